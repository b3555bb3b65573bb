//! Input of the models: condition images, or whatever else a [`ModelInput`] makes. Condition images show a link on its map:
//! buildings, transmitter, receiver.
//!
//! Images are made where they are used. The rasters of all maps lie on the device as one tensor, and of each link there
//! come a map number and four coordinates, not 3 x 256 x 256 pixels. A round Gaussian spot is the product of one along x
//! and one along y, so that an image costs one exponential a row and a column, and one product a pixel.
//!
//! # Sizes
//!
//! An image of any size shows the whole raster, or a window of its size about the receiver ([`Frame`]). Pixel i of W covers \[i, i + 1) / W of the width, so position c, in pixels
//! of the raster (where pixel i stands for position i, its middle), is at (c + 1/2) S / W - 1/2 in an image S pixels wide;
//! heights alike. A pixel of the image is the average of the raster over what it covers, and the spots' deviation shrinks
//! with the image: 20 pixels of a 256-pixel raster are 5 of a 64-pixel image. At the raster's own size images equal those
//! of `aps_data::ConditionImages` bit for bit.

mod area;
mod frame;
mod mirror;
mod shape;

use std::fmt::Debug;

use candle_core::{D, DType, Device, Tensor};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};
pub use frame::Frame;
pub use mirror::MIRROR_IMAGES;
pub(crate) use mirror::is_mirrored;
pub use shape::{InputKind, InputShape, PolarShape};

/// Settings of condition images.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConditionConfig {
    /// Rows and columns of an image \[pixels\]; 256 in the paper.
    pub image_size: usize,
    /// Standard deviation of the spots \[pixels of the raster\]; positive. 20 in the released data.
    pub sigma_px: f64,
    /// Part of the plane that an image shows.
    #[serde(default)]
    pub frame: Frame,
}

impl Default for ConditionConfig {
    fn default() -> Self {
        Self {
            image_size: 256,
            sigma_px: 20.0,
            frame: Frame::Map,
        }
    }
}

/// The buildings of maps, all of one size.
#[derive(Debug, Clone, Copy)]
pub struct Rasters<'a> {
    /// Share of each pixel that is built upon, in \[0, 1\]; shape (maps, height, width), last axis fastest.
    pub pixels: &'a [f32],
    /// Number of rows of a map.
    pub height: usize,
    /// Number of columns of a map.
    pub width: usize,
    /// Distance between neighbouring pixels \[m\]; pixel (x, y) stands for the point (x, y) times this.
    pub metres_per_pixel: f64,
}

/// A transmitter and a receiver on a map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Index of the map among the [`Rasters`].
    pub map: u32,
    /// Position of the transmitter (x, y) \[m\].
    pub tx_m: [f64; 2],
    /// Position of the receiver (x, y) \[m\].
    pub rx_m: [f64; 2],
}

/// Makes the input of a model from links. A model that takes another input than [`ConditionImages`] has an implementation of its
/// own.
pub trait ModelInput: Debug + Send + Sync {
    /// Makes the input of some links: one tensor, links along the first dimension.
    ///
    /// # Errors
    /// [`Error::Condition`] when a link names a map that is not there, or its ends are not finite; [`Error::Input`] of an input
    /// made elsewhere.
    fn batch(&self, links: &[Link]) -> Result<Tensor>;

    /// Begins the input of links that will be asked for soon: called from a thread of its own, while the network computes.
    ///
    /// # Errors
    /// As [`batch`](Self::batch), which finds the same error again.
    fn prepare(&self, links: &[Link]) -> Result<()> {
        let _ = links;
        Ok(())
    }

    /// Moves the data that the input of some links is made of to the device, so that only numbers are sent for batches of them;
    /// `false` where that saves nothing or there is no room for it.
    ///
    /// # Errors
    /// As [`batch`](Self::batch).
    fn hold(&self, links: &mut dyn Iterator<Item = Link>) -> Result<bool> {
        let _ = links;
        Ok(false)
    }

    /// Returns a number that links have in common whose input is made with less work soon after each other, as those of one
    /// receiver; `None` where it makes no difference. Training then takes some of them at a time.
    fn group(&self, link: &Link) -> Option<u64> {
        let _ = link;
        None
    }

    /// Returns the device that the input is for: it is made there, or on the CPU for a model that sends what it needs of it.
    fn device(&self) -> &Device;

