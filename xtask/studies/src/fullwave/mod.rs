//! The tracer against the solution of the wave equation in small scenes, with and without slope diffraction.

mod compare;
mod reading;

use anyhow::Result;
use aps_raytrace::TraceConfig;
use aps_tests::fullwave::{FullWave, Walls};
use serde::Serialize;
use xtask::progress;

use crate::{Setup, Stopwatch, Study};
use compare::{Comparison, Reference};

/// A setting of the tracer.
#[derive(Debug, Clone)]
struct Setting {
    name: String,
    config: TraceConfig,
}

impl Setting {
    fn new(r: usize, d: usize, range_db: f64, slope_diffraction: bool) -> Self {
        let slopes = if slope_diffraction { ", slopes" } else { "" };
        Self {
            name: format!("R{r} D{d}, {range_db} dB{slopes}"),
            config: TraceConfig {
                dynamic_range_db: Some(range_db),
                slope_diffraction,
                ..TraceConfig::within(r, d)
            },
        }
    }

    fn all() -> Vec<Self> {
        let mut all = vec![
            Self::new(2, 1, 60.0, false),
            Self::new(5, 2, 30.0, false),
            Self::new(5, 2, 30.0, true),
            Self::new(8, 3, 40.0, false),
            Self::new(8, 3, 40.0, true),
        ];
        for (r, d, range_db) in [
            (0, 1, 60.0),
            (1, 1, 60.0),
            (3, 1, 60.0),
            (5, 1, 60.0),
            (8, 1, 60.0),
            (2, 2, 30.0),
            (5, 2, 20.0),
            (5, 2, 40.0),
            (8, 2, 30.0),
            (5, 3, 30.0),
        ] {
            all.push(Self::new(r, d, range_db, false));
            if d > 1 {
                all.push(Self::new(r, d, range_db, true));
            }
        }
        all
    }

    /// Limits beyond those, without and with slopes.
    fn beyond() -> impl Iterator<Item = Self> {
        let limits = [(12, 3), (16, 3), (24, 3), (8, 4), (12, 4), (16, 4)];
        let both = |(r, d)| [false, true].map(|slopes| Self::new(r, d, 40.0, slopes));
        limits.into_iter().flat_map(both)
    }
}

/// The scene in which limits are raised further, for no order is the last between walls that reflect all.
const CANYON: &str = "canyon";

/// The settings that are named in tables: places in [`Setting::all`].
const R2_D1: usize = 0;
const CASCADE: usize = 1;
const SLOPES: usize = 2;
const FAR_CASCADE: usize = 3;
const FAR: usize = 4;

/// A setting in a scene.
#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: &'static str,
    walls: &'static str,
    /// In wavelengths.
    longest_wall: f64,
    setting: String,
    max_reflections: usize,
    max_diffractions: usize,
    dynamic_range_db: Option<f64>,
    slopes: bool,
    links: usize,
    /// Links without a path; each counts as an error of 40 dB.
    missing: usize,
    mean_error_db: f64,
    median_error_db: f64,
    p90_error_db: f64,
    /// The same with the reference's reflection coefficients.
    mean_error_of_its_material_db: f64,
    /// Mean of the level found over the level there.
    bias_db: f64,
    /// Links whose strongest path has two corners or more, after R5 D2 with slopes.
    two_corners: usize,
    two_corners_missing: usize,
    two_corners_mean_error_db: f64,
    two_corners_median_error_db: f64,
    arrays: usize,
    mean_direction_error_deg: f64,
    /// Part of the arrays with an error below 5 deg.
    directions_within_5_deg: f64,
    paths_per_link: f64,
    /// Per link, with its share of map and terminals: of one run, but at R5 D2 and 30 dB the median of several.
    time_us: f64,
}

/// A link, at the settings of the tables.
#[derive(Debug, Clone, Serialize)]
struct LinkRow {
    scene: &'static str,
    walls: &'static str,
    source: usize,
    x: f64,
    y: f64,
    /// Level of the reference over free space \[dB\].
    level_db: f64,
    /// Corners on the strongest path of R5 D2 with slopes.
    corners: usize,
    /// Nearest to its boundary that any of them is: sqrt(2 k L) sin(delta / 2).
    boundary: Option<f64>,
    r2_d1_db: f64,
    cascade_db: f64,
    slopes_db: f64,
    far_db: f64,
    /// Error of the strongest direction of the array about the receiver, if it has one, at R5 D2 with slopes.
    direction_deg: Option<f64>,
}

