//! Tensors of a model: candle's [`VarMap`] with initial values that follow from a seed, and constant copies of it.

use std::collections::HashMap;

use candle_core::{DType, Device, Shape, Tensor, Var};
use candle_nn::init::NormalOrUniform;
use candle_nn::var_builder::SimpleBackend;
use candle_nn::{Init, VarBuilder, VarMap};

use crate::random::{generator_of_tensor, normal_pair, unit};
use crate::{Error, Result};

/// Returns a builder that makes a model's tensors in `parameters`, floats of type `dtype` on `device`.
///
/// The initial values of a tensor follow from `seed` and the tensor's name alone, so that they depend neither on the order
/// in which a model asks for its tensors nor on the device or the machine. A tensor that is in `parameters` already is
/// used as it is, as by [`VarBuilder::from_varmap`].
///
/// ```
/// use aps_model::candle_core::{DType, Device};
/// use aps_model::candle_nn::VarMap;
/// use aps_model::condition::InputShape;
/// use aps_model::{ModelKind, Preset, seeded, trainable};
///
/// let parameters = VarMap::new();
/// let vb = seeded(&parameters, 1, DType::F32, &Device::Cpu);
/// ModelKind::ResnetMlp.build(Preset::Small, InputShape::Images, vb)?;
/// let count: usize = trainable(&parameters).iter().map(|(_, var)| var.elem_count()).sum();
/// assert_eq!(count, 2_910_932);
/// # Ok::<(), aps_model::Error>(())
/// ```
pub fn seeded(
    parameters: &VarMap,
    seed: u64,
    dtype: DType,
    device: &Device,
) -> VarBuilder<'static> {
    let backend = Seeded {
        parameters: parameters.clone(),
        seed,
    };
    VarBuilder::from_backend(Box::new(backend), dtype, device.clone())
}

/// Copies `parameters` into a builder of constants, for a model that is only evaluated.
///
/// No gradient is asked of a constant: values between the layers are freed as soon as the next layer has read them, instead
/// of being kept for a backward pass, and convolutions keep a kernel cache (on a CPU, up to four times the weights' memory).
/// Later changes of `parameters` do not reach the copy.
///
/// # Errors
/// [`Error::Candle`](crate::Error::Candle), where there is no memory for the copy.
///
/// ```
/// use aps_model::candle_core::{DType, Device, ModuleT, Tensor};
/// use aps_model::candle_nn::VarMap;
/// use aps_model::condition::InputShape;
/// use aps_model::{ModelKind, Preset, frozen, seeded};
///
/// let parameters = VarMap::new();
/// let vb = seeded(&parameters, 1, DType::F32, &Device::Cpu);
/// ModelKind::ResnetMlp.build(Preset::Small, InputShape::Images, vb)?;
/// let model = ModelKind::ResnetMlp.build(Preset::Small, InputShape::Images, frozen(&parameters)?)?;
/// let images = Tensor::zeros((2, 3, 64, 64), DType::F32, &Device::Cpu)?;
/// assert!(!model.forward_t(&images, false)?.track_op());
/// # Ok::<(), aps_model::Error>(())
/// ```
pub fn frozen(parameters: &VarMap) -> Result<VarBuilder<'static>> {
    let (mut dtype, mut device) = (DType::F32, Device::Cpu);
    let mut constants = HashMap::new();
    for (name, var) in sorted(parameters) {
        // Facts of the labels may lie elsewhere.
        if var.dtype().is_float() && !is_fixed(&name) {
            (dtype, device) = (var.dtype(), var.device().clone());
        }
        constants.insert(name, var.as_detached_tensor().copy()?);
    }
    Ok(VarBuilder::from_tensors(constants, dtype, &device))
}

/// Returns the trainable tensors by name, in the order of their names: all but the running statistics and counters of batch
/// normalisation, and the facts of the labels ([`LabelFacts`]).
pub fn trainable(parameters: &VarMap) -> Vec<(String, Var)> {
    let mut all = sorted(parameters);
    all.retain(|(name, var)| {
        let is_mean = name.rsplit('.').next() == Some("running_mean");
        !is_counter(var) && !is_fixed(name) && !is_mean && !is_variance(name)
    });
    all
}

/// Prefix of tensors that follow from the labels and are not trained.
pub(crate) const FIXED: &str = "fixed";

fn is_fixed(name: &str) -> bool {
    name.split('.').next() == Some(FIXED)
}

/// Facts of the labels that a model computes with instead of learning them: kept with its weights, so that a file of weights is
/// complete, and not trained.
///
/// Polar-Reg is the one model that computes with them. Another array is another matrix: the same weights then predict the spectra of
/// that array.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelFacts {
    /// Response of the array in each bin to unit power from each direction, (bins, directions), last axis fastest.
    pub array: Vec<f64>,
    /// Mean of the labels, in parts of each label's maximum.
    pub mean: f64,
    /// Their deviation.
    pub deviation: f64,
    /// True if each label is then standardised by its own mean and deviation.
    pub is_by_link: bool,
}

