//! Error against time: the front that nothing beats, and what is off it.

use crate::benchmark::words;
use crate::chart::{Axis, Chart, Mark, Series, Spot};
use crate::theme::Colour;

/// One setting: what it costs and how far off it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Kind of setting: a colour in the chart.
    pub group: String,
    /// What it is called in words.
    pub name: String,
    /// In the unit of the time axis; positive.
    pub time: f64,
    /// In the unit of the error axis; not negative.
    pub error: f64,
}

/// Which settings a chart names besides those on the front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Marked<'n> {
    /// All of them.
    All,
    /// Those of these names.
    Only(&'n [&'n str]),
}

impl Marked<'_> {
    fn holds(self, choice: &Choice) -> bool {
        match self {
            Self::All => true,
            Self::Only(names) => names.contains(&&*choice.name),
        }
    }
}

/// Settings that are compared.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trade {
    /// In the order of the key.
    pub choices: Vec<Choice>,
}

impl Trade {
    /// Adds a setting.
    pub fn add(&mut self, group: &str, name: impl Into<String>, time: f64, error: f64) {
        self.choices.push(Choice {
            group: group.into(),
            name: name.into(),
            time,
            error,
        });
    }

    /// Those nothing beats, the fastest first; an error smaller by less than a hundredth is none.
    pub fn front(&self) -> Vec<&Choice> {
        let mut sorted: Vec<&Choice> = self.choices.iter().collect();
        sorted.sort_by(|p, q| p.time.total_cmp(&q.time).then(p.error.total_cmp(&q.error)));
        let mut best = f64::INFINITY;
        sorted.retain(|choice| {
            let is_better = choice.error < 0.99 * best;
            if is_better {
                best = choice.error;
            }
            is_better
        });
        sorted
    }

    /// The fastest setting that is clearly faster than this one (by a tenth) and no less accurate (but for a hundredth).
    pub fn better_than(&self, choice: &Choice) -> Option<&Choice> {
        let beats =
            |other: &&Choice| other.time < 0.9 * choice.time && other.error <= 1.01 * choice.error;
        let faster = |p: &&Choice, q: &&Choice| p.time.total_cmp(&q.time);
        self.choices.iter().filter(beats).min_by(faster)
    }

    /// A setting by its name.
    pub fn named(&self, name: &str) -> Option<&Choice> {
        self.choices.iter().find(|choice| choice.name == name)
    }

    /// Both axes logarithmic, the front as steps; errors below `least` are drawn there. Settings on the
    /// front, and those `marked`, are named.
    pub fn chart(&self, time: &str, error: &str, least: f64, marked: Marked<'_>) -> Chart {
        let at = |choice: &Choice| [choice.time, choice.error.max(least)];
        let front = self.front();
        let mut steps: Vec<[f64; 2]> = front.iter().map(|choice| at(choice)).collect();
        let slowest = self.choices.iter().map(|c| c.time).fold(0.0, f64::max);
        steps.extend(steps.last().map(|last| [slowest, last[1]]));
        let mut chart = Chart::new(Axis::log(time), Axis::log(error)).sized(640.0, 440.0);
        chart = chart.with(Series {
            name: "front".into(),
            colour: Colour::Soft,
            mark: Mark::Steps { points: steps },
            link: None,
        });
        let mut groups: Vec<&str> = Vec::new();
        for choice in &self.choices {
            if !groups.contains(&&*choice.group) {
                groups.push(&choice.group);
            }
        }
        for (i, group) in groups.into_iter().enumerate() {
            let spot = |choice: &Choice| Spot {
                at: at(choice),
                label: match front.contains(&choice) || marked.holds(choice) {
                    true => choice.name.clone(),
                    false => String::new(),
                },
                interval: None,
            };
            let members = self.choices.iter().filter(|c| c.group == group);
            chart = chart.with(Series {
                name: group.into(),
                colour: Colour::Series(i),
                mark: Mark::Spots(members.map(spot).collect()),
                link: None,
            });
        }
        chart
    }

    /// The front in a sentence.
    pub fn front_in_words(&self, time: &str, error: &str) -> String {
        let front = self.front();
        let of = |choice: &&Choice| {
            format!(
                "{} ({} {time}, {} {error})",
                choice.name,
                words::three_digits(choice.time),
                small(choice.error)
            )
        };
        let listed: Vec<String> = front.iter().map(of).collect();
        format!(
            "On the front are {} of {} settings: {}.",
            front.len(),
            self.choices.len(),
            words::list(&listed)
        )
    }

    /// What is clearly dominated, each with what to take instead.
    pub fn dominated_in_words(&self) -> Vec<String> {
        let of = |choice: &Choice| {
            let better = self.better_than(choice)?;
            Some(format!(
                "{} is dominated: {} takes {} % of its time and has an error of {} instead of {}.",
                choice.name,
                better.name,
                words::three_digits(100.0 * better.time / choice.time),
                small(better.error),
                small(choice.error)
            ))
        };
        self.choices.iter().filter_map(of).collect()
    }
}

/// A number that may be very small or very large: three digits, else by a power of ten.
pub fn small(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if (1e-3..1e6).contains(&v) => words::three_digits(value),
        _ => {
            let text = format!("{value:.1e}");
            text.replace("e-", "e\u{2212}").replace(".0e", "e")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trade() -> Trade {
        let mut trade = Trade::default();
        for (name, time, error) in [
            ("a", 1.0, 1.0),
            ("b", 2.0, 0.5),
            ("c", 4.0, 0.5),
            ("d", 2.05, 0.6),
            ("e", 5.0, 0.0),
        ] {
            trade.add("all", name, time, error);
        }
        trade
    }

    #[test]
    fn front_is_what_nothing_beats() {
        let trade = trade();
        let names: Vec<&str> = trade.front().iter().map(|c| &*c.name).collect();
        assert_eq!(names, ["a", "b", "e"]);
    }

    #[test]
    fn only_what_is_clearly_slower_is_called_dominated() {
        let said = trade().dominated_in_words();
        assert_eq!(
            said,
            [
                "c is dominated: b takes 50.0 % of its time and has an error of 0.500 instead of 0.500."
            ]
        );
    }

    #[test]
    fn an_error_of_zero_is_drawn() {
        let text = trade()
            .chart("time", "error", 1e-3, Marked::Only(&[]))
            .draw()
            .to_file_text();
        assert!(text.contains(">e<"), "{text}");
    }

    #[test]
    fn small_numbers_read_well() {
        let texts = [0.0, 2.2e-11, 1e-4, 0.0123, 3.0].map(small);
        assert_eq!(small(5.17e8), "5.2e8");
        assert_eq!(
            texts,
            ["0", "2.2e\u{2212}11", "1e\u{2212}4", "0.0123", "3.00"]
        );
    }
}
