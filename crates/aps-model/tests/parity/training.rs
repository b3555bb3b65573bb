//! Three steps of training.

use std::collections::BTreeMap;
use std::sync::Mutex;

use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::models::{MsMlp, RadioUnet, ResnetConv1d, ResnetMlp, VitReg, VitRegConfig};
use aps_model::{Mode, Model, Parameters};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::golden::{Golden, Row};
use crate::optimizer::{Adam, gradients};
use crate::rule::{images, set_weights, targets};

pub fn fresh() -> Parameters {
    Parameters::new(&Device::Cpu, DType::F32, 0)
}

/// All tensors of a model, in the order of their names.
pub fn tensors(parameters: &Parameters) -> Vec<(String, Tensor)> {
    parameters
        .all()
        .into_iter()
        .map(|(name, p)| (name, p.var.as_detached_tensor()))
        .collect()
}

pub fn check_losses(golden: &[f64], found: &[f64]) {
    for (step, (e, f)) in golden.iter().zip(found).enumerate() {
        println!(
            "loss of step {step}: {f}, {:.1e} relative",
            (f / e - 1.0).abs()
        );
        assert!(
            (f - e).abs() <= 1e-4 * e,
            "loss of step {step}: {f}, not {e}"
        );
    }
    assert_eq!(golden.len(), found.len());
}

/// Norms of groups (top-level modules) to 1e-4, norms and samples of single tensors to 1e-3 of the group's size an element.
pub fn check_gradients(rows: &[Row]) {
    let mut groups: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for row in rows {
        let group = groups
            .entry(row.tensor.split('.').next().unwrap())
            .or_default();
        group.0 += row.norm.0.powi(2);
        group.1 += row.norm.1.powi(2);
    }
    for (name, (expected, found)) in &groups {
        let (expected, found) = (expected.sqrt(), found.sqrt());
        println!(
            "gradient of {name}: {found:.6}, off by {:.1e} relative",
            (found / expected - 1.0).abs()
        );
        assert!(
            (found - expected).abs() <= 1e-4 * expected,
            "gradient of {name}: {found}, not {expected}"
        );
    }
    let mut worst = 0.0_f64;
    for row in rows {
        let group = groups[row.tensor.split('.').next().unwrap()].0.sqrt();
        let slack = 1e-3 * row.norm.0 + 1e-6 * group;
        worst = worst.max((row.norm.1 - row.norm.0).abs() / slack);
        assert!(
            (row.norm.1 - row.norm.0).abs() <= slack,
            "gradient of {}: {:?}",
            row.tensor,
            row.norm
        );
        for &(e, f) in &row.samples {
            assert!(
                (f - e).abs() <= 1e-2 * row.rms + 1e-6 * group,
                "gradient of {}: {f}, not {e}",
                row.tensor
            );
        }
    }
    println!("worst norm of a tensor's gradient: {worst:.3} of what is allowed");
}

/// Norms to 1e-4 relative, samples to 1e-4 of the tensor's size an element.
///
/// `lost` names tensors without a true gradient: a bias before a batch normalisation, whose mean takes it out again. What
/// rounding leaves there Adam blows up to full steps, in PyTorch too; of these only that they moved no further than three
/// steps can is checked.
pub fn check_after(rows: &[Row], lost: &[String], lr: f64) {
    let (mut worst, mut worst_at) = (0.0_f64, "");
    for row in rows {
        let is_lost = lost.contains(&row.tensor);
        for &(e, f) in row.samples.iter().chain([&row.norm]) {
            let size = if (e, f) == row.norm {
                row.norm.0
            } else {
                row.rms
            };
            if is_lost {
                continue;
            }
            let error = (f - e).abs() / size.max(1e-30);
            if error > worst {
                (worst, worst_at) = (error, &row.tensor);
            }
        }
        if is_lost {
            for &(e, f) in &row.samples {
                assert!((f - e).abs() <= 8.0 * lr, "{}: {f}, not {e}", row.tensor);
            }
        }
    }
    println!(
        "after three steps: off by at most {worst:.1e} relative, in {worst_at}; {} tensors without gradient",
        lost.len()
    );
    assert!(worst <= 1e-4, "{worst_at}: off by {worst:e}");
}

/// Names of the tensors whose true gradient is nothing but rounding of double precision.
pub fn without_gradient(rows: &[Row]) -> Vec<String> {
    let all = rows.iter().map(|r| r.norm.0.powi(2)).sum::<f64>().sqrt();
    rows.iter()
        .filter(|r| r.norm.0 < 1e-10 * all)
        .map(|r| r.tensor.clone())
        .collect()
}

fn three_steps_are_pytorch_s(name: &str, model: &dyn Model) {
    let parameters = model.parameters();
    set_weights(parameters);
    let golden = Golden::of(name);
    let (images, targets) = (images(64), targets());
    let generator = Mutex::new(ChaCha8Rng::seed_from_u64(0));
    let mut optimizer = Adam::new(3e-4, (0.9, 0.999), 0.01);
    let mut losses = Vec::new();
    let mut lost = Vec::new();
    for step in 0..3 {
        let output = model.forward(&images, Mode::Train(&generator)).unwrap();
        let loss = (&output - &targets)
            .unwrap()
            .sqr()
            .unwrap()
            .mean_all()
            .unwrap();
        let gradients = gradients(parameters, &loss.backward().unwrap());
        if step == 0 {
            golden.check_absolute("train_64", &output, 1e-4);
            let rows = golden.rows("gradients", &gradients);
            check_gradients(&rows);
            lost = without_gradient(&rows);
        }
        optimizer.step(parameters, &gradients);
        losses.push(f64::from(loss.to_scalar::<f32>().unwrap()));
    }
    check_losses(&golden.values("losses"), &losses);
    check_after(&golden.rows("after", &tensors(parameters)), &lost, 3e-4);
}

#[test]
fn training_of_ms_mlp() {
    three_steps_are_pytorch_s("ms_mlp", &MsMlp::new(&fresh(), 64).unwrap());
}

#[test]
fn training_of_resnet_mlp() {
    three_steps_are_pytorch_s("resnet_mlp", &ResnetMlp::new(&fresh(), 64, 0.0).unwrap());
}

#[test]
fn training_of_radiounet() {
    three_steps_are_pytorch_s("radiounet", &RadioUnet::new(&fresh(), 64).unwrap());
}

#[test]
fn training_of_vit_reg() {
    let config = VitRegConfig {
        dropout: 0.0,
        ..VitRegConfig::default()
    };
    three_steps_are_pytorch_s("vit_reg", &VitReg::new(&fresh(), config).unwrap());
}

#[test]
fn training_of_resnet_conv1d() {
    three_steps_are_pytorch_s("resnet_conv1d", &ResnetConv1d::new(&fresh(), 64).unwrap());
}
