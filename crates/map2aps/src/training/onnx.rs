//! Trained models for other runtimes.

use std::path::Path;

use aps_model::candle_core::Device;
use aps_model::condition::InputKind;
use aps_model::weights::{Label, LoadReport};
use aps_model::{ModelKind, Preset, onnx};

use super::input::shape_for;
use super::loaded::Loaded;
use super::{TrainingError, usual_image_size};
use crate::error::Result;

/// A model as a file of ONNX: see [`aps_model::onnx`].
#[derive(Debug)]
pub struct OnnxModel {
    /// Content of the file.
    pub bytes: Vec<u8>,
    /// Model and sizes.
    pub label: Label,
    /// Rows and columns of its condition images; none if it takes no images.
    pub image_size: Option<usize>,
    /// True if nothing tells that size, and it is the one that the preset is meant for.
    pub is_size_assumed: bool,
    /// Account of the tensors that were read.
    pub report: LoadReport,
}

impl OnnxModel {
    /// Makes the file of weights as [`Trained::load`](super::Trained::load) takes them. Images have `image_size` rows and columns;
    /// without it the size that the model was trained on, as far as that is known.
    ///
    /// The metadata tell model, preset and size, and for weights in the folder of a run what they were trained on: the labels'
    /// settings (array, bandwidth, protocol), the statistics that normalise them, width of the spots and frame of the images.
    ///
    /// # Errors
    /// Errors of [`Trained::load`](super::Trained::load), and an image size that the model does not take.
    pub fn load(
        weights: &Path,
        kind: Option<ModelKind>,
        preset: Option<Preset>,
        image_size: Option<usize>,
    ) -> Result<Self> {
        let loaded = Loaded::file(weights, kind, preset, &Device::Cpu)?;
        Self::of(loaded, image_size)
    }

    /// Makes the file of the weights that come with `aps-model`, as [`load`](Self::load) does.
    ///
    /// # Errors
    /// Errors of [`Trained::shipped`](super::Trained::shipped), and an image size that the model does not take.
    pub fn shipped(kind: ModelKind, image_size: Option<usize>) -> Result<Self> {
        Self::of(Loaded::shipped(kind, &Device::Cpu)?, image_size)
    }

    fn of(loaded: Loaded, image_size: Option<usize>) -> Result<Self> {
        let label = loaded.label;
        let trained_on = loaded.settings.as_ref().map(|settings| settings.image_size);
        let size = image_size.or(trained_on);
        let size = size.unwrap_or(usual_image_size(label.preset));
        let has_images = label.kind.input() == InputKind::Images;
        if image_size.is_some() && !has_images {
            return Err(TrainingError::NoImages(label.kind).into());
        }
        let mut facts = Vec::new();
        if has_images {
            facts.push(("image_size", size.to_string()));
        }
        if let Some(settings) = loaded.settings {
            let statistics = serde_json::to_string(&settings.training_statistics)?;
            if has_images {
                facts.push(("sigma_px", settings.sigma_px.to_string()));
                facts.push(("frame", settings.frame.to_string()));
            }
            facts.push(("protocol", settings.protocol.to_string()));
            facts.push(("training_statistics", statistics));
            if let Some(labels) = settings.data_configuration.get("label") {
                facts.push(("label", labels.to_string()));
            }
        }
        Ok(Self {
            bytes: onnx::export(
                label,
                shape_for(label.kind),
                size,
                &loaded.parameters,
                &facts,
            )?,
            label,
            image_size: has_images.then_some(size),
            is_size_assumed: has_images && image_size.or(trained_on).is_none(),
            report: loaded.report,
        })
    }
}
