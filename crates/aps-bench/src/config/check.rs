//! Settings out of range.

use aps_model::ModelKind;

use super::Config;
use crate::error::{Error, Result};

impl Config {
    /// Makes sure that every setting is in its range.
    ///
    /// # Errors
    /// [`Error::Setting`], which names it.
    pub fn check(&self) -> Result<()> {
        for name in self.model.keys() {
            name.parse::<ModelKind>()?;
        }
        let data = &self.data;
        let smallest_batch = self.latency.batches.iter().copied().min();
        let counts = [
            ("data.train_maps", data.train_maps),
            ("data.develop_maps", data.develop_maps),
            ("data.test_maps", data.test_maps),
            ("data.tx_per_map", data.tx_per_map),
            ("data.rx_per_map", data.rx_per_map),
            ("data.test_links", data.test_links.unwrap_or(1)),
            ("latency.batches", smallest_batch.unwrap_or(0)),
        ];
        for (key, value) in counts {
            must(value > 0, || format!("{key} must be at least 1"))?;
        }
        let seconds = self.latency.seconds;
        must(seconds >= 0.0 && seconds.is_finite(), || {
            format!("latency.seconds is {seconds}: must be finite and not negative")
        })?;
        let both = "training.budget and training.epochs both end a training: give one of them";
        let is_one = self.training.epochs.is_none() || self.training.budget.is_none();
        must(is_one, || both.into())?;
        self.budget_s().map(|_| ())
    }
}

fn must(holds: bool, told: impl FnOnce() -> String) -> Result<()> {
    match holds {
        true => Ok(()),
        false => Err(Error::Setting(told())),
    }
}
