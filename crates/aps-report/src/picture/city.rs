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

/// Room around the mapped area, so that a terminal at its border is seen whole \[px\].
const MARGIN: f64 = 12.0;

/// Room for the name of a terminal: from its middle to the side, up and down \[px\].
const NAME: [f64; 3] = [34.0, 21.0, 22.0];

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
    let ruler = ruler(&frame, [tx, rx], &mut labels);
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
    let group = group.add(badges).add(terminals).add(ruler);
    let (tx, rx, count) = (link.tx, link.rx, rays.len());
    let label = format!(
        "map with transmitter at ({:.1}, {:.1}) m, receiver at ({:.1}, {:.1}) m and {count} paths",
        tx.x, tx.y, rx.x, rx.y
    );
    Drawing::new(group, side, side, label)
}

/// Map from metres to pixels.
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
        let inside = (side - 2.0 * MARGIN).max(1.0);
        let pixels_per_metre = inside / (area.max - area.min).max_element().max(1.0);
        // The area lies in the middle, whatever its shape.
        let middle = (area.min + area.max) / 2.0;
        Self {
            min: middle - 0.5 * side / pixels_per_metre,
            pixels_per_metre,
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

/// The name stands on the side away from the other end, if there is room.
fn terminal(
    name: &str,
    colour: Colour,
    at: (f64, f64),
    other: (f64, f64),
    side: f64,
    labels: &mut Labels,
) -> Group {
    let (x, y) = at;
    let [beside, above, below] = NAME;
    let is_left = (x < other.0 && x > beside) || x > side - beside;
    let is_above = (y < other.1 && y > above) || y > side - below;
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

/// A round length, in the corner that is farthest from the terminals.
fn ruler(frame: &Frame, terminals: [(f64, f64); 2], labels: &mut Labels) -> Group {
    // About a fifth of the picture.
    let fifth = 0.2 * frame.side / frame.pixels_per_metre;
    let power = 10_f64.powf(fifth.log10().floor());
    let mut lengths = [5.0, 2.0, 1.0].map(|m| m * power).into_iter();
    let length = lengths.find(|&l| l <= fifth).unwrap_or(power);
    let side = frame.side;
    let away = |&(x, y): &(f64, f64)| {
        let away = terminals.map(|t| (t.0 - x).hypot(t.1 - y));
        away[0].min(away[1])
    };
    let corners = [(0.0, side), (side, side), (0.0, 0.0), (side, 0.0)];
    // Reversed: of two that are as far the first is taken, as people look for it there.
    let corners = corners.into_iter().rev();
    let (x, y) = corners
        .max_by(|a, b| away(a).total_cmp(&away(b)))
        .unwrap_or((0.0, side));
    let width = length * frame.pixels_per_metre;
    let left = if x > 0.0 { side - 12.0 - width } else { 12.0 };
    let base = if y > 0.0 { side - 12.0 } else { 26.0 };
    let name = format!("{length} m");
    labels.line(left, base, left + width, base);
    labels.text(left + 1.0, base - 6.0, &name, "start");
    let text = words(&name, left + 1.0, base - 6.0);
    Group::new()
        .add(line(left, base, left + width, base, "line stroke-ink"))
        .add(text.set("class", "small halo"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of an attribute of all elements of a name.
    fn numbers(text: &str, name: &str, attribute: &str) -> Vec<f64> {
        let document = roxmltree::Document::parse(text).unwrap();
        let nodes = document.descendants().filter(|n| n.has_tag_name(name));
        let values = nodes.filter_map(|n| n.attribute(attribute)?.parse().ok());
        values.collect()
    }

    #[test]
    fn terminals_at_the_border_are_seen_whole_and_free_of_the_scale() {
        let area = Area {
            min: DVec2::ZERO,
            max: DVec2::new(256.0, 200.0),
        };
        let outlines = Outlines {
            rings: Vec::new(),
            area: Some(area),
        };
        let side = 300.0;
        let ends = [
            (0.0, 0.0),
            (0.0, 200.0),
            (256.0, 0.0),
            (256.0, 200.0),
            (128.0, 9.0),
        ];
        for (tx, rx) in ends.iter().flat_map(|tx| ends.map(|rx| (*tx, rx))) {
            let link = LinkView {
                tx: tx.into(),
                rx: rx.into(),
                paths: Vec::new(),
            };
            let text = draw(&outlines, &link, &[], side).to_file_text();
            let [x, y] = ["cx", "cy"].map(|place| numbers(&text, "circle", place));
            assert_eq!((x.len(), y.len()), (4, 4));
            let is_inside = |&v: &f64| (7.0..=side - 7.0).contains(&v);
            assert!(x.iter().chain(&y).all(is_inside), "{x:?} {y:?}");
            let names = numbers(&text, "text", "y");
            assert!(
                names.iter().all(|y| (13.0..=side - 4.0).contains(y)),
                "{names:?}"
            );
            let [left, right, base] = ["x1", "x2", "y1"].map(|at| numbers(&text, "line", at)[0]);
            for (x, y) in x.into_iter().zip(y) {
                let nearest = (x.clamp(left, right), y.clamp(base - 18.0, base));
                assert!((x - nearest.0).hypot(y - nearest.1) > 10.0, "{tx:?} {rx:?}");
            }
        }
    }
}
