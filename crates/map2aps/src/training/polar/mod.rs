//! The input of Polar-Reg: ways along rays, found in the scenes when they are asked for.

mod cache;

use std::sync::Arc;

use aps_label::{LabelConfig, MeanStd, Protocol};
use aps_model::candle_core::{Device, Tensor};
use aps_model::condition::{InputShape, Link, Mirror, ModelInput, PolarShape};
use aps_model::{LabelFacts, Result as ModelResult};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::polar::{
    self, Fan, PolarError, PolarLink, PolarMap, ReceiverRays, Shape, TransmitterWays,
};
use rayon::prelude::*;

use self::cache::{Cache, Cell, Key};
use crate::error::{At, Error, Place, Result};

/// Memory for the ways of transmitters, beside those of the batches under way \[bytes\].
const TRANSMITTER_BYTES: usize = 256 << 20;

/// Memory for the rays of receivers likewise.
const RECEIVER_BYTES: usize = 256 << 20;

/// Size of a transmitter's ways, and of a receiver's rays, in a city of a RadioMapSeer map \[bytes\].
const USUAL_BYTES: usize = 128 << 10;

/// Shape of the ways of a link.
pub(super) fn shape() -> PolarShape {
    let Fan {
        directions,
        max_bounces: bounces,
    } = Fan::default();
    PolarShape {
        directions,
        ways: Shape {
            directions,
            bounces,
        }
        .ways(),
        features: polar::FEATURES,
        numbers: polar::NUMBERS,
    }
}

/// Computes the facts of labels that a model is told: the response of the array in each of the bins, and the statistics by which the
/// protocol normalises.
pub(super) fn label_facts(
    label: &LabelConfig,
    angles_deg: impl Iterator<Item = f64>,
    protocol: Protocol,
    statistics: MeanStd,
) -> LabelFacts {
    let fan = Fan::default();
    let response = |angle_deg: f64| {
        let directions = 0..fan.directions;
        let of = |direction| {
            let arrives_rad = fan.angle_rad(direction);
            label
                .array
                .power_response(angle_deg.to_radians(), arrives_rad)
        };
        directions.map(of).collect::<Vec<_>>()
    };
    LabelFacts {
        array: angles_deg.flat_map(response).collect(),
        mean: statistics.mean,
        deviation: statistics.std,
        is_by_link: protocol == Protocol::Released,
    }
}

/// Finds the ways of links on some maps, as they are and in their mirror images: number `image * maps + map` is a map in an
/// image of [`Mirror::ALL`].
///
/// Ways of transmitters and rays of receivers are made once for all links that follow soon, on all threads, and are bounded in
/// memory. None are made for a mirror image: it has the same values in another order.
#[derive(Debug)]
pub(super) struct PolarWays {
    maps: Vec<Arc<PolarMap<'static>>>,
    /// Position that changes places with 0 in a mirror image \[m\].
    far_end_m: [f64; 2],
    transmitters: Cache<TransmitterWays>,
    receivers: Cache<ReceiverRays>,
    device: Device,
}

/// A link with everything it is made of.
struct Ready {
    map: usize,
    transmitter: Cell<TransmitterWays>,
    receiver: Cell<ReceiverRays>,
    ends: [DVec2; 2],
    mirror: polar::Mirror,
}

/// Prepares scenes, which are named by the ids of their maps. Work on all threads, one scene after another.
pub(super) fn polar_maps(
    scenes: impl Iterator<Item = Result<(u32, Scene)>>,
) -> Result<Vec<Arc<PolarMap<'static>>>> {
    let prepare = |scene: Result<(u32, Scene)>| {
        let (id, scene) = scene?;
        let map = PolarMap::owning(scene, Fan::default()).at(Place::Map(id))?;
        Ok(Arc::new(map))
    };
    scenes.map(prepare).collect()
}

impl PolarWays {
    /// Finds ways on maps that mirror images change about half of `far_end_m`.
    pub fn new(maps: Vec<Arc<PolarMap<'static>>>, far_end_m: [f64; 2], device: Device) -> Self {
        Self {
            maps,
            far_end_m,
            transmitters: Cache::new(TRANSMITTER_BYTES, USUAL_BYTES),
            receivers: Cache::new(RECEIVER_BYTES, USUAL_BYTES),
            device,
        }
    }

