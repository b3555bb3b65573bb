//! Schedule of the learning rate over a run.

/// A straight line up, then a straight line down to zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Schedule {
    /// The highest rate, that of step `warmup` - 1.
    pub peak: f64,
    /// Steps on which the rate rises; 0 starts at the peak.
    pub warmup: u64,
    /// Number of all steps; the rate is 0 from this step on, and positive before.
    pub total: u64,
}

impl Schedule {
    /// Returns the rate of a step; the first is step 0.
    pub fn at(&self, step: u64) -> f64 {
        if step < self.warmup.min(self.total) {
            return self.peak * (step + 1) as f64 / self.warmup as f64;
        }
        let left = self.total.saturating_sub(step);
        let way_down = self.total.saturating_sub(self.warmup) + u64::from(self.warmup > 0);
        self.peak * left as f64 / way_down.max(1) as f64
    }
}