    /// Returns the shape of a link's input, which a model must be built for.
    fn shape(&self) -> InputShape {
        InputShape::Images
    }

    /// Returns the rows and columns of an image; 0 for input that is none.
    fn image_size(&self) -> usize {
        0
    }
}

/// Makes condition images (links, 3, size, size) in f32 of any links of some maps. O(size^2) a link, on all threads of a CPU.
///
/// ```
/// use aps_model::candle_core::Device;
/// use aps_model::condition::{ConditionConfig, ConditionImages, Link, ModelInput, Rasters};
/// let open_ground = Rasters { pixels: &[0.0; 256 * 256], height: 256, width: 256, metres_per_pixel: 1.0 };
/// let config = ConditionConfig { image_size: 64, ..ConditionConfig::default() };
/// let images = ConditionImages::new(open_ground, config, &Device::Cpu)?;
/// let link = Link { map: 0, tx_m: [128.0, 10.0], rx_m: [30.0, 40.0] };
/// assert_eq!(images.batch(&[link, link])?.dims(), [2, 3, 64, 64]);
/// # Ok::<(), aps_model::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ConditionImages {
    /// (maps, size, size), on the device.
    buildings: Tensor,
    /// Copy of the buildings on the host, where images are filled in one pass; empty on other devices.
    host: Vec<f32>,
    /// Maps for windows about receivers; none in the frame of the map.
    windows: Option<Windows>,
    maps: usize,
    size: usize,
    along: [Axis; 2],
}

/// Maps that windows about receivers are averaged from.
#[derive(Debug, Clone)]
enum Windows {
    /// Sums over the maps, on the host.
    Sums(frame::Sums),
    /// The maps (maps, height, width), on the device.
    Rasters(Tensor),
}

/// Map from positions along x or y to pixels of an image.
#[derive(Debug, Clone, Copy)]
struct Axis {
    metres_per_pixel: f64,
    /// Pixels of the image a pixel of the raster.
    scale: f64,
    /// -1 / (2 sigma^2), sigma in pixels of the image.
    exponent: f64,
}

impl ConditionImages {
    /// Brings the maps to the image's size and onto the device: maps x size^2 x 4 bytes, 13 MB for 51 maps at 256; in the frame of the
    /// receiver the rasters too.
    ///
    /// # Errors
    /// [`Error::Condition`] when the pixels do not make whole maps or are no shares, or a setting is not positive.
    pub fn new(rasters: Rasters<'_>, config: ConditionConfig, device: &Device) -> Result<Self> {
        let (size, sigma_px) = (config.image_size, config.sigma_px);
        let (pixels, metres_per_pixel) = (rasters.pixels, rasters.metres_per_pixel);
        let (height, width) = (rasters.height, rasters.width);
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let map_len = height.saturating_mul(width);
        if size == 0 || size > MAX_SIZE || !positive(sigma_px) || !positive(metres_per_pixel) {
            return Err(Error::Condition(format!(
                "image size {size}, sigma {sigma_px} px, {metres_per_pixel} m a pixel: the size must be 1 to {MAX_SIZE}, \
                 the others positive"
            )));
        }
        if map_len == 0 || pixels.is_empty() || !pixels.len().is_multiple_of(map_len) {
            return Err(Error::Condition(format!(
                "{} pixels are not one or more maps of {height} x {width}",
                pixels.len()
            )));
        }
        if let Some(i) = pixels.iter().position(|p| !(0.0..=1.0).contains(p)) {
            let (map, value) = (i / map_len, pixels[i]);
            return Err(Error::Condition(format!(
                "a pixel of map {map} is {value}: must be a share from 0 to 1"
            )));
        }
        let maps = pixels.len() / map_len;
        let average = |map: &[f32]| area::average(map, [height, width], size);
        let resized: Vec<f32> = pixels.par_chunks(map_len).flat_map_iter(average).collect();
        let axis = |side: usize| {
            let scale = size as f64 / side as f64;
            let sigma = sigma_px * scale;
            Axis {
                metres_per_pixel,
                scale,
                // Never infinite: at no distance it is multiplied by 0.
                exponent: (-0.5 / (sigma * sigma)).max(f64::MIN),
            }
        };
        let buildings = Tensor::from_slice(&resized, (maps, size, size), device)?;
        let windows = match (config.frame, device.is_cpu()) {
            (Frame::Map, _) => None,
            (Frame::Receiver, true) => {
                Some(Windows::Sums(frame::Sums::new(pixels, [height, width])))
            }
            (Frame::Receiver, false) => Some(Windows::on_device(&rasters, device)?),
        };
        Ok(Self {
            buildings,
            windows,
            host: if device.is_cpu() { resized } else { Vec::new() },
            maps,
            size,
            along: [axis(width), axis(height)],
        })
    }

