//! Polar-Reg: a perceptron for each way that arrives along a ray, whose strengths are added; it is given geometry instead of an image.

mod ways;

use candle_core::{DType, Device, Module, ModuleT, Result, Tensor, Var};
use candle_nn::{Init, VarBuilder};

use self::ways::Ways;
use super::{Model, Spec};
use crate::ANGLE_BINS;
use crate::condition::{InputKind, PolarShape};
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

/// Strength of a direction that no way arrives from.
const LEAST_STRENGTH: f64 = 1e-6;

/// The strength of each way (`ways`), added to a share of the power of each direction, and from that a spectrum (`fixed`). It maps
/// ways of a [`PolarShape`] in f32, on the CPU or on the device of its parameters, to (links, bins) there, in the type of its parameters.
#[derive(Debug, Clone)]
pub(crate) struct PolarReg {
    dtype: DType,
    ways: Ways,
    spectrum: Spectrum,
}

/// Converts shares of power to a normalised spectrum: the response of the array, divided by its maximum and standardised as the labels
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
        let centred = ops::sub(&y, &ops::mean_last(&y)?)?;
        let variance = ops::mean_last(&ops::square(&centred)?)?;
        let deviation = ops::shift(&ops::sqrt(&variance)?, LEAST_DEVIATION)?;
        ops::div(&centred, &deviation)
    }
}

impl PolarReg {
    /// Creates the model: 3,841 trainable parameters for 15 kinds of ways of 14 features.
    pub fn new(shape: PolarShape, vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            dtype: vb.dtype(),
            ways: Ways::new(&shape, vb.pp("ways"))?,
            spectrum: Spectrum::new(shape.directions, vb.pp(FIXED))?,
        })
    }

    /// Computes the share of the power by direction (links, directions).
    pub fn power(&self, input: &Tensor) -> Result<Tensor> {
        let sums = self.ways.sums(input)?;
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
