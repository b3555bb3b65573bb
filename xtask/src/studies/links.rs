//! Links of a scene, traced and labelled with one setting after another, and timed.

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::Result;
use aps_label::{Label, LabelConfig, Labeler, MAX_PATHS, PathSample, Scratch, Status};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, Omitted, PathRecord, Receiver, Scene, TraceConfig, Tracer, Transmitter};
use rayon::prelude::*;

use super::{NamedScene, Stopwatch, on_one_thread};
use crate::{samples, sampling};

/// Transmitters and receivers of a map of the benchmark: what is done once a terminal is shared by so many links.
const SHARED_BY: (f64, f64) = (500.0, 100.0);

/// A reference leaves paths out once all that are left are this far below the strongest \[dB\], together.
pub const REST_DB: f64 = 80.0;

/// Terminals in a scene; every transmitter has a link to every receiver.
pub struct Links<'s> {
    scene: &'s Scene,
    tx: Vec<DVec2>,
    rx: Vec<DVec2>,
    labeler: Labeler,
}

/// Spectra \[dB\] of the links, transmitter after transmitter; none for a link without a path.
pub type Spectra = Vec<Option<Vec<f64>>>;

/// What one setting gives.
pub struct Traced {
    pub spectra: Spectra,
    pub time: LinkTime,
    /// Paths of all links.
    pub paths: usize,
    pub omitted: Omitted,
    /// Corners that can diffract.
    pub corners: usize,
    /// Images of all transmitters.
    pub images: usize,
    /// Links with more paths than a label takes, of which the strongest were labelled.
    pub cut_links: usize,
}

/// The best that is affordable.
pub struct Reference {
    pub spectra: Spectra,
    /// Whether a link was reached only by chains of more diffractions than the limits allow.
    pub is_beyond: Vec<bool>,
    /// Paths of all links.
    pub paths: usize,
}

/// What a link costs, part by part.
#[derive(Debug, Clone, Copy, Default)]
pub struct LinkTime {
    /// A map \[s\].
    pub map_s: f64,
    /// A transmitter, with what the first of its links without a path adds \[us\].
    pub transmitter_us: f64,
    /// A receiver \[us\].
    pub receiver_us: f64,
    /// The join of the two \[us\].
    pub join_us: f64,
    /// The label of the paths found \[us\].
    pub label_us: f64,
}

impl LinkTime {
    /// Tracing of a link in a map of 100 transmitters and 500 receivers \[us\].
    pub fn trace_us(&self) -> f64 {
        let (of_tx, of_rx) = SHARED_BY;
        self.join_us
            + self.transmitter_us / of_tx
            + self.receiver_us / of_rx
            + 1e6 * self.map_s / (of_tx * of_rx)
    }

    /// Tracing and labelling \[us\].
    pub fn total_us(&self) -> f64 {
        self.trace_us() + self.label_us
    }
}

impl<'s> Links<'s> {
    /// Draws the terminals.
    pub fn draw(place: &'s NamedScene, seed: u64, tx: usize, rx: usize) -> Result<Self> {
        let terminals = sampling::draw(&place.scene, seed, place.id, tx, rx)?;
        Ok(Self {
            scene: &place.scene,
            tx: terminals.tx,
            rx: terminals.rx,
            labeler: Labeler::new(&LabelConfig::paper())?,
        })
    }

    /// Number of links.
    pub fn len(&self) -> usize {
        self.tx.len() * self.rx.len()
    }

    /// Traces with a setting too costly to be timed, on all threads.
    pub fn reference(&self, config: &TraceConfig) -> Result<Reference> {
        let tracer = Tracer::new(self.scene, config.clone())?;
        let rx: Vec<Receiver> = prepare(&self.rx, |p| tracer.receiver(p))?;
        let mut all: Vec<(Option<Vec<f64>>, bool, usize)> = Vec::with_capacity(self.len());
        for &p in &self.tx {
            // One transmitter at a time: its waves at the corners are what takes memory.
            let tx = tracer.transmitter(p)?;
            let of_link = |rx: &Receiver| {
                let mut link = Link::default();
                tracer.link(&tx, rx, &mut link)?;
                let (paths, is_beyond) = (link.paths.len(), link.fallback_diffractions.is_some());
                let label = self.labeler.label(&strongest(link.paths))?;
                Ok((label.map(|l| l.aps_db), is_beyond, paths))
            };
            let of_tx: Vec<_> = rx.par_iter().map(of_link).collect::<Result<_>>()?;
            all.extend(of_tx);
        }
        Ok(Reference {
            paths: all.iter().map(|l| l.2).sum(),
            is_beyond: all.iter().map(|l| l.1).collect(),
            spectra: all.into_iter().map(|l| l.0).collect(),
        })
    }

