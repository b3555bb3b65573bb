//! Training with a squared error: one step in single precision, three in double.

use std::collections::BTreeMap;

use candle_core::{DType, ModuleT, Result, Tensor};
use candle_nn::{VarBuilder, VarMap};

use super::super::{blank, flat};
use super::golden::{Golden, Row};
use super::optimizer::{Adam, gradients};
use super::rule::{images, set_weights, targets};
use crate::models::{ms_areg, radiounet, resnet_conv1d, resnet_mlp, vit_reg};
use crate::parameters::sorted;

/// Number of steps and tolerances of a comparison, by precision.
pub struct Tolerances {
    pub steps: usize,
    /// Absolute tolerance of outputs.
    pub output: f64,
    /// Relative tolerance of losses.
    pub loss: f64,
    /// Relative tolerance of norms and samples of gradients.
    pub gradient: f64,
    /// Largest error of a single sampled gradient, in units of the tolerance.
    ///
    /// Unlimited in single precision: rounding moves values across the kink of a ReLU, and single gradients jump.
    /// PyTorch's own (2.15, oneDNN) are off by up to 1.8 times the size of an element for resnet_conv1d, their norm by 1e-3.
    pub outliers: f64,
}

impl Tolerances {
    pub fn of(dtype: DType) -> Self {
        match dtype {
            DType::F64 => Self {
                steps: 3,
                output: 1e-9,
                loss: 1e-9,
                gradient: 1e-9,
                outliers: 1.0,
            },
            _ => Self {
                steps: 1,
                output: 1e-4,
                loss: 1e-4,
                gradient: 1e-3,
                outliers: f64::INFINITY,
            },
        }
    }
}

/// Returns all tensors of a model, in the order of their names.
pub fn tensors(parameters: &VarMap) -> Vec<(String, Tensor)> {
    let all = sorted(parameters).into_iter();
    all.map(|(name, var)| (name, var.as_detached_tensor()))
        .collect()
}

pub fn scalar(loss: &Tensor) -> f64 {
    flat(loss)[0]
}

pub fn check_loss(golden: &[f64], step: usize, found: f64, tolerances: &Tolerances) {
    let off = (found / golden[step] - 1.0).abs();
    println!("loss of step {step}: {found}, off by {off:.1e} relative");
    let expected = golden[step];
    assert!(
        off <= tolerances.loss,
        "loss of step {step}: {found}, not {expected}"
    );
}

/// Norms of groups (top-level modules), of single tensors to ten times that, and samples. To each comes 1e-2 of it of the
/// group's norm: of a bias before a batch normalisation, whose mean takes it out again, only rounding is left.
pub fn check_gradients(rows: &[Row], tolerances: &Tolerances) {
    let group_of = |row: &Row| row.tensor.split('.').next().unwrap_or_default().to_owned();
    let mut groups: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    for row in rows {
        let group = groups.entry(group_of(row)).or_default();
        group.0 = group.0.hypot(row.norm.0);
        group.1 = group.1.hypot(row.norm.1);
    }
    for (name, (expected, found)) in &groups {
        let off = (found / expected - 1.0).abs();
        println!("gradient of {name}: {found:.6}, off by {off:.1e} relative");
        let is_close = off <= tolerances.gradient;
        assert!(is_close, "gradient of {name}: {found}, not {expected}");
    }
    let mut samples = Vec::new();
    for row in rows {
        let floor = 1e-2 * tolerances.gradient * groups[&group_of(row)].0;
        let (expected, found) = row.norm;
        assert!(
            (found - expected).abs() <= 10.0 * tolerances.gradient * expected + floor,
            "gradient of {}: norm {found}, not {expected}",
            row.tensor
        );
        samples.extend(row.samples.iter().map(|(expected, found)| {
            (found - expected).abs() / (tolerances.gradient * row.rms + floor)
        }));
    }
    samples.sort_by(f64::total_cmp);
    let (median, worst) = (samples[samples.len() / 2], samples[samples.len() - 1]);
    println!(
        "samples of gradients: {median:.3} of what is allowed in the median, {worst:.3} at worst"
    );
    assert!(
        median <= 1.0,
        "half of all sampled gradients are off by {median} of what is allowed"
    );
    assert!(
        worst <= tolerances.outliers,
        "a sampled gradient is off by {worst} of what is allowed"
    );
}

/// Norms and samples of all tensors.
pub fn check_after(rows: &[Row]) {
    let (mut worst, mut worst_at) = (0.0_f64, "");
    for row in rows {
        for (size, (expected, found)) in row.pairs() {
            let off = (found - expected).abs() / size.max(f64::MIN_POSITIVE);
            if off > worst {
                (worst, worst_at) = (off, &row.tensor);
            }
        }
    }
    println!("after three steps: off by at most {worst:.1e} relative, in {worst_at}");
    assert!(worst <= 1e-9, "{worst_at}: off by {worst:e} relative");
}

/// Builds a model in the paper's sizes without dropout.
type Build = fn(VarBuilder<'_>) -> Result<Box<dyn ModuleT>>;

fn training_is_pytorch_s(dtype: DType, name: &str, build: Build) -> Result<()> {
    let parameters = VarMap::new();
    let model = build(blank(&parameters, dtype))?;
    set_weights(&parameters);
    let (golden, tolerances) = (Golden::of(name), Tolerances::of(dtype));
    let (images, targets) = (images(64).to_dtype(dtype)?, targets().to_dtype(dtype)?);
    let mut optimizer = Adam::new(3e-4, [0.9, 0.999], 0.01);
    for step in 0..tolerances.steps {
        let output = model.forward_t(&images, true)?;
        let loss = (&output - &targets)?.sqr()?.mean_all()?;
        let moves = gradients(&parameters, &loss.backward()?);
        if step == 0 {
            golden.check_absolute("train_64", &output, tolerances.output);
            check_gradients(&golden.rows("gradients", &moves), &tolerances);
        }
        check_loss(&golden.values("losses"), step, scalar(&loss), &tolerances);
        if tolerances.steps > 1 {
            optimizer.step(&parameters, &moves);
        }
    }
    if tolerances.steps == 3 {
        check_after(&golden.rows("after", &tensors(&parameters)));
    }
    Ok(())
}

const MS_MLP: Build = |vb| Ok(Box::new(ms_areg::MsAreg::ms_mlp(64, vb)?));
const RESNET_MLP: Build = |vb| Ok(Box::new(resnet_mlp::ResnetMlp::new(64, 0.0, vb)?));
const RADIOUNET: Build = |vb| Ok(Box::new(radiounet::RadioUnet::new(64, vb)?));
const RESNET_CONV1D: Build = |vb| Ok(Box::new(resnet_conv1d::ResnetConv1d::new(64, vb)?));
const VIT_REG: Build = |vb| {
    let config = vit_reg::VitRegConfig {
        dropout: 0.0,
        ..vit_reg::VitRegConfig::PAPER
    };
    Ok(Box::new(vit_reg::VitReg::new(config, vb)?))
};

trainings! {
    training_is_pytorch_s:
    ms_mlp("ms_mlp", MS_MLP), ignore = "long: trains";
    resnet_mlp("resnet_mlp", RESNET_MLP);
    radiounet("radiounet", RADIOUNET), ignore = "long: trains";
    vit_reg("vit_reg", VIT_REG), ignore = "long: trains";
    resnet_conv1d("resnet_conv1d", RESNET_CONV1D), ignore = "long: trains";
}
