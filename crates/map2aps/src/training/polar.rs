//! The input of Polar-Reg as a tensor, and what it is told of labels.

use std::sync::OnceLock;

use aps_label::{LabelConfig, MeanStd, Protocol};
use aps_model::candle_core::{Device, Tensor};
use aps_model::condition::{InputShape, Link, ModelInput, PolarShape};
use aps_model::{LabelFacts, Result as ModelResult};
use aps_raytrace::polar;

use super::held_ways::HeldWays;
use crate::error::Result;
use crate::polar::{PolarViews, SeenLink, padded};

/// Shape of the ways of a link.
pub(super) fn shape() -> PolarShape {
    let fan = PolarViews::fan();
    PolarShape {
        directions: fan.directions,
        kinds: fan.way_kinds(),
        features: polar::FEATURES,
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
    LabelFacts {
        array: PolarViews::array_response(&label.array, angles_deg),
        mean: statistics.mean,
        deviation: statistics.std,
        is_by_link: protocol == Protocol::Released,
    }
}

/// Finds the ways of links on the CPU: see [`PolarShape`].
pub(super) fn ways(views: &PolarViews, links: &[SeenLink]) -> Result<Tensor> {
    let (values, shape) = padded(&views.ways(links)?);
    let ways = Tensor::from_vec(values, &shape, &Device::Cpu);
    Ok(ways.map_err(aps_model::Error::from)?)
}

/// Finds the ways of links on some maps, as they are and in their mirror images: number `image * maps + map` is a map in an
/// image of [`polar::Mirror::ALL`].
#[derive(Debug)]
pub(super) struct PolarWays {
    views: PolarViews,
    /// Position that changes places with 0 in a mirror image \[m\].
    far_end_m: [f64; 2],
    device: Device,
    /// Ways that lie on the device.
    held: OnceLock<HeldWays>,
}

impl PolarWays {
    /// Finds ways on maps that mirror images change about half of `far_end_m`.
    pub fn new(views: PolarViews, far_end_m: [f64; 2], device: Device) -> Self {
        Self {
            views,
            far_end_m,
            device,
            held: OnceLock::new(),
        }
    }

    /// The link that a link is the mirror image of, and the image.
    fn upright(&self, link: &Link) -> Option<SeenLink> {
        let (map, maps) = (link.map as usize, self.views.maps());
        let mirror = *polar::Mirror::ALL.get(map.checked_div(maps)?)?;
        // Its own inverse, and exact for whole metres.
        let upright = link.mirrored(map / maps, 0, self.far_end_m);
        Some(SeenLink {
            map: map % maps,
            tx_m: upright.tx_m,
            rx_m: upright.rx_m,
            mirror,
        })
    }

    fn known(&self, link: &Link) -> ModelResult<SeenLink> {
        self.upright(link).ok_or_else(|| {
            let maps = self.views.maps();
            aps_model::Error::Condition(format!(
                "{link:?} is on none of the {maps} maps and their mirror images"
            ))
        })
    }

    fn all_known(&self, links: &[Link]) -> ModelResult<Vec<SeenLink>> {
        links.iter().map(|link| self.known(link)).collect()
    }
}

impl ModelInput for PolarWays {
    fn batch(&self, links: &[Link]) -> ModelResult<Tensor> {
        let links = self.all_known(links)?;
        if let Some(held) = self.held.get().and_then(|held| held.batch(&links)) {
            return Ok(held?);
        }
        let ways = ways(&self.views, &links);
        ways.map_err(|error| aps_model::Error::Input(error.into()))
    }

    fn prepare(&self, links: &[Link]) -> ModelResult<()> {
        let links = self.all_known(links)?;
        if !self.held.get().is_some_and(|held| held.has(&links)) {
            self.views.prepare(&links);
        }
        Ok(())
    }

    fn hold(&self, links: &mut dyn Iterator<Item = Link>) -> ModelResult<bool> {
        let links = links.map(|link| self.known(&link));
        let held = HeldWays::new(&self.views, links, &self.device)?;
        Ok(held.is_some_and(|held| self.held.set(held).is_ok()))
    }

    fn group(&self, link: &Link) -> Option<u64> {
        let link = self.upright(link)?;
        let words = [
            link.map as u64,
            link.rx_m[0].to_bits(),
            link.rx_m[1].to_bits(),
        ];
        // Two receivers of one number would only be taken together.
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
}

#[cfg(test)]
mod tests {
    use aps_label::{Labeler, PathSample};
    use aps_raytrace::Scene;
    use aps_raytrace::glam::DVec2;
    use aps_raytrace::scene::{CityConfig, Location};

    use super::*;

    fn city() -> (PolarWays, Vec<[f64; 2]>) {
        let scene = Scene::synthetic(&CityConfig::default()).unwrap();
        let places = (0..).map(|i: u32| [f64::from(i * 37 % 250), f64::from(i * 91 % 250)]);
        let is_outdoor = |&p: &[f64; 2]| scene.locate(DVec2::from(p)) == Location::Outdoor;
        let places = places.filter(is_outdoor).take(3).collect();
        let views = PolarViews::new([Ok((0, scene))].into_iter()).unwrap();
        (PolarWays::new(views, [255.0; 2], Device::Cpu), places)
    }

    /// Ways by link and direction: features, and kind.
    fn by_direction(ways: &PolarWays, links: &[Link]) -> Vec<Vec<Vec<f32>>> {
        let shape = shape();
        let batch = ways.batch(links).unwrap().to_vec3::<f32>().unwrap();
        let of_link = |ways: Vec<Vec<f32>>| {
            let mut all = vec![Vec::new(); shape.directions];
            for mut way in ways.into_iter().filter(|way| way[1] != 0.0) {
                let direction = way.remove(shape.features);
                all[direction as usize].extend(way);
            }
            all
        };
        batch.into_iter().map(of_link).collect()
    }

    #[test]
    fn ways_held_on_a_device_are_those_of_the_host_in_every_image() {
        let (host, places) = city();
        let (device, _) = city();
        let link = |tx: usize, rx: usize| Link {
            map: 0,
            tx_m: places[tx],
            rx_m: places[rx],
        };
        let images = |link: Link| (0..4).map(move |image| link.mirrored(image, 1, [255.0; 2]));
        // Between whole metres, where mirroring twice rounds.
        let between = Link {
            tx_m: places[2].map(|x| x + 0.1),
            ..link(2, 1)
        };
        let held: Vec<Link> = [link(0, 1), between].into_iter().flat_map(images).collect();
        assert!(device.hold(&mut held.iter().copied()).unwrap());
        assert_eq!(device.held.get().unwrap().links(), 2);
        let (found, expected) = (by_direction(&device, &held), by_direction(&host, &held));
        let mut count = 0;
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                let bound = expected.abs() / 2048.0 + 1e-6;
                assert!((found - expected).abs() <= bound, "{found} for {expected}");
                count += usize::from(*expected == 1.0);
            }
        }
        assert!(count > 8 * 20, "{count} ways");
        // Each link in a block of its own.
        let links = device.all_known(&held).unwrap();
        let known = links.iter().copied().map(Ok);
        let apart = HeldWays::in_blocks(&host.views, known, &Device::Cpu, 1)
            .unwrap()
            .unwrap();
        let lists = |held: &HeldWays| {
            held.batch(&links)
                .unwrap()
                .unwrap()
                .to_vec3::<f32>()
                .unwrap()
        };
        assert_eq!(lists(&apart), lists(device.held.get().unwrap()));
        // Others come from the host.
        let others = [held[0], link(0, 2)];
        assert!(
            !device
                .held
                .get()
                .unwrap()
                .has(&device.all_known(&others).unwrap())
        );
        assert_eq!(by_direction(&device, &others), by_direction(&host, &others));
        // What cannot be found is told, not left out.
        let inside = Link {
            rx_m: [f64::NAN; 2],
            ..held[0]
        };
        let refused = city().0.hold(&mut [held[0], inside].into_iter());
        assert!(
            matches!(refused, Err(aps_model::Error::Input(_))),
            "{refused:?}"
        );
    }

    #[test]
    fn mirror_images_have_the_directions_in_another_order_and_share_the_receiver() {
        let (ways, places) = city();
        let link = Link {
            map: 0,
            tx_m: places[0],
            rx_m: places[1],
        };
        let upright = &by_direction(&ways, &[link])[0];
        let PolarShape {
            directions,
            features,
            ..
        } = shape();
        for (image, mirror) in polar::Mirror::ALL.into_iter().enumerate() {
            let mirrored = link.mirrored(image, 1, [255.0; 2]);
            assert_eq!(ways.group(&mirrored), ways.group(&link));
            let found = &by_direction(&ways, &[mirrored])[0];
            for (direction, found) in found.iter().enumerate() {
                let upright = &upright[mirror.direction(direction, directions)];
                assert_eq!(found.len(), upright.len());
                for (at, (found, upright)) in found.iter().zip(upright).enumerate() {
                    // Angles beside a ray change signs.
                    let is_signed = at % (features + 1) == 2;
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
        let (label, fan) = (LabelConfig::paper(), PolarViews::fan());
        let labeler = Labeler::new(&label).unwrap();
        let angles = labeler.angles_deg().iter().copied();
        let statistics = MeanStd {
            mean: 0.1,
            std: 0.2,
        };
        let facts = label_facts(&label, angles, Protocol::Paper, statistics);
        assert!(!facts.is_by_link && facts.array.len() == 180 * fan.directions);
        for direction in [0, 68, 257, 405, 719] {
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
