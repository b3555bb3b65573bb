//! Examples drawn in batches, for networks of other programs.

use std::sync::Arc;

use aps_data::{Dataset, Part};
use aps_raytrace::polar::Mirror;
use rayon::prelude::*;

use crate::error::Result;
use crate::examples::{Example, Examples};
use crate::maps::MapSource;
use crate::mirror::negated_bins;
use crate::polar::{PolarViews, SeenLink};
use crate::scores::Domain;

/// The examples of a part of a data set, drawn as condition images of any size, or as the ways that Polar-Reg is given, with their
/// targets; alone or with their mirror images: number 4 n + i is then example n in image i of [`Mirror::ALL`], the
/// numbers of `aps_model::data::Mirrored`.
#[derive(Debug, Clone)]
pub struct DrawnExamples {
    examples: Examples,
    /// For each bin the one at the negative of its angle, where there are mirror images.
    negated: Option<Vec<usize>>,
    /// Finder of ways, which stand in place of images.
    views: Option<Arc<PolarViews>>,
}

impl DrawnExamples {
    /// Opens the examples of a part, to be drawn with so many rows and columns; labels stay on disk until they are asked for.
    ///
    /// # Errors
    /// As [`Examples::open`]; with `is_mirrored`, a data set whose spectra are not those of a linear array over symmetric
    /// angles.
    pub fn open(
        dataset: &Dataset,
        part: Part,
        domain: Domain,
        image_size: usize,
        is_mirrored: bool,
    ) -> Result<Self> {
        let manifest = dataset.manifest();
        let axis = dataset.aps_layout()?.axis;
        let negated = is_mirrored.then(|| negated_bins(&manifest.configuration, axis));
        let examples = Examples::open(dataset, part, domain)?;
        Ok(Self {
            negated: negated.transpose()?,
            examples: examples.with_image_size(image_size),
            views: None,
        })
    }

    /// Puts the ways of [`PolarViews`] in place of images. The maps that the data set was made from must be
    /// given, unless they are synthetic.
    ///
    /// # Errors
    /// [`MapError::NoScene`](crate::MapError::NoScene), [`MapError::NoImage`](crate::MapError::NoImage) and
    /// [`MapError::OtherBuildings`](crate::MapError::OtherBuildings); maps that cannot be read.
    pub fn with_ways(self, maps: Option<&MapSource>) -> Result<Self> {
        let views = Some(Arc::new(self.examples.polar_views(maps)?));
        Ok(Self { views, ..self })
    }

    /// Shape of an image, (planes, rows, columns); `None` if there are ways in place of images.
    pub fn image_shape(&self) -> Option<[usize; 3]> {
        let [rows, columns] = self.examples.image_shape();
        self.views.is_none().then_some([3, rows, columns])
    }

    /// The examples.
    pub fn examples(&self) -> &Examples {
        &self.examples
    }

    /// Number of examples, mirror images included.
    pub fn len(&self) -> usize {
        self.images() * self.examples.list().len()
    }

    /// Tells if there is no example.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn images(&self) -> usize {
        self.negated.as_ref().map_or(1, |_| Mirror::ALL.len())
    }

    /// Draws images on all threads: `images` takes each in [its shape](Self::image_shape).
    ///
    /// # Panics
    /// When there is no such example, or the slice has another length.
    pub fn write_images(&self, numbers: &[usize], images: &mut [f32]) {
        let length = self.examples.image_len();
        assert_eq!(images.len(), numbers.len() * length, "an image for each");
        let images = images.par_chunks_mut(length.max(1)).zip(numbers);
        images.for_each(|(image, &number)| self.draw(number, image));
    }

    /// Finds the ways of links on all threads; `None` if there are images in their place. [`padded`](crate::padded) makes one array of
    /// them.
    ///
    /// # Errors
    /// An end of a link that is in a building of its map.
    ///
    /// # Panics
    /// When there is no such example.
    pub fn ways(&self, numbers: &[usize]) -> Option<Result<Vec<Vec<f32>>>> {
        let links: Vec<SeenLink> = numbers.iter().map(|&n| self.seen(n)).collect();
        self.views.as_ref().map(|views| views.ways(&links))
    }

    /// Makes targets on all threads, (numbers, bins).
    ///
    /// # Errors
    /// A label that cannot be read or normalised.
    ///
    /// # Panics
    /// When there is no such example, or the slice has another length.
    pub fn write_targets(&self, numbers: &[usize], targets: &mut [f32]) -> Result<()> {
        let bins = self.examples.bins();
        assert_eq!(targets.len(), numbers.len() * bins, "a target for each");
        // Once, by all threads, before each asks for it.
        self.examples.form()?;
        let targets = targets.par_chunks_mut(bins).zip(numbers);
        targets.try_for_each_init(
            || vec![0.0; bins],
            |upright, (target, &number)| self.write_target(number, target, upright),
        )
    }

    /// The example of a number, and the axes along which it is mirrored.
    fn of(&self, number: usize) -> (usize, Mirror) {
        let images = self.images();
        (number / images, Mirror::ALL[number % images])
    }

    fn seen(&self, number: usize) -> SeenLink {
        let (example, mirror) = self.of(number);
        let Example { tx_m, rx_m, .. } = self.examples.list()[example];
        SeenLink {
            map: self.examples.map_index(example),
            tx_m,
            rx_m,
            mirror,
        }
    }

    fn draw(&self, number: usize, image: &mut [f32]) {
        let (example, mirror) = self.of(number);
        self.examples.write_condition(example, image);
        let [rows, columns] = self.examples.image_shape();
        if mirror.x {
            image.chunks_exact_mut(columns).for_each(<[f32]>::reverse);
        }
        if mirror.y {
            image
                .chunks_exact_mut(rows * columns)
                .for_each(|plane| turn_over(plane, columns));
        }
    }

    fn write_target(&self, number: usize, target: &mut [f32], upright: &mut [f64]) -> Result<()> {
        let (example, mirror) = self.of(number);
        self.examples.write_target(example, upright)?;
        let negated = self.negated.as_ref().filter(|_| mirror.y);
        for (bin, value) in target.iter_mut().enumerate() {
            let of = negated.map_or(bin, |negated| negated[bin]);
            *value = upright[of] as f32;
        }
        Ok(())
    }
}

