//! Batch normalisation.

use candle_core::{DType, ModuleT, Result, Tensor, Var};
use candle_nn::{Init, VarBuilder};

use crate::ops;

/// PyTorch's `BatchNorm1d` and `BatchNorm2d`: `weight`, `bias`, `running_mean`, `running_var` (channels) and the counter
/// `num_batches_tracked`. It takes inputs (batch, channels, ...).
#[derive(Debug, Clone)]
pub(crate) struct BatchNorm {
    weight: Tensor,
    bias: Tensor,
    running_mean: Var,
    running_var: Var,
    passes: Var,
}

impl BatchNorm {
    /// Creates a layer that is the identity at first: weight and variance 1, bias and mean 0.
    pub fn new(channels: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let get = |name, value| vb.get_with_hints(channels, name, Init::Const(value));
        // Files of old PyTorch and of candle have no counter.
        let (counter, zero) = ("num_batches_tracked", Init::Const(0.0));
        let passes = match vb.get_with_hints_dtype((), counter, zero, DType::I64) {
            Ok(passes) => Var::from_tensor(&passes)?,
            Err(_) if !vb.contains_tensor(counter) => Var::zeros((), DType::I64, vb.device())?,
            Err(error) => return Err(error),
        };
        Ok(Self {
            weight: get("weight", 1.0)?,
            bias: get("bias", 0.0)?,
            running_mean: Var::from_tensor(&get("running_mean", 0.0)?)?,
            running_var: Var::from_tensor(&get("running_var", 1.0)?)?,
            passes,
        })
    }

    /// Counts a training pass.
    pub fn count(&self, train: bool) -> Result<()> {
        match train {
            true => self.passes.set(&(self.passes.as_detached_tensor() + 1.0)?),
            false => Ok(()),
        }
    }

    pub fn tensors(&self) -> ops::BatchNormTensors<'_> {
        ops::BatchNormTensors {
            weight: &self.weight,
            bias: &self.bias,
            running_mean: &self.running_mean,
            running_var: &self.running_var,
        }
    }
}

impl ModuleT for BatchNorm {
    fn forward_t(&self, x: &Tensor, train: bool) -> Result<Tensor> {
        self.count(train)?;
        ops::batch_norm(x, self.tensors(), train, false)
    }
}
