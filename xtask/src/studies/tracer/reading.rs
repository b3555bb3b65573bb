//! What the measurements say.

use anyhow::Result;
use aps_raytrace::TraceConfig;

use super::settings::{self, DEFAULT, LIMITS, RANGES};
use super::{ReferenceRow, Row};
use crate::benchmark::words::{self, three_digits};
use crate::studies::errors::FLOOR_DB;
use crate::studies::links::REST_DB;
use crate::studies::trade::{Choice, Marked, Trade, small};
use crate::studies::{Setup, Study, StudyName};

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
    let mut study = Study::new(StudyName::Tracer.name(), "Tracer: how far to go").at(1);
    for text in introduction(setup, references) {
        study.text(text);
    }
    maps(&mut study, references);
    let trades = [
        (
            "db",
            "mean error above \u{2212}40 dB [dB]",
            LEAST_DB,
            "Mean error of the spectrum",
        ),
        (
            "cosine",
            "1 \u{2212} CosSim",
            1e-6,
            "1 \u{2212} CosSim of the targets",
        ),
        ("ple", "PLE [deg]", 1e-3, "Peak location error"),
    ]
    .map(|(stem, axis, least, what)| (stem, axis, least, what, trade(&all, stem)));
    for (stem, axis, least, what, trade) in &trades {
        let chart = trade.chart(
            "tracing and labelling of a link [us]",
            axis,
            *least,
            Marked::Only(&[DEFAULT]),
        );
        let caption = format!("{what} against time a link, over all maps. Grey: the front.");
        study.figure(&format!("{stem}-time"), caption, &chart.draw());
    }
    let by_db = &trades[0].4;
    study.text(by_db.front_in_words("us", "dB"));
    study.points(findings(&all, by_db));
    let dominated = by_db.dominated_in_words();
    if !dominated.is_empty() {
        study.text("By the mean error in dB, against what is faster by more than a tenth:");
        study.points(dominated);
    }
    overall_table(&mut study, &all, by_db);
    by_map(&mut study, references, rows);
    study.data("settings", "Every setting on every map", rows)?;
    study.data("references", "The references", references)?;
    Ok(study)
}

fn introduction(setup: &Setup, references: &[ReferenceRow]) -> [String; 3] {
    let limits = settings::reference(setup.profile);
    let sum = |of: fn(&ReferenceRow) -> usize| references.iter().map(of).sum::<usize>();
    let default = TraceConfig::default();
    [
        format!(
            "How much of the label is lost by stopping early? The reference, R{} D{}, leaves nothing out; its label is made of the \
             strongest paths, until all that are left are together {REST_DB} dB below the strongest. It shares the tracer's formulas: this \
             study is about limits, the study of diffraction about formulas. Links drawn: {}; compared: {}; without any path: {}; \
             reached only by chains of more diffractions than that, which are estimates in every setting, and left out: {}.",
            limits.max_reflections,
            limits.max_diffractions,
            sum(|r| r.links),
            sum(|r| r.compared),
            sum(|r| r.without_path),
            sum(|r| r.beyond),
        ),
        format!(
            "Rn Dm stands for limits of n reflections and m diffractions on a path, n + m in all, with the usual dynamic range of \
             {} dB and chains of up to {} diffractions for links without a path. The dynamic range is varied at R2 D1, the \
             default, and {} dB also within {}.",
            default.dynamic_range_db.unwrap_or_default(),
            default.max_fallback_diffractions,
            settings::FAR_RANGE_DB,
            settings::FAR_LIMITS
        ),
        format!(
            "Labels are the paper's, of a linear array of 16. Errors in dB are means over the bins in which the reference or the \
             setting is above \u{2212}{FLOOR_DB} dB of the reference's maximum, what is below counted as if it were there; a link without a \
             spectrum counts {FLOOR_DB} dB, CosSim 0 and a PLE of 180 deg. The time of a link is its join, its label, and its \
             share of what is done once a terminal and once a map, for 100 transmitters and 500 receivers a map."
        ),
    ]
}

fn maps(study: &mut Study, references: &[ReferenceRow]) {
    let row = |r: &ReferenceRow| {
        vec![
            r.map.clone(),
            r.buildings.to_string(),
            r.walls.to_string(),
            format!("{} of {}", r.compared, r.links),
            words::count(r.paths_per_link.round() as u64),
            words::duration(r.seconds),
        ]
    };
    let head = [
        "map",
        "buildings",
        "walls",
        "links compared",
        "paths a link",
        "time",
    ];
    study.table("The reference", &head, references.iter().map(row).collect());
}

