//! Tables, figures and the verdict.

use anyhow::Result;
use aps_report::chart::{Axis, Chart, Mark, Series};
use aps_report::document::Verdict;
use aps_report::numbers::{fixed, three_digits};
use aps_report::theme::Colour;
use aps_report::trade::Trade;
use aps_tests::fullwave::Walls;

use super::rows::{CANYON, LinkRow, Row, mean};
use super::setting::{CASCADE, FAR, FAR_CASCADE, R2_D1, SLOPES, Setting};
use crate::{Study, StudyName};

/// The scenes of one house in several sizes.
const SIZES: &str = "block";
/// Ends of the ranges of distances to a boundary.
const BOUNDARIES: [f64; 5] = [0.3, 1.0, 3.0, 10.0, f64::INFINITY];

/// Names of the settings in tables, [`R2_D1`] to [`FAR`].
type Named<'s> = [&'s str; 5];

/// The measure of a row that a table shows.
type Value = fn(&Row) -> f64;

pub fn study(
    settings: &[Setting],
    rows: &[Row],
    beyond: &[Row],
    links: &[LinkRow],
) -> Result<Study> {
    let mut study =
        StudyName::Fullwave.study("The whole field: the tracer against the wave equation");
    let named: Named<'_> =
        [R2_D1, CASCADE, SLOPES, FAR_CASCADE, FAR].map(|i| settings[i].name.as_str());
    let of = |row: &Row, setting: &str| {
        let same = |r: &&Row| (r.scene, r.walls) == (row.scene, row.walls);
        let found = rows.iter().filter(same).find(|r| r.setting == setting);
        found.cloned()
    };
    let scenes: Vec<&Row> = rows.iter().filter(|r| r.setting == named[0]).collect();
    let cells = |row: &&Row, value: Value| -> Vec<String> {
        let at = |setting: &&str| of(row, setting).map_or(String::new(), |r| fixed(value(&r), 2));
        named.iter().map(at).collect()
    };
    let table = |study: &mut Study, caption: &str, value: Value| {
        let mut head = vec!["scene", "walls", "longest wall", "links"];
        head.extend(named);
        let line = |row: &&Row| {
            let mut line = vec![
                row.scene.into(),
                row.walls.into(),
                fixed(row.longest_wall, 0),
                row.links.to_string(),
            ];
            line.extend(cells(row, value));
            line
        };
        study.table(caption, &head, scenes.iter().map(line));
    };
    table(
        &mut study,
        "Mean error of the level [dB]; a link without a path counts 40 dB",
        |r| r.mean_error_db,
    );
    table(&mut study, "Median error of the level [dB]", |r| {
        r.median_error_db
    });
    table(
        &mut study,
        "Mean error of the strongest direction of an array of 16 [deg], where there is a path",
        |r| r.mean_direction_error_deg,
    );
    shadow(&mut study, &named, &scenes, &of);
    if !beyond.is_empty() {
        orders(&mut study, rows, beyond);
    }
    parts(&mut study, &named, &scenes, &of);
    boundaries(&mut study, &named, links);
    study.section.heading("Error against time");
    for walls in Walls::ALL {
        trade(&mut study, settings, rows, walls.name());
    }
    figures(&mut study, &named, rows, links);
    verdict(&mut study, &named, rows);
    study.data("scenes", "Every setting in every scene", rows)?;
    if !beyond.is_empty() {
        study.data("orders", "Higher limits in the canyon", beyond)?;
    }
    Ok(study)
}

/// The rows of each scene at four settings, where all of them are there.
fn at_settings(
    settings: [usize; 4],
    named: &Named<'_>,
    scenes: &[&Row],
    of: &impl Fn(&Row, &str) -> Option<Row>,
) -> Vec<[Row; 4]> {
    let rows = |row: &&Row| {
        let [p, q, r, s] = settings.map(|i| of(row, named[i]));
        Some([p?, q?, r?, s?])
    };
    scenes.iter().filter_map(rows).collect()
}

