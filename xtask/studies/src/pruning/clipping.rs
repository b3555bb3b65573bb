//! Beams: images that nothing can see are never made.

use std::time::Duration;

use anyhow::Result;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, TraceConfig, Tracer};
use aps_report::numbers::{count, three_digits};
use aps_tests::brute_force::candidates;
use indicatif::ProgressBar;
use map2aps::sampling::draw as draw_terminals;
use serde::Serialize;

use super::ends;
use crate::scenes::NamedScene;
use crate::{Setup, Stopwatch, Study, on_one_thread};

/// Walls beyond which exhaustion of two reflections takes too long to be waited for.
const MOST_WALLS: usize = 400;

#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: String,
    walls: usize,
    max_reflections: usize,
    /// Sequences of walls that exhaustion examines.
    sequences: u64,
    images_per_transmitter: f64,
    empty_beams_per_transmitter: f64,
    trace_us: f64,
    /// Empty where it would take too long.
    exhaustion_us: Option<f64>,
}

pub fn study(
    setup: &Setup,
    scenes: &[NamedScene],
    bar: &ProgressBar,
    study: &mut Study,
) -> Result<()> {
    let mut rows = Vec::new();
    for place in scenes {
        for order in 1..=setup.profile.choose(1, 3) {
            rows.extend(of_scene(setup, place, order)?);
        }
        bar.inc(1);
    }
    study.section.heading("Branches without a beam");
    let cells = |r: &Row| {
        let times = r.exhaustion_us.map(|us| us / r.trace_us);
        vec![
            r.scene.clone(),
            r.walls.to_string(),
            r.max_reflections.to_string(),
            count(r.sequences),
            three_digits(r.images_per_transmitter),
            three_digits(r.empty_beams_per_transmitter),
            three_digits(r.trace_us),
            r.exhaustion_us.map_or("\u{2013}".into(), three_digits),
            times.map_or("\u{2013}".into(), three_digits),
        ]
    };
    let head = [
        "scene",
        "walls",
        "R",
        "sequences",
        "images",
        "of them lighting nothing",
        "time [us]",
        "exhaustion [us]",
        "times as fast",
    ];
    study.table(
        "Reflections by beams and by exhaustion",
        &head,
        rows.iter().map(cells).collect(),
    );
    study.data("clipping", "Beams against exhaustion", &rows)
}

fn of_scene(setup: &Setup, place: &NamedScene, order: usize) -> Result<Option<Row>> {
    let walls = place.scene.walls();
    if walls.is_empty() {
        return Ok(None);
    }
    let (tx, _) = ends(setup);
    let terminals = draw_terminals(&place.scene, setup.seed, place.id, tx, tx..=tx)?;
    let pairs: Vec<(DVec2, DVec2)> = terminals.tx.into_iter().zip(terminals.rx).collect();
    let config = TraceConfig::reflections_only(order);
    let tracer = Tracer::new(&place.scene, config)?;
    let (mut images, mut empty) = (0, 0);
    for &(p, _) in &pairs {
        let tx = tracer.transmitter(p)?;
        images += tx.image_count();
        empty += tx.empty_beam_count();
    }
    let stopwatch = Stopwatch::of(setup.profile);
    let trace = on_one_thread(|| {
        stopwatch.time(|| {
            for &(p, q) in &pairs {
                let link: Result<Link, _> = tracer.trace(p, q);
                let _ = std::hint::black_box(link);
            }
        })
    })?;
    let (n, sequences) = (walls.len() as u64, sequences(walls.len() as u64, order));
    let affordable =
        n as usize <= MOST_WALLS && sequences <= setup.profile.choose(10_000, 1_000_000);
    let exhaustion = affordable.then(|| {
        let once = Stopwatch {
            most: Duration::ZERO,
            ..stopwatch
        };
        let timing = once.time(|| {
            let (p, q) = pairs[0];
            std::hint::black_box(candidates(walls, p, q, order, 0.0));
        });
        timing.us()
    });
    let per_tx = |count: usize| count as f64 / pairs.len() as f64;
    Ok(Some(Row {
        scene: place.name.clone(),
        walls: walls.len(),
        max_reflections: order,
        sequences,
        images_per_transmitter: per_tx(images),
        empty_beams_per_transmitter: per_tx(empty),
        trace_us: trace.per(pairs.len()).us(),
        exhaustion_us: exhaustion,
    }))
}

/// Sequences of up to `order` walls, no wall twice in a row.
fn sequences(walls: u64, order: usize) -> u64 {
    let mut of_order = 1;
    let mut all = 1;
    for i in 0..order {
        of_order *= if i == 0 { walls } else { walls - 1 };
        all += of_order;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_repeat_no_wall_at_once() {
        assert_eq!(
            [0, 1, 2, 3].map(|order| sequences(4, order)),
            [1, 5, 17, 53]
        );
    }
}
