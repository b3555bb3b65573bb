//! One map: prepare, trace, label, write.
//!
//! Links are independent, so transmitters are spread over the threads; rows go to the writer in
//! the order of the transmitters, and few parts wait for another, so that memory does not grow with
//! the map and the bytes do not depend on the threads.

use std::time::Instant;

use aps_data::{DatasetWriter, Links, MapInput, MapWriter};
use aps_label::Labeler;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Scene, TraceConfig, Tracer, Transmitter};

use super::link::LinkMaker;
use super::receivers::{Choice, Pool};
use super::rows::Rows;
use crate::batch::SIDE_BY_SIDE;
use crate::control::Control;
use crate::error::{At, Place, Result};
use crate::in_order::in_order;
use crate::maps;
use crate::maps::identity::with_outlines;
use crate::sampling::Terminals;
use crate::tally::Tally;

/// Context that all maps of a run share.
pub struct Run<'a> {
    pub writer: &'a DatasetWriter,
    pub labeler: &'a Labeler,
    pub control: &'a Control<'a>,
}

impl Run<'_> {
    /// Traces and labels one map; nothing of it stays on disk unless it is whole.
    pub fn map(
        &self,
        id: u32,
        scene: &Scene,
        terminals: &Terminals,
        choice: Choice,
        trace: &TraceConfig,
    ) -> Result<Tally> {
        let started = Instant::now();
        let tracer = Tracer::new(scene, trace.clone()).at(Place::Map(id))?;
        let sure = match choice {
            Choice::All => terminals.rx.len(),
            Choice::FirstReached(links) => links,
        };
        let rx = Pool::new(&tracer, &terminals.rx, sure).at(Place::Map(id))?;
        let mut tally = Tally {
            prepare: started.elapsed(),
            maps_without_walls: u64::from(scene.walls().is_empty()),
            maps_without_corners: u64::from(tracer.corner_count() == 0),
            ..Tally::default()
        };
        let buildings = maps::raster(scene, self.writer.config().layout.raster)?;
        let mut writer = self.writer.begin_map(
            id,
            &MapInput {
                buildings: &buildings,
                tx_m: &positions(&terminals.tx),
                rx_m: &positions(&terminals.rx),
                links: Links::WithRows,
            },
        )?;
        let tx: Vec<(u32, DVec2)> = (0..).zip(terminals.tx.iter().copied()).collect();
        self.write(&mut writer, &parts_of(&tx), &mut tally, |tx| {
            self.transmitters(&tracer, tx, &rx, choice)
        })
        .at(Place::Map(id))?;
        writer.set_statistics(with_outlines(tally.statistics(), scene));
        self.finish(writer, &mut tally)?;
        Ok(tally)
    }

    /// Makes the links of some transmitters, receiver by receiver. The rows of each are in the order of the receivers.
    fn transmitters(
        &self,
        tracer: &Tracer<'_>,
        tx: &[(u32, DVec2)],
        rx: &Pool,
        choice: Choice,
    ) -> Result<Vec<Rows>> {
        // Links wanted of each, where only points that are reached count.
        let wanted = match choice {
            Choice::FirstReached(wanted) => Some(wanted),
            Choice::All => None,
        };
        let prepare = |&(id, position)| {
            let started = Instant::now();
            let tx = tracer.transmitter(position).at(Place::Transmitter)?;
            let mut rows = Rows::default();
            rows.tally.prepare = started.elapsed();
            rows.tally.empty_beams = tx.empty_beam_count() as u64;
            Ok((id, tx, rows))
        };
        let mut parts = tx.iter().map(prepare).collect::<Result<Vec<_>>>()?;
        let mut maker = LinkMaker::new(self.writer.config().layout.paths);
        for candidate in rx.order() {
            for (id, tx, rows) in &mut parts {
                if wanted.is_some_and(|wanted| rows.status.len() >= wanted) {
                    continue;
                }
                self.control.check()?;
                let started = Instant::now();
                let receiver = rx.get(tracer, candidate)?;
                rows.tally.prepare += started.elapsed();
                let is_reached = maker.trace(tracer, tx, receiver, &mut rows.tally)?;
                if is_reached || wanted.is_none() {
                    maker.label(self.labeler, [*id, candidate], rows)?;
                    if self.writer.config().layout.paths {
                        maker.push_paths(rows);
                    }
                    let is_near = is_near(tracer.config(), tx.position(), rx.point(candidate));
                    rows.tally.near_links += u64::from(is_near);
                    self.control.progress.advance(1);
                } else {
                    rows.tally.pass_over(maker.status_inside_limits());
                }
            }
        }
        let finish = |(_, _, mut rows): (u32, Transmitter, Rows)| {
            if let Some(wanted) = wanted {
                let missing = wanted.saturating_sub(rows.status.len()) as u64;
                rows.tally.missing_links += missing;
                self.control.progress.advance(missing);
            }
            rows.sort_by_receiver();
            rows.count_shapes(self.labeler, &self.writer.config().layout)?;
            Ok(rows)
        };
        parts.into_iter().map(finish).collect()
    }

    /// Makes the rows of parts on all threads, and writes them in the order of the parts.
    pub(super) fn write<T: Sync>(
        &self,
        writer: &mut MapWriter<'_>,
        parts: &[T],
        tally: &mut Tally,
        make: impl Fn(&T) -> Result<Vec<Rows>> + Send + Sync,
    ) -> Result<()> {
        in_order(parts, make, |rows| {
            let started = Instant::now();
            for rows in rows {
                writer.push(&rows.link_rows(&self.writer.config().layout))?;
                tally.add(&rows.tally);
            }
            tally.write += started.elapsed();
            Ok(())
        })
    }

    pub(super) fn finish(&self, writer: MapWriter<'_>, tally: &mut Tally) -> Result<()> {
        let started = Instant::now();
        let entry = writer.finish()?;
        tally.write += started.elapsed();
        tally.bytes = entry.files.iter().map(|f| f.bytes).sum();
        Ok(())
    }
}

/// Divides transmitters into parts, smaller ones towards the end, so that all threads end at about the same time.
fn parts_of<T>(mut tx: &[T]) -> Vec<&[T]> {
    let mut parts = Vec::new();
    while !tx.is_empty() {
        let count = tx.len().div_ceil(2 * rayon::current_num_threads());
        let (part, rest) = tx.split_at(count.min(SIDE_BY_SIDE));
        parts.push(part);
        tx = rest;
    }
    parts
}

/// Returns true when the ends of a link are nearer to each other than a wavelength and not at one point, which is no
/// link. The formulas of the far field give such links too large a gain.
pub fn is_near(trace: &TraceConfig, tx: DVec2, rx: DVec2) -> bool {
    tx != rx && tx.distance(rx) < trace.wavelength_m()
}

fn positions(points: &[DVec2]) -> Vec<[f64; 2]> {
    points.iter().map(|p| p.to_array()).collect()
}
