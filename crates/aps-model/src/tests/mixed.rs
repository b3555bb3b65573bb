//! Mixed precision: products of bf16 that sum in f32, weights and losses in f32.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use candle_core::{DType, Device, Tensor};
use candle_nn::VarMap;

use super::train::{
    adversarial, adversarial_config, input, regression, regression_config, resnet_mlp, samples,
};
use super::{WAYS, builder, flat, shape_of, some_ways};
use crate::condition::{ConditionImages, InputShape, Link, ModelInput};
use crate::ops::as_on_a_device;
use crate::parameters::sorted;
use crate::train::{Precision, TrainConfig, Trainer};
use crate::{ANGLE_BINS, LabelFacts, Loss, ModelKind, Preset};

const LINKS: usize = 16;

/// Values from 0 to 1 that follow from their place.
fn pattern(shape: &[usize]) -> Tensor {
    let count = shape.iter().product::<usize>() as u64;
    let value = |i: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32 / (1 << 24) as f32;
    let values: Vec<f32> = (0..count).map(value).collect();
    Tensor::from_vec(values, shape, &Device::Cpu).unwrap()
}

/// Spectra in use, and gradients of all weights in training, as one list.
fn computed(kind: ModelKind, precision: Precision) -> [Vec<f64>; 2] {
    let parameters = VarMap::new();
    let shape = shape_of(kind);
    let input = match shape {
        InputShape::Images => pattern(&[LINKS, 3, 64, 64]),
        InputShape::Polar(_) => some_ways(LINKS, 220),
    };
    let vb = builder(&parameters, DType::F32, 3);
    let model = kind.build(Preset::Small, shape, vb).unwrap();
    let facts = LabelFacts {
        array: flat(&pattern(&[ANGLE_BINS, WAYS.directions])),
        mean: 0.1,
        deviation: 0.2,
        is_by_link: false,
    };
    facts.set(&parameters).unwrap();
    let input = precision.of_input(&input, shape).unwrap();
    let used = model.forward_t(&input, false).unwrap();
    model.seed_dropout(1, 1);
    let predicted = model.forward_t(&input, true).unwrap();
    let predicted = predicted.to_dtype(DType::F32).unwrap();
    let targets = pattern(&[LINKS, ANGLE_BINS]);
    let loss = Loss::Squared.error(&predicted, &targets).unwrap();
    let store = loss.backward().unwrap();
    let all = sorted(&parameters);
    let gradients = all.iter().filter_map(|(_, var)| store.get(var));
    let gradients = gradients.flat_map(|gradient| {
        assert_eq!(gradient.dtype(), DType::F32);
        flat(gradient)
    });
    [flat(&used), gradients.collect()]
}

/// Distance of two lists over the length of the second.
fn apart(found: &[f64], expected: &[f64]) -> f64 {
    let length = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let difference = length(&mut found.iter().zip(expected).map(|(f, e)| f - e));
    difference / length(&mut expected.iter().copied())
}

/// PyTorch's own differences, of spectra and of gradients, as `tests/golden/mixed.py` prints them. Gradients of random weights are far
/// apart where a ReLU of few channels or a maximum decides.
const PYTORCH_S: [(ModelKind, f64, f64); 7] = [
    (ModelKind::MsAreg, 2.3e-3, 3.9e-2),
    (ModelKind::MsMlp, 2.2e-3, 4.7e-2),
    (ModelKind::AdvMlp, 2.4e-3, 2.3e-1),
    (ModelKind::ResnetMlp, 2.5e-3, 3.1e-1),
    (ModelKind::RadioUnet, 2.9e-3, 8.6e-3),
    (ModelKind::VitReg, 9.3e-3, 7.6e-3),
    (ModelKind::ResnetConv1d, 2.6e-3, 2.3e-2),
];

/// Compares mixed precision, by the CPU's loops and by the operations of a device, with the CPU's loops in f32, and those operations in
/// f32 too: spectra of each network, gradients of all weights.
fn are_as_near_those_of_f32_as_pytorch_s(kinds: &[ModelKind]) {
    for &kind in kinds {
        let full = computed(kind, Precision::Full);
        let is_near = |way: &str, found: &[Vec<f64>; 2], bounds: [f64; 2]| {
            let off = [0, 1].map(|i| apart(&found[i], &full[i]));
            let [of_spectra, of_gradients] = off;
            println!(
                "{kind}, {way}: spectra off by {of_spectra:.1e}, gradients by {of_gradients:.1e}"
            );
            assert!(
                of_spectra < bounds[0] && of_gradients < bounds[1],
                "{kind}, {way}: {off:?}"
            );
        };
        let on_a_device = |precision| as_on_a_device(|| computed(kind, precision));
        // Rounding decides a ReLU here and there.
        is_near("device", &on_a_device(Precision::Full), [1e-5, 1e-2]);
        let of_torch = PYTORCH_S.iter().find(|(of, ..)| *of == kind);
        if let Some(&(_, spectra, gradients)) = of_torch {
            // Other weights are drawn there.
            let bounds = [3.0 * spectra, 2.0 * gradients];
            is_near("mixed, CPU", &computed(kind, Precision::Mixed), bounds);
            is_near("mixed, device", &on_a_device(Precision::Mixed), bounds);
        }
    }
}