/// Measures.
pub fn run(setup: &Setup) -> Result<Study> {
    let smoke = ["block05", "behind"];
    let is_taken = |scene: &FullWave| setup.profile.choose(smoke.contains(&scene.name), true);
    let scenes: Vec<FullWave> = FullWave::all().into_iter().filter(is_taken).collect();
    let settings: Vec<Setting> = Setting::all();
    let settings = &settings[..setup.profile.choose(FAR + 1, settings.len())];
    let bar = progress::bar((scenes.len() * Walls::ALL.len()) as u64, "scenes");
    let (mut rows, mut beyond, mut links) = (Vec::new(), Vec::new(), Vec::new());
    for full in &scenes {
        for walls in Walls::ALL {
            let reference = Reference::new(full, walls)?;
            let all: Vec<Comparison> = settings
                .iter()
                .map(|setting| reference.compare(&setting.config))
                .collect::<Result<_>>()?;
            let mut times: Vec<f64> = all.iter().map(|found| found.time_us).collect();
            let compared = &settings[CASCADE..=SLOPES];
            let measured = reference.times(compared, Stopwatch::of(setup.profile))?;
            times[CASCADE..=SLOPES].copy_from_slice(&measured);
            for ((setting, found), time_us) in settings.iter().zip(&all).zip(times) {
                rows.push(row(&reference, setting, found, &all[SLOPES], time_us));
            }
            links.extend(link_rows(&reference, &all));
            if full.name == CANYON {
                for setting in Setting::beyond() {
                    let found = reference.compare(&setting.config)?;
                    let time_us = found.time_us;
                    beyond.push(row(&reference, &setting, &found, &all[SLOPES], time_us));
                }
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    reading::study(&rows, &beyond, &links)
}

fn row(
    reference: &Reference<'_>,
    setting: &Setting,
    found: &Comparison,
    by: &Comparison,
    time_us: f64,
) -> Row {
    let full = reference.full;
    let compared = || reference.compared();
    let error = |i: usize| found.error_db(i).abs();
    let errors: Vec<f64> = compared().map(error).collect();
    let deep: Vec<usize> = compared().filter(|&i| by.corners[i] >= 2).collect();
    let deep_errors: Vec<f64> = deep.iter().map(|&i| error(i)).collect();
    let of_material = compared().map(|i| found.error_of_its_material_db(i).abs());
    let reached: Vec<f64> = compared()
        .filter(|&i| found.is_reached(i))
        .map(|i| found.error_db(i))
        .collect();
    let directions: Vec<f64> = found.directions.iter().map(|&(_, error)| error).collect();
    let within = directions.iter().filter(|&&e| e < 5.0).count();
    Row {
        scene: full.name,
        walls: reference.walls.name(),
        longest_wall: full.longest_wall(),
        setting: setting.name.clone(),
        max_reflections: setting.config.max_reflections,
        max_diffractions: setting.config.max_diffractions,
        dynamic_range_db: setting.config.dynamic_range_db,
        slopes: setting.config.slope_diffraction,
        links: errors.len(),
        missing: compared().filter(|&i| !found.is_reached(i)).count(),
        mean_error_db: mean(&errors),
        median_error_db: quantile(&errors, 0.5),
        p90_error_db: quantile(&errors, 0.9),
        mean_error_of_its_material_db: mean(&of_material.collect::<Vec<_>>()),
        bias_db: mean(&reached),
        two_corners: deep.len(),
        two_corners_missing: deep.iter().filter(|&&i| !found.is_reached(i)).count(),
        two_corners_mean_error_db: mean(&deep_errors),
        two_corners_median_error_db: quantile(&deep_errors, 0.5),
        arrays: directions.len(),
        mean_direction_error_deg: mean(&directions),
        directions_within_5_deg: within as f64 / directions.len().max(1) as f64,
        paths_per_link: found.paths as f64 / reference.link_count() as f64,
        time_us,
    }
}

fn link_rows(reference: &Reference<'_>, all: &[Comparison]) -> Vec<LinkRow> {
    let row = |i: usize| {
        let (source, place) = reference.link(i);
        LinkRow {
            scene: reference.full.name,
            walls: reference.walls.name(),
            source,
            x: place.x,
            y: place.y,
            level_db: reference.level_db(i),
            corners: all[SLOPES].corners[i],
            boundary: all[SLOPES].boundaries[i],
            r2_d1_db: all[R2_D1].error_db(i),
            cascade_db: all[CASCADE].error_db(i),
            slopes_db: all[SLOPES].error_db(i),
            far_db: all[FAR].error_db(i),
            direction_deg: all[SLOPES].direction_error_deg(i),
        }
    };
    reference.compared().map(row).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (part * sorted.len() as f64) as usize;
    sorted.get(at).or(sorted.last()).copied().unwrap_or(0.0)
}
