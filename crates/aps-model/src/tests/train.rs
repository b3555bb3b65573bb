//! Training: it learns, it continues bit for bit, its steps are the paper's, and it stops where it must.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use candle_core::{DType, Device, Tensor};
use candle_nn::{Optimizer, VarMap};

use super::{builder, conditions, flat, on_threads};
use crate::condition::{ConditionImages, Link, ModelInput};
use crate::data::{Examples, Samples};
use crate::models::ms_areg::MsAreg;
use crate::models::resnet_mlp::ResnetMlp;
use crate::optim::AdamW;
use crate::train::{TrainConfig, TrainError, Trainer, predict};
use crate::{ANGLE_BINS, Error, Loss, Model, Regularizer, loss, trainable};

const SIZE: usize = 32;
/// Channels of the first stage; the paper's models have 64.
const WIDTH: usize = 4;

pub fn input() -> ConditionImages {
    let pixel = |i: usize| f32::from(i % 37 < 9);
    let pixels: Vec<f32> = (0..2 * SIZE * SIZE).map(pixel).collect();
    conditions(&pixels, SIZE, 8.0, SIZE)
}

fn link(i: usize) -> Link {
    let place = |k: usize| ((i * k + 5) % 29 * 9) as f64;
    Link {
        map: i as u32 % 2,
        tx_m: [place(7), place(11)],
        rx_m: [place(13), place(17)],
    }
}

/// A lobe whose place follows from the link.
fn target(i: usize) -> Vec<f32> {
    let Link { tx_m, rx_m, .. } = link(i);
    let centre = (rx_m[1] - tx_m[1]).atan2(rx_m[0] - tx_m[0]).to_degrees() / 2.0 + 90.0;
    let lobe = |bin: usize| 3.0 * (-0.002 * (bin as f64 - centre).powi(2)).exp() - 0.3;
    (0..ANGLE_BINS).map(|bin| lobe(bin) as f32).collect()
}

pub fn samples(n: usize) -> Samples {
    let targets = (0..n).flat_map(target).collect();
    Samples::new((0..n).map(link).collect(), targets).unwrap()
}

pub fn resnet_mlp(width: usize) -> (Box<dyn Model>, VarMap) {
    let parameters = VarMap::new();
    let model = ResnetMlp::new(width, 0.1, builder(&parameters, DType::F32, 1)).unwrap();
    (Box::new(model), parameters)
}

fn ms_areg() -> (Box<dyn Model>, VarMap) {
    let parameters = VarMap::new();
    let model = MsAreg::new(WIDTH, builder(&parameters, DType::F32, 1)).unwrap();
    (Box::new(model), parameters)
}

fn regularizer() -> (Regularizer, VarMap) {
    let parameters = VarMap::new();
    let regularizer = Regularizer::new(WIDTH, builder(&parameters, DType::F32, 2)).unwrap();
    (regularizer, parameters)
}

pub fn regression_config() -> TrainConfig {
    TrainConfig {
        epochs: 2,
        batch: 4,
        learning_rate: 3e-3,
        ..TrainConfig::regression()
    }
}

pub fn adversarial_config() -> TrainConfig {
    TrainConfig {
        epochs: 2,
        batch: 4,
        ..TrainConfig::adversarial()
    }
}

fn trainer(
    (model, parameters): (Box<dyn Model>, VarMap),
    examples: impl Examples + 'static,
    config: TrainConfig,
) -> Trainer {
    let (input, examples) = (Box::new(input()), Box::new(examples));
    Trainer::new(model, &parameters, Loss::Squared, input, examples, config).unwrap()
}

pub fn regression(examples: impl Examples + 'static, config: TrainConfig) -> Trainer {
    trainer(resnet_mlp(WIDTH), examples, config)
}

pub fn adversarial(examples: impl Examples + 'static, config: TrainConfig) -> Trainer {
    let (regularizer, parameters) = regularizer();
    let trainer = trainer(ms_areg(), examples, config);
    trainer.with_regularizer(regularizer, &parameters).unwrap()
}

