//! Weights in files: ours, PyTorch's, damaged ones.

use std::fs;
use std::path::{Path, PathBuf};

use aps_model::candle_core::{DType, Device, Tensor, safetensors};
use aps_model::layers::{BatchNorm, Linear};
use aps_model::weights::{Label, load, load_pretrained, read_label, save, warm_start};
use aps_model::{Error, Mode, Model, ModelKind, Parameters, Preset};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/golden/weights")
        .join(name)
}

fn empty(seed: u64) -> Parameters {
    Parameters::new(&Device::Cpu, DType::F32, seed)
}

/// The module of `weights.py`: a linear layer and a batch normalisation.
fn tiny() -> Parameters {
    let parameters = empty(1);
    Linear::new(&parameters.root().at("fc"), 3, 2).unwrap();
    BatchNorm::new(&parameters.root().at("bn"), 2).unwrap();
    parameters
}

/// All values by name.
fn values(parameters: &Parameters) -> Vec<(String, Vec<f64>)> {
    let flat = |t: &Tensor| {
        t.to_dtype(DType::F64)
            .unwrap()
            .flatten_all()
            .unwrap()
            .to_vec1()
            .unwrap()
    };
    parameters
        .all()
        .into_iter()
        .map(|(name, p)| (name, flat(p.var.as_tensor())))
        .collect()
}

/// What `weights.py` writes.
fn written() -> Vec<(String, Vec<f64>)> {
    let tensor = |name: &str, k: f64, count| {
        (
            name.to_owned(),
            (0..count).map(|i| k + f64::from(i) / 8.0).collect(),
        )
    };
    vec![
        tensor("bn.bias", 3.0, 2),
        tensor("bn.num_batches_tracked", 6.0, 1),
        tensor("bn.running_mean", 4.0, 2),
        tensor("bn.running_var", 5.0, 2),
        tensor("bn.weight", 2.0, 2),
        tensor("fc.bias", 1.0, 2),
        tensor("fc.weight", 0.0, 6),
    ]
}

#[test]
fn pytorch_s_files_in_every_shape() {
    for file in ["plain.pt", "checkpoint.pt", "layouts.pt"] {
        let parameters = tiny();
        let report = load(&golden(file), &parameters).unwrap();
        assert_eq!(values(&parameters), written(), "{file}");
        assert_eq!(
            (report.loaded, report.dropped.len(), report.zeroed.len()),
            (7, 0, 0),
            "{file}"
        );
    }
}

#[test]
fn a_file_without_state_dict_says_what_it_holds() {
    let error = load(&golden("no_state_dict.pt"), &tiny())
        .unwrap_err()
        .to_string();
    assert!(error.contains("no tensors: loss"), "{error}");
}

#[test]
fn what_is_saved_is_loaded_and_names_its_model() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let (kind, preset) = (ModelKind::ResnetMlp, Preset::Small);
    let (one, other) = (empty(1), empty(2));
    kind.build(preset, &one).unwrap();
    kind.build(preset, &other).unwrap();
    assert_ne!(values(&one), values(&other));
    save(&path, &one, Some(Label { kind, preset })).unwrap();
    assert_eq!(read_label(&path).unwrap(), Some(Label { kind, preset }));
    load(&path, &other).unwrap();
    assert_eq!(values(&one), values(&other));
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "a partial file was left"
    );
}

#[test]
fn frozen_parameters_stay_what_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let (kind, preset) = (ModelKind::ResnetMlp, Preset::Small);
    let (one, other) = (empty(1), empty(2));
    kind.build(preset, &one).unwrap();
    kind.build(preset, &other).unwrap();
    let frozen = one.frozen().unwrap();
    let model = kind.build(preset, &frozen).unwrap();
    assert_eq!(frozen.count(), one.count());
    assert!(frozen.trainable().is_empty());

    // Several answers, so that what is kept is used; other weights in between do not reach them.
    let images = Tensor::rand(0f32, 1.0, (4, 3, 64, 64), &Device::Cpu).unwrap();
    let answer = |model: &dyn Model| -> Vec<Vec<f32>> {
        let y = model.forward(&images, Mode::Eval).unwrap();
        y.to_vec2().unwrap()
    };
    let before = answer(&*model);
    save(&path, &other, Some(Label { kind, preset })).unwrap();
    load(&path, &one).unwrap();
    assert_eq!(answer(&*model), before);
    let now = kind.build(preset, &one.frozen().unwrap()).unwrap();
    assert_ne!(answer(&*now), before);

    for result in [load(&path, &frozen), load_pretrained(&path, &frozen)] {
        let error = result.unwrap_err();
        assert!(matches!(error, Error::Frozen { .. }), "{error}");
    }
    assert_eq!(answer(&*model), before);
}

