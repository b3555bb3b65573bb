//! Results made up by a formula: every entry has a skill, every link a difficulty.

use std::path::Path;

use aps_metrics::Metric;
use aps_report::benchmark::{
    CurvePoint, DataSummary, Entry, EntryKind, Example, FORMAT, Latency, Machine, Prediction,
    Results, ScoreTable, TestLink, Training,
};

const MAPS: u32 = 5;
const TXS: u32 = 8;
const RXS: u32 = 12;

/// An entry and its quality, from 0, no better than chance, to 1, perfect.
pub struct Made {
    pub name: &'static str,
    pub kind: EntryKind,
    /// Quality of the shape and the peaks.
    pub places: f64,
    /// Quality of the level.
    pub level: f64,
    pub ms: f64,
}

const fn made(name: &'static str, kind: EntryKind, places: f64, level: f64, ms: f64) -> Made {
    Made {
        name,
        kind,
        places,
        level,
        ms,
    }
}

/// The paper's models in the paper's order, baselines below them.
pub fn as_in_the_paper() -> Vec<Made> {
    use EntryKind::{Baseline, Ceiling, External, Model, Shipped, Tracer};
    vec![
        made("MS-AReg", Model, 0.93, 0.90, 1.1),
        made("RadioUNet", Model, 0.84, 0.70, 9.3),
        made("ResNet-MLP", Model, 0.80, 0.60, 0.9),
        made("ViT-Reg", Model, 0.74, 0.65, 8.2),
        made("ResNet-Conv1D", Model, 0.70, 0.55, 1.0),
        made("MS-MLP", Model, 0.86, 0.62, 1.05),
        made("Adv-MLP", Model, 0.81, 0.88, 0.95),
        made("Polar-Reg", Model, 0.90, 0.86, 0.8),
        made("mean spectrum", Baseline, 0.30, 0.40, 0.0005),
        made("line of sight", Baseline, 0.45, 0.35, 0.002),
        made("tracer, 0 interactions", Tracer, 0.50, 0.45, 0.01),
        made("tracer, 1 interaction", Tracer, 0.72, 0.70, 0.03),
        made("tracer, 2 interactions", Tracer, 0.95, 0.96, 0.4),
        made("tracer, 3 interactions", Tracer, 1.0, 1.0, 1.4),
        made("MS-AReg, shipped", Shipped, 0.91, 0.88, 1.1),
        made("Polar-Reg, shipped", Shipped, 0.92, 0.88, 0.8),
        made("strongest path", Ceiling, 0.97, 0.93, 1.4),
        made("Someone's <model> & co", External, 0.77, 0.66, 2.0),
    ]
}

/// Writes score files into a folder and gives the results that name them.
pub fn results(folder: &Path, entries: &[Made]) -> Results {
    let links = links();
    let entries: Vec<Entry> = entries.iter().map(|e| entry(folder, e, &links)).collect();
    let maps = |from: u32, to: u32| (from..to).collect::<Vec<u32>>();
    Results {
        format: FORMAT,
        profile: "quick".into(),
        configuration: serde_json::json!({"seed": 7, "models": {"image": 64, "preset": "small"}}),
        machine: Machine {
            cpu: "Example CPU".into(),
            cores: 2,
            threads: 2,
            memory_bytes: 16 << 30,
            os: "Linux".into(),
            rustc: "rustc 1.89.0".into(),
            version: "0.1.0".into(),
            commit: String::new(),
            started: "2026-01-02T03:04:05Z".into(),
            seconds_total: 812.0,
        },
        data: DataSummary {
            source: "synthetic city, seed 7".into(),
            train_maps: maps(0, 40),
            dev_maps: maps(40, 46),
            test_maps: maps(46, 46 + MAPS),
            train_links: 20_000,
            dev_links: 1_000,
            chosen_by: "cosine".into(),
            test_links: links.len() as u64,
            invalid_test_links: 3,
            protocol: "released".into(),
        },
        examples: examples(&entries, &links),
        links,
        entries,
        failed: Vec::new(),
        left_out: Vec::new(),
    }
}

fn links() -> Vec<TestLink> {
    let mut links = Vec::new();
    for map in 46..46 + MAPS {
        for tx in 0..TXS {
            for rx in 0..RXS {
                let at = |salt| noise([map, tx, rx, salt]);
                let distance_m = 5.0 + 290.0 * at(0).sqrt();
                links.push(TestLink {
                    map,
                    tx,
                    rx,
                    distance_m,
                    line_of_sight: at(1) * 250.0 > distance_m,
                    dominant_peaks: 1 + (at(2) * at(2) * 6.0) as u32,
                });
            }
        }
    }
    links
}

fn entry(folder: &Path, made: &Made, links: &[TestLink]) -> Entry {
    let is_trained = made.kind == EntryKind::Model;
    let latency = |batch: usize| Latency {
        batch,
        median_ms_per_link: made.ms * if batch == 1 { 4.0 } else { 1.0 },
        p95_ms_per_link: made.ms * if batch == 1 { 6.0 } else { 1.3 },
        input_ms_per_link: if is_trained { 0.2 } else { 0.0 },
        device: "cpu".into(),
    };
    let scores = ["released", "paper"].map(|protocol| {
        let rows: Vec<_> = links.iter().map(|link| row(made, link, protocol)).collect();
        let letters = made.name.chars().filter(char::is_ascii_alphanumeric);
        let stem: String = letters.collect();
        let file = format!("scores/{stem}-{protocol}.npy");
        let table = ScoreTable::of_rows(&rows).unwrap();
        table.write(folder, Path::new(&file), protocol).unwrap()
    });
    Entry {
        name: made.name.into(),
        kind: made.kind,
        model: match made.kind {
            EntryKind::Model => Some(made.name.into()),
            EntryKind::Shipped => made.name.strip_suffix(", shipped").map(str::to_owned),
            _ => None,
        },
        parameters: is_trained.then_some((1e6 * made.ms) as u64 + 11_000_000),
        training: is_trained.then(|| training(made)),
        latency: match made.kind {
            EntryKind::External => Vec::new(),
            EntryKind::Tracer | EntryKind::Ceiling => vec![latency(256)],
            _ => vec![latency(1), latency(256)],
        },
        scores: scores.into(),
        substituted_links: u64::from(made.name == "tracer, 0 interactions") * 123,
    }
}

