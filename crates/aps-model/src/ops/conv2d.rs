//! Convolution and transposed convolution.

use candle_core::{DType, Result, Tensor};

use super::cpu::{Backward, apply, are_fast, is_on_cpu};
use super::portable;
use crate::kernels::epilogue::Epilogue;
use crate::kernels::{ConvShape, convolution::convolve, input_gradient, weight_gradient};
use crate::recording::{Graph, Value, ints, recorded};

/// [`portable::conv2d`], with f32 on the CPU several times as fast: unfolded tiles that stay in cache, one matrix product a
/// tile, threads over the images (or over channels where images are small or few).
///
/// Half-precision values on the CPU are widened to f32 and the result, bias included, rounded back once.
pub(crate) fn conv2d(
    x: &Tensor,
    weight: &Tensor,
    bias: Option<&Tensor>,
    stride: usize,
    padding: (usize, usize),
) -> Result<Tensor> {
    let inputs: Vec<_> = [x, weight].into_iter().chain(bias).collect();
    let nodes = |g: &mut Graph, v: &[Value]| {
        let (stride, (h, w)) = (stride as i64, (padding.0 as i64, padding.1 as i64));
        let settings = [ints("strides", [stride; 2]), ints("pads", [h, w, h, w])];
        g.node("Conv", v, settings)
    };
    recorded(&inputs, nodes, || {
        if is_on_cpu(x) && matches!(x.dtype(), DType::BF16 | DType::F16) {
            // Weights have the precision of x, whatever they are stored in.
            let wide = |t: &Tensor| t.to_dtype(x.dtype())?.to_dtype(DType::F32);
            let bias = bias.map(wide).transpose()?;
            let y = conv2d(&wide(x)?, &wide(weight)?, bias.as_ref(), stride, padding)?;
            return y.to_dtype(x.dtype());
        }
        let is_known = bias.is_none_or(|bias| are_fast(&[bias]));
        let shape = conv_shape(x, weight, stride, padding).filter(|_| is_known);
        let Some(s) = shape else {
            return portable::conv2d(x, weight, bias, stride, padding);
        };
        let dims = s.out_dims();
        match bias {
            None => apply(
                "conv2d",
                [x, weight],
                &dims,
                move |[x, weight]| convolved(&s, x, weight, None),
                move |b| gradients(&s, b.inputs, &b),
            ),
            Some(bias) => apply(
                "conv2d with bias",
                [x, weight, bias],
                &dims,
                move |[x, weight, bias]| convolved(&s, x, weight, Some(bias)),
                move |b| {
                    let [x, weight, _] = b.inputs;
                    let [by_input, by_weight] = gradients(&s, [x, weight], &b);
                    let by_bias = sum_channels(b.grad, s.out_channels, s.out_pixels());
                    [by_input, by_weight, Some(by_bias)]
                },
            ),
        }
    })
}

/// Computes the cross-correlation of `x` (batch, in, length) with `weight` (out, in, kernel), zeros around, and adds `bias` (out).
pub(crate) fn conv1d(x: &Tensor, weight: &Tensor, bias: &Tensor, padding: usize) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let pads = ints("pads", [padding as i64; 2]);
        g.node("Conv", v, [pads])
    };
    recorded(&[x, weight, bias], nodes, || {
        // A line is an image of height 1.
        let (x, weight) = (x.unsqueeze(2)?, weight.unsqueeze(2)?);
        conv2d(&x, &weight, Some(bias), 1, (0, padding))?.squeeze(2)
    })
}

/// [`portable::conv_transpose2x2`]: the input gradient of a convolution, and computed as that.
pub(crate) fn conv_transpose2x2(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| g.node("ConvTranspose", v, [ints("strides", [2, 2])]);
    recorded(&[x, weight, bias], nodes, || {
        let Some(s) = transposed_shape(x, weight) else {
            return portable::conv_transpose2x2(x, weight, bias);
        };
        let y = apply(
            "transposed conv2d",
            [x, weight],
            &[s.batch, s.in_channels, s.height, s.width],
            move |[x, weight]| input_gradient(&s, x, weight),
            move |b| {
                let [x, weight] = b.inputs;
                let by_input = convolved(&s, b.grad, weight, None);
                [Some(by_input), Some(weight_gradient(&s, b.grad, x))]
            },
        )?;
        y.broadcast_add(&bias.reshape((1, (), 1, 1))?)
    })
}

/// Returns the sizes, if the fast path knows the tensors and they fit together.
pub(super) fn conv_shape(
    x: &Tensor,
    w: &Tensor,
    stride: usize,
    padding: (usize, usize),
) -> Option<ConvShape> {
    let (batch, in_channels, height, width) = x.dims4().ok()?;
    let (out_channels, channels, kh, kw) = w.dims4().ok()?;
    let shape = ConvShape {
        batch,
        in_channels,
        height,
        width,
        out_channels,
        kernel: (kh, kw),
        stride,
        padding,
    };
    (are_fast(&[x, w]) && channels == in_channels && shape.is_valid()).then_some(shape)
}

/// Returns the convolution whose input gradient the transposed one is.
fn transposed_shape(x: &Tensor, w: &Tensor) -> Option<ConvShape> {
    let (batch, channels, height, width) = x.dims4().ok()?;
    let (inputs, outputs, kh, kw) = w.dims4().ok()?;
    let fits = channels == inputs && outputs > 0 && (kh, kw) == (2, 2) && x.elem_count() > 0;
    (are_fast(&[x, w]) && fits).then_some(ConvShape {
        batch,
        in_channels: outputs,
        height: 2 * height,
        width: 2 * width,
        out_channels: inputs,
        kernel: (2, 2),
        stride: 2,
        padding: (0, 0),
    })
}

fn convolved(s: &ConvShape, x: &[f32], weight: &[f32], bias: Option<&[f32]>) -> Vec<f32> {
    convolve(s, x, weight, None, Epilogue::bias(bias))
}

/// Computes the gradients by input and weight, the former only where something asks for it.
fn gradients<const N: usize>(
    s: &ConvShape,
    [x, weight]: [&[f32]; 2],
    backward: &Backward<'_, N>,
) -> [Option<Vec<f32>>; 2] {
    let by_input = backward.wanted[0].then(|| input_gradient(s, backward.grad, weight));
    [by_input, Some(weight_gradient(s, x, backward.grad))]
}

/// Sums each channel over images and pixels, in f64.
fn sum_channels(values: &[f32], channels: usize, pixels: usize) -> Vec<f32> {
    use rayon::prelude::*;
    let sum_of = |c: usize| {
        let images = values.chunks_exact(channels * pixels);
        let planes = images.flat_map(|image| &image[c * pixels..][..pixels]);
        planes.map(|&v| f64::from(v)).sum::<f64>() as f32
    };
    (0..channels).into_par_iter().map(sum_of).collect()
}
