//! Maps, tracers and terminals that were prepared: made when they are first asked for, and kept while they are in use.
//!
//! A map is prepared once for each configuration, a terminal once for each place. So a receiver that is dragged costs the look
//! around it and its join with the transmitter.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;
use aps_raytrace::{Receiver, Scene, TerminalError, TraceConfig, Tracer, Transmitter};
use aps_report::picture::Outlines;
use map2aps::aps_model::ModelKind;
use map2aps::maps::choose;
use map2aps::training::{Device, LinkModel, Trained};
use map2aps::{MapSource, PolarViews, SceneSettings};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::fault::{End, Fault};
use crate::houses::House;
use crate::lru_cache::LruCache;
use crate::request::CityQuestion;
use crate::request_handle::RequestHandle;

/// Scenes, tracers and terminals that are kept. A tracer may take some hundred megabytes.
const SCENES: usize = 8;
const TRACERS: usize = 4;
const TERMINALS: usize = 8;

/// Geometries for the model that are kept; each bounds its terminals itself.
const VIEWS: usize = 2;

/// The maps to choose from.
#[derive(Debug)]
pub struct Maps {
    /// Their source.
    pub source: MapSource,
    /// Their numbers.
    pub ids: Vec<u32>,
    /// Seed of synthetic cities and of first places.
    pub seed: u64,
    /// Settings of their scenes.
    pub scene: SceneSettings,
}

impl Maps {
    /// Lists the maps of a source.
    ///
    /// # Errors
    /// A source that cannot be read, or holds no map.
    pub fn new(source: MapSource, seed: u64, scene: SceneSettings) -> map2aps::Result<Self> {
        Ok(Self {
            ids: source.ids()?,
            source,
            seed,
            scene,
        })
    }
}

/// A map with its buildings as they stand.
#[derive(Debug)]
pub struct City {
    number: u64,
    /// Number of houses of the map as it was read.
    pub as_read: usize,
    /// The houses that were given.
    pub houses: Vec<House>,
    /// The square of the map.
    pub area: Area,
    /// The scene that they make.
    pub scene: Scene,
    /// Its walls.
    pub outlines: Outlines,
}

/// Prepared object with its preparation time.
#[derive(Debug)]
pub struct Prepared<T> {
    number: u64,
    /// The object.
    pub value: T,
    /// Time that its preparation took.
    pub took: Duration,
}

/// A tracer and a transmitter, prepared for some limits.
#[derive(Debug)]
pub struct TxSide {
    /// The tracer of the map.
    pub tracer: Arc<Prepared<Tracer<'static>>>,
    /// The transmitter.
    pub tx: Arc<Prepared<Transmitter>>,
}

/// Maps, tracers and terminals that are kept between requests, and threads to prepare them.
///
/// Whoever prepares something keeps others that ask for it waiting. So no thread of a pool may ask: while it waits for the rest of
/// its own work it would take up theirs, and wait for itself.
#[derive(Debug, Clone)]
pub struct Cache {
    kept: Arc<Kept>,
    threads: Arc<ThreadPool>,
}

#[derive(Debug)]
struct Kept {
    maps: Maps,
    counter: AtomicU64,
    cities: LruCache<CityQuestion, City>,
    tracers: LruCache<(u64, TraceConfig), Prepared<Tracer<'static>>>,
    transmitters: LruCache<(u64, [u64; 2]), Prepared<Transmitter>>,
    receivers: LruCache<(u64, [u64; 2]), Prepared<Receiver>>,
    model: LruCache<(), LinkModel>,
    views: LruCache<u64, Prepared<PolarViews>>,
}

