//! RadioUNet: a U-Net whose last features are averaged into a spectrum.

use candle_core::{Module, ModuleT, Result, Tensor, bail};
use candle_nn::VarBuilder;

use super::check::{CHANNELS, check_images};
use super::{Model, Spec};
use crate::condition::InputKind;
use crate::layers::{ConvTranspose2x2, DoubleConv, Linear};
use crate::loss::Loss;
use crate::train::TrainConfig;
use crate::{ANGLE_BINS, Preset, ops};

pub(crate) const SPEC: Spec = Spec {
    name: "radiounet",
    title: "RadioUNet",
    loss: Loss::Squared,
    input: InputKind::Images,
    build: |preset, _, vb| {
        // Its first and last blocks work at full resolution.
        let width = match preset {
            Preset::Paper => 64,
            Preset::Small => 16,
        };
        Ok(Box::new(RadioUnet::new(width, vb)?))
    },
    settings: |usual| TrainConfig {
        batch: usual.batch.min(256),
        ..usual
    },
};

/// A U-Net (Ronneberger et al., MICCAI 2015; for radio maps Levie et al., IEEE TWC 2021): `enc1` to `enc4` with maxima over
/// 2 x 2 between them, `bottleneck`, transposed convolutions `up4` to `up1`, each joined with the encoder's features
/// (first the upsampled, then those) and followed by `dec4` to `dec1`; the mean over the image, `head.0`, ReLU, `head.2`.
#[derive(Debug, Clone)]
pub(crate) struct RadioUnet {
    encoders: Vec<DoubleConv>,
    bottleneck: DoubleConv,
    /// Deepest first, each with the block after it.
    decoders: Vec<(ConvTranspose2x2, DoubleConv)>,
    head: [Linear; 2],
}

/// Halvings of the image.
const DEPTH: usize = 4;

impl RadioUnet {
    /// Creates the model. The paper has `width` 64: 31,169,076 trainable parameters.
    ///
    /// Images must have sides that are multiples of 16.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let encoder = |n: usize| {
            let inputs = if n == 0 { CHANNELS } else { width << (n - 1) };
            DoubleConv::new(inputs, width << n, vb.pp(format!("enc{}", n + 1)))
        };
        let decoder = |n: usize| -> Result<_> {
            let (channels, up) = (width << n, vb.pp(format!("up{}", n + 1)));
            let block = vb.pp(format!("dec{}", n + 1));
            Ok((
                ConvTranspose2x2::new(2 * channels, channels, up)?,
                DoubleConv::new(2 * channels, channels, block)?,
            ))
        };
        let head = vb.pp("head");
        Ok(Self {
            encoders: (0..DEPTH).map(encoder).collect::<Result<_>>()?,
            bottleneck: DoubleConv::new(8 * width, 16 * width, vb.pp("bottleneck"))?,
            decoders: (0..DEPTH).rev().map(decoder).collect::<Result<_>>()?,
            head: [
                Linear::new(width, 8 * width, head.pp(0))?,
                Linear::new(8 * width, ANGLE_BINS, head.pp(2))?,
            ],
        })
    }
}

impl ModuleT for RadioUnet {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let unit = 1 << DEPTH;
        if images.dim(2)? % unit != 0 || images.dim(3)? % unit != 0 {
            let found = images.dims();
            bail!(
                "condition images of a RadioUNet must have the shape [any, {CHANNELS}, multiple of {unit}, multiple of {unit}], \
                 not {found:?}"
            );
        }
        let mut skips = Vec::with_capacity(DEPTH);
        let mut x = images.clone();
        for encoder in &self.encoders {
            let features = encoder.forward_t(&x, train)?;
            x = ops::max_pool_2x2(&features)?;
            skips.push(features);
        }
        x = self.bottleneck.forward_t(&x, train)?;
        for ((up, block), skip) in self.decoders.iter().zip(skips.iter().rev()) {
            x = block.forward_t(&ops::cat(&[&up.forward(&x)?, skip], 1)?, train)?;
        }
        let features = ops::flatten_from(&ops::adaptive_avg_pool(&x, 1)?, 1)?;
        let hidden = ops::relu(&self.head[0].forward(&features)?)?;
        self.head[1].forward(&hidden)
    }
}

impl Model for RadioUnet {}
