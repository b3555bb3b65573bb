//! The input of Polar-Reg: fields of the geometry, made of the scenes when they are asked for.

mod cache;

use std::sync::Arc;

use aps_label::{LabelConfig, MeanStd, Protocol};
use aps_model::candle_core::{Device, Tensor};
use aps_model::condition::{InputShape, Link, Mirror, ModelInput, PolarShape};
use aps_model::{LabelFacts, Result as ModelResult};
use aps_raytrace::Scene;
use aps_raytrace::fields::{
    self, Fan, FieldConfig, FieldError, FieldGrid, FieldLink, FieldMap, ReceiverRays,
    TransmitterFields,
};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;
use rayon::prelude::*;

use self::cache::{Cache, Cell, Key};
use crate::error::{At, Error, Place, Result};

/// Memory for the fields of transmitters, beside those of the batches under way \[bytes\].
const TRANSMITTER_BYTES: usize = 256 << 20;

/// Memory for the rays of receivers likewise.
const RECEIVER_BYTES: usize = 256 << 20;

/// Side of the pixels of a transmitter's fields \[m\].
const PIXEL_M: f64 = 1.0;

/// Bytes of a receiver's rays a position.
const POSITION_BYTES: usize = 13;

/// Bytes of a transmitter's fields a pixel.
const PIXEL_BYTES: usize = 6;

/// Shape of the fields of a link.
pub(super) fn shape() -> PolarShape {
    let Fan {
        directions,
        ranges_m,
        ..
    } = Fan::default();
    PolarShape {
        planes: fields::PLANES,
        numbers: fields::NUMBERS,
        ranges: ranges_m.len(),
        directions,
    }
}

/// What a model is told of labels: the response of the array in each of the bins, and the statistics by which the protocol
/// normalises.
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

/// Makes the fields of links on some maps, as they are and in their mirror images: number `image * maps + map` is a map in an
/// image of [`Mirror::ALL`].
///
/// Fields of transmitters and rays of receivers are made once for all links that follow soon, on all threads, and are bounded in
/// memory. No field is made for a mirror image: it has the same numbers in another order.
#[derive(Debug)]
pub(super) struct PolarFields {
    maps: Vec<Arc<FieldMap<'static>>>,
    /// Position that changes places with 0 in a mirror image \[m\].
    far_end_m: [f64; 2],
    transmitters: Cache<TransmitterFields>,
    receivers: Cache<ReceiverRays>,
    device: Device,
}

/// A link with everything it is made of.
struct Ready {
    map: usize,
    transmitter: Cell<TransmitterFields>,
    receiver: Cell<ReceiverRays>,
    ends: [DVec2; 2],
    mirror: fields::Mirror,
}

/// Prepares scenes, which are named by the ids of their maps. Work on all threads, one scene after another.
pub(super) fn field_maps(
    scenes: impl Iterator<Item = Result<(u32, Scene)>>,
) -> Result<Vec<Arc<FieldMap<'static>>>> {
    let prepare = |scene: Result<(u32, Scene)>| {
        let (id, scene) = scene?;
        let area = scene.area().unwrap_or(Area::RADIOMAPSEER);
        let config = FieldConfig {
            grid: FieldGrid::over(area, PIXEL_M),
            fan: Fan::default(),
        };
        let map = FieldMap::owning(scene, config).at(Place::Map(id))?;
        Ok(Arc::new(map))
    };
    scenes.map(prepare).collect()
}

