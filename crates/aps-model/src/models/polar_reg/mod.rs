//! Polar-Reg: a perceptron for each way that arrives along a ray, whose strengths are added; it is given geometry instead of an image.

mod found;

use candle_core::{DType, Device, Module, ModuleT, Result, Tensor, Var};
use candle_nn::{Init, VarBuilder};

use self::found::Found;
use super::{Model, Spec};
use crate::ANGLE_BINS;
use crate::condition::{InputKind, PolarShape};
use crate::layers::Linear;
use crate::loss::Loss;
use crate::ops;
use crate::parameters::FIXED;
use crate::train::TrainConfig;

pub(crate) const SPEC: Spec = Spec {
    name: "polar_reg",
    title: "Polar-Reg",
    loss: Loss::AbsoluteAndCosine,
    input: InputKind::Polar,
    build: |_, shape, vb| Ok(Box::new(PolarReg::new(shape.polar()?, vb)?)),
    settings: |usual| TrainConfig {
        batch: 128,
        learning_rate: 2e-3,
        ..usual
    },
};

/// Features within the perceptron of a way.
const HIDDEN: usize = 48;

/// Factor of a way's output to the logarithm of its strength, which has to spread over 50 dB and more.
const SPREAD: f64 = 6.0;

/// Largest logarithm of a strength: its exponential is a number in f32 and bf16.
const MAX_LOG: f64 = 60.0;

/// Share of a ray that a way arrives along at least.
const LEAST_SHARE: f64 = 0.01;

/// Strength of a direction that no way arrives from.
const LEAST_STRENGTH: f64 = 1e-6;

/// The strength of each way (`ways`), added to a share of the power of each direction, and from that a spectrum (`fixed`). It maps
/// ways of a [`PolarShape`] in f32, on the CPU or on the device of its parameters, to (links, bins) there, in the type of its parameters.
#[derive(Debug, Clone)]
pub(crate) struct PolarReg {
    shape: PolarShape,
    dtype: DType,
    device: Device,
    ways: Ways,
    spectrum: Spectrum,
}

/// A perceptron for each way: `embed` of its features and its kind as a unit vector, `hidden`, `out`, with GELU between.
#[derive(Debug, Clone)]
struct Ways {
    embed: Linear,
    hidden: Linear,
    out: Linear,
}

impl Ways {
    fn new(shape: &PolarShape, vb: VarBuilder<'_>) -> Result<Self> {
        let inputs = shape.features + shape.kinds;
        Ok(Self {
            embed: Linear::new(inputs, HIDDEN, vb.pp("embed"))?,
            hidden: Linear::new(HIDDEN, HIDDEN, vb.pp("hidden"))?,
            out: Linear::new(HIDDEN, 1, vb.pp("out"))?,
        })
    }

    /// Maps (ways, features and kind) to the logarithms of their strengths over [`SPREAD`], (ways, 1).
    fn forward(&self, ways: &Tensor) -> Result<Tensor> {
        let x = ops::gelu(&self.embed.forward(ways)?)?;
        self.out.forward(&ops::gelu(&self.hidden.forward(&x)?)?)
    }
}

/// Makes a spectrum of shares of the power: the response of the array, divided by its maximum and standardised as the labels
/// are. See [`LabelFacts`](crate::LabelFacts).
#[derive(Debug, Clone)]
struct Spectrum {
    /// (bins, directions)
    array: Var,
    mean: Var,
    deviation: Var,
    /// On the CPU: it decides what is computed.
    is_by_link: Var,
}

impl Spectrum {
    fn new(directions: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let zeros = Init::Const(0.0);
        let number = |vb: &VarBuilder<'_>, name, value| {
            Var::from_tensor(&vb.get_with_hints((), name, Init::Const(value))?)
        };
        let on_cpu = vb.clone().set_device(Device::Cpu);
        Ok(Self {
            array: Var::from_tensor(&vb.get_with_hints(
                (ANGLE_BINS, directions),
                "array",
                zeros,
            )?)?,
            mean: number(&vb, "mean", 0.0)?,
            deviation: number(&vb, "deviation", 1.0)?,
            is_by_link: number(&on_cpu, "is_by_link", 0.0)?,
        })
    }
}

/// Keeps a spectrum without power from being divided by zero.
const LEAST_MAXIMUM: f64 = 1e-9;

/// Keeps the deviation of a link's own spectrum from being zero, as the labels do.
const LEAST_DEVIATION: f64 = 1e-8;

impl Module for Spectrum {
    fn forward(&self, power: &Tensor) -> Result<Tensor> {
        let fixed = |var: &Var| ops::fixed(var, power.dtype());
        let y = ops::project(power, &fixed(&self.array)?)?;
        let y = ops::div(&y, &ops::shift(&ops::max_last(&y)?, LEAST_MAXIMUM)?)?;
        let y = ops::sub(&y, &fixed(&self.mean)?)?;
        let y = ops::div(&y, &fixed(&self.deviation)?)?;
        if self.is_by_link.to_dtype(DType::F32)?.to_scalar::<f32>()? == 0.0 {
            return Ok(y);
        }
        let centred = ops::centred_last(&y)?;
        let deviation = ops::shift(&ops::rms_last(&centred)?, LEAST_DEVIATION)?;
        ops::div(&centred, &deviation)
    }
}

impl PolarReg {
    /// Creates the model: 3,841 trainable parameters for 15 kinds of ways of 14 features.
    pub fn new(shape: PolarShape, vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            shape,
            dtype: vb.dtype(),
            device: vb.device().clone(),
            ways: Ways::new(&shape, vb.pp("ways"))?,
            spectrum: Spectrum::new(shape.directions, vb.pp(FIXED))?,
        })
    }

    /// Computes the share of the power by direction (links, directions).
    pub fn power(&self, input: &Tensor) -> Result<Tensor> {
        self.shares(&Found::of(input, &self.shape, self.dtype, &self.device)?)
    }

    /// Computes the share of the power by direction of some links from their ways.
    fn shares(&self, found: &Found) -> Result<Tensor> {
        let column = |n: usize| ops::narrow(&found.rows, 1, n, 1);
        let share = ops::at_least_f32(&column(0)?)?;
        let share = ops::log(&ops::shift(&share, LEAST_SHARE)?)?;
        // As normalisations, strengths, shares and the spectrum are computed in f32 at least: a maximum takes most digits away.
        let log = ops::at_least_f32(&self.ways.forward(&found.rows)?)?;
        let log = ops::add(&ops::scale(&log, SPREAD)?, &share)?;
        // What stands in for no way has no strength.
        let strength = ops::exp(&ops::at_most(&log, MAX_LOG)?)?;
        let strength = ops::mul(&strength, &column(1)?.to_dtype(log.dtype())?)?;
        let sums = found.sums(&strength, &self.shape)?;
        ops::softmax(&ops::log(&ops::shift(&sums, LEAST_STRENGTH)?)?)
    }
}

impl ModuleT for PolarReg {
    fn forward_t(&self, input: &Tensor, _: bool) -> Result<Tensor> {
        let spectrum = self.spectrum.forward(&self.power(input)?)?;
        spectrum.to_dtype(self.dtype)
    }
}

impl Model for PolarReg {}