/// Writes the tiny module's tensors after a change, and loads them into a fresh one.
fn load_changed(
    change: impl Fn(&mut Vec<(String, Tensor)>),
) -> Result<Vec<(String, Vec<f64>)>, Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let source = tiny();
    load(&golden("plain.pt"), &source).unwrap();
    let mut tensors: Vec<(String, Tensor)> = source
        .all()
        .into_iter()
        .map(|(name, p)| (name, p.var.as_detached_tensor()))
        .collect();
    change(&mut tensors);
    safetensors::save(&tensors.into_iter().collect(), &path).unwrap();
    let parameters = tiny();
    let before = values(&parameters);
    match load(&path, &parameters) {
        Ok(_) => Ok(values(&parameters)),
        Err(Error::WeightsMismatch { problems, .. }) => {
            assert_eq!(values(&parameters), before, "weights were changed in part");
            Err(problems)
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn every_tensor_that_does_not_fit_is_named() {
    let problems = load_changed(|tensors| {
        tensors.retain(|(name, _)| name != "fc.bias" && name != "bn.running_mean");
        for (name, tensor) in tensors.iter_mut() {
            match name.as_str() {
                "fc.weight" => *tensor = tensor.t().unwrap().contiguous().unwrap(),
                "bn.weight" => *tensor = tensor.to_dtype(DType::I64).unwrap(),
                "bn.bias" => *name = "bn.shift".to_owned(),
                _ => {}
            }
        }
    })
    .unwrap_err();
    assert_eq!(
        problems,
        [
            "bn.bias [2] is missing",
            "bn.running_mean [2] is missing",
            "bn.weight has the type I64",
            "fc.bias [2] is missing",
            "fc.weight has the shape [3, 2], not [2, 3]",
            "bn.shift is not part of the model",
        ]
    );
}

#[test]
fn weights_that_are_not_finite_are_refused() {
    let problems = load_changed(|tensors| {
        let (_, weight) = tensors
            .iter_mut()
            .find(|(name, _)| name == "fc.weight")
            .unwrap();
        *weight = (weight.log().unwrap() * 0.0).unwrap();
    })
    .unwrap_err();
    assert_eq!(problems, ["fc.weight holds values that are not finite"]);
}

#[test]
fn counters_of_old_pytorch_may_lack() {
    let loaded =
        load_changed(|tensors| tensors.retain(|(name, _)| !name.ends_with("num_batches_tracked")))
            .unwrap();
    let mut expected = written();
    expected[1].1 = vec![0.0];
    assert_eq!(loaded, expected);
}

/// A file as torchvision's `resnet18` has it, as wide as the small preset, made of the ResNet-MLP of `seed`.
fn backbone_file(path: &Path, seed: u64) -> Parameters {
    let source = empty(seed);
    ModelKind::ResnetMlp.build(Preset::Small, &source).unwrap();
    let mut tensors: Vec<(String, Tensor)> = source
        .all()
        .into_iter()
        .filter_map(|(name, p)| {
            Some((
                name.strip_prefix("encoder.")?.to_owned(),
                p.var.as_detached_tensor(),
            ))
        })
        .collect();
    for name in ["fc.weight", "fc.bias"] {
        tensors.push((
            name.to_owned(),
            Tensor::zeros(1000, DType::F32, &Device::Cpu).unwrap(),
        ));
    }
    safetensors::save(&tensors.into_iter().collect(), path).unwrap();
    source
}

#[test]
fn a_pretrained_backbone_fills_every_encoder_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("resnet18.safetensors");
    let source = backbone_file(&path, 1);
    let of = |name: &str| source.get(&format!("encoder.{name}")).unwrap().var;
    let same = |a: &Tensor, b: &Tensor| {
        (a - b)
            .unwrap()
            .abs()
            .unwrap()
            .sum_all()
            .unwrap()
            .to_scalar::<f32>()
            .unwrap()
            == 0.0
    };

    for kind in [
        ModelKind::ResnetMlp,
        ModelKind::AdvMlp,
        ModelKind::MsAreg,
        ModelKind::ResnetConv1d,
    ] {
        let (parameters, untouched) = (empty(2), empty(2));
        kind.build(Preset::Small, &parameters).unwrap();
        kind.build(Preset::Small, &untouched).unwrap();
        let report = load_pretrained(&path, &parameters).unwrap();
        assert_eq!(report.dropped, ["fc.bias", "fc.weight"], "{kind}");
        assert_eq!(report.loaded, 120, "{kind}");
        for (name, parameter) in parameters.all() {
            if name.ends_with("num_batches_tracked") {
                continue;
            }
            let encoder = name
                .strip_prefix("encoder.")
                .map(|rest| rest.replace("stem.0", "conv1").replace("stem.1", "bn1"));
            let expected = match encoder {
                Some(rest) if !rest.contains("proj") => of(&rest),
                _ => untouched.get(&name).unwrap().var,
            };
            assert!(
                same(parameter.var.as_tensor(), expected.as_tensor()),
                "{kind}: {name}"
            );
        }
    }

    let regularizer = regularizer();
    load_pretrained(&path, &regularizer).unwrap();
    let first = regularizer.get("cond_encoder.conv1.weight").unwrap().var;
    assert!(same(first.as_tensor(), of("conv1.weight").as_tensor()));

    let unet = empty(4);
    ModelKind::RadioUnet.build(Preset::Small, &unet).unwrap();
    assert!(matches!(
        load_pretrained(&path, &unet),
        Err(Error::NoBackbone)
    ));
}

#[test]
fn damaged_files_are_refused_or_read_without_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let ours = folder.path().join("ours.safetensors");
    save(&ours, &tiny(), None).unwrap();
    let parameters = tiny();
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    for file in [
        ours,
        golden("plain.pt"),
        golden("checkpoint.pt"),
        golden("layouts.pt"),
    ] {
        let bytes = fs::read(&file).unwrap();
        for _ in 0..1000 {
            let mut damaged = bytes.clone();
            for _ in 0..=generator.next_u32() % 3 {
                // Headers and directories are at the ends.
                let near = match generator.next_u32() % 3 {
                    0 => damaged.len().min(400),
                    _ => damaged.len(),
                };
                let back = generator.next_u32().is_multiple_of(2);
                let at = generator.next_u64() as usize % near;
                let at = if back { damaged.len() - 1 - at } else { at };
                damaged[at] = generator.next_u32() as u8;
            }
            if generator.next_u32().is_multiple_of(8) {
                damaged.truncate(generator.next_u64() as usize % damaged.len());
            }
            fs::write(&path, &damaged).unwrap();
            let _ = load(&path, &parameters);
            let _ = read_label(&path);
        }
    }
}

