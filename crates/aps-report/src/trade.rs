//! Error against time: the front of settings that no other beats, and the settings behind it.

use crate::chart::{Axis, Chart, Mark, Series, Spot, pareto_front};
use crate::theme::Colour;

/// One setting, with its time and its error.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Kind of setting: a colour in the chart.
    pub group: String,
    /// Its name in words.
    pub name: String,
    /// Time in the unit of its axis; positive.
    pub time: f64,
    /// Error in the unit of its axis; not negative.
    pub error: f64,
}

/// Settings that are compared.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trade {
    /// Settings in the order of the key.
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

    /// The settings that nothing beats, the fastest first; an error smaller by less than a hundredth is none.
    pub fn front(&self) -> Vec<&Choice> {
        let points: Vec<[f64; 2]> = self.choices.iter().map(|c| [c.time, c.error]).collect();
        let front = pareto_front(&points, 0.01);
        front.into_iter().map(|i| &self.choices[i]).collect()
    }

    /// `yes` for a setting on the front, else nothing: the cell of a table.
    pub fn on_front(&self, name: &str) -> String {
        let is_there = self.front().iter().any(|choice| choice.name == name);
        if is_there { "yes" } else { "" }.into()
    }

    /// A setting by its name.
    pub fn named(&self, name: &str) -> Option<&Choice> {
        self.choices.iter().find(|choice| choice.name == name)
    }

    /// Makes a chart, both axes logarithmic, the front as steps; errors below `least` are drawn there. Settings on the
    /// front, and those that `is_named` chooses, are named.
    pub fn chart(
        &self,
        time: &str,
        error: &str,
        least: f64,
        is_named: impl Fn(&Choice) -> bool,
    ) -> Chart {
        let at = |choice: &Choice| [choice.time, choice.error.max(least)];
        let front = self.front();
        let mut steps: Vec<[f64; 2]> = front.iter().map(|choice| at(choice)).collect();
        let slowest = self.choices.iter().map(|c| c.time).fold(0.0, f64::max);
        steps.extend(steps.last().map(|last| [slowest, last[1]]));
        let front_line = Series::new("front", Colour::Soft, Mark::Steps { points: steps });
        let mut chart = Chart::new(Axis::log(time), Axis::log(error))
            .sized(640.0, 440.0)
            .with(front_line);
        let mut groups: Vec<&str> = Vec::new();
        for choice in &self.choices {
            if !groups.contains(&&*choice.group) {
                groups.push(&choice.group);
            }
        }
        for (i, group) in groups.into_iter().enumerate() {
            let spot = |choice: &Choice| Spot {
                at: at(choice),
                label: match front.contains(&choice) || is_named(choice) {
                    true => choice.name.clone(),
                    false => String::new(),
                },
                ..Spot::default()
            };
            let members = self.choices.iter().filter(|c| c.group == group);
            let spots = Mark::Spots(members.map(spot).collect());
            chart = chart.with(Series::new(group, Colour::Series(i), spots));
        }
        chart
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
    fn an_error_of_zero_is_drawn() {
        let chart = trade().chart("time", "error", 1e-3, |_| false);
        let text = chart.draw().to_file_text();
        assert!(text.contains(">e<"), "{text}");
    }
}
