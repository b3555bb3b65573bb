//! Spectra of mirrored maps.

use aps_data::Axis;
use serde_json::Value;

/// Fault of a data set whose spectra say nothing about mirrored maps.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MirrorError {
    /// Spectra of another array than a linear one.
    #[error(
        "the spectra of mirrored maps follow without tracing for a uniform linear array only; this data set's array is \
         {array}"
    )]
    Array {
        /// The array, as the manifest has it.
        array: Value,
    },
    /// Spectra over other angles than their mirror image.
    #[error("the angles of this data set's spectra are not symmetric about zero")]
    Asymmetric,
}

/// For each bin of a data set's spectra the one at the negative of its angle, if the spectra are those of a linear array,
/// whose mirror images are known without tracing. `configuration` is the manifest's.
pub(crate) fn negated_bins(configuration: &Value, axis: Axis) -> Result<Vec<usize>, MirrorError> {
    let array = configuration.pointer("/label/array");
    if array.is_none_or(|array| array.get("uniform_linear").is_none()) {
        let array = array.cloned().unwrap_or_default();
        return Err(MirrorError::Array { array });
    }
    let angles: Vec<f64> = axis.values().collect();
    let at = |angle: f64| angles.iter().position(|x| (x - angle).abs() < 1e-9);
    // The axis may hold 180 and -180 degrees, or one of them.
    let negated = |&angle: &f64| {
        let turns = [0.0, 360.0, -360.0];
        turns.iter().find_map(|turn| at(turn - angle))
    };
    let bins: Option<Vec<usize>> = angles.iter().map(negated).collect();
    bins.ok_or(MirrorError::Asymmetric)
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
        assert!(matches!(refused, MirrorError::Asymmetric), "{refused}");
        let refused = negated_bins(&circular, Axis::ANGLE_PAPER_DEG).unwrap_err();
        assert!(matches!(refused, MirrorError::Array { .. }), "{refused}");
    }
}
