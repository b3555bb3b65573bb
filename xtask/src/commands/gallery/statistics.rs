//! Numbers over a sample of the links of a data set.

use anyhow::Result;
use aps_label::Labeler;
use aps_report::document::{Figure, Section, Table};
use aps_report::link::{LinkView, Spectrum, dominant_peaks};
use aps_report::numbers::count;

use super::charts;
use crate::source::{Source, SourceMap};

/// Figures of the paper's test links.
pub const PAPER_MEAN_PEAKS: f64 = 2.28;
const PAPER_AT_MOST_TWO: f64 = 75.0;

/// One value a sampled link with a label; empty lists for what the data set does not tell.
#[derive(Default)]
pub struct Values {
    pub distance_m: Vec<f64>,
    pub dominant_peaks: Vec<u64>,
    pub paths: Vec<u64>,
    pub path_loss_db: Vec<f64>,
    pub delay_spread_ns: Vec<f64>,
    pub line_of_sight: u64,
}

/// The statistics in the making.
pub struct Statistics<'a> {
    source: &'a Source,
    values: Values,
}

impl<'a> Statistics<'a> {
    pub fn new(source: &'a Source) -> Self {
        Self {
            source,
            values: Values::default(),
        }
    }

    /// Counts some links with labels, given by their rows and the paths known of them.
    pub fn add(&mut self, map: &SourceMap, rows: &[usize], links: &[LinkView]) -> Result<()> {
        let v = &mut self.values;
        let protocol = self.source.label().protocol;
        let labeler = Labeler::new(self.source.label())?;
        for (&row, link) in rows.iter().zip(links) {
            v.distance_m.push(link.distance_m());
            if let Some(aps) = &map.data.aps {
                let mut relative = vec![0.0; aps.bins()];
                aps.read_relative_db(row, &mut relative);
                let shape: Vec<f64> = relative.iter().map(|&db| f64::from(db)).collect();
                let peaks = dominant_peaks(&shape, protocol);
                v.dominant_peaks.push(peaks.dominant().len() as u64);
            } else if let Some(spectrum) = Spectrum::of(&labeler, &link.samples())? {
                v.dominant_peaks
                    .push(spectrum.dominant_peaks().dominant().len() as u64);
            }
            if map.has_paths() {
                v.paths.push(link.paths.len() as u64);
                v.path_loss_db.extend(link.path_loss_db());
                v.delay_spread_ns
                    .extend(link.delay_spread_s().map(|s| s * 1e9));
                v.line_of_sight += u64::from(link.has_line_of_sight());
            }
        }
        Ok(())
    }

    /// One sentence on the whole.
    pub fn summary(&self) -> String {
        let totals = &self.source.dataset().manifest().totals;
        let valid = totals.status.get("valid").copied().unwrap_or(0);
        format!(
            "{} maps, {} links, {} of them with a label of the {} protocol ({:.2} %).",
            totals.maps,
            count(totals.links),
            count(valid),
            self.source.label().protocol,
            100.0 * valid as f64 / totals.links.max(1) as f64
        )
    }

    /// The section of the page.
    pub fn section(&self) -> Section {
        let v = &self.values;
        let totals = &self.source.dataset().manifest().totals;
        let valid = totals.status.get("valid").copied().unwrap_or(0);
        let sampled = v.distance_m.len() as u64;
        let mut section = Section::new("Statistics");
        section.text(match sampled == valid {
            true => format!("Over all {} links with a label.", count(valid)),
            false => format!(
                "Over a random sample of {} of the {} links with a label, drawn from all maps; only the counts of links are of all.",
                count(sampled),
                count(valid)
            ),
        });
        if v.paths.is_empty() {
            section.text(
                "The data set stores no paths, so paths, path loss, delay spread and line of sight are not shown. \
                 They are traced again where the maps are given with --maps.",
            );
        }
        section.table(self.table());
        section.table(self.states());
        section.figures(self.figures());
        section
    }

    fn table(&self) -> Table {
        let v = &self.values;
        let mut table = Table::new(
            "",
            ["of a link with a label", "mean", "5 %", "median", "95 %"],
        );
        let floats = |counts: &[u64]| counts.iter().map(|&n| n as f64).collect::<Vec<f64>>();
        for (name, values, decimals) in [
            ("distance [m]", v.distance_m.clone(), 0),
            ("dominant peaks", floats(&v.dominant_peaks), 2),
            ("paths", floats(&v.paths), 1),
            ("path loss [dB]", v.path_loss_db.clone(), 1),
            ("delay spread [ns]", v.delay_spread_ns.clone(), 1),
        ] {
            // None without values.
            if let Some(d) = aps_metrics::Distribution::of(values) {
                let numbers = [d.mean, d.q05, d.median, d.q95].map(|x| format!("{x:.decimals$}"));
                table = table.row([name.to_owned()].into_iter().chain(numbers));
            }
        }
        table
    }

    /// Links with a label, and why others have none; most first.
    fn states(&self) -> Table {
        let totals = &self.source.dataset().manifest().totals;
        let mut states: Vec<_> = totals.status.iter().collect();
        states.sort_by(|p, q| q.1.cmp(p.1));
        let share = |n: u64| format!("{:.1}", 100.0 * n as f64 / totals.links.max(1) as f64);
        let row =
            |(name, &n): (&String, &u64)| vec![name.replace('_', " "), n.to_string(), share(n)];
        Table::new("", ["state of a link", "links", "share [%]"]).rows(states.into_iter().map(row))
    }

    fn figures(&self) -> Vec<Figure> {
        let v = &self.values;
        let mut figures = Vec::new();
        if let Some(chart) = charts::dominant_peaks(&v.dominant_peaks) {
            figures.push(Figure::shown(self.peaks_caption(), chart));
        }
        figures.push(Figure::shown(
            "Distance of transmitter and receiver.",
            charts::distance(&v.distance_m),
        ));
        if !v.paths.is_empty() {
            let sight = 100.0 * v.line_of_sight as f64 / v.paths.len() as f64;
            figures.push(Figure::shown(
                format!("Paths of a link. {sight:.1} % of the links have a line of sight."),
                charts::paths(&v.paths),
            ));
            figures.push(Figure::shown(
                "Path loss: minus the gain of all paths together, their powers added.",
                charts::path_loss(&v.path_loss_db),
            ));
            figures.push(Figure::shown("Delay spread: standard deviation of the delay, paths weighted by power. The few largest values are left out.", charts::delay_spread(&v.delay_spread_ns)));
        }
        figures
    }

    fn peaks_caption(&self) -> String {
        let peaks = &self.values.dominant_peaks;
        let n = peaks.len().max(1) as f64;
        let mean = peaks.iter().sum::<u64>() as f64 / n;
        let at_most_two = 100.0 * peaks.iter().filter(|&&k| k <= 2).count() as f64 / n;
        format!(
            "Dominant peaks of a spectrum, {} protocol: {mean:.2} on average, at most two in {at_most_two:.1} % of the links. \
             The paper's test links have {PAPER_MEAN_PEAKS} and {PAPER_AT_MOST_TWO} %.",
            self.source.label().protocol
        )
    }
}
