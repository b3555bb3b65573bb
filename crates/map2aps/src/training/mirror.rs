//! Mirror images of a data set's spectra.

use aps_data::Dataset;
use aps_model::ModelKind;
use aps_model::candle_core::Device;
use aps_model::condition::{ConditionConfig, ConditionImages, InputKind, ModelInput, Rasters};
use aps_model::data::{self, Mirrored};

use super::polar::PolarWays;
use crate::error::Result;
use crate::examples::Examples;
use crate::maps::MapSource;
use crate::mirror::negated_bins;

/// Adds the mirror images to training examples; returns the input of a model for all of them too. The development maps stand
/// behind the training maps, so that checkpoints keep the numbers that they know maps by.
pub fn mirrored(
    dataset: &Dataset,
    train: Examples,
    development: &Examples,
    (kind, images): (ModelKind, ConditionConfig),
    maps: Option<&MapSource>,
    device: &Device,
) -> Result<(Box<dyn data::Examples>, Box<dyn ModelInput>)> {
    let manifest = dataset.manifest();
    let aps = dataset.aps_layout()?;
    let negated = negated_bins(&manifest.configuration, aps.axis)?;
    let pixels = [train.pixels(), development.pixels()].concat();
    let rasters = train.rasters(&pixels);
    let input: Box<dyn ModelInput> = match kind.input() {
        InputKind::Images => {
            let pixels = &rasters.mirrored();
            let rasters = Rasters { pixels, ..rasters };
            Box::new(ConditionImages::new(rasters, images, device)?)
        }
        InputKind::Polar => {
            let views = train.polar_views(maps)?;
            let views = views.with(development.polar_views(maps)?);
            Box::new(PolarWays::new(views, rasters.far_end_m(), device.clone()))
        }
    };
    Ok((Box::new(Mirrored::new(train, rasters, negated)?), input))
}
