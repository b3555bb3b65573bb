//! Times that can be compared: one thread, warmed up, the median of repeats.

use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::profile::Profile;

/// Measures how long something takes, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stopwatch {
    /// Measured samples; their median counts.
    pub samples: usize,
    /// A sample repeats the work until it has taken this long, so that the clock's steps do not show.
    pub least_sample: Duration,
    /// Samples stop once they have taken this long together. Work that takes longer than this at once is
    /// timed by its one run.
    pub most: Duration,
}

impl Stopwatch {
    /// The samples of a profile.
    pub fn of(profile: Profile) -> Self {
        Self {
            samples: profile.choose(3, 7),
            least_sample: profile.choose(Duration::from_micros(50), Duration::from_millis(5)),
            most: profile.choose(Duration::from_millis(20), Duration::from_millis(250)),
        }
    }

    /// Times `work`, which runs once for warming up and is then repeated.
    pub fn time(&self, mut work: impl FnMut()) -> f64 {
        self.compare(&[()], |()| work())[0]
    }

    /// Times a unit of work, of which `work` does `count`, for several settings as [`Self::compare`] does, on one thread.
    ///
    /// # Errors
    /// A system that gives no thread.
    pub fn each<A: Sync>(
        &self,
        settings: &[A],
        count: usize,
        work: impl Fn(&A) + Send,
    ) -> Result<Vec<f64>> {
        let times = on_one_thread(|| self.compare(settings, work))?;
        Ok(times.into_iter().map(|time| time / count as f64).collect())
    }

    /// Times the same work for several settings that are to be compared: their samples take turns, so that a machine that slows
    /// down for a while slows all of them.
    pub fn compare<A>(&self, settings: &[A], mut work: impl FnMut(&A)) -> Vec<f64> {
        let once = |setting: &A| {
            let started = Instant::now();
            work(setting);
            started.elapsed()
        };
        let warm_up: Vec<Duration> = settings.iter().map(once).collect();
        self.compare_again(&warm_up, settings, work)
    }

    /// Times work as [`Self::compare`] does that ran already and took `once`.
    ///
    /// # Panics
    /// If there are not as many times as settings.
    pub fn compare_again<A>(
        &self,
        once: &[Duration],
        settings: &[A],
        mut work: impl FnMut(&A),
    ) -> Vec<f64> {
        assert_eq!(once.len(), settings.len(), "a time for every setting");
        let mut samples: Vec<Vec<f64>> = once.iter().map(|_| Vec::new()).collect();
        let mut spent = vec![Duration::ZERO; once.len()];
        for _ in 0..self.samples.max(1) {
            for (i, setting) in settings.iter().enumerate() {
                let first = once[i].as_secs_f64().max(1e-9);
                if once[i] >= self.most {
                    samples[i] = vec![first];
                } else if samples[i].is_empty() || spent[i] < self.most {
                    let repeats = (self.least_sample.as_secs_f64() / first).ceil().max(1.0);
                    let started = Instant::now();
                    for _ in 0..repeats as u32 {
                        work(setting);
                    }
                    let took = started.elapsed();
                    spent[i] += took;
                    samples[i].push(took.as_secs_f64() / repeats);
                }
            }
        }
        let median = |mut samples: Vec<f64>| {
            samples.sort_by(f64::total_cmp);
            samples[(samples.len() - 1) / 2]
        };
        samples.into_iter().map(median).collect()
    }
}

/// Runs `work` so that whatever it spreads over threads stays on one.
///
/// # Errors
/// A system that gives no thread.
pub fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    Ok(pool.context("cannot start a thread")?.install(work))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_runs_once_to_warm_up_and_then_as_often_as_asked() {
        let stopwatch = Stopwatch {
            samples: 5,
            least_sample: Duration::ZERO,
            most: Duration::from_secs(60),
        };
        let mut runs = 0;
        assert!(stopwatch.time(|| runs += 1).is_finite());
        assert_eq!(runs, 6);
    }

    #[test]
    fn what_takes_too_long_runs_once() {
        let stopwatch = Stopwatch {
            samples: 5,
            least_sample: Duration::ZERO,
            most: Duration::ZERO,
        };
        let mut runs = 0;
        // No time is below a nanosecond, whatever the steps of the clock.
        assert!(stopwatch.time(|| runs += 1) >= 1e-9);
        assert_eq!(runs, 1);
    }

    #[test]
    fn samples_of_compared_work_take_turns() {
        let stopwatch = Stopwatch {
            samples: 3,
            least_sample: Duration::ZERO,
            most: Duration::from_secs(60),
        };
        let order = std::cell::RefCell::new(String::new());
        let timings = stopwatch.compare(&['a', 'b'], |&name| order.borrow_mut().push(name));
        assert_eq!(timings.len(), 2);
        assert_eq!(*order.borrow(), "abababab");
    }

    #[test]
    fn nothing_spreads_beyond_one_thread() {
        assert_eq!(on_one_thread(rayon::current_num_threads).unwrap(), 1);
    }
}
