//! The commands as a user meets them: a small data set, a few steps, their files, their errors.

#[path = "../../../tests/end_to_end/command.rs"]
mod command;
#[path = "../../../tests/end_to_end/lobes.rs"]
mod lobes;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use aps_data::{Dataset, Part, npy};
use serde_json::{Value, json};
use tempfile::TempDir;

use command::{assert_told, fail, remarks, succeed, words};
use lobes::{BINS, dataset_of};

const PROGRAM: &str = env!("CARGO_BIN_EXE_xtask-models");

/// The committed maps and data sets.
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data");

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn dataset() -> &'static Path {
    static DATASET: OnceLock<TempDir> = OnceLock::new();
    DATASET.get_or_init(|| dataset_of("paper")).path()
}

/// The command of a short training of `model` into `out`.
fn training(model: &str, out: &Path, more: &str) -> String {
    let (data, out) = (text(dataset()), text(out));
    format!("train --model {model} --data {data} --image-size 32 --batch 10 --out {out} {more}")
}

struct Trained {
    folder: TempDir,
    report: String,
}

/// A run of two epochs of three steps.
fn trained() -> &'static Trained {
    static TRAINED: OnceLock<Trained> = OnceLock::new();
    TRAINED.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let report = succeed(&training("resnet_mlp", &run, "--epochs 2"));
        Trained { folder, report }
    })
}

fn file(name: &str) -> PathBuf {
    trained().folder.path().join("run").join(name)
}

fn lines(path: &Path) -> usize {
    fs::read_to_string(path).unwrap().lines().count()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn training_leaves_weights_logs_and_every_setting() {
    let report = &trained().report;
    assert_told(report, &["mean training spectrum", "best, epoch"]);
    assert_eq!(
        (lines(&file("steps.csv")), lines(&file("scores.csv"))),
        (1 + 6, 1 + 2)
    );
    let config = json(&file("config.json"));
    assert_eq!(config["model"], "resnet_mlp");
    assert_eq!(config["train_maps"], json!([0, 1]));
    assert_eq!(config["dev_maps"], json!([2]));
    assert_eq!(config["train_links"], 30);
    assert_eq!(config["dev_links"], 15);
    assert_eq!(config["training"]["batch"], 10);
    assert!(file("best.safetensors").is_file());
}

#[test]
fn stopped_run_continues_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let again = folder.path().join("again");
    // Scores after 2, 3 (an epoch), 4 and 6 steps.
    let all = "--epochs 2 --score-every 2 --l1-weight 50";
    let line =
        |out: &Path, more: &str| training("ms_areg", out, &format!("{all} --threads 1 {more}"));
    let kill_after_an_epoch = |out: &Path| {
        let mut child = Command::new(PROGRAM)
            .args(words(&training("ms_areg", out, all)))
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        while !out.join("best.safetensors").is_file() && child.try_wait().unwrap().is_none() {
            std::thread::yield_now();
        }
        // The run may have ended by now: in either case it must be continued from its files.
        let _ = child.kill();
        child.wait().unwrap();
    };
    succeed(&line(&out, ""));
    let scores = fs::read_to_string(out.join("scores.csv")).unwrap();
    let made = scores.lines().skip(1).map(|row| row.split(',').next());
    assert!(made.eq(["2", "3", "4", "6"].map(Some)), "{scores}");
    kill_after_an_epoch(&again);
    succeed(&line(&again, "--resume"));
    for name in [
        "steps.csv",
        "scores.csv",
        "best.safetensors",
        "last.safetensors",
    ] {
        let read = |folder: &Path| fs::read(folder.join(name)).unwrap();
        assert!(read(&out) == read(&again), "{name}");
    }
}

