//! Means, intervals and comparisons of everything that was scored.

use std::path::Path;

use aps_metrics::{Better, Bootstrap, Estimate, Metric, Resamples};

use super::results::{Entry, EntryKind, Example, Latency, ProtocolScores, Results, TestLink};
use super::scores::ScoreTable;
use crate::ReportError;

/// The metrics shown where there is no room for all.
pub const HEADLINE: [Metric; 3] = [Metric::Cosine, Metric::PleDeg, Metric::Recall4Deg];

/// Results with their scores, ready to be asked.
pub struct Analysis<'a> {
    /// The measurements.
    pub results: &'a Results,
    /// The drawing behind all intervals.
    pub bootstrap: Bootstrap,
    /// Scores of each entry, a protocol each.
    scored: Vec<Vec<Scored>>,
    everything: Group,
}

/// An entry under a protocol.
struct Scored {
    protocol: String,
    table: ScoreTable,
    /// Over all links.
    means: Vec<(Metric, Estimate)>,
}

/// A group of links, with their places in the results.
pub struct Group {
    /// In words: `50 to 100 m`.
    pub name: String,
    /// Its place on an axis.
    pub at: f64,
    /// Places of its links in the results.
    pub links: Vec<usize>,
    resamples: Resamples,
}

/// The lead of one entry over another, link by link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Above 0 if it is better, whichever way the metric runs.
    pub estimate: Estimate,
}

/// The sign of a gain, as far as its interval tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Verdict {
    /// The interval lies above 0.
    Better,
    /// The interval holds 0.
    Undecided,
    /// The interval lies below 0.
    Worse,
}

impl Verdict {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Undecided => "undecided",
            Self::Worse => "worse",
        }
    }
}

impl Gain {
    /// Its sign, as far as its interval tells it.
    pub fn verdict(&self) -> Verdict {
        match self.estimate {
            e if e.low > 0.0 => Verdict::Better,
            e if e.high < 0.0 => Verdict::Worse,
            _ => Verdict::Undecided,
        }
    }
}

impl<'a> Analysis<'a> {
    /// Reads the scores that results name, which lie in `folder`.
    ///
    /// # Errors
    /// Scores that cannot be read or do not fit the links; names that are not unique; examples of
    /// links that are not there.
    pub fn new(results: &'a Results, folder: &Path) -> Result<Self, ReportError> {
        let count = results.links.len();
        let refuse = |why: String| Err(ReportError::Results(why));
        if count == 0 {
            return refuse("these results hold no test links: nothing to report".into());
        }
        for (i, entry) in results.entries.iter().enumerate() {
            if results.entries[..i].iter().any(|e| e.name == entry.name) {
                return refuse(format!("two entries are named '{}'", entry.name));
            }
        }
        if let Some(Example { link, .. }) = results.examples.iter().find(|e| e.link >= count) {
            return refuse(format!("an example shows link {link}; there are {count}"));
        }
        let bootstrap = Bootstrap::default();
        let all = (0..count).collect();
        let everything = group(results, bootstrap, "all".into(), 0.0, all);
        let read = |entry: &Entry| -> Result<Vec<Scored>, ReportError> {
            let one = |scores: &ProtocolScores| -> Result<Scored, ReportError> {
                let table = ScoreTable::read(folder, scores, count)?;
                let mean = |metric: Metric| {
                    let values = table.column(metric)?;
                    Some((metric, everything.resamples.mean(values).ok()??))
                };
                Ok(Scored {
                    protocol: scores.protocol.clone(),
                    means: Metric::ALL.into_iter().filter_map(mean).collect(),
                    table,
                })
            };
            let scored: Result<_, _> = entry.scores.iter().map(one).collect();
            scored.map_err(|source| ReportError::Scores {
                name: entry.name.clone(),
                source: Box::new(source),
            })
        };
        Ok(Self {
            results,
            bootstrap,
            scored: results.entries.iter().map(read).collect::<Result<_, _>>()?,
            everything,
        })
    }

