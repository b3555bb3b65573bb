//! The geometry that a model may be given of links, for networks of any framework: ways along rays, found in scenes when they are
//! asked for.

mod cache;

use std::sync::Arc;

use aps_label::Array;
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::polar::{
    Fan, Mirror, PER_WAY, PolarError, PolarLink, PolarMap, ReceiverRays, TransmitterWays,
};
use rayon::prelude::*;

use self::cache::{Cache, Cell, Key};
use crate::error::{At, Place, Result};

/// Memory for the ways of transmitters, beside those of the batches under way \[bytes\]: some thousands on maps of 256 m.
const TRANSMITTER_BYTES: usize = 256 << 20;

/// Memory for the rays of receivers likewise: some 1,500.
const RECEIVER_BYTES: usize = 256 << 20;

/// A link whose geometry is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenLink {
    /// Place of its map among those of the [`PolarViews`].
    pub map: usize,
    /// Place of the transmitter \[m\].
    pub tx_m: [f64; 2],
    /// Place of the receiver \[m\].
    pub rx_m: [f64; 2],
    /// Mirror image of the link, map and all, that is asked for.
    pub mirror: Mirror,
}

/// Maps as their receivers see them along rays, with the default [`Fan`]: the input of Polar-Reg.
///
/// Ways of transmitters and rays of receivers are made once for all links that follow soon, on all threads, and are bounded in
/// memory. None are made for a mirror image: it has the same ways from other directions.
///
/// ```
/// use map2aps::aps_raytrace::{Scene, polar::Mirror};
/// use map2aps::{PolarViews, SeenLink};
///
/// let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]")?;
/// let views = PolarViews::new([Ok((0, scene))].into_iter())?;
/// let link = SeenLink { map: 0, tx_m: [20.0, 70.0], rx_m: [70.0, 30.0], mirror: Mirror::default() };
/// let ways = &views.ways(&[link])?[0];
/// assert_eq!(ways.len() % map2aps::aps_raytrace::polar::PER_WAY, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PolarViews {
    maps: Vec<Arc<PolarMap<'static>>>,
    transmitters: Cache<TransmitterWays>,
    receivers: Cache<ReceiverRays>,
}

/// A link with everything it is made of.
struct Ready<'a> {
    link: &'a SeenLink,
    transmitter: Cell<TransmitterWays>,
    receiver: Cell<ReceiverRays>,
}

impl PolarViews {
    /// Prepares scenes, which are named by the ids of their maps. Works on all threads, one scene after another.
    ///
    /// # Errors
    /// Errors of the scenes, and a scene of too many corners.
    pub fn new(scenes: impl Iterator<Item = Result<(u32, Scene)>>) -> Result<Self> {
        let prepare = |scene: Result<(u32, Scene)>| {
            let (id, scene) = scene?;
            let map = PolarMap::owning(scene, Fan::default()).at(Place::Map(id))?;
            Ok(Arc::new(map))
        };
        let maps = scenes.map(prepare).collect::<Result<_>>()?;
        Ok(Self {
            maps,
            transmitters: Cache::new(TRANSMITTER_BYTES, TransmitterWays::bytes),
            receivers: Cache::new(RECEIVER_BYTES, ReceiverRays::bytes),
        })
    }

    /// Puts the maps of others behind these.
    pub fn with(mut self, others: Self) -> Self {
        self.maps.extend(others.maps);
        self
    }

    /// Number of maps.
    pub fn maps(&self) -> usize {
        self.maps.len()
    }

    /// The rays of a receiver.
    pub fn fan() -> Fan {
        Fan::default()
    }

    /// Computes the response of an array in each bin of its spectra to unit power along each [ray](Self::fan): (bins, rays), last axis
    /// fastest.
    pub fn array_response(array: &Array, angles_deg: impl Iterator<Item = f64>) -> Vec<f64> {
        let fan = Self::fan();
        let response = |angle_deg: f64| {
            let of = move |ray| array.power_response(angle_deg.to_radians(), fan.angle_rad(ray));
            (0..fan.directions).map(of)
        };
        angles_deg.flat_map(response).collect()
    }

    /// Begins the ways of links that will be asked for soon. Errors are found again by [`ways`](Self::ways).
    ///
    /// # Panics
    /// When a link is on none of the maps.
    pub fn prepare(&self, links: &[SeenLink]) {
        self.ready(links);
    }

    /// Finds the ways of each link, as [`PolarLink::ways`] and [`Mirror::turn_ways`] do, on all threads.
    ///
    /// # Errors
    /// [`PolarError::Terminal`] for an end that is indoors or not finite, by its link.
    ///
    /// # Panics
    /// When a link is on none of the maps.
    pub fn ways(&self, links: &[SeenLink]) -> Result<Vec<Vec<f32>>> {
        let ready = self.ready(links);
        let all = ready.par_iter().enumerate().map(|(row, link)| {
            let mut ways = Vec::new();
            let polar = link.polar(&self.maps);
            let found = polar.and_then(|polar| polar.ways(&mut ways));
            found.at(Place::Link(row))?;
            link.link
                .mirror
                .turn_ways(&mut ways, Self::fan().directions);
            Ok(ways)
        });
        all.collect()
    }

