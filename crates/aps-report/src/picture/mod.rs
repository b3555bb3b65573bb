//! Pictures of links: the map with its paths, and the spectra they make.

mod city;
mod outline;
mod spectrum;
mod strength;

use aps_label::Protocol;
use svg::node::element::Group;

pub use city::{Ray, draw as map};
pub use outline::Outlines;
pub use spectrum::{axes, azimuth, curve, delay_chart};
pub use strength::GainScale;

use crate::chart::{Chart, Series};
use crate::drawing::{Drawing, at};
use crate::link::{LinkView, Spectrum, angle_deg};
use crate::theme::Colour;

/// Side of the map in a picture \[px\].
const SIDE: f64 = 520.0;

/// Makes rays of all paths of a link, coloured by their gain, weak ones below.
pub fn rays_by_gain<'a>(link: &'a LinkView, scale: &GainScale) -> Vec<Ray<'a>> {
    let ray = |path| Ray {
        path,
        colour: scale.colour(path.gain_db),
        width: scale.width(path.gain_db),
        number: None,
        link: None,
    };
    let mut rays: Vec<Ray<'a>> = link.paths.iter().map(ray).collect();
    rays.sort_by(|p, q| p.path.gain_db.total_cmp(&q.path.gain_db));
    rays
}

/// Adds to a spectrum a stem for each path, as high as its gain.
pub fn stems_by_gain(chart: Chart, link: &LinkView, scale: &GainScale, sense: Protocol) -> Chart {
    let stem = |ray: Ray<'_>| {
        let angle = angle_deg(ray.path.arrival_azimuth_rad, sense);
        Series::stem(ray.colour, [angle, ray.path.gain_db], false)
    };
    let rays = rays_by_gain(link, scale).into_iter();
    rays.map(stem).fold(chart, Chart::with)
}

/// Map and paths to the left, APS to the right; none for a link without label.
pub fn link(outlines: &Outlines, link: &LinkView, spectrum: Option<&Spectrum>) -> Drawing {
    let scale = GainScale::over(&link.paths);
    let city = map(outlines, link, &rays_by_gain(link, &scale), SIDE);
    let protocol = spectrum.map_or(Protocol::Paper, |s| s.protocol);
    let title = match spectrum {
        Some(s) => format!("Angle power spectrum, protocol {}", s.protocol),
        None => "No path, no spectrum".into(),
    };
    let top_db = spectrum.map_or(0.0, Spectrum::top_db);
    let mut chart = axes(protocol, top_db, false)
        .titled(title)
        .sized(580.0, SIDE + 24.0);
    chart = stems_by_gain(chart, link, &scale, protocol);
    if let Some(spectrum) = spectrum {
        let mut curve = curve(spectrum, protocol, Colour::Ink);
        curve.name.clear();
        chart = chart.with(curve);
    }
    let chart = chart.draw();
    let ((width, height), (more, other)) = (city.size(), chart.size());
    let content = Group::new()
        .add(at(10.0, 30.0, city.into_content()))
        .add(at(width + 20.0, 10.0, chart.into_content()))
        .add(scale.key(10.0 + width, 10.0));
    let label = "a map with all paths of a link, and the angle power spectrum they make";
    let height = (height + 40.0).max(other + 16.0);
    Drawing::new(content, width + more + 24.0, height, label)
}
