//! The map with terminals and paths.

use aps_data::InteractionKind;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;
use svg::node::element::path::Data;
use svg::node::element::{Group, Path, Rectangle, Title};

use super::Outlines;
use crate::chart::{Labels, badge};
use crate::drawing::{Drawing, anchored, circle, line, linked, plain, px, through, words};
use crate::link::{LinkView, PathView};
use crate::theme::Colour;

/// A path as drawn; those first in a list lie below.
#[derive(Debug, Clone)]
pub struct Ray<'a> {
    /// The path.
    pub path: &'a PathView,
    /// Its colour.
    pub colour: Colour,
    /// Width of the line \[px\].
    pub width: f64,
    /// Shown on the ray near the receiver.
    pub number: Option<String>,
    /// Links the ray to other pictures: value of its `data-path`.
    pub link: Option<String>,
}

/// Draws the map into a square of `side` px, y upwards.
pub fn draw(outlines: &Outlines, link: &LinkView, rays: &[Ray<'_>], side: f64) -> Drawing {
    let frame = Frame::new(outlines, link, side);
    let ground = Rectangle::new()
        .set("width", side)
        .set("height", side)
        .set("class", "ground");
    let mut group = Group::new().add(ground).add(buildings(outlines, &frame));
    let (tx, rx) = (frame.place(link.tx), frame.place(link.rx));
    let mut labels = Labels::inside(0.0, 0.0, side, side);
    let terminals = Group::new()
        .add(terminal("Tx", Colour::Series(1), tx, rx, side, &mut labels))
        .add(terminal("Rx", Colour::Series(0), rx, tx, side, &mut labels));
    let mut badges = Group::new();
    for ray in rays {
        let way = places(link, ray.path, &frame);
        group = group.add(linked(draw_ray(ray, &way), ray.link.as_deref()));
        if let Some(number) = &ray.number {
            let (x, y) = labels.among(&along(&way));
            let badge = badge(x, y, number, ray.colour, false);
            badges = badges.add(linked(badge, ray.link.as_deref()));
        }
    }
    let group = group.add(badges).add(terminals).add(ruler(&frame));
    let (tx, rx, count) = (link.tx, link.rx, rays.len());
    let label = format!(
        "map with transmitter at ({:.1}, {:.1}) m, receiver at ({:.1}, {:.1}) m and {count} paths",
        tx.x, tx.y, rx.x, rx.y
    );
    Drawing::new(group, side, side, label)
}

/// From metres to pixels.
struct Frame {
    min: DVec2,
    pixels_per_metre: f64,
    side: f64,
}

impl Frame {
    fn new(outlines: &Outlines, link: &LinkView, side: f64) -> Self {
        let area = outlines.area.unwrap_or_else(|| {
            let points = || {
                let corners = outlines.rings.iter().flatten().copied();
                corners.chain([link.tx, link.rx])
            };
            Area {
                min: points().fold(link.tx, DVec2::min),
                max: points().fold(link.tx, DVec2::max),
            }
        });
        let extent = (area.max - area.min).max_element().max(1.0);
        Self {
            min: area.min,
            pixels_per_metre: side / extent,
            side,
        }
    }

    fn place(&self, p: DVec2) -> (f64, f64) {
        let r = (p - self.min) * self.pixels_per_metre;
        (px(r.x), px(self.side - r.y))
    }
}

fn buildings(outlines: &Outlines, frame: &Frame) -> Path {
    let data = outlines.rings.iter().fold(Data::new(), |data, ring| {
        through(data, ring.iter().map(|&p| Some(frame.place(p)))).close()
    });
    Path::new().set("d", data).set("class", "house")
}

/// The corners of a path \[px\].
fn places(link: &LinkView, path: &PathView, frame: &Frame) -> Vec<(f64, f64)> {
    let bends = path.bends.iter().map(|bend| bend.point);
    let points = [link.tx].into_iter().chain(bends).chain([link.rx]);
    points.map(|p| frame.place(p)).collect()
}

fn draw_ray(ray: &Ray<'_>, places: &[(f64, f64)]) -> Group {
    let data = through(Data::new(), places.iter().copied().map(Some));
    let (name, length_m) = (ray.path.name(), ray.path.length_m());
    let title = format!("{name}, {:.1} dB, {length_m:.1} m", ray.path.gain_db);
    let line = Path::new()
        .set("d", data)
        .set("class", format!("line {}", ray.colour.stroke()))
        .set("style", format!("stroke-width:{}px", px(ray.width)))
        .add(Title::new(plain(&title)));
    let mut group = Group::new().add(line);
    for (bend, &(x, y)) in ray.path.bends.iter().zip(&places[1..]) {
        let kind = match bend.kind {
            InteractionKind::Reflection => "reflection",
            InteractionKind::Diffraction | InteractionKind::Other(_) => "diffraction",
        };
        group = group.add(circle(x, y, 2.0).set("class", format!("bend {kind}")));
    }
    group
}

/// Places along a way from its end on, near the end first.
fn along(way: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut found = Vec::new();
    let mut next = 30.0;
    let mut walked = 0.0;
    for leg in way.windows(2).rev() {
        let ((x0, y0), (x1, y1)) = (leg[1], leg[0]);
        let length = (x1 - x0).hypot(y1 - y0);
        while next <= walked + length && found.len() < 60 {
            let t = (next - walked) / length;
            found.push((x0 + t * (x1 - x0), y0 + t * (y1 - y0)));
            next += 9.0;
        }
        walked += length;
    }
    if found.is_empty() {
        let ((x0, y0), (x1, y1)) = (way[way.len() - 1], way[way.len() - 2]);
        found.push(((x0 + x1) / 2.0, (y0 + y1) / 2.0));
    }
    found
}

/// The name stands on the side away from the other end.
fn terminal(
    name: &str,
    colour: Colour,
    at: (f64, f64),
    other: (f64, f64),
    side: f64,
    labels: &mut Labels,
) -> Group {
    let (x, y) = at;
    let is_left = (x < other.0 && x > 30.0) || x > side - 30.0;
    let is_above = (y < other.1 && y > 24.0) || y > side - 12.0;
    let (dx, anchor) = match is_left {
        true => (-9.0, "end"),
        false => (9.0, "start"),
    };
    let dy = if is_above { -7.0 } else { 17.0 };
    labels.dot(at);
    labels.text(x + dx, y + dy, name, anchor);
    let text = anchored(name, x + dx, y + dy, anchor);
    Group::new()
        .add(circle(x, y, 7.0).set("class", "paper"))
        .add(circle(x, y, 5.5).set("class", colour.fill()))
        .add(text.set("class", format!("title halo {}", colour.fill())))
}

fn ruler(frame: &Frame) -> Group {
    // A round length of about a fifth of the picture.
    let fifth = 0.2 * frame.side / frame.pixels_per_metre;
    let power = 10_f64.powf(fifth.log10().floor());
    let mut lengths = [5.0, 2.0, 1.0].map(|m| m * power).into_iter();
    let length = lengths.find(|&l| l <= fifth).unwrap_or(power);
    let (y, end) = (frame.side - 12.0, 12.0 + length * frame.pixels_per_metre);
    let text = words(&format!("{length} m"), 13.0, y - 6.0);
    Group::new()
        .add(line(12.0, y, end, y, "line stroke-ink"))
        .add(text.set("class", "small halo"))
}
