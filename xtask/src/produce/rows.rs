//! The rows of some links as the writer takes them, and their share of the data set's statistics.

use std::time::Instant;

use anyhow::Result;
use aps_data::{
    Layout, LinkRows, LinkStatus, PathTable, Profile, ProfileLayout, ProfileRows, Stored,
};
use aps_label::{ANGLE_BINS, Label, Labeler};

use crate::summary::Tally;

/// Rows of consecutive links.
#[derive(Default)]
pub struct Rows {
    /// Indices of transmitter and receiver.
    pub ends: Vec<[u32; 2]>,
    pub status: Vec<LinkStatus>,
    pub fallback: Vec<u8>,
    pub aps_db: Vec<f64>,
    pub pdp_db: Vec<f64>,
    pub paths: PathTable,
    pub tally: Tally,
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
        self.status.push(status);
        self.fallback.push(fallback);
        let links = self.status.len();
        // Rows of links without label are ignored, whatever they hold.
        self.aps_db.extend_from_slice(&label.aps_db);
        self.aps_db.resize(links * ANGLE_BINS, 0.0);
        if labeler.config().pdp {
            self.pdp_db.extend_from_slice(&label.pdp_db);
            self.pdp_db.resize(links * labeler.delays_s().len(), 0.0);
        }
    }

    /// Rows of the arrays that a layout stores.
    pub fn link_rows(&self, layout: &Layout) -> LinkRows<'_> {
        LinkRows {
            links: Some(&self.ends),
            status: &self.status,
            fallback: Some(&self.fallback),
            aps: layout.aps.map(|_| profile_rows(&self.aps_db)),
            pdp: layout.pdp.map(|_| profile_rows(&self.pdp_db)),
            paths: layout.paths.then_some(&self.paths),
        }
    }

    /// Encodes the spectra as the data set stores them, or would store them.
    pub fn stored_aps(&self, labeler: &Labeler, layout: &Layout) -> Result<Profile> {
        let aps = layout.aps.unwrap_or_else(|| default_aps(labeler, layout));
        Ok(Profile::encode(
            &profile_rows(&self.aps_db),
            &aps,
            &self.status,
        )?)
    }

    /// Counts the shapes of the spectra, once all rows are there.
    pub fn count_shapes(&mut self, labeler: &Labeler, layout: &Layout) -> Result<()> {
        let started = Instant::now();
        let aps = self.stored_aps(labeler, layout)?;
        let valid = (0..self.status.len()).filter(|&link| self.status[link].is_valid());
        self.tally.shapes(&aps, valid, labeler.config().protocol)?;
        self.tally.label += started.elapsed();
        Ok(())
    }
}

pub fn profile_rows(db: &[f64]) -> ProfileRows<'_> {
    ProfileRows { db, argmax: None }
}

fn default_aps(labeler: &Labeler, layout: &Layout) -> ProfileLayout {
    let all = Stored {
        aps: true,
        pdp: false,
        paths: false,
    };
    let layout = Layout::of_labels(labeler.config(), layout.raster, all);
    layout.aps.expect("it was asked for")
}