fn shadow(
    study: &mut Study,
    named: &Named<'_>,
    scenes: &[&Row],
    of: &impl Fn(&Row, &str) -> Option<Row>,
) {
    study.section.heading("In the shadow of two corners");
    // Without and with slopes, then the same of far limits.
    let all = at_settings([CASCADE, SLOPES, FAR_CASCADE, FAR], named, scenes, of);
    let missing = |row: &Row| row.two_corners_missing.to_string();
    let mean = |row: &Row| fixed(row.two_corners_mean_error_db, 2);
    let median = |row: &Row| fixed(row.two_corners_median_error_db, 2);
    study.columns(
        "Links whose strongest path has two corners, R5 D2 and 30 dB, without and with slopes",
        all.iter().filter(|r| r[1].two_corners > 0),
        &[
            ("scene", &|r| r[1].scene.into()),
            ("walls", &|r| r[1].walls.into()),
            ("links", &|r| r[1].two_corners.to_string()),
            ("no path, without slopes", &|r| missing(&r[0])),
            ("with", &|r| missing(&r[1])),
            ("mean error [dB], without", &|r| mean(&r[0])),
            ("with", &|r| mean(&r[1])),
            ("median error [dB], without", &|r| median(&r[0])),
            ("with", &|r| median(&r[1])),
            ("time with / without", &|r| {
                fixed(r[1].time_us / r[0].time_us, 2)
            }),
            ("R8 D3, 40 dB: mean error, without", &|r| mean(&r[2])),
            ("with", &|r| mean(&r[3])),
        ],
    );
}

fn orders(study: &mut Study, rows: &[Row], beyond: &[Row]) {
    let range_db = beyond.first().and_then(|row| row.dynamic_range_db);
    let limits = |row: &Row| (row.max_reflections, row.max_diffractions);
    let far = rows
        .iter()
        .filter(|r| r.scene == CANYON && r.max_diffractions > 2);
    let all: Vec<&Row> = far
        .chain(beyond)
        .filter(|r| r.dynamic_range_db == range_db)
        .collect();
    let line = |row: &&&Row| -> Vec<String> {
        let at = |walls: Walls, slopes: bool| {
            let same =
                |r: &&&Row| (limits(r), r.slopes, r.walls) == (limits(row), slopes, walls.name());
            let found = all.iter().find(same);
            found.map_or(String::new(), |r| fixed(r.two_corners_mean_error_db, 2))
        };
        let cells = Walls::ALL
            .into_iter()
            .flat_map(|walls| [false, true].map(|slopes| at(walls, slopes)));
        let (r, d) = limits(row);
        std::iter::once(format!("R{r} D{d}")).chain(cells).collect()
    };
    let head = Walls::ALL.map(|walls| [format!("{}, without", walls.name()), "with".into()]);
    let head: Vec<&str> = std::iter::once("limits")
        .chain(head.iter().flatten().map(String::as_str))
        .collect();
    let first = |row: &&&Row| !row.slopes && row.walls == Walls::Conductor.name();
    study.table(
        "The same mean error [dB] in the canyon as limits grow, at 40 dB, without and with slopes",
        &head,
        all.iter().filter(first).map(|row| line(&row)),
    );
}