    /// Traces and labels on one thread, and times every part.
    pub fn measure(&self, config: &TraceConfig, stopwatch: Stopwatch) -> Result<Traced> {
        on_one_thread(|| self.measure_here(config, stopwatch))?
    }

    fn measure_here(&self, config: &TraceConfig, stopwatch: Stopwatch) -> Result<Traced> {
        let began = Instant::now();
        let tracer = Tracer::new(self.scene, config.clone())?;
        let map = stopwatch.time_again(began.elapsed(), || {
            let _ = black_box(Tracer::new(self.scene, config.clone()));
        });
        let began = Instant::now();
        let tx: Vec<Transmitter> = prepare(&self.tx, |p| tracer.transmitter(p))?;
        let transmitter = stopwatch.time_again(began.elapsed(), || {
            for &p in &self.tx {
                let _ = black_box(tracer.transmitter(p));
            }
        });
        let began = Instant::now();
        let rx: Vec<Receiver> = prepare(&self.rx, |p| tracer.receiver(p))?;
        let receiver = stopwatch.time_again(began.elapsed(), || {
            for &p in &self.rx {
                let _ = black_box(tracer.receiver(p));
            }
        });
        let mut traced = Traced {
            spectra: Vec::with_capacity(self.len()),
            time: LinkTime::default(),
            paths: 0,
            omitted: Omitted::default(),
            corners: tracer.corner_count(),
            images: tx.iter().map(Transmitter::image_count).sum(),
            cut_links: 0,
        };
        let mut samples: Vec<Vec<PathSample>> = Vec::with_capacity(self.len());
        let mut link = Link::default();
        let mut cold = Duration::ZERO;
        for tx in &tx {
            for rx in &rx {
                let began = Instant::now();
                tracer.link(tx, rx, &mut link)?;
                cold += began.elapsed();
                traced.paths += link.paths.len();
                traced.omitted.by_bound += link.omitted.by_bound;
                traced.omitted.by_gain += link.omitted.by_gain;
                traced.cut_links += usize::from(link.paths.len() > MAX_PATHS);
                samples.push(labelled(&mut link.paths));
            }
        }
        let join = stopwatch.time_again(cold, || {
            for tx in &tx {
                for rx in &rx {
                    let _ = black_box(tracer.link(tx, rx, &mut link));
                }
            }
        });
        let (mut scratch, mut label) = (Scratch::default(), Label::default());
        let began = Instant::now();
        for samples in &samples {
            let status = self.labeler.label_into(samples, &mut scratch, &mut label)?;
            let is_labelled = status == Status::Labelled;
            traced
                .spectra
                .push(is_labelled.then(|| label.aps_db.clone()));
        }
        let labels = stopwatch.time_again(began.elapsed(), || {
            for samples in &samples {
                let _ = black_box(self.labeler.label_into(samples, &mut scratch, &mut label));
            }
        });
        // Chains beyond the limits are made when a link first asks for them.
        let first_us = 1e6 * (cold.as_secs_f64() - join.median_s).max(0.0) / tx.len() as f64;
        let first_us = if config.max_fallback_diffractions > 0 {
            first_us
        } else {
            0.0
        };
        traced.time = LinkTime {
            map_s: map.median_s,
            transmitter_us: transmitter.per(tx.len()).us() + first_us,
            receiver_us: receiver.per(rx.len()).us(),
            join_us: join.per(self.len()).us(),
            label_us: labels.per(self.len()).us(),
        };
        Ok(traced)
    }
}

fn prepare<T: Send, E: Into<anyhow::Error> + Send>(
    places: &[DVec2],
    one: impl Fn(DVec2) -> Result<T, E> + Sync,
) -> Result<Vec<T>> {
    places
        .par_iter()
        .map(|&p| one(p).map_err(Into::into))
        .collect()
}

/// What a label takes of a link's paths: all of them, or as many of the strongest.
fn labelled(paths: &mut [PathRecord]) -> Vec<PathSample> {
    if paths.len() > MAX_PATHS {
        strongest_first(paths);
    }
    paths
        .iter()
        .map(samples::of_record)
        .take(MAX_PATHS)
        .collect()
}

/// The strongest paths, until the rest is nothing.
fn strongest(mut paths: Vec<PathRecord>) -> Vec<PathSample> {
    strongest_first(&mut paths);
    let least = paths.first().map_or(0.0, PathRecord::power) * 10_f64.powf(-0.1 * REST_DB);
    let mut rest: f64 = paths.iter().map(PathRecord::power).sum();
    let kept = paths.iter().take_while(|path| {
        let counts = rest > least;
        rest -= path.power();
        counts
    });
    kept.map(samples::of_record).take(MAX_PATHS).collect()
}

fn strongest_first(paths: &mut [PathRecord]) {
    paths.sort_by(|p, q| q.power().total_cmp(&p.power()));
}
