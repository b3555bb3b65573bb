//! Matching of a file's tensors with the model's by name.

use std::collections::HashMap;

use aps_model::candle_core::{DType, Tensor, safetensors};
use aps_model::weights::{load, save};
use aps_model::{Error, ModelKind, Preset};

use super::{built, detached, golden, tiny, values, written};

#[test]
fn pytorch_s_files_in_every_shape() {
    // With what a checkpoint, an average or a training module holds beside the model.
    let files: [(&str, &[&str]); 10] = [
        ("plain", &[]),
        ("layouts", &[]),
        ("checkpoint", &["r_state_dict.other.weight", "rng"]),
        ("wrapped_compiled_parallel", &[]),
        ("wrapped_thrice", &[]),
        ("wrapped_part", &[]),
        ("wrapped_averaged", &["n_averaged"]),
        (
            "wrapped_attribute",
            &["state_dict.loss.bias", "state_dict.loss.weight"],
        ),
        ("wrapped_with_average", &AVERAGE),
        // Its optimizer's are too deep to be looked at.
        ("wrapped_odd_key", &[]),
    ];
    for (file, dropped) in files {
        let parameters = tiny();
        let report = load(&golden(&format!("{file}.pt")), &parameters).unwrap();
        assert_eq!(values(&parameters), written(), "{file}");
        assert_eq!((report.loaded, report.zeroed.len()), (7, 0), "{file}");
        assert_eq!(report.dropped, dropped, "{file}");
    }
}

const AVERAGE: [&str; 7] = [
    "model_ema.bn.bias",
    "model_ema.bn.num_batches_tracked",
    "model_ema.bn.running_mean",
    "model_ema.bn.running_var",
    "model_ema.bn.weight",
    "model_ema.fc.bias",
    "model_ema.fc.weight",
];

#[test]
fn types_that_cannot_be_converted_are_told_by_tensor() {
    let header = r#"{"fc.weight":{"dtype":"F4","shape":[2],"data_offsets":[0,1]}}"#;
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend(header.as_bytes());
    bytes.push(0);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("four_bits.safetensors");
    std::fs::write(&path, bytes).unwrap();
    let told = load(&path, &tiny()).unwrap_err().to_string();
    assert!(told.contains("fc.weight (values of the type F4"), "{told}");
}

#[test]
fn a_file_without_state_dict_says_what_it_holds() {
    for (file, told) in [
        ("no_state_dict", "entries that are no tensors: loss"),
        (
            "wrapped_module",
            "these entries: epoch, model; save the state_dict()",
        ),
        (
            "wrapped_two_copies",
            "more than once, below student. and teacher.:",
        ),
    ] {
        let error = load(&golden(&format!("{file}.pt")), &tiny());
        let error = error.unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    }
}

/// Writes the tiny module's tensors after a change, and loads them into a fresh one.
fn load_changed(
    change: impl Fn(&mut Vec<(String, Tensor)>),
) -> Result<Vec<(String, Vec<f64>)>, Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let source = tiny();
    load(&golden("plain.pt"), &source).unwrap();
    let mut tensors = detached(&source);
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
            "bn.weight has the type I64, not of real numbers",
            "fc.bias [2] is missing",
            "fc.weight has the shape [3, 2], not [2, 3]",
            "bn.shift is not part of the model",
        ]
    );
}

#[test]
fn weights_that_are_not_finite_are_refused() {
    let problems = load_changed(|tensors| {
        let mut all = tensors.iter_mut();
        let (_, weight) = all.find(|(name, _)| name == "fc.weight").unwrap();
        *weight = (weight.log().unwrap() * 0.0).unwrap();
    })
    .unwrap_err();
    assert_eq!(problems, ["fc.weight holds values that are not finite"]);
}

#[test]
fn a_variance_below_0_is_refused() {
    let changed = |by: f64| {
        load_changed(|tensors| {
            let mut all = tensors.iter_mut();
            let (_, variance) = all.find(|(name, _)| name == "bn.running_var").unwrap();
            *variance = (&*variance - by).unwrap();
        })
    };
    // They are 5 and 5.125.
    assert!(changed(5.0).is_ok());
    let problems = changed(5.0625).unwrap_err();
    assert_eq!(problems, ["bn.running_var holds a variance below 0"]);
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

#[test]
fn safetensors_of_wrapped_models_are_read_alike() {
    for prefix in [
        "module.",
        "_orig_mod.",
        "module._orig_mod.",
        "_orig_mod.module._orig_mod.",
        "model.",
        "model._orig_mod.module.",
        "state_dict.net.module.",
        "_fsdp_wrapped_module.",
    ] {
        let loaded = load_changed(|tensors| {
            for (name, _) in tensors.iter_mut() {
                *name = format!("{prefix}{name}");
            }
            // Not the model's.
            let other = tensors[0].1.clone();
            tensors.push(("criterion.weight".to_owned(), other));
        });
        assert_eq!(loaded.unwrap(), written(), "{prefix}");
    }
    let loaded = load_changed(|tensors| {
        for (name, _) in tensors.iter_mut() {
            *name = name.replace("fc.", "fc._checkpoint_wrapped_module.");
        }
    });
    assert_eq!(loaded.unwrap(), written());
}

#[test]
fn what_is_below_the_model_s_prefix_must_be_its_own() {
    let problems = load_changed(|tensors| {
        for (name, _) in tensors.iter_mut() {
            *name = format!("module.{name}");
        }
        let other = tensors[0].1.clone();
        tensors.push(("module.gn.weight".to_owned(), other.clone()));
        tensors.push(("loss.weight".to_owned(), other));
    })
    .unwrap_err();
    assert_eq!(
        problems,
        [
            "module.gn.weight is not part of the model",
            "the file holds besides: loss.weight"
        ]
    );
}

/// A tensor may not come twice, whatever is put before its name.
#[test]
fn two_tensors_for_one_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let source = tiny();
    let mut tensors: HashMap<String, Tensor> = detached(&source).into_iter().collect();
    tensors.insert("fc.module.bias".to_owned(), tensors["fc.bias"].clone());
    safetensors::save(&tensors, &path).unwrap();
    let error = load(&path, &source).unwrap_err().to_string();
    let told = "fc.bias and fc.module.bias are one";
    assert!(error.contains(told), "{error}");
}

/// With every name wrong, some of those looked for and some of those found.
#[test]
fn another_model_s_file_is_told_in_a_few_lines() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights.safetensors");
    let unet = built(ModelKind::RadioUnet, Preset::Small, 1);
    let vit = built(ModelKind::VitReg, Preset::Small, 2);
    save(&path, &unet, None).unwrap();
    let error = load(&path, &vit).unwrap_err();
    let Error::WeightsMismatch { problems, .. } = error else {
        panic!("{error}")
    };
    assert_eq!(problems.len(), 50, "{problems:#?}");
    assert_eq!(problems[0], "head.0.bias has the shape [128], not [192]");
    assert!(problems[24].starts_with("and "), "{problems:#?}");
    let first = "bottleneck.block.0.bias is not part of the model";
    assert_eq!(problems[25], first);
    // Nothing is told twice.
    let mut once = problems.clone();
    once.sort();
    once.dedup();
    assert_eq!(once.len(), problems.len());
}