    /// Fills a batch of images in one pass over its memory.
    fn fill(&self, links: &[Link]) -> Result<Tensor> {
        let (size, plane) = (self.size, self.size * self.size);
        let mut images = vec![0.0_f32; links.len() * 3 * plane];
        images
            .par_chunks_mut(3 * plane)
            .zip(links)
            .for_each(|(image, link)| {
                let (buildings, spots) = image.split_at_mut(plane);
                let map = link.map as usize;
                match &self.windows {
                    Some(Windows::Sums(sums)) => {
                        sums.average(map, self.middle(link), size, buildings);
                    }
                    _ => buildings.copy_from_slice(&self.host[map * plane..][..plane]),
                }
                let first = self.first_pixel(link);
                for (spot, centre_m) in spots.chunks_exact_mut(plane).zip([link.tx_m, link.rx_m]) {
                    let [x, y] = [0, 1].map(|i| self.along[i].profile(centre_m[i], first[i], size));
                    for (row, y) in spot.chunks_exact_mut(size).zip(y) {
                        for (value, x) in row.iter_mut().zip(&x) {
                            *value = (x * y) as f32;
                        }
                    }
                }
            });
        let shape = (links.len(), 3, size, size);
        Ok(Tensor::from_vec(images, shape, self.device())?)
    }

    /// Locates the middle of a link's window \[pixels from the raster's corner\].
    fn middle(&self, link: &Link) -> [f64; 2] {
        [0, 1].map(|i| (self.along[i].place(link.rx_m[i]) + 0.5) / self.along[i].scale)
    }

    /// Locates the first pixel of a link's image in that of the map \[pixels\].
    fn first_pixel(&self, link: &Link) -> [f64; 2] {
        let middle = 0.5 * (self.size as f64 - 1.0);
        match self.windows {
            None => [0.0; 2],
            Some(_) => [0, 1].map(|i| self.along[i].place(link.rx_m[i]) - middle),
        }
    }

    /// Composes a batch of images by candle's operations: five numbers a link are sent to the device, in the frame of the receiver seven.
    fn compose(&self, links: &[Link]) -> Result<Tensor> {
        let (n, size) = (links.len(), self.size);
        let maps: Vec<u32> = links.iter().map(|link| link.map).collect();
        let maps = Tensor::from_vec(maps, n, self.device())?;
        let buildings = match &self.windows {
            Some(Windows::Rasters(rasters)) => {
                let middles: Vec<_> = links.iter().map(|link| self.middle(link)).collect();
                frame::averages(&rasters.index_select(&maps, 0)?, &middles, size)?
            }
            _ => self.buildings.index_select(&maps, 0)?,
        };
        let mut planes = vec![buildings];
        for end in [|link: &Link| link.tx_m, |link: &Link| link.rx_m] {
            let profile = |i: usize| {
                let axis = self.along[i];
                let centre = |link| axis.place(end(link)[i]) - self.first_pixel(link)[i];
                let centres = links.iter().map(|link| centre(link) as f32);
                let centres = Tensor::from_vec(centres.collect(), (n, 1), self.device())?;
                let pixels =
                    Tensor::arange(0_u32, size as u32, self.device())?.to_dtype(DType::F32)?;
                let distance = pixels.unsqueeze(0)?.broadcast_sub(&centres)?;
                // In f32, which must hold it as well.
                let exponent = axis.exponent.max(f32::MIN.into());
                (distance.sqr()? * exponent)?.exp()
            };
            let (x, y) = (profile(0)?.unsqueeze(1)?, profile(1)?.unsqueeze(D::Minus1)?);
            planes.push(y.broadcast_mul(&x)?);
        }
        Ok(Tensor::stack(&planes, 1)?)
    }
}

