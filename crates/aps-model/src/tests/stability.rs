//! Training at the edges of its numbers: each case says what it expects and why.

use candle_core::{DType, Device, Tensor, Var};
use candle_nn::VarMap;

use super::{builder, conditions, flat as values};
use crate::condition::Link;
use crate::data::Samples;
use crate::models::resnet_mlp::ResnetMlp;
use crate::ops::{self, BatchNormTensors};
use crate::optim::clip_factor;
use crate::train::{TrainConfig, TrainError, Trainer};
use crate::{ANGLE_BINS, Loss, loss, trainable};

const DEVICE: &Device = &Device::Cpu;

/// At +-10^4 the sigmoid is 0 or 1 to more digits than any float has: the loss of a wrong answer is the logit itself, of a
/// right one 0, and the gradients are exactly -1, 0 and 1. The textbook's ln(sigmoid(x)) would be infinite.
#[test]
fn cross_entropy_of_logits_of_ten_thousand() {
    for (logit, target, expected, slope) in [
        (1e4_f32, 1.0_f32, 0.0, 0.0),
        (1e4, 0.0, 1e4, 1.0),
        (-1e4, 1.0, 1e4, -1.0),
        (-1e4, 0.0, 0.0, 0.0),
    ] {
        let x = Var::new(&[logit], DEVICE).unwrap();
        let target = Tensor::new(&[target], DEVICE).unwrap();
        let y = loss::bce_with_logits(&x, &target).unwrap();
        assert_eq!(f64::from(y.to_scalar::<f32>().unwrap()), expected);
        assert_eq!(values(y.backward().unwrap().get(&x).unwrap()), [slope]);
    }
}

/// Between them the f32 loss stays within rounding of the f64 formula ln(1 + e^x) - t x, and is nowhere negative.
#[test]
fn cross_entropy_between_the_extremes() {
    let mut worst: f64 = 0.0;
    for i in -400..=400 {
        let x = f64::from(i) * 0.25;
        for t in [0.0, 0.25, 1.0] {
            let logit = Tensor::new(&[x as f32], DEVICE).unwrap();
            let target = Tensor::new(&[t as f32], DEVICE).unwrap();
            let y = loss::bce_with_logits(&logit, &target).unwrap();
            let found = f64::from(y.to_scalar::<f32>().unwrap());
            let expected = x.max(0.0) - t * x + (-x.abs()).exp().ln_1p();
            assert!(found >= 0.0);
            // Relative to the terms, of which the largest rounds the sum.
            worst = worst.max((found - expected).abs() / expected.max(1.0));
        }
    }
    println!("worst error {worst:.1e}");
    assert!(worst < 3e-7, "{worst:e}");
}

fn trainer(batch: usize, size: usize, target: f32, change: impl Fn(&mut TrainConfig)) -> Trainer {
    try_trainer(batch, size, target, change).unwrap()
}

fn try_trainer(
    batch: usize,
    size: usize,
    target: f32,
    change: impl Fn(&mut TrainConfig),
) -> Result<Trainer, TrainError> {
    let input = Box::new(conditions(&[0.0; 64 * 64], 64, 1.0, size));
    let link = |i: usize| Link {
        map: 0,
        tx_m: [(5 * i % 64) as f64, 20.0],
        rx_m: [40.0, (7 * i % 64) as f64],
    };
    let links: Vec<Link> = (0..8).map(link).collect();
    let targets = vec![target; links.len() * ANGLE_BINS];
    let parameters = VarMap::new();
    let model = ResnetMlp::new(4, 0.1, builder(&parameters, DType::F32, 1)).unwrap();
    let mut config = TrainConfig {
        epochs: 10,
        batch,
        ..TrainConfig::regression()
    };
    change(&mut config);
    let samples = Box::new(Samples::new(links, targets).unwrap());
    Trainer::new(
        Box::new(model),
        &parameters,
        Loss::Squared,
        input,
        samples,
        config,
    )
}

fn weights(trainer: &Trainer) -> Vec<f64> {
    let all = trainable(trainer.parameters());
    all.iter().flat_map(|(_, var)| values(var)).collect()
}