fn steps(trainer: &mut Trainer, n: usize) -> Vec<f64> {
    let step = |_| trainer.step().unwrap().expect("a step is left").loss;
    (0..n).map(step).collect()
}

/// Returns the whole state of a training as bytes.
fn state(trainer: &mut Trainer, folder: &Path) -> Vec<u8> {
    let path = folder.join("state.safetensors");
    trainer.save(&path, "").unwrap();
    fs::read(path).unwrap()
}

/// Builds a trainer of some examples, after a change of its settings.
type Setup = fn(Spoilt, fn(&mut TrainConfig)) -> Trainer;
const SETUPS: [Setup; 2] = [
    |examples, change| regression(examples, changed(regression_config(), change)),
    |examples, change| adversarial(examples, changed(adversarial_config(), change)),
];

fn changed(mut config: TrainConfig, change: fn(&mut TrainConfig)) -> TrainConfig {
    change(&mut config);
    config
}

fn sound(n: usize) -> Spoilt {
    Spoilt {
        samples: samples(n),
        example: n,
        value: 0.0,
    }
}

#[test]
fn continued_run_equals_uninterrupted_one_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("last.safetensors");
    for setup in SETUPS {
        // 14 examples, 4 a batch: 3 steps an epoch. Stopped within the first epoch, at its end, within the second.
        let trainer = || setup(sound(14), |_| ());
        let mut straight = trainer();
        let losses = steps(&mut straight, 6);
        assert!(straight.step().unwrap().is_none(), "two epochs are over");
        let expected = state(&mut straight, folder.path());
        for stop in [2, 3, 5] {
            let mut stopped = trainer();
            steps(&mut stopped, stop);
            stopped.save(&path, "notes of the caller").unwrap();
            drop(stopped);
            let mut resumed = trainer();
            assert_eq!(resumed.resume(&path).unwrap(), "notes of the caller");
            assert_eq!(resumed.steps_done(), stop as u64);
            assert_eq!(steps(&mut resumed, 6 - stop), losses[stop..]);
            let is_same = state(&mut resumed, folder.path()) == expected;
            assert!(is_same, "stopped after {stop}");
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for setup in SETUPS {
        let trained = || {
            let mut trainer = setup(sound(8), |_| ());
            steps(&mut trainer, 3);
            state(&mut trainer, folder.path())
        };
        assert!(on_threads(1, trained) == on_threads(3, trained));
    }
}

#[test]
fn a_few_links_are_learnt_by_heart() {
    for setup in SETUPS {
        let mut trainer = setup(sound(8), |config| {
            config.epochs = 100;
            config.learning_rate = 3e-3;
        });
        let losses = steps(&mut trainer, 200);
        let (first, last) = (losses[0], losses[198..].iter().sum::<f64>() / 2.0);
        assert!(last < 0.4 * first, "{first} to {last}");
    }
}

/// The paper's equations written down plainly: three full passes of the regularizer, nothing shared, nothing detached but
/// the prediction.
#[test]
fn adversarial_step_is_the_papers_equations() {
    let config = adversarial_config();
    let (network, of_regularizer) = regularizer();
    let mut trainer = trainer(ms_areg(), samples(4), config.clone())
        .with_regularizer(network, &of_regularizer)
        .unwrap();
    let report = trainer.step().unwrap().unwrap();
    let found = [trainer.parameters(), &of_regularizer];

    let ((predictor, of_predictor), (regularizer, of_regularizer)) = (ms_areg(), regularizer());
    let links: Vec<Link> = (0..4).map(link).collect();
    let images = input().batch(&links).unwrap();
    let truth: Vec<f32> = (0..4).flat_map(target).collect();
    let truth = Tensor::from_vec(truth, (4, ANGLE_BINS), &Device::Cpu).unwrap();
    let bce = |score: Tensor, label: f64| {
        let label = (score.zeros_like().unwrap() + label).unwrap();
        loss::bce_with_logits(&score, &label).unwrap()
    };
    let update = |loss: &Tensor, parameters: &VarMap| {
        let vars = trainable(parameters).into_iter().map(|(_, var)| var);
        let params = config.optimizer.with_rate(report.learning_rate);
        let mut optimizer = AdamW::new(vars.collect(), params).unwrap();
        optimizer.backward_step_clipped(loss, 1.0).unwrap()
    };
    let predicted = predictor.forward_t(&images, true).unwrap();
    let score = |spectra: &Tensor| {
        let encoded = regularizer.encode(&images, true).unwrap();
        regularizer.score(&encoded, spectra).unwrap()
    };
    let (real, fake) = (score(&truth), score(&predicted.detach()));
    let regularizer_loss = (bce(real, 1.0) + bce(fake, 0.0)).unwrap();
    let regularizer_norm = update(&regularizer_loss, &of_regularizer);
    let l1 = loss::l1(&predicted, &truth).unwrap();
    let whole = (bce(score(&predicted), 1.0) + (&l1 * 100.0).unwrap()).unwrap();
    let norm = update(&whole, &of_predictor);

    for (found, expected) in [
        (report.loss, flat(&l1)[0]),
        (report.regularizer_loss.unwrap(), flat(&regularizer_loss)[0]),
        (report.gradient_norm, norm),
        (report.regularizer_gradient_norm.unwrap(), regularizer_norm),
    ] {
        let is_close = (found - expected).abs() <= 1e-4 * expected.abs();
        assert!(is_close, "{found} is not {expected}");
    }
    let plain = [&of_predictor, &of_regularizer];
    let initial = [ms_areg().1, self::regularizer().1];
    for ((found, plain), initial) in found.iter().zip(plain).zip(&initial) {
        let (mut moved, mut apart) = (0.0, 0.0);
        let plain = trainable(plain).into_iter().zip(trainable(initial));
        for ((_, a), ((_, b), (_, initial))) in trainable(found).iter().zip(plain) {
            moved += distance(a, &initial);
            apart += distance(a, &b);
        }
        // Adam's first step has the size of the rate whatever the gradient's size: rounding of gradients near zero shows.
        let is_near = moved > 0.0 && apart < 1e-2 * moved;
        assert!(is_near, "{apart} apart after moving by {moved}");
    }
}

fn distance(a: &Tensor, b: &Tensor) -> f64 {
    flat(&(a - b).unwrap().abs().unwrap().sum_all().unwrap())[0]
}

/// Examples of which one has a target that no label can have.
#[derive(Debug)]
struct Spoilt {
    samples: Samples,
    example: usize,
    value: f32,
}

impl Examples for Spoilt {
    fn len(&self) -> usize {
        self.samples.len()
    }

    fn link(&self, example: usize) -> Link {
        self.samples.link(example)
    }

    fn write_target(&self, example: usize, target: &mut [f32]) {
        self.samples.write_target(example, target);
        if example == self.example {
            target[17] = self.value;
        }
    }
}

#[test]
fn bad_label_stops_the_run_and_is_named_with_the_last_good_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("last.safetensors");
    for setup in SETUPS {
        for value in [f32::NAN, f32::INFINITY, 1e9] {
            let spoilt = Spoilt {
                example: 9,
                value,
                ..sound(12)
            };
            let mut trainer = setup(spoilt, |_| ());
            let error = loop {
                trainer.save(&path, "").unwrap();
                match trainer.step() {
                    Ok(report) => assert!(report.is_some(), "an epoch has every example"),
                    Err(error) => break error,
                }
            };
            let text = error.to_string();
            let TrainError::Diverged {
                step,
                quantity,
                links,
                checkpoint,
                ..
            } = error
            else {
                panic!("{error}");
            };
            assert_eq!((step, quantity), (trainer.steps_done(), "the loss"));
            assert_eq!(links[0], (9, link(9)), "the worst link comes first");
            assert_eq!(checkpoint.as_ref(), Some(&path));
            for told in ["example 9", "last.safetensors"] {
                assert!(text.contains(told), "{text}");
            }

            assert!(matches!(trainer.step(), Err(TrainError::Failed)));
            assert!(matches!(trainer.save(&path, ""), Err(TrainError::Failed)));
            trainer.resume(&path).unwrap();
            // What is left is the good checkpoint.
            assert_eq!(trainer.steps_done(), step);
        }
    }
}

