//! Mirror images of a data set's spectra.

use aps_data::{Axis, Dataset};
use aps_model::ModelKind;
use aps_model::candle_core::Device;
use aps_model::condition::{ConditionImages, InputKind, ModelInput, Rasters};
use aps_model::data::{self, Mirrored};
use serde_json::Value;

use super::TrainingError;
use super::fields::PolarFields;
use super::input::images;
use crate::error::Result;
use crate::examples::Examples;
use crate::maps::MapSource;
use crate::scores::ScoreError;

/// Adds the mirror images to training examples; returns the input of a model for all of them too. The development maps stand
/// behind the training maps, so that checkpoints keep the numbers that they know maps by.
pub fn mirrored(
    dataset: &Dataset,
    train: Examples,
    development: &Examples,
    (kind, image_size): (ModelKind, usize),
    maps: Option<&MapSource>,
    device: &Device,
) -> Result<(Box<dyn data::Examples>, Box<dyn ModelInput>)> {
    let manifest = dataset.manifest();
    let aps = manifest.layout.aps.ok_or(ScoreError::NoSpectra)?;
    let negated = negated_bins(&manifest.configuration, aps.axis)?;
    let pixels = [train.pixels(), development.pixels()].concat();
    let rasters = train.rasters(&pixels);
    let input: Box<dyn ModelInput> = match kind.input() {
        InputKind::Images => {
            let pixels = &rasters.mirrored();
            let rasters = Rasters { pixels, ..rasters };
            Box::new(ConditionImages::new(rasters, images(image_size), device)?)
        }
        InputKind::Polar => {
            let maps = [train.field_maps(maps)?, development.field_maps(maps)?].concat();
            Box::new(PolarFields::new(maps, rasters.far_end_m(), device.clone()))
        }
    };
    Ok((Box::new(Mirrored::new(train, rasters, negated)?), input))
}

/// For each bin of a data set's spectra the one at the negative of its angle, if the spectra are those of a linear array,
/// whose mirror images are known without tracing. `configuration` is the manifest's.
fn negated_bins(configuration: &Value, axis: Axis) -> Result<Vec<usize>, TrainingError> {
    let array = configuration.pointer("/label/array");
    if array.is_none_or(|array| array.get("uniform_linear").is_none()) {
        let array = array.cloned().unwrap_or_default();
        return Err(TrainingError::Mirrored { array });
    }
    let angles: Vec<f64> = axis.values().collect();
    let at = |angle: f64| angles.iter().position(|x| (x - angle).abs() < 1e-9);
    // The axis may hold 180 and -180 degrees, or one of them.
    let negated = |&angle: &f64| {
        let turns = [0.0, 360.0, -360.0];
        turns.iter().find_map(|turn| at(turn - angle))
    };
    let bins: Option<Vec<usize>> = angles.iter().map(negated).collect();
    bins.ok_or(TrainingError::Asymmetric)
}

#[cfg(test)]
mod tests {
    use aps_label::LabelConfig;
    use serde_json::json;

    use super::*;

    #[test]
    fn each_bin_has_one_at_its_negative_angle() {
        let linear = json!({ "label": { "array": LabelConfig::released().array } });
        for axis in [Axis::ANGLE_RELEASED_DEG, Axis::ANGLE_PAPER_DEG] {
            let angles: Vec<f64> = axis.values().collect();
            let negated = negated_bins(&linear, axis).unwrap();
            let mut sorted = negated.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..axis.count));
            for (bin, &other) in negated.iter().enumerate() {
                let turns = (angles[bin] + angles[other]) / 360.0;
                assert!((turns - turns.round()).abs() < 1e-12, "{bin} and {other}");
            }
        }
        let half = Axis {
            start: 0.0,
            ..Axis::ANGLE_PAPER_DEG
        };
        let circular = json!({ "label": { "array": { "uniform_circular": { "elements": 8 } } } });
        let refused = negated_bins(&linear, half).unwrap_err();
        assert!(matches!(refused, TrainingError::Asymmetric), "{refused}");
        let refused = negated_bins(&circular, Axis::ANGLE_PAPER_DEG).unwrap_err();
        assert!(
            matches!(refused, TrainingError::Mirrored { .. }),
            "{refused}"
        );
    }
}
