//! Adam, and AdamW.

use std::collections::HashMap;
use std::sync::Mutex;

use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Tensor, Var};
use serde::{Deserialize, Serialize};

use super::fused::{Coefficients, Fused};
use crate::{Parameters, Result};

/// Settings of [`Adam`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AdamConfig {
    /// Share of the first moment that is kept each step.
    pub beta1: f64,
    /// Share of the second moment that is kept each step.
    pub beta2: f64,
    /// Added to the root of the second moment before dividing by it.
    pub epsilon: f64,
    /// Decay of weights a step and unit of learning rate, decoupled from the gradient; 0 is plain Adam, anything else
    /// AdamW.
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
}

/// Adam with decoupled weight decay: Kingma and Ba, "Adam: A Method for Stochastic Optimization", ICLR 2015, algorithm 1;
/// Loshchilov and Hutter, "Decoupled Weight Decay Regularization", ICLR 2019, algorithm 2 as PyTorch has it, where the
/// decay is multiplied by the learning rate.
///
/// On a CPU one pass over memory does everything, on all threads; elsewhere candle's operations are composed. Both moments
/// are f32 whatever the weights are.
#[derive(Debug)]
pub struct Adam {
    config: AdamConfig,
    steps: u64,
    slots: Vec<Slot>,
}

#[derive(Debug)]
struct Slot {
    name: String,
    var: Var,
    moments: Moments,
}

#[derive(Debug)]
enum Moments {
    /// Moments of f32 weights on a CPU.
    Host(Vec<f32>, Vec<f32>),
    Device(Tensor, Tensor),
}

impl Adam {
    /// Creates an optimizer of the trainable parameters, before its first step.
    pub fn new(parameters: &Parameters, config: AdamConfig) -> Result<Self> {
        let slot = |(name, var): (String, Var)| {
            let moments = Moments::zeros(&var)?;
            Ok(Slot { name, var, moments })
        };
        let slots = parameters.trainable().into_iter().map(slot);
        Ok(Self {
            config,
            steps: 0,
            slots: slots.collect::<Result<_>>()?,
        })
    }

    /// Returns the variables that the optimizer updates, in the order of their names.
    pub fn variables(&self) -> impl Iterator<Item = &Var> {
        self.slots.iter().map(|slot| &slot.var)
    }

    /// Returns the number of steps made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Moves the variables by their gradients, multiplied by `gradient_scale` (of
    /// [clipping](super::clip_factor), else 1) first. A variable without gradient stays, with its moments.
    pub fn step(
        &mut self,
        gradients: &GradStore,
        learning_rate: f64,
        gradient_scale: f64,
    ) -> Result<()> {
        self.steps += 1;
        let AdamConfig {
            beta1,
            beta2,
            epsilon,
            weight_decay,
        } = self.config;
        let correction = |beta: f64| 1.0 - beta.powf(self.steps as f64);
        let coefficients = Coefficients {
            gradient_scale,
            keep: 1.0 - learning_rate * weight_decay,
            beta1,
            beta2,
            step_size: learning_rate / correction(beta1),
            root_correction: correction(beta2).sqrt(),
            epsilon,
        };
        for slot in &mut self.slots {
            if let Some(gradient) = gradients.get(&slot.var) {
                slot.moments.update(&slot.var, gradient, coefficients)?;
            }
        }
        Ok(())
    }

    /// Returns both moments of every variable, as `NAME.first` and `NAME.second`; with [`steps`](Self::steps) they are the
    /// optimizer's whole state.
    pub fn state(&self) -> Result<Vec<(String, Tensor)>> {
        let mut state = Vec::with_capacity(2 * self.slots.len());
        for slot in &self.slots {
            let [first, second] = slot.moments.tensors(&slot.var)?;
            state.push((format!("{}.first", slot.name), first));
            state.push((format!("{}.second", slot.name), second));
        }
        Ok(state)
    }

    /// Goes back to a [`state`](Self::state). All of it must be there, in the right shapes; nothing changes otherwise.
    pub fn restore(&mut self, steps: u64, state: &HashMap<String, Tensor>) -> Result<()> {
        let find = |name: String, var: &Var| match state.get(&name) {
            Some(tensor) if tensor.shape() == var.shape() => Ok(tensor),
            Some(tensor) => candle_core::bail!(
                "optimizer state '{name}' has shape {:?}, its variable {:?}",
                tensor.shape(),
                var.shape()
            ),
            None => candle_core::bail!("optimizer state '{name}' is missing"),
        };
        let restored = |slot: &Slot| {
            let first = find(format!("{}.first", slot.name), &slot.var)?;
            let second = find(format!("{}.second", slot.name), &slot.var)?;
            Moments::of(&slot.var, first, second)
        };
        let moments: Vec<Moments> = self.slots.iter().map(restored).collect::<Result<_>>()?;
        for (slot, moments) in self.slots.iter_mut().zip(moments) {
            slot.moments = moments;
        }
        self.steps = steps;
        Ok(())
    }
}

impl Moments {
    fn zeros(var: &Var) -> Result<Self> {
        if is_on_host(var) {
            let n = var.elem_count();
            return Ok(Self::Host(vec![0.0; n], vec![0.0; n]));
        }
        let zeros = Tensor::zeros(var.shape(), DType::F32, var.device())?;
        Ok(Self::Device(zeros.copy()?, zeros))
    }

    fn of(var: &Var, first: &Tensor, second: &Tensor) -> Result<Self> {
        if is_on_host(var) {
            let values = |t: &Tensor| t.to_dtype(DType::F32)?.flatten_all()?.to_vec1();
            return Ok(Self::Host(values(first)?, values(second)?));
        }
        let there = |t: &Tensor| t.to_dtype(DType::F32)?.to_device(var.device());
        Ok(Self::Device(there(first)?, there(second)?))
    }

    fn tensors(&self, var: &Var) -> Result<[Tensor; 2]> {
        Ok(match self {
            Self::Host(first, second) => [
                Tensor::from_slice(first, var.shape(), &Device::Cpu)?,
                Tensor::from_slice(second, var.shape(), &Device::Cpu)?,
            ],
            Self::Device(first, second) => [first.clone(), second.clone()],
        })
    }

    fn update(&mut self, var: &Var, gradient: &Tensor, c: Coefficients) -> Result<()> {
        match self {
            Self::Host(first, second) => {
                let fused = Fused {
                    coefficients: c,
                    moments: Mutex::new((first, second)),
                };
                var.inplace_op2(&gradient.contiguous()?, &fused)?;
            }
            Self::Device(first, second) => {
                let g = (gradient.detach().to_dtype(DType::F32)? * c.gradient_scale)?;
                *first = (&*first + ((&g - &*first)? * (1.0 - c.beta1))?)?;
                *second = ((&*second * c.beta2)? + (g.sqr()? * (1.0 - c.beta2))?)?;
                let denominator = ((second.sqrt()? / c.root_correction)? + c.epsilon)?;
                let kept = (var.as_detached_tensor().to_dtype(DType::F32)? * c.keep)?;
                let moved = (kept - ((&*first / denominator)? * c.step_size)?)?;
                var.set(&moved.to_dtype(var.dtype())?)?;
            }
        }
        Ok(())
    }
}

fn is_on_host(var: &Var) -> bool {
    var.device().is_cpu() && var.dtype() == DType::F32
}