    /// The protocols scored under, that of the labels first.
    pub fn protocols(&self) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        for scored in self.scored.iter().flatten() {
            if !found.contains(&scored.protocol) {
                found.push(scored.protocol.clone());
            }
        }
        found.sort_by_key(|p| *p != self.results.data.protocol);
        found
    }

    /// The protocol of figures and claims.
    pub fn main_protocol(&self) -> String {
        self.protocols().into_iter().next().unwrap_or_default()
    }

    /// An entry by its name.
    pub fn entry(&self, name: &str) -> Option<&'a Entry> {
        self.results.entries.iter().find(|e| e.name == name)
    }

    /// Entries of some kinds, in their order.
    pub fn of_kinds(&self, kinds: &[EntryKind]) -> Vec<&'a Entry> {
        let is_asked = |e: &&Entry| kinds.contains(&e.kind);
        self.results.entries.iter().filter(is_asked).collect()
    }

    /// Learned entries: models, ablations and predictions from outside.
    pub fn learned(&self) -> Vec<&'a Entry> {
        self.of_kinds(&[EntryKind::Model, EntryKind::Ablation, EntryKind::External])
    }

    /// One value a link.
    pub fn column(&self, entry: &Entry, protocol: &str, metric: Metric) -> Option<&[f64]> {
        self.scored(entry, protocol)?.table.column(metric)
    }

    /// Mean over all links.
    pub fn mean(&self, entry: &Entry, protocol: &str, metric: Metric) -> Option<Estimate> {
        let means = &self.scored(entry, protocol)?.means;
        Some(means.iter().find(|m| m.0 == metric)?.1)
    }

    fn scored(&self, entry: &Entry, protocol: &str) -> Option<&Scored> {
        let entries = &self.results.entries;
        let at = entries.iter().position(|e| e.name == entry.name)?;
        self.scored[at].iter().find(|s| s.protocol == protocol)
    }

    /// Mean over some links.
    pub fn mean_in(
        &self,
        group: &Group,
        entry: &Entry,
        protocol: &str,
        metric: Metric,
    ) -> Option<Estimate> {
        let column = self.column(entry, protocol, metric)?;
        let values: Vec<f64> = group.links.iter().map(|&i| column[i]).collect();
        group.resamples.mean(&values).ok()?
    }

    /// The lead of `entry` over `other`, on the same links.
    pub fn gain(
        &self,
        entry: &Entry,
        other: &Entry,
        protocol: &str,
        metric: Metric,
    ) -> Option<Gain> {
        let mine = self.column(entry, protocol, metric)?;
        let theirs = self.column(other, protocol, metric)?;
        let sign = match metric.better() {
            Better::Higher => 1.0,
            Better::Lower => -1.0,
        };
        let pairs = mine.iter().zip(theirs);
        let values: Vec<f64> = pairs.map(|(a, b)| sign * (a - b)).collect();
        let estimate = self.everything.resamples.mean(&values).ok()??;
        Some(Gain { estimate })
    }

    /// The entry with the best mean; the first of equals.
    pub fn best<'e>(
        &self,
        entries: &[&'e Entry],
        protocol: &str,
        metric: Metric,
    ) -> Option<&'e Entry> {
        let mut best: Option<(&Entry, f64)> = None;
        for &entry in entries {
            let Some(mean) = self.mean(entry, protocol, metric) else {
                continue;
            };
            if best.is_none_or(|(_, value)| is_better(metric, mean.mean, value)) {
                best = Some((entry, mean.mean));
            }
        }
        best.map(|b| b.0)
    }

    /// Groups links for which `of` returns the same place on an axis and name; by rising place.
    pub fn groups(&self, of: impl Fn(&TestLink) -> (f64, String)) -> Vec<Group> {
        let mut found: Vec<(f64, String, Vec<usize>)> = Vec::new();
        for (i, link) in self.results.links.iter().enumerate() {
            let (at, name) = of(link);
            match found.iter_mut().find(|g| g.1 == name) {
                Some(group) => group.2.push(i),
                None => found.push((at, name, vec![i])),
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let make = |(at, name, links)| group(self.results, self.bootstrap, name, at, links);
        found.into_iter().map(make).collect()
    }

    /// Sizes of batches that were timed, ascending.
    pub fn batches(&self) -> Vec<usize> {
        let timed = self.results.entries.iter().flat_map(|e| &e.latency);
        let mut batches: Vec<usize> = timed.map(|l| l.batch).collect();
        batches.sort_unstable();
        batches.dedup();
        batches
    }
}

/// Tells if a value is strictly better than another.
pub fn is_better(metric: Metric, value: f64, other: f64) -> bool {
    match metric.better() {
        Better::Higher => value > other,
        Better::Lower => value < other,
    }
}

/// Run time of an entry for a batch; for entries timed with one batch size alone, the time for that one.
pub fn latency_at(entry: &Entry, batch: usize) -> Option<&Latency> {
    let exact = entry.latency.iter().find(|l| l.batch == batch);
    exact.or(match &entry.latency[..] {
        [only] => Some(only),
        _ => None,
    })
}

fn group(
    results: &Results,
    bootstrap: Bootstrap,
    name: String,
    at: f64,
    links: Vec<usize>,
) -> Group {
    let cluster = |&i: &usize| (results.links[i].map, results.links[i].tx);
    let clusters: Vec<(u32, u32)> = links.iter().map(cluster).collect();
    Group {
        name,
        at,
        links,
        resamples: bootstrap.draw(&clusters),
    }
}