/// Puts the rows of a plane in the opposite order.
fn turn_over(plane: &mut [f32], columns: usize) {
    let half = plane.len() / columns / 2 * columns;
    let (top, rest) = plane.split_at_mut(half);
    let bottom = rest.chunks_exact_mut(columns).rev();
    let pairs = top.chunks_exact_mut(columns).zip(bottom);
    pairs.for_each(|(a, b)| a.swap_with_slice(b));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    fn dataset(root: &tempfile::TempDir) -> Dataset {
        synthetic::made(&synthetic::plan(3, 2, 5), root.path(), &[0, 1, 2])
    }

    fn drawn(examples: &DrawnExamples, numbers: &[usize]) -> (Vec<f32>, Vec<f32>) {
        let mut images = vec![0.0; numbers.len() * examples.examples().image_len()];
        let mut targets = vec![0.0; numbers.len() * 180];
        examples.write_images(numbers, &mut images);
        examples.write_targets(numbers, &mut targets).unwrap();
        (images, targets)
    }

    #[test]
    fn mirrored_examples_are_the_others_turned_over() {
        let root = tempfile::tempdir().unwrap();
        let dataset = dataset(&root);
        let open = |mirrored| {
            DrawnExamples::open(&dataset, Part::Train, Domain::Normalised, 33, mirrored).unwrap()
        };
        let (plain, mirrored) = (open(false), open(true));
        assert_eq!(mirrored.len(), 4 * plain.len());
        let (image, target) = drawn(&plain, &[3]);
        assert_eq!(
            target,
            plain.examples().targets().unwrap()[3 * 180..4 * 180]
        );
        let (images, targets) = drawn(&mirrored, &[12, 13, 14, 15]);
        let pixel = |plane: usize, y: usize, x: usize| image[(plane * 33 + y) * 33 + x];
        for (i, found) in images.chunks_exact(3 * 33 * 33).enumerate() {
            for (place, &value) in found.iter().enumerate() {
                let (plane, y, x) = (place / 33 / 33, place / 33 % 33, place % 33);
                let x = if i % 2 == 1 { 32 - x } else { x };
                let y = if i / 2 == 1 { 32 - y } else { y };
                assert_eq!(value, pixel(plane, y, x));
            }
        }
        // The released axis holds both -180 and 180 degrees, so that negating an angle is reading backwards.
        let backwards: Vec<f32> = target.iter().rev().copied().collect();
        for (i, found) in targets.chunks_exact(180).enumerate() {
            let expected = if i / 2 == 1 { &backwards } else { &target };
            assert_eq!(found, &expected[..], "image {i}");
        }
    }

    #[test]
    fn ways_are_those_of_the_link_in_its_mirror_images() {
        let root = tempfile::tempdir().unwrap();
        let dataset = dataset(&root);
        let open =
            || DrawnExamples::open(&dataset, Part::Train, Domain::Normalised, 8, true).unwrap();
        assert!(open().ways(&[12]).is_none() && open().image_shape() == Some([3, 8, 8]));
        let drawn = open().with_ways(None).unwrap();
        assert_eq!(drawn.image_shape(), None);
        let found = drawn.ways(&[12, 13, 14, 15]).unwrap().unwrap();

        let Example {
            map, tx_m, rx_m, ..
        } = drawn.examples().list()[3];
        let maps = MapSource::Synthetic { count: 3 };
        let scene = maps.load(map, 42, crate::SceneSettings::default());
        let views = PolarViews::new([scene.map(|scene| (map, scene))].into_iter()).unwrap();
        let link = |mirror| SeenLink {
            map: 0,
            tx_m,
            rx_m,
            mirror,
        };
        assert_eq!(found, views.ways(&Mirror::ALL.map(link)).unwrap());
    }

    #[test]
    fn labels_left_on_disk_make_the_targets_of_those_held() {
        let root = tempfile::tempdir().unwrap();
        let dataset = dataset(&root);
        for domain in [Domain::Linear, Domain::Normalised] {
            for part in [Part::Train, Part::Develop, Part::Test] {
                let held = Examples::load(&dataset, part, domain).unwrap();
                let stored = Examples::open(&dataset, part, domain).unwrap();
                assert_eq!(stored.list(), held.list());
                let targets = stored.targets().unwrap().into_iter();
                for (stored, held) in targets.zip(held.targets().unwrap()) {
                    let bound = match domain {
                        Domain::Linear => 0.0,
                        Domain::Normalised => 1e-6 * held.abs().max(1.0),
                    };
                    assert!((stored - held).abs() <= bound, "{stored} {held}");
                }
            }
        }
        let drawn = DrawnExamples::open(&dataset, Part::Train, Domain::Linear, 8, false).unwrap();
        let map = drawn.examples().list()[0].map;
        std::fs::remove_file(root.path().join(format!("map_{map:04}/aps_db.npy"))).unwrap();
        let error = drawn.write_targets(&[0], &mut [0.0; 180]).unwrap_err();
        assert!(error.chain().contains("aps_db.npy"), "{error:?}");
    }
}