#[test]
fn predictions_are_rows_of_the_test_links() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("pred.npy");
    let (weights, data) = (file("best.safetensors"), dataset());
    let [weights, data_arg, out_arg] = [&weights, data, &out].map(text);
    succeed(&format!(
        "predict --weights {weights} --data {data_arg} --split test --out {out_arg}"
    ));
    let spectra = npy::read::<f32>(&out).unwrap();
    let dataset = Dataset::open(data).unwrap();
    let map = dataset.maps_of(Part::Test).next().unwrap().unwrap();
    let valid: Vec<usize> = map.valid_links().collect();
    assert_eq!(spectra.shape, [valid.len(), BINS]);
    assert!(spectra.data.iter().all(|x| x.is_finite()));
    let names = fs::read_to_string(folder.path().join("pred.links.csv")).unwrap();
    let rows = names.lines().skip(1).map(|line| line.split(',').collect());
    let rows: Vec<Vec<&str>> = rows.collect();
    assert_eq!(rows.len(), valid.len());
    for (i, (row, &link)) in rows.iter().zip(&valid).enumerate() {
        assert_eq!(row[..3], [i.to_string(), "3".into(), link.to_string()]);
        let rx_m: [f64; 2] = [row[7].parse().unwrap(), row[8].parse().unwrap()];
        assert_eq!(rx_m, map.ends_m(link).1);
    }
}

/// A file stays until something whole takes its place.
#[test]
fn a_prediction_that_fails_leaves_the_one_before_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("pred.npy");
    let [dataset, city] = ["shipped", "helsinki.geojson"].map(|name| Path::new(DATA).join(name));
    let (dataset, city, out) = (text(&dataset), text(&city), text(&out));
    let predict = format!("predict --model polar_reg --data '{dataset}' --out {out}");
    succeed(&format!("{predict} --maps '{city}'"));
    let files = || {
        let entries = fs::read_dir(folder.path()).unwrap();
        let of = |path: PathBuf| (path.clone(), fs::read(path).unwrap());
        let mut all: Vec<_> = entries.map(|entry| of(entry.unwrap().path())).collect();
        all.sort();
        all
    };
    let before = files();
    assert_eq!(before.len(), 2);
    assert_told(&fail(&predict), &["--maps"]);
    assert!(files() == before, "the files changed");
}

/// Without a file of weights, on the small data set that the scores of the shipped ones are stated for.
#[test]
fn shipped_weights_predict_where_no_file_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("pred.npy");
    let [dataset, city] = ["shipped", "helsinki.geojson"].map(|name| Path::new(DATA).join(name));
    let opened = Dataset::open(&dataset).unwrap();
    let links = opened.maps_of(Part::Test);
    let links: usize = links.map(|map| map.unwrap().valid_links().count()).sum();
    let predict = format!("predict --out {} --model", text(&out));
    for (model, maps) in [
        ("ms_areg", String::new()),
        ("polar_reg", format!("--maps '{}'", text(&city))),
    ] {
        succeed(&format!(
            "{predict} {model} --data '{}' {maps}",
            text(&dataset)
        ));
        let spectra = npy::read::<f32>(&out).unwrap();
        assert_eq!(spectra.shape, [links, BINS], "{model}");
        assert!(spectra.data.iter().all(|x| x.is_finite()), "{model}");
    }
    let other = dataset_of("released");
    let told = fail(&format!("{predict} ms_areg --data {}", text(other.path())));
    assert!(told.contains("half a turn"), "{told}");
}

/// Labels of other settings are predicted, and told.
#[test]
fn labels_of_other_settings_are_told() {
    let (folder, other) = (tempfile::tempdir().unwrap(), dataset_of("paper"));
    let (out, weights) = (folder.path().join("pred.npy"), file("best.safetensors"));
    let predict = format!("predict --weights {} --out {}", text(&weights), text(&out));
    let told = |data: &Path| remarks(&format!("{predict} --data {}", text(data)));
    let silent = told(dataset());
    assert!(!silent.contains("other labels"), "{silent}");
    let of_maps = (0..4).map(|id| format!("map_{id:04}/map.json"));
    for name in of_maps.chain(["manifest.json".into()]) {
        let path = other.path().join(name);
        let json = fs::read_to_string(&path).unwrap();
        let changed = json.replace("\"protocol\"", "\"sampling_rate_hz\": 1e8, \"protocol\"");
        fs::write(path, changed).unwrap();
    }
    let difference = "sampling_rate_hz: not told in the training, 100000000.0 here";
    assert_told(&told(other.path()), &["other labels", difference]);
}

