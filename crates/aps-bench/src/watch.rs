//! Events of a benchmark that runs, and the flag that ends it.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use aps_report::benchmark::Failure;
use map2aps::training::{Run, Training};
use map2aps::{Control, Difference, Progress};

use crate::error::{Error, Result};
use crate::tune::Trial;

/// Follows a benchmark. Its [`Progress`] counts the links of a data set that is made and the steps of a training.
pub trait Observer: Progress {
    /// Takes what happens.
    fn event(&self, event: Event<'_>) {
        let _ = event;
    }
}

/// Follows nothing.
impl Observer for () {}

/// Step of a benchmark that a person who waits may want to know.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A stage begins: the data set, then an entry each.
    Stage {
        /// Its number, from 1.
        number: usize,
        /// Number of stages.
        count: usize,
        /// Name of the entry.
        name: &'a str,
        /// Time since the beginning.
        elapsed: Duration,
    },
    /// This file of a finished part is gone or was changed: the part is made again.
    Damaged(&'a Path),
    /// The folder of the data set holds one of other maps or settings, which is removed: all is made anew.
    DataReplaced(&'a Path),
    /// All maps of the data set are there.
    DataReady,
    /// A training begins, or is continued.
    TrainingBegins(&'a Training, &'a Run),
    /// A training ends, with all its steps made or not.
    TrainingEnds {
        /// False when it failed or was ended from outside.
        is_whole: bool,
    },
    /// Weights trained elsewhere learnt other labels than those here.
    Foreign(&'a Difference),
    /// Image size assumed for weights trained elsewhere, because no file states it \[pixels\].
    ImagesAssumed(usize),
    /// An entry is left out, since it predicts labels of another meaning.
    LeftOut(&'a Failure),
    /// An entry failed, and the others go on.
    Failed(&'a Failure),
    /// The report is written: its files.
    Reported(&'a [PathBuf]),
    /// The choice of settings begins: a table of trials.
    TuningBegins,
    /// A setting was tried.
    Tried(&'a Trial<'a>),
    /// The settings with the best score of a model, which are in the file now.
    Chosen(&'a Trial<'a>),
}

/// Observer and cancellation of a benchmark. The default tells nobody and cannot be cancelled.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Is told what happens.
    pub observer: &'a dyn Observer,
    /// The work ends soon after this becomes true.
    pub cancel: &'a AtomicBool,
}

impl Default for Watch<'_> {
    fn default() -> Self {
        Self {
            observer: &(),
            cancel: Control::default().cancel,
        }
    }
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut watch = f.debug_struct("Watch");
        watch.field("cancel", self.cancel).finish_non_exhaustive()
    }
}

impl<'a> Watch<'a> {
    /// Makes the progress and cancellation of an operation of the library.
    pub(crate) fn control(&self) -> Control<'a> {
        Control {
            progress: self.observer,
            cancel: self.cancel,
            ..Control::default()
        }
    }

    pub(crate) fn tell(&self, event: Event<'_>) {
        self.observer.event(event);
    }

    /// Tells of an error, after the work was ended from outside, that it was.
    pub(crate) fn ended<T>(&self, result: Result<T>) -> Result<T> {
        result.map_err(|error| match self.is_cancelled() {
            true => Error::Interrupted(Box::new(error)),
            false => error,
        })
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}