#[test]
fn foreign_or_damaged_checkpoint_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("last.safetensors");
    let mut source = regression(samples(8), regression_config());
    steps(&mut source, 2);
    source.save(&path, "").unwrap();
    let good = fs::read(&path).unwrap();

    let mut own = regression(samples(8), regression_config());
    let before = state(&mut own, folder.path());
    let mut unreadable = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        match own.resume(&path) {
            Err(TrainError::Checkpoint { problem, .. }) => problem,
            other => panic!("{other:?}"),
        }
    };
    let (shorter, foreign) = (&good[..good.len() - 1], b"not safetensors at all");
    for bytes in [shorter, &good[..100], b"", foreign] {
        let length = bytes.len();
        assert!(unreadable(bytes).contains("damaged"), "{length} bytes");
    }
    let mut renamed = good.clone();
    let name = b"head.0.bias\"";
    let mut places = (0..good.len()).filter(|&i| good[i..].starts_with(name));
    let (first, second) = (places.next(), places.next());
    assert_eq!(second, None);
    renamed[first.unwrap() + 5] = b'9';
    assert!(unreadable(&renamed).contains("head."));
    for (name, value, told) in [
        ("predictor.head.0.bias", f32::NAN, "not finite"),
        (
            "predictor.optimizer.head.0.bias.first",
            f32::INFINITY,
            "not finite",
        ),
        ("predictor.optimizer.head.0.bias.second", -1.0, "below 0"),
        ("predictor.encoder.bn1.running_var", -1.0, "below 0"),
    ] {
        let tensors = safetensors::SafeTensors::deserialize(&good).unwrap();
        let data = tensors.tensor(name).unwrap().data();
        let at = data.as_ptr() as usize - good.as_ptr() as usize;
        let mut bad = good.clone();
        bad[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let problem = unreadable(&bad);
        assert!(
            problem.contains(name) && problem.contains(told),
            "{problem}"
        );
    }
    assert!(state(&mut own, folder.path()) == before);

    fs::write(&path, &good).unwrap();
    let refused = |mut trainer: Trainer| {
        let problem = trainer.resume(&path).unwrap_err().to_string();
        assert!(problem.contains("last.safetensors"), "{problem}");
        problem
    };
    let config = regression_config;
    let other_seed = changed(config(), |config| config.seed = 7);
    assert!(refused(regression(samples(8), other_seed)).contains("seed"));
    assert!(refused(regression(samples(9), config())).contains("examples"));
    let wider = trainer(resnet_mlp(2 * WIDTH), samples(8), config());
    assert!(refused(wider).contains("shape"));
    let (network, parameters) = regularizer();
    let more = regression(samples(8), config()).with_regularizer(network, &parameters);
    assert!(refused(more.unwrap()).contains("missing"));

    let missing = own.resume(folder.path().join("nothing"));
    assert!(matches!(
        missing,
        Err(TrainError::Model(Error::WeightsIo { .. }))
    ));
    let nowhere = own.save(folder.path().join("no/folder/file"), "");
    assert!(matches!(
        nowhere,
        Err(TrainError::Model(Error::WeightsIo { .. }))
    ));
}

