//! RadioUNet: a U-Net whose last features are averaged into a spectrum.

use candle_core::Tensor;

use super::{CHANNELS, check_images};
use crate::layers::{ConvTranspose2x2, DoubleConv, Linear};
use crate::{ANGLE_BINS, Error, Mode, Model, Parameters, Result, ops};

/// A U-Net (Ronneberger et al., MICCAI 2015; for radio maps Levie et al., IEEE TWC 2021): `enc1` to `enc4` with maxima over
/// 2 x 2 between them, `bottleneck`, transposed convolutions `up4` to `up1`, each joined with the encoder's features
/// (first the upsampled, then those) and followed by `dec4` to `dec1`; the mean over the image, `head.0`, ReLU, `head.2`.
#[derive(Debug, Clone)]
pub struct RadioUnet {
    encoders: [DoubleConv; DEPTH],
    bottleneck: DoubleConv,
    /// Deepest first, each with the block after it.
    decoders: [(ConvTranspose2x2, DoubleConv); DEPTH],
    head: [Linear; 2],
    parameters: Parameters,
}

/// Halvings of the image.
const DEPTH: usize = 4;

impl RadioUnet {
    /// Creates the model's tensors in `parameters`. The paper has `width` 64: 31,169,076 trainable parameters.
    ///
    /// Images must have sides that are multiples of 16.
    pub fn new(parameters: &Parameters, width: usize) -> Result<Self> {
        let root = parameters.root();
        let encode = |n: usize| {
            let inputs = if n == 0 { CHANNELS } else { width << (n - 1) };
            DoubleConv::new(&root.at(format!("enc{}", n + 1)), inputs, width << n)
        };
        let decode = |n: usize| -> Result<_> {
            let channels = width << n;
            let up =
                ConvTranspose2x2::new(&root.at(format!("up{}", n + 1)), 2 * channels, channels)?;
            Ok((
                up,
                DoubleConv::new(&root.at(format!("dec{}", n + 1)), 2 * channels, channels)?,
            ))
        };
        let head = root.at("head");
        Ok(Self {
            encoders: [encode(0)?, encode(1)?, encode(2)?, encode(3)?],
            bottleneck: DoubleConv::new(&root.at("bottleneck"), 8 * width, 16 * width)?,
            decoders: [decode(3)?, decode(2)?, decode(1)?, decode(0)?],
            head: [
                Linear::new(&head.at(0), width, 8 * width)?,
                Linear::new(&head.at(2), 8 * width, ANGLE_BINS)?,
            ],
            parameters: parameters.clone(),
        })
    }
}

impl Model for RadioUnet {
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        let (height, width) = (images.dim(2)?, images.dim(3)?);
        let unit = 1 << DEPTH;
        if height % unit != 0 || width % unit != 0 {
            return Err(Error::Shape {
                what: "condition images of a RadioUNet",
                expected: format!("[any, {CHANNELS}, multiple of {unit}, multiple of {unit}]"),
                found: images.dims().to_vec(),
            });
        }
        let mut skips = Vec::with_capacity(DEPTH);
        let mut x = images.clone();
        for encoder in &self.encoders {
            let features = encoder.forward(&x, mode)?;
            x = ops::max_pool_2x2(&features)?;
            skips.push(features);
        }
        x = self.bottleneck.forward(&x, mode)?;
        for ((up, decoder), skip) in self.decoders.iter().zip(skips.iter().rev()) {
            x = decoder.forward(&Tensor::cat(&[&up.forward(&x)?, skip], 1)?, mode)?;
        }
        let features = ops::adaptive_avg_pool(&x, 1)?.flatten_from(1)?;
        let hidden = ops::relu(&self.head[0].forward(&features)?)?;
        self.head[1].forward(&hidden)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