#[test]
fn no_file_and_no_weights_say_so() {
    let error = load(Path::new("no/such/file"), &tiny())
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("cannot read no/such/file"), "{error}");
    let error = load(&golden("../weights.py"), &tiny())
        .unwrap_err()
        .to_string();
    assert!(error.contains("neither safetensors"), "{error}");
}

fn regularizer() -> Parameters {
    let parameters = empty(3);
    ModelKind::MsAreg
        .build_regularizer(Preset::Small, &parameters)
        .unwrap();
    parameters
}

/// An encoder goes from model to model: whole between those that look at several scales, its ResNet alone else.
#[test]
fn another_model_s_encoder_is_adopted() {
    let folder = tempfile::tempdir().unwrap();
    let trained = |kind: ModelKind| {
        let parameters = empty(5);
        kind.build(Preset::Small, &parameters).unwrap();
        let path = folder.path().join(format!("{kind}.safetensors"));
        save(&path, &parameters, None).unwrap();
        (path, values(&parameters))
    };
    let moved = |path: &Path, into: &Parameters| -> Vec<(String, Vec<f64>)> {
        let before = values(into);
        let report = load_pretrained(path, into).unwrap();
        assert!(!report.dropped.is_empty(), "{report}");
        let after = values(into).into_iter().zip(before);
        after.filter(|(a, b)| a != b).map(|(a, _)| a).collect()
    };
    let random = |kind: ModelKind| {
        let parameters = empty(6);
        kind.build(Preset::Small, &parameters).unwrap();
        parameters
    };
    let (scales, of_scales) = trained(ModelKind::MsMlp);
    let (plain, of_plain) = trained(ModelKind::ResnetMlp);
    let value = |all: &[(String, Vec<f64>)], name: &str| {
        let found = all.iter().find(|(n, _)| n == name);
        found.unwrap_or_else(|| panic!("no {name}")).1.clone()
    };

    // Whole: every tensor with drawn values in the encoder is the other's, and nothing else has moved.
    let all = moved(&scales, &random(ModelKind::MsAreg));
    assert!(all.iter().any(|(name, _)| name == "encoder.proj3.weight"));
    for (name, found) in &all {
        assert!(name.starts_with("encoder."), "{name}");
        assert_eq!(found, &value(&of_scales, name), "{name}");
    }
    // From a plain one into one of several scales and the other way: the ResNet, under other names.
    let all = moved(&plain, &random(ModelKind::MsAreg));
    assert!(all.iter().all(|(name, _)| !name.contains("proj")));
    let stem = value(&all, "encoder.stem.0.weight");
    assert_eq!(stem, value(&of_plain, "encoder.conv1.weight"));
    let all = moved(&scales, &random(ModelKind::ResnetMlp));
    let stem = value(&all, "encoder.conv1.weight");
    assert_eq!(stem, value(&of_scales, "encoder.stem.0.weight"));
    // And into a regularizer.
    let all = moved(&scales, &regularizer());
    let deep = value(&all, "cond_encoder.layer4.1.conv2.weight");
    assert_eq!(deep, value(&of_scales, "encoder.layer4.1.conv2.weight"));
}