    /// The link that a link is the mirror image of, and the image.
    fn upright(&self, link: &Link) -> Option<(Link, Mirror)> {
        let (map, maps) = (link.map as usize, self.maps.len());
        let mirror = *Mirror::ALL.get(map.checked_div(maps)?)?;
        let image = map / maps;
        let flat = Link {
            map: (map % maps) as u32,
            ..*link
        };
        // Its own inverse, and exact for whole metres.
        Some((flat.mirrored(image, 0, self.far_end_m), mirror))
    }

    /// Makes everything that the values of links are looked up in.
    fn ready(&self, links: &[Link]) -> ModelResult<Vec<Ready>> {
        let upright = |link: &Link| {
            let known = self.upright(link);
            known.ok_or_else(|| {
                let maps = self.maps.len();
                aps_model::Error::Condition(format!(
                    "{link:?} is on none of the {maps} maps and their mirror images"
                ))
            })
        };
        let links: Vec<(Link, Mirror)> = links.iter().map(upright).collect::<ModelResult<_>>()?;
        let key = |map: u32, end_m: [f64; 2]| -> Key { (map as usize, end_m.map(f64::to_bits)) };
        let of_tx = links.iter().map(|(link, _)| key(link.map, link.tx_m));
        let of_rx = links.iter().map(|(link, _)| key(link.map, link.rx_m));
        let cells = self.transmitters.cells(of_tx).into_iter();
        let cells = cells.zip(self.receivers.cells(of_rx));
        let ready: Vec<Ready> = links
            .iter()
            .zip(cells)
            .map(|((link, mirror), (transmitter, receiver))| Ready {
                map: link.map as usize,
                transmitter,
                receiver,
                ends: [link.tx_m, link.rx_m].map(DVec2::from),
                mirror: polar::Mirror {
                    x: mirror.x,
                    y: mirror.y,
                },
            })
            .collect();
        ready.par_iter().for_each(|link| {
            let (map, [tx, rx]) = (&self.maps[link.map], link.ends);
            link.transmitter.get_or_init(|| map.transmitter(tx));
            link.receiver.get_or_init(|| map.receiver(rx));
        });
        Ok(ready)
    }
}

impl Ready {
    /// Writes the values of the link.
    fn write(&self, maps: &[Arc<PolarMap<'static>>], out: &mut [f32]) -> Result<(), PolarError> {
        let map = &maps[self.map];
        let made = "everything is made before it is looked up";
        let link = PolarLink {
            map,
            transmitter: self
                .transmitter
                .get()
                .expect(made)
                .as_ref()
                .map_err(Clone::clone)?,
            receiver: self
                .receiver
                .get()
                .expect(made)
                .as_ref()
                .map_err(Clone::clone)?,
            mirror: self.mirror,
        };
        link.write(out)
    }
}

impl ModelInput for PolarWays {
    fn batch(&self, links: &[Link]) -> ModelResult<Tensor> {
        let (ready, shape) = (self.ready(links)?, shape());
        let one = shape.directions * shape.values();
        let mut values = vec![0.0; links.len() * one];
        values
            .par_chunks_mut(one)
            .zip(&ready)
            .try_for_each(|(values, link)| link.write(&self.maps, values))
            .map_err(|error| aps_model::Error::Input(error.into()))?;
        let shape = (links.len(), shape.directions, shape.values());
        Ok(Tensor::from_vec(values, shape, &self.device)?)
    }

    fn prepare(&self, links: &[Link]) -> ModelResult<()> {
        self.ready(links).map(drop)
    }

    fn group(&self, link: &Link) -> Option<u64> {
        let (link, _) = self.upright(link)?;
        let words = [
            link.map.into(),
            link.tx_m[0].to_bits(),
            link.tx_m[1].to_bits(),
        ];
        // Two transmitters of one number would only be taken together.
        let mix = |sum: u64, word: u64| {
            (sum ^ word)
                .wrapping_mul(0x9E37_79B9_7F4A_7C15)
                .rotate_left(29)
        };
        Some(words.into_iter().fold(0, mix))
    }

    fn device(&self) -> &Device {
        &self.device
    }

    fn shape(&self) -> InputShape {
        InputShape::Polar(shape())
    }

    fn image_size(&self) -> usize {
        0
    }
}

impl From<PolarError> for Error {
    fn from(error: PolarError) -> Self {
        Self::Model(aps_model::Error::Input(error.into()))
    }
}

#[cfg(test)]
mod tests {
    use aps_label::{Labeler, PathSample};
    use aps_raytrace::scene::{CityConfig, Location};

    use super::*;

