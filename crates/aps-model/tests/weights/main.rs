//! Weights in files: ours, PyTorch's, damaged ones.

mod backbone;
mod names;
mod torchvision;

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::layers::{BatchNorm, Linear};
use aps_model::weights::{Label, load, load_pretrained, read_label, save};
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

/// Returns all values by name.
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

/// Returns the tensors that `weights.py` writes.
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
fn a_model_in_somebody_else_s_words_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let bias = Tensor::zeros(2, DType::F32, &Device::Cpu).unwrap();
    for (words, is_label) in [
        ("resnet18 imagenet1k", false),
        ("resnet18", false),
        ("resnet_mlp huge", false),
        ("resnet_mlp small", true),
    ] {
        let metadata = HashMap::from([("model".to_owned(), words.to_owned())]);
        let bytes = safetensors::serialize([("fc.bias", &bias)], Some(metadata)).unwrap();
        fs::write(&path, bytes).unwrap();
        match read_label(&path) {
            Ok(label) => assert_eq!(label.is_some(), is_label, "{words}"),
            Err(error) => {
                assert!(!is_label, "{error}");
                assert!(error.to_string().contains(words), "{error}");
            }
        }
    }
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

    // Several images, so that the kernel cache is used; other weights in between do not reach them.
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
