//! AdamW in one pass over memory, with clipped gradients and a state that can be saved.
//!
//! Numbers follow PyTorch's `torch.optim.AdamW` and `torch.nn.utils.clip_grad_norm_` operation by operation in f32, so that
//! trajectories agree to rounding. Results do not depend on the number of threads: elements are updated alone, and sums run
//! over blocks of fixed size in a fixed order.

use std::sync::{Mutex, PoisonError};

use candle_core::backprop::GradStore;
use candle_core::{CpuStorage, DType, Device, InplaceOp2, Layout, Result, Tensor, Var, bail};
use candle_nn::{Optimizer, ParamsAdamW};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ops::with_slices;

/// Settings of [`AdamW`] without the learning rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AdamConfig {
    /// Share of the first moment that is kept each step.
    pub beta1: f64,
    /// Share of the second moment that is kept each step.
    pub beta2: f64,
    /// Added to the root of the second moment before dividing by it.
    pub epsilon: f64,
    /// Decay of weights a step and unit of learning rate, decoupled from the gradient; 0 is plain Adam.
    pub weight_decay: f64,
}

impl Default for AdamConfig {
    /// PyTorch's AdamW: 0.9, 0.999, 1e-8, 0.01.
    fn default() -> Self {
        Self {
            beta1: 0.9,
            beta2: 0.999,
            epsilon: 1e-8,
            weight_decay: 0.01,
        }
    }
}

impl AdamConfig {
    /// Returns the settings of adversarial training: beta1 = 0.5, no decay.
    pub fn adversarial() -> Self {
        Self {
            beta1: 0.5,
            weight_decay: 0.0,
            ..Self::default()
        }
    }

    /// Returns candle's settings at a learning rate.
    pub(crate) fn with_rate(self, lr: f64) -> ParamsAdamW {
        ParamsAdamW {
            lr,
            beta1: self.beta1,
            beta2: self.beta2,
            eps: self.epsilon,
            weight_decay: self.weight_decay,
        }
    }
}

/// Adam with decoupled weight decay: Kingma and Ba, "Adam: A Method for Stochastic Optimization", ICLR 2015, algorithm 1;
/// Loshchilov and Hutter, "Decoupled Weight Decay Regularization", ICLR 2019, algorithm 2 as PyTorch has it, where the
/// decay is multiplied by the learning rate.
///
/// On a CPU one pass over memory does everything, on all threads; elsewhere candle's operations are composed. Both moments
/// are f32 whatever the weights are.
#[derive(Debug)]
pub struct AdamW {
    params: ParamsAdamW,
    steps: u64,
    slots: Vec<(Var, Moments)>,
}

impl Optimizer for AdamW {
    type Config = ParamsAdamW;

    fn new(vars: Vec<Var>, params: ParamsAdamW) -> Result<Self> {
        let floats = vars.into_iter().filter(|var| var.dtype().is_float());
        let slots = floats.map(|var| Ok((var.clone(), Moments::zeros(&var)?)));
        Ok(Self {
            params,
            steps: 0,
            slots: slots.collect::<Result<_>>()?,
        })
    }

    /// Updates the variables by their gradients. A variable without gradient stays, with its moments.
    fn step(&mut self, gradients: &GradStore) -> Result<()> {
        self.step_scaled(gradients, 1.0)
    }

    fn learning_rate(&self) -> f64 {
        self.params.lr
    }

    fn set_learning_rate(&mut self, lr: f64) {
        self.params.lr = lr;
    }
}

impl AdamW {
    /// Computes the gradients of `loss`, shortens them to a norm of at most `max_norm` and updates the variables by them.
    /// Returns the norm before; if it is not finite nothing is updated.
    pub fn backward_step_clipped(&mut self, loss: &Tensor, max_norm: f64) -> Result<f64> {
        let gradients = loss.backward()?;
        let norm = gradient_norm(&gradients, self.slots.iter().map(|(var, _)| var))?;
        if norm.is_finite() {
            self.step_scaled(&gradients, clip_factor(norm, max_norm))?;
        }
        Ok(norm)
    }