/// A batch of one has a variance over the pixels of its image, as long as there are two of them: 64 px leave 2 x 2 behind
/// the last stage. At 32 px a single pixel is left, whose variance says nothing: an error that names the remedy, where
/// dividing by n - 1 would have made a NaN.
#[test]
fn batch_of_one() {
    let mut large = trainer(1, 64, 0.5, |_| ());
    for _ in 0..3 {
        assert!(large.step().unwrap().unwrap().loss.is_finite());
    }
    match trainer(1, 32, 0.5, |_| ()).step() {
        Err(TrainError::Model(error)) => {
            let (text, told) = (
                error.to_string(),
                "[1, 32, 1, 1]; use a batch of two or more",
            );
            assert!(text.contains(told), "{text}");
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
}

/// Targets without any variation are learnt like others; the loss falls and stays a number.
#[test]
fn constant_targets() {
    for target in [0.0, -0.45, 3.4] {
        let mut trainer = trainer(4, 32, target, |c| c.learning_rate = 3e-3);
        let reports = std::iter::from_fn(|| trainer.step().unwrap());
        let losses: Vec<f64> = reports.map(|report| report.loss).collect();
        let (first, last) = (losses[0], losses[losses.len() - 1]);
        assert!(losses.iter().all(|loss| loss.is_finite()));
        assert!(last < first, "{first} to {last}");
    }
}

/// A learning rate a billion times too high is noticed at once, and the run stops with the step and the quantity.
#[test]
fn learning_rate_too_high() {
    let mut trainer = trainer(4, 32, 0.5, |c| {
        c.learning_rate = 1e6;
        c.warmup_steps = 0;
    });
    let error = loop {
        match trainer.step() {
            Ok(report) => assert!(report.is_some(), "the run should have been stopped"),
            Err(error) => break error,
        }
    };
    println!("{error}");
    let quantities = ["the loss", "the gradient's norm"];
    assert!(
        matches!(error, TrainError::Diverged { step: ..=3, quantity, .. } if quantities.contains(&quantity))
    );
}

/// Channels without variance, at any height, are normalised to exactly their bias: the deviation is the epsilon's, and
/// nothing is divided by zero. The gradient by the input is zero but for the rounding of the two terms that cancel, since
/// shifting all values changes no output.
#[test]
fn normalising_constant_channels() {
    for height in [0.0, 1.0, -3e4, 1e-30, 3e18] {
        let full = |v: f64, shape: &[usize]| {
            let tensor = Tensor::full(v as f32, shape, DEVICE).unwrap();
            Var::from_tensor(&tensor).unwrap()
        };
        let x = full(height, &[3, 2, 4, 4]);
        let vector = |v: f64| full(v, &[2]);
        let (weight, bias) = (vector(1.5), vector(0.25));
        let (mean, var) = (vector(0.0), vector(1.0));
        let tensors = BatchNormTensors {
            weight: weight.as_tensor(),
            bias: bias.as_tensor(),
            running_mean: &mean,
            running_var: &var,
        };
        let y = ops::batch_norm(&x, tensors, true, false).unwrap();
        assert!(values(&y).iter().all(|&v| v == 0.25), "at {height}");
        let gradients = y.sqr().unwrap().sum_all().unwrap().backward().unwrap();
        let by_input = values(gradients.get(&x).unwrap());
        let terms = 1.5 / 1e-5_f64.sqrt() * 2.0 * 0.25;
        let bound = 2.0 * f64::from(f32::EPSILON) * terms;
        let worst = by_input.iter().fold(0.0_f64, |w, g| w.max(g.abs()));
        assert!(worst <= bound, "at {height}: {worst:e}, bound {bound:e}");
        let expected = 0.1 * height;
        for found in values(&mean) {
            assert!((found - expected).abs() <= 1e-6 * expected.abs());
        }
        assert!(values(&var).iter().all(|&v| (v - 0.9).abs() < 1e-7));
    }
}

/// Clipping at infinity clips nothing: the same weights, to the bit, as with a limit never reached. Clipping at 0 would
/// never move a weight: it is refused, as are NaN and negative limits.
#[test]
fn clipping_at_infinity_and_at_zero() {
    let after = |clip: f64| {
        let mut trainer = trainer(4, 32, 0.5, |c| c.clip_norm = clip);
        trainer.step().unwrap();
        weights(&trainer)
    };
    assert_eq!(after(f64::INFINITY), after(1e30));
    assert_ne!(after(f64::INFINITY), after(1e-12));
    assert_eq!(clip_factor(5.0, f64::INFINITY), 1.0);
    assert_eq!(clip_factor(0.0, f64::INFINITY), 1.0);
    assert_eq!(clip_factor(5.0, 0.0), 0.0);
    for bad in [0.0, -1.0, f64::NAN] {
        let refused = try_trainer(4, 32, 0.5, |c| c.clip_norm = bad);
        let is_told = matches!(refused, Err(TrainError::Config(_)));
        assert!(is_told, "clip_norm {bad}");
    }
}

/// JSON has no word for infinity: the checkpoint of such a training tells it all the same, and tells it from a number.
#[test]
fn a_training_that_clips_nothing_is_continued() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("last.safetensors");
    let at = |clip: f64| trainer(4, 32, 0.5, |c| c.clip_norm = clip);
    let mut stopped = at(f64::INFINITY);
    stopped.step().unwrap();
    stopped.save(&path, "").unwrap();
    let mut resumed = at(f64::INFINITY);
    resumed.resume(&path).unwrap();
    assert_eq!(resumed.steps_done(), 1);
    let problem = at(1.0).resume(&path).unwrap_err().to_string();
    assert!(
        problem.contains("clip_norm = null, now it is 1.0"),
        "{problem}"
    );
}
