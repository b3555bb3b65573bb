//! Events of a benchmark, printed for a person who waits.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::Result;
use aps_bench::{Event, Observer, Outcome, Trial};
use map2aps::aps_model::train::StepReport;
use map2aps::training::DevelopmentScores;
use map2aps::{Progress, Work};
use xtask::progress::Bar;
use xtask::{note, output, say};

use crate::run;
use crate::weights::size_assumed;

/// Prints stages, remarks and tables, and shows bars.
pub struct Printer {
    maps: Bar,
    training: Mutex<Option<run::Bar>>,
    cancel: &'static AtomicBool,
    /// The first line that could not be written to standard output.
    unwritten: Mutex<Option<anyhow::Error>>,
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Printer {
    /// Prints until something cannot be written, which raises `cancel`.
    pub fn new(cancel: &'static AtomicBool) -> Self {
        Self {
            maps: Bar::default(),
            training: Mutex::default(),
            cancel,
            unwritten: Mutex::default(),
        }
    }

    /// Tells if everything could be written to standard output.
    ///
    /// # Errors
    /// The first failure.
    pub fn printed(self) -> Result<()> {
        let unwritten = self.unwritten.into_inner();
        let unwritten = unwritten.unwrap_or_else(PoisonError::into_inner);
        unwritten.map_or(Ok(()), Err)
    }

    /// Tells if a training is under way, whose bar counts its steps.
    fn trains(&self) -> bool {
        locked(&self.training).is_some()
    }

    fn line(&self, text: &str) {
        if let Err(error) = say!("{text}") {
            locked(&self.unwritten).get_or_insert(error);
            self.cancel.store(true, Ordering::Relaxed);
        }
    }
}

impl Progress for Printer {
    fn begin(&self, work: Work) {
        if !self.trains() {
            self.maps.begin(work);
        }
    }

    fn map(&self, id: u32) {
        self.maps.map(id);
    }

    fn advance(&self, units: u64) {
        if !self.trains() {
            self.maps.advance(units);
        }
    }

    fn step(&self, report: &StepReport) {
        let training = locked(&self.training);
        training.iter().for_each(|bar| bar.step(report));
    }

    fn scored(&self, scores: &DevelopmentScores) {
        let training = locked(&self.training);
        training.iter().for_each(|bar| bar.scored(scores));
    }
}

impl Observer for Printer {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Stage {
                number,
                count,
                name,
                elapsed,
            } => {
                let seconds = elapsed.as_secs();
                note!("[{number}/{count}] {name}, {seconds} s so far");
            }
            Event::Damaged(file) => {
                note!("'{}' is gone or was changed: made again", file.display());
            }
            Event::DataReplaced(folder) => {
                note!(
                    "'{}' holds a data set of other maps or settings: made anew, and all trainings with it",
                    folder.display()
                );
            }
            Event::DataReady => self.maps.clear(),
            Event::TrainingBegins(plan, run) => {
                *locked(&self.training) = Some(run::Bar::begin(plan, run));
            }
            Event::TrainingEnds { is_whole } => {
                if let Some(bar) = locked(&self.training).take() {
                    bar.end(is_whole);
                }
            }
            Event::Foreign(difference) => {
                note!("note: it learnt other labels than those here: {difference}");
            }
            Event::ImagesAssumed(size) => {
                note!("{}", size_assumed(size, "put that file beside them"));
            }
            Event::LeftOut(it) => note!("{} is left out: {}", it.name, it.message),
            Event::Failed(it) => note!("{} failed, the others go on: {}", it.name, it.message),
            Event::Reported(files) => note!("{} files of the report", files.len()),
            Event::TuningBegins => self.line(&format!(
                "{:14} {:>10} {:>6} {:>6} {:>7} {:>9} {:>7}",
                "model", "rate", "batch", "pixels", "warm-up", "share", "CosSim"
            )),
            Event::Tried(trial) => {
                let outcome = match trial.outcome {
                    Outcome::Scored { cosine, few_steps } => {
                        let few = few_steps.map(|steps| format!(", of only {steps} steps"));
                        format!("{cosine:7.3}{}", few.unwrap_or_default())
                    }
                    Outcome::Failed(error) => format!("failed: {}", output::told(error)),
                };
                self.line(&format!("{} {outcome}", row(trial)));
            }
            Event::Chosen(best) => {
                if let Outcome::Scored { cosine, .. } = best.outcome {
                    self.line(&format!("{} <- best, CosSim {cosine:.3}", row(best)));
                }
            }
            _ => {}
        }
    }
}

/// A line of the table of trials, but for what came of it.
fn row(trial: &Trial<'_>) -> String {
    let settings = trial.settings;
    format!(
        "{:14} {:>10.1e} {:>6} {:>6} {:>7} {:>9.4}",
        trial.model.name(),
        settings.learning_rate.unwrap_or_default(),
        settings.batch.unwrap_or_default(),
        settings.image_size.unwrap_or_default(),
        settings.warmup_steps.unwrap_or_default(),
        trial.share,
    )
}