    /// [`step`](Optimizer::step) with gradients multiplied by `scale` first.
    pub(crate) fn step_scaled(&mut self, gradients: &GradStore, scale: f64) -> Result<()> {
        self.steps += 1;
        let p = &self.params;
        let correction = |beta: f64| 1.0 - beta.powf(self.steps as f64);
        let coefficients = Coefficients {
            gradient_scale: scale,
            keep: 1.0 - p.lr * p.weight_decay,
            beta1: p.beta1,
            beta2: p.beta2,
            step_size: p.lr / correction(p.beta1),
            root_correction: correction(p.beta2).sqrt(),
            epsilon: p.eps,
        };
        for (var, moments) in &mut self.slots {
            if let Some(gradient) = gradients.get(var) {
                moments.update(var, gradient, coefficients)?;
            }
        }
        Ok(())
    }

    /// Returns both moments of every variable, in the order of the variables. With the number of steps they are the whole
    /// state.
    pub(crate) fn moments(&self) -> Result<Vec<[Tensor; 2]>> {
        let moments = self.slots.iter().map(|(var, moments)| moments.tensors(var));
        moments.collect()
    }

    /// Goes back to a state: the number of steps, and moments of the shapes of the variables, in their order.
    pub(crate) fn restore(&mut self, steps: u64, moments: &[[Tensor; 2]]) -> Result<()> {
        let (found, needed) = (moments.len(), self.slots.len());
        if found != needed {
            bail!("{found} moments for {needed} variables");
        }
        let pairs = self.slots.iter().zip(moments);
        let restored = pairs.map(|((var, _), [first, second])| Moments::of(var, first, second));
        let restored: Vec<Moments> = restored.collect::<Result<_>>()?;
        for ((_, moments), restored) in self.slots.iter_mut().zip(restored) {
            *moments = restored;
        }
        self.steps = steps;
        Ok(())
    }
}

/// First and second moment of a variable's gradient.
#[derive(Debug)]
enum Moments {
    /// Moments of f32 weights on a CPU.
    Host(Vec<f32>, Vec<f32>),
    Device(Tensor, Tensor),
}

impl Moments {
    fn zeros(var: &Var) -> Result<Self> {
        let zeros = Tensor::zeros(var.shape(), DType::F32, var.device())?;
        Self::of(var, &zeros, &zeros.copy()?)
    }

    fn of(var: &Var, first: &Tensor, second: &Tensor) -> Result<Self> {
        if var.device().is_cpu() && var.dtype() == DType::F32 {
            let values = |t: &Tensor| t.to_dtype(DType::F32)?.flatten_all()?.to_vec1();
            return Ok(Self::Host(values(first)?, values(second)?));
        }
        let there = |t: &Tensor| t.to_dtype(DType::F32)?.to_device(var.device());
        Ok(Self::Device(there(first)?, there(second)?))
    }

    fn tensors(&self, var: &Var) -> Result<[Tensor; 2]> {
        let host = |values| Tensor::from_slice(values, var.shape(), &Device::Cpu);
        Ok(match self {
            Self::Host(first, second) => [host(first)?, host(second)?],
            Self::Device(first, second) => [first.clone(), second.clone()],
        })
    }

    fn update(&mut self, var: &Var, gradient: &Tensor, c: Coefficients) -> Result<()> {
        match self {
            Self::Host(first, second) => {
                let update = Update {
                    coefficients: c,
                    moments: Mutex::new((first, second)),
                };
                var.inplace_op2(&gradient.contiguous()?, &update)
            }
            Self::Device(first, second) => {
                let g = (gradient.detach().to_dtype(DType::F32)? * c.gradient_scale)?;
                *first = (&*first + ((&g - &*first)? * (1.0 - c.beta1))?)?;
                *second = ((&*second * c.beta2)? + (g.sqr()? * (1.0 - c.beta2))?)?;
                let denominator = ((second.sqrt()? / c.root_correction)? + c.epsilon)?;
                let decayed = (var.as_detached_tensor().to_dtype(DType::F32)? * c.keep)?;
                let moved = (decayed - ((&*first / denominator)? * c.step_size)?)?;
                var.set(&moved.to_dtype(var.dtype())?)
            }
        }
    }
}

/// The numbers of one step, alike for all values.
#[derive(Debug, Clone, Copy)]
struct Coefficients {
    /// Gradients are multiplied by this first.
    gradient_scale: f64,
    /// Weights are multiplied by this: 1 - rate * decay.
    keep: f64,
    beta1: f64,
    beta2: f64,
    /// rate / (1 - beta1^t).
    step_size: f64,
    /// sqrt(1 - beta2^t).
    root_correction: f64,
    epsilon: f64,
}

