//! Normalisation over the batch and over features.

use candle_core::{D, DType, Result, Tensor, Var, bail};

/// Added to variances before the root in batch normalisation (PyTorch's default).
pub(crate) const EPSILON: f64 = 1e-5;
/// Added to variances in layer normalisation (torchvision's for vision transformers).
pub(crate) const LAYER_EPSILON: f64 = 1e-6;
/// Weight of the newest batch in the running statistics (PyTorch's default).
pub(crate) const MOMENTUM: f64 = 0.1;

/// The tensors of a batch normalisation, each (channels).
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchNormTensors<'a> {
    /// Scale.
    pub weight: &'a Tensor,
    /// Shift.
    pub bias: &'a Tensor,
    /// Running mean.
    pub running_mean: &'a Var,
    /// Running variance, over n - 1.
    pub running_var: &'a Var,
}

/// Batch normalisation of (batch, channels, ...) over all dimensions but the second (Ioffe and Szegedy, ICML 2015).
///
/// In training it normalises with mean and variance (over n) of this batch and moves the running ones (variance over
/// n - 1) by a tenth; else it normalises with the running ones. Half-precision inputs are normalised in f32.
///
/// # Errors
/// [`values_a_channel`]'s in training.
pub(crate) fn batch_norm(x: &Tensor, tensors: BatchNormTensors<'_>, train: bool) -> Result<Tensor> {
    let dtype = x.dtype();
    let x = &at_least_f32(x)?;
    let mut shape = vec![1; x.rank()];
    shape[1] = x.dim(1)?;
    let fit = |t: &Tensor| t.to_dtype(x.dtype())?.reshape(shape.as_slice());
    let (weight, bias) = (fit(tensors.weight)?, fit(tensors.bias)?);

    let y = if train {
        let count = values_a_channel(x)?;
        let over: Vec<usize> = (0..x.rank()).filter(|&d| d != 1).collect();
        let mean = x.mean_keepdim(over.as_slice())?;
        let centred = x.broadcast_sub(&mean)?;
        let variance = centred.sqr()?.mean_keepdim(over)?;
        let unbiased = (&variance * (count as f64 / (count - 1) as f64))?;
        move_towards(tensors.running_mean, &mean)?;
        move_towards(tensors.running_var, &unbiased)?;
        let deviation = (variance + EPSILON)?.sqrt()?;
        centred.broadcast_mul(&weight.broadcast_div(&deviation)?)?
    } else {
        let mean = fit(&tensors.running_mean.as_detached_tensor())?;
        let deviation = (fit(&tensors.running_var.as_detached_tensor())? + EPSILON)?.sqrt()?;
        x.broadcast_sub(&mean)?
            .broadcast_mul(&weight.broadcast_div(&deviation)?)?
    };
    y.broadcast_add(&bias)?.to_dtype(dtype)
}

/// Returns the number of values of a channel of (batch, channels, ...) in training.
///
/// # Errors
/// If there is only one, which has no variance: PyTorch refuses it too.
pub(crate) fn values_a_channel(x: &Tensor) -> Result<usize> {
    match x.elem_count() / x.dim(1)?.max(1) {
        0 | 1 => bail!(
            "batch normalisation needs more than one value a channel in training, found shape {:?}; use a batch of two or more \
             samples, or larger images",
            x.dims()
        ),
        count => Ok(count),
    }
}

fn move_towards(running: &Var, batch: &Tensor) -> Result<()> {
    let old = running.as_detached_tensor();
    let batch = batch.detach().to_dtype(old.dtype())?.reshape(old.dims())?;
    running.set(&((old * (1.0 - MOMENTUM))? + (batch * MOMENTUM)?)?)
}

/// Layer normalisation over the last dimension, with scale and shift (Ba, Kiros and Hinton, arXiv:1607.06450).
/// Half-precision inputs are normalised in f32.
pub(crate) fn layer_norm(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let dtype = x.dtype();
    let x = &at_least_f32(x)?;
    let centred = x.broadcast_sub(&x.mean_keepdim(D::Minus1)?)?;
    let variance = centred.sqr()?.mean_keepdim(D::Minus1)?;
    let normalised = centred.broadcast_div(&(variance + LAYER_EPSILON)?.sqrt()?)?;
    let y = normalised
        .broadcast_mul(&weight.to_dtype(x.dtype())?)?
        .broadcast_add(&bias.to_dtype(x.dtype())?)?;
    y.to_dtype(dtype)
}

/// Widens half precision to f32.
pub(crate) fn at_least_f32(x: &Tensor) -> Result<Tensor> {
    match x.dtype() {
        DType::F16 | DType::BF16 => x.to_dtype(DType::F32),
        _ => Ok(x.clone()),
    }
}