fn trade(all: &[Overall<'_>], error: &str) -> Trade {
    let mut trade = Trade::default();
    for o in all {
        let error = match error {
            "cosine" => o.one_minus_cosine.max(0.0),
            "ple" => o.ple_deg,
            _ => o.mean_db,
        };
        trade.add(o.first.group, &o.first.setting, o.total_us, error);
    }
    trade
}

/// Sentences about the settings that a user chooses among.
fn findings(all: &[Overall<'_>], by_db: &Trade) -> Vec<String> {
    let mut points = Vec::new();
    let find = |name: &str| all.iter().find(|o| o.first.setting == name);
    if let (Some(default), Some(choice)) = (find(DEFAULT), by_db.named(DEFAULT)) {
        points.push(default_in_words(default, choice, by_db));
    }
    for (limit, next) in LIMITS.iter().zip(&LIMITS[1..]) {
        let last = |group: &str| all.iter().rfind(|o| o.first.group == group);
        if let (Some(p), Some(q)) = (last(limit), last(next)) {
            points.push(format!(
                "From {} to {} the error goes from {} to {} dB, the time from {} to {} us: {} % of the error goes.",
                p.first.setting,
                q.first.setting,
                small(p.mean_db),
                small(q.mean_db),
                three_digits(p.total_us),
                three_digits(q.total_us),
                words::fixed(100.0 * (1.0 - q.mean_db / p.mean_db), 0)
            ));
        }
    }
    let ranges: Vec<&Overall<'_>> = all.iter().filter(|o| o.first.group == RANGES).collect();
    if let (Some(default), Some(unpruned)) = (find(DEFAULT), find("all paths")) {
        let free = ranges
            .iter()
            .filter(|o| o.mean_db <= 1.05 * unpruned.mean_db)
            .min_by(|p, q| p.total_us.total_cmp(&q.total_us));
        points.push(format!(
            "Keeping all paths at {DEFAULT} takes {} us instead of {}, for an error of {} dB instead of {}: {}.",
            three_digits(unpruned.total_us),
            three_digits(default.total_us),
            small(unpruned.mean_db),
            small(default.mean_db),
            match default.mean_db - unpruned.mean_db {
                d if d < 0.01 => "nothing that weak shows".to_owned(),
                d => format!("the dynamic range costs {} dB", small(d)),
            }
        ));
        if let Some(o) = free {
            points.push(format!(
                "The fastest dynamic range with an error within 5 % of that of all paths is {}: {} us, {} paths a link instead \
                 of {}.",
                o.first.setting,
                three_digits(o.total_us),
                three_digits(o.paths),
                three_digits(unpruned.paths)
            ));
        }
    }
    if let Some(last) = all.iter().rfind(|o| LIMITS.contains(&o.first.group)) {
        points.push(format!(
            "{}, one reflection short of the reference, is still {} dB off: the reference is not the end either, and what is said \
             here about errors is a lower bound.",
            last.first.setting,
            small(last.mean_db)
        ));
    }
    let cut: Vec<&str> = all
        .iter()
        .filter(|o| o.cut_links > 0)
        .map(|o| &*o.first.setting)
        .collect();
    if !cut.is_empty() {
        points.push(format!(
            "{} finds more than {} paths for some links: more than a label takes. There the strongest {} are labelled.",
            words::list(&cut),
            aps_label::MAX_PATHS,
            aps_label::MAX_PATHS
        ));
    }
    points
}

fn default_in_words(default: &Overall<'_>, choice: &Choice, by_db: &Trade) -> String {
    let cost = format!(
        "The default, {DEFAULT}, takes {} us a link, {} of them for tracing, and is off by {} dB in the mean (95 % of the links below \
         {} dB), by {} in CosSim and by {} deg in PLE",
        three_digits(default.total_us),
        three_digits(default.trace_us),
        small(default.mean_db),
        small(default.p95_db),
        small(default.one_minus_cosine),
        small(default.ple_deg)
    );
    let front = by_db.front();
    match by_db.better_than(choice) {
        Some(better) => format!("{cost}. It is dominated by {}.", better.name),
        None if front.contains(&choice) => format!("{cost}. It is on the front."),
        None => format!("{cost}. It lies beside the front, by less than a tenth of its time."),
    }
}

fn overall_table(study: &mut Study, all: &[Overall<'_>], by_db: &Trade) {
    let front = by_db.front();
    let row = |o: &Overall<'_>| {
        let on_front = front.iter().any(|c| c.name == o.first.setting);
        vec![
            o.first.setting.clone(),
            three_digits(o.total_us),
            three_digits(o.trace_us),
            three_digits(o.paths),
            o.missing.to_string(),
            small(o.mean_db),
            small(o.p95_db),
            small(o.one_minus_cosine),
            small(o.ple_deg),
            if on_front { "yes" } else { "" }.into(),
        ]
    };
    let head = [
        "setting",
        "time [us]",
        "of it tracing [us]",
        "paths",
        "links without",
        "mean error [dB]",
        "95 % [dB]",
        "1 \u{2212} CosSim",
        "PLE [deg]",
        "on the front",
    ];
    study.table(
        "All settings, over all maps",
        &head,
        all.iter().map(row).collect(),
    );
}

/// The default and the reference's neighbours on each map: does density matter?
fn by_map(study: &mut Study, references: &[ReferenceRow], rows: &[Row]) {
    let shown: Vec<&str> = [DEFAULT, "R5 D1", "R2 D2", "R5 D2"]
        .into_iter()
        .filter(|name| rows.iter().any(|r| r.setting == *name))
        .collect();
    let cells = |map: &ReferenceRow| {
        let mut cells = vec![map.map.clone(), map.walls.to_string()];
        for name in &shown {
            let row = rows.iter().find(|r| r.map == map.map && r.setting == *name);
            cells.push(row.map_or(String::new(), |r| {
                format!(
                    "{} us, {} dB",
                    three_digits(r.total_us),
                    small(r.mean_error_db)
                )
            }));
        }
        cells
    };
    let mut head = vec!["map", "walls"];
    head.extend(&shown);
    study.table(
        "Time a link and mean error on each map",
        &head,
        references.iter().map(cells).collect(),
    );
    let of_default = || rows.iter().filter(|r| r.setting == DEFAULT && r.links > 0);
    let by_error = |p: &&Row, q: &&Row| p.mean_error_db.total_cmp(&q.mean_error_db);
    if let (Some(best), Some(worst)) =
        (of_default().min_by(by_error), of_default().max_by(by_error))
    {
        study.text(format!(
            "At {DEFAULT} the error is smallest on {} ({} walls, {} dB) and largest on {} ({} walls, {} dB): how far to go depends on \
             the map.",
            best.map,
            best.walls,
            small(best.mean_error_db),
            worst.map,
            worst.walls,
            small(worst.mean_error_db)
        ));
    }
}