/// Updates weights (the destination) and moments from a gradient (the source).
struct Update<'a> {
    coefficients: Coefficients,
    /// First and second moments of the values; an operation is shared, hence the lock.
    moments: Mutex<(&'a mut [f32], &'a mut [f32])>,
}

/// Values a thread works on at a time; fixed, so that the order of summation does not depend on the threads.
const BLOCK: usize = 1 << 14;

impl InplaceOp2 for Update<'_> {
    fn name(&self) -> &'static str {
        "adamw"
    }

    fn cpu_fwd(
        &self,
        weights: &mut CpuStorage,
        weights_layout: &Layout,
        gradient: &CpuStorage,
        gradient_layout: &Layout,
    ) -> Result<()> {
        let ranges = (
            weights_layout.contiguous_offsets(),
            gradient_layout.contiguous_offsets(),
        );
        let (CpuStorage::F32(weights), CpuStorage::F32(gradient), (Some((w0, w1)), Some((g0, g1)))) =
            (weights, gradient, ranges)
        else {
            bail!("the update in one pass takes contiguous f32 tensors");
        };
        let mut moments = self.moments.lock().unwrap_or_else(PoisonError::into_inner);
        let (first, second) = &mut *moments;
        weights[w0..w1]
            .par_chunks_mut(BLOCK)
            .zip(gradient[g0..g1].par_chunks(BLOCK))
            .zip(first.par_chunks_mut(BLOCK))
            .zip(second.par_chunks_mut(BLOCK))
            .for_each(|(((w, g), m), v)| update(&self.coefficients, w, g, m, v));
        Ok(())
    }
}

/// The operations of `torch.optim.AdamW` on single tensors, in its order and precision.
fn update(c: &Coefficients, w: &mut [f32], g: &[f32], m: &mut [f32], v: &mut [f32]) {
    let (scale, keep, beta2) = (c.gradient_scale as f32, c.keep as f32, c.beta2 as f32);
    let (first_share, second_share) = ((1.0 - c.beta1) as f32, (1.0 - c.beta2) as f32);
    let (step_size, epsilon) = (c.step_size as f32, c.epsilon as f32);
    let root_correction = c.root_correction as f32;
    for (((w, g), m), v) in w.iter_mut().zip(g).zip(m).zip(v) {
        let g = g * scale;
        *m += first_share * (g - *m);
        *v = *v * beta2 + second_share * (g * g);
        let denominator = v.sqrt() / root_correction + epsilon;
        *w = *w * keep - step_size * (*m / denominator);
    }
}

/// Returns the factor that brings gradients of this norm to a norm of at most `max_norm`: 1 if it is. As in PyTorch, 1e-6 is
/// added to the norm before dividing by it.
pub(crate) fn clip_factor(norm: f64, max_norm: f64) -> f64 {
    (max_norm / (norm + 1e-6)).min(1.0)
}

/// Computes the Euclidean norm of the gradients of `vars` taken as one vector; variables without one count as zero.
///
/// On a CPU squares are summed in f64; on another device in f32, and one number is read back. Not a number, or infinite, if a gradient
/// is.
pub(crate) fn gradient_norm<'a>(
    gradients: &GradStore,
    vars: impl IntoIterator<Item = &'a Var>,
) -> Result<f64> {
    let (mut squares, mut on_device) = (0.0, Vec::new());
    for gradient in vars.into_iter().filter_map(|var| gradients.get(var)) {
        if gradient.device().is_cpu() && gradient.dtype() == DType::F32 {
            squares += with_slices([&gradient.contiguous()?], |[g]| sum_of_squares(g))?;
        } else {
            on_device.push(gradient.to_dtype(DType::F32)?.sqr()?.sum_all()?);
        }
    }
    if !on_device.is_empty() {
        let sum = Tensor::stack(&on_device, 0)?.sum_all()?;
        squares += f64::from(sum.to_scalar::<f32>()?);
    }
    Ok(squares.sqrt())
}

/// Sums squares in f64, block by block.
fn sum_of_squares(values: &[f32]) -> f64 {
    let square = |&x: &f32| f64::from(x) * f64::from(x);
    let blocks = values.par_chunks(BLOCK);
    let blocks: Vec<f64> = blocks.map(|block| block.iter().map(square).sum()).collect();
    blocks.iter().sum()
}
