//! The benchmark as a user meets it: the smoke profile, run again with changes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use aps_data::npy;
use aps_model::ModelKind;
use aps_report::benchmark::{Entry, EntryKind, Results, ScoreTable};
use tempfile::TempDir;

/// The entries of the weights that come with the program.
const SHIPPED: [&str; 2] = ["MS-AReg, shipped", "Polar-Reg, shipped"];

fn run(out: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask-models"))
        .args(["bench-models", "--profile", "smoke", "--out"])
        .arg(out)
        .args(more)
        .output()
        .expect("the program starts")
}

#[track_caller]
fn results(out: &Path, more: &[&str]) -> Results {
    let output = run(out, more);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{more:?}: {stderr}");
    Results::load(out).unwrap()
}

fn entry<'a>(results: &'a Results, name: &str) -> &'a Entry {
    let found = results.entries.iter().find(|e| e.name == name);
    found.unwrap_or_else(|| panic!("no entry {name}: {:?}", results.failed))
}

fn table(results: &Results, out: &Path, name: &str) -> ScoreTable {
    let scores = &entry(results, name).scores[0];
    ScoreTable::read(out, scores, results.links.len()).unwrap()
}

fn mean_cosine(results: &Results, out: &Path, name: &str) -> f64 {
    let table = table(results, out, name);
    let column = table.column(aps_metrics::Metric::Cosine).unwrap();
    column.iter().sum::<f64>() / column.len() as f64
}

#[test]
fn smoke_benchmark_is_whole_and_reused() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("bench");
    let first = results(&out, &[]);
    is_whole(&first, &out);

    // One model made to fail, one's own predictions and weights from outside: the other is not trained again.
    let copy = folder.path().join("own.npy");
    fs::copy(out.join("scores/resnet-mlp/prediction.npy"), &copy).unwrap();
    let config = folder.path().join("bench.toml");
    fs::write(&config, "[model.ms_areg]\nlearning_rate = -1.0\n").unwrap();
    let external = format!("own={}", copy.display());
    let best = out.join("models/resnet_mlp/best.safetensors");
    let weights = format!("weights={}", best.display());
    let config = config.to_str().unwrap();
    let settings = ["--config", config, "--models", "resnet_mlp,ms_areg"];
    let foreign = ["--external", &external, "--weights", &weights];
    let second = results(&out, &[settings, foreign].concat());
    assert_eq!(second.profile, "custom");
    assert_eq!(entry(&second, "ResNet-MLP"), entry(&first, "ResNet-MLP"));
    let trained = table(&first, &out, "ResNet-MLP");
    assert_eq!(table(&second, &out, "own"), trained);
    assert_eq!(entry(&second, "own").kind, EntryKind::External);
    let weights = entry(&second, "weights");
    assert_eq!(weights.kind, EntryKind::Shipped);
    assert_eq!(weights.training, None);
    assert_eq!(table(&second, &out, "weights"), trained);
    let [failure] = &second.failed[..] else {
        panic!("{:?}", second.failed);
    };
    assert_eq!(failure.name, "MS-AReg");
    let is_told = failure.message.contains("learning_rate");
    assert!(is_told, "{}", failure.message);
    let html = fs::read_to_string(out.join("report.html")).unwrap();
    let is_told = html.contains("learning_rate");
    assert!(is_told, "the report tells what failed");

    // Predictions of other links are refused, and nothing else suffers.
    npy::write(&copy, &[2, 180], &[0.0_f32; 360]).unwrap();
    let third = results(&out, &["--models", "resnet_mlp", "--external", &external]);
    let is_told = third.failed[0].message.contains("2 spectra");
    assert!(is_told, "{:?}", third.failed);
    assert!(!third.entries.iter().any(|e| e.name == "MS-AReg"));
}

