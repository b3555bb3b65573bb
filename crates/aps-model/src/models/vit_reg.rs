//! ViT-Reg: a vision transformer whose class token becomes the spectrum.

use candle_core::Tensor;
use serde::{Deserialize, Serialize};

use super::{CHANNELS, check_images};
use crate::layers::{Conv2d, EncoderBlock, LayerNorm, Linear};
use crate::{ANGLE_BINS, Error, Init, Mode, Model, Parameters, Result, ops};

/// Sizes of a [`VitReg`]. [`Default`] is the paper's: ViT-B/16.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VitRegConfig {
    /// Side to which images are resized \[pixels\]; a multiple of `patch`.
    pub image_size: usize,
    /// Side of a patch, which becomes one token \[pixels\].
    pub patch: usize,
    /// Features of a token; a multiple of `heads`.
    pub width: usize,
    /// Encoder blocks.
    pub depth: usize,
    /// Attention heads.
    pub heads: usize,
    /// Hidden features of the head.
    pub hidden: usize,
    /// Probability of dropping a hidden feature of the head in training.
    pub dropout: f64,
}

impl Default for VitRegConfig {
    fn default() -> Self {
        Self {
            image_size: 224,
            patch: 16,
            width: 768,
            depth: 12,
            heads: 12,
            hidden: 512,
            dropout: 0.1,
        }
    }
}

impl VitRegConfig {
    /// Patches of 8 px of images of 64 px, width 192, depth 6, three heads: for CPUs.
    pub fn small() -> Self {
        Self {
            image_size: 64,
            patch: 8,
            width: 192,
            depth: 6,
            heads: 3,
            hidden: 192,
            dropout: 0.1,
        }
    }

    fn check(&self) -> Result<()> {
        let divides =
            |part: usize, whole: usize| part > 0 && whole > 0 && whole.is_multiple_of(part);
        if divides(self.patch, self.image_size) && divides(self.heads, self.width) {
            return Ok(());
        }
        let what = format!(
            "a vision transformer needs an image size ({}) that its patches ({}) fill and a width ({}) that its heads ({}) \
             share",
            self.image_size, self.patch, self.width, self.heads
        );
        Err(Error::Config { what })
    }
}

/// torchvision's `VisionTransformer` (Dosovitskiy et al., ICLR 2021) as `vit`, then `head.0`, GELU, dropout, `head.3`.
#[derive(Debug, Clone)]
pub struct VitReg {
    patches: Conv2d,
    class_token: Tensor,
    positions: Tensor,
    blocks: Vec<EncoderBlock>,
    ln: LayerNorm,
    head: [Linear; 2],
    config: VitRegConfig,
    parameters: Parameters,
}

impl VitReg {
    /// Creates the model's tensors in `parameters`. The paper's sizes make 86,284,724 trainable parameters.
    ///
    /// # Errors
    /// [`Error::Config`] if sizes do not divide each other.
    pub fn new(parameters: &Parameters, config: VitRegConfig) -> Result<Self> {
        config.check()?;
        let root = parameters.root();
        let (vit, head) = (root.at("vit"), root.at("head"));
        let encoder = vit.at("encoder");
        let width = config.width;
        let tokens = (config.image_size / config.patch).pow(2) + 1;
        let blocks = (0..config.depth)
            .map(|i| {
                let scope = encoder.at("layers").at(format!("encoder_layer_{i}"));
                EncoderBlock::new(&scope, width, config.heads)
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            patches: Conv2d::patches(&vit.at("conv_proj"), CHANNELS, width, config.patch)?,
            class_token: vit.trainable("class_token", (1, 1, width), Init::ZEROS)?,
            positions: encoder.trainable(
                "pos_embedding",
                (1, tokens, width),
                Init::Normal { std: 0.02 },
            )?,
            blocks,
            ln: LayerNorm::new(&encoder.at("ln"), width)?,
            head: [
                Linear::new(&head.at(0), width, config.hidden)?,
                Linear::new(&head.at(3), config.hidden, ANGLE_BINS)?,
            ],
            config,
            parameters: parameters.clone(),
        })
    }

    /// Computes the class tokens (batch, width) of images of any size.
    fn encode(&self, images: &Tensor) -> Result<Tensor> {
        let (batch, size) = (images.dim(0)?, self.config.image_size);
        let images = ops::resize_bilinear(images, size, size)?;
        let patches = self
            .patches
            .forward(&images)?
            .flatten_from(2)?
            .transpose(1, 2)?;
        let class = self.class_token.to_dtype(patches.dtype())?;
        let class = class.broadcast_as((batch, 1, self.config.width))?;
        let mut tokens = Tensor::cat(&[&class, &patches], 1)?
            .broadcast_add(&self.positions.to_dtype(patches.dtype())?)?;
        for block in &self.blocks {
            tokens = block.forward(&tokens)?;
        }
        // The normalisation acts on each token: that of the class token is all that is needed.
        Ok(self.ln.forward(&tokens.narrow(1, 0, 1)?)?.squeeze(1)?)
    }
}

impl Model for VitReg {
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        let hidden = ops::gelu(&self.head[0].forward(&self.encode(images)?)?)?;
        self.head[1].forward(&ops::dropout(&hidden, self.config.dropout, mode)?)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
