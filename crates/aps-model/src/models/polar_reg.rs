//! Polar-Reg: a perceptron for each way that arrives along a ray, and convolutions over the directions around the receiver; it
//! is given geometry instead of an image.

use candle_core::{DType, Device, Module, ModuleT, Result, Tensor, Var, bail};
use candle_nn::{Init, VarBuilder};

use super::{Model, Spec};
use crate::ANGLE_BINS;
use crate::condition::{InputKind, PolarShape};
use crate::layers::{BatchNorm, Conv1d, Linear};
use crate::loss::Loss;
use crate::ops;
use crate::parameters::{FIXED, fan_in};
use crate::recording::{Graph, Value, int, recorded};
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

/// Values of a way beside its strength.
const FURTHER: usize = 8;

/// Features of a direction.
const WIDTH: usize = 64;

/// Dilation of the kernels of each block.
const DILATIONS: [usize; 3] = [1, 2, 4];

/// Taps of these kernels.
const TAPS: usize = 7;

/// Factor of a way's output to the logarithm of its strength, which has to spread over 50 dB and more.
const SPREAD: f64 = 6.0;

/// Largest logarithm of a strength: its exponential is a number in f32 and bf16.
const MAX_LOG: f64 = 60.0;

/// Share of a ray that a way arrives along at least.
const LEAST_SHARE: f64 = 0.01;

/// Strength of a direction that no way arrives from.
const LEAST_STRENGTH: f64 = 1e-6;

/// Strength and further values of each way (`ways`), features of each direction (`project`, `norm`), residual blocks along the
/// directions (`blocks`), a share of the power of each direction (`head`), and from that a spectrum (`fixed`). It maps (links,
/// directions, values) of a [`PolarShape`] to (links, bins).
#[derive(Debug, Clone)]
pub(crate) struct PolarReg {
    shape: PolarShape,
    ways: Ways,
    project: Linear,
    norm: BatchNorm,
    blocks: Vec<Block>,
    head: Conv1d,
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
        let inputs = shape.features + shape.ways;
        Ok(Self {
            embed: Linear::new(inputs, HIDDEN, vb.pp("embed"))?,
            hidden: Linear::new(HIDDEN, HIDDEN, vb.pp("hidden"))?,
            out: Linear::new(HIDDEN, 1 + FURTHER, vb.pp("out"))?,
        })
    }

    /// Maps (ways, features and kind) to (ways, 1 + [`FURTHER`]).
    fn forward(&self, ways: &Tensor) -> Result<Tensor> {
        let x = ops::gelu(&self.embed.forward(ways)?)?;
        self.out.forward(&ops::gelu(&self.hidden.forward(&x)?)?)
    }
}

/// The ways that there are, out of all links, directions and kinds. They are data: no gradient is followed through them.
struct Found {
    /// (ways, features and kind as a unit vector)
    rows: Tensor,
    /// Number of each: kind plus kinds times direction plus directions times link.
    at: Tensor,
    /// Number of each without the kind.
    direction: Tensor,
}

impl Found {
    /// Picks them out of (links, directions, values), which are taken in f32, as they are made.
    fn of(input: &Tensor, shape: &PolarShape) -> Result<Self> {
        let &PolarShape { ways, features, .. } = shape;
        let host = input.detach().to_device(&Device::Cpu)?;
        let host = host.to_dtype(DType::F32)?.flatten_all()?.to_vec1::<f32>()?;
        let (mut rows, mut at) = (Vec::new(), Vec::new());
        for (direction, values) in host.chunks_exact(shape.values()).enumerate() {
            let all = values[..ways * features].chunks_exact(features);
            for (kind, way) in all.enumerate() {
                if way[1] != 0.0 {
                    at.push((direction * ways + kind) as u32);
                    rows.extend_from_slice(way);
                    rows.extend((0..ways).map(|other| f32::from(u8::from(other == kind))));
                }
            }
        }
        if at.is_empty() {
            // Layers take no empty batch: a way of zeros, which has no strength, stands in.
            at.push(0);
            rows.resize(features + ways, 0.0);
        }
        let (count, device) = (at.len(), input.device());
        let direction = at.iter().map(|at| at / ways as u32).collect::<Vec<_>>();
        let rows = Tensor::from_vec(rows, (count, features + ways), device)?;
        Ok(Self {
            rows: recorded(
                &[input],
                |g, v| every_way(g, v[0], shape),
                || rows.to_dtype(input.dtype()),
            )?,
            at: Tensor::from_vec(at, count, device)?,
            direction: Tensor::from_vec(direction, count, device)?,
        })
    }

    /// Sums values (ways, 1) over the ways of each direction: (links, directions, 1).
    fn sums(&self, values: &Tensor, links: usize, shape: &PolarShape) -> Result<Tensor> {
        let &PolarShape {
            directions, ways, ..
        } = shape;
        let nodes = |g: &mut Graph, v: &[Value]| {
            let values = g.regroup(v[0], &[directions, ways]);
            let last = g.whole(&[-1]);
            g.node("ReduceSum", &[values, last], [])
        };
        recorded(&[values], nodes, || {
            let sums = Tensor::zeros((links * directions, 1), values.dtype(), values.device())?;
            let sums = sums.index_add(&self.direction, &values.contiguous()?, 0)?;
            sums.reshape((links, directions, 1))
        })
    }