    /// Makes everything that the ways of links are looked up in.
    fn ready<'a>(&self, links: &'a [SeenLink]) -> Vec<Ready<'a>> {
        let key = |map: usize, end_m: [f64; 2]| -> Key { (map, end_m.map(f64::to_bits)) };
        let of_tx = links.iter().map(|link| key(link.map, link.tx_m));
        let of_rx = links.iter().map(|link| key(link.map, link.rx_m));
        let cells = self.transmitters.cells(of_tx).into_iter();
        let cells = cells.zip(self.receivers.cells(of_rx));
        let ready: Vec<Ready<'_>> = links
            .iter()
            .zip(cells)
            .map(|(link, (transmitter, receiver))| Ready {
                link,
                transmitter,
                receiver,
            })
            .collect();
        ready.par_iter().for_each(|ready| {
            let (map, link) = (&self.maps[ready.link.map], ready.link);
            let of_tx = || map.transmitter(DVec2::from(link.tx_m));
            let of_rx = || map.receiver(DVec2::from(link.rx_m));
            ready.transmitter.get_or_init(of_tx);
            ready.receiver.get_or_init(of_rx);
        });
        ready
    }
}

/// Puts the ways of some links into one array of shape (links, ways, [`PER_WAY`]); links of fewer ways than others end with ways of
/// zeros, whose feature 1 says that they are none, and one there is at least.
///
/// # Panics
/// When a list is not of whole ways.
pub fn padded(ways: &[Vec<f32>]) -> (Vec<f32>, [usize; 3]) {
    let is_whole = |ways: &Vec<f32>| ways.len().is_multiple_of(PER_WAY);
    assert!(ways.iter().all(is_whole), "{PER_WAY} numbers a way");
    let most = ways.iter().map(|ways| ways.len() / PER_WAY).max();
    let shape = [ways.len(), most.unwrap_or(0).max(1), PER_WAY];
    let mut values = Vec::with_capacity(shape.iter().product());
    for (link, ways) in (1..).zip(ways) {
        values.extend_from_slice(ways);
        values.resize(link * shape[1] * PER_WAY, 0.0);
    }
    (values, shape)
}

impl Ready<'_> {
    /// The link, if both of its ends can stand there.
    fn polar<'a>(
        &'a self,
        maps: &'a [Arc<PolarMap<'static>>],
    ) -> Result<PolarLink<'a>, PolarError> {
        let made = "everything is made before it is looked up";
        let (transmitter, receiver) = (self.transmitter.get(), self.receiver.get());
        Ok(PolarLink {
            map: &maps[self.link.map],
            transmitter: transmitter.expect(made).as_ref().map_err(Clone::clone)?,
            receiver: receiver.expect(made).as_ref().map_err(Clone::clone)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use aps_raytrace::scene::{CityConfig, Location};

    use super::*;

    fn city() -> (PolarViews, Vec<[f64; 2]>) {
        let scene = Scene::synthetic(&CityConfig::default()).unwrap();
        let places = (0..).map(|i: u32| [f64::from(i * 37 % 250), f64::from(i * 91 % 250)]);
        let is_outdoor = |&p: &[f64; 2]| scene.locate(DVec2::from(p)) == Location::Outdoor;
        let places = places.filter(is_outdoor).take(6).collect();
        (
            PolarViews::new([Ok((0, scene))].into_iter()).unwrap(),
            places,
        )
    }

    /// Whatever was asked for before, and in whatever company: the same bits.
    #[test]
    fn ways_of_a_link_do_not_depend_on_what_was_made_before() {
        let (views, places) = city();
        let link = |tx: usize, rx: usize| SeenLink {
            map: 0,
            tx_m: places[tx],
            rx_m: places[rx],
            mirror: Mirror::default(),
        };
        let links = [link(0, 1), link(0, 2), link(3, 1)];
        let first = views.ways(&links).unwrap();
        views.prepare(&[link(4, 5)]);
        assert_eq!(views.ways(&links).unwrap(), first);
        assert_eq!(city().0.ways(&links[2..]).unwrap(), first[2..]);
        assert!(first[0] != first[1]);
    }

    #[test]
    fn links_of_fewer_ways_end_with_ways_of_zeros() {
        let way = |value: f32| [value; PER_WAY];
        let ways = [Vec::new(), way(1.0).to_vec(), [way(2.0), way(3.0)].concat()];
        let (values, shape) = padded(&ways);
        assert_eq!(shape, [3, 2, PER_WAY]);
        assert_eq!(values, [0.0, 0.0, 1.0, 0.0, 2.0, 3.0].map(way).concat());
        assert_eq!(padded(&[Vec::new()]), (way(0.0).to_vec(), [1, 1, PER_WAY]));
    }

    #[test]
    fn an_end_that_cannot_stand_there_is_named_by_its_link() {
        let (views, places) = city();
        let link = |rx_m| SeenLink {
            map: 0,
            tx_m: places[0],
            rx_m,
            mirror: Mirror::default(),
        };
        let error = views.ways(&[link(places[1]), link([f64::NAN; 2])]);
        let error = error.unwrap_err().chain();
        assert!(error.starts_with("link 1: no terminal"), "{error}");
    }
}