// Two tests, for two threads.
#[test]
fn first_models_are_as_near_those_of_f32_as_pytorch_s() {
    are_as_near_those_of_f32_as_pytorch_s(&ModelKind::ALL[..3]);
}

#[test]
fn other_models_are_as_near_those_of_f32_as_pytorch_s() {
    are_as_near_those_of_f32_as_pytorch_s(&ModelKind::ALL[3..]);
}

/// The numbers of directions have no room in bf16.
#[test]
fn polar_reg_stays_in_f32() {
    let [full, mixed] = Precision::ALL.map(|precision| computed(ModelKind::PolarReg, precision));
    assert_eq!(full, mixed);
}

/// Losses of all steps.
fn losses(mut trainer: Trainer) -> Vec<f64> {
    let mut losses = Vec::new();
    while let Some(report) = trainer.step().unwrap() {
        losses.push(report.loss);
        losses.extend(report.regularizer_loss);
    }
    let weights = trainer.parameters().all_vars();
    assert!(weights.iter().all(|var| var.dtype() != DType::BF16));
    losses
}

#[test]
fn training_goes_the_way_of_f32() {
    let mixed = |config: TrainConfig| TrainConfig {
        precision: Precision::Mixed,
        ..config
    };
    let [full, half] = [regression_config(), mixed(regression_config())]
        .map(|config| losses(regression(samples(16), config)));
    let [of_full, of_half] = [adversarial_config(), mixed(adversarial_config())]
        .map(|config| losses(adversarial(samples(16), config)));
    for (full, half) in [(full, half), (of_full, of_half)] {
        assert!(full != half && full.len() == half.len());
        let worst = full.iter().zip(&half).map(|(f, h)| (h / f - 1.0).abs());
        let worst = worst.fold(0.0, f64::max);
        println!("losses off by {worst:.1e} at most");
        assert!(worst < 0.05, "{full:?} {half:?}");
    }
}

/// Only the rounding of the targets to half precision differs.
#[test]
fn targets_on_the_device_are_those_of_the_host() {
    let host = losses(regression(samples(16), regression_config()));
    let device = regression(samples(16), regression_config()).hold();
    let device = losses(device.unwrap());
    assert!(host != device && host.len() == device.len());
    // Of the first step, before weights differ.
    assert!((device[0] / host[0] - 1.0).abs() < 1e-3);
    let worst = host.iter().zip(&device).map(|(h, d)| (d / h - 1.0).abs());
    assert!(worst.fold(0.0, f64::max) < 0.02, "{host:?} {device:?}");
}

/// Counts the links that it is asked to hold.
#[derive(Debug)]
struct Held(ConditionImages, Arc<AtomicUsize>);

impl ModelInput for Held {
    fn batch(&self, links: &[Link]) -> crate::Result<Tensor> {
        self.0.batch(links)
    }

    fn hold(&self, links: &mut dyn Iterator<Item = Link>) -> crate::Result<bool> {
        self.1.fetch_add(links.count(), Ordering::Relaxed);
        Ok(true)
    }

    fn device(&self) -> &Device {
        self.0.device()
    }
}

#[test]
fn the_input_of_all_examples_is_held_with_their_targets() {
    let count = Arc::default();
    let held = Box::new(Held(input(), Arc::clone(&count)));
    let (model, parameters) = resnet_mlp(8);
    let examples = Box::new(samples(16));
    let trainer = Trainer::new(
        model,
        &parameters,
        Loss::Squared,
        held,
        examples,
        regression_config(),
    );
    let held = trainer.unwrap().hold().unwrap().held();
    assert!(held.input && held.targets);
    assert_eq!(count.load(Ordering::Relaxed), 16);
}

#[test]
fn settings_of_before_are_of_full_precision() {
    let mut stored = serde_json::to_value(TrainConfig::regression()).unwrap();
    assert_eq!(stored["precision"], "full");
    stored.as_object_mut().unwrap().remove("precision");
    let read: TrainConfig = serde_json::from_value(stored).unwrap();
    assert_eq!(read, TrainConfig::regression());
}
