//! torchvision's state dicts, of today and of earlier releases: names and shapes as torchvision lists them.

use std::fs;
use std::io::Write;
use std::path::Path;

use aps_model::candle_core::{DType, Device, Tensor, safetensors};
use aps_model::candle_nn::VarMap;
use aps_model::weights::{LoadReport, load_pretrained};
use aps_model::{ModelKind, Preset};
use serde_json::Value;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::backbone::regularizer;
use super::{built, get, golden};

/// Names and shapes.
fn listed(list: &str) -> Vec<(String, Vec<usize>)> {
    let text = fs::read_to_string(golden(&format!("torchvision_{list}.json"))).unwrap();
    let Value::Object(entries) = serde_json::from_str(&text).unwrap() else {
        panic!("{list} is no object")
    };
    let entry = |(name, shape)| (name, serde_json::from_value(shape).unwrap());
    entries.into_iter().map(entry).collect()
}

/// The one value of a tensor of a list, by its place: an eighth of it, which 16 bits of either kind hold.
fn value(place: usize) -> f32 {
    place as f32 / 8.0
}

fn is_counter(name: &str) -> bool {
    name.ends_with("num_batches_tracked")
}

fn write_safetensors(path: &Path, list: &[(String, Vec<usize>)]) {
    let tensor = |(place, (name, shape)): (usize, &(String, Vec<usize>))| {
        let (value, shape) = (value(place), shape.as_slice());
        let dtype = match is_counter(name) {
            true => DType::I64,
            false => DType::F16,
        };
        let one = Tensor::new(value, &Device::Cpu).unwrap();
        let one = one.to_dtype(dtype).unwrap();
        let full = one.broadcast_as(shape).unwrap().contiguous().unwrap();
        (name.clone(), full)
    };
    let tensors = list.iter().enumerate().map(tensor).collect();
    safetensors::save(&tensors, path).unwrap();
}

