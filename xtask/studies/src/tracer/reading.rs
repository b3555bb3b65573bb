//! Tables and figures of the measurements.

use anyhow::Result;
use aps_metrics::LEVEL_FLOOR_DB;
use aps_report::document::Verdict;
use aps_report::numbers::{count, duration, small, three_digits};
use aps_report::trade::{Choice, Trade};

use super::rows::{ReferenceRow, Row};
use super::settings::{self, DEFAULT};
use crate::links::REST_DB;
use crate::{Setup, Study, StudyName};

/// Errors below this [dB] are drawn there.
const LEAST_DB: f64 = 1e-3;

/// One setting over all maps.
struct Overall<'r> {
    first: &'r Row,
    total_us: f64,
    trace_us: f64,
    paths: f64,
    missing: usize,
    cut_links: usize,
    mean_db: f64,
    p95_db: f64,
    one_minus_cosine: f64,
    ple_deg: f64,
}

impl<'r> Overall<'r> {
    /// Times are means over maps, errors means over links.
    fn of(rows: &'r [Row]) -> Vec<Self> {
        let first = &rows[0].map;
        let settings = rows.iter().filter(|row| row.map == *first);
        let over = |first: &'r Row| {
            let own: Vec<&Row> = rows.iter().filter(|r| r.setting == first.setting).collect();
            let links: usize = own.iter().map(|r| r.links).sum();
            let mean =
                |of: fn(&Row) -> f64| own.iter().map(|r| of(r)).sum::<f64>() / own.len() as f64;
            let by_link = |of: fn(&Row) -> f64| {
                own.iter().map(|r| of(r) * r.links as f64).sum::<f64>() / links.max(1) as f64
            };
            Self {
                first,
                total_us: mean(|r| r.total_us),
                trace_us: mean(|r| r.trace_us),
                paths: by_link(|r| r.paths_per_link),
                missing: own.iter().map(|r| r.missing_links).sum(),
                cut_links: own.iter().map(|r| r.cut_links).sum(),
                mean_db: by_link(|r| r.mean_error_db),
                p95_db: by_link(|r| r.p95_error_db),
                one_minus_cosine: by_link(|r| r.one_minus_cosine),
                ple_deg: by_link(|r| r.ple_deg),
            }
        };
        settings.map(over).collect()
    }
}

/// The study, from its measurements.
pub fn study(setup: &Setup, references: &[ReferenceRow], rows: &[Row]) -> Result<Study> {
    let all = Overall::of(rows);
    let mut study = StudyName::Tracer.study("Tracer: how far to go");
    let limits = settings::reference(setup.profile);
    study.section.text(format!(
        "Rn Dm: limits of n reflections and m diffractions. Reference: R{} D{}, without omissions, down to {REST_DB} dB below the \
         strongest path. Errors down to {LEVEL_FLOOR_DB} dB below the reference's maximum.",
        limits.max_reflections, limits.max_diffractions,
    ));
    maps(&mut study, references);
    let by_db = trade(&all, |o| o.mean_db);
    let by_cosine = trade(&all, |o| o.one_minus_cosine.max(0.0));
    let by_ple = trade(&all, |o| o.ple_deg);
    let error_db = "mean error above \u{2212}40 dB [dB]";
    let cosine = "1 \u{2212} CosSim";
    for (stem, trade, axis, least, what) in [
        (
            "db",
            &by_db,
            error_db,
            LEAST_DB,
            "Mean error of the spectrum",
        ),
        (
            "cosine",
            &by_cosine,
            cosine,
            1e-6,
            "1 \u{2212} CosSim of the targets",
        ),
        ("ple", &by_ple, "PLE [deg]", 1e-3, "Peak location error"),
    ] {
        let is_named = |choice: &Choice| choice.name == DEFAULT;
        let chart = trade.chart(
            "tracing and labelling of a link [us]",
            axis,
            least,
            is_named,
        );
        let caption = format!("{what} against time a link, over all maps. Grey: the front.");
        study.figure(&format!("{stem}-time"), caption, chart.draw());
    }
    if let Some(default) = by_db.named(DEFAULT) {
        let claim = format!("the default, {DEFAULT}, is on the front");
        let numbers = format!(
            "{} us, {} dB",
            three_digits(default.time),
            small(default.error)
        );
        let is_there = by_db.front().contains(&default);
        study
            .section
            .verdict(Verdict::decided(is_there, claim, numbers));
    }
    overall_table(&mut study, &all, &by_db);
    study.data("settings", "Every setting on every map", rows)?;
    study.data("references", "The references", references)?;
    Ok(study)
}

fn maps(study: &mut Study, references: &[ReferenceRow]) {
    study.columns(
        "The reference",
        references,
        &[
            ("map", &|r| r.map.clone()),
            ("buildings", &|r| r.buildings.to_string()),
            ("walls", &|r| r.walls.to_string()),
            ("links compared", &|r| {
                format!("{} of {}", r.compared, r.links)
            }),
            ("without a path", &|r| r.without_path.to_string()),
            ("paths a link", &|r| count(r.paths_per_link.round() as u64)),
            ("time", &|r| duration(r.seconds)),
        ],
    );
}

fn trade(all: &[Overall<'_>], error: fn(&Overall<'_>) -> f64) -> Trade {
    let mut trade = Trade::default();
    for o in all {
        trade.add(o.first.group, &o.first.setting, o.total_us, error(o));
    }
    trade
}

fn overall_table(study: &mut Study, all: &[Overall<'_>], by_db: &Trade) {
    study.columns(
        "All settings, over all maps",
        all,
        &[
            ("setting", &|o| o.first.setting.clone()),
            ("time [us]", &|o| three_digits(o.total_us)),
            ("of it tracing [us]", &|o| three_digits(o.trace_us)),
            ("paths", &|o| three_digits(o.paths)),
            ("links without", &|o| o.missing.to_string()),
            ("links cut", &|o| o.cut_links.to_string()),
            ("mean error [dB]", &|o| small(o.mean_db)),
            ("95 % [dB]", &|o| small(o.p95_db)),
            ("1 \u{2212} CosSim", &|o| small(o.one_minus_cosine)),
            ("PLE [deg]", &|o| small(o.ple_deg)),
            ("on the front", &|o| by_db.on_front(&o.first.setting)),
        ],
    );
}
