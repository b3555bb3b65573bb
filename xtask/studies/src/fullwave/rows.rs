//! Measurements of the study, as its data keep them.

use serde::Serialize;

/// The scene in which limits are raised further, for no order is the last between walls that reflect all.
pub const CANYON: &str = "canyon";

/// A setting in a scene.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub scene: &'static str,
    pub walls: &'static str,
    /// Length in wavelengths.
    pub longest_wall: f64,
    pub setting: String,
    pub max_reflections: usize,
    pub max_diffractions: usize,
    pub dynamic_range_db: Option<f64>,
    pub slopes: bool,
    pub links: usize,
    /// Links without a path; each counts as an error of 40 dB.
    pub missing: usize,
    pub mean_error_db: f64,
    pub median_error_db: f64,
    pub p90_error_db: f64,
    /// Mean error with the reference's reflection coefficients.
    pub mean_error_of_its_material_db: f64,
    /// Mean of the level found over the level there.
    pub bias_db: f64,
    /// Links whose strongest path has two corners or more, after R5 D2 with slopes.
    pub two_corners: usize,
    pub two_corners_missing: usize,
    pub two_corners_mean_error_db: f64,
    pub two_corners_median_error_db: f64,
    pub arrays: usize,
    pub mean_direction_error_deg: f64,
    /// Part of the arrays with an error below 5 deg.
    pub directions_within_5_deg: f64,
    pub paths_per_link: f64,
    /// Per link, with its share of map and terminals: of one run, but at R5 D2 and 30 dB the median of several.
    pub time_us: f64,
}

/// A link, at the settings of the tables.
#[derive(Debug, Clone, Serialize)]
pub struct LinkRow {
    pub scene: &'static str,
    pub walls: &'static str,
    pub source: usize,
    pub x: f64,
    pub y: f64,
    /// Level of the reference over free space \[dB\].
    pub level_db: f64,
    /// Corners on the strongest path of R5 D2 with slopes.
    pub corners: usize,
    /// Nearest to its boundary that any of them is: sqrt(2 k L) sin(delta / 2).
    pub boundary: Option<f64>,
    pub r2_d1_db: f64,
    pub cascade_db: f64,
    pub slopes_db: f64,
    pub far_db: f64,
    /// Error of the strongest direction of the array about the receiver, if it has one, at R5 D2 with slopes.
    pub direction_deg: Option<f64>,
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

pub fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (part * sorted.len() as f64) as usize;
    sorted.get(at).or(sorted.last()).copied().unwrap_or(0.0)
}
