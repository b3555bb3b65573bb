//! Errors over distance and wedge angle, and the cost of each method.

use std::f64::consts::PI;

use anyhow::Result;
use aps_report::chart::{Axis, Chart};
use aps_report::document::Verdict;
use aps_report::numbers::{small, three_digits};
use aps_report::trade::Trade;
use aps_tests::wedge::ExactWedge;
use rayon::prelude::*;
use serde::Serialize;

use super::methods::Method;
use crate::{Setup, Stopwatch, Study};

const INTERIOR_DEG: [u32; 6] = [0, 30, 60, 90, 120, 150];
/// Parts of the open angle from which the wave comes.
const INCIDENCE: [f64; 3] = [0.05, 0.25, 0.5];
/// Nearer to a boundary than this the printed formula is a quotient of rounding errors [rad].
const CLEAR_RAD: f64 = 1e-4;
/// Nearer to the face the field itself vanishes, and with it the meaning of decibels [deg].
const OFF_FACE_DEG: f64 = 5.0;
/// Distance at which methods are compared.
const COMPARED_AT: f64 = 100.0;
/// Directions nearer to a boundary than this are where a theory without transition function fails [deg].
const NEAR_DEG: f64 = 10.0;

#[derive(Debug, Clone, Serialize)]
struct Row {
    method: &'static str,
    interior_deg: u32,
    k_rho: f64,
    /// Largest error in any direction, in parts of the incident field.
    worst_error: Option<f64>,
    /// Largest error of the level in the shadow.
    shadow_error_db: Option<f64>,
    /// Largest error more than 10 deg from the shadow boundary.
    deep_shadow_error_db: Option<f64>,
}

/// Directions of one wedge: incidence and observation [rad].
fn directions(n: f64, count: usize) -> Vec<(f64, f64)> {
    let open = n * PI;
    let mut all = Vec::new();
    for part in INCIDENCE {
        let incident = part * open;
        let boundaries = [
            PI + incident,
            PI - incident,
            (2.0 * n - 1.0) * PI - incident,
        ];
        let spread = (0..count).map(|i| (i as f64 + 0.5) / count as f64 * open);
        let beside = boundaries
            .iter()
            .flat_map(|b| [-0.01, -0.001, 0.001, 0.01].map(|d| b + d));
        let is_clear = |phi: &f64| {
            *phi > 0.0 && *phi < open && boundaries.iter().all(|b| (phi - b).abs() > CLEAR_RAD)
        };
        all.extend(
            spread
                .chain(beside)
                .filter(is_clear)
                .map(|phi| (incident, phi)),
        );
    }
    all
}

pub fn study(setup: &Setup, study: &mut Study) -> Result<()> {
    let distances: Vec<f64> = match setup.profile.choose(true, false) {
        true => vec![10.0, COMPARED_AT],
        false => (0..=12).map(|i| 10_f64.powf(f64::from(i) / 4.0)).collect(),
    };
    let count = setup.profile.choose(12, 120);
    let cases: Vec<(u32, f64)> = INTERIOR_DEG
        .into_iter()
        .flat_map(|interior| distances.iter().map(move |&k_rho| (interior, k_rho)))
        .collect();
    let rows: Vec<Row> = cases
        .par_iter()
        .flat_map_iter(|&(i, k)| compare(i, k, count))
        .collect();
    study.section.heading("Distance and wedge angle");
    let of_utd = |interior: u32| -> Vec<[f64; 2]> {
        let own = rows
            .iter()
            .filter(|r| r.method == Method::Utd.name() && r.interior_deg == interior);
        own.filter_map(|r| Some([r.k_rho, r.worst_error?]))
            .collect()
    };
    let chart = Chart::new(
        Axis::log("k rho"),
        Axis::log("largest error [of the incident field]"),
    )
    .sized(640.0, 380.0);
    let chart = INTERIOR_DEG[1..]
        .iter()
        .fold(chart, |chart, &i| chart.line(format!("{i} deg"), of_utd(i)));
    let caption = "Largest error of UTD in any direction against the distance from the edge, by interior angle. A half plane, where UTD is exact, is not drawn.";
    study.figure("distance", caption, chart.draw());
    verdicts(&rows, study);
    study.section.heading("Cheaper theories");
    let times = times(setup, count)?;
    let mut trade = Trade::default();
    let mut table = Vec::new();
    for (method, seconds) in Method::ALL.into_iter().zip(times) {
        let ns = 1e9 * seconds;
        let is_own = |r: &&Row| r.method == method.name() && r.k_rho == COMPARED_AT;
        let worst = |of: fn(&Row) -> Option<f64>| {
            let own = rows.iter().filter(is_own);
            own.filter_map(of).reduce(f64::max)
        };
        let (any, shadow) = (worst(|r| r.worst_error), worst(|r| r.shadow_error_db));
        let deep = worst(|r| r.deep_shadow_error_db);
        if let Some(shadow) = deep {
            trade.add(method.name(), method.name(), ns, shadow);
        }
        let text = |value: Option<f64>| value.map_or("\u{2013}".into(), small);
        table.push(vec![
            method.name().into(),
            three_digits(ns),
            text(any),
            text(shadow),
            text(deep),
        ]);
    }
    let chart = trade.chart(
        "time a field [ns]",
        "largest error far from the boundary [dB]",
        1e-5,
        |_| true,
    );
    let caption = "Largest error of the level in the shadow, far from its boundary, against time. Grey: the front.";
    study.figure("methods-time", caption, chart.draw());
    let head = [
        "method",
        "time a field [ns]",
        "largest error",
        "level in the shadow [dB]",
        "far from the boundary [dB]",
    ];
    let caption = format!(
        "Methods at k rho = {COMPARED_AT}, all wedges; shadow from {OFF_FACE_DEG} deg off the face, far from {NEAR_DEG} deg off the boundary"
    );
    study.table(caption, &head, table);
    study.data("wedges", "Every method, wedge and distance", &rows)
}

