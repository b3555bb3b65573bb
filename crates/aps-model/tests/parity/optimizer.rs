//! A plain Adam for the tests, written from PyTorch's documentation: they judge the models' gradients, and must not share a
//! mistake with the crate's own optimizer.

use std::collections::HashMap;

use aps_model::Parameters;
use aps_model::candle_core::Tensor;
use aps_model::candle_core::backprop::GradStore;

use crate::golden::flat;

pub struct Adam {
    pub lr: f64,
    pub betas: (f64, f64),
    /// Decoupled, as in AdamW.
    pub weight_decay: f64,
    step: i32,
    moments: HashMap<String, (Tensor, Tensor)>,
}

/// Gradients by name, in the order of the names.
pub fn gradients(parameters: &Parameters, store: &GradStore) -> Vec<(String, Tensor)> {
    parameters
        .trainable()
        .into_iter()
        .map(|(name, var)| {
            let gradient = match store.get(var.as_tensor()) {
                Some(gradient) => gradient.clone(),
                None => panic!("no gradient of {name}"),
            };
            (name, gradient)
        })
        .collect()
}

fn norm(tensor: &Tensor) -> f64 {
    flat(tensor).iter().map(|v| v * v).sum::<f64>().sqrt()
}

impl Adam {
    pub fn new(lr: f64, betas: (f64, f64), weight_decay: f64) -> Self {
        Self {
            lr,
            betas,
            weight_decay,
            step: 0,
            moments: HashMap::new(),
        }
    }

    /// Clips the gradients to norm 1 and moves the weights.
    pub fn step(&mut self, parameters: &Parameters, gradients: &[(String, Tensor)]) {
        self.step += 1;
        let norm = gradients
            .iter()
            .map(|(_, g)| norm(g).powi(2))
            .sum::<f64>()
            .sqrt();
        let clip = (1.0 / (norm + 1e-6)).min(1.0);
        for (name, gradient) in gradients {
            self.move_one(parameters, name, &(gradient * clip).unwrap())
                .unwrap();
        }
    }

    fn move_one(
        &mut self,
        parameters: &Parameters,
        name: &str,
        g: &Tensor,
    ) -> aps_model::Result<()> {
        let (beta1, beta2) = self.betas;
        let var = parameters.get(name).unwrap().var;
        let (m, v) = match self.moments.remove(name) {
            Some(moments) => moments,
            None => (g.zeros_like()?, g.zeros_like()?),
        };
        let m = ((m * beta1)? + (g * (1.0 - beta1))?)?;
        let v = ((v * beta2)? + (g.sqr()? * (1.0 - beta2))?)?;
        let root = (&v / (1.0 - beta2.powi(self.step)))?.sqrt()?;
        let change = (&m / (1.0 - beta1.powi(self.step)))?.div(&(root + 1e-8)?)?;
        let kept = (var.as_detached_tensor() * (1.0 - self.lr * self.weight_decay))?;
        var.set(&(kept - (change * self.lr)?)?)?;
        self.moments.insert(name.to_owned(), (m, v));
        Ok(())
    }
}
