//! Numbers over a sample of the links of a data set.

use aps_data::Totals;
use aps_label::Protocol;

use super::charts;
use crate::document::{Figure, Section, Table};
use crate::link::LinkView;
use crate::numbers::count;

/// Figures of the paper's test links.
pub const PAPER_MEAN_PEAKS: f64 = 2.28;
const PAPER_AT_MOST_TWO: f64 = 75.0;

/// Counts of a whole data set, and one value a sampled link with a label.
#[derive(Debug, Clone)]
pub struct Statistics {
    protocol: Protocol,
    totals: Totals,
    distance_m: Vec<f64>,
    dominant_peaks: Vec<u64>,
    paths: Vec<u64>,
    path_loss_db: Vec<f64>,
    delay_spread_ns: Vec<f64>,
    line_of_sight: u64,
}

impl Statistics {
    /// Statistics of a data set with labels of a protocol, without a link yet.
    pub fn new(protocol: Protocol, totals: Totals) -> Self {
        Self {
            protocol,
            totals,
            distance_m: Vec::new(),
            dominant_peaks: Vec::new(),
            paths: Vec::new(),
            path_loss_db: Vec::new(),
            delay_spread_ns: Vec::new(),
            line_of_sight: 0,
        }
    }

    /// Counts a link with a label: its dominant peaks, if its spectrum is known, and its paths, unless they are unknown.
    pub fn add(&mut self, link: &LinkView, dominant_peaks: Option<usize>, has_paths: bool) {
        self.distance_m.push(link.distance_m());
        self.dominant_peaks.extend(dominant_peaks.map(|n| n as u64));
        if has_paths {
            self.paths.push(link.paths.len() as u64);
            self.path_loss_db.extend(link.path_loss_db());
            self.delay_spread_ns
                .extend(link.delay_spread_s().map(|s| s * 1e9));
            self.line_of_sight += u64::from(link.has_line_of_sight());
        }
    }

    /// The section of the page.
    pub fn section(&self) -> Section {
        let valid = self.totals.valid();
        let sampled = self.distance_m.len() as u64;
        let mut section = Section::new("Statistics");
        section.text(match sampled == valid {
            true => format!("Over all {} links with a label.", count(valid)),
            false => format!(
                "Over a random sample of {} of the {} links with a label, drawn from all maps; only the counts of links are of all.",
                count(sampled),
                count(valid)
            ),
        });
        if self.paths.is_empty() {
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
        let mut table = Table::new(
            "",
            ["of a link with a label", "mean", "5 %", "median", "95 %"],
        );
        let floats = |counts: &[u64]| counts.iter().map(|&n| n as f64).collect::<Vec<f64>>();
        for (name, values, decimals) in [
            ("distance [m]", self.distance_m.clone(), 0),
            ("dominant peaks", floats(&self.dominant_peaks), 2),
            ("paths", floats(&self.paths), 1),
            ("path loss [dB]", self.path_loss_db.clone(), 1),
            ("delay spread [ns]", self.delay_spread_ns.clone(), 1),
        ] {
            // None without values.
            if let Some(d) = aps_metrics::Distribution::of(values) {
                let numbers = [d.mean, d.q05, d.median, d.q95].map(|x| format!("{x:.decimals$}"));
                table = table.row([name.to_owned()].into_iter().chain(numbers));
            }
        }
        table
    }

    /// Table of the states of links: labelled, or the reason why not, the most frequent first.
    fn states(&self) -> Table {
        let (maps, links) = (self.totals.maps, self.totals.links);
        let caption = format!(
            "Links of {maps} maps, labels of the {} protocol",
            self.protocol
        );
        let all = "all".to_owned();
        let mut states = vec![(&all, &links)];
        states.extend(&self.totals.status);
        states.sort_by(|p, q| q.1.cmp(p.1));
        let share = |n: u64| format!("{:.1}", 100.0 * n as f64 / links.max(1) as f64);
        let row =
            |(name, &n): (&String, &u64)| vec![name.replace('_', " "), n.to_string(), share(n)];
        let head = ["state of a link", "links", "share [%]"];
        Table::new(caption, head).rows(states.into_iter().map(row))
    }

    fn figures(&self) -> Vec<Figure> {
        let mut figures = Vec::new();
        let mut add = |caption: &str, drawing| figures.push(Figure::shown(caption, drawing));
        if let Some(chart) = charts::dominant_peaks(&self.dominant_peaks) {
            add(&self.peaks_caption(), chart);
        }
        let distances = charts::distance(&self.distance_m);
        add("Distance of transmitter and receiver.", distances);
        if !self.paths.is_empty() {
            let sight = 100.0 * self.line_of_sight as f64 / self.paths.len() as f64;
            let caption =
                format!("Paths of a link. {sight:.1} % of the links have a line of sight.");
            add(&caption, charts::paths(&self.paths));
            let caption = "Path loss: minus the gain of all paths together, their powers added.";
            add(caption, charts::path_loss(&self.path_loss_db));
            let caption = "Delay spread: standard deviation of the delay, paths weighted by power. \
                           The few largest values are left out.";
            add(caption, charts::delay_spread(&self.delay_spread_ns));
        }
        figures
    }

    fn peaks_caption(&self) -> String {
        let peaks = &self.dominant_peaks;
        let n = peaks.len().max(1) as f64;
        let mean = peaks.iter().sum::<u64>() as f64 / n;
        let at_most_two = 100.0 * peaks.iter().filter(|&&k| k <= 2).count() as f64 / n;
        format!(
            "Dominant peaks of a spectrum, {} protocol: {mean:.2} on average, at most two in {at_most_two:.1} % of the links. \
             The paper's test links have {PAPER_MEAN_PEAKS} and {PAPER_AT_MOST_TWO} %.",
            self.protocol
        )
    }
}
