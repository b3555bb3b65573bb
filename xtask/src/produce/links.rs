//! One link: trace, label.

use std::time::Instant;

use anyhow::Result;
use aps_data::LinkStatus;
use aps_label::{Label, Labeler, PathSample, Scratch, Status};
use aps_raytrace::{Link, Receiver, TraceError, Tracer, Transmitter};

use super::rows::Rows;
use crate::samples;

/// Makes links one after the other, in buffers that it keeps: one a thread.
#[derive(Default)]
pub struct LinkMaker {
    link: Link,
    samples: Vec<PathSample>,
    scratch: Scratch,
    label: Label,
}

impl LinkMaker {
    /// Appends the link between two terminals to `rows`.
    pub fn make(
        &mut self,
        tracer: &Tracer<'_>,
        labeler: &Labeler,
        tx: &Transmitter,
        rx: &Receiver,
        rows: &mut Rows,
    ) -> Result<()> {
        let started = Instant::now();
        let traced = tracer.link(tx, rx, &mut self.link);
        let traced_at = Instant::now();
        rows.tally.trace += traced_at - started;
        let link = &mut self.link;
        if let Err(TraceError::Coincident { .. }) = traced {
            *link = Link::default();
        }
        self.samples.clear();
        self.samples
            .extend(link.paths.iter().map(samples::of_record));
        let labelled = labeler.label_into(&self.samples, &mut self.scratch, &mut self.label)?;
        let status = match (traced, labelled) {
            (Err(_), _) => LinkStatus::SamePoint,
            (_, Status::Labelled) => LinkStatus::Valid,
            _ if link.is_enclosed => LinkStatus::Enclosed,
            _ if link.paths.is_empty() => LinkStatus::NoPath,
            _ => LinkStatus::Unlabelled,
        };
        rows.tally.label += traced_at.elapsed();
        let protocol = labeler.config().protocol;
        rows.tally.link(link, &self.label, status, protocol);
        let beyond = link.fallback_diffractions.unwrap_or(0).min(u8::MAX.into());
        rows.push(labeler, status, beyond as u8, &self.label);
        rows.paths.push(&link.paths);
        Ok(())
    }
}
