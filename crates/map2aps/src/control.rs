//! Progress and cancellation of long operations.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use aps_data::Plan;

use crate::error::{Error, Result};

/// Receives the progress of an operation. Methods are called from any thread of it.
#[allow(unused_variables)]
pub trait Progress: Sync {
    /// Takes the size of the work that begins.
    fn begin(&self, work: Work) {}

    /// Takes the map that is worked on from now on.
    fn map(&self, id: u32) {}

    /// Takes the number of units that are done since the last call.
    fn advance(&self, units: u64) {}

    /// Takes what a step of a training did.
    #[cfg(feature = "models")]
    fn step(&self, report: &aps_model::train::StepReport) {}

    /// Takes the scores of the development links after a step.
    #[cfg(feature = "models")]
    fn scored(&self, scores: &DevelopmentScores) {}
}

/// Ignores the progress.
impl Progress for () {}

/// Size of the work of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Work {
    /// Number of units to do.
    pub units: u64,
    /// Name of the units: `links`, `files`, `maps`, `bytes` or `seconds`.
    pub name: &'static str,
    /// Maps that the result holds already.
    pub finished_maps: usize,
    /// Maps of the result.
    pub maps: usize,
}

/// Scores of the development links after a step.
#[cfg(feature = "models")]
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct DevelopmentScores {
    /// Steps made.
    pub steps: u64,
    /// Epochs made.
    pub epochs: f64,
    /// Time spent on the training before these scores \[s\].
    pub seconds: f64,
    /// Mean training loss since the scores before.
    pub loss: f64,
    /// The scores.
    pub group: aps_metrics::GroupReport,
    /// Metric by which the best weights are chosen.
    pub chosen_by: aps_metrics::Metric,
    /// True when these are the best so far.
    pub is_best: bool,
}

/// Progress, cancellation and name of an operation. The default reports nothing and cannot be cancelled.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Receiver of the progress.
    pub progress: &'a dyn Progress,
    /// The operation ends soon after this becomes true.
    pub cancel: &'a AtomicBool,
    /// Command that continues the operation, one word each: an unfinished data set keeps it for its readers
    /// ([`Plan`]).
    pub command: &'a [String],
}

impl Default for Control<'_> {
    fn default() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self {
            progress: &(),
            cancel: &NEVER,
            command: &[],
        }
    }
}

impl fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut control = f.debug_struct("Control");
        control.field("cancel", &self.cancel);
        control.field("command", &self.command);
        control.finish_non_exhaustive()
    }
}

impl Control<'_> {
    /// Returns true when the operation is to end.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// The plan of an operation that makes these maps, for readers of the unfinished data set.
    pub(crate) fn plan(&self, maps: Vec<u32>, shards: Option<u32>) -> Plan {
        Plan {
            maps,
            shards,
            command: self.command.to_vec(),
        }
    }

    /// Ends a cancelled operation.
    pub(crate) fn check(&self) -> Result<()> {
        match self.is_cancelled() {
            true => Err(Error::Cancelled),
            false => Ok(()),
        }
    }
}
