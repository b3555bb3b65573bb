//! A model that begins as the function another one computes.

use std::path::Path;

use candle_nn::VarMap;

use super::matching::{Columns, assign, own_names};
use super::report::LoadReport;
use super::source::Source;
use crate::Result;
use crate::parameters::sorted;

/// Prefix of the noise input, which only predictors trained against a regularizer have.
const NOISE: &str = "noise_proj.";

/// Matrix that reads the noise input: one column for each of its values, after all other columns.
const READS_NOISE: &str = "decoder.0.weight";

/// Fills all tensors from weights of the same model, or MS-AReg's from MS-MLP's: adversarial training then begins with
/// a trained predictor, as is usual for generators.
///
/// MS-MLP is MS-AReg without the noise input. The weights that read the noise begin at zero, so that MS-AReg's outputs
/// are at first MS-MLP's. The noise input itself keeps its values; the report lists its tensors.
///
/// # Errors
/// As [`load`](super::load).
pub fn warm_start(path: &Path, parameters: &VarMap) -> Result<LoadReport> {
    let source = Source::open(path)?;
    let mut wanted = sorted(parameters);
    let names = own_names(&source, &wanted)?;
    let has_noise = names.found.keys().any(|name| name.starts_with(NOISE));
    let noise = wanted.iter().find(|(name, _)| name == "noise_proj.bias");
    let Some((_, noise)) = noise.filter(|_| !has_noise).cloned() else {
        return assign(&source, names, &wanted, None);
    };
    let kept = wanted.extract_if(.., |(name, _)| name.starts_with(NOISE));
    let kept = kept.map(|(name, _)| name).collect();
    let silent = Columns {
        of: READS_NOISE,
        count: noise.elem_count(),
    };
    let report = assign(&source, names, &wanted, Some(silent))?;
    Ok(LoadReport { kept, ..report })
}
