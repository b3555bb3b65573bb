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
    entries
        .into_iter()
        .map(|(name, shape)| (name, serde_json::from_value(shape).unwrap()))
        .collect()
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
        pickle
            .text(name)
            .op(b"ctorch._utils\n_rebuild_tensor_v2\n((");
        pickle
            .text("storage")
            .op(format!("ctorch\n{storage}\n").as_bytes());
        pickle
            .text(&place.to_string())
            .text("cpu")
            .int(elements)
            .op(b"tQ");
        let stride = |at: usize| shape[at + 1..].iter().product();
        pickle.int(0).tuple(shape.iter().copied());
        pickle.tuple((0..shape.len()).map(stride)).op(b"\x89}tR");
        zip.start_file(format!("archive/data/{place}"), options)
            .unwrap();
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
        items.for_each(|item| {
            self.int(item);
        });
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
    let prefixed = tensors
        .iter()
        .map(|(name, shape)| (format!("{prefix}{name}"), shape.clone()));
    let prefixed: Vec<(String, Vec<usize>)> = prefixed.collect();
    match form {
        "pt" => write_pt(&path, "model", &prefixed),
        _ => write_safetensors(&path, &prefixed),
    }
    let report = load_pretrained(&path, parameters).unwrap();
    let mut compared = 0;
    for (at, (name, _)) in tensors.iter().enumerate() {
        let today = name.replace("linear_1", "0").replace("linear_2", "3");
        let stem = today
            .strip_prefix("conv1.")
            .map(|rest| format!("stem.0.{rest}"));
        let stem = stem.or(today
            .strip_prefix("bn1.")
            .map(|rest| format!("stem.1.{rest}")));
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
            let report = check("resnet18", prefix, form, parameters, "encoder.");
            assert_eq!(
                (report.loaded, report.dropped.len(), report.zeroed.len()),
                (120, 2, 0)
            );
            let report = check("resnet18_old", prefix, form, parameters, "encoder.");
            assert_eq!(
                (report.loaded, report.dropped.len(), report.zeroed.len()),
                (100, 2, 20)
            );
        }
    }
    let critic = regularizer(Preset::Paper);
    let report = check(
        "resnet18",
        "module.",
        "safetensors",
        &critic,
        "cond_encoder.",
    );
    assert_eq!(report.loaded, 120);
}

#[test]
fn vit_b_16_fills_a_backbone() {
    let parameters = built(ModelKind::VitReg, Preset::Paper, 1);
    let report = check("vit_b_16", "", "safetensors", &parameters, "vit.");
    assert_eq!(
        report.to_string(),
        "150 tensors loaded; left out: heads.head.bias, heads.head.weight"
    );
    let report = check("vit_b_16_old", "module.", "pt", &parameters, "vit.");
    assert_eq!(
        report.to_string(),
        "150 tensors loaded; left out: model.module.heads.head.bias, model.module.heads.head.weight"
    );
}

#[test]
fn another_backbone_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("weights");
    let resnet = built(ModelKind::ResnetMlp, Preset::Paper, 1);
    // A block more than a ResNet-18 has, as a ResNet-34.
    let mut deeper = listed("resnet18");
    let block: Vec<(String, Vec<usize>)> = deeper
        .iter()
        .filter_map(|(name, shape)| {
            let rest = name.strip_prefix("layer1.1.")?;
            Some((format!("layer1.2.{rest}"), shape.clone()))
        })
        .collect();
    deeper.extend(block);
    write_safetensors(&path, &deeper);
    let error = load_pretrained(&path, &resnet).unwrap_err().to_string();
    assert!(
        error.contains("layer1.2.bn1.bias is not part of the model"),
        "{error}"
    );
    // One for the other.
    let vit = built(ModelKind::VitReg, Preset::Small, 2);
    write_safetensors(&path, &listed("resnet18"));
    let error = load_pretrained(&path, &vit).unwrap_err().to_string();
    assert!(
        error.contains("vit.class_token [1, 1, 192] is missing"),
        "{error}"
    );
    assert!(
        error.contains("bn1.bias is not part of the model"),
        "{error}"
    );
    assert!(error.lines().count() < 55, "{error}");
}
