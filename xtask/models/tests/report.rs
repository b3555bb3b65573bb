//! The study of models at its smallest: what is written, and that errors are those of single precision. Never times.

use std::fs;
use std::process::Command;

use aps_report::document::Block;
use tempfile::TempDir;
use xtask_studies::Study;

#[test]
fn study_of_models_is_whole_and_joins_the_report() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("report");
    let output = Command::new(env!("CARGO_BIN_EXE_xtask-models"))
        .args(["report", "--profile", "smoke", "--seed", "42", "--out"])
        .arg(&out)
        .arg("--work")
        .arg(folder.path().join("work"))
        .output()
        .expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");

    let text = fs::read_to_string(out.join("numerics.md")).unwrap();
    assert!(text.contains("cargo xtask report --study models --profile smoke --seed 42"));
    assert!(!text.contains("NaN"), "{text}");
    let study = Study::read(&out.join("numerics/models.json")).unwrap();
    let figures = study.section.blocks.iter();
    let figures = figures.filter(|block| matches!(block, Block::Figure(_)));
    assert_eq!(figures.count(), 2);

    let rows = |file: &str| -> Vec<csv::StringRecord> {
        let reader = csv::Reader::from_path(out.join("numerics").join(file));
        reader.unwrap().records().map(Result::unwrap).collect()
    };
    // model, precision, batch, time, relative error, largest error
    let singles: Vec<f64> = rows("models-precision.csv")
        .iter()
        .filter(|row| &row[1] == "f32")
        .map(|row| row[4].parse().unwrap())
        .collect();
    assert_eq!(singles.len(), 2);
    assert!(
        singles.iter().all(|e| (1e-9..1e-5).contains(e)),
        "{singles:?}"
    );
    // The report says so where a processor cannot compute in bf16.
    let halves = rows("models-precision.csv").len() > singles.len();
    assert!(halves || text.contains("in bf16 does not run here"));
    let pixels: Vec<String> = rows("models-images.csv")
        .iter()
        .map(|row| row[0].to_owned())
        .collect();
    assert_eq!(pixels, ["32", "64"]);
}
