//! Predictions without learning from maps: the mean spectrum, the line of sight.

use std::f64::consts::PI;
use std::time::Instant;

use aps_label::{Label, Labeler, PathSample, Scratch, Status};
use aps_raytrace::SPEED_OF_LIGHT_M_PER_S;
use map2aps::DatasetPlan;

use crate::answer::Answer;
use crate::error::Result;
use crate::latency::{ms_per_link, of_times};
use crate::test_set::TestSet;

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
    for link in test.examples.list() {
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
            test.normalization.apply(&mut label.aps_db)?;
            values = Some(std::mem::take(&mut label.aps_db));
        }
        times.push(ms_per_link(started.elapsed(), 1));
        answers.push(values);
    }
    Ok(Answer {
        latency: vec![of_times(1, times)],
        ..substitute(answers, mean)
    })
}

/// Fills in the mean spectrum where there is no answer, and keeps count.
pub fn substitute(answers: Vec<Option<Vec<f64>>>, mean: &[f64]) -> Answer {
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