/// MS-AReg begins with MS-MLP's answers; a model of the same kind with every value.
#[test]
fn a_warm_start_begins_with_the_other_s_answers() {
    let folder = tempfile::tempdir().unwrap();
    let made = |kind: ModelKind, seed| kind.build(Preset::Small, &empty(seed)).unwrap();
    let saved = |model: &dyn Model| {
        let path = folder.path().join("weights.safetensors");
        save(&path, model.parameters(), None).unwrap();
        path
    };
    let images = Tensor::rand(0f32, 1.0, (3, 3, 64, 64), &Device::Cpu).unwrap();
    let answer = |model: &dyn Model| -> Vec<Vec<f32>> {
        let y = model.forward(&images, Mode::Eval).unwrap();
        y.to_vec2().unwrap()
    };

    let (trained, adversarial) = (made(ModelKind::MsMlp, 1), made(ModelKind::MsAreg, 2));
    let before = answer(&*adversarial);
    let report = warm_start(&saved(&*trained), adversarial.parameters()).unwrap();
    assert_eq!(report.kept, ["noise_proj.bias", "noise_proj.weight"]);
    let (expected, found) = (answer(&*trained), answer(&*adversarial));
    assert_ne!(found, before);
    let pairs = expected.iter().flatten().zip(found.iter().flatten());
    for (a, b) in pairs {
        // Added zeros change nothing, but the order of sums may.
        assert!((a - b).abs() <= 1e-6 * (1.0 + a.abs()), "{a} and {b}");
    }

    // The noise input was not lost to the zeros: it can learn.
    let own = made(ModelKind::MsAreg, 3);
    let report = warm_start(&saved(&*adversarial), own.parameters()).unwrap();
    assert!(report.kept.is_empty());
    assert_eq!(values(own.parameters()), values(adversarial.parameters()));

    // Another model is refused, with nothing changed.
    let other = made(ModelKind::ResnetMlp, 4);
    let before = values(own.parameters());
    let error = warm_start(&saved(&*other), own.parameters()).unwrap_err();
    assert!(matches!(error, Error::WeightsMismatch { .. }), "{error}");
    assert_eq!(values(own.parameters()), before);
    assert!(warm_start(&saved(&*own), other.parameters()).is_err());
}
