//! `metrics`: a perfect prediction scores perfectly in every format, from files and against a data
//! set; what does not fit is told.

use std::fs;

use aps_data::{Dataset, Part, npy};
use aps_label::SAMPLE_EPSILON;
use serde_json::Value;

use crate::folder::Folder;
use crate::{assert_told, fail, succeed, xtask};

const PAPER_COLUMNS: [&str; 10] = [
    "MAE", "PSNR", "CosSim", "NMSE", "Angle", "PLE", "Hit@2", "Hit@4", "Rec.@2", "Rec.@4",
];

/// Spectra of one lobe each, of mean zero.
fn lobes(samples: usize) -> Vec<f32> {
    let value = |i: usize| {
        let (sample, bin) = ((i / 180) as f32, (i % 180) as f32);
        let distance = (bin - 20.0 - (sample * 7.0) % 140.0) / 4.0;
        (-0.5 * distance * distance).exp() - 0.05
    };
    (0..samples * 180).map(value).collect()
}

impl Folder {
    /// Writes an array and returns its path as an argument.
    fn write<T: npy::Element>(&self, name: &str, shape: &[usize], data: &[T]) -> String {
        npy::write(self.path(name), shape, data).unwrap();
        self.arg(name)
    }
}

fn json(line: &str) -> Value {
    serde_json::from_str(&succeed(&format!("{line} --format json"))).unwrap()
}

/// Mean of a metric over all samples.
fn mean(scores: &Value, metric: &str) -> f64 {
    mean_of(&scores["report"]["overall"], metric)
}

fn mean_of(group: &Value, metric: &str) -> f64 {
    let metrics = group["metrics"].as_array().unwrap();
    let found = metrics.iter().find(|m| m["metric"] == metric).unwrap();
    found["mean"].as_f64().unwrap()
}

#[track_caller]
fn assert_perfect(scores: &Value) {
    assert_eq!(scores["rejected"], 0);
    assert!(mean(scores, "mae") < 1e-9, "{}", mean(scores, "mae"));
    assert!((mean(scores, "cosine") - 1.0).abs() < 1e-12);
    assert_eq!(mean(scores, "nmse_db"), -120.0);
    assert_eq!(mean(scores, "ple_deg"), 0.0);
    for metric in ["recall_2deg", "recall_4deg"] {
        assert_eq!(mean(scores, metric), 1.0, "{metric}");
    }
}

#[test]
fn perfect_prediction_in_every_format() {
    let folder = Folder::new();
    let spectra = lobes(7);
    let truth = folder.write("truth.npy", &[7, 180], &spectra);
    let wide: Vec<f64> = spectra.iter().copied().map(f64::from).collect();
    let prediction = folder.write("prediction.npy", &[7, 180], &wide);
    let map_ids = folder.write("ids.npy", &[7], &[46_u32, 46, 46, 50, 50, 47, 47]);
    let files = format!("--truth {truth} --prediction {prediction} --map-ids {map_ids}");
    let line = format!("metrics {files} --protocol paper");
    let scored = |format: &str| succeed(&format!("{line} --format {format}"));

    let scores = json(&line);
    assert_perfect(&scores);
    assert_eq!(mean(&scores, "hit_2deg"), 1.0);
    assert_eq!(mean(&scores, "mirror_hit_2deg"), 1.0);
    assert_eq!(scores["protocol"], "paper");
    let maps = scores["report"]["maps"].as_array().unwrap();
    let ids: Vec<u64> = maps.iter().map(|m| m["map_id"].as_u64().unwrap()).collect();
    assert_eq!(ids, [46, 47, 50]);
    assert_eq!(maps[0]["group"]["samples"], 3);
    assert_eq!(mean_of(&maps[2]["group"], "hit_4deg"), 1.0);

    let text = scored("csv");
    let mut csv = csv::Reader::from_reader(text.as_bytes());
    let column = |name: &str, headers: &csv::StringRecord| {
        headers.iter().position(|h| h == name).expect("a column")
    };
    let headers = csv.headers().unwrap().clone();
    let (metric, median) = (column("metric", &headers), column("median", &headers));
    let records: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(records.len(), 4 * 16);
    let cosine = records.iter().find(|r| &r[metric] == "cosine").unwrap();
    assert!((cosine[median].parse::<f64>().unwrap() - 1.0).abs() < 1e-12);

    let table = scored("table");
    let heading = table.lines().find(|line| line.contains("MAE")).unwrap();
    let places = PAPER_COLUMNS.map(|name| heading.find(name).expect(name));
    assert!(places.is_sorted(), "{heading}");
    assert!(table.contains("map 47"), "{table}");

    let markdown = scored("markdown");
    let rows: Vec<Vec<&str>> = markdown
        .lines()
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), 2 + 4);
    assert!(rows.iter().all(|row| row.len() == 3 + 10 + 3), "{markdown}");
    for (cell, name) in rows[0][3..].iter().zip(PAPER_COLUMNS) {
        assert!(cell.starts_with(name), "{cell} is not {name}");
    }
    assert_eq!(rows[2][0], "all");
    assert_eq!(rows[2][5].parse::<f64>().unwrap(), 1.0);
}

