//! Training: it learns, it continues bit for bit, it does what the recipe says, and it stops where it must.

use std::fs;
use std::path::Path;
use std::sync::Mutex;

use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::condition::{ConditionConfig, Conditions, Link, Rasters};
use aps_model::data::{Examples, Samples};
use aps_model::models::{MsAreg, ResnetMlp};
use aps_model::optim::{Adam, clip_factor, gradient_norm};
use aps_model::train::{Quantity, TrainConfig, TrainError, Trainees, Trainer, predict};
use aps_model::{ANGLE_BINS, Mode, Model, Parameters, Regularizer, loss};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const SIZE: usize = 32;
/// Channels of the first stage; the paper's models have 64.
const WIDTH: usize = 4;

fn conditions() -> Conditions {
    let pixels: Vec<f32> = (0..2 * SIZE * SIZE)
        .map(|i| f32::from(u8::from(i % 37 < 9)))
        .collect();
    let rasters = Rasters {
        pixels: &pixels,
        height: SIZE,
        width: SIZE,
        metres_per_pixel: 8.0,
    };
    let config = ConditionConfig {
        image_size: SIZE,
        sigma_px: 2.5,
    };
    Conditions::new(rasters, config, &Device::Cpu).unwrap()
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

fn samples(n: usize) -> Samples {
    Samples::new(
        (0..n).map(link).collect(),
        (0..n).flat_map(target).collect(),
    )
    .unwrap()
}

fn fresh(seed: u64) -> Parameters {
    Parameters::new(&Device::Cpu, DType::F32, seed)
}

fn regression() -> (Trainees, TrainConfig) {
    let predictor = ResnetMlp::new(&fresh(1), WIDTH, 0.1).unwrap();
    let trainees = Trainees {
        predictor: Box::new(predictor),
        regularizer: None,
    };
    let config = TrainConfig {
        epochs: 2,
        batch: 4,
        learning_rate: 3e-3,
        ..TrainConfig::regression()
    };
    (trainees, config)
}

fn adversarial() -> (Trainees, TrainConfig) {
    let trainees = Trainees {
        predictor: Box::new(MsAreg::new(&fresh(1), WIDTH).unwrap()),
        regularizer: Some(Box::new(Regularizer::new(&fresh(2), WIDTH).unwrap())),
    };
    let config = TrainConfig {
        epochs: 2,
        batch: 4,
        ..TrainConfig::adversarial()
    };
    (trainees, config)
}

fn trainer(
    (trainees, config): (Trainees, TrainConfig),
    examples: impl Examples + 'static,
) -> Trainer {
    Trainer::new(trainees, conditions(), examples, config).unwrap()
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

type Recipe = fn() -> (Trainees, TrainConfig);
const RECIPES: [Recipe; 2] = [regression, adversarial];

#[test]
fn continued_run_equals_uninterrupted_one_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("last.safetensors");
    for recipe in RECIPES {
        // 14 examples, 4 a batch: 3 steps an epoch. Stopped within the first epoch, at its end, within the second.
        let mut straight = trainer(recipe(), samples(14));
        let losses = steps(&mut straight, 6);
        assert!(straight.step().unwrap().is_none(), "two epochs are over");
        let expected = state(&mut straight, folder.path());
        for stop in [2, 3, 5] {
            let mut stopped = trainer(recipe(), samples(14));
            steps(&mut stopped, stop);
            stopped.save(&path, "notes of the caller").unwrap();
            drop(stopped);
            let mut resumed = trainer(recipe(), samples(14));
            assert_eq!(resumed.resume(&path).unwrap(), "notes of the caller");
            assert_eq!(resumed.steps_done(), stop as u64);
            assert_eq!(steps(&mut resumed, 6 - stop), losses[stop..]);
            assert!(
                state(&mut resumed, folder.path()) == expected,
                "stopped after {stop}"
            );
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for recipe in RECIPES {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mut trainer = trainer(recipe(), samples(8));
                steps(&mut trainer, 3);
                state(&mut trainer, folder.path())
            })
        };
        assert!(on(1) == on(3));
    }
}

#[test]
fn a_few_links_are_learnt_by_heart() {
    for recipe in RECIPES {
        let (trainees, config) = recipe();
        let config = TrainConfig {
            epochs: 100,
            learning_rate: 3e-3,
            ..config
        };
        let mut trainer = trainer((trainees, config), samples(8));
        let losses = steps(&mut trainer, 200);
        let (first, last) = (losses[0], losses[198..].iter().sum::<f64>() / 2.0);
        assert!(last < 0.4 * first, "{first} to {last}");
    }
}

