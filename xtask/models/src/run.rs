//! A training with its progress for a person who waits.

use std::fmt::Write;
use std::iter;
use std::time::Duration;

use anyhow::Result;
use aps_metrics::{GroupReport, Metric};
use aps_model::condition::InputKind;
use aps_model::train::StepReport;
use aps_report::numbers::duration;
use indicatif::{HumanDuration, ProgressBar};
use map2aps::training::{DevelopmentScores, Device, Run, RunFolder, Training};
use map2aps::{Progress, counted};
use xtask::progress::bar_of;
use xtask::{note, say};

/// Tells what begins.
fn announce(plan: &Training, run: &Run) {
    let (settings, trainer) = (run.settings(), run.trainer());
    if let Some(report) = run.initial_weights() {
        note!("initial weights: {}: {report}", plan.initial);
    }
    note!(
        "{} ({}, weights: {}), {} training links of {}, {} development links of {}, {input}, {} of {} links",
        settings.model,
        settings.preset,
        settings.initial_weights,
        settings.train_links,
        counted(settings.train_maps.len(), "map", "maps"),
        settings.dev_links,
        counted(settings.dev_maps.len(), "map", "maps"),
        match (trainer.steps_total(), trainer.config().budget_s) {
            (None, Some(budget_s)) => format!("{} of steps", duration(budget_s)),
            (steps, _) => counted(steps.unwrap_or_default(), "step", "steps"),
        },
        trainer.links_per_step(),
        input = match plan.model.input() {
            InputKind::Images => format!("images {0} x {0}", settings.image_size),
            InputKind::Polar => "ways along rays".into(),
        },
    );
    if plan.device != Device::Cpu {
        let place = |is_held| {
            if is_held {
                "on the device"
            } else {
                "sent with each batch"
            }
        };
        let held = trainer.held();
        let ways = match plan.model.input() {
            InputKind::Images => String::new(),
            InputKind::Polar => format!("; ways: {}", place(held.input)),
        };
        note!("targets: {}{ways}", place(held.targets));
    }
}

/// Prints the scores of the best weights beside those of the mean training spectrum.
pub fn print_scores(run: &Run, folder: &RunFolder) -> Result<()> {
    let scores = run.closing_scores()?;
    let (best, mean_spectrum) = (&scores.best, &scores.mean);
    let rows = [
        (format!("best, epoch {}", short(scores.best_epochs)), best),
        ("mean training spectrum".to_owned(), mean_spectrum),
    ];
    say!("{} development links:\n{}", scores.links, table(&rows))?;
    say!("best weights in '{}'", folder.best().display())?;
    let cosine = |group: &GroupReport| group.mean(Metric::Cosine);
    if cosine(best) <= cosine(mean_spectrum) {
        say!(
            "WARNING: the model's spectra are no more like the true ones (CosSim) than the mean training spectrum is: \
             it has not learnt; give it more links or epochs"
        )?;
    }
    Ok(())
}

/// Shows the share of the budget that is spent; an earlier run spent the second.
pub struct Bar(ProgressBar, f64);

/// Parts of a budget that a bar counts.
const PARTS: f64 = 1e4;

impl Bar {
    /// The bar of a training, which is announced.
    pub fn begin(plan: &Training, run: &Run) -> Self {
        announce(plan, run);
        let bar = bar_of(PARTS as u64, "[{bar:30}] {percent} %{msg}");
        let earlier = run.trainer().share();
        bar.set_position((earlier * PARTS) as u64);
        Self(bar, earlier)
    }

    /// Removes the bar, or leaves it where the training broke off.
    pub fn end(&self, is_whole: bool) {
        match is_whole {
            true => self.0.finish_and_clear(),
            false => self.0.abandon(),
        }
    }
}

impl Progress for Bar {
    fn step(&self, report: &StepReport) {
        self.0.set_position((report.share * PARTS) as u64);
        let (step, epoch, loss) = (report.step + 1, report.epoch + 1, report.loss);
        // The bar's own estimate tells 0 s until it has seen some seconds.
        let done = (report.share - self.1).max(f64::MIN_POSITIVE);
        let left_s = self.0.elapsed().as_secs_f64() * (1.0 - report.share).max(0.0) / done;
        let left = HumanDuration(Duration::from_secs(left_s.ceil() as u64));
        self.0.set_message(format!(
            ", {left:#} left, step {step}, epoch {epoch}, loss {loss:.4}"
        ));
    }

    fn scored(&self, scores: &DevelopmentScores) {
        let (chosen_by, group) = (scores.chosen_by, &scores.group);
        let others = [Metric::Cosine, Metric::PleDeg];
        let others = others.into_iter().filter(|&metric| metric != chosen_by);
        let shown: Vec<String> = iter::once(chosen_by)
            .chain(others)
            .filter_map(|metric| Some(format!("{} {:.4}", metric.label(), group.mean(metric)?)))
            .collect();
        self.0.println(format!(
            "epoch {}, step {}: training loss {:.4}; development {}{}",
            short(scores.epochs),
            scores.steps,
            scores.loss,
            shown.join(", "),
            if scores.is_best { ", best" } else { "" }
        ));
    }
}

/// A number of epochs with two decimals, or none if it is whole.
fn short(epochs: f64) -> String {
    match epochs.fract() == 0.0 {
        true => epochs.to_string(),
        false => format!("{epochs:.2}"),
    }
}

/// Means of the paper's columns, one row a name.
fn table(rows: &[(String, &GroupReport)]) -> String {
    let columns = || Metric::PAPER_COLUMNS.into_iter().chain([Metric::Mse]);
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut text = format!("{:width$}", "");
    for metric in columns() {
        let _ = write!(text, "  {:>10}", metric.heading());
    }
    for (name, group) in rows {
        let _ = write!(text, "\n{name:width$}");
        for metric in columns() {
            let mean = group
                .mean(metric)
                .map_or("-".into(), |mean| format!("{mean:.4}"));
            let _ = write!(text, "  {mean:>10}");
        }
    }
    text
}
