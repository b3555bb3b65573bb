//! Polar-Reg: a convolutional network over range and direction around the receiver, which is given geometry instead of an
//! image.

use candle_core::{D, DType, Module, ModuleT, Result, Tensor, Var, bail};
use candle_nn::{Init, VarBuilder};

use super::{Model, Spec};
use crate::ANGLE_BINS;
use crate::condition::{InputKind, PolarShape};
use crate::layers::{BatchNorm, Conv1d, Conv2d, Linear, NormedConv};
use crate::loss::Loss;
use crate::ops::{self, After};
use crate::parameters::{FIXED, fan_in};
use crate::train::TrainConfig;

pub(crate) const SPEC: Spec = Spec {
    name: "polar_reg",
    title: "Polar-Reg",
    loss: Loss::AbsoluteAndCosine,
    input: InputKind::Polar,
    build: |_, shape, vb| Ok(Box::new(PolarReg::new(shape.polar()?, vb)?)),
    settings: |usual| TrainConfig {
        batch: 128,
        learning_rate: 1.5e-3,
        ..usual
    },
};

/// Channels of the convolutions over range and direction, each of which halves the ranges.
const STEM: [usize; 3] = [24, 32, 40];

/// Features of a direction.
const WIDTH: usize = 96;

/// Dilation of the kernels of each block.
const DILATIONS: [usize; 6] = [1, 2, 4, 1, 2, 4];

/// Taps of these kernels.
const TAPS: usize = 9;

/// Convolutions over range and direction (`stem.N`), features of each direction (`project`), residual blocks along the
/// directions (`blocks.N`), a share of the power of each direction (`head`), and from that a spectrum (`fixed`). It maps (links,
/// rows, directions) of a [`PolarShape`] to (links, bins).
#[derive(Debug, Clone)]
pub(crate) struct PolarReg {
    shape: PolarShape,
    stem: Vec<NormedConv>,
    project: Conv1d,
    blocks: Vec<Block>,
    head: Conv1d,
    spectrum: Spectrum,
}

/// A depthwise circular convolution (`depthwise`), `norm`, a perceptron (`expand`, GELU, `contract`), times a `gate` that sees
/// the mean over all directions, beside a shortcut. It keeps the shape (links, width, directions).
#[derive(Debug, Clone)]
struct Block {
    depthwise: Tensor,
    dilation: usize,
    norm: BatchNorm,
    expand: Conv1d,
    contract: Conv1d,
    gate: Linear,
}

impl Block {
    fn new(width: usize, dilation: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let init = fan_in(TAPS);
        let depthwise = vb.pp("depthwise");
        Ok(Self {
            depthwise: depthwise.get_with_hints((width, 1, TAPS), "weight", init)?,
            dilation,
            norm: BatchNorm::new(width, vb.pp("norm"))?,
            expand: Conv1d::same(width, 2 * width, 1, vb.pp("expand"))?,
            contract: Conv1d::same(2 * width, width, 1, vb.pp("contract"))?,
            gate: Linear::new(width, width, vb.pp("gate"))?,
        })
    }
}

