//! The rows of some links as the writer takes them, and their share of the data set's statistics.

use std::time::Instant;

use aps_data::{
    Layout, LinkRows, LinkStatus, PathTable, Profile, ProfileLayout, ProfileRows, Stored,
};
use aps_label::{Label, Labeler};

use crate::error::Result;
use crate::tally::Tally;

/// Rows of consecutive links.
#[derive(Default)]
pub struct Rows {
    /// Indices of transmitter and receiver; none where the map's list of links tells them.
    pub ends: Vec<[u32; 2]>,
    pub status: Vec<LinkStatus>,
    pub fallback: Vec<u8>,
    pub aps: Values,
    pub pdp: Values,
    pub paths: PathTable,
    pub tally: Tally,
}

/// Powers \[dB\] and the places of their maxima, which traced labels have none of.
#[derive(Debug, Default)]
pub struct Values {
    pub db: Vec<f64>,
    pub places: Vec<f64>,
}

impl Values {
    /// Appends the powers of the last of `links` links: those of one without a label are ignored, whatever they are.
    pub fn push(&mut self, db: &[f64], links: usize, bins: usize) {
        self.db.extend_from_slice(db);
        self.db.resize(links * bins, 0.0);
    }

    /// The values as the writer takes them.
    pub fn rows(&self) -> ProfileRows<'_> {
        ProfileRows {
            db: &self.db,
            argmax: (!self.places.is_empty()).then_some(&self.places),
        }
    }

    /// The values of links, in the order in which they are given, of `count` in all.
    fn of_links(&self, links: &[usize], count: usize) -> Self {
        let of = |values: &[f64]| {
            let bins = values.len() / count;
            let rows = links.iter().map(|link| &values[link * bins..][..bins]);
            rows.flatten().copied().collect()
        };
        Self {
            db: of(&self.db),
            places: of(&self.places),
        }
    }

    fn append(&mut self, mut other: Self) {
        self.db.append(&mut other.db);
        self.places.append(&mut other.places);
    }
}

impl Rows {
    /// Appends all of a link but its paths.
    pub fn push(
        &mut self,
        labeler: &Labeler,
        ends: [u32; 2],
        status: LinkStatus,
        fallback: u8,
        label: &Label,
    ) {
        self.ends.push(ends);
        self.fallback.push(fallback);
        self.push_label(labeler, status, label);
    }

    /// Appends the state and the label of a link.
    pub fn push_label(&mut self, labeler: &Labeler, status: LinkStatus, label: &Label) {
        self.status.push(status);
        let links = self.status.len();
        let angles = labeler.angles_deg().len();
        self.aps.push(&label.aps_db, links, angles);
        if labeler.config().pdp {
            self.pdp
                .push(&label.pdp_db, links, labeler.delays_s().len());
        }
    }

    /// Appends the rows of the links that follow.
    pub fn append(&mut self, mut other: Self) {
        self.ends.append(&mut other.ends);
        self.status.append(&mut other.status);
        self.fallback.append(&mut other.fallback);
        self.aps.append(other.aps);
        self.pdp.append(other.pdp);
        self.paths.push_table(&other.paths);
        self.tally.add(&other.tally);
    }

    /// Sorts the rows by their receivers.
    pub fn sort_by_receiver(&mut self) {
        let count = self.ends.len();
        let mut links: Vec<usize> = (0..count).collect();
        links.sort_by_key(|&link| self.ends[link][1]);
        if links.is_sorted() {
            return;
        }
        self.ends = links.iter().map(|&link| self.ends[link]).collect();
        self.status = links.iter().map(|&link| self.status[link]).collect();
        self.fallback = links.iter().map(|&link| self.fallback[link]).collect();
        self.aps = self.aps.of_links(&links, count);
        self.pdp = self.pdp.of_links(&links, count);
        if self.paths.links() == count {
            self.paths = self.paths.of_links(links);
        }
    }

    /// Rows of the arrays that a layout stores.
    pub fn link_rows(&self, layout: &Layout) -> LinkRows<'_> {
        LinkRows {
            links: Some(&self.ends),
            status: &self.status,
            fallback: Some(&self.fallback),
            aps: layout.aps.map(|_| self.aps.rows()),
            pdp: layout.pdp.map(|_| self.pdp.rows()),
            paths: layout.paths.then_some(&self.paths),
        }
    }

    /// Counts the shapes of the spectra, once all rows are there: as the data set stores them, or would store them.
    pub fn count_shapes(&mut self, labeler: &Labeler, layout: &Layout) -> Result<()> {
        let started = Instant::now();
        let aps = layout.aps.unwrap_or_else(|| default_aps(labeler, layout));
        let aps = Profile::encode(&self.aps.rows(), &aps, &self.status)?;
        let valid = (0..self.status.len()).filter(|&link| self.status[link].is_valid());
        self.tally.shapes(&aps, valid, labeler.config().protocol)?;
        self.tally.label += started.elapsed();
        Ok(())
    }
}

fn default_aps(labeler: &Labeler, layout: &Layout) -> ProfileLayout {
    let layout = Layout::of_labels(labeler.config(), layout.raster, Stored::default());
    layout.aps.expect("it is stored by default")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_sorted_with_all_that_belongs_to_them() {
        let receivers = [7, 2, 9, 4];
        let sorted = [2, 4, 7, 9];
        let rows = |receivers: [u32; 4], with_paths: bool| {
            let mut rows = Rows::default();
            for rx in receivers {
                rows.ends.push([3, rx]);
                let is_odd = rx % 2 == 1;
                rows.status.push(if is_odd {
                    LinkStatus::NoPath
                } else {
                    LinkStatus::Valid
                });
                rows.fallback.push(rx as u8);
                rows.aps.db.extend([f64::from(rx), f64::from(rx) + 0.5]);
                rows.pdp.places.push(f64::from(rx));
                if with_paths {
                    rows.paths.end_link();
                }
            }
            rows
        };
        for with_paths in [false, true] {
            let (mut found, expected) = (rows(receivers, with_paths), rows(sorted, with_paths));
            found.sort_by_receiver();
            assert_eq!(found.ends, expected.ends);
            assert_eq!(found.status, expected.status);
            assert_eq!(found.fallback, expected.fallback);
            assert_eq!(
                (found.aps.db, found.aps.places),
                (expected.aps.db, expected.aps.places)
            );
            assert_eq!(
                (found.pdp.db, found.pdp.places),
                (expected.pdp.db, expected.pdp.places)
            );
            assert!(found.paths.is_same(&expected.paths));
        }
        let mut none = Rows::default();
        none.sort_by_receiver();
        assert!(none.ends.is_empty());
    }
}
