//! The metric by which the best weights are chosen.

use aps_metrics::{Better, GroupReport, Metric};
use aps_model::{Loss, ModelKind};

/// Choice of the best weights among those that are scored on the development links.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Selection {
    /// By the error that the training minimises: the mean squared error, or the mean absolute error of models whose loss holds it.
    #[default]
    Loss,
    /// By the mean of a metric.
    Metric(Metric),
}

impl Selection {
    /// Returns the metric for a model.
    pub fn metric(self, model: ModelKind) -> Metric {
        match (self, model.loss()) {
            (Self::Metric(metric), _) => metric,
            (Self::Loss, Loss::Squared) => Metric::Mse,
            (Self::Loss, _) => Metric::Mae,
        }
    }
}

/// The mean of a metric as a number that is the less the better; infinite without one.
pub(super) fn cost(group: &GroupReport, metric: Metric) -> f64 {
    let mean = group.mean(metric);
    let cost = match metric.better() {
        Better::Lower => mean,
        Better::Higher => mean.map(|mean| -mean),
    };
    cost.unwrap_or(f64::INFINITY)
}
