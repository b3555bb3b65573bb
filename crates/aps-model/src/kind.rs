//! Models by name.

use candle_core::bail;
use candle_nn::VarBuilder;
use serde::{Deserialize, Serialize};

use crate::condition::{InputKind, InputShape};
use crate::loss::Loss;
use crate::models::{self, Model, Regularizer, Spec};
use crate::named::named;
use crate::train::TrainConfig;
use crate::{Error, Preset, Result};

/// Declares [`ModelKind`] from the [`Spec`]s in the modules of [`crate::models`].
macro_rules! model_kinds {
    ($($(#[$doc:meta])* $kind:ident = $module:ident::$spec:ident;)*) => {
        /// The models of the benchmark. Serialized, one is its [`name`](ModelKind::name).
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(into = "&'static str", try_from = "String")]
        pub enum ModelKind {
            $($(#[$doc])* $kind,)*
        }

        impl ModelKind {
            /// Every model, in the order of this page.
            pub const ALL: [Self; [$(stringify!($kind)),*].len()] = [$(Self::$kind),*];

            fn spec(self) -> &'static Spec {
                match self {
                    $(Self::$kind => &models::$module::$spec,)*
                }
            }
        }
    };
}

model_kinds! {
    /// MS-AReg, the paper's reference: multi-scale encoder, decoder, trained against a regularizer.
    MsAreg = ms_areg::MS_AREG;
    /// MS-MLP, an ablation: MS-AReg without the regularizer.
    MsMlp = ms_areg::MS_MLP;
    /// Adv-MLP, an ablation: MS-AReg without the multi-scale encoder.
    AdvMlp = ms_areg::ADV_MLP;
    /// ResNet-18 and a perceptron.
    ResnetMlp = resnet_mlp::SPEC;
    /// A U-Net, averaged over the image, and a perceptron.
    RadioUnet = radiounet::SPEC;
    /// ViT-B/16 and a perceptron.
    VitReg = vit_reg::SPEC;
    /// The multi-scale encoder and convolutions over the angle.
    ResnetConv1d = resnet_conv1d::SPEC;
    /// Polar-Reg, which is not of the paper: a perceptron for each way along a ray, whose strengths are added; no image.
    PolarReg = polar_reg::SPEC;
}

impl ModelKind {
    /// Returns the name on the command line and in files.
    pub fn name(self) -> &'static str {
        self.spec().name
    }

    /// Returns the name in tables and texts.
    pub fn title(self) -> &'static str {
        self.spec().title
    }

    /// Returns true when the model is trained against a [`Regularizer`].
    pub fn is_adversarial(self) -> bool {
        self.loss() == Loss::Adversarial
    }

    /// Returns the loss that its training minimises.
    pub fn loss(self) -> Loss {
        self.spec().loss
    }

    /// Returns the kind of its input.
    pub fn input(self) -> InputKind {
        self.spec().input
    }

    /// Builds the model for input of a shape from the tensors of `vb`: [`seeded`](crate::seeded) ones to train it as the benchmark does, those of
    /// any [`VarMap`](candle_nn::VarMap), or constants, as a file's, to evaluate it.
    ///
    /// # Errors
    /// `vb` lacks a tensor, or has one of another shape; or the input is not of the model's [kind](Self::input).
    pub fn build(
        self,
        preset: Preset,
        input: InputShape,
        vb: VarBuilder<'_>,
    ) -> candle_core::Result<Box<dyn Model>> {
        let (found, needed) = (input.kind(), self.input());
        if found != needed {
            bail!("{self} takes {needed:?} as input, not {found:?}");
        }
        (self.spec().build)(preset, input, vb)
    }

    /// Builds the regularizer to train the model against; `None` where it needs none. `vb` must not be the model's own:
    /// some names of tensors are the same.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn build_regularizer(
        self,
        preset: Preset,
        vb: VarBuilder<'_>,
    ) -> candle_core::Result<Option<Regularizer>> {
        let build = || Regularizer::new(models::width(preset), vb);
        self.is_adversarial().then(build).transpose()
    }

    /// Returns the paper's settings of its training, with steps of 64 links for the small preset; Polar-Reg has its own rate
    /// and steps.
    pub fn train_config(self, preset: Preset) -> TrainConfig {
        let papers = match self.is_adversarial() {
            true => TrainConfig::adversarial(),
            false => TrainConfig::regression(),
        };
        let batch = match preset {
            Preset::Paper => papers.batch,
            Preset::Small => 64,
        };
        (self.spec().settings)(TrainConfig { batch, ..papers })
    }
}

named!(ModelKind, "model");

impl From<ModelKind> for &'static str {
    fn from(kind: ModelKind) -> Self {
        kind.name()
    }
}

impl TryFrom<String> for ModelKind {
    type Error = Error;

    fn try_from(name: String) -> Result<Self> {
        name.parse()
    }
}
