//! Means and intervals of everything that was scored.

use std::path::Path;

use aps_metrics::{Bootstrap, Estimate, Metric, Resamples};

use super::results::{Entry, Example, ProtocolScores, Results, TestLink};
use super::scores::ScoreTable;
use crate::ReportError;

/// Results with their scores, ready to be asked.
pub struct Analysis<'a> {
    /// The measurements.
    pub results: &'a Results,
    /// The drawing behind all intervals.
    pub bootstrap: Bootstrap,
    /// Scores of each entry, a protocol each.
    scored: Vec<Vec<Scored>>,
}

/// An entry under a protocol.
struct Scored {
    protocol: String,
    table: ScoreTable,
    /// Means over all links.
    means: Vec<(Metric, Estimate)>,
}

/// A group of links, with their places in the results.
pub struct Group {
    /// Name in words: `50 to 100 m`.
    pub name: String,
    /// Places of its links in the results.
    pub links: Vec<usize>,
    resamples: Resamples,
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
        let everything = group(results, bootstrap, "all".into(), (0..count).collect());
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

    /// The entries with scores, by falling mean of a metric of which more is better.
    pub fn ranked(&self, protocol: &str, metric: Metric) -> Vec<&'a Entry> {
        let mean = |entry: &'a Entry| Some((entry, self.mean(entry, protocol, metric)?.mean));
        let mut entries: Vec<_> = self.results.entries.iter().filter_map(mean).collect();
        entries.sort_by(|a, b| b.1.total_cmp(&a.1));
        entries.into_iter().map(|(entry, _)| entry).collect()
    }

    /// Groups links for which `of` returns the same name; by rising place.
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
        let make = |(_, name, links)| group(self.results, self.bootstrap, name, links);
        found.into_iter().map(make).collect()
    }
}

/// Times a link of an entry \[ms\], that of the smallest batch first.
pub fn times(entry: &Entry) -> Vec<f64> {
    let mut all: Vec<_> = entry.latency.iter().collect();
    all.sort_by_key(|l| l.batch);
    all.into_iter().map(|l| l.total_ms_per_link()).collect()
}

fn group(results: &Results, bootstrap: Bootstrap, name: String, links: Vec<usize>) -> Group {
    let cluster = |&i: &usize| (results.links[i].map, results.links[i].tx);
    let clusters: Vec<(u32, u32)> = links.iter().map(cluster).collect();
    Group {
        name,
        links,
        resamples: bootstrap
            .draw(&clusters)
            .expect("the default level, and links that were read"),
    }
}