impl ModelInput for ConditionImages {
    fn batch(&self, links: &[Link]) -> Result<Tensor> {
        for (i, link) in links.iter().enumerate() {
            let is_finite = link.tx_m.iter().chain(&link.rx_m).all(|x| x.is_finite());
            if link.map as usize >= self.maps || !is_finite {
                let maps = self.maps;
                return Err(Error::Condition(format!(
                    "link {i} of the batch is {link:?}: its map must be below {maps}, its ends finite"
                )));
            }
        }
        match self.device().is_cpu() {
            true => self.fill(links),
            false => self.compose(links),
        }
    }

    fn device(&self) -> &Device {
        self.buildings.device()
    }

    fn image_size(&self) -> usize {
        self.size
    }
}

impl Windows {
    fn on_device(rasters: &Rasters<'_>, device: &Device) -> Result<Self> {
        let shape = (rasters.maps(), rasters.height, rasters.width);
        Ok(Self::Rasters(Tensor::from_slice(
            rasters.pixels,
            shape,
            device,
        )?))
    }
}

/// Largest side of an image \[pixels\].
pub(crate) const MAX_SIZE: usize = 1 << 12;

impl Axis {
    /// Converts a position from metres to pixels of the image.
    fn place(self, metres: f64) -> f64 {
        metres / self.metres_per_pixel * self.scale + 0.5 * (self.scale - 1.0)
    }

    /// Computes the spot along this axis in an image whose first pixel is at the place `first`.
    fn profile(self, centre_m: f64, first: f64, pixels: usize) -> Vec<f64> {
        let centre = self.place(centre_m) - first;
        (0..pixels)
            .map(|pixel| (self.exponent * (pixel as f64 - centre).powi(2)).exp())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However small a spot is, its middle is 1, not NaN: on the host and on a device.
    #[test]
    fn a_spot_of_hardly_any_size_is_a_point() {
        let rasters = Rasters {
            pixels: &[0.0; 9],
            height: 3,
            width: 3,
            metres_per_pixel: 2.0,
        };
        let link = Link {
            map: 0,
            tx_m: [2.0, 0.0],
            rx_m: [1.0, 1.0],
        };
        let spot = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0_f32];
        for sigma_px in [5e-324, 1e-160, 1e-25, 1e-3] {
            let config = ConditionConfig {
                image_size: 3,
                sigma_px,
                frame: Frame::Map,
            };
            let images = ConditionImages::new(rasters, config, &Device::Cpu).unwrap();
            for image in [images.fill(&[link]), images.compose(&[link])] {
                let image: Vec<f32> = image.unwrap().flatten_all().unwrap().to_vec1().unwrap();
                assert_eq!(
                    (&image[9..18], &image[18..]),
                    (&spot[..], &[0.0; 9][..]),
                    "{sigma_px:e}"
                );
            }
        }
    }

    /// The device's way must not differ from the host's by more than the rounding of f32, which nothing else checks
    /// without such a device.
    #[test]
    fn composed_images_equal_filled_ones() {
        let pixels: Vec<f32> = (0..2 * 40 * 50).map(|i| (i % 3) as f32 / 2.0).collect();
        let rasters = Rasters {
            pixels: &pixels,
            height: 40,
            width: 50,
            metres_per_pixel: 2.0,
        };
        let link = |map, tx_m, rx_m| Link { map, tx_m, rx_m };
        let links = [
            link(1, [10.0, 70.5], [99.0, 0.0]),
            link(0, [0.25, 3.0], [-40.0, 200.0]),
            link(1, [90.0, 20.0], [31.25, 47.5]),
        ];
        for (frame, image_size, tolerance) in [
            (Frame::Map, 32, 2e-6),
            (Frame::Receiver, 32, 2e-5),
            (Frame::Receiver, 40, 2e-5),
            (Frame::Receiver, 90, 2e-5),
        ] {
            let config = ConditionConfig {
                image_size,
                sigma_px: 7.0,
                frame,
            };
            let host = ConditionImages::new(rasters, config, &Device::Cpu).unwrap();
            let mut device = host.clone();
            if frame == Frame::Receiver {
                device.windows = Some(Windows::on_device(&rasters, &Device::Cpu).unwrap());
            }
            let filled = host.fill(&links).unwrap();
            let composed = device.compose(&links).unwrap();
            assert_eq!(filled.dims(), composed.dims());
            let difference = (filled - composed).unwrap().abs().unwrap();
            let worst: f32 = difference.max_all().unwrap().to_scalar().unwrap();
            assert!(worst < tolerance, "{frame}, {image_size} px: {worst}");
        }
    }
}
