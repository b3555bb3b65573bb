//! Schedule of the learning rate over a training's budget.

/// Share of a time budget in which the learning rate rises at most; of a step budget as much.
const WARMUP_SHARE: f64 = 0.1;

/// End of a training.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Budget {
    /// Number of steps.
    Steps(u64),
    /// Wall time \[s\].
    Seconds(f64),
}

/// A straight line up, then a straight line down to zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Schedule {
    /// The highest rate.
    pub peak: f64,
    /// Steps on which the rate rises, within a tenth of the budget; 0 starts at the peak.
    pub warmup: u64,
    /// The rate is 0 from its end on, and positive before.
    pub budget: Budget,
}

impl Schedule {
    /// Returns the rate of a step, the first being step 0, that begins when so many seconds are spent.
    pub fn at(&self, step: u64, seconds: f64) -> f64 {
        match self.budget {
            Budget::Steps(total) => {
                let warmup = self.warmup.min(total / 10);
                if step < warmup {
                    return self.peak * (step + 1) as f64 / warmup as f64;
                }
                let left = total.saturating_sub(step);
                let way_down = total.saturating_sub(warmup) + u64::from(warmup > 0);
                self.peak * left as f64 / way_down.max(1) as f64
            }
            Budget::Seconds(_) => {
                // How many steps there will be is not known: the rate falls over the last nine tenths, however short the rise was.
                let share = self.share(step, seconds);
                let by_steps = (step + 1) as f64 / self.warmup.max(1) as f64;
                let rise = by_steps.max(share / WARMUP_SHARE).min(1.0);
                let fall = (1.0 - share) / (1.0 - WARMUP_SHARE);
                self.peak * rise.min(fall)
            }
        }
    }

    /// Returns the share of the budget that is spent after so many steps and seconds, from 0 to 1.
    pub fn share(&self, steps: u64, seconds: f64) -> f64 {
        let share = match self.budget {
            Budget::Steps(total) => steps as f64 / total.max(1) as f64,
            Budget::Seconds(total) => seconds / total,
        };
        share.min(1.0)
    }
}