#[test]
fn a_given_range_shifts_psnr() {
    let folder = Folder::new();
    let spectra = lobes(3);
    let shifted: Vec<f32> = spectra.iter().map(|x| x + 0.1).collect();
    let truth = folder.write("truth.npy", &[3, 180], &spectra);
    let prediction = folder.write("prediction.npy", &[3, 180], &shifted);
    let scores = json(&format!(
        "metrics --truth {truth} --prediction {prediction} --data-range 10"
    ));
    assert!((mean(&scores, "psnr_db") - 40.0).abs() < 1e-4);
    assert_eq!(scores["protocol"], "paper");
}

#[test]
fn decibels_are_told_from_powers() {
    let folder = Folder::new();
    let decibels: Vec<f32> = lobes(3)
        .iter()
        .map(|x| 10.0 * (x + 0.06).log10() - 80.0)
        .collect();
    let truth = folder.write("truth.npy", &[3, 180], &decibels);
    let output = xtask(&format!("metrics --truth {truth} --prediction {truth}"));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("not of decibels"), "{told}");
}

#[test]
fn rejected_samples_are_shouted() {
    let folder = Folder::new();
    let spectra = lobes(4);
    let mut broken = spectra.clone();
    broken[2 * 180 + 5] = f32::NAN;
    let truth = folder.write("truth.npy", &[4, 180], &spectra);
    let prediction = folder.write("prediction.npy", &[4, 180], &broken);
    let line = format!("metrics --truth {truth} --prediction {prediction}");
    let output = xtask(&line);
    let (out, err) = (
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    );
    assert!(output.status.success());
    assert!(out.contains("NOT SCORED"), "{out}");
    assert_told(&err, &["1 of 4", "sample 2, bin 5"]);
    let scores = json(&line);
    assert_eq!(scores["rejected"], 1);
    assert_eq!(scores["first_rejected"][0]["sample"], 2);

    let nothing = folder.write("nothing.npy", &[4, 180], &[f32::NAN; 4 * 180]);
    let error = fail(&format!("metrics --truth {truth} --prediction {nothing}"));
    assert!(error.contains("none of 4 samples"), "{error}");
}

