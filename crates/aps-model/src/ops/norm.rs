//! Batch normalisation, with the ReLU behind it in the same pass.

use candle_core::{Result, Tensor, Var};

use super::cpu::{apply, are_fast, with_slices};
use super::portable::{self, BatchNormTensors, EPSILON, MOMENTUM};
use crate::kernels::batch_norm::{gradient, gradient_sums, moments, scale_shift};
use crate::recording::{Graph, Value, float, recorded};

/// [`portable::batch_norm`], then ReLU if it is asked for: with f32 on the CPU in two passes forward and two backward.
pub(crate) fn batch_norm(
    x: &Tensor,
    t: BatchNormTensors<'_>,
    train: bool,
    relu: bool,
) -> Result<Tensor> {
    let (mean, variance) = (t.running_mean.as_tensor(), t.running_var.as_tensor());
    let inputs = [x, t.weight, t.bias, mean, variance];
    let nodes = |g: &mut Graph, v: &[Value]| {
        let y = g.node("BatchNormalization", v, [float("epsilon", EPSILON)]);
        if relu { g.node("Relu", &[y], []) } else { y }
    };
    recorded(&inputs, nodes, || {
        let fits = |channels: usize| [t.weight, t.bias].iter().all(|t| t.dims() == [channels]);
        if are_fast(&inputs) && x.rank() > 1 && x.elem_count() > 0 && fits(x.dim(1)?) {
            return fast(x, t, train, relu);
        }
        let y = portable::batch_norm(x, t, train)?;
        if relu { portable::relu(&y) } else { Ok(y) }
    })
}

fn fast(x: &Tensor, t: BatchNormTensors<'_>, train: bool, relu: bool) -> Result<Tensor> {
    let (x, channels) = (x.contiguous()?, x.dim(1)?);
    let pixels = x.elem_count() / (x.dim(0)? * channels);
    let (mean, variance) = if train {
        let count = portable::values_a_channel(&x)?;
        let (mean, variance) = with_slices([&x], |[x]| moments(x, channels, pixels))?;
        let unbiased = count as f64 / (count - 1) as f64;
        move_towards(t.running_mean, &mean, 1.0)?;
        move_towards(t.running_var, &variance, unbiased)?;
        (mean, variance)
    } else {
        (t.running_mean.to_vec1()?, t.running_var.to_vec1()?)
    };
    let inverse_std = inverse_std(&variance);
    let moments = (mean.clone(), inverse_std.clone());
    let forward = move |[x, weight, bias]: [&[f32]; 3]| {
        let scale = weight.iter().zip(&inverse_std).map(|(w, i)| w * i);
        let scale: Vec<f32> = scale.collect();
        scale_shift(x, &mean, &scale, bias, pixels, relu)
    };
    apply(
        "batch_norm",
        [&x, t.weight, t.bias],
        x.dims(),
        forward,
        move |b| {
            let (mean, inverse_std) = &moments;
            let ([x, w, _], y) = (b.inputs, relu.then_some(b.output));
            let (sum, product) = gradient_sums(x, y, b.grad, (mean, inverse_std), pixels);
            let count = (x.len() / w.len()) as f32;
            let factors = |c: usize| {
                let factor = w[c] * inverse_std[c];
                if !train {
                    return [factor, 0.0, 0.0, 0.0];
                }
                // a (g - mean(g) - x^ mean(g x^)), with x^ = (x - mean) inverse_std.
                let slope = -factor * product[c] / count * inverse_std[c];
                [factor, slope, -factor * sum[c] / count, mean[c]]
            };
            let factors: Vec<[f32; 4]> = (0..w.len()).map(factors).collect();
            let by_input = gradient(x, y, b.grad, &factors, pixels);
            [Some(by_input), Some(product), Some(sum)]
        },
    )
}

pub(super) fn inverse_std(variance: &[f32]) -> Vec<f32> {
    let of = |&v| (1.0 / (f64::from(v) + EPSILON).sqrt()) as f32;
    variance.iter().map(of).collect()
}

fn move_towards(running: &Var, batch: &[f32], factor: f64) -> Result<()> {
    let mut values: Vec<f32> = running.to_vec1()?;
    for (v, &b) in values.iter_mut().zip(batch) {
        *v = ((1.0 - MOMENTUM) * f64::from(*v) + MOMENTUM * factor * f64::from(b)) as f32;
    }
    let moved = Tensor::from_vec(values, running.shape(), running.device())?;
    running.set(&moved)
}