    fn city() -> (PolarWays, Vec<[f64; 2]>) {
        let scene = Scene::synthetic(&CityConfig::default()).unwrap();
        let places = (0..).map(|i: u32| [f64::from(i * 37 % 250), f64::from(i * 91 % 250)]);
        let is_outdoor = |&p: &[f64; 2]| scene.locate(DVec2::from(p)) == Location::Outdoor;
        let places = places.filter(is_outdoor).take(6).collect();
        let maps = polar_maps([Ok((0, scene))].into_iter()).unwrap();
        (PolarWays::new(maps, [255.0; 2], Device::Cpu), places)
    }

    fn values(ways: &PolarWays, links: &[Link]) -> Vec<Vec<Vec<f32>>> {
        ways.batch(links).unwrap().to_vec3().unwrap()
    }

    /// Whatever was asked for before, and in whatever company: the same bits.
    #[test]
    fn ways_of_a_link_do_not_depend_on_what_was_made_before() {
        let (ways, places) = city();
        let link = |tx: usize, rx: usize| Link {
            map: 0,
            tx_m: places[tx],
            rx_m: places[rx],
        };
        let links = [link(0, 1), link(0, 2), link(3, 1)];
        let first = values(&ways, &links);
        ways.prepare(&[link(4, 5)]).unwrap();
        assert!(values(&ways, &links) == first);
        assert!(values(&city().0, &links[2..])[0] == first[2]);
        assert_ne!(first[0], first[1]);
        let groups = links.map(|link| ways.group(&link));
        assert!(groups[0] == groups[1] && groups[0] != groups[2]);
    }

    #[test]
    fn mirror_images_have_the_directions_in_another_order_and_share_the_transmitter() {
        let (ways, places) = city();
        let link = Link {
            map: 0,
            tx_m: places[0],
            rx_m: places[1],
        };
        let upright = &values(&ways, &[link])[0];
        let PolarShape {
            directions,
            ways: kinds,
            features,
            ..
        } = shape();
        for (image, mirror) in polar::Mirror::ALL.into_iter().enumerate() {
            let mirrored = link.mirrored(image, 1, [255.0; 2]);
            assert_eq!(ways.group(&mirrored), ways.group(&link));
            let found = &values(&ways, &[mirrored])[0];
            for (direction, found) in found.iter().enumerate() {
                let upright = &upright[mirror.direction(direction, directions)];
                for (at, (found, upright)) in found.iter().zip(upright).enumerate() {
                    // Angles beside a ray, and the bearing's sine, change signs.
                    let is_signed =
                        at == kinds * features + 1 || at < kinds * features && at % features == 2;
                    let upright = if is_signed { upright.abs() } else { *upright };
                    let found = if is_signed { found.abs() } else { *found };
                    assert_eq!(found, upright, "image {image}, direction {direction}, {at}");
                }
            }
        }
        let nowhere = Link { map: 4, ..link };
        assert!(matches!(
            ways.batch(&[nowhere]),
            Err(aps_model::Error::Condition(_))
        ));
        let inside = Link {
            rx_m: [f64::NAN; 2],
            ..link
        };
        assert!(matches!(
            ways.batch(&[inside]),
            Err(aps_model::Error::Input(_))
        ));
    }

    /// A path from a ray's direction alone makes the label that the model's array makes of it.
    #[test]
    fn the_array_of_a_model_is_that_of_the_labels() {
        let (label, fan) = (LabelConfig::paper(), Fan::default());
        let labeler = Labeler::new(&label).unwrap();
        let angles = labeler.angles_deg().iter().copied();
        let statistics = MeanStd {
            mean: 0.1,
            std: 0.2,
        };
        let facts = label_facts(&label, angles, Protocol::Paper, statistics);
        assert!(!facts.is_by_link && facts.array.len() == 180 * fan.directions);
        for direction in [0, 17, 64, 101, 179] {
            let path = PathSample {
                delay_s: 3e-7,
                arrival_azimuth_rad: fan.angle_rad(direction),
                gain_db: -80.0,
            };
            let mut power = labeler.label(&[path]).unwrap().unwrap().aps_db;
            aps_label::relative_power(&mut power).unwrap();
            let column = |bin: usize| facts.array[bin * fan.directions + direction];
            let top = (0..180).map(column).fold(0.0, f64::max);
            for (bin, power) in power.iter().enumerate() {
                let (found, power) = (column(bin) / top, *power);
                // Labels end at a floor.
                assert!(
                    (found - power).abs() < 1e-6,
                    "{direction}, {bin}: {found}, {power}"
                );
            }
        }
    }
}
