//! Predictions that learn nothing of maps: the mean spectrum, the line of sight, the tracer with lower limits.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use aps_data::{Dataset, Split};
use aps_label::{Label, Labeler, PathSample, Scratch, Status};
use aps_model::ANGLE_BINS;
use aps_raytrace::{SPEED_OF_LIGHT_M_PER_S, TraceConfig};
use map2aps::DatasetPlan;

use super::answer::Answer;
use super::dataset::{self, limited};
use super::latency::{ms_per_link, of_times};
use super::test_set::TestSet;

/// Predicts the mean spectrum for every link.
pub fn mean(test: &TestSet, mean: &[f64]) -> Answer {
    Answer {
        predictions: as_f32(mean).collect::<Vec<_>>().repeat(test.len()),
        ..Answer::default()
    }
}

/// Predicts the label of a single straight path, also through buildings. Timed link by link on one thread.
pub fn line_of_sight(test: &TestSet, plan: &DatasetPlan, mean: &[f64]) -> Result<Answer> {
    let labeler = Labeler::new(&plan.label)?;
    let wavelength_m = SPEED_OF_LIGHT_M_PER_S / plan.trace.frequency_hz;
    let (mut scratch, mut label) = (Scratch::default(), Label::default());
    let mut times = Vec::with_capacity(test.len());
    let mut answers = Vec::with_capacity(test.len());
    for link in test.examples().list() {
        let started = Instant::now();
        let [dx, dy] = [0, 1].map(|axis| link.tx_m[axis] - link.rx_m[axis]);
        let distance_m = dx.hypot(dy);
        let path = PathSample {
            delay_s: distance_m / SPEED_OF_LIGHT_M_PER_S,
            arrival_azimuth_rad: dy.atan2(dx),
            gain_db: 20.0 * (wavelength_m / (4.0 * PI * distance_m)).log10(),
        };
        let status = labeler.label_into(&[path], &mut scratch, &mut label)?;
        let mut values = None;
        if status == Status::Labelled {
            let mut db: [f64; ANGLE_BINS] =
                label.aps_db[..].try_into().context("bins of a label")?;
            test.normalization().apply(&mut db)?;
            values = Some(db);
        }
        times.push(ms_per_link(started.elapsed(), 1));
        answers.push(values);
    }
    Ok(Answer {
        latency: vec![of_times(1, times)],
        ..substitute(answers, mean)
    })
}

/// The test links traced and labelled again with at most so many `interactions` on a path, and none of the further
/// diffractions by which links without a path get one. Timed a map at a time on all threads, from its buildings to the written labels; `batch` is
/// what the time is listed under.
pub fn tracer(
    test: &TestSet,
    plan: &DatasetPlan,
    interactions: usize,
    mean: &[f64],
    folder: &Path,
    batch: usize,
) -> Result<Answer> {
    let whole = &plan.trace;
    let [reflections, diffractions] = [whole.max_reflections, whole.max_diffractions];
    let interactions = interactions.min(whole.max_interactions);
    let lower = DatasetPlan {
        trace: TraceConfig {
            max_fallback_diffractions: 0,
            ..limited(
                whole,
                reflections.min(interactions),
                diffractions.min(interactions),
                interactions,
            )
        },
        ..plan.clone()
    };
    let labels = folder.join("labels");
    if labels.exists() {
        // Times are those of whole runs.
        fs::remove_dir_all(&labels)?;
    }
    let split = Split {
        test: test.maps().to_vec(),
        ..Split::default()
    };
    let times = dataset::make(&lower, &labels, &split)?.maps;
    let answers = test.targets_of(&Dataset::open(&labels)?)?;
    fs::remove_dir_all(&labels)?;
    let of_map = |&(_, links, time)| ms_per_link(time, links as usize);
    Ok(Answer {
        latency: vec![of_times(batch, times.iter().map(of_map).collect())],
        ..substitute(answers, mean)
    })
}

/// Fills in the mean spectrum where there is no answer, and keeps count.
fn substitute(answers: Vec<Option<[f64; ANGLE_BINS]>>, mean: &[f64]) -> Answer {
    let mut answer = Answer::default();
    for (link, values) in answers.iter().enumerate() {
        if values.is_none() {
            answer.substituted.push(link);
        }
        let values = values.as_ref().map_or(mean, |values| &values[..]);
        answer.predictions.extend(as_f32(values));
    }
    answer
}

fn as_f32(values: &[f64]) -> impl Iterator<Item = f32> {
    values.iter().map(|&x| x as f32)
}