/// The recipe written down plainly: three full passes of the regularizer, nothing shared, nothing detached but the
/// prediction.
#[test]
fn adversarial_step_is_the_papers_equations() {
    let (trainees, config) = adversarial();
    let all = |trainees: &Trainees| {
        let regularizer = trainees.regularizer.as_ref().unwrap();
        [
            trainees.predictor.parameters().clone(),
            regularizer.parameters().clone(),
        ]
    };
    let learnt = all(&trainees);
    let mut trainer = trainer((trainees, config.clone()), samples(4));
    let report = trainer.step().unwrap().unwrap();

    let predictor = MsAreg::new(&fresh(1), WIDTH).unwrap();
    let regularizer = Regularizer::new(&fresh(2), WIDTH).unwrap();
    let links: Vec<Link> = (0..4).map(link).collect();
    let images = conditions().images(&links).unwrap();
    let truth: Vec<f32> = (0..4).flat_map(target).collect();
    let truth = Tensor::from_vec(truth, (4, ANGLE_BINS), &Device::Cpu).unwrap();
    let generator = Mutex::new(ChaCha8Rng::seed_from_u64(0));
    let mode = Mode::Train(&generator);
    let label = |score: &Tensor, value: f64| {
        (
            (score.zeros_like().unwrap() + value).unwrap(),
            score.clone(),
        )
    };
    let bce = |(label, score): (Tensor, Tensor)| loss::bce_with_logits(&score, &label).unwrap();
    let move_by = |loss: &Tensor, parameters: &Parameters| {
        let mut adam = Adam::new(parameters, config.optimizer).unwrap();
        let gradients = loss.backward().unwrap();
        let norm = gradient_norm(&gradients, adam.variables()).unwrap();
        adam.step(&gradients, report.learning_rate, clip_factor(norm, 1.0))
            .unwrap();
        norm
    };
    let predicted = predictor.forward(&images, mode).unwrap();
    let score = |spectra: &Tensor| regularizer.forward(&images, spectra, mode).unwrap();
    let (real, fake) = (score(&truth), score(&predicted.detach()));
    let regularizer_loss = (bce(label(&real, 1.0)) + bce(label(&fake, 0.0))).unwrap();
    let regularizer_norm = move_by(&regularizer_loss, regularizer.parameters());
    let l1 = loss::l1(&predicted, &truth).unwrap();
    let goal = (bce(label(&score(&predicted), 1.0)) + (&l1 * 100.0).unwrap()).unwrap();
    let norm = move_by(&goal, predictor.parameters());

    let close = |found: f64, expected: f64| {
        assert!(
            (found - expected).abs() <= 1e-4 * expected.abs(),
            "{found} is not {expected}"
        );
    };
    close(report.loss, f64::from(l1.to_scalar::<f32>().unwrap()));
    close(
        report.regularizer_loss.unwrap(),
        f64::from(regularizer_loss.to_scalar::<f32>().unwrap()),
    );
    close(report.gradient_norm, norm);
    close(report.regularizer_gradient_norm.unwrap(), regularizer_norm);
    for (learnt, plain) in learnt
        .iter()
        .zip([predictor.parameters(), regularizer.parameters()])
    {
        let (mut moved, mut apart) = (0.0, 0.0);
        for ((name, a), (_, b)) in learnt.trainable().iter().zip(plain.trainable()) {
            let first = fresh_value(name, learnt, a);
            moved += distance(a, &first);
            apart += distance(a, &b);
        }
        // Adam's first step has the size of the rate whatever the gradient's size: rounding of gradients near zero shows.
        assert!(
            apart < 1e-2 * moved,
            "{apart} apart after moving by {moved}"
        );
    }
}

/// The value a tensor had before training.
fn fresh_value(name: &str, network: &Parameters, like: &Tensor) -> Tensor {
    let predictor = MsAreg::new(&fresh(1), WIDTH).unwrap();
    let regularizer = Regularizer::new(&fresh(2), WIDTH).unwrap();
    let is_predictor = network.get("decoder.0.weight").is_some();
    let of = if is_predictor {
        predictor.parameters()
    } else {
        regularizer.parameters()
    };
    let var = of.get(name).expect("the same network").var;
    assert_eq!(var.dims(), like.dims());
    var.as_detached_tensor()
}

fn distance(a: &Tensor, b: &Tensor) -> f64 {
    let sum = (a - b).unwrap().abs().unwrap().sum_all().unwrap();
    f64::from(sum.to_scalar::<f32>().unwrap())
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
    for recipe in RECIPES {
        for value in [f32::NAN, f32::INFINITY, 1e9] {
            let spoilt = Spoilt {
                samples: samples(12),
                example: 9,
                value,
            };
            let mut trainer = trainer(recipe(), spoilt);
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
            assert_eq!((step, quantity), (trainer.steps_done(), Quantity::Loss));
            assert_eq!(links[0], (9, link(9)), "the worst link comes first");
            assert_eq!(checkpoint.as_ref(), Some(&path));
            assert!(
                text.contains("example 9") && text.contains("last.safetensors"),
                "{text}"
            );

            assert!(matches!(trainer.step(), Err(TrainError::Failed)));
            assert!(matches!(trainer.save(&path, ""), Err(TrainError::Failed)));
            trainer.resume(&path).unwrap();
            assert_eq!(
                trainer.steps_done(),
                step,
                "what is left is the good checkpoint"
            );
        }
    }
}