fn parts(
    study: &mut Study,
    named: &Named<'_>,
    scenes: &[&Row],
    of: &impl Fn(&Row, &str) -> Option<Row>,
) {
    study.section.heading("Parts of the error");
    let step = |r: &[Row; 4], i: usize| fixed(r[i].mean_error_db - r[i + 1].mean_error_db, 2);
    let rest = |r: &[Row; 4]| r[3].mean_error_of_its_material_db;
    let of_gamma = |r: &[Row; 4]| fixed(r[3].mean_error_db - rest(r), 2);
    let of_rest = |r: &[Row; 4]| fixed(rest(r), 2);
    study.columns(
        "Mean error of the level [dB], and what of it goes with each step; negative where it grows",
        &at_settings([R2_D1, CASCADE, SLOPES, FAR], named, scenes, of),
        &[
            ("scene", &|r| r[0].scene.into()),
            ("walls", &|r| r[0].walls.into()),
            ("R2 D1", &|r| fixed(r[0].mean_error_db, 2)),
            ("orders up to R5 D2", &|r| step(r, 0)),
            ("slopes", &|r| step(r, 1)),
            ("orders up to R8 D3", &|r| step(r, 2)),
            ("Gamma of the reference", &of_gamma),
            ("rest: UTD, of concrete with Luebbers' Gamma", &of_rest),
        ],
    );
}

fn boundaries(study: &mut Study, named: &Named<'_>, links: &[LinkRow]) {
    study.section.heading("Distance to the boundaries");
    let mut rows = Vec::new();
    for walls in Walls::ALL {
        for corners in [1, 2] {
            let mut low = 0.0;
            for high in BOUNDARIES {
                let is_own = |r: &&LinkRow| {
                    r.walls == walls.name()
                        && r.corners.min(2) == corners
                        && r.boundary.is_some_and(|b| (low..high).contains(&b))
                };
                let own: Vec<&LinkRow> = links.iter().filter(is_own).collect();
                let error = |of: fn(&LinkRow) -> f64| {
                    let errors: Vec<f64> = own.iter().map(|r| of(r).abs()).collect();
                    fixed(mean(&errors), 2)
                };
                let directions: Vec<f64> = own.iter().filter_map(|r| r.direction_deg).collect();
                let range = if high.is_finite() {
                    format!("{low} to {high}")
                } else {
                    format!("{low} and more")
                };
                if !own.is_empty() {
                    rows.push(vec![
                        walls.name().into(),
                        if corners == 1 { "one" } else { "two or more" }.into(),
                        range,
                        own.len().to_string(),
                        error(|r| r.cascade_db),
                        error(|r| r.slopes_db),
                        error(|r| r.far_db),
                        directions.len().to_string(),
                        fixed(mean(&directions), 1),
                    ]);
                }
                low = high;
            }
        }
    }
    let head = [
        "walls",
        "corners of the strongest path",
        "sqrt(2 k L) sin(delta / 2)",
        "links",
        named[CASCADE],
        named[SLOPES],
        named[FAR],
        "arrays",
        "their direction with slopes [deg]",
    ];
    study.table(
        "Mean error of the level [dB] by the distance of the strongest path from the nearest boundary of its corners; the transition region ends at about 3",
        &head,
        rows,
    );
}

/// Means over the scenes that are no series of sizes.
fn over_scenes(rows: &[Row], walls: &str, setting: &str, value: Value) -> Option<f64> {
    let is_own = |r: &&Row| r.walls == walls && r.setting == setting && !r.scene.starts_with(SIZES);
    let own: Vec<f64> = rows.iter().filter(is_own).map(value).collect();
    (!own.is_empty()).then(|| mean(&own))
}

fn trade(study: &mut Study, settings: &[Setting], rows: &[Row], walls: &str) {
    let mut trade = Trade::default();
    let mut lines = Vec::new();
    for setting in settings {
        let at = |value: Value| over_scenes(rows, walls, &setting.name, value);
        let (Some(time), Some(error), Some(direction), Some(paths)) = (
            at(|r| r.time_us),
            at(|r| r.mean_error_db),
            at(|r| r.mean_direction_error_deg),
            at(|r| r.paths_per_link),
        ) else {
            continue;
        };
        let group = match setting.config.slope_diffraction {
            true => "with slopes",
            false => "without",
        };
        trade.add(group, &setting.name, time, error);
        lines.push(vec![
            setting.name.clone(),
            three_digits(time),
            three_digits(paths),
            fixed(error, 2),
            fixed(direction, 2),
        ]);
    }
    let head = [
        "setting",
        "time a link [us]",
        "paths",
        "error [dB]",
        "direction [deg]",
    ];
    study.table(
        format!("Walls of {walls}: means over the scenes but the blocks alone"),
        &head,
        lines,
    );
    let chart = trade.chart("time a link [us]", "mean error [dB]", 0.1, |_| true);
    study.figure(
        &format!("time-{walls}"),
        format!("Mean error of the level against time a link, walls of {walls}. Grey: the front."),
        chart.draw(),
    );
}