impl LabelFacts {
    /// Sets the tensors of a model that hold these facts; a model that has none is left as it is.
    ///
    /// # Errors
    /// [`Error::Samples`] for numbers that are not finite, a deviation that is not positive, or an array of another size than
    /// the model's.
    pub fn set(&self, parameters: &VarMap) -> Result<()> {
        let mut numbers = self.array.iter().chain([&self.mean, &self.deviation]);
        if !numbers.all(|x| x.is_finite()) || self.deviation <= 0.0 {
            let text = "facts of the labels must be finite, the deviation positive";
            return Err(Error::Samples(text.into()));
        }
        let data = parameters.data().lock().expect("no holder panics");
        let set = |name: &str, values: &[f64]| -> Result<()> {
            let Some(var) = data.get(&format!("{FIXED}.{name}")) else {
                return Ok(());
            };
            if var.elem_count() != values.len() {
                return Err(Error::Samples(format!(
                    "{} values for the labels' {name}, the model has {:?}",
                    values.len(),
                    var.dims()
                )));
            }
            let values = Tensor::from_slice(values, var.shape(), var.device())?;
            Ok(var.set(&values.to_dtype(var.dtype())?)?)
        };
        set("array", &self.array)?;
        set("mean", &[self.mean])?;
        set("deviation", &[self.deviation])?;
        set("is_by_link", &[f64::from(u8::from(self.is_by_link))])
    }
}

/// Returns all tensors by name, in the order of their names.
pub(crate) fn sorted(parameters: &VarMap) -> Vec<(String, Var)> {
    let data = parameters.data().lock().expect("no holder panics");
    let mut all: Vec<(String, Var)> = data.iter().map(|(n, v)| (n.clone(), v.clone())).collect();
    drop(data);
    all.sort_by(|(a, _), (b, _)| a.cmp(b));
    all
}

/// Returns true for the counter of training passes of a batch normalisation: a whole number that no output depends on, kept
/// so that state dicts go both ways without a tensor too many or too few.
pub(crate) fn is_counter(tensor: &Tensor) -> bool {
    tensor.dtype().is_int()
}

/// Returns true for the name of a variance that a batch normalisation divides by.
pub(crate) fn is_variance(name: &str) -> bool {
    name.rsplit('.').next() == Some("running_var")
}

struct Seeded {
    parameters: VarMap,
    seed: u64,
}

impl SimpleBackend for Seeded {
    fn get(
        &self,
        shape: Shape,
        name: &str,
        init: Init,
        dtype: DType,
        device: &Device,
    ) -> candle_core::Result<Tensor> {
        if !self.contains_tensor(name) {
            let values = draw(init, self.seed, name, &shape);
            let values = Tensor::from_vec(values, &shape, &Device::Cpu)?;
            let var = Var::from_tensor(&values.to_dtype(dtype)?.to_device(device)?)?;
            let mut data = self.parameters.data().lock().expect("no holder panics");
            data.insert(name.to_owned(), var);
        }
        self.parameters.get(shape, name, init, dtype, device)
    }

    fn get_unchecked(
        &self,
        name: &str,
        dtype: DType,
        device: &Device,
    ) -> candle_core::Result<Tensor> {
        SimpleBackend::get_unchecked(&self.parameters, name, dtype, device)
    }

    fn contains_tensor(&self, name: &str) -> bool {
        self.parameters.contains_tensor(name)
    }
}

/// Draws the initial values of the tensor `name` under `seed`.
fn draw(init: Init, seed: u64, name: &str, shape: &Shape) -> Vec<f64> {
    let count = shape.elem_count();
    let mut generator = generator_of_tensor(seed, name);
    match init {
        Init::Const(value) => vec![value; count],
        Init::Uniform { lo, up } => {
            let (centre, half) = ((lo + up) / 2.0, (up - lo) / 2.0);
            let value = |_| centre + half * (2.0 * unit(&mut generator) - 1.0);
            (0..count).map(value).collect()
        }
        Init::Randn { mean, stdev } => {
            let pairs = std::iter::repeat_with(|| normal_pair(&mut generator));
            let values = pairs.flatten().map(|z| mean + stdev * z);
            values.take(count).collect()
        }
        Init::Kaiming {
            dist,
            fan,
            non_linearity,
        } => {
            let stdev = non_linearity.gain() / (fan.for_shape(shape) as f64).sqrt();
            let init = match dist {
                NormalOrUniform::Uniform => symmetric(3.0_f64.sqrt() * stdev),
                NormalOrUniform::Normal => normal(stdev),
            };
            draw(init, seed, name, shape)
        }
    }
}

