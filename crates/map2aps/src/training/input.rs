//! Examples as models take them: their input on a device, their targets in single precision.

use aps_data::Raster;
use aps_model::candle_core::Device;
use aps_model::condition::{
    ConditionConfig, ConditionImages, InputKind, InputShape, Link, ModelInput, Rasters,
};
use aps_model::{ANGLE_BINS, ModelKind, data};

use super::polar::{self, PolarWays};
use crate::error::Result;
use crate::examples::Examples;
use crate::maps::MapSource;

/// Shape of the input that a model takes.
pub(super) fn shape_for(kind: ModelKind) -> InputShape {
    match kind.input() {
        InputKind::Images => InputShape::Images,
        InputKind::Polar => InputShape::Polar(polar::shape()),
    }
}

impl Examples {
    /// The link of an example, on a map of [`Examples::input`].
    pub fn link(&self, example: usize) -> Link {
        let found = &self.list()[example];
        Link {
            map: self.map_index(example) as u32,
            tx_m: found.tx_m,
            rx_m: found.rx_m,
        }
    }

    /// Links of all examples, on the maps of [`Examples::input`].
    pub fn links(&self) -> impl Iterator<Item = Link> {
        (0..self.list().len()).map(|example| self.link(example))
    }

    /// The target of an example.
    ///
    /// # Panics
    /// When there is no such example, its spectrum has not [`ANGLE_BINS`] bins, or the data set is damaged: its labels were
    /// finite when it was written.
    pub fn target(&self, example: usize) -> [f64; ANGLE_BINS] {
        let mut target = [0.0; ANGLE_BINS];
        let written = self.write_target(example, &mut target);
        written.expect("labels are finite, and the statistics were used before");
        target
    }

    /// Prepares the input of a model for these links. A model that is given the geometry, as
    /// [`PolarReg`](ModelKind::PolarReg), needs the maps that the data set was made from, unless they were synthetic.
    ///
    /// # Errors
    /// An image size that the model does not take, memory that the device does not have, and
    /// [`MapError::NoScene`](crate::MapError::NoScene).
    pub fn input(
        &self,
        kind: ModelKind,
        images: ConditionConfig,
        maps: Option<&MapSource>,
        device: &Device,
    ) -> Result<Box<dyn ModelInput>> {
        let pixels = self.pixels();
        let rasters = self.rasters(&pixels);
        match kind.input() {
            InputKind::Images => {
                let images = ConditionImages::new(rasters, images, device)?;
                Ok(Box::new(images))
            }
            InputKind::Polar => {
                let (views, far_end_m) = (self.polar_views(maps)?, rasters.far_end_m());
                Ok(Box::new(PolarWays::new(views, far_end_m, device.clone())))
            }
        }
    }

    /// The buildings of all maps; shape (maps, height, width).
    pub(super) fn pixels(&self) -> Vec<f32> {
        let of_map = |buildings: &Raster| -> Vec<f32> {
            buildings.pixels().iter().copied().map(f32::from).collect()
        };
        let maps = self.maps.iter();
        maps.flat_map(|map| of_map(&map.buildings.image)).collect()
    }

    /// The buildings as models take them, of [`Examples::pixels`].
    pub(super) fn rasters<'a>(&self, pixels: &'a [f32]) -> Rasters<'a> {
        let first = self.maps.first();
        let grid = first
            .map(|map| map.buildings.image.grid())
            .unwrap_or_default();
        Rasters {
            pixels,
            height: grid.height,
            width: grid.width,
            metres_per_pixel: grid.metres_per_pixel,
        }
    }
}

impl data::Examples for Examples {
    fn len(&self) -> usize {
        self.list().len()
    }

    fn link(&self, example: usize) -> Link {
        self.link(example)
    }