/// A training of at most ten seconds; the clock moves by a second a step, and whenever the test says so.
fn timed(clock: &Arc<AtomicU64>) -> Trainer {
    let config = TrainConfig {
        budget_s: Some(10.0),
        ..regression_config()
    };
    let clock = Arc::clone(clock);
    trainer(resnet_mlp(WIDTH), samples(8), config)
        .with_clock(move || Duration::from_secs(clock.load(Ordering::Relaxed)))
}

#[test]
fn time_ends_a_training_and_a_continued_one_gets_what_is_left() {
    let clock = Arc::new(AtomicU64::new(1000));
    let wait = |seconds| clock.fetch_add(seconds, Ordering::Relaxed);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("last.safetensors");
    let mut first = timed(&clock);
    first.spend(Duration::from_secs(2));
    assert_eq!((first.steps_total(), first.share()), (None, 0.2));
    wait(5);
    assert_eq!(first.share(), 0.2, "time counts from the first step on");
    for step in 0..3 {
        assert_eq!(first.step().unwrap().unwrap().step, step);
        wait(1);
    }
    first.save(&path, "").unwrap();
    wait(3600);
    assert_eq!(first.share(), 1.0);
    assert!(first.step().unwrap().is_none(), "its time is over");

    let mut second = timed(&clock);
    second.resume(&path).unwrap();
    assert_eq!((second.seconds(), second.share()), (5.0, 0.5));
    let mut rates = Vec::new();
    while let Some(report) = second.step().unwrap() {
        rates.push(report.learning_rate);
        wait(1);
    }
    assert_eq!((second.steps_done(), rates.len()), (8, 5));
    assert!(rates.is_sorted_by(|a, b| a > b), "{rates:?}");
    // Not even one step that would begin at the end.
    assert!(second.step().unwrap().is_none());
}