fn compare(interior_deg: u32, k_rho: f64, count: usize) -> Vec<Row> {
    let exact = ExactWedge::new(interior_deg, k_rho);
    let n = exact.n();
    let truth: Vec<_> = directions(n, count)
        .into_iter()
        .map(|(incident, phi)| (incident, phi, exact.field(incident, phi)))
        .collect();
    let of_method = |method: Method| {
        let (mut worst, mut shadow, mut deep) = (0.0_f64, 0.0_f64, 0.0_f64);
        for &(incident, phi, field) in &truth {
            let beyond = phi - incident - PI;
            let is_level = method == Method::KnifeEdge;
            if is_level && beyond <= 0.0 {
                continue;
            }
            let found = method.field(n, k_rho, incident, phi);
            worst = worst.max((found - field).norm());
            if beyond > 0.0 && n * PI - phi > OFF_FACE_DEG.to_radians() {
                let error = (20.0 * (found.norm() / field.norm()).log10()).abs();
                shadow = shadow.max(error);
                if beyond > NEAR_DEG.to_radians() {
                    deep = deep.max(error);
                }
            }
        }
        // From 150 deg on no direction is left between boundary and face.
        let seen = |value: f64| (value > 0.0).then_some(value);
        Row {
            method: method.name(),
            interior_deg,
            k_rho,
            worst_error: seen(worst).filter(|_| method != Method::KnifeEdge),
            shadow_error_db: seen(shadow),
            deep_shadow_error_db: seen(deep),
        }
    };
    Method::ALL.into_iter().map(of_method).collect()
}

/// Time of a field by each method [s].
fn times(setup: &Setup, count: usize) -> Result<Vec<f64>> {
    let places = directions(1.5, count);
    let work = |method: &Method| {
        for &(incident, phi) in &places {
            let (n, k_rho) = std::hint::black_box((1.5, COMPARED_AT));
            std::hint::black_box(method.field(n, k_rho, incident, phi));
        }
    };
    Stopwatch::of(setup.profile).each(&Method::ALL, places.len(), work)
}

/// The bounds that the documentation states.
fn verdicts(rows: &[Row], study: &mut Study) {
    let utd = || rows.iter().filter(|r| r.method == Method::Utd.name());
    let half_plane = utd().filter(|r| r.interior_deg == 0);
    let half_plane = half_plane.filter_map(|r| r.worst_error).fold(0.0, f64::max);
    let wedges = utd().filter(|r| r.interior_deg > 0);
    let scaled = wedges
        .filter_map(|r| Some(r.worst_error? * r.k_rho))
        .fold(0.0, f64::max);
    let far = utd().filter(|r| r.k_rho >= 10.0);
    let shadow_db = far.filter_map(|r| r.shadow_error_db).fold(0.0, f64::max);
    let unit = "of the incident field";
    for (claim, value, most, unit) in [
        (
            "error of UTD at a half plane, where it is exact",
            half_plane,
            1e-11,
            unit,
        ),
        ("error of UTD at a wedge, times k rho", scaled, 0.04, unit),
        (
            "level in the shadow from k rho = 10 on",
            shadow_db,
            0.07,
            "dB",
        ),
    ] {
        study
            .section
            .verdict(Verdict::bound(claim, value, most, unit));
    }
}
