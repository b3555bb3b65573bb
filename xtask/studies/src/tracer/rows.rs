//! Measurements of the study, as its data keep them.

use serde::Serialize;

/// Cost and errors of a setting on one map.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub map: String,
    pub walls: usize,
    pub setting: String,
    pub group: &'static str,
    pub max_reflections: usize,
    pub max_diffractions: usize,
    pub dynamic_range_db: Option<f64>,
    pub links: usize,
    pub missing_links: usize,
    pub paths_per_link: f64,
    /// Links with more paths than a label takes: the strongest are labelled.
    pub cut_links: usize,
    pub trace_us: f64,
    pub label_us: f64,
    pub total_us: f64,
    pub map_s: f64,
    pub transmitter_us: f64,
    pub receiver_us: f64,
    pub join_us: f64,
    pub mean_error_db: f64,
    pub p95_error_db: f64,
    pub one_minus_cosine: f64,
    pub ple_deg: f64,
}

/// Costs of the reference on one map.
#[derive(Debug, Clone, Serialize)]
pub struct ReferenceRow {
    pub map: String,
    pub buildings: usize,
    pub walls: usize,
    /// Links drawn.
    pub links: usize,
    /// Links that are compared.
    pub compared: usize,
    /// Links without a path.
    pub without_path: usize,
    pub paths_per_link: f64,
    pub seconds: f64,
}
