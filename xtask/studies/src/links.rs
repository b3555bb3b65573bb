//! Links of a scene, traced and labelled with one setting after another, and timed.

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::Result;
use aps_data::sample_of;
use aps_label::{Label, LabelConfig, Labeler, MAX_PATHS, PathSample, Scratch, Status};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, Omitted, PathRecord, Receiver, Scene, TraceConfig, Tracer, Transmitter};
use map2aps::sampling::draw as draw_terminals;
use rayon::prelude::*;

use crate::{NamedScene, Stopwatch, on_one_thread};

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

/// The outcome of one setting.
#[derive(Default)]
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
    /// Paths of all links.
    pub paths: usize,
}

/// Costs of a link, part by part.
#[derive(Debug, Clone, Copy, Default)]
pub struct LinkTime {
    /// A map \[s\].
    pub map_s: f64,
    /// A transmitter \[us\].
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
        let terminals = draw_terminals(&place.scene, seed, place.id, tx, rx..=rx)?;
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
        let mut all: Vec<(Option<Vec<f64>>, usize)> = Vec::with_capacity(self.len());
        for &p in &self.tx {
            // One transmitter at a time: its waves at the corners take the most memory.
            let tx = tracer.transmitter(p)?;
            let of_link = |rx: &Receiver| {
                let mut link = Link::default();
                tracer.link(&tx, rx, &mut link)?;
                let paths = link.paths.len();
                let label = self.labeler.label(&strongest(link.paths))?;
                Ok((label.map(|l| l.aps_db), paths))
            };
            let of_tx: Vec<_> = rx.par_iter().map(of_link).collect::<Result<_>>()?;
            all.extend(of_tx);
        }
        Ok(Reference {
            paths: all.iter().map(|l| l.1).sum(),
            spectra: all.into_iter().map(|l| l.0).collect(),
        })
    }

    /// Traces and labels with each setting on one thread, and times every part. Settings to be compared are best given at once:
    /// their samples take turns.
    pub fn measure(&self, configs: &[&TraceConfig], stopwatch: Stopwatch) -> Result<Vec<Traced>> {
        on_one_thread(|| self.measure_here(configs, stopwatch))?
    }

    fn measure_here(&self, configs: &[&TraceConfig], stopwatch: Stopwatch) -> Result<Vec<Traced>> {
        let (tracers, began) = timed(configs, |&config| {
            Ok(Tracer::new(self.scene, config.clone())?)
        })?;
        let map = stopwatch.compare_again(&began, configs, |&config| {
            let _ = black_box(Tracer::new(self.scene, config.clone()));
        });
        let (tx, began) = timed(&tracers, |t| prepare(&self.tx, |p| t.transmitter(p)))?;
        let transmitter = stopwatch.compare_again(&began, &tracers, |tracer| {
            for &p in &self.tx {
                let _ = black_box(tracer.transmitter(p));
            }
        });
        let (rx, began) = timed(&tracers, |t| prepare(&self.rx, |p| t.receiver(p)))?;
        let receiver = stopwatch.compare_again(&began, &tracers, |tracer| {
            for &p in &self.rx {
                let _ = black_box(tracer.receiver(p));
            }
        });
        let ready: Vec<Ready<'_>> = (0..configs.len())
            .map(|i| Ready {
                tracer: &tracers[i],
                tx: &tx[i],
                rx: &rx[i],
            })
            .collect();
        let mut found: Vec<Found> = ready.iter().map(Ready::find).collect::<Result<_>>()?;
        let cold: Vec<Duration> = found.iter().map(|f| f.cold).collect();
        let join = stopwatch.compare_again(&cold, &ready, Ready::join);
        let mut began = Vec::with_capacity(found.len());
        for found in &mut found {
            let started = Instant::now();
            found.traced.spectra = self.label(&found.samples)?;
            began.push(started.elapsed());
        }
        let label = stopwatch.compare_again(&began, &found, |found| {
            let _ = black_box(self.label(&found.samples));
        });
        let us = |seconds: f64, count: usize| 1e6 * seconds / count as f64;
        let traced = found.into_iter().enumerate().map(|(i, found)| Traced {
            time: LinkTime {
                map_s: map[i],
                transmitter_us: us(transmitter[i], self.tx.len()),
                receiver_us: us(receiver[i], self.rx.len()),
                join_us: us(join[i], self.len()),
                label_us: us(label[i], self.len()),
            },
            ..found.traced
        });
        Ok(traced.collect())
    }

    /// Spectra of all links \[dB\].
    fn label(&self, samples: &[Vec<PathSample>]) -> Result<Spectra> {
        let (mut scratch, mut label) = (Scratch::default(), Label::default());
        let of_link = |samples: &Vec<PathSample>| {
            let status = self.labeler.label_into(samples, &mut scratch, &mut label)?;
            Ok((status == Status::Labelled).then(|| label.aps_db.clone()))
        };
        samples.iter().map(of_link).collect()
    }
}

/// One setting with its terminals prepared.
struct Ready<'r> {
    tracer: &'r Tracer<'r>,
    tx: &'r [Transmitter],
    rx: &'r [Receiver],
}

/// The finds of a first pass over its links.
struct Found {
    traced: Traced,
    samples: Vec<Vec<PathSample>>,
    /// Time of the pass.
    cold: Duration,
}

impl Ready<'_> {
    fn find(&self) -> Result<Found> {
        let mut found = Found {
            traced: Traced {
                corners: self.tracer.corner_count(),
                images: self.tx.iter().map(Transmitter::image_count).sum(),
                ..Traced::default()
            },
            samples: Vec::with_capacity(self.tx.len() * self.rx.len()),
            cold: Duration::ZERO,
        };
        let mut link = Link::default();
        for tx in self.tx {
            for rx in self.rx {
                let began = Instant::now();
                self.tracer.link(tx, rx, &mut link)?;
                found.cold += began.elapsed();
                let traced = &mut found.traced;
                traced.paths += link.paths.len();
                traced.omitted.by_bound += link.omitted.by_bound;
                traced.omitted.by_gain += link.omitted.by_gain;
                traced.cut_links += usize::from(link.paths.len() > MAX_PATHS);
                found.samples.push(labelled(&mut link.paths));
            }
        }
        Ok(found)
    }

    fn join(&self) {
        let mut link = Link::default();
        for tx in self.tx {
            for rx in self.rx {
                let _ = black_box(self.tracer.link(tx, rx, &mut link));
            }
        }
    }
}

/// The things that each setting makes, and the time it took.
fn timed<A, B>(settings: &[A], make: impl Fn(&A) -> Result<B>) -> Result<(Vec<B>, Vec<Duration>)> {
    let mut made = Vec::with_capacity(settings.len());
    let mut times = Vec::with_capacity(settings.len());
    for setting in settings {
        let started = Instant::now();
        made.push(make(setting)?);
        times.push(started.elapsed());
    }
    Ok((made, times))
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

/// The part that a label takes of a link's paths: all of them, or as many of the strongest.
fn labelled(paths: &mut [PathRecord]) -> Vec<PathSample> {
    if paths.len() > MAX_PATHS {
        strongest_first(paths);
    }
    paths.iter().map(sample_of).take(MAX_PATHS).collect()
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
    kept.map(sample_of).take(MAX_PATHS).collect()
}

fn strongest_first(paths: &mut [PathRecord]) {
    paths.sort_by(|p, q| q.power().total_cmp(&p.power()));
}
