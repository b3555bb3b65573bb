//! Single links: the map, the truth and the predictions.

use aps_label::Protocol;
use aps_metrics::Metric;
use aps_raytrace::glam::DVec2;

use super::analysis::Analysis;
use super::figures::{colour, svg};
use super::results::Example;
use super::words;
use crate::chart::{Axis, Chart, Mark, Series};
use crate::document::Figure;
use crate::link::LinkView;
use crate::numbers;
use crate::picture::{self, Outlines};
use crate::theme::Colour;

/// The paper's two zones, with the entries compared with the truth in each.
const ZONES: [(&str, &str, [&str; 4]); 2] = [
    (
        "main",
        "main comparison",
        ["MS-AReg", "RadioUNet", "ResNet-MLP", "ResNet-Conv1D"],
    ),
    (
        "ablation",
        "ablation",
        ["MS-AReg", "ResNet-MLP", "Adv-MLP", "MS-MLP"],
    ),
];

/// Map, main zone and ablation zone of a link; predictions of no zone come last.
pub fn figures(
    analysis: &Analysis<'_>,
    protocol: &str,
    number: usize,
    example: &Example,
) -> Vec<Figure> {
    let stem = format!(
        "example-{}-{}",
        number + 1,
        numbers::stem(&example.difficulty)
    );
    let mut figures = vec![Figure::new(
        svg(&format!("{stem}-map")),
        format!(
            "Link {} ({}): {}.",
            number + 1,
            example.difficulty,
            place(analysis, example)
        ),
        map(example),
    )];
    let in_no_zone: Vec<&str> = example
        .predictions
        .iter()
        .map(|p| p.entry.as_str())
        .filter(|name| !ZONES.iter().any(|z| z.2.contains(name)))
        .collect();
    let zones = ZONES
        .iter()
        .map(|(key, title, names)| (*key, *title, names.to_vec()));
    for (key, title, names) in zones.chain([("others", "others", in_no_zone)]) {
        let Some(chart) = zone(analysis, example, &names) else {
            continue;
        };
        figures.push(Figure::new(
            svg(&format!("{stem}-{key}")),
            format!(
                "Link {}, {title}: {}",
                number + 1,
                scores(analysis, protocol, example, &names)
            ),
            chart.draw(),
        ));
    }
    figures
}

fn map(example: &Example) -> crate::drawing::Drawing {
    let point = |[x, y]: [f64; 2]| DVec2::new(x, y);
    let ring = |ring: &Vec<[f64; 2]>| ring.iter().copied().map(point).collect();
    let outlines = Outlines {
        rings: example.buildings.iter().map(ring).collect(),
        area: None,
    };
    let link = LinkView {
        tx: point(example.tx_m),
        rx: point(example.rx_m),
        paths: Vec::new(),
    };
    picture::map(&outlines, &link, &[], 340.0)
}

fn place(analysis: &Analysis<'_>, example: &Example) -> String {
    let link = &analysis.results.links[example.link];
    let sight = if link.line_of_sight {
        "in sight"
    } else {
        "out of sight"
    };
    format!(
        "map {}, transmitter {}, receiver {}, {} m apart, {sight}; {} dominant peak{} in the truth",
        link.map,
        link.tx,
        link.rx,
        numbers::fixed(link.distance_m, 0),
        link.dominant_peaks,
        if link.dominant_peaks == 1 { "" } else { "s" }
    )
}

/// Truth and predictions over the angle; none if nothing of the names was predicted.
fn zone(analysis: &Analysis<'_>, example: &Example, names: &[&str]) -> Option<Chart> {
    let protocol: Protocol = analysis.results.data.protocol.parse().ok()?;
    let axis = protocol.angle_axis_deg();
    let line = |values: &[f64], dashed: bool| Mark::Line {
        points: aps_label::Axis {
            count: values.len(),
            ..axis
        }
        .values()
        .zip(values)
        .map(|(x, &y)| [x, y])
        .collect(),
        dashed,
    };
    let axes = (picture::azimuth(protocol), Axis::linear("normalised power"));
    let mut chart = Chart::new(axes.0, axes.1).sized(480.0, 340.0);
    chart = chart.with(Series::new(
        "truth",
        Colour::Ink,
        line(&example.truth, false),
    ));
    for name in names {
        let (Some(prediction), Some(entry)) = (
            example.predictions.iter().find(|p| p.entry == *name),
            analysis.entry(name),
        ) else {
            continue;
        };
        chart = chart.with(Series::new(
            *name,
            colour(analysis, entry),
            line(&prediction.spectrum, true),
        ));
    }
    (chart.series.len() > 1).then_some(chart)
}

fn scores(analysis: &Analysis<'_>, protocol: &str, example: &Example, names: &[&str]) -> String {
    let score = |name: &&str| {
        let entry = analysis.entry(name)?;
        let of = |metric| Some(analysis.column(entry, protocol, metric)?[example.link]);
        Some(format!(
            "{name} CosSim {}, PLE {} deg",
            words::value(Metric::Cosine, of(Metric::Cosine)?),
            words::value(Metric::PleDeg, of(Metric::PleDeg)?)
        ))
    };
    let scores: Vec<String> = names.iter().filter_map(score).collect();
    format!("{}.", scores.join("; "))
}