#[track_caller]
fn is_whole(results: &Results, out: &Path) {
    assert_eq!(results.profile, "smoke");
    assert!(results.failed.is_empty(), "{:?}", results.failed);
    let data = &results.data;
    assert_eq!((data.train_maps.len(), data.test_maps.len()), (2, 1));
    assert_eq!(data.test_links + data.invalid_test_links, 36);
    assert_eq!(results.links.len() as u64, data.test_links);
    assert_eq!(results.examples.len(), 3);
    assert!(!results.machine.rustc.is_empty() && results.machine.memory_bytes > 0);
    for kind in ModelKind::ALL {
        let model = entry(results, kind.title());
        let training = model.training.as_ref().unwrap();
        let times: Vec<f64> = training.curve.iter().map(|p| p.seconds).collect();
        assert!(!times.is_empty() && times.len() <= 7 && times.is_sorted());
        assert!(training.seconds > 0.0, "{times:?}");
        assert!(training.links_seen > 0);
        // Weights are chosen by the metric that entries are ranked by; of equals the first.
        let cosines = training.curve.iter().filter_map(|p| p.dev_cosine);
        let highest = cosines.fold(f64::NEG_INFINITY, f64::max);
        let best = training.curve.iter();
        let best = best.filter(|p| p.dev_cosine == Some(highest));
        assert_eq!(training.best_steps, best.map(|p| p.steps).min(), "{kind}");
        let batches: Vec<usize> = model.latency.iter().map(|l| l.batch).collect();
        assert_eq!(batches, [1, 16]);
        let mut times = model.latency.iter();
        assert!(times.all(|l| l.p95_ms_per_link >= l.median_ms_per_link));
    }
    let shipped = |e: &&Entry| e.kind == EntryKind::Shipped;
    let shipped = results.entries.iter().filter(shipped);
    assert!(shipped.map(|e| &*e.name).eq(SHIPPED));
    assert!(results.left_out.is_empty(), "{:?}", results.left_out);
    // The tracer scores better with more of the interactions that the labels are made of.
    let cosine = |name| mean_cosine(results, out, name);
    assert!(cosine("tracer, 2 interactions") > cosine("tracer, 0 interactions"));
    assert!(cosine("tracer, 2 interactions") > cosine("mean spectrum"));
    // One path of each link, none of which lacks one: more than what is in sight, less than all.
    let strongest = cosine("strongest path");
    assert!(strongest > cosine("tracer, 0 interactions") && strongest < 0.999_999);
    assert_eq!(entry(results, "strongest path").substituted_links, 0);
    let shipped = entry(results, "Polar-Reg, shipped");
    assert_eq!(shipped.model.as_deref(), Some("Polar-Reg"));
    // The labels' own limits.
    assert!(cosine("tracer, 3 interactions") > 0.999_999);
    let in_sight = results.links.iter().filter(|l| l.line_of_sight).count() as u64;
    let direct = entry(results, "tracer, 0 interactions");
    assert_eq!(direct.substituted_links, data.test_links - in_sight);
    for file in ["report.html", "report.md", "configuration.json"] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

/// The shipped weights learnt labels of the protocol `paper`, whose angles are half a turn from those of `released`.
#[test]
fn shipped_weights_are_left_out_where_labels_mean_something_else() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("bench");
    let more = ["--models", "resnet_mlp", "--budget", "1s", "--set"];
    let results = results(&out, &[&more[..], &["data.protocol=released"]].concat());
    assert_eq!(results.data.protocol, "released");
    assert!(results.failed.is_empty(), "{:?}", results.failed);
    assert!(!results.entries.iter().any(|e| e.kind == EntryKind::Shipped));
    assert!(results.entries.iter().any(|e| e.kind == EntryKind::Model));
    let left_out = &results.left_out;
    assert!(left_out.iter().map(|r| &*r.name).eq(SHIPPED));
    let told = "protocol: paper in the training, released here";
    assert!(left_out[0].message.contains(told), "{left_out:?}");
    let page = fs::read_to_string(out.join("report.md")).unwrap();
    assert!(page.contains("Left out") && page.contains(told), "{page}");
}

#[test]
fn folder_of_something_else_is_left_alone() {
    let folder = TempDir::new().unwrap();
    let own = folder.path().join("data");
    fs::create_dir(&own).unwrap();
    let output = run(folder.path(), &[]);
    assert!(!output.status.success() && own.is_dir());
    assert!(String::from_utf8_lossy(&output.stderr).contains("--out"));
}