/// A file as `torch.save` writes it, of a checkpoint with the state dict under `key`.
fn write_pt(path: &Path, key: &str, list: &[(String, Vec<usize>)]) {
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let mut zip = ZipWriter::new(fs::File::create(path).unwrap());
    let mut pickle = Pickle(b"\x80\x02}(".to_vec());
    pickle.text("epoch").int(3).text(key).op(b"}(");
    for (place, (name, shape)) in list.iter().enumerate() {
        let elements: usize = shape.iter().product();
        let (storage, bytes) = match is_counter(name) {
            true => ("LongStorage", (place as i64).to_le_bytes().to_vec()),
            false => {
                let [_, _, low, high] = value(place).to_le_bytes();
                ("BFloat16Storage", [low, high].repeat(elements))
            }
        };
        let rebuild = b"ctorch._utils\n_rebuild_tensor_v2\n((";
        let storage = format!("ctorch\n{storage}\n");
        pickle.text(name).op(rebuild);
        pickle.text("storage").op(storage.as_bytes());
        pickle.text(&place.to_string()).text("cpu");
        pickle.int(elements).op(b"tQ");
        let stride = |at: usize| shape[at + 1..].iter().product();
        pickle.int(0).tuple(shape.iter().copied());
        pickle.tuple((0..shape.len()).map(stride)).op(b"\x89}tR");
        let file = format!("archive/data/{place}");
        zip.start_file(file, options).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.start_file("archive/data.pkl", options).unwrap();
    zip.write_all(&pickle.op(b"uu.").0).unwrap();
    zip.finish().unwrap();
}

/// Instructions of protocol 2.
struct Pickle(Vec<u8>);

impl Pickle {
    fn op(&mut self, code: &[u8]) -> &mut Self {
        self.0.extend(code);
        self
    }

    fn text(&mut self, text: &str) -> &mut Self {
        let length = u32::try_from(text.len()).unwrap().to_le_bytes();
        self.op(b"X").op(&length).op(text.as_bytes())
    }

    fn int(&mut self, n: usize) -> &mut Self {
        self.op(b"J").op(&i32::try_from(n).unwrap().to_le_bytes())
    }

    fn tuple(&mut self, items: impl Iterator<Item = usize>) -> &mut Self {
        self.op(b"(");
        for item in items {
            self.int(item);
        }
        self.op(b"t")
    }
}

/// First and last value of a tensor.
fn ends(tensor: &Tensor) -> [f32; 2] {
    let flat = tensor.flatten_all().unwrap().to_dtype(DType::F32).unwrap();
    let end = |at| flat.get(at).unwrap().to_scalar().unwrap();
    [end(0), end(flat.elem_count() - 1)]
}

/// Loads a file of a list into the backbone of `parameters`, below `place`, and checks every tensor of it.
fn check(list: &str, prefix: &str, form: &str, parameters: &VarMap, place: &str) -> LoadReport {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights");
    let tensors = listed(list);
    let mut prefixed = tensors.clone();
    for (name, _) in &mut prefixed {
        name.insert_str(0, prefix);
    }
    match form {
        "pt" => write_pt(&path, "model", &prefixed),
        _ => write_safetensors(&path, &prefixed),
    }
    let report = load_pretrained(&path, parameters).unwrap();
    let mut compared = 0;
    for (at, (name, _)) in tensors.iter().enumerate() {
        let today = name.replace("linear_1", "0").replace("linear_2", "3");
        // The first layers in an encoder of several scales.
        let stem = [("conv1.", "stem.0."), ("bn1.", "stem.1.")]
            .iter()
            .find_map(|(theirs, ours)| {
                let rest = today.strip_prefix(theirs)?;
                Some(format!("{ours}{rest}"))
            });
        let own = |name: &str| get(parameters, &format!("{place}{name}"));
        let Some(tensor) = own(&today).or(stem.and_then(|name| own(&name))) else {
            let dropped = report.dropped.iter().any(|dropped| dropped.ends_with(name));
            assert!(dropped, "{list}: {name} is neither used nor told of");
            continue;
        };
        let expected = match is_counter(name) {
            true => (at as f32 / if form == "pt" { 1.0 } else { 8.0 }).trunc(),
            false => value(at),
        };
        assert_eq!(ends(tensor.as_tensor()), [expected; 2], "{list}: {name}");
        compared += 1;
    }
    assert_eq!(compared, report.loaded, "{list}");
    report
}

#[test]
fn resnet_18_fills_a_backbone() {
    let plain = built(ModelKind::ResnetMlp, Preset::Paper, 1);
    let scales = built(ModelKind::MsMlp, Preset::Paper, 1);
    let forms = [
        ("", "safetensors"),
        ("", "pt"),
        ("_orig_mod.module.", "pt"),
        ("model.", "safetensors"),
    ];
    for (prefix, form) in forms {
        for parameters in [&plain, &scales] {
            for (list, expected) in [("resnet18", [120, 2, 0]), ("resnet18_old", [100, 2, 20])] {
                let report = check(list, prefix, form, parameters, "encoder.");
                let found = [report.loaded, report.dropped.len(), report.zeroed.len()];
                assert_eq!(found, expected, "{list}");
            }
        }
    }
    let critic = regularizer(Preset::Paper);
    let (form, place) = ("safetensors", "cond_encoder.");
    let report = check("resnet18", "module.", form, &critic, place);
    assert_eq!(report.loaded, 120);
}

#[test]
fn vit_b_16_fills_a_backbone() {
    let parameters = built(ModelKind::VitReg, Preset::Paper, 1);
    for (list, prefix, form, below) in [
        ("vit_b_16", "", "safetensors", ""),
        ("vit_b_16_old", "module.", "pt", "model.module."),
    ] {
        let report = check(list, prefix, form, &parameters, "vit.").to_string();
        let dropped = format!("{below}heads.head.bias, {below}heads.head.weight");
        let expected = format!("150 tensors loaded; left out: {dropped}");
        assert_eq!(report, expected);
    }
}

#[test]
fn another_backbone_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights");
    let resnet = built(ModelKind::ResnetMlp, Preset::Paper, 1);
    // A block more than a ResNet-18 has, as a ResNet-34.
    let mut deeper = listed("resnet18");
    let more = |(name, shape): &(String, Vec<usize>)| {
        let rest = name.strip_prefix("layer1.1.")?;
        Some((format!("layer1.2.{rest}"), shape.clone()))
    };
    deeper.extend(deeper.clone().iter().filter_map(more));
    write_safetensors(&path, &deeper);
    let error = load_pretrained(&path, &resnet).unwrap_err().to_string();
    let told = "layer1.2.bn1.bias is not part of the model";
    assert!(error.contains(told), "{error}");
    // One for the other.
    let vit = built(ModelKind::VitReg, Preset::Small, 2);
    write_safetensors(&path, &listed("resnet18"));
    let error = load_pretrained(&path, &vit).unwrap_err().to_string();
    for told in [
        "vit.class_token [1, 1, 192] is missing",
        "bn1.bias is not part of the model",
    ] {
        assert!(error.contains(told), "{error}");
    }
    assert!(error.lines().count() < 55, "{error}");
}
