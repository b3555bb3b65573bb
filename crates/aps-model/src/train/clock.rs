//! The clock of a training, which time may end.

use std::time::{Duration, Instant};

/// Time spent on a training.
pub(super) struct Clock {
    /// Time since any moment.
    pub now: Box<dyn Fn() -> Duration + Send + Sync>,
    /// Spent before `since`.
    pub before: Duration,
    /// Time of the first step of this sitting.
    pub since: Option<Duration>,
}

impl Clock {
    pub fn new() -> Self {
        let start = Instant::now();
        Self {
            now: Box::new(move || start.elapsed()),
            before: Duration::ZERO,
            since: None,
        }
    }

    pub fn start(&mut self) {
        self.since.get_or_insert_with(&self.now);
    }

    pub fn seconds(&self) -> f64 {
        let sitting = self.since.map(|since| (self.now)() - since);
        (self.before + sitting.unwrap_or_default()).as_secs_f64()
    }
}
