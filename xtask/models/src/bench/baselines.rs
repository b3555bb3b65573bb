//! Predictions that learn nothing of maps: the mean spectrum, the line of sight, the tracer with lower limits.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;
use std::time::Instant;

use anyhow::{Context, Result};
use aps_data::PathTable;
use aps_label::{Label, Labeler, PathSample, Scratch, Status};
use aps_model::ANGLE_BINS;
use aps_raytrace::{Link, PathRecord, SPEED_OF_LIGHT_M_PER_S, TraceConfig, Tracer};
use map2aps::{Control, DatasetPlan, Example, label_links};
use rayon::prelude::*;

use super::answer::Answer;
use super::dataset::limited;
use super::latency::{ms_per_link, of_times};
use super::test_set::TestSet;

/// Links that a thread traces at a time.
const LINKS_AT_ONCE: usize = 64;

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

/// Paths that the tracer is asked for.
#[derive(Debug, Clone, Copy)]
pub enum Found {
    /// Paths of at most so many interactions, without the further diffractions that links without a path go on with.
    Within(usize),
    /// The strongest of a link, of all that the labels are made of.
    Strongest,
}

/// The test links traced and labelled again with some of their paths. Timed a map at a time on all threads, from its buildings to the labels;
/// `batch` is what the time is listed under.
pub fn tracer(
    test: &TestSet,
    plan: &DatasetPlan,
    found: Found,
    mean: &[f64],
    batch: usize,
) -> Result<Answer> {
    let whole = &plan.trace;
    let (trace, kept): (_, Kept) = match found {
        Found::Strongest => (whole.clone(), strongest),
        Found::Within(interactions) => {
            let most = interactions.min(whole.max_interactions);
            let [reflections, diffractions] =
                [whole.max_reflections, whole.max_diffractions].map(|limit| limit.min(most));
            let lower = TraceConfig {
                max_fallback_diffractions: 0,
                ..limited(whole, reflections, diffractions, most)
            };
            (lower, |paths| paths)
        }
    };
    let labeler = Labeler::new(&plan.label)?;
    let (mut answers, mut times) = (Vec::with_capacity(test.len()), Vec::new());
    for of_map in test.examples().list().chunk_by(|p, q| p.map == q.map) {
        let started = Instant::now();
        let scene = plan.maps.load(of_map[0].map, plan.seed, plan.scene)?;
        let paths = traced(&Tracer::new(&scene, trace.clone())?, of_map, kept)?;
        let labels = label_links(&labeler, &paths, &Control::default())?;
        times.push(ms_per_link(started.elapsed(), of_map.len()));
        let rows = labels.aps_db.chunks_exact(ANGLE_BINS);
        for (row, is_labelled) in rows.zip(labels.is_labelled) {
            let mut db: [f64; ANGLE_BINS] = row.try_into()?;
            if is_labelled {
                test.normalization().apply(&mut db)?;
            }
            answers.push(is_labelled.then_some(db));
        }
    }
    Ok(Answer {
        latency: vec![of_times(batch, times)],
        ..substitute(answers, mean)
    })
}

/// A choice of the paths of a link.
type Kept = fn(&[PathRecord]) -> &[PathRecord];

/// The path of the most power, the first of equals.
fn strongest(paths: &[PathRecord]) -> &[PathRecord] {
    let mut best = 0;
    for (i, path) in paths.iter().enumerate() {
        if path.power() > paths[best].power() {
            best = i;
        }
    }
    &paths[best..paths.len().min(best + 1)]
}

/// Some of the paths of links of one map, whose terminals are prepared once each.
fn traced(tracer: &Tracer<'_>, links: &[Example], kept: Kept) -> Result<PathTable> {
    let prepared = |ends: BTreeMap<u32, [f64; 2]>| ends.into_par_iter();
    let tx = prepared(links.iter().map(|link| (link.tx, link.tx_m)).collect())
        .map(|(row, at)| Ok((row, tracer.transmitter(at.into())?)))
        .collect::<Result<HashMap<_, _>>>()?;
    let rx = prepared(links.iter().map(|link| (link.rx, link.rx_m)).collect())
        .map(|(row, at)| Ok((row, tracer.receiver(at.into())?)))
        .collect::<Result<HashMap<_, _>>>()?;
    let some = |buffer: &mut Link, links: &[Example]| {
        let mut paths = PathTable::default();
        for link in links {
            tracer.link(&tx[&link.tx], &rx[&link.rx], buffer)?;
            paths.push_records(kept(&buffer.paths));
        }
        Ok(paths)
    };
    let parts = links
        .par_chunks(LINKS_AT_ONCE)
        .map_init(Link::default, some);
    let mut all = PathTable::default();
    for part in &parts.collect::<Result<Vec<_>>>()? {
        (0..part.links()).for_each(|link| all.push_link(part, link));
    }
    Ok(all)
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

#[cfg(test)]
mod tests {
    use aps_raytrace::Scene;
    use aps_raytrace::scene::CityConfig;

    use super::*;

    #[test]
    fn the_strongest_path_is_the_one_that_no_other_exceeds() {
        let scene = Scene::synthetic(&CityConfig::default()).unwrap();
        let tracer = Tracer::new(&scene, TraceConfig::default()).unwrap();
        let places = (0..).map(|i: u32| [f64::from(i * 37 % 250), f64::from(i * 91 % 250)]);
        let ends: Vec<_> = places
            .filter_map(|at| Some((tracer.transmitter(at.into()).ok()?, at)))
            .take(8)
            .collect();
        let (mut link, mut several) = (Link::default(), 0);
        for (tx, at) in &ends {
            for (_, other) in ends.iter().filter(|(_, other)| other != at) {
                let rx = tracer.receiver((*other).into()).unwrap();
                tracer.link(tx, &rx, &mut link).unwrap();
                let most = link.paths.iter().map(PathRecord::power).fold(0.0, f64::max);
                let kept: Vec<f64> = strongest(&link.paths)
                    .iter()
                    .map(PathRecord::power)
                    .collect();
                assert_eq!(kept, vec![most; link.paths.len().min(1)]);
                several += usize::from(link.paths.first().is_some_and(|p| p.power() < most));
            }
        }
        assert!(several > 0, "the strongest is not always the first");
        assert!(strongest(&[]).is_empty());
    }
}