/// Metadata of somebody else's say nothing about the model, which must then be named.
#[test]
fn weights_with_foreign_metadata_need_the_model_named() {
    let folder = tempfile::tempdir().unwrap();
    let [weights, out] = ["w.safetensors", "o.npy"].map(|name| folder.path().join(name));
    let mut bytes = fs::read(file("best.safetensors")).unwrap();
    let label = b"resnet_mlp small";
    let at = bytes.windows(label.len()).position(|w| w == label).unwrap();
    bytes[at..][..label.len()].copy_from_slice(b"resnet18 imagene");
    fs::write(&weights, bytes).unwrap();
    let predict = format!(
        "predict --weights {} --data {} --image-size 32 --out {}",
        text(&weights),
        text(dataset()),
        text(&out)
    );
    assert_told(&fail(&predict), &["resnet18 imagene", "--model"]);
    succeed(&format!("{predict} --model resnet_mlp --preset small"));
}

#[test]
fn a_size_of_images_that_nothing_tells_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let weights = folder.path().join("w.safetensors");
    fs::copy(file("best.safetensors"), &weights).unwrap();
    let [npy, onnx] = ["o.npy", "o.onnx"].map(|name| folder.path().join(name));
    let predict = format!("predict --data {} --out {}", text(dataset()), text(&npy));
    let export = format!("export-onnx --overwrite --out {}", text(&onnx));
    let assumed = ["nothing tells the size", "64 pixels", "--image-size"];
    for command in [predict, export] {
        let command = format!("{command} --weights");
        let alone = format!("{command} {}", text(&weights));
        assert_told(&remarks(&alone), &assumed);
        let in_its_run = format!("{command} {}", text(&file("best.safetensors")));
        for known in [format!("{alone} --image-size 32"), in_its_run] {
            let told = remarks(&known);
            assert!(!told.contains("nothing tells the size"), "{known}: {told}");
        }
    }
}

#[test]
fn an_exported_model_tells_what_it_was_trained_on_and_replaces_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let (weights, out) = (file("best.safetensors"), folder.path().join("m.onnx"));
    let export = format!("export-onnx --weights {}", text(&weights));
    let line = format!("{export} --out {}", text(&out));
    assert_told(&succeed(&line), &["images of 32 pixels"]);
    let bytes = fs::read(&out).unwrap();
    let has = |words: &str| bytes.windows(words.len()).any(|w| w == words.as_bytes());
    for words in [
        "image_size",
        "sigma_px",
        "training_statistics",
        "{\"array\":{\"uniform_linear\":{}},\"protocol\":\"paper\"}",
    ] {
        assert!(has(words), "{words}");
    }

    assert_told(&fail(&line), &["m.onnx", "--overwrite"]);
    let line = format!("{line} --overwrite --image-size 48");
    assert!(succeed(&line).contains("48 pixels"));
    assert_ne!(fs::read(&out).unwrap(), bytes);
    let told = fail(&format!("{line} --model ms_mlp"));
    assert_told(&told, &["resnet_mlp", "ms_mlp"]);

    let shipped = folder.path().join("shipped.onnx");
    let line = format!("export-onnx --model polar_reg --out {}", text(&shipped));
    assert!(succeed(&line).contains("polar_reg"));
    assert!(fail("export-onnx --model ms_mlp --out no.onnx").contains("polar_reg"));
    let told = fail("export-onnx --model ms_areg --preset paper --out no.onnx");
    assert_told(&told, &["come with the program", "preset small"]);
    let told = fail(&format!("{line} --overwrite --image-size 32"));
    assert_told(&told, &["polar_reg takes no condition images"]);
    let none = folder.path().join("none.onnx");
    let told = fail(&format!("{export} --image-size 0 --out {}", text(&none)));
    assert!(told.contains("must be 1 to 4096"), "{told}");
}