    /// Puts values (ways, [`FURTHER`]) to their directions, zeros where there is no way: (links, directions, all values).
    fn spread(&self, values: &Tensor, links: usize, shape: &PolarShape) -> Result<Tensor> {
        let &PolarShape {
            directions, ways, ..
        } = shape;
        let nodes = |g: &mut Graph, v: &[Value]| g.regroup(v[0], &[directions, ways * FURTHER]);
        recorded(&[values], nodes, || {
            let all = (links * directions * ways, FURTHER);
            let all = Tensor::zeros(all, values.dtype(), values.device())?;
            let all = all.index_add(&self.at, &values.contiguous()?, 0)?;
            all.reshape((links, directions, ways * FURTHER))
        })
    }
}

/// Makes the rows of [`Found`] in a graph: of every way, there or not, since those that are not have no strength.
fn every_way(g: &mut Graph, input: Value, shape: &PolarShape) -> Value {
    let &PolarShape { ways, features, .. } = shape;
    let all = g.slice(input, 2, [0, ways * features]);
    let all = g.regroup(all, &[ways, features]);
    let unit = |n: usize| f64::from(u8::from(n / ways == n % ways));
    let kinds = (0..ways * ways).map(unit).collect::<Vec<_>>();
    let kinds = g.numbers(&[1, ways, ways], &kinds);
    let kinds = g.repeat(kinds, &[ways, ways], all);
    let all = g.node("Concat", &[all, kinds], [int("axis", 2)]);
    g.regroup(all, &[features + ways])
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
    /// Creates the model: 76,426 trainable parameters for 15 ways of 14 features and 4 numbers.
    pub fn new(shape: PolarShape, vb: VarBuilder<'_>) -> Result<Self> {
        let blocks = DILATIONS.into_iter().enumerate();
        let block = |(n, dilation)| Block::new(WIDTH, dilation, vb.pp("blocks").pp(n));
        let inputs = shape.ways * FURTHER + shape.numbers + 1;
        Ok(Self {
            shape,
            ways: Ways::new(&shape, vb.pp("ways"))?,
            project: Linear::new(inputs, WIDTH, vb.pp("project"))?,
            norm: BatchNorm::new(WIDTH, vb.pp("norm"))?,
            blocks: blocks.map(block).collect::<Result<_>>()?,
            head: Conv1d::same(WIDTH, 1, 1, vb.pp("head"))?,
            spectrum: Spectrum::new(shape.directions, vb.pp(FIXED))?,
        })
    }

    /// Computes the share of the power by direction (links, directions).
    pub fn power(&self, input: &Tensor, train: bool) -> Result<Tensor> {
        let PolarShape {
            directions,
            ways,
            features,
            numbers,
        } = self.shape;
        let links = match input.dims() {
            &[links, found, values] if found == directions && values == self.shape.values() => {
                links
            }
            found => bail!(
                "ways along rays must have the shape [any, {directions}, {}], not {found:?}",
                self.shape.values()
            ),
        };
        let found = Found::of(input, &self.shape)?;
        let column = |n: usize| ops::narrow(&found.rows, 1, n, 1);
        let out = self.ways.forward(&found.rows)?;
        let share = ops::at_least_f32(&column(0)?)?;
        let share = ops::log(&ops::shift(&share, LEAST_SHARE)?)?;
        let log = ops::at_least_f32(&ops::narrow(&out, 1, 0, 1)?)?;
        let log = ops::add(&ops::scale(&log, SPREAD)?, &share)?;
        let is_there = column(1)?;
        // What stands in for no way has no strength.
        let strength = ops::exp(&ops::at_most(&log, MAX_LOG)?)?;
        let strength = ops::mul(&strength, &is_there.to_dtype(log.dtype())?)?;
        let sums = found.sums(&strength, links, &self.shape)?;
        let log_sums = ops::log(&ops::shift(&sums, LEAST_STRENGTH)?)?;
        let further = ops::mul(&ops::narrow(&out, 1, 1, FURTHER)?, &is_there)?;
        let further = found.spread(&further, links, &self.shape)?;
        let numbers = ops::narrow(input, 2, ways * features, numbers)?;
        let seen = log_sums.to_dtype(input.dtype())?;
        let x = ops::cat(&[&further, &numbers, &seen], 2)?;
        let x = ops::transpose(&self.project.forward(&x)?)?;
        // Slope 0: the plain one, with loops of our own.
        let mut x = ops::leaky_relu(&self.norm.forward_t(&x, train)?, 0.0)?;
        for block in &self.blocks {
            x = block.forward_t(&x, train)?;
        }
        // As normalisations, shares and the spectrum are computed in f32 at least: a maximum takes most digits away.
        let logits = ops::at_least_f32(&ops::squeeze(&self.head.forward(&x)?, 1)?)?;
        ops::softmax(&ops::add(&logits, &ops::squeeze(&log_sums, 2)?)?)
    }
}

impl ModuleT for PolarReg {
    fn forward_t(&self, input: &Tensor, train: bool) -> Result<Tensor> {
        let spectrum = self.spectrum.forward(&self.power(input, train)?)?;
        spectrum.to_dtype(input.dtype())
    }
}

impl Model for PolarReg {}
