//! The explanation as a page, or as one picture.

use svg::node::element::Group;

use super::{Explanation, LOBE_COLUMNS, Listed, PATH_COLUMNS, badge_text};
use crate::chart::{Chart, Mark, Series, badge};
use crate::document::{Block, Document, Figure, Layout, RowMark, Section, Table};
use crate::drawing::{Drawing, at, text_width, words};
use crate::link::{PathView, Side};
use crate::picture::{self, Outlines, Ray};
use crate::theme::Colour;

const LEGEND: &str = "R12 is a reflection at wall 12, D7 a diffraction at corner 7, LoS the line of sight. Shares are of the \
    power at the maximum of the lobe. Paths below a fifth of every lobe are listed only among the strongest.";

/// Links what has no number of its own: pointing at a path dims it too.
const REST: &str = "0";

/// An explanation, ready to be drawn.
#[derive(Debug)]
pub struct Explained<'a> {
    /// The name of the link.
    pub title: &'a str,
    /// The buildings around it.
    pub outlines: &'a Outlines,
    /// The explanation.
    pub explanation: &'a Explanation<'a>,
}

impl Explained<'_> {
    /// A page: map and spectrum side by side, tables of lobes and paths below.
    pub fn page(&self) -> Document {
        let e = self.explanation;
        let mark = |listed: &Listed<'_>| RowMark {
            link: Some(link(listed)),
            colour: Some(listed.colour.to_string()),
        };
        let mut lobes = Table::new("", LOBE_COLUMNS);
        for (cells, cause) in e.lobe_rows() {
            lobes.push_marked(cells, cause.map(mark).unwrap_or_default());
        }
        let mut paths = Table::new("", PATH_COLUMNS);
        for (cells, listed) in e.path_rows() {
            paths.push_marked(cells, mark(listed));
        }
        let caption_map = "Paths that make a lobe in colour, with their numbers; others in grey. \
                           Open dots are reflections, filled dots diffractions.";
        let caption_spectrum = format!(
            "The spectrum under the {} protocol, and dashed under the other. A disc marks the lobe of a path where the path \
             comes from, a ring with a prime its mirror image, with two primes a grating lobe, where the elements of the array \
             cannot tell the path's phases from those of another direction, or a sidelobe; a question mark a lobe that no single path \
             explains. Stems are as high as their path is strong.",
            e.spectrum.protocol
        );
        let spectrum = self.spectrum(480.0, 480.0).draw();
        let figures = [
            Figure::shown(caption_map, self.map(480.0)),
            Figure::shown(caption_spectrum, spectrum),
        ];
        let mut links = Section::new("Lobes and paths");
        let linked = vec![
            Block::Group(Layout::Beside, figures.map(Block::Figure).to_vec()),
            Block::Table(lobes),
            Block::Table(paths),
        ];
        links.blocks.push(Block::Group(Layout::Linked, linked));
        links.text(LEGEND);
        Document::new(self.title)
            .lead(self.summary())
            .lead("Point at a row, a path or a marker to see what belongs together.")
            .section(links)
    }

    /// One picture: map and spectrum side by side, the table of paths below.
    pub fn drawing(&self) -> Drawing {
        let side = 500.0;
        let map = self.map(side);
        let chart = self.spectrum(560.0, side + 24.0).draw();
        let (paths, lobes) = (self.explanation.path_rows(), self.explanation.lobe_rows());
        let of_lobe = |(cells, cause): (_, Option<&Listed<'_>>)| (cells, colour_of(cause));
        let of_path = |(cells, path): (_, &Listed<'_>)| (cells, path.colour);
        let lobe_table = table(&LOBE_COLUMNS, lobes.into_iter().map(of_lobe));
        let path_table = table(&PATH_COLUMNS, paths.into_iter().map(of_path));
        let summary = self.summary();
        let mut y = 60.0;
        let mut group = Group::new()
            .add(words(self.title, 12.0, 24.0).set("class", "title"))
            .add(words(&summary, 12.0, 44.0).set("class", "small"))
            .add(at(12.0, y, map.into_content()))
            .add(at(side + 20.0, y - 12.0, chart.into_content()));
        y += side + 40.0;
        for (content, height) in [lobe_table, path_table] {
            group = group.add(at(12.0, y, content));
            y += height + 18.0;
        }
        let label = format!("{}: {summary}", self.title);
        Drawing::new(group, side + 592.0, y, label)
    }

    fn summary(&self) -> String {
        let e = self.explanation;
        let explained = e.lobes.iter().filter(|l| l.cause().is_some()).count();
        let (lobes, paths) = (e.lobes.len(), e.link.paths.len());
        let sight = match e.link.has_line_of_sight() {
            true => "in",
            false => "out of",
        };
        format!(
            "protocol {}: {:.0} m, {sight} sight, paths: {paths}, dominant lobes: {lobes}, made by one path: {explained}",
            e.spectrum.protocol,
            e.link.distance_m(),
        )
    }

    fn map(&self, side: f64) -> Drawing {
        let e = self.explanation;
        let is_listed = |path: &PathView| e.listed.iter().any(|l| std::ptr::eq(l.path, path));
        let rest = e.link.paths.iter().filter(|path| !is_listed(path));
        let rest = rest.map(|path| Ray {
            path,
            colour: Colour::Soft,
            width: 0.5,
            number: None,
            link: Some(REST.into()),
        });
        let listed = e.listed.iter().rev().map(|l| Ray {
            path: l.path,
            colour: l.colour,
            width: if is_coloured(l) { 2.4 } else { 0.9 },
            number: is_coloured(l).then(|| l.number.to_string()),
            link: Some(link(l)),
        });
        // Coloured ones last, on top.
        let mut rays: Vec<Ray<'_>> = rest.chain(listed).collect();
        rays.sort_by_key(|ray| ray.number.is_some());
        picture::map(self.outlines, e.link, &rays, side)
    }

    fn spectrum(&self, width: f64, height: f64) -> Chart {
        let e = self.explanation;
        let protocol = e.spectrum.protocol;
        let mut chart = picture::axes(protocol, e.spectrum.top_db(), true).sized(width, height);
        for l in e.listed.iter().rev() {
            let has_mirror = is_coloured(l) && e.has_mirrors;
            for stem in picture::stems(l.path, l.colour, protocol, has_mirror) {
                chart = chart.with(stem.linked(Some(link(l))));
            }
        }
        if let Some(other) = &e.other {
            chart = chart.with(picture::curve(other, protocol, Colour::Soft));
        }
        chart = chart.with(picture::curve(&e.spectrum, protocol, Colour::Ink));
        for lobe in &e.lobes {
            let cause = lobe.cause().and_then(|i| e.listed(i));
            let mark = Mark::Badges {
                points: vec![[lobe.angle_deg, lobe.level_db]],
                text: cause.map_or("?".into(), |l| badge_text(l.number, lobe.side)),
                hollow: lobe.side != Side::Own && cause.is_some(),
            };
            let badge = Series::new("", colour_of(cause), mark);
            chart = chart.with(badge.linked(cause.map(link)));
        }
        chart
    }
}

/// The colour of a lobe: that of the path that makes it.
fn colour_of(cause: Option<&Listed<'_>>) -> Colour {
    cause.map_or(Colour::Soft, |l| l.colour)
}

fn link(listed: &Listed<'_>) -> String {
    listed.number.to_string()
}

fn is_coloured(listed: &Listed<'_>) -> bool {
    matches!(listed.colour, Colour::Series(_))
}

/// A table as a picture, and its height \[px\]; the first cell of each row is a badge.
fn table(columns: &[&str], rows: impl Iterator<Item = (Vec<String>, Colour)>) -> (Group, f64) {
    let rows: Vec<(Vec<String>, Colour)> = rows.collect();
    let mut group = Group::new();
    let mut left = 0.0;
    for (i, title) in columns.iter().enumerate() {
        let texts = rows.iter().map(|(cells, _)| text_width(&cells[i]));
        let width = texts.fold(text_width(title), f64::max);
        group = group.add(words(title, left, 12.0).set("class", "small"));
        for (j, (cells, colour)) in rows.iter().enumerate() {
            let y = 34.0 + 21.0 * j as f64;
            group = match i {
                0 => group.add(badge(left + 9.0, y - 4.5, &cells[0], *colour, false)),
                _ => group.add(words(&cells[i], left, y).set("class", "")),
            };
        }
        left += width + 16.0;
    }
    (group, 24.0 + 21.0 * rows.len() as f64)
}
