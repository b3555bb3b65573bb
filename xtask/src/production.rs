//! Making the maps of a data set, one after the other, whatever may come between.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use aps_data::DatasetWriter;
use aps_label::Labeler;

use crate::interrupt::interrupt_flag;
use crate::note;
use crate::produce::Run;
use crate::progress;
use crate::summary::Tally;

/// Makes each map of `todo` by `make`, with a progress bar over all their links; returns their tally and the time it took.
///
/// # Errors
/// An interruption or a failure; the error tells the maps that are kept.
pub fn make_maps(
    writer: &DatasetWriter,
    labeler: &Labeler,
    out: &Path,
    todo: &[u32],
    links: u64,
    mut make: impl FnMut(&Run<'_>, u32) -> Result<Tally>,
) -> Result<(Tally, Duration)> {
    let progress = progress::bar(links, "links");
    let interrupted = interrupt_flag()?;
    let run = Run {
        writer,
        labeler,
        progress: &progress,
        interrupted: &interrupted,
    };
    let kept = || {
        let whole = writer.map_ids().len();
        format!("{whole} whole maps are kept in '{}'", out.display())
    };
    let started = Instant::now();
    let mut total = Tally::default();
    for &id in todo {
        progress.set_message(format!("map {id}"));
        let made = make(&run, id);
        if interrupted.load(Ordering::Relaxed) {
            progress.abandon();
            bail!("interrupted; {}, the same command continues", kept());
        }
        if made.is_err() {
            progress.abandon();
        }
        let made = made.with_context(|| {
            let kept = kept();
            format!("stopped; {kept}, with the cause removed the same command continues")
        })?;
        total.add(&made);
    }
    progress.finish_and_clear();
    Ok((total, started.elapsed()))
}

/// Says how many of the maps there is nothing left to do for.
pub fn tell_finished(todo: usize, all: usize) {
    if todo < all {
        note!("{} of {all} maps are there already", all - todo);
    }
}
