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
use crate::drawing::{Drawing, at, words};
use crate::link::{LinkView, PathView, Spectrum, angle_deg, mirror_deg};
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

/// Adds to a spectrum a stem for each path, as high as its gain, and a dashed one for its mirror image if the array makes one.
pub fn stems_by_gain(
    mut chart: Chart,
    link: &LinkView,
    scale: &GainScale,
    sense: Protocol,
    has_mirrors: bool,
) -> Chart {
    for ray in rays_by_gain(link, scale) {
        let stems = stems(ray.path, ray.colour, sense, has_mirrors);
        chart = stems.fold(chart, Chart::with);
    }
    chart
}

/// The stem of a path in a spectrum, and a dashed one before it for the mirror image if it has one.
pub fn stems(
    path: &PathView,
    colour: Colour,
    sense: Protocol,
    has_mirror: bool,
) -> impl Iterator<Item = Series> {
    let (own, gain_db) = (angle_deg(path.arrival_azimuth_rad, sense), path.gain_db);
    let mirror = has_mirror.then(|| Series::stem(colour, [mirror_deg(own), gain_db], true));
    mirror
        .into_iter()
        .chain([Series::stem(colour, [own, gain_db], false)])
}

/// Map and paths to the left, APS to the right; no spectrum for a link without label. `has_mirrors` tells if the array shows
/// each path twice.
pub fn link(
    outlines: &Outlines,
    link: &LinkView,
    spectrum: Option<&Spectrum>,
    has_mirrors: bool,
) -> Drawing {
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
    chart = stems_by_gain(chart, link, &scale, protocol, has_mirrors);
    if let Some(spectrum) = spectrum {
        let mut curve = curve(spectrum, protocol, Colour::Ink);
        curve.name.clear();
        chart = chart.with(curve);
    }
    let chart = chart.draw();
    let ((width, height), (more, other)) = (city.size(), chart.size());
    let below = (height + 40.0).max(other + 16.0);
    let mut content = Group::new()
        .add(at(10.0, 30.0, city.into_content()))
        .add(at(width + 20.0, 10.0, chart.into_content()))
        .add(scale.key(10.0 + width, 10.0));
    let label = "a map with all paths of a link, and the angle power spectrum they make";
    if !link.paths.is_empty() {
        let bends = "open dots: reflections; filled dots: diffractions";
        let stems = match has_mirrors {
            true => {
                "stems: paths; dashed: their mirror images, which a linear array cannot tell from them"
            }
            false => "stems: paths",
        };
        for (text, x) in [(bends, 10.0), (stems, width + 84.0)] {
            content = content.add(words(text, x, below + 8.0).set("class", "small"));
        }
    }
    Drawing::new(content, width + more + 24.0, below + 20.0, label)
}
