//! The spectra of the golden script, made again bit for bit.

use std::path::Path;

pub const BINS: usize = 180;
const SCALE: f64 = 4096.0;
const PER_FAMILY: usize = 200;
const FAMILIES: usize = 8;

pub struct Sample {
    pub name: String,
    pub truth: Vec<f64>,
    pub prediction: Vec<f64>,
}

/// One array of the script's output, flat.
pub fn load<T: npyz::Deserialize>(file: &str) -> Vec<T> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/metrics");
    let path = folder.join(file);
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let array = npyz::NpyFile::new(&bytes[..]).expect("a .npy header");
    array.into_vec().expect("the expected element type")
}

/// Samples in the script's order: labels, then the families.
pub fn samples() -> Vec<Sample> {
    let labels: Vec<i16> = load("labels.npy");
    let mut named: Vec<(String, Vec<i64>)> = labels
        .chunks(BINS)
        .enumerate()
        .map(|(i, row)| {
            (
                format!("label {i}"),
                row.iter().map(|&v| 4 * i64::from(v)).collect(),
            )
        })
        .collect();
    for family in 0..FAMILIES {
        named.extend(
            (0..PER_FAMILY).map(|i| (format!("family {family}, {i}"), spectrum(family, i))),
        );
    }
    let real = |row: &[i64]| row.iter().map(|&v| v as f64 / SCALE).collect();
    (0..named.len())
        .map(|i| Sample {
            name: named[i].0.clone(),
            truth: real(&named[i].1),
            prediction: real(&prediction(&named, i)),
        })
        .collect()
}

/// SplitMix64's finaliser over a few small integers.
fn mix(key: &[usize]) -> u64 {
    key.iter().fold(0_u64, |z, &part| {
        let z = z
            .wrapping_add(part as u64)
            .wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    })
}

fn spectrum(family: usize, i: usize) -> Vec<i64> {
    let below = |key: usize, limit: u64| (mix(&[family, i, key]) % limit) as i64;
    let bins = 0..BINS;
    match family {
        0 => bins.map(|j| below(j, 16384) - 4096).collect(),
        1 => bins.map(|j| 1024 * below(j, 4) - 1024).collect(),
        2 => {
            let width = 2 + below(999, 9) as usize;
            bins.map(|j| below(j / width, 8192) - 2048).collect()
        }
        3 => {
            let (slope, start) = (1 + below(1000, 60), below(1001, 4096));
            let period = 2048 << below(1002, 4);
            let sign = if i.is_multiple_of(2) { 1 } else { -1 };
            bins.map(|j| sign * ((j as i64 * slope + start) % period) - 512)
                .collect()
        }
        4 => {
            let place = [0, BINS - 1, below(1000, BINS as u64) as usize][i % 3];
            bins.map(|j| {
                if j == place {
                    4096
                } else {
                    -64 * (i % 4) as i64
                }
            })
            .collect()
        }
        5 => vec![4096 * ((i % 5) as i64 - 2); BINS],
        6 => bins.map(|j| -1 - below(j / (1 + i % 3), 12288)).collect(),
        _ => bins
            .map(|j| {
                let peak = mix(&[family, i, j, 7]).is_multiple_of(23);
                if peak { 8192 - below(j, 8000) } else { -400 }
            })
            .collect(),
    }
}

fn prediction(truth: &[(String, Vec<i64>)], i: usize) -> Vec<i64> {
    let mut row = truth[i].1.clone();
    match i % 5 {
        0 => {}
        1 => row.rotate_right(1 + (mix(&[50, i]) % 5) as usize),
        2 => {
            for (j, value) in row.iter_mut().enumerate() {
                *value += (mix(&[51, i, j]) % 1024) as i64 - 512;
            }
        }
        3 => row.clone_from(&truth[(i + 1) % truth.len()].1),
        _ => {
            let twin = |j: usize| truth[i].1[(BINS / 2 + BINS - j) % BINS] - 100 * (j % 2) as i64;
            row = (0..BINS).map(twin).collect();
        }
    }
    row
}
