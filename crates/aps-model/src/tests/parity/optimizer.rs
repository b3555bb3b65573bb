//! A plain Adam for the tests, written from PyTorch's documentation: they judge the models' gradients, and must not share a
//! mistake with the crate's own optimizer.

use std::collections::HashMap;

use candle_core::backprop::GradStore;
use candle_core::{Tensor, Var};
use candle_nn::VarMap;
use rayon::prelude::*;

use super::super::flat;
use crate::trainable;

pub struct Adam {
    pub lr: f64,
    pub betas: [f64; 2],
    /// Decoupled, as in AdamW.
    pub weight_decay: f64,
    step: i32,
    /// Means of gradients and of their squares, by tensor.
    moments: HashMap<String, Vec<(f64, f64)>>,
}

/// Gradients by name, in the order of the names.
pub fn gradients(parameters: &VarMap, store: &GradStore) -> Vec<(String, Tensor)> {
    let gradient = |(name, var): (String, Var)| match store.get(&var) {
        Some(gradient) => (name, gradient.clone()),
        None => panic!("no gradient of {name}"),
    };
    trainable(parameters).into_iter().map(gradient).collect()
}

impl Adam {
    pub fn new(lr: f64, betas: [f64; 2], weight_decay: f64) -> Self {
        Self {
            lr,
            betas,
            weight_decay,
            step: 0,
            moments: HashMap::new(),
        }
    }

    /// Clips the gradients to norm 1 and moves the weights.
    pub fn step(&mut self, parameters: &VarMap, gradients: &[(String, Tensor)]) {
        self.step += 1;
        let squares = |(_, g): &(String, Tensor)| flat(g).iter().map(|v| v * v).sum::<f64>();
        let norm = gradients.iter().map(squares).sum::<f64>().sqrt();
        let clip = (1.0 / (norm + 1e-6)).min(1.0);
        for ((name, var), (_, gradient)) in trainable(parameters).iter().zip(gradients) {
            self.move_one(var, name, gradient, clip);
        }
    }

    /// On plain numbers: whole tensors a term would take most of the tests' time.
    fn move_one(&mut self, var: &Var, name: &str, gradient: &Tensor, clip: f64) {
        let [beta1, beta2] = self.betas;
        let [done1, done2] = self.betas.map(|beta| 1.0 - beta.powi(self.step));
        let kept = 1.0 - self.lr * self.weight_decay;
        let mut weights = flat(var.as_tensor());
        let moments = self.moments.entry(name.to_owned());
        let moments = moments.or_insert_with(|| vec![(0.0, 0.0); weights.len()]);
        let gradients = flat(gradient);
        let work = weights.par_iter_mut().zip(moments).zip(gradients);
        work.for_each(|((weight, (m, v)), g)| {
            let g = clip * g;
            *m = beta1 * *m + (1.0 - beta1) * g;
            *v = beta2 * *v + (1.0 - beta2) * g * g;
            let change = (*m / done1) / ((*v / done2).sqrt() + 1e-8);
            *weight = kept * *weight - self.lr * change;
        });
        let moved = Tensor::from_vec(weights, var.shape(), var.device()).unwrap();
        var.set(&moved.to_dtype(var.dtype()).unwrap()).unwrap();
    }
}
