//! Examples with their mirror images: four for each.

use super::Examples;
use crate::condition::{Link, MIRROR_IMAGES, Rasters, is_mirrored};
use crate::{ANGLE_BINS, Error, Result};

/// Examples with their mirror images: number 4 n + i is example n in image i of [`MIRROR_IMAGES`].
///
/// In a scene mirrored along an axis every path is mirrored too, so that the spectrum of the link follows without tracing. A
/// linear array on the y axis sees only the sine of an angle: mirroring x leaves its spectra as they are, mirroring y turns
/// theta into -theta, which puts the bins in another order.
///
/// ```
/// use aps_model::condition::{ConditionConfig, ConditionImages, Link, ModelInput, Rasters};
/// use aps_model::data::{Examples, Mirrored, Samples};
/// # use aps_model::{ANGLE_BINS, candle_core::Device};
/// let rasters = Rasters { pixels: &[0.0; 256], height: 16, width: 16, metres_per_pixel: 1.0 };
/// let link = Link { map: 0, tx_m: [2.0, 3.0], rx_m: [9.0, 9.0] };
/// let samples = Samples::new(vec![link], vec![0.0; ANGLE_BINS])?;
/// let negated = (0..ANGLE_BINS).rev().collect(); // of a grid with both -180 and 180 degrees
/// let examples = Mirrored::new(samples, rasters, negated)?;
/// assert_eq!((examples.len(), examples.link(3).tx_m), (4, [13.0, 12.0]));
///
/// let pixels = rasters.mirrored();
/// let config = ConditionConfig { image_size: 8, ..ConditionConfig::default() };
/// let images = ConditionImages::new(Rasters { pixels: &pixels, ..rasters }, config, &Device::Cpu)?;
/// let links: Vec<Link> = (0..4).map(|e| examples.link(e)).collect();
/// assert_eq!(images.batch(&links)?.dims(), [4, 3, 8, 8]);
/// # Ok::<(), aps_model::Error>(())
/// ```
#[derive(Debug)]
pub struct Mirrored<E> {
    examples: E,
    maps: usize,
    far_end_m: [f64; 2],
    negated: Vec<usize>,
}

impl<E: Examples> Mirrored<E> {
    /// Mirror images of `examples` on the maps of `rasters`; their input must be made of
    /// [`Rasters::mirrored`]. `negated` is for each bin the one at the negative of its angle.
    ///
    /// # Errors
    /// [`Error::Samples`] when `negated` does not name each of the [`ANGLE_BINS`] bins once, or there are too many maps.
    pub fn new(examples: E, rasters: Rasters<'_>, negated: Vec<usize>) -> Result<Self> {
        let mut named = [false; ANGLE_BINS];
        for &bin in negated.iter().filter(|&&bin| bin < ANGLE_BINS) {
            named[bin] = true;
        }
        if negated.len() != ANGLE_BINS || named.contains(&false) {
            let text = format!("bins at negative angles must name each of {ANGLE_BINS} bins once");
            return Err(Error::Samples(format!("{text}, not {negated:?}")));
        }
        let maps = rasters.maps();
        if u32::try_from(maps.saturating_mul(MIRROR_IMAGES)).is_err() {
            let text = format!("{maps} maps are too many to be mirrored");
            return Err(Error::Samples(text));
        }
        Ok(Self {
            examples,
            maps,
            far_end_m: rasters.far_end_m(),
            negated,
        })
    }
}

impl<E: Examples> Examples for Mirrored<E> {
    fn len(&self) -> usize {
        self.examples.len() * MIRROR_IMAGES
    }

    fn link(&self, example: usize) -> Link {
        let (original, image) = (example / MIRROR_IMAGES, example % MIRROR_IMAGES);
        let link = self.examples.link(original);
        link.mirrored(image, self.maps, self.far_end_m)
    }

    fn write_target(&self, example: usize, target: &mut [f32]) {
        let (original, image) = (example / MIRROR_IMAGES, example % MIRROR_IMAGES);
        self.examples.write_target(original, target);
        if is_mirrored(image, 1) {
            let mut upright = [0.0; ANGLE_BINS];
            upright.copy_from_slice(target);
            for (value, &bin) in target.iter_mut().zip(&self.negated) {
                *value = upright[bin];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Samples;
    use super::*;

    fn negated() -> Vec<usize> {
        (0..ANGLE_BINS).rev().collect()
    }

    #[test]
    fn each_example_comes_as_it_is_and_in_three_images() {
        let link = |map, tx_m, rx_m| Link { map, tx_m, rx_m };
        let links = vec![
            link(0, [1.0, 2.0], [3.0, 0.5]),
            link(1, [0.0, 0.0], [7.0, 3.0]),
        ];
        let targets: Vec<f32> = (0..2 * ANGLE_BINS).map(|i| i as f32).collect();
        let samples = Samples::new(links, targets).unwrap();
        let rasters = Rasters {
            pixels: &[0.0; 2 * 4 * 8],
            height: 4,
            width: 8,
            metres_per_pixel: 1.0,
        };
        let all = Mirrored::new(samples.clone(), rasters, negated()).unwrap();
        assert_eq!(all.len(), 8);
        let found: Vec<Link> = (0..4).map(|e| all.link(e)).collect();
        let expected = [
            link(0, [1.0, 2.0], [3.0, 0.5]),
            link(2, [6.0, 2.0], [4.0, 0.5]),
            link(4, [1.0, 1.0], [3.0, 2.5]),
            link(6, [6.0, 1.0], [4.0, 2.5]),
        ];
        assert_eq!(found, expected);
        assert_eq!(all.link(7).map, 7);
        let target = |example| {
            let mut target = vec![0.0; ANGLE_BINS];
            all.write_target(example, &mut target);
            target
        };
        let (upright, turned) = (target(4), target(6));
        assert_eq!((upright[0], upright[3]), (180.0, 183.0));
        assert_eq!(target(5), upright);
        assert!(upright.iter().eq(turned.iter().rev()));
        assert_eq!(target(7), turned);

        for wrong in [vec![0; ANGLE_BINS], negated()[1..].to_vec(), vec![180; 180]] {
            assert!(Mirrored::new(samples.clone(), rasters, wrong).is_err());
        }
    }
}