impl ModuleT for Block {
    fn forward_t(&self, x: &Tensor, train: bool) -> Result<Tensor> {
        let y = ops::depthwise(x, &self.depthwise, self.dilation)?;
        let y = self.expand.forward(&self.norm.forward_t(&y, train)?)?;
        let y = self.contract.forward(&ops::gelu(&y)?)?;
        let gate = ops::sigmoid(&self.gate.forward(&ops::mean_last(x)?)?)?;
        ops::add_gated(x, &y, &gate)
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
    is_by_link: Var,
}

impl Spectrum {
    fn new(directions: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let zeros = Init::Const(0.0);
        let get =
            |name, value| Var::from_tensor(&vb.get_with_hints((), name, Init::Const(value))?);
        Ok(Self {
            array: Var::from_tensor(&vb.get_with_hints(
                (ANGLE_BINS, directions),
                "array",
                zeros,
            )?)?,
            mean: get("mean", 0.0)?,
            deviation: get("deviation", 1.0)?,
            is_by_link: get("is_by_link", 0.0)?,
        })
    }
}

/// Keeps a spectrum without power from being divided by zero.
const LEAST_MAXIMUM: f64 = 1e-9;

/// Keeps the deviation of a link's own spectrum from being zero, as the labels do.
const LEAST_DEVIATION: f64 = 1e-8;

impl Module for Spectrum {
    fn forward(&self, power: &Tensor) -> Result<Tensor> {
        let fixed = |var: &Var| var.as_detached_tensor().to_dtype(power.dtype());
        let y = power.matmul(&fixed(&self.array)?.t()?)?;
        let y = y.broadcast_div(&(ops::max_last(&y)? + LEAST_MAXIMUM)?)?;
        let y = y.broadcast_sub(&fixed(&self.mean)?)?;
        let y = y.broadcast_div(&fixed(&self.deviation)?)?;
        if self.is_by_link.to_dtype(DType::F32)?.to_scalar::<f32>()? == 0.0 {
            return Ok(y);
        }
        let centred = y.broadcast_sub(&y.mean_keepdim(D::Minus1)?)?;
        let deviation = centred.sqr()?.mean_keepdim(D::Minus1)?.sqrt()?;
        centred.broadcast_div(&(deviation + LEAST_DEVIATION)?)
    }
}

impl PolarReg {
    /// Creates the model: 326,113 trainable parameters for 12 planes and 4 numbers over 40 ranges.
    pub fn new(shape: PolarShape, vb: VarBuilder<'_>) -> Result<Self> {
        let (mut channels, mut ranges) = (shape.planes, shape.ranges);
        let mut stem = Vec::new();
        for (n, outputs) in STEM.into_iter().enumerate() {
            let vb = vb.pp("stem").pp(n);
            let conv = Conv2d::polar(channels, outputs, 3, vb.pp("conv"))?;
            stem.push(NormedConv::new(
                conv,
                BatchNorm::new(outputs, vb.pp("norm"))?,
            ));
            (channels, ranges) = (outputs, ranges.div_ceil(2));
        }
        let blocks = DILATIONS.into_iter().enumerate();
        let block = |(n, dilation)| Block::new(WIDTH, dilation, vb.pp("blocks").pp(n));
        Ok(Self {
            shape,
            stem,
            project: Conv1d::same(
                channels * ranges + shape.numbers,
                WIDTH,
                1,
                vb.pp("project"),
            )?,
            blocks: blocks.map(block).collect::<Result<_>>()?,
            head: Conv1d::same(WIDTH, 1, 1, vb.pp("head"))?,
            spectrum: Spectrum::new(shape.directions, vb.pp(FIXED))?,
        })
    }

    /// Computes the share of the power by direction (links, directions).
    pub fn power(&self, fields: &Tensor, train: bool) -> Result<Tensor> {
        let PolarShape {
            planes,
            numbers,
            ranges,
            directions,
        } = self.shape;
        let links = match fields.dims() {
            &[links, rows, columns] if rows == self.shape.rows() && columns == directions => links,
            found => bail!(
                "polar fields must have the shape [any, {}, {directions}], not {found:?}",
                self.shape.rows()
            ),
        };
        let mut x = fields.narrow(1, 0, planes * ranges)?;
        x = x.reshape((links, planes, ranges, directions))?;
        for layer in &self.stem {
            x = layer.forward_t(&x, After::Relu, train)?;
        }
        let numbers = fields.narrow(1, planes * ranges, numbers)?;
        let x = Tensor::cat(&[&x.flatten(1, 2)?, &numbers], 1)?;
        let x = self.project.forward(&x)?;
        // Slope 0: the plain one, with loops of our own.
        let mut x = ops::leaky_relu(&x, 0.0)?;
        for block in &self.blocks {
            x = block.forward_t(&x, train)?;
        }
        // As normalisations, shares and the spectrum are computed in f32 at least: a maximum takes most digits away.
        let logits = self.head.forward(&x)?.squeeze(1)?;
        ops::softmax(&ops::at_least_f32(&logits)?)
    }
}

impl ModuleT for PolarReg {
    fn forward_t(&self, fields: &Tensor, train: bool) -> Result<Tensor> {
        let spectrum = self.spectrum.forward(&self.power(fields, train)?)?;
        spectrum.to_dtype(fields.dtype())
    }
}

impl Model for PolarReg {}