fn training(made: &Made) -> Training {
    let seconds = 60.0;
    let point = |share: f64| {
        let done = 1.0 - (-4.0 * share).exp();
        CurvePoint {
            steps: (1000.0 * share) as u64,
            seconds: seconds * share,
            train_loss: 1.0 - made.places * done,
            dev_cosine: Some(made.places * done),
            dev_recall: Some(0.9 * made.places * done),
        }
    };
    Training {
        seconds,
        epochs: 1.6,
        best_steps: Some(750),
        links_seen: 64_000,
        batch: 64,
        learning_rate: 3e-4,
        image_size: 64,
        curve: [0.0625, 0.125, 0.25, 0.5, 0.75, 1.0].map(point).into(),
    }
}

/// Scores that follow from skill, difficulty and chance; maps and transmitters have their own.
fn row(made: &Made, link: &TestLink, protocol: &str) -> [f64; 16] {
    let (map, tx, rx) = (link.map, link.tx, link.rx);
    let name = made.name.bytes();
    let own = name.fold(0, |sum, b| sum * 31 % 9973 + u32::from(b));
    let chance = noise([map, tx, rx, own]);
    let shared = 0.1 * noise([map, 1, 1, 9]) + 0.1 * noise([map, tx, 1, 9]);
    let hard = 0.25 * f64::from(link.dominant_peaks) / 6.0 + 0.2 * f64::from(!link.line_of_sight);
    let miss = (1.0 - made.places) * (0.4 + shared + hard + 0.6 * chance);
    let off = (1.0 - made.level) * (0.4 + shared + 0.6 * chance);
    let cosine = 1.0 - miss.min(1.5);
    let mse = 1e-4 + off * off;
    let ple = match protocol {
        "paper" => 60.0 * miss * miss,
        _ => 80.0 * miss * miss,
    };
    let hit = |limit: f64| f64::from(ple < limit && chance < 0.55);
    let recall = |limit: f64| (1.0 - miss + 0.02 * limit).clamp(0.0, 1.0);
    let mirror = |limit: f64| f64::from(ple < limit);
    [
        mse.sqrt() * 0.7,
        24.0 - 10.0 * mse.log10(),
        cosine,
        10.0 * mse.log10(),
        cosine.clamp(-1.0, 1.0).acos().to_degrees(),
        ple,
        hit(2.0),
        hit(4.0),
        recall(0.0),
        recall(1.0),
        mse,
        mse.sqrt(),
        mse,
        0.6 * ple,
        mirror(2.0),
        mirror(4.0),
    ]
}

fn examples(entries: &[Entry], links: &[TestLink]) -> Vec<Example> {
    const BINS: usize = 180;
    let lobe = |bin: usize, centre: f64, width: f64| {
        let angle = -180.0 + 360.0 * bin as f64 / (BINS - 1) as f64;
        (-((angle - centre) / width).powi(2)).exp()
    };
    let example = |(i, rank): (usize, &str)| {
        let truth: Vec<f64> = (0..BINS)
            .map(|b| 4.0 * lobe(b, -60.0, 9.0) + 2.5 * lobe(b, 35.0 * i as f64, 7.0) - 0.4)
            .collect();
        let predict = |(k, entry): (usize, &Entry)| {
            let shift = (k as f64 - 3.0) * 2.0 * i as f64;
            let spectrum = (0..BINS).map(|b| {
                3.7 * lobe(b, -60.0 + shift, 11.0) + 2.0 * lobe(b, 35.0 * i as f64, 9.0) - 0.4
            });
            Prediction {
                entry: entry.name.clone(),
                spectrum: spectrum.collect(),
            }
        };
        let house = |h: u32| {
            let (x, y) = (
                60.0 * f64::from(h % 4) + 10.0,
                80.0 * f64::from(h / 4) + 20.0,
            );
            vec![[x, y], [x + 40.0, y], [x + 40.0, y + 25.0], [x, y + 25.0]]
        };
        Example {
            rank: rank.into(),
            link: 37 * i % links.len(),
            truth,
            predictions: entries.iter().enumerate().take(1).map(predict).collect(),
            buildings: (0..12).map(house).collect(),
            tx_m: [55.0, 70.0],
            rx_m: [180.0 - 20.0 * i as f64, 130.0],
        }
    };
    let ranks = ["best", "median", "worst"].into_iter();
    ranks.enumerate().map(example).collect()
}

/// A number in [0, 1) that depends on a few others (SplitMix64's finaliser).
fn noise(key: [u32; 4]) -> f64 {
    let z = key.into_iter().fold(0_u64, |z, part| {
        let z = z
            .wrapping_add(u64::from(part))
            .wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    });
    (z >> 11) as f64 / (1_u64 << 53) as f64
}

/// The columns that [`row`] fills in.
const _: () = assert!(Metric::ALL.len() == 16);
