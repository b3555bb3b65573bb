//! A benchmark from its settings to its report.

use std::time::Instant;

use aps_report::benchmark::{Failure, Machine, Results, write_report};
use map2aps::error::chain;

use crate::benchmark::Benchmark;
use crate::entry::Context;
use crate::error::{Error, Result};
use crate::files::claim_folder;
use crate::job::{self, Job, SIGHT};
use crate::watch::{Event, Watch};

impl Benchmark {
    /// Makes the data set, trains the models, asks all entries for the test links, and writes results and report.
    ///
    /// An entry that fails is one of [`Results::failed`]; one that predicts labels of another meaning, of
    /// [`Results::left_out`].
    ///
    /// # Errors
    /// A folder of something else, data that cannot be made, files that cannot be written, and [`Error::Interrupted`]: what is finished by
    /// then is kept, and the same benchmark goes on from there.
    pub fn run(&self, watch: Watch<'_>) -> Result<Results> {
        watch.ended(self.results(watch))
    }

    fn results(&self, watch: Watch<'_>) -> Result<Results> {
        let started = Instant::now();
        let device = self.config.device.open()?;
        let _lock = claim_folder(&self.out, &self.config)?;
        let jobs = job::of(&self.config)?;
        let begin = |number: usize, name: &str| {
            watch.tell(Event::Stage {
                number,
                count: 1 + jobs.len(),
                name,
                elapsed: started.elapsed(),
            });
        };
        begin(1, "data set");
        let context = Context::open(self, device, watch)?;
        let (mut entries, mut failed, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for (number, job) in (2..).zip(&jobs) {
            let (name, _) = job.title();
            begin(number, &name);
            let error = match context.entry(job) {
                Ok(entry) => {
                    entries.push(entry);
                    continue;
                }
                Err(error) => error,
            };
            if watch.is_cancelled() {
                return Err(error);
            }
            let message = chain(&error);
            let failure = Failure { name, message };
            if error.is_of_other_labels() {
                watch.tell(Event::LeftOut(&failure));
                left_out.push(failure);
            } else if matches!(job, Job::Tracer(SIGHT)) {
                // The tracer without interactions tells which links are in sight: no report without it.
                return Err(error);
            } else {
                watch.tell(Event::Failed(&failure));
                failed.push(failure);
            }
        }
        if entries.is_empty() {
            return Err(Error::NothingScored);
        }
        let results = Results {
            machine: Machine {
                seconds_total: started.elapsed().as_secs_f64(),
                ..self.machine.clone()
            },
            failed,
            left_out,
            ..context.results(entries)?
        };
        results.save(&self.out)?;
        watch.tell(Event::Reported(&write_report(&results, &self.out)?));
        Ok(results)
    }
}