fn figures(study: &mut Study, named: &Named<'_>, rows: &[Row], links: &[LinkRow]) {
    study
        .section
        .heading("Size of the house, and a line behind two");
    let size = |walls: Walls| -> Vec<[f64; 2]> {
        let is_own = |r: &&Row| {
            r.walls == walls.name() && r.scene.starts_with(SIZES) && r.setting == named[R2_D1]
        };
        let own = rows.iter().filter(is_own);
        own.map(|r| [r.longest_wall, r.mean_error_db]).collect()
    };
    let chart = Chart::new(
        Axis::log("longest wall [wavelengths]"),
        Axis::log("mean error [dB]"),
    )
    .sized(640.0, 320.0);
    let chart = Walls::ALL
        .into_iter()
        .fold(chart, |chart, walls| chart.line(walls.name(), size(walls)));
    study.figure(
        "size",
        "Mean error of the level around one house at R2 D1 against its size, everything else in proportion.",
        chart.draw(),
    );
    for walls in Walls::ALL {
        let is_own = |r: &&LinkRow| {
            r.scene == "behind" && r.walls == walls.name() && r.source == 0 && r.y == 24.3
        };
        let line = |value: fn(&LinkRow) -> f64| -> Vec<[f64; 2]> {
            let own = links.iter().filter(is_own);
            own.map(|r| [r.x, r.level_db + value(r)]).collect()
        };
        let series = |i: usize, name: &str, points: Vec<[f64; 2]>, dashed: bool| {
            Series::new(name, Colour::Series(i), Mark::Line { points, dashed })
        };
        let chart = Chart::new(
            Axis::linear("x [wavelengths]"),
            Axis::linear("level over free space [dB]"),
        )
        .sized(640.0, 380.0)
        .with(series(0, "the field", line(|_| 0.0), false))
        .with(series(1, named[CASCADE], line(|r| r.cascade_db), true))
        .with(series(2, named[SLOPES], line(|r| r.slopes_db), false));
        study.figure(
            &format!("behind-{}", walls.name()),
            format!(
                "Along a line behind two blocks one behind the other, walls of {}. A link without a path is drawn 40 dB below the field.",
                walls.name()
            ),
            chart.draw(),
        );
    }
}

fn verdict(study: &mut Study, named: &Named<'_>, rows: &[Row]) {
    let sums = |setting: usize| {
        let own = rows
            .iter()
            .filter(|r| r.setting == named[setting] && r.two_corners > 0);
        own.fold((0.0, 0.0), |(error, time), r| {
            (
                error + r.two_corners_mean_error_db * r.two_corners as f64,
                time + r.time_us,
            )
        })
    };
    let links: usize = rows
        .iter()
        .filter(|r| r.setting == named[SLOPES])
        .map(|r| r.two_corners)
        .sum();
    let (without, with) = (sums(CASCADE), sums(SLOPES));
    let gain_db = (without.0 - with.0) / links.max(1) as f64;
    let ratio = with.1 / without.1;
    study.section.verdict(Verdict::decided(
        gain_db >= 3.0 && ratio < 1.3,
        "Slopes bring the mean error in the shadow of two corners down by 3 dB or more at less than 1.3 times the time",
        format!("{} dB over {links} links, {} times the time", fixed(gain_db, 2), fixed(ratio, 2)),
    ));
}
