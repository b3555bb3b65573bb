//! The error of the chosen limits against the reference ones, and the time of both.

use std::time::{Duration, Instant};

use aps_label::Labeler;
use aps_metrics::LevelDistance;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, TraceConfig};
use aps_report::link::Spectrum;
use map2aps::aps_data::sample_of;
use serde::Serialize;

use crate::cache::{Cache, TxSide};
use crate::curve::Curve;
use crate::fault::{End, Fault};
use crate::request::LinkQuestion;
use crate::request_handle::RequestHandle;
use crate::times::{Times, us};

/// Times that a link is repeated; the median counts.
const REPEATS: usize = 5;

/// Error and times.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// None where the reference limits find no path.
    error_db: Option<ErrorDb>,
    own: Side,
    reference: Side,
    curve: Option<Curve>,
}

#[derive(Debug, Serialize)]
struct ErrorDb {
    mean: f64,
    worst: f64,
}

#[derive(Debug, Serialize)]
struct Side {
    paths: usize,
    times_us: Times,
    #[serde(skip)]
    spectrum: Option<Spectrum>,
}

/// Compares a link with the reference limits, under the same label.
///
/// # Errors
/// As for a link.
pub fn compare(
    cache: &Cache,
    question: &LinkQuestion,
    handle: &RequestHandle,
) -> Result<Comparison, Fault> {
    let labeler = Labeler::new(&question.label.config()?).map_err(Fault::of)?;
    let own = measure(cache, question, &question.trace.config()?, &labeler, handle)?;
    let reference = question.trace.reference()?;
    let reference = measure(cache, question, &reference, &labeler, handle)?;
    let error_db = reference.spectrum.as_ref().map(|truth| {
        let found = own.spectrum.as_ref().map(|s| s.aps_db.as_slice());
        let error = LevelDistance::of(&truth.aps_db, found);
        ErrorDb {
            mean: error.mean_db,
            worst: error.worst_db,
        }
    });
    let protocol = question.label.protocol;
    let curve = reference.spectrum.as_ref().map(|s| Curve::of(s, protocol));
    Ok(Comparison {
        error_db,
        own,
        reference,
        curve,
    })
}

fn measure(
    cache: &Cache,
    question: &LinkQuestion,
    config: &TraceConfig,
    labeler: &Labeler,
    handle: &RequestHandle,
) -> Result<Side, Fault> {
    handle.check()?;
    let city = cache.city(&question.city)?;
    let TxSide { tracer, tx } = cache.tx_side(&city, config, question.tx, handle)?;
    let to = DVec2::from(question.rx);
    let mut taken: [Vec<Duration>; 3] = Default::default();
    let (mut link, mut spectrum) = (Link::default(), None);
    for _ in 0..REPEATS {
        handle.check()?;
        let began = Instant::now();
        let rx = tracer.value.receiver(to);
        let rx = rx.map_err(|source| Fault::Terminal {
            end: End::Rx,
            source,
        })?;
        let prepared = Instant::now();
        let joined = tracer.value.link(&tx.value, &rx, &mut link);
        joined.map_err(Fault::of)?;
        let joined = Instant::now();
        let heading_rad = question.label.heading_deg.to_radians();
        let seen = |path| sample_of(path).from_heading(heading_rad);
        let samples: Vec<_> = link.paths.iter().map(seen).collect();
        spectrum = Spectrum::of(labeler, &samples).map_err(Fault::of)?;
        taken[0].push(prepared - began);
        taken[1].push(joined - prepared);
        taken[2].push(joined.elapsed());
    }
    let [rx, join, label] = taken.map(|mut times| {
        times.sort();
        us(times[REPEATS / 2])
    });
    Ok(Side {
        paths: link.paths.len(),
        times_us: Times {
            map: us(tracer.took),
            tx: us(tx.took),
            rx,
            join,
            label,
        },
        spectrum,
    })
}
