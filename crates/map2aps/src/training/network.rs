//! Networks with their initial weights.

use std::fmt;
use std::path::{Path, PathBuf};

use aps_model::candle_core::{DType, Device};
use aps_model::candle_nn::VarMap;
use aps_model::weights::{self, Label, LoadReport};
use aps_model::{LabelFacts, Model, Regularizer, seeded};

use super::input::shape_for;
use crate::error::{At, Place, Result};

/// Initial weights of a training.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum InitialWeights {
    /// Drawn by the seed.
    #[default]
    Random,
    /// The backbone's from a file, the regularizer's too, the rest drawn.
    Backbone(PathBuf),
    /// The predictor's all from a file, as [`weights::warm_start`] takes them, and the regularizer's backbone.
    Model(PathBuf),
}

impl fmt::Display for InitialWeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Random => f.write_str("random"),
            Self::Backbone(path) => write!(f, "backbone of {}", path.display()),
            Self::Model(path) => write!(f, "all of {}", path.display()),
        }
    }
}

/// The networks of a training with their parameters.
pub struct Networks {
    /// The model and its tensors.
    pub model: (Box<dyn Model>, VarMap),
    /// The regularizer and its tensors, for the models that are trained against one.
    pub regularizer: Option<(Regularizer, VarMap)>,
    /// Account of the initial weights that a file gave.
    pub loaded: Option<LoadReport>,
}

impl Networks {
    /// Builds the networks of a training with their initial weights and, where they compute with them, the facts of the labels.
    pub fn new(
        Label { kind, preset }: Label,
        facts: Option<&LabelFacts>,
        seed: u64,
        initial: &InitialWeights,
        device: &Device,
    ) -> Result<Self> {
        let (parameters, of_regularizer) = (VarMap::new(), VarMap::new());
        let vb = seeded(&parameters, seed, DType::F32, device);
        let model = kind.build(preset, shape_for(kind), vb)?;
        let vb = seeded(&of_regularizer, seed.wrapping_add(1), DType::F32, device);
        let regularizer = kind.build_regularizer(preset, vb)?;
        let load = |path: &Path| -> Result<LoadReport> {
            // In the paper all backbones begin pretrained.
            if regularizer.is_some() {
                weights::load_pretrained(path, &of_regularizer)?;
            }
            Ok(match initial {
                InitialWeights::Model(_) => weights::warm_start(path, &parameters)?,
                InitialWeights::Random | InitialWeights::Backbone(_) => {
                    weights::load_pretrained(path, &parameters)?
                }
            })
        };
        let loaded = match initial {
            InitialWeights::Random => None,
            InitialWeights::Backbone(path) | InitialWeights::Model(path) => {
                let place = Place::InitialWeights(initial.to_string());
                Some(load(path).at(place)?)
            }
        };
        if let Some(facts) = facts {
            facts.set(&parameters)?;
        }
        Ok(Self {
            model: (model, parameters),
            regularizer: regularizer.map(|network| (network, of_regularizer)),
            loaded,
        })
    }
}
