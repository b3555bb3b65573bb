//! One link: trace, label.

use std::time::Instant;

use aps_data::LinkStatus;
use aps_label::{Labeler, Status};
use aps_raytrace::{Link, Receiver, TraceError, Tracer, Transmitter};

use super::rows::Rows;
use crate::batch::Buffers;
use crate::error::Result;
use crate::tally::Tally;

/// Makes links one after the other, in buffers that it keeps: one a thread.
pub struct LinkMaker {
    link: Link,
    is_same_point: bool,
    buffers: Buffers,
}

impl LinkMaker {
    /// A maker of links, `with_paths` of those whose paths are stored.
    pub fn new(with_paths: bool) -> Self {
        let link = if with_paths {
            Link::default()
        } else {
            Link::without_interactions()
        };
        Self {
            link,
            is_same_point: false,
            buffers: Buffers::default(),
        }
    }

    /// Traces the link between two terminals; returns true when it has a path inside the limits.
    pub fn trace(
        &mut self,
        tracer: &Tracer<'_>,
        tx: &Transmitter,
        rx: &Receiver,
        tally: &mut Tally,
    ) -> Result<bool> {
        let started = Instant::now();
        let traced = tracer.link(tx, rx, &mut self.link);
        tally.trace += started.elapsed();
        self.is_same_point = matches!(traced, Err(TraceError::Coincident { .. }));
        match traced {
            // The link is empty then.
            Err(TraceError::Coincident { .. }) => {}
            traced => traced?,
        }
        Ok(!self.link.paths.is_empty() && self.link.fallback_diffractions.is_none())
    }

    /// Labels the link traced last and appends it to `rows`, but for its paths; `ends` are its indices of transmitter and receiver.
    pub fn label(&mut self, labeler: &Labeler, ends: [u32; 2], rows: &mut Rows) -> Result<()> {
        let started = Instant::now();
        let link = &self.link;
        let samples = link.paths.iter().map(aps_data::sample_of);
        let labelled = self.buffers.label(labeler, samples)?;
        let status = match labelled {
            Status::Labelled if !self.is_same_point => LinkStatus::Valid,
            Status::Labelled | Status::NoPath => self.status_without_label(),
        };
        rows.tally.label += started.elapsed();
        let (label, protocol) = (&self.buffers.label, labeler.config().protocol);
        let fallback = link.fallback_diffractions.unwrap_or(0).min(u8::MAX.into()) as u8;
        rows.tally.link(link, fallback, label, status, protocol);
        rows.push(labeler, ends, status, fallback, label);
        Ok(())
    }

    /// Appends the paths of the link traced last.
    pub fn push_paths(&self, rows: &mut Rows) {
        rows.paths.push_records(&self.link.paths);
    }

    /// The state of the link traced last, which has no path inside the limits; chains beyond them do not count.
    pub fn status_inside_limits(&self) -> LinkStatus {
        match self.status_without_label() {
            LinkStatus::Unlabelled => LinkStatus::NoPath,
            other => other,
        }
    }

    /// The state of the link traced last if it gets no label.
    pub fn status_without_label(&self) -> LinkStatus {
        match &self.link {
            _ if self.is_same_point => LinkStatus::SamePoint,
            link if link.is_enclosed => LinkStatus::Enclosed,
            link if link.paths.is_empty() => LinkStatus::NoPath,
            _ => LinkStatus::Unlabelled,
        }
    }
}