impl PolarFields {
    /// Makes fields on maps that mirror images change about half of `far_end_m`.
    pub fn new(maps: Vec<Arc<FieldMap<'static>>>, far_end_m: [f64; 2], device: Device) -> Self {
        let pixels = maps.iter().map(|map| map.grid().pixels()).max();
        let of_transmitter = PIXEL_BYTES * pixels.unwrap_or(0);
        let of_receiver = POSITION_BYTES * Fan::default().positions();
        Self {
            maps,
            far_end_m,
            transmitters: Cache::new(TRANSMITTER_BYTES, of_transmitter),
            receivers: Cache::new(RECEIVER_BYTES, of_receiver),
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

    /// Makes everything that the fields of links are looked up in.
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
                mirror: fields::Mirror {
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
    /// Writes the fields of the link.
    fn write(&self, maps: &[Arc<FieldMap<'static>>], out: &mut [f32]) -> Result<(), FieldError> {
        let map = &maps[self.map];
        let made = "everything is made before it is looked up";
        let link = FieldLink {
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
        let (planes, numbers) = out.split_at_mut(fields::PLANES * map.fan().positions());
        link.write(planes, numbers)
    }
}

impl ModelInput for PolarFields {
    fn batch(&self, links: &[Link]) -> ModelResult<Tensor> {
        let (ready, shape) = (self.ready(links)?, shape());
        let mut values = vec![0.0; links.len() * shape.values()];
        values
            .par_chunks_mut(shape.values())
            .zip(&ready)
            .try_for_each(|(values, link)| link.write(&self.maps, values))
            .map_err(|error| aps_model::Error::Input(error.into()))?;
        let shape = (links.len(), shape.rows(), shape.directions);
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

impl From<FieldError> for Error {
    fn from(error: FieldError) -> Self {
        Self::Model(aps_model::Error::Input(error.into()))
    }
}

#[cfg(test)]
mod tests {
    use aps_label::{Labeler, PathSample};
    use aps_raytrace::scene::{CityConfig, Location};

    use super::*;

    fn city() -> (PolarFields, Vec<[f64; 2]>) {
        let scene = Scene::synthetic(&CityConfig::default()).unwrap();
        let places = (0..).map(|i: u32| [f64::from(i * 37 % 250), f64::from(i * 91 % 250)]);
        let is_outdoor = |&p: &[f64; 2]| scene.locate(DVec2::from(p)) == Location::Outdoor;
        let places = places.filter(is_outdoor).take(6).collect();
        let maps = field_maps([Ok((0, scene))].into_iter()).unwrap();
        (PolarFields::new(maps, [255.0; 2], Device::Cpu), places)
    }

    fn rows(fields: &PolarFields, links: &[Link]) -> Vec<Vec<Vec<f32>>> {
        fields.batch(links).unwrap().to_vec3().unwrap()
    }

    /// Whatever was asked for before, and in whatever company: the same bits.
    #[test]
    fn fields_of_a_link_do_not_depend_on_what_was_made_before() {
        let (fields, places) = city();
        let link = |tx: usize, rx: usize| Link {
            map: 0,
            tx_m: places[tx],
            rx_m: places[rx],
        };
        let links = [link(0, 1), link(0, 2), link(3, 1)];
        let first = rows(&fields, &links);
        fields.prepare(&[link(4, 5)]).unwrap();
        assert!(rows(&fields, &links) == first);
        assert!(rows(&city().0, &links[2..])[0] == first[2]);
        assert_ne!(first[0], first[1]);
        let groups = links.map(|link| fields.group(&link));
        assert!(groups[0] == groups[1] && groups[0] != groups[2]);
    }

    #[test]
    fn mirror_images_have_the_directions_in_another_order_and_share_the_transmitter() {
        let (fields, places) = city();
        let link = Link {
            map: 0,
            tx_m: places[0],
            rx_m: places[1],
        };
        let upright = &rows(&fields, &[link])[0];
        let PolarShape {
            planes,
            ranges,
            directions,
            ..
        } = shape();
        for (image, mirror) in fields::Mirror::ALL.into_iter().enumerate() {
            let mirrored = link.mirrored(image, 1, [255.0; 2]);
            assert_eq!(fields.group(&mirrored), fields.group(&link));
            let found = &rows(&fields, &[mirrored])[0];
            for (row, found) in found[..planes * ranges].iter().enumerate() {
                let turned = (0..directions).map(|d| upright[row][mirror.direction(d, directions)]);
                assert!(turned.eq(found.iter().copied()), "image {image}, row {row}");
            }
        }
        let nowhere = Link { map: 4, ..link };
        assert!(matches!(
            fields.batch(&[nowhere]),
            Err(aps_model::Error::Condition(_))
        ));
        let inside = Link {
            rx_m: [f64::NAN; 2],
            ..link
        };
        assert!(matches!(
            fields.batch(&[inside]),
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
