//! Errors next to the shadow boundary.

use std::f64::consts::PI;

use anyhow::Result;
use aps_report::chart::{Axis, Chart, Mark, Series};
use aps_report::numbers::small;
use aps_report::theme::Colour;
use aps_tests::wedge::ExactWedge;
use serde::Serialize;

use super::methods::Method;
use crate::{Setup, Study};

const INTERIOR_DEG: u32 = 90;
const INCIDENT_DEG: f64 = 67.5;
const K_RHO: [f64; 3] = [10.0, 100.0, 1000.0];

#[derive(Debug, Clone, Serialize)]
struct Row {
    method: &'static str,
    k_rho: f64,
    /// Angle beyond the boundary; negative where the source is seen.
    beyond_deg: f64,
    /// Error in parts of the incident field.
    error: f64,
}

pub fn study(setup: &Setup, study: &mut Study) -> Result<()> {
    let steps = setup.profile.choose(6, 60);
    let rows = rows(steps);
    study.section.heading("Distance to the shadow boundary");
    let line = |method: Method, k_rho: f64, side: f64| -> Vec<[f64; 2]> {
        let own = rows
            .iter()
            .filter(|r| r.method == method.name() && r.k_rho == k_rho && r.beyond_deg * side > 0.0);
        own.map(|r| [r.beyond_deg.abs(), r.error]).collect()
    };
    let axes = || {
        Chart::new(
            Axis::log("from the shadow boundary [deg]"),
            Axis::log("error [of the incident field]"),
        )
        .sized(640.0, 380.0)
    };
    let shown = [Method::Utd, Method::ThreePieces, Method::Keller];
    let chart = shown.iter().fold(axes(), |chart, &m| {
        chart.line(m.name(), line(m, 100.0, 1.0))
    });
    study.figure(
        "boundary-methods",
        "Error next to the shadow boundary at k rho = 100, in the shadow of a corner of 90 deg, wave from 67.5 deg off a face.",
        chart.draw(),
    );
    let side = |i: usize, k_rho: f64, (side, name): (f64, &str)| {
        Series::new(
            format!("k rho = {k_rho}, {name}"),
            Colour::Series(i),
            Mark::Line {
                points: line(Method::Utd, k_rho, side),
                dashed: side < 0.0,
            },
        )
    };
    let chart = K_RHO.iter().enumerate().fold(axes(), |chart, (i, &k_rho)| {
        chart
            .with(side(i, k_rho, (1.0, "shadow")))
            .with(side(i, k_rho, (-1.0, "lit")))
    });
    study.figure(
        "boundary-distance",
        "Error of UTD on both sides of the shadow boundary.",
        chart.draw(),
    );
    let worst = |method: Method, k_rho: f64| {
        let is_own = |r: &&Row| r.method == method.name() && r.k_rho == k_rho;
        let errors = rows.iter().filter(is_own).map(|r| r.error);
        small(errors.fold(0.0, f64::max))
    };
    let cells = |method: Method| {
        let mut cells = vec![method.name().to_owned()];
        cells.extend(K_RHO.map(|k_rho| worst(method, k_rho)));
        cells
    };
    let heads = K_RHO.map(|k_rho| format!("k rho = {k_rho}"));
    let head = ["method", &heads[0], &heads[1], &heads[2]];
    let caption = "Largest error within 20 deg of the shadow boundary [of the incident field]";
    study.table(caption, &head, shown.map(cells));
    study.data("boundary", "Errors next to the shadow boundary", &rows)
}

fn rows(steps: usize) -> Vec<Row> {
    let mut rows = Vec::new();
    let incident = INCIDENT_DEG.to_radians();
    for k_rho in K_RHO {
        let exact = ExactWedge::new(INTERIOR_DEG, k_rho);
        for side in [1.0, -1.0] {
            for i in 0..=steps {
                // From 1e-5 deg to 20 deg.
                let beyond_deg = side * 1e-5 * 2e6_f64.powf(i as f64 / steps as f64);
                let phi = PI + incident + beyond_deg.to_radians();
                let truth = exact.field(incident, phi);
                for method in [Method::Utd, Method::ThreePieces, Method::Keller] {
                    let found = method.field(exact.n(), k_rho, incident, phi);
                    rows.push(Row {
                        method: method.name(),
                        k_rho,
                        beyond_deg,
                        error: (found - truth).norm(),
                    });
                }
            }
        }
    }
    rows
}