/// Returns the distribution uniform in ±`bound`.
fn symmetric(bound: f64) -> Init {
    let (lo, up) = (-bound, bound);
    Init::Uniform { lo, up }
}

/// Returns the distribution uniform in ±1/sqrt(fan_in): PyTorch's choice for weight and bias of linear and convolution layers.
/// PyTorch writes this as Kaiming's uniform distribution with the slope a = sqrt(5).
pub(crate) fn fan_in(fan_in: usize) -> Init {
    symmetric(1.0 / (fan_in as f64).sqrt())
}

/// Returns the normal distribution of variance 2 / fan_out, which keeps the size of gradients through ReLU (He et al., "Delving
/// deep into rectifiers", ICCV 2015, eq. 14): torchvision's choice for the convolutions of ResNets.
pub(crate) fn kaiming_fan_out(fan_out: usize) -> Init {
    normal((2.0 / fan_out as f64).sqrt())
}

/// Returns the distribution uniform in ±sqrt(6 / (fan_in + fan_out)) (Glorot and Bengio, AISTATS 2010, eq. 16): torchvision's
/// choice for the attention and the perceptrons of vision transformers.
pub(crate) fn xavier(fan_in: usize, fan_out: usize) -> Init {
    symmetric((6.0 / (fan_in + fan_out) as f64).sqrt())
}

/// Returns the normal distribution of mean 0.
pub(crate) fn normal(stdev: f64) -> Init {
    Init::Randn { mean: 0.0, stdev }
}

#[cfg(test)]
mod tests {
    use candle_nn::init::DEFAULT_KAIMING_NORMAL;

    use super::*;

    fn values(init: Init, seed: u64, name: &str, count: usize) -> Vec<f64> {
        draw(init, seed, name, &Shape::from(count))
    }

    fn moments(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        (mean, variance)
    }

    #[test]
    fn values_follow_from_seed_and_name() {
        let draw = |seed, name| values(fan_in(16), seed, name, 100);
        assert_eq!(draw(1, "fc.weight"), draw(1, "fc.weight"));
        assert_ne!(draw(1, "fc.weight"), draw(2, "fc.weight"));
        assert_ne!(draw(1, "fc.weight"), draw(1, "fc.bias"));
    }

    #[test]
    fn first_values_are_the_same_on_every_machine() {
        // Values of the first run: a change here changes every seeded training.
        let uniform = values(symmetric(1.0), 7, "a", 2);
        let normal = values(normal(1.0), 7, "a", 2);
        assert_eq!(uniform, [0.35640479366106637, -0.9101713007670271]);
        assert_eq!(normal, [1.4463098824789244, 0.41934795712579115]);
    }

    #[test]
    fn distributions_have_their_moments() {
        let n = 100_000;
        let close = |init, expected: [f64; 2], tolerance| {
            let (mean, variance) = moments(&values(init, 1, "u", n));
            let off = [mean - expected[0], variance - expected[1]];
            let is_close = off.iter().all(|off| off.abs() < tolerance);
            assert!(is_close, "{init:?}: {mean} {variance}");
        };
        close(symmetric(3.0), [0.0, 3.0], 0.05);
        close(Init::Uniform { lo: 1.0, up: 3.0 }, [2.0, 1.0 / 3.0], 0.01);
        let (mean, stdev) = (1.0, 2.0);
        close(Init::Randn { mean, stdev }, [1.0, 4.0], 0.1);
        let normal = values(normal(1.0), 1, "n", n);
        let squares: Vec<f64> = normal.iter().map(|v| v * v).collect();
        let (_, spread) = moments(&squares);
        // The variance of the square of a normal value.
        assert!((spread - 2.0).abs() < 0.1, "{spread}");
        let (kaiming, weight) = (DEFAULT_KAIMING_NORMAL, Shape::from((100, 50)));
        let (mean, variance) = moments(&draw(kaiming, 1, "k", &weight));
        let is_close = mean.abs() < 0.01 && (variance - 2.0 / 50.0).abs() < 0.003;
        assert!(is_close, "{mean} {variance}");
    }

    #[test]
    fn bounds_are_pytorch_s() {
        let range = |init| match init {
            Init::Uniform { lo, up } => [lo, up],
            Init::Randn { mean, stdev } => [mean, stdev],
            other => panic!("{other:?}"),
        };
        // torch.nn.Linear(64, 8): kaiming_uniform_(a = sqrt 5) has gain sqrt(2 / 6) and bound sqrt(3) gain / sqrt(64).
        assert_eq!(range(fan_in(64)), [-0.125, 0.125]);
        assert_eq!(range(xavier(10, 14)), [-0.5, 0.5]);
        assert_eq!(range(kaiming_fan_out(8)), [0.0, 0.5]);
    }
}
