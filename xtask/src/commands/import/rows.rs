//! Rows of imported links, put together from those of single links.

use aps_data::{Layout, LinkRows, LinkStatus, PathTable, ProfileRows};

/// The rows of consecutive links.
#[derive(Debug, Default)]
pub struct Rows {
    pub status: Vec<LinkStatus>,
    pub aps: Values,
    pub pdp: Values,
    pub paths: PathTable,
}

/// Powers [dB] and the places of their maxima.
#[derive(Debug, Default)]
pub struct Values {
    pub db: Vec<f64>,
    pub places: Vec<f64>,
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
        for link in 0..other.paths.links() {
            self.paths.push_link(&other.paths, link);
        }
    }

    /// The rows as they are written.
    pub fn link_rows(&self, layout: &Layout) -> LinkRows<'_> {
        LinkRows {
            links: None,
            status: &self.status,
            fallback: None,
            aps: layout.aps.map(|aps| self.aps.rows(aps.argmax)),
            pdp: layout.pdp.map(|pdp| self.pdp.rows(pdp.argmax)),
            paths: layout.paths.then_some(&self.paths),
        }
    }
}
