//! The scores in the forms people and programs read.

use crate::{note, output};
use std::io::Write;
use std::path::Path;

use anyhow::Result;
use aps_label::MeanStd;
use aps_metrics::{GroupReport, Metric};
use clap::ValueEnum;
use map2aps::{Scores, Truth};
use serde_json::json;

/// Forms of the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Means in the paper's columns, aligned.
    Table,
    /// Everything: all metrics with mean, deviation and quantiles, overall and a map.
    Json,
    /// The same, one line a metric and group of samples.
    Csv,
    /// Means in the paper's columns, for a README.
    Markdown,
}

/// Rejected samples that JSON lists one by one.
const LISTED: usize = 100;

/// Scores of a prediction, with everything that is printed or written about it.
pub struct Printed<'a> {
    pub truth: &'a Truth,
    pub prediction: &'a Path,
    pub scores: &'a Scores,
}

impl Printed<'_> {
    /// Tells on standard error of samples that are in no mean, whatever the format.
    pub fn warn(&self) {
        let rejected = self.scores.evaluation.rejected();
        if let Some(first) = rejected.first() {
            note!(
                "WARNING: {} of {} samples are NOT scored and in no mean \
                 (NaN or infinite: {} predictions, {} truths); the first: sample {}, {}",
                rejected.len(),
                self.scores.evaluation.samples(),
                self.scores.report.rejected_predictions,
                self.scores.report.rejected_truths,
                first.sample,
                first.defect
            );
        }
        let maximum = self.scores.evaluation.truth_maximum();
        if maximum.is_some_and(|maximum| maximum <= 0.0) {
            note!(
                "WARNING: no true value is above 0: metrics are of linear power or of normalised spectra, not of decibels; \
                 10**((db - db.max(axis=1, keepdims=True)) / 10) makes these linear"
            );
        }
    }

    /// Prints the scores.
    pub fn print(&self, format: Format) -> Result<()> {
        let mut out = output::stdout();
        match format {
            Format::Table => self.table(&mut out)?,
            Format::Markdown => self.markdown(&mut out)?,
            Format::Json => self.json(&mut out)?,
            Format::Csv => self.csv(&mut out)?,
        }
        Ok(())
    }

    fn table(&self, out: &mut impl Write) -> Result<()> {
        writeln!(out, "{}", self.truth)?;
        writeln!(out, "prediction '{}'", self.prediction.display())?;
        let rows = self.cells();
        let columns = rows[0].len();
        let width = |c: usize| rows.iter().map(|row| row[c].len()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &rows {
            let cells = row.iter().zip(&widths);
            let padded: Vec<String> = cells
                .map(|(cell, &width)| format!("{cell:>width$}"))
                .collect();
            writeln!(out, "{}", padded.join("  "))?;
        }
        writeln!(out, "{}", self.remarks().join("\n"))?;
        Ok(())
    }

    fn markdown(&self, out: &mut impl Write) -> Result<()> {
        let rows = self.cells();
        for (i, row) in rows.iter().enumerate() {
            writeln!(out, "| {} |", row.join(" | "))?;
            if i == 0 {
                writeln!(out, "|{}", "---:|".repeat(row.len()))?;
            }
        }
        writeln!(out, "\n{}", self.remarks().join("; "))?;
        Ok(())
    }

    fn json(&self, out: &mut impl Write) -> Result<()> {
        let rejected = self.scores.evaluation.rejected();
        let value = json!({
            "protocol": self.scores.protocol,
            "truth": self.truth.describe(),
            "prediction": self.prediction.display().to_string(),
            "samples": self.scores.evaluation.samples(),
            "rejected": rejected.len(),
            "first_rejected": &rejected[..rejected.len().min(LISTED)],
            "report": self.scores.report,
        });
        serde_json::to_writer_pretty(&mut *out, &value)?;
        writeln!(out)?;
        Ok(())
    }

    fn csv(&self, out: &mut impl Write) -> Result<()> {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record([
            "protocol", "group", "samples", "rejected", "metric", "unit", "mean", "std", "min",
            "q05", "q25", "median", "q75", "q95", "max",
        ])?;
        for (name, rejected, group) in self.groups() {
            for m in &group.metrics {
                let d = &m.distribution;
                let mut record = vec![
                    self.scores.protocol.name().to_owned(),
                    name.clone(),
                    group.samples.to_string(),
                    rejected.to_string(),
                    m.metric.key().to_owned(),
                    m.metric.unit().to_owned(),
                ];
                let numbers = [
                    d.mean, d.std, d.min, d.q05, d.q25, d.median, d.q75, d.q95, d.max,
                ];
                record.extend(numbers.map(|x| x.to_string()));
                csv.write_record(&record)?;
            }
        }
        csv.flush()?;
        Ok(())
    }

    /// Name, number of rejected samples and report of all samples, then of each map.
    fn groups(&self) -> Vec<(String, usize, &GroupReport)> {
        let rejected = self.scores.evaluation.rejected();
        let report = &self.scores.report;
        let all = ("all".to_owned(), rejected.len(), &report.overall);
        let maps = report.maps.iter().map(|map| {
            let id = Some(map.map_id);
            let of_map = rejected.iter().filter(|r| r.map_id == id).count();
            (format!("map {}", map.map_id), of_map, &map.group)
        });
        [all].into_iter().chain(maps).collect()
    }

    /// Headings and means: the paper's columns in its order, then the mirror-aware ones.
    fn cells(&self) -> Vec<Vec<String>> {
        let columns = [&Metric::PAPER_COLUMNS[..], &Metric::MIRROR_COLUMNS].concat();
        let columns = || columns.iter().copied();
        let named = |names: [&str; 3]| names.map(str::to_owned).into_iter();
        let mut rows = vec![
            named(["", "samples", "rejected"])
                .chain(columns().map(Metric::heading))
                .collect(),
        ];
        for (name, rejected, group) in self.groups() {
            let counts = [group.samples.to_string(), rejected.to_string()];
            let means = columns().map(|metric| match group.get(metric) {
                Some(d) => format!("{:.*}", metric.decimals(), d.mean),
                None => "-".into(),
            });
            rows.push([name].into_iter().chain(counts).chain(means).collect());
        }
        rows
    }

    fn remarks(&self) -> Vec<String> {
        let report = &self.scores.report;
        let (samples, peaks) = (report.overall.samples, &report.overall.peaks);
        let (name, range) = (self.scores.protocol.name(), report.data_range.get());
        let share = |count: usize| count as f64 / samples.max(1) as f64;
        let mut remarks = Vec::new();
        match self.truth.target() {
            None => {}
            Some((_, Some(MeanStd { mean, std }))) => remarks.push(format!(
                "compared as normalised target: training mean {mean:.6}, std {std:.6}"
            )),
            Some(_) => remarks.push("compared as linear power relative to the maximum".into()),
        }
        remarks.extend([
            format!("means under the {name} protocol; PSNR relative to a range of {range:.6}"),
            format!(
                "{:.2} dominant true peaks a sample, at most two in {:.1} %; \
                 without a peak: {} truths, {} predictions",
                share(peaks.dominant_true_peaks),
                100.0 * share(peaks.at_most_two),
                peaks.truths_without_peak,
                peaks.predictions_without_peak
            ),
        ]);
        let (predictions, truths) = (report.rejected_predictions, report.rejected_truths);
        if predictions + truths > 0 {
            remarks.push(format!(
                "NOT SCORED, in no mean: {predictions} predictions and {truths} truths \
                 with NaN or an infinity"
            ));
        }
        remarks
    }
}
