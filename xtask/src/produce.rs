//! One map: prepare, trace, label, write.
//!
//! Links are independent, so transmitters are spread over the threads; rows go to the writer in
//! the order of the transmitters, a few transmitters at a time, so that memory does not grow with
//! the map and the bytes do not depend on the threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use aps_data::{DatasetWriter, LinkRows, LinkStatus, Links, MapInput, ProfileRows, Raster};
use aps_label::{ANGLE_BINS, Label, Labeler, PathSample, Scratch, Status};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Footprint;
use aps_raytrace::{Link, Receiver, TraceConfig, TraceError, Tracer};
use indicatif::ProgressBar;
use rayon::prelude::*;

use crate::maps::Map;
use crate::sampling::Terminals;
use crate::summary::Tally;

mod columns;

use columns::PathColumns;

/// Transmitters traced between two writes.
const TX_AT_ONCE: usize = 16;

/// What all maps of a run share.
pub struct Run<'a> {
    pub writer: &'a DatasetWriter,
    pub trace: &'a TraceConfig,
    pub labeler: &'a Labeler,
    pub progress: &'a ProgressBar,
    /// Set by Ctrl-C.
    pub interrupted: &'a AtomicBool,
}

/// All rows of one transmitter.
#[derive(Default)]
struct Rows {
    status: Vec<LinkStatus>,
    fallback: Vec<u8>,
    aps_db: Vec<f64>,
    pdp_db: Vec<f64>,
    paths: PathColumns,
    tally: Tally,
}

impl Run<'_> {
    /// Makes one map of the data set; nothing of it stays on disk unless it is whole.
    pub fn map(&self, id: u32, map: &Map, terminals: &Terminals) -> Result<Tally> {
        let started = Instant::now();
        let tracer = Tracer::new(&map.scene, self.trace.clone())?;
        let rx: Vec<Receiver> = terminals
            .rx
            .par_iter()
            .map(|&p| tracer.receiver(p))
            .collect::<Result<_, _>>()
            .with_context(|| format!("map {id}: receiver"))?;
        let mut tally = Tally {
            prepare: started.elapsed(),
            maps_without_walls: u64::from(map.scene.walls().is_empty()),
            maps_without_corners: u64::from(tracer.corner_count() == 0),
            ..Tally::default()
        };

        let grid = self.writer.config().layout.raster;
        let mut buildings = Raster::empty(grid)?;
        for f in &map.footprints {
            let rings = rings_of(f);
            buildings.fill_building(rings.iter().map(Vec::as_slice))?;
        }
        let mut writer = self.writer.begin_map(
            id,
            &MapInput {
                buildings: &buildings,
                tx_m: &positions(&terminals.tx),
                rx_m: &positions(&terminals.rx),
                links: Links::Grid,
            },
        )?;
        for group in terminals.tx.chunks(TX_AT_ONCE) {
            let rows: Vec<Result<Rows>> = group
                .par_iter()
                .map(|&tx| self.transmitter(&tracer, tx, &rx))
                .collect();
            let started = Instant::now();
            for rows in rows {
                let rows = rows.with_context(|| format!("map {id}"))?;
                writer.push(&self.link_rows(&rows))?;
                tally.add(&rows.tally);
            }
            tally.write += started.elapsed();
        }
        let started = Instant::now();
        writer.set_statistics(tally.statistics());
        let entry = writer.finish()?;
        tally.write += started.elapsed();
        tally.bytes = entry.files.iter().map(|f| f.bytes).sum();
        Ok(tally)
    }

    fn link_rows<'r>(&self, rows: &'r Rows) -> LinkRows<'r> {
        let layout = &self.writer.config().layout;
        let profile = |db: &'r [f64]| ProfileRows { db, argmax: None };
        LinkRows {
            status: &rows.status,
            fallback: Some(&rows.fallback),
            aps: layout.aps.map(|_| profile(&rows.aps_db)),
            pdp: layout.pdp.map(|_| profile(&rows.pdp_db)),
            paths: layout.paths.then(|| rows.paths.rows()),
        }
    }

    fn transmitter(&self, tracer: &Tracer<'_>, tx: DVec2, rx: &[Receiver]) -> Result<Rows> {
        let started = Instant::now();
        let tx = tracer.transmitter(tx).context("transmitter")?;
        let layout = &self.writer.config().layout;
        let delays = self.labeler.delays_s().len();
        let protocol = self.labeler.config().protocol;
        let mut rows = Rows::default();
        rows.tally.prepare = started.elapsed();
        rows.tally.empty_beams = tx.empty_beam_count() as u64;
        let (mut link, mut scratch, mut label) =
            (Link::default(), Scratch::default(), Label::default());
        let mut samples = Vec::new();
        for rx in rx {
            if self.interrupted.load(Ordering::Relaxed) {
                bail!("interrupted");
            }
            let started = Instant::now();
            let traced = tracer.link(&tx, rx, &mut link);
            let traced_at = Instant::now();
            rows.tally.trace += traced_at - started;
            if let Err(TraceError::Coincident { .. }) = traced {
                link.paths.clear();
            }
            samples.clear();
            samples.extend(link.paths.iter().map(|p| PathSample {
                delay_s: p.delay_s,
                arrival_azimuth_rad: p.arrival_azimuth_rad,
                gain_db: p.gain_db(),
            }));
            let labelled = self
                .labeler
                .label_into(&samples, &mut scratch, &mut label)?;
            let status = match (traced, labelled) {
                (Err(_), _) => LinkStatus::SamePoint,
                (_, Status::Labelled) => LinkStatus::Valid,
                _ if link.is_enclosed => LinkStatus::Enclosed,
                _ if link.paths.is_empty() => LinkStatus::NoPath,
                _ => LinkStatus::Unlabelled,
            };
            rows.tally.label += traced_at.elapsed();
            rows.tally.link(&link, &label, status, protocol);
            rows.status.push(status);
            let beyond = link.fallback_diffractions.unwrap_or(0);
            rows.fallback.push(beyond.min(u8::MAX.into()) as u8);
            let n = rows.status.len();
            // Rows of links without label are ignored, whatever they hold.
            if layout.aps.is_some() {
                rows.aps_db.extend_from_slice(&label.aps_db);
                rows.aps_db.resize(n * ANGLE_BINS, 0.0);
            }
            if layout.pdp.is_some() {
                rows.pdp_db.extend_from_slice(&label.pdp_db);
                rows.pdp_db.resize(n * delays, 0.0);
            }
            if layout.paths {
                rows.paths.push(&link.paths);
            }
        }
        self.progress.inc(rx.len() as u64);
        Ok(rows)
    }
}

fn positions(points: &[DVec2]) -> Vec<[f64; 2]> {
    points.iter().map(|p| p.to_array()).collect()
}

/// Outer ring and courtyards of a building, as a raster takes them.
pub fn rings_of(f: &Footprint) -> Vec<Vec<[f64; 2]>> {
    std::iter::once(&f.outer)
        .chain(&f.holes)
        .map(|ring| positions(ring))
        .collect()
}