impl Cache {
    /// Makes a cache that holds the list of maps alone.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn new(maps: Maps) -> Result<Self, ThreadPoolBuildError> {
        let kept = Kept {
            maps,
            counter: AtomicU64::new(0),
            cities: LruCache::new(SCENES),
            tracers: LruCache::new(TRACERS),
            transmitters: LruCache::new(TERMINALS),
            receivers: LruCache::new(TERMINALS),
            model: LruCache::new(1),
            views: LruCache::new(VIEWS),
        };
        Ok(Self {
            kept: Arc::new(kept),
            threads: Arc::new(ThreadPoolBuilder::new().build()?),
        })
    }

    /// Shares what is kept with other threads, on which nobody waits for the work of these.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn with_own_threads(&self) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {
            kept: Arc::clone(&self.kept),
            threads: Arc::new(ThreadPoolBuilder::new().build()?),
        })
    }

    /// Does something that works on all threads. It must not ask for anything that is kept.
    pub fn on_all_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.threads.install(work)
    }

    /// The maps to choose from.
    pub fn maps(&self) -> &Maps {
        &self.kept.maps
    }

    /// A map.
    ///
    /// # Errors
    /// A map that is not there, changes that do not fit it, and houses that make no scene.
    pub fn city(&self, question: &CityQuestion) -> Result<Arc<City>, Fault> {
        self.kept.cities.get(question.clone(), || {
            let maps = &self.kept.maps;
            choose(&maps.ids, &[question.map]).map_err(map2aps::Error::from)?;
            let (footprints, area) = maps.source.footprints(question.map, maps.seed)?;
            let as_read = footprints.len();
            let houses = question.houses.apply(footprints)?;
            let given: Vec<_> = houses.iter().map(|h| h.footprint.clone()).collect();
            let scene = maps.scene.scene(&given, area)?;
            Ok(City {
                number: self.number(),
                outlines: Outlines::of_scene(&scene),
                as_read,
                houses,
                area,
                scene,
            })
        })
    }

    fn tracer(
        &self,
        city: &City,
        config: &TraceConfig,
    ) -> Result<Arc<Prepared<Tracer<'static>>>, Fault> {
        self.kept.tracers.get((city.number, config.clone()), || {
            let make = || Tracer::owning(city.scene.clone(), config.clone()).map_err(Fault::of);
            self.on_all_threads(|| self.prepare(make))
        })
    }

    /// Prepares a tracer and a transmitter, unless the request is overtaken between the two.
    ///
    /// # Errors
    /// Limits under which the map takes too much memory, [`Fault::Terminal`] and [`Fault::Overtaken`].
    pub fn tx_side(
        &self,
        city: &City,
        config: &TraceConfig,
        place: [f64; 2],
        handle: &RequestHandle,
    ) -> Result<TxSide, Fault> {
        let tracer = self.tracer(city, config)?;
        handle.check()?;
        let make = |p| tracer.value.transmitter(p);
        let tx = self.terminal(&self.kept.transmitters, &tracer, End::Tx, place, make)?;
        Ok(TxSide { tracer, tx })
    }

    /// Prepares a receiver.
    ///
    /// # Errors
    /// [`Fault::Terminal`].
    pub fn receiver(
        &self,
        tracer: &Prepared<Tracer<'static>>,
        place: [f64; 2],
    ) -> Result<Arc<Prepared<Receiver>>, Fault> {
        let make = |p| tracer.value.receiver(p);
        self.terminal(&self.kept.receivers, tracer, End::Rx, place, make)
    }

    /// The shipped model, read when it is first asked for.
    ///
    /// # Errors
    /// Weights that cannot be read.
    pub fn model(&self) -> Result<Arc<LinkModel>, Fault> {
        self.kept.model.get((), || {
            let device = Device::Cpu.open()?;
            let trained = Trained::shipped(ModelKind::PolarReg, &device)?;
            Ok(LinkModel::new(trained)?)
        })
    }

    /// The geometry of a map as the model is given it. It keeps the ways of transmitters and the rays of receivers.
    ///
    /// # Errors
    /// A map of too many corners.
    pub fn views(&self, city: &City) -> Result<Arc<Prepared<PolarViews>>, Fault> {
        self.kept.views.get(city.number, || {
            let scenes = [Ok((0, city.scene.clone()))].into_iter();
            self.on_all_threads(|| self.prepare(|| Ok(PolarViews::new(scenes)?)))
        })
    }

    fn terminal<T>(
        &self,
        kept: &LruCache<(u64, [u64; 2]), Prepared<T>>,
        tracer: &Prepared<Tracer<'static>>,
        end: End,
        place: [f64; 2],
        make: impl FnOnce(DVec2) -> Result<T, TerminalError>,
    ) -> Result<Arc<Prepared<T>>, Fault> {
        let at = |source| Fault::Terminal { end, source };
        kept.get((tracer.number, place.map(f64::to_bits)), || {
            self.prepare(|| make(DVec2::from(place)).map_err(at))
        })
    }

    fn prepare<T>(&self, make: impl FnOnce() -> Result<T, Fault>) -> Result<Prepared<T>, Fault> {
        let began = Instant::now();
        Ok(Prepared {
            number: self.number(),
            value: make()?,
            took: began.elapsed(),
        })
    }

    fn number(&self) -> u64 {
        self.kept.counter.fetch_add(1, Ordering::Relaxed)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// One synthetic city.
    pub fn cache() -> Cache {
        let source = MapSource::Synthetic { count: 1 };
        Cache::new(Maps::new(source, 42, SceneSettings::default()).unwrap()).unwrap()
    }
}