#[test]
fn settings_that_cannot_train_are_refused() {
    let attempt = |parameters: &VarMap, samples: Samples, config| {
        let (model, _) = resnet_mlp(WIDTH);
        let (input, samples) = (Box::new(input()), Box::new(samples));
        Trainer::new(model, parameters, Loss::Squared, input, samples, config)
    };
    let (_, parameters) = resnet_mlp(WIDTH);
    let refused = |change: fn(&mut TrainConfig)| {
        let config = changed(regression_config(), change);
        match attempt(&parameters, samples(4), config) {
            Err(TrainError::Config(problem)) => problem,
            other => panic!("{:?}", other.err()),
        }
    };
    assert!(refused(|c| c.epochs = 0).contains("epochs"));
    assert!(refused(|c| c.batch = 0).contains("batch"));
    assert!(refused(|c| c.budget_s = Some(0.0)).contains("budget_s"));
    assert!(refused(|c| c.budget_s = Some(f64::INFINITY)).contains("budget_s"));
    assert!(refused(|c| c.learning_rate = f64::NAN).contains("learning_rate"));
    assert!(refused(|c| c.clip_norm = -1.0).contains("clip_norm"));
    assert!(refused(|c| c.optimizer.beta1 = 1.0).contains("beta1"));
    let none = attempt(&parameters, Samples::default(), regression_config());
    assert!(matches!(none, Err(TrainError::Config(problem)) if problem.contains("no example")));
    let foreign = attempt(&VarMap::new(), samples(4), regression_config());
    assert!(matches!(foreign, Err(TrainError::Config(problem)) if problem.contains("trainable")));
    assert!(Samples::new(vec![link(0)], vec![0.0; 179]).is_err());
    assert!(Samples::new(vec![link(0)], vec![f32::NAN; 180]).is_err());
}

#[test]
fn predictions_do_not_depend_on_the_batch_and_damaged_weights_are_told() {
    let (model, parameters) = resnet_mlp(WIDTH);
    let run = |batch| {
        let mut all = Vec::new();
        let take = |first: usize, spectra: &[f32]| {
            assert_eq!(first * ANGLE_BINS, all.len());
            all.extend_from_slice(spectra);
            Ok::<(), TrainError>(())
        };
        predict(&*model, &input(), (0..7).map(link), batch, take).map(|()| all)
    };
    let (three, seven) = (run(3).unwrap(), run(7).unwrap());
    assert_eq!(three.len(), 7 * ANGLE_BINS);
    for (a, b) in three.iter().zip(&seven) {
        assert!((a - b).abs() < 1e-5, "{a} is not {b}");
    }
    // Before a rectifier, which must not hide it.
    let all = trainable(&parameters);
    let (_, bias) = all.iter().find(|(name, _)| name == "head.0.bias").unwrap();
    let spoilt = (bias.ones_like().unwrap() * f64::NAN).unwrap();
    bias.set(&spoilt).unwrap();
    let told = run(3);
    assert!(matches!(told, Err(TrainError::Prediction { link: 0, .. })));
}
