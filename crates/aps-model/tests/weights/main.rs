//! Weights in files: ours, PyTorch's, damaged ones.

mod backbone;
mod names;
mod torchvision;

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use aps_model::candle_core::{DType, Device, Tensor, Var};
use aps_model::candle_nn::{Init, VarMap};
use aps_model::condition::InputShape;
use aps_model::weights::{Label, load, read_label, save};
use aps_model::{Model, ModelKind, Preset, frozen, seeded, trainable};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/golden/weights")
        .join(name)
}

/// Returns the tensors of a model under a seed.
fn built(kind: ModelKind, preset: Preset, seed: u64) -> VarMap {
    let parameters = VarMap::new();
    let vb = seeded(&parameters, seed, DType::F32, &Device::Cpu);
    kind.build(preset, InputShape::Images, vb).unwrap();
    parameters
}

/// The module of `weights.py`: a linear layer and a batch normalisation.
fn tiny() -> VarMap {
    let parameters = VarMap::new();
    let vb = seeded(&parameters, 1, DType::F32, &Device::Cpu);
    vb.get((2, 3), "fc.weight").unwrap();
    for name in [
        "fc.bias",
        "bn.weight",
        "bn.bias",
        "bn.running_mean",
        "bn.running_var",
    ] {
        vb.get(2, name).unwrap();
    }
    let (counter, zero) = ("bn.num_batches_tracked", Init::Const(0.0));
    vb.get_with_hints_dtype((), counter, zero, DType::I64)
        .unwrap();
    parameters
}

/// Returns all tensors by name, in the order of their names.
fn sorted(parameters: &VarMap) -> Vec<(String, Var)> {
    let data = parameters.data().lock().unwrap();
    let mut all: Vec<(String, Var)> = data.iter().map(|(n, v)| (n.clone(), v.clone())).collect();
    all.sort_by(|(a, _), (b, _)| a.cmp(b));
    all
}

/// Returns all tensors by name, apart from their variables.
fn detached(parameters: &VarMap) -> Vec<(String, Tensor)> {
    let all = sorted(parameters).into_iter();
    all.map(|(name, var)| (name, var.as_detached_tensor()))
        .collect()
}

fn get(parameters: &VarMap, name: &str) -> Option<Var> {
    parameters.data().lock().unwrap().get(name).cloned()
}

/// Returns all values by name.
fn values(parameters: &VarMap) -> Vec<(String, Vec<f64>)> {
    let flat = |t: &Tensor| {
        let t = t.to_dtype(DType::F64).unwrap().flatten_all().unwrap();
        t.to_vec1().unwrap()
    };
    let all = sorted(parameters).into_iter();
    all.map(|(name, var)| (name, flat(&var))).collect()
}

/// Returns the spectra of images.
fn answer(model: &dyn Model, images: &Tensor) -> Vec<Vec<f32>> {
    model.forward_t(images, false).unwrap().to_vec2().unwrap()
}

/// Returns the tensors that `weights.py` writes.
fn written() -> Vec<(String, Vec<f64>)> {
    let tensor = |name: &str, k: f64, count| {
        let values = (0..count).map(|i| k + f64::from(i) / 8.0);
        (name.to_owned(), values.collect())
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
    let (one, other) = (built(kind, preset, 1), built(kind, preset, 2));
    assert_ne!(values(&one), values(&other));
    save(&path, &one, Some(Label { kind, preset })).unwrap();
    assert_eq!(read_label(&path).unwrap(), Some(Label { kind, preset }));
    load(&path, &other).unwrap();
    assert_eq!(values(&one), values(&other));
    let files = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 1, "a partial file was left");
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
    let (one, other) = (built(kind, preset, 1), built(kind, preset, 2));
    let frozen_model = || {
        let model = kind.build(preset, InputShape::Images, frozen(&one).unwrap());
        model.unwrap()
    };
    let model = frozen_model();

    // Several images, so that the kernel cache is used; other weights in between do not reach them.
    let images = &Tensor::rand(0f32, 1.0, (4, 3, 64, 64), &Device::Cpu).unwrap();
    let before = answer(&*model, images);
    save(&path, &other, Some(Label { kind, preset })).unwrap();
    load(&path, &one).unwrap();
    assert_eq!(answer(&*model, images), before);
    assert_ne!(answer(&*frozen_model(), images), before);
}

/// Weights of candle's own `VarMap` under a model whose builder is candle's: they are trained, and nothing is cached that
/// a changed weight would make wrong. A constant may even share its memory with a variable.
#[test]
fn a_model_of_any_builder_follows_its_weights() {
    use aps_model::candle_nn::VarBuilder;
    let (kind, preset, device) = (ModelKind::MsMlp, Preset::Small, &Device::Cpu);
    let (ours, theirs) = (built(kind, preset, 1), VarMap::new());
    let model = |vb| kind.build(preset, InputShape::Images, vb).unwrap();
    let of_varmap = model(VarBuilder::from_varmap(&theirs, DType::F32, device));
    let names = |map| sorted(map).into_iter().map(|(name, _)| name);
    assert!(names(&ours).eq(names(&theirs)));
    assert_eq!(trainable(&ours).len(), trainable(&theirs).len());

    let images = Tensor::rand(0f32, 1.0, (4, 3, 64, 64), device).unwrap();
    let answer = |model: &dyn Model| answer(model, &images);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    save(&path, &ours, None).unwrap();
    let drawn = answer(&*of_varmap);
    load(&path, &theirs).unwrap();
    let loaded = answer(&*of_varmap);
    assert_ne!(drawn, loaded);

    // From the file, as candle reads it.
    let bytes = fs::read(&path).unwrap();
    let vb = VarBuilder::from_buffered_safetensors(bytes, DType::F32, device);
    let found = answer(&*model(vb.unwrap()));
    let shared = detached(&theirs).into_iter().collect();
    let shared = model(VarBuilder::from_tensors(shared, DType::F32, device));
    for (found, expected) in found.iter().flatten().zip(loaded.iter().flatten()) {
        let is_close = (found - expected).abs() <= 1e-5 * (1.0 + expected.abs());
        assert!(is_close, "{found}, {expected}");
    }
    let before = answer(&*shared);
    let first = get(&theirs, "encoder.layer1.0.conv1.weight").unwrap();
    first.set(&first.zeros_like().unwrap()).unwrap();
    assert_ne!(
        answer(&*of_varmap),
        loaded,
        "a trainable weight has changed"
    );
    assert_eq!(answer(&*shared), before, "a layer's constant is its own");
}

#[test]
fn damaged_files_are_refused_or_read_without_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let ours = folder.path().join("ours.safetensors");
    save(&ours, &tiny(), None).unwrap();
    let parameters = tiny();
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let [plain, checkpoint, layouts] = ["plain.pt", "checkpoint.pt", "layouts.pt"].map(golden);
    for file in [ours, plain, checkpoint, layouts] {
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
    let told = |path: &Path| load(path, &tiny()).unwrap_err().to_string();
    let error = told(Path::new("no/such/file"));
    assert!(error.starts_with("cannot read no/such/file"), "{error}");
    let error = told(&golden("../weights.py"));
    assert!(error.contains("neither safetensors"), "{error}");
}