#[test]
fn what_does_not_fit_is_told() {
    let folder = Folder::new();
    let truth = folder.write("truth.npy", &[7, 180], &lobes(7));
    let refused = |prediction: &str| {
        fail(&format!(
            "metrics --truth {truth} --prediction {prediction}"
        ))
    };

    let short = folder.write("short.npy", &[6, 180], &lobes(6));
    assert_told(&refused(&short), &["(7, 180)", "(6, 180)", "same samples"]);

    let deep = folder.write("deep.npy", &[7, 180, 1], &lobes(7));
    assert_told(&refused(&deep), &["(7, 180, 1)", "(7, 180)", "reshape"]);

    let whole = folder.write("whole.npy", &[7, 180], &[1_u32; 7 * 180]);
    assert!(refused(&whole).contains("astype"));

    let text = folder.arg("text.npy");
    fs::write(&text, "1, 2, 3, 4, 5, 6, 7").unwrap();
    assert!(refused(&text).contains("not an .npy file"));

    let ids = folder.write("i.npy", &[3], &[1_u32; 3]);
    let error = refused(&format!("{truth} --map-ids {ids}"));
    assert!(error.contains("3 map ids for 7 samples"), "{error}");
    assert!(refused(&format!("{truth} --split test")).contains("for a data set"));
    assert!(refused(&format!("{truth} --data-range 0")).contains("positive"));
}

/// Linear relative power of all labels of a part, row after row.
pub fn linear(dataset: &Dataset, part: Part) -> Vec<f64> {
    let mut values = Vec::new();
    for map in dataset.maps_of(part) {
        let map = map.unwrap();
        let aps = map.aps.as_ref().unwrap();
        let mut row = vec![0.0; aps.bins()];
        for link in map.valid_links() {
            aps.read_relative_db(link, &mut row);
            values.extend(row.iter().map(|&db| 10_f64.powf(f64::from(db) / 10.0)));
        }
    }
    values
}

/// Mean and deviation.
pub fn mean_std(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

#[test]
fn data_set_as_truth() {
    let folder = Folder::new();
    let truth = folder.arg("data");
    succeed(&format!(
        "dataset --profile smoke --protocol released --out {truth}"
    ));
    let dataset = Dataset::open(&truth).unwrap();
    let (mean, std) = mean_std(&linear(&dataset, Part::Train));
    let test = linear(&dataset, Part::Test);
    let shape = [test.len() / 180, 180];

    // The targets as design and papers spell them out, by themselves.
    let paper: Vec<f64> = test.iter().map(|x| (x - mean) / std).collect();
    let mut released = paper.clone();
    for row in released.chunks_mut(180) {
        let (mean, std) = mean_std(row);
        row.iter_mut()
            .for_each(|x| *x = (*x - mean) / (std + SAMPLE_EPSILON));
    }
    let paper = folder.write("paper.npy", &shape, &paper);
    let released = folder.write("released.npy", &shape, &released);
    let linear_file = folder.write("linear.npy", &shape, &test);
    let line = |prediction: &str| format!("metrics --truth {truth} --prediction {prediction}");

    // The protocol of the labels is the default.
    let scores = json(&line(&released));
    assert_perfect(&scores);
    assert_eq!(scores["protocol"], "released");
    assert_eq!(scores["report"]["maps"][0]["map_id"], 1);
    let trained = scores["truth"]["training"]["mean"].as_f64().unwrap();
    assert!((trained - mean).abs() < 1e-12);
    assert_perfect(&json(&(line(&paper) + " --protocol paper")));
    assert_perfect(&json(&(line(&linear_file) + " --domain linear")));

    // The wrong target has the right shape of each spectrum, and is far off.
    let scores = json(&line(&linear_file));
    assert!(self::mean(&scores, "mae") > 0.1);

    let short = [shape[0] - 1, 180];
    let short_file = folder.write("short.npy", &short, &test[180..]);
    let error = fail(&line(&short_file));
    for [samples, bins] in [shape, short] {
        assert!(error.contains(&format!("({samples}, {bins})")), "{error}");
    }
    assert!(error.contains("the test maps [1]"), "{error}");
    // Two maps have none to develop on.
    let error = fail(&(line(&released) + " --split develop"));
    assert_told(
        &error,
        &["no develop maps, only train and test maps", "--split"],
    );
    let ids = folder.write("ids.npy", &[shape[0]], &vec![1_u32; shape[0]]);
    let error = fail(&format!("{} --map-ids {ids}", line(&released)));
    assert!(error.contains("knows its maps"), "{error}");
}