#[test]
fn what_does_not_fit_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("pred.npy");
    let weights = file("best.safetensors");
    let predict = |weights: &Path, data: &Path, more: &str| {
        let [weights, data, out] = [weights, data, out.as_path()].map(text);
        fail(&format!(
            "predict --weights {weights} --data {data} --out {out} {more}"
        ))
    };
    let told = predict(&weights, dataset(), "--model ms_mlp");
    assert_told(&told, &["resnet_mlp", "ms_mlp"]);
    let told = predict(&weights, dataset(), "--preset paper");
    assert_told(&told, &["small", "paper"]);
    let other = dataset_of("released");
    let told = predict(&weights, other.path(), "");
    assert_told(&told, &["half a turn", "--protocol paper", "relabel"]);
    assert!(!out.exists());
    let foreign = folder.path().join("foreign.safetensors");
    fs::write(&foreign, b"nothing of the kind").unwrap();
    assert!(predict(&foreign, dataset(), "--model ms_mlp").contains("foreign.safetensors"));
    assert!(predict(&folder.path().join("none"), dataset(), "").contains("none"));

    let run = trained().folder.path().join("run");
    assert!(fail(&training("resnet_mlp", &run, "")).contains("--resume"));
    let told = fail(&training("resnet_mlp", &run, "--epochs 3 --resume"));
    assert!(told.contains("epochs"), "{told}");
    let new = folder.path().join("new");
    assert!(fail(&training("resnet_mlp", &new, "--resume")).contains("no run"));
    assert!(fail(&training("resnet_mlp", &new, "--dev-maps 3")).contains("map 3"));
    assert!(fail(&training("resnet", &new, "")).contains("resnet_mlp"));
    assert!(fail(&training("ms_mlp", &new, "--l1-weight 1")).contains("ms_areg"));
    assert!(fail(&training("polar_reg", &new, "")).contains("--image-size is for"));
    assert!(fail(&training("resnet_mlp", dataset(), "")).contains("folder of a data set"));
    let warm = format!("--warm-start {}", text(&weights));
    let told = fail(&training("ms_mlp", &new, &warm));
    assert_told(&told, &["best.safetensors", "encoder.stem.0.weight"]);
}

#[test]
fn a_run_begins_with_the_weights_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    succeed(&training("ms_mlp", &first, "--epochs 1"));
    let weights = first.join("best.safetensors");
    let more = format!("--epochs 1 --warm-start {}", text(&weights));
    let told = remarks(&training("ms_areg", &second, &more));
    assert_told(&told, &["kept: noise_proj.bias, noise_proj.weight"]);
    let config = json(&second.join("config.json"));
    let told = config["initial_weights"].as_str().unwrap();
    assert!(told.contains(text(&weights)), "{told}");
}

/// Mirror images make four examples of each link that is drawn.
#[test]
fn a_part_of_the_links_is_drawn_and_mirrored_and_other_maps_can_be_held_out() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let more = "--epochs 1 --limit 20 --mirror --dev-maps 0 --dev-limit 7";
    succeed(&training("resnet_mlp", &out, more));
    assert_eq!(lines(&out.join("steps.csv")), 1 + 4 * 20 / 10);
    let config = json(&out.join("config.json"));
    assert_eq!(config["mirrored"], true);
    assert_eq!(config["train_maps"], json!([1, 2]));
    assert_eq!(config["train_links"], 20);
    assert_eq!(config["dev_links"], 7);
}
