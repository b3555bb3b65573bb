//! Rows of imported links, put together from those of single links.

use aps_data::{InteractionKind, Layout, LinkRows, LinkStatus, PathRows, ProfileRows};

/// The rows of consecutive links.
#[derive(Debug, Default)]
pub struct Rows {
    pub status: Vec<LinkStatus>,
    pub aps: Values,
    pub pdp: Values,
    pub paths: Paths,
}

/// Powers [dB] and the places of their maxima.
#[derive(Debug, Default)]
pub struct Values {
    pub db: Vec<f64>,
    pub places: Vec<f64>,
}

/// Columns as [`PathRows`] has them.
#[derive(Debug, Default)]
pub struct Paths {
    pub per_link: Vec<usize>,
    pub delay_s: Vec<f64>,
    pub departure_azimuth_rad: Vec<f64>,
    pub arrival_azimuth_rad: Vec<f64>,
    pub gain: Vec<[f64; 2]>,
    pub interactions: Vec<usize>,
    pub kind: Vec<InteractionKind>,
    pub id: Vec<u32>,
    pub point_m: Vec<[f64; 2]>,
}

impl Values {
    /// Brings the rows to `links` of `bins` values: those of a link without label are ignored.
    pub fn fill(&mut self, links: usize, bins: usize) {
        self.db.resize(links * bins, 0.0);
        self.places.resize(links * bins, 0.0);
    }

    fn append(&mut self, mut other: Self) {
        self.db.append(&mut other.db);
        self.places.append(&mut other.places);
    }

    fn rows(&self, argmax: bool) -> ProfileRows<'_> {
        ProfileRows {
            db: &self.db,
            argmax: argmax.then_some(&self.places),
        }
    }
}

impl Rows {
    /// Adds the rows of the links that follow.
    pub fn append(&mut self, mut other: Self) {
        self.status.append(&mut other.status);
        self.aps.append(other.aps);
        self.pdp.append(other.pdp);
        let (to, mut from) = (&mut self.paths, other.paths);
        to.per_link.append(&mut from.per_link);
        to.delay_s.append(&mut from.delay_s);
        to.departure_azimuth_rad
            .append(&mut from.departure_azimuth_rad);
        to.arrival_azimuth_rad.append(&mut from.arrival_azimuth_rad);
        to.gain.append(&mut from.gain);
        to.interactions.append(&mut from.interactions);
        to.kind.append(&mut from.kind);
        to.id.append(&mut from.id);
        to.point_m.append(&mut from.point_m);
    }

    /// The rows as they are written.
    pub fn link_rows(&self, layout: &Layout) -> LinkRows<'_> {
        let p = &self.paths;
        LinkRows {
            status: &self.status,
            fallback: None,
            aps: layout.aps.map(|aps| self.aps.rows(aps.argmax)),
            pdp: layout.pdp.map(|pdp| self.pdp.rows(pdp.argmax)),
            paths: layout.paths.then_some(PathRows {
                paths_per_link: &p.per_link,
                delay_s: &p.delay_s,
                departure_azimuth_rad: &p.departure_azimuth_rad,
                arrival_azimuth_rad: &p.arrival_azimuth_rad,
                gain: &p.gain,
                interactions_per_path: &p.interactions,
                interaction_kind: &p.kind,
                interaction_id: &p.id,
                interaction_point_m: &p.point_m,
            }),
        }
    }
}