#[test]
fn foreign_or_damaged_checkpoint_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("last.safetensors");
    let mut source = trainer(regression(), samples(8));
    steps(&mut source, 2);
    source.save(&path, "").unwrap();
    let good = fs::read(&path).unwrap();

    let mut own = trainer(regression(), samples(8));
    let before = state(&mut own, folder.path());
    let mut refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        match own.resume(&path) {
            Err(TrainError::Checkpoint { problem, .. }) => problem,
            other => panic!("{other:?}"),
        }
    };
    for bytes in [
        &good[..good.len() - 1],
        &good[..100],
        b"",
        b"not safetensors at all",
    ] {
        assert!(refused(bytes).contains("damaged"), "{} bytes", bytes.len());
    }
    let mut renamed = good.clone();
    let name = b"head.0.bias\"";
    let places: Vec<usize> = (0..good.len() - name.len())
        .filter(|&i| good[i..].starts_with(name))
        .collect();
    assert_eq!(places.len(), 1);
    renamed[places[0] + 5] = b'9';
    assert!(refused(&renamed).contains("head."));
    assert!(state(&mut own, folder.path()) == before);

    fs::write(&path, &good).unwrap();
    let other = |(trainees, config): (Trainees, TrainConfig), n: usize| {
        let problem = trainer((trainees, config), samples(n))
            .resume(&path)
            .unwrap_err()
            .to_string();
        assert!(problem.contains("last.safetensors"), "{problem}");
        problem
    };
    let (trainees, config) = regression();
    assert!(other((trainees, TrainConfig { seed: 7, ..config }), 8).contains("seed"));
    assert!(other(regression(), 9).contains("examples"));
    let (mut trainees, config) = regression();
    trainees.predictor = Box::new(ResnetMlp::new(&fresh(1), 2 * WIDTH, 0.1).unwrap());
    assert!(other((trainees, config), 8).contains("shape"));
    let (mut trainees, config) = regression();
    trainees.regularizer = adversarial().0.regularizer;
    assert!(other((trainees, config), 8).contains("missing"));

    let missing = own.resume(folder.path().join("nothing")).unwrap_err();
    assert!(matches!(missing, TrainError::Io { .. }));
    let nowhere = own
        .save(folder.path().join("no/folder/file"), "")
        .unwrap_err();
    assert!(matches!(nowhere, TrainError::Io { .. }));
}

#[test]
fn settings_that_cannot_train_are_refused() {
    let refused = |change: fn(&mut TrainConfig)| {
        let (trainees, mut config) = regression();
        change(&mut config);
        match Trainer::new(trainees, conditions(), samples(4), config) {
            Err(TrainError::Config(problem)) => problem,
            other => panic!("{:?}", other.err()),
        }
    };
    assert!(refused(|c| c.epochs = 0).contains("epochs"));
    assert!(refused(|c| c.batch = 0).contains("batch"));
    assert!(refused(|c| c.learning_rate = f64::NAN).contains("learning_rate"));
    assert!(refused(|c| c.clip_norm = -1.0).contains("clip_norm"));
    assert!(refused(|c| c.optimizer.beta1 = 1.0).contains("beta1"));
    let (trainees, config) = regression();
    let none = Trainer::new(trainees, conditions(), Samples::default(), config);
    assert!(matches!(none, Err(TrainError::NoExamples)));
    assert!(Samples::new(vec![link(0)], vec![0.0; 179]).is_err());
    assert!(Samples::new(vec![link(0)], vec![f32::NAN; 180]).is_err());
}

#[test]
fn predictions_do_not_depend_on_the_batch_and_damaged_weights_are_told() {
    let (trainees, _) = regression();
    let model = &*trainees.predictor;
    let run = |batch| {
        let mut all = Vec::new();
        let take = |first: usize, spectra: &[f32]| {
            assert_eq!(first * ANGLE_BINS, all.len());
            all.extend_from_slice(spectra);
            Ok::<(), TrainError>(())
        };
        predict(model, &conditions(), (0..7).map(link), batch, take).map(|()| all)
    };
    let (three, seven) = (run(3).unwrap(), run(7).unwrap());
    assert_eq!(three.len(), 7 * ANGLE_BINS);
    for (a, b) in three.iter().zip(&seven) {
        assert!((a - b).abs() < 1e-5, "{a} is not {b}");
    }
    // In the last layer: on its way through a rectifier NaN may become 0.
    let bias = model.parameters().get("head.3.bias").unwrap().var;
    let spoilt = (bias.ones_like().unwrap() * f64::NAN).unwrap();
    bias.set(&spoilt).unwrap();
    assert!(matches!(
        run(3),
        Err(TrainError::Prediction { link: 0, .. })
    ));
}
