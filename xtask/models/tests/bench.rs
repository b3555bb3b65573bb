//! The benchmark as a user meets it: its flags, and what it prints. Package `aps-bench` tests what it does.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use aps_report::benchmark::{EntryKind, Results};
use tempfile::TempDir;

/// The entries of the weights that come with the program.
const SHIPPED: [&str; 2] = ["MS-AReg, shipped", "Polar-Reg, shipped"];

fn run(out: &Path, more: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask-models"))
        .args(["bench-models", "--profile", "smoke", "--out"])
        .arg(out)
        .args(more.split_whitespace())
        .output()
        .expect("the program starts")
}

/// The shipped weights learnt labels of the protocol `paper`, whose angles are half a turn from those of `released`. Files that are not
/// there fail by themselves.
#[test]
fn shipped_weights_are_left_out_where_labels_mean_something_else() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("bench");
    let config = folder.path().join("bench.toml");
    fs::write(&config, "[training]\nbatch = 9\nbudget = '1h'\n").unwrap();
    let more = "--models resnet_mlp --set training.epochs=1 --set data.protocol=released --seed 7 --limits r2d1 \
                --external own=none.npy --weights mine=none.safetensors --config";
    let output = run(&out, &format!("{more} {}", config.display()));
    let [told, remarks] =
        [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    let is_told = remarks.contains("error: failed entries: 2; the report holds the others");
    assert!(!output.status.success() && is_told, "{remarks}");
    let results = Results::load(&out).unwrap();
    assert_eq!(results.profile, "custom");
    let setting = |pointer: &str| results.configuration.pointer(pointer).unwrap().to_string();
    let [seed, batch, epochs] = ["/seed", "/training/batch", "/training/epochs"].map(setting);
    assert_eq!([&*seed, &batch, &epochs], ["7", "9", "1"]);
    assert_eq!(setting("/data/limits"), "\"r2d1\"");
    let of_tracer = results
        .entries
        .iter()
        .filter(|e| e.kind == EntryKind::Tracer);
    let most = of_tracer.map(|e| &*e.name).max();
    assert_eq!(most, Some("tracer, 3 interactions"));
    assert!(!results.machine.rustc.is_empty() && results.machine.memory_bytes > 0);
    assert_eq!(results.data.protocol, "released");
    assert!(!results.entries.iter().any(|e| e.kind == EntryKind::Shipped));
    assert!(results.entries.iter().any(|e| e.kind == EntryKind::Model));
    let left_out = &results.left_out;
    assert!(left_out.iter().map(|r| &*r.name).eq(SHIPPED));
    let reason = "protocol: paper in the training, released here";
    assert!(left_out[0].message.contains(reason), "{left_out:?}");
    let failed = results.failed.iter().map(|failure| &*failure.name);
    assert!(failed.eq(["mine", "own"]), "{:?}", results.failed);
    for line in [
        "failed: own: ",
        "left out: MS-AReg, shipped: ",
        "report.html",
    ] {
        assert!(told.contains(line), "{told}");
    }
    for remark in ["[1/13] data set, ", "mine failed, the others go on: "] {
        assert!(remarks.contains(remark), "{remarks}");
    }
    let page = fs::read_to_string(out.join("report.md")).unwrap();
    assert!(page.contains("Left out") && page.contains(reason), "{page}");
}

/// A flag wins over a file. The only model fails before its first step.
#[test]
fn a_benchmark_without_a_model_fails_and_keeps_its_report() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("bench");
    let more = "--models resnet_mlp --budget 7s --set model.resnet_mlp.learning_rate=-1";
    let output = run(&out, more);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && told.contains("error: every model failed"),
        "{told}"
    );
    let results = Results::load(&out).unwrap();
    assert_eq!(results.configuration["training"]["budget"], "7s");
    assert_eq!(results.failed[0].name, "ResNet-MLP");
}

#[test]
fn folder_of_something_else_is_left_alone_and_the_option_named() {
    let folder = TempDir::new().unwrap();
    let own = folder.path().join("data");
    fs::create_dir(&own).unwrap();
    let output = run(folder.path(), "");
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("give another --out"));
    assert!(own.is_dir());
}
