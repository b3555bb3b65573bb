//! Weights that begin a training: a backbone's, another model's.

use std::collections::HashMap;
use std::path::Path;

use aps_model::candle_core::{DType, Device, Tensor, safetensors};
use aps_model::candle_nn::VarMap;
use aps_model::condition::InputShape;
use aps_model::weights::{load_pretrained, save, warm_start};
use aps_model::{Error, Model, ModelKind, Preset, seeded};

use super::{answer, built, detached, get, sorted, values};

/// A file as torchvision's `resnet18` has it, as wide as the small preset, made of the ResNet-MLP of `seed`.
fn backbone_file(path: &Path, seed: u64) -> VarMap {
    let source = built(ModelKind::ResnetMlp, Preset::Small, seed);
    let tensors = detached(&source).into_iter();
    let tensors = tensors
        .filter_map(|(name, tensor)| Some((name.strip_prefix("encoder.")?.to_owned(), tensor)));
    let mut tensors: HashMap<String, Tensor> = tensors.collect();
    let classifier = Tensor::zeros(1000, DType::F32, &Device::Cpu).unwrap();
    for name in ["fc.weight", "fc.bias"] {
        tensors.insert(name.to_owned(), classifier.clone());
    }
    safetensors::save(&tensors, path).unwrap();
    source
}

#[test]
fn a_pretrained_backbone_fills_every_encoder_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("resnet18.safetensors");
    let source = backbone_file(&path, 1);
    let of = |name: &str| get(&source, &format!("encoder.{name}")).unwrap();
    let same = |a: &Tensor, b: &Tensor| {
        let apart = (a - b).unwrap().abs().unwrap().sum_all().unwrap();
        apart.to_scalar::<f32>().unwrap() == 0.0
    };

    for kind in [
        ModelKind::ResnetMlp,
        ModelKind::AdvMlp,
        ModelKind::MsAreg,
        ModelKind::ResnetConv1d,
    ] {
        let [parameters, untouched] = [2, 2].map(|seed| built(kind, Preset::Small, seed));
        let report = load_pretrained(&path, &parameters).unwrap();
        assert_eq!(report.dropped, ["fc.bias", "fc.weight"], "{kind}");
        assert_eq!(report.loaded, 120, "{kind}");
        for (name, var) in sorted(&parameters) {
            if name.ends_with("num_batches_tracked") {
                continue;
            }
            let expected = match name.strip_prefix("encoder.") {
                Some(rest) if !rest.contains("proj") => {
                    of(&rest.replace("stem.0", "conv1").replace("stem.1", "bn1"))
                }
                _ => get(&untouched, &name).unwrap(),
            };
            assert!(same(&var, &expected), "{kind}: {name}");
        }
    }

    let regularizer = regularizer(Preset::Small);
    load_pretrained(&path, &regularizer).unwrap();
    let first = get(&regularizer, "cond_encoder.conv1.weight").unwrap();
    assert!(same(&first, &of("conv1.weight")));

    let unet = built(ModelKind::RadioUnet, Preset::Small, 4);
    let refused = load_pretrained(&path, &unet);
    assert!(matches!(refused, Err(Error::NoBackbone)));
}

pub fn regularizer(preset: Preset) -> VarMap {
    let parameters = VarMap::new();
    let vb = seeded(&parameters, 3, DType::F32, &Device::Cpu);
    ModelKind::MsAreg.build_regularizer(preset, vb).unwrap();
    parameters
}

/// An encoder goes from model to model: whole between those that look at several scales, its ResNet alone else.
#[test]
fn another_model_s_encoder_is_adopted() {
    let folder = tempfile::tempdir().unwrap();
    let trained = |kind: ModelKind| {
        let parameters = built(kind, Preset::Small, 5);
        let path = folder.path().join(format!("{kind}.safetensors"));
        save(&path, &parameters, None).unwrap();
        (path, values(&parameters))
    };
    let moved = |path: &Path, into: &VarMap| -> Vec<(String, Vec<f64>)> {
        let before = values(into);
        let report = load_pretrained(path, into).unwrap();
        assert!(!report.dropped.is_empty(), "{report}");
        let after = values(into).into_iter().zip(before);
        after.filter(|(a, b)| a != b).map(|(a, _)| a).collect()
    };
    let random = |kind: ModelKind| built(kind, Preset::Small, 6);
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
    let all = moved(&scales, &regularizer(Preset::Small));
    let deep = value(&all, "cond_encoder.layer4.1.conv2.weight");
    assert_eq!(deep, value(&of_scales, "encoder.layer4.1.conv2.weight"));
}

/// MS-AReg begins with MS-MLP's outputs; a model of the same kind with every value.
#[test]
fn a_warm_start_begins_with_the_other_s_answers() {
    let folder = tempfile::tempdir().unwrap();
    let made = |kind: ModelKind, seed| {
        let parameters = VarMap::new();
        let vb = seeded(&parameters, seed, DType::F32, &Device::Cpu);
        let model = kind.build(Preset::Small, InputShape::Images, vb);
        (model.unwrap(), parameters)
    };
    let saved = |parameters: &VarMap| {
        let path = folder.path().join("weights.safetensors");
        save(&path, parameters, None).unwrap();
        path
    };
    let images = Tensor::rand(0f32, 1.0, (3, 3, 64, 64), &Device::Cpu).unwrap();
    let answer = |model: &dyn Model| answer(model, &images);

    let (trained, of_trained) = made(ModelKind::MsMlp, 1);
    let (adversarial, parameters) = made(ModelKind::MsAreg, 2);
    let before = answer(&*adversarial);
    let report = warm_start(&saved(&of_trained), &parameters).unwrap();
    assert_eq!(report.kept, ["noise_proj.bias", "noise_proj.weight"]);
    let (expected, found) = (answer(&*trained), answer(&*adversarial));
    assert_ne!(found, before);
    let pairs = expected.iter().flatten().zip(found.iter().flatten());
    for (a, b) in pairs {
        // Added zeros change nothing, but the order of sums may.
        assert!((a - b).abs() <= 1e-6 * (1.0 + a.abs()), "{a} and {b}");
    }

    // The noise input was not lost to the zeros: it can learn.
    let (_, own) = made(ModelKind::MsAreg, 3);
    let report = warm_start(&saved(&parameters), &own).unwrap();
    assert!(report.kept.is_empty());
    assert_eq!(values(&own), values(&parameters));

    // Another model is refused, with nothing changed.
    let (_, other) = made(ModelKind::ResnetMlp, 4);
    let before = values(&own);
    let error = warm_start(&saved(&other), &own).unwrap_err();
    assert!(matches!(error, Error::WeightsMismatch { .. }), "{error}");
    assert_eq!(values(&own), before);
    assert!(warm_start(&saved(&own), &other).is_err());
}
