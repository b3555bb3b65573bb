//! ViT-Reg: a vision transformer whose class token becomes the spectrum.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::{Init, VarBuilder};

use super::check::{CHANNELS, check_images};
use super::{Model, Spec};
use crate::condition::InputKind;
use crate::layers::{Conv2d, Dropout, EncoderBlock, LayerNorm, Linear};
use crate::loss::Loss;
use crate::parameters::normal;
use crate::train::TrainConfig;
use crate::{ANGLE_BINS, Preset, ops};

pub(crate) const SPEC: Spec = Spec {
    name: "vit_reg",
    title: "ViT-Reg",
    loss: Loss::Squared,
    input: InputKind::Images,
    build: |preset, _, vb| {
        let config = match preset {
            Preset::Paper => VitRegConfig::PAPER,
            Preset::Small => VitRegConfig::SMALL,
        };
        Ok(Box::new(VitReg::new(config, vb)?))
    },
    settings: |usual| TrainConfig {
        learning_rate: 1e-4,
        ..usual
    },
};

/// Sizes of a [`VitReg`].
#[derive(Debug, Clone)]
pub(crate) struct VitRegConfig {
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

impl VitRegConfig {
    /// ViT-B/16.
    pub const PAPER: Self = Self {
        image_size: 224,
        patch: 16,
        width: 768,
        depth: 12,
        heads: 12,
        hidden: 512,
        dropout: 0.1,
    };

    /// Sizes for CPUs.
    pub const SMALL: Self = Self {
        image_size: 64,
        patch: 8,
        width: 192,
        depth: 6,
        heads: 3,
        hidden: 192,
        dropout: 0.1,
    };
}

/// torchvision's `VisionTransformer` (Dosovitskiy et al., ICLR 2021) as `vit`, then `head.0`, GELU, dropout, `head.3`.
#[derive(Debug, Clone)]
pub(crate) struct VitReg {
    patches: Conv2d,
    class_token: Tensor,
    positions: Tensor,
    blocks: Vec<EncoderBlock>,
    ln: LayerNorm,
    head: [Linear; 2],
    dropout: Dropout,
    config: VitRegConfig,
}

impl VitReg {
    /// Creates the model. The paper's sizes make 86,284,724 trainable parameters.
    pub fn new(config: VitRegConfig, vb: VarBuilder<'_>) -> Result<Self> {
        let (vit, head) = (vb.pp("vit"), vb.pp("head"));
        let encoder = vit.pp("encoder");
        let width = config.width;
        let tokens = (config.image_size / config.patch).pow(2) + 1;
        let block = |i: usize| {
            let vb = encoder.pp("layers").pp(format!("encoder_layer_{i}"));
            EncoderBlock::new(width, config.heads, vb)
        };
        Ok(Self {
            patches: Conv2d::patches(CHANNELS, width, config.patch, vit.pp("conv_proj"))?,
            class_token: vit.get_with_hints((1, 1, width), "class_token", Init::Const(0.0))?,
            positions: encoder.get_with_hints((1, tokens, width), "pos_embedding", normal(0.02))?,
            blocks: (0..config.depth).map(block).collect::<Result<_>>()?,
            ln: LayerNorm::new(width, encoder.pp("ln"))?,
            head: [
                Linear::new(width, config.hidden, head.pp(0))?,
                Linear::new(config.hidden, ANGLE_BINS, head.pp(3))?,
            ],
            dropout: Dropout::new(config.dropout),
            config,
        })
    }

    /// Computes the class tokens (batch, width) of images of any size.
    fn encode(&self, images: &Tensor) -> Result<Tensor> {
        let size = self.config.image_size;
        let images = ops::resize_bilinear(images, size, size)?;
        let patches = ops::flatten_from(&self.patches.forward(&images)?, 2)?;
        let patches = ops::transpose(&patches)?;
        let class = self.class_token.to_dtype(patches.dtype())?;
        let class = ops::repeat(&class, &patches)?;
        let tokens = ops::cat(&[&class, &patches], 1)?;
        let mut tokens = ops::add(&tokens, &self.positions.to_dtype(patches.dtype())?)?;
        for block in &self.blocks {
            tokens = block.forward(&tokens)?;
        }
        // The normalisation acts on each token: that of the class token is all that is needed.
        ops::squeeze(&self.ln.forward(&ops::narrow(&tokens, 1, 0, 1)?)?, 1)
    }
}

impl ModuleT for VitReg {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let hidden = ops::gelu(&self.head[0].forward(&self.encode(images)?)?)?;
        self.head[1].forward(&self.dropout.forward_t(&hidden, train)?)
    }
}

impl Model for VitReg {
    fn seed_dropout(&self, seed: u64, step: u64) {
        self.dropout.seed(seed, step);
    }
}