    fn write_target(&self, example: usize, target: &mut [f32]) {
        for (target, value) in target.iter_mut().zip(self.target(example)) {
            *target = value as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use aps_data::{
        Axis, Dataset, DatasetConfig, DatasetWriter, Layout, LinkRows, LinkStatus, Links, MapInput,
        Part, Precision, ProfileLayout, ProfileRows, Raster, RasterGrid, Split,
    };
    use serde_json::json;

    use super::*;
    use crate::maps::MapError;
    use crate::targets::{self, Target};

    /// Two maps of 3 x 3 links, one of each without a label, with values that take all digits a precision has.
    fn dataset(dtype: Precision, protocol: &str) -> (tempfile::TempDir, Dataset) {
        let root = tempfile::tempdir().unwrap();
        let aps = ProfileLayout {
            dtype,
            ..ProfileLayout::over(Axis::ANGLE_PAPER_DEG)
        };
        let config = DatasetConfig {
            configuration: json!({ "label": { "protocol": protocol } }),
            layout: Layout {
                aps: Some(aps),
                ..Layout::default()
            },
            ..DatasetConfig::default()
        };
        let writer = DatasetWriter::open(root.path(), config).unwrap();
        let buildings = Raster::empty(RasterGrid::default()).unwrap();
        let at = [[10.0, 20.0], [30.0, 5.0], [90.5, 90.0]];
        for id in 0..2 {
            let input = MapInput {
                buildings: &buildings,
                tx_m: &at,
                rx_m: &at,
                links: Links::Grid,
            };
            let mut map = writer.begin_map(id, &input).unwrap();
            let value = |i: usize| -90.0 - 40.0 * (f64::from(id) + (i as f64 * 0.7).sin()).abs();
            let db: Vec<f64> = (0..9 * ANGLE_BINS).map(value).collect();
            let mut status = [LinkStatus::Valid; 9];
            status[4] = LinkStatus::NoPath;
            let aps = ProfileRows {
                db: &db,
                argmax: None,
            };
            map.push(&LinkRows {
                status: &status,
                aps: Some(aps),
                ..LinkRows::default()
            })
            .unwrap();
            map.finish().unwrap();
        }
        let split = Split {
            train: vec![0],
            develop: vec![],
            test: vec![1],
        };
        writer.finish(&split).unwrap();
        let dataset = Dataset::open(root.path()).unwrap();
        (root, dataset)
    }

    #[test]
    fn a_model_of_geometry_asks_for_the_maps() {
        let (_root, dataset) = dataset(Precision::F16, "paper");
        let examples = Examples::of_maps(&dataset, &[0, 1], Target::Linear, None).unwrap();
        // Without its own image there is nothing to hold given maps to.
        for maps in [None, Some(&MapSource::Synthetic { count: 2 })] {
            let asked = examples.input(
                ModelKind::PolarReg,
                ConditionConfig::default(),
                maps,
                &Device::Cpu,
            );
            let error = asked.unwrap_err();
            let cause = error.cause();
            assert!(
                matches!(cause, crate::Error::Map(MapError::NoImage(0))),
                "{cause:?}"
            );
        }
    }

    /// Whatever a data set stores, a model learns what it is scored against.
    #[test]
    fn targets_learnt_and_scored_have_the_same_bits() {
        for dtype in [Precision::F16, Precision::F32] {
            for protocol in ["paper", "released"] {
                let (_root, dataset) = dataset(dtype, protocol);
                let (_, _, target) = targets::learning_target(&dataset).unwrap();
                let Target::Normalised(normalization) = target else {
                    panic!("a learning target is normalised");
                };
                let labels = Examples::of_maps(&dataset, &[1], target, None).unwrap();
                let mut scored = Vec::new();
                let found =
                    targets::for_each_block(&dataset, Part::Test, target, 3, |rows, map| {
                        assert_eq!(map, 1);
                        scored.extend_from_slice(rows);
                        Ok(())
                    });
                assert_eq!((found.unwrap(), labels.list().len()), (8, 8));
                let map = dataset.map(1).unwrap();
                for (link, expected) in scored.chunks(ANGLE_BINS).enumerate() {
                    let learnt = labels.target(link);
                    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect();
                    let (learnt, expected): (Vec<u64>, Vec<u64>) = (bits(&learnt), bits(expected));
                    assert_eq!(learnt, expected, "{dtype:?}, {protocol}, link {link}");
                    // By the shortest way there is.
                    let mut stored = [0.0_f32; ANGLE_BINS];
                    let row = labels.list()[link].link;
                    targets::spectra(&map).read_relative_db(row, &mut stored);
                    let mut own = stored.map(f64::from);
                    normalization.apply(&mut own).unwrap();
                    assert_eq!(bits(&own), learnt, "{dtype:?}, {protocol}, link {link}");
                    // A network's tensors are in single precision.
                    let mut single = [0.0_f32; ANGLE_BINS];
                    data::Examples::write_target(&labels, link, &mut single);
                    assert!(single.iter().zip(own).all(|(&s, x)| s == x as f32));
                }
            }
        }
    }
}
