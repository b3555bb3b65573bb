//! The tracer as a baseline, with some of the paths that the labels are made of.

use std::time::Instant;

use aps_label::Labeler;
use aps_model::ANGLE_BINS;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{PathRecord, TraceConfig, Tracer};
use map2aps::{Control, DatasetPlan, Example, label_links, trace_pairs};

use crate::answer::Answer;
use crate::baselines::substitute;
use crate::error::Result;
use crate::latency::{ms_per_link, of_times};
use crate::test_set::TestSet;

/// Paths that the tracer is asked for.
#[derive(Debug, Clone, Copy)]
pub enum PathSubset {
    /// Paths of at most so many interactions. Links without one get none: there are no further diffractions as in the labels.
    Within(usize),
    /// The strongest path of each link.
    Strongest,
}

/// Traces the test links again, and labels them by some of their paths. The time is that of a map, from its buildings to its labels, on all
/// threads, divided by its links; it is listed as that of batches of `batch` links.
pub fn answer(
    test: &TestSet,
    plan: &DatasetPlan,
    subset: PathSubset,
    mean: &[f64],
    batch: usize,
) -> Result<Answer> {
    let whole = &plan.trace;
    let (trace, select): (_, Selection) = match subset {
        PathSubset::Strongest => (whole.clone(), strongest),
        PathSubset::Within(interactions) => {
            let most = interactions.min(whole.max_interactions);
            let [max_reflections, max_diffractions] =
                [whole.max_reflections, whole.max_diffractions].map(|limit| limit.min(most));
            let lower = TraceConfig {
                max_reflections,
                max_diffractions,
                max_interactions: most.min(max_reflections + max_diffractions),
                max_fallback_diffractions: 0,
                ..whole.clone()
            };
            (lower, |paths| paths)
        }
    };
    let labeler = Labeler::new(&plan.label)?;
    let (mut answers, mut times) = (Vec::with_capacity(test.len()), Vec::new());
    for of_map in test.examples.list().chunk_by(|p, q| p.map == q.map) {
        let started = Instant::now();
        let scene = plan.maps.load(of_map[0].map, plan.seed, plan.scene)?;
        let tracer = Tracer::new(&scene, trace.clone())?;
        let pair = |link: &Example| [link.tx_m, link.rx_m].map(DVec2::from);
        let pairs: Vec<[DVec2; 2]> = of_map.iter().map(pair).collect();
        let control = Control::default();
        let paths = trace_pairs(&tracer, &pairs, select, &control)?;
        let labels = label_links(&labeler, &paths, &control)?;
        times.push(ms_per_link(started.elapsed(), of_map.len()));
        let rows = labels.aps_db.chunks_exact(ANGLE_BINS);
        for (row, is_labelled) in rows.zip(labels.is_labelled) {
            let mut db = row.to_vec();
            if is_labelled {
                test.normalization.apply(&mut db)?;
            }
            answers.push(is_labelled.then_some(db));
        }
    }
    Ok(Answer {
        latency: vec![of_times(batch, times)],
        ..substitute(answers, mean)
    })
}

/// A choice among the paths of a link.
type Selection = fn(&[PathRecord]) -> &[PathRecord];

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

#[cfg(test)]
mod tests {
    use aps_raytrace::scene::CityConfig;
    use aps_raytrace::{Link, Scene};

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
