//! The tracer against the solution of the wave equation in small scenes, with and without slope diffraction.

mod compare;
mod reading;
mod rows;
mod setting;

use anyhow::Result;
use aps_tests::fullwave::{FullWave, Walls};
use xtask::progress;

use crate::{Setup, Stopwatch, Study};
use compare::{Comparison, Reference};
use rows::{CANYON, LinkRow, Row, mean, quantile};
use setting::{CASCADE, FAR, R2_D1, SLOPES, Setting};

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
            let mut all: Vec<Comparison> = settings
                .iter()
                .map(|setting| reference.compare(&setting.config))
                .collect::<Result<_>>()?;
            let compared = &settings[CASCADE..=SLOPES];
            let times = reference.times(compared, Stopwatch::of(setup.profile))?;
            for (found, seconds) in all[CASCADE..=SLOPES].iter_mut().zip(times) {
                found.time_us = 1e6 * seconds;
            }
            for (setting, found) in settings.iter().zip(&all) {
                rows.push(row(&reference, setting, found, &all[SLOPES]));
            }
            links.extend(link_rows(&reference, &all));
            if full.name == CANYON {
                for setting in Setting::beyond() {
                    let found = reference.compare(&setting.config)?;
                    beyond.push(row(&reference, &setting, &found, &all[SLOPES]));
                }
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    reading::study(settings, &rows, &beyond, &links)
}

fn row(reference: &Reference<'_>, setting: &Setting, found: &Comparison, by: &Comparison) -> Row {
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
        time_us: found.time_us,
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
