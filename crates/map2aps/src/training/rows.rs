//! Rows of the logs of a run: `steps.csv`, `scores.csv` and `times.csv`.

use aps_metrics::{GroupReport, Metric};
use aps_model::train::StepReport;

/// Names of [`step_cells`].
pub const STEP_COLUMNS: &str =
    "step,epoch,learning_rate,loss,gradient_norm,regularizer_loss,regularizer_gradient_norm";

/// Cells of the row of a step.
pub fn step_cells(report: &StepReport) -> [String; 7] {
    [
        report.step.to_string(),
        report.epoch.to_string(),
        report.learning_rate.to_string(),
        report.loss.to_string(),
        report.gradient_norm.to_string(),
        optional(report.regularizer_loss),
        optional(report.regularizer_gradient_norm),
    ]
}

fn optional(x: Option<f64>) -> String {
    x.map(|x| x.to_string()).unwrap_or_default()
}

/// Names of [`score_cells`].
pub fn score_columns() -> String {
    let metrics = Metric::ALL.map(|metric| format!(",dev_{}", metric.key()));
    format!("steps,epochs,train_loss{}", metrics.concat())
}

/// Cells of the row of scores of the development links after so many steps; `loss` is the mean since the row before.
pub fn score_cells(steps: u64, epochs: f64, loss: f64, scores: &GroupReport) -> Vec<String> {
    let mut cells = vec![steps.to_string(), epochs.to_string(), loss.to_string()];
    cells.extend(Metric::ALL.map(|metric| optional(scores.mean(metric))));
    cells
}

/// Names of [`time_cells`].
pub const TIME_COLUMNS: &str = "steps,seconds";

/// Cells of the time spent before the scores after so many steps.
pub fn time_cells(steps: u64, seconds: f64) -> [String; 2] {
    [steps.to_string(), seconds.to_string()]
}
