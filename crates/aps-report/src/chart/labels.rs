//! Keeps texts and badges from covering each other: each takes the first free place.

use crate::drawing::text_width;

/// Half the side of a badge with the room around it \[px\].
const BADGE: f64 = 9.5;

/// A rectangle: left, top, right, bottom \[px\].
type Area = [f64; 4];

/// Places that are taken already.
#[derive(Debug, Clone)]
pub(crate) struct Labels {
    inside: Area,
    taken: Vec<Area>,
}

impl Labels {
    /// None so far; all are to lie inside an area.
    pub fn inside(left: f64, top: f64, right: f64, bottom: f64) -> Self {
        Self {
            inside: [left, top, right, bottom],
            taken: Vec::new(),
        }
    }

    /// Takes the surroundings of a dot.
    pub fn dot(&mut self, (x, y): (f64, f64)) {
        self.taken.push([x - 5.0, y - 5.0, x + 5.0, y + 5.0]);
    }

    /// Takes the place of a text of 15 px that is drawn from `x` on, at `y`.
    pub fn text(&mut self, x: f64, y: f64, text: &str, anchor: &str) {
        let w = 1.2 * text_width(text);
        let left = left_of(x, w, anchor);
        self.taken.push([left, y - 13.0, left + w, y + 4.0]);
    }

    /// Takes the surroundings of a horizontal or vertical line.
    pub fn line(&mut self, x1: f64, y1: f64, x2: f64, y2: f64) {
        let (left, right, top, bottom) = (x1.min(x2), x1.max(x2), y1.min(y2), y1.max(y2));
        self.taken
            .push([left - 2.0, top - 2.0, right + 2.0, bottom + 2.0]);
    }

    /// A place for a text beside a dot: right of it, left, above or below, else some lines further up
    /// or down, else right all the same. Returns start or end of its base line and the anchor.
    pub fn beside(&mut self, x: f64, y: f64, text: &str) -> (f64, f64, &'static str) {
        let w = text_width(text);
        let places = [
            (x + 8.0, y + 4.5, "start"),
            (x - 8.0, y + 4.5, "end"),
            (x, y - 10.0, "middle"),
            (x, y + 19.0, "middle"),
            (x + 6.0, y - 10.0, "start"),
            (x + 6.0, y + 19.0, "start"),
            (x - 6.0, y - 10.0, "end"),
            (x - 6.0, y + 19.0, "end"),
        ];
        // Lines further away, where dots crowd.
        let far = [14.0, 50.0].into_iter().flat_map(|aside| {
            let far = (2..12).map(|line| 14.0 * f64::from(line));
            let far = far.flat_map(|away| [y + 4.5 + away, y + 4.5 - away]);
            far.flat_map(move |base| [(x + aside, base, "start"), (x - aside, base, "end")])
        });
        let area = |(x, base, anchor): (f64, f64, &str)| {
            let left = left_of(x, w, anchor);
            [left, base - 11.0, left + w, base + 3.0]
        };
        let mut all = places.into_iter().chain(far);
        let place = all.find(|&place| self.is_free(area(place)));
        let place = place.unwrap_or(places[0]);
        self.taken.push(area(place));
        place
    }

    /// The height of a free place for a badge above a point.
    pub fn above(&mut self, x: f64, y: f64) -> f64 {
        let places: Vec<_> = (0..12)
            .map(|i| (x, y - 14.0 - 7.0 * f64::from(i)))
            .collect();
        self.among(&places).1
    }

    /// The first of some places for a badge where it covers no other, else the first of all. There is one at least.
    pub fn among(&mut self, places: &[(f64, f64)]) -> (f64, f64) {
        let is_free = |&&place: &&(f64, f64)| self.is_free(badge(place));
        let place = *places.iter().find(is_free).unwrap_or(&places[0]);
        self.taken.push(badge(place));
        place
    }

    fn is_free(&self, [left, top, right, bottom]: Area) -> bool {
        let [l, t, r, b] = self.inside;
        let fits = left >= l && top >= t && right <= r && bottom <= b;
        fits && self
            .taken
            .iter()
            .all(|&[l, t, r, b]| right <= l || left >= r || bottom <= t || top >= b)
    }
}

/// The left end of a text of width `w` with its anchor at `x`.
fn left_of(x: f64, w: f64, anchor: &str) -> f64 {
    match anchor {
        "start" => x,
        "middle" => x - w / 2.0,
        _ => x - w,
    }
}

/// The area of a badge.
fn badge((x, y): (f64, f64)) -> Area {
    [x - BADGE, y - BADGE, x + BADGE, y + BADGE]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn badges_at_one_point_are_stacked() {
        let mut labels = Labels::inside(0.0, 0.0, 200.0, 200.0);
        let ups: Vec<f64> = (0..3).map(|_| labels.above(50.0, 150.0)).collect();
        assert!(
            ups[0] - ups[1] >= 2.0 * BADGE && ups[1] - ups[2] >= 2.0 * BADGE,
            "{ups:?}"
        );
    }

    #[test]
    fn text_that_does_not_fit_to_the_right_goes_elsewhere() {
        let mut labels = Labels::inside(0.0, 0.0, 100.0, 100.0);
        assert_eq!(labels.beside(20.0, 50.0, "near").2, "start");
        assert_eq!(labels.beside(90.0, 50.0, "near").2, "end");
        // A second one at the first place is moved.
        assert_ne!(labels.beside(20.0, 50.0, "near").1, 54.5);
    }
}
