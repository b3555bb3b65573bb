//! Axes: from values to a part of their length, and the ticks along them.

use crate::numbers::fixed;

/// Room beyond the data on either side of a tight axis, as a part of their extent.
const MARGIN: f64 = 0.05;

/// The layout of values along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal differences are equally far apart.
    #[default]
    Linear,
    /// Equal ratios are equally far apart; values that are not positive are left out.
    Log10,
}

/// An axis as asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// Its name, with its unit in brackets.
    pub label: String,
    /// Layout of the values.
    pub scale: Scale,
    /// First and last value; `None` takes them from the data, rounded outwards to ticks. Values
    /// beyond a range given are drawn at its ends (lines, bars) or left out (points).
    pub range: Option<[f64; 2]>,
    /// If true, an axis without a range ends a little beyond the data instead of at ticks.
    pub is_tight: bool,
    /// Distance of ticks on a linear axis; `None` chooses one of 1, 2, 5 times a power of ten.
    pub step: Option<f64>,
}

impl Axis {
    /// A linear axis over the range of the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            ..Self::default()
        }
    }

    /// A logarithmic axis over the range of the data.
    pub fn log(label: impl Into<String>) -> Self {
        Self {
            scale: Scale::Log10,
            ..Self::linear(label)
        }
    }

    /// Sets the ends.
    #[must_use]
    pub fn over(self, first: f64, last: f64) -> Self {
        Self {
            range: Some([first, last]),
            ..self
        }
    }

    /// Ends the axis a little beyond the data: a chart of dots wastes no room.
    #[must_use]
    pub fn tight(self) -> Self {
        Self {
            is_tight: true,
            ..self
        }
    }

    /// Sets a tick every `step`.
    #[must_use]
    pub fn every(self, step: f64) -> Self {
        Self {
            step: Some(step),
            ..self
        }
    }

    /// Azimuth from -180 to 180 deg with ticks at the points of the compass.
    pub fn azimuth(label: impl Into<String>) -> Self {
        Self::linear(label).over(-180.0, 180.0).every(45.0)
    }

    /// Tells if the axis can show a value at all.
    pub(super) fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    /// Fits the axis to its data.
    pub(super) fn fit(&self, values: impl Iterator<Item = f64>, ticks: usize) -> Fitted {
        let is_given = self.range.is_some();
        let [first, last] = self.range.unwrap_or_else(|| {
            let shown = values.filter(|&v| self.shows(v));
            let empty = [f64::INFINITY, f64::NEG_INFINITY];
            let ends = shown.fold(empty, |[low, high], v| [low.min(v), high.max(v)]);
            if self.is_tight {
                self.widened(ends)
            } else {
                ends
            }
        });
        // Ends between ticks hold fewer of them.
        let ticks = ticks + if self.is_tight { 2 } else { 0 };
        // Ends without any room between them are spread to ticks.
        let keeps_ends = is_given || (self.is_tight && first < last);
        match self.scale {
            Scale::Linear => fit_linear(first, last, self, keeps_ends, ticks),
            Scale::Log10 => fit_log(first, last, keeps_ends),
        }
    }

    /// Ends of data, moved apart by a part of their distance.
    fn widened(&self, [first, last]: [f64; 2]) -> [f64; 2] {
        match self.scale {
            Scale::Linear => {
                let room = MARGIN * (last - first);
                [first - room, last + room]
            }
            Scale::Log10 => {
                let room = (last / first).powf(MARGIN);
                [first / room, last * room]
            }
        }
    }
}

/// An axis with known ends.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fitted {
    scale: Scale,
    first: f64,
    last: f64,
    /// Value and text.
    pub ticks: Vec<(f64, String)>,
}

impl Fitted {
    /// The place of a value, 0 at the first end and 1 at the last; clamped to these.
    pub fn part(&self, value: f64) -> f64 {
        let place = |v: f64| match self.scale {
            Scale::Linear => v,
            Scale::Log10 => v.max(f64::MIN_POSITIVE).log10(),
        };
        let (first, last) = (place(self.first), place(self.last));
        ((place(value) - first) / (last - first)).clamp(0.0, 1.0)
    }

    /// Tells if a value lies between the ends.
    pub fn contains(&self, value: f64) -> bool {
        (self.first.min(self.last)..=self.last.max(self.first)).contains(&value)
    }

    /// The end where bars and stems stand: 0 if the axis has it, else the first.
    pub fn base(&self) -> f64 {
        match self.scale {
            Scale::Linear if self.contains(0.0) => 0.0,
            Scale::Linear | Scale::Log10 => self.first,
        }
    }
}

fn fit_linear(first: f64, last: f64, axis: &Axis, keeps_ends: bool, ticks: usize) -> Fitted {
    let is_sound = first.is_finite() && last.is_finite();
    let (mut first, mut last) = if is_sound { (first, last) } else { (0.0, 1.0) };
    if first == last {
        let room = 0.5 * first.abs().max(1.0);
        (first, last) = (first - room, last + room);
    }
    let step = axis
        .step
        .unwrap_or_else(|| nice_step((last - first).abs() / ticks.max(1) as f64));
    if !keeps_ends {
        first = (first / step).floor() * step;
        last = (last / step).ceil() * step;
    }
    let (low, high) = (first.min(last), first.max(last));
    // Steps of 0.1 do not add up to 1 exactly.
    let slack = 1e-9;
    let from = (low / step - slack).ceil() as i64;
    let to = (high / step + slack).floor() as i64;
    let decimals = (-(step * 1.000_001).log10().floor()).max(0.0) as usize;
    // 2.5 needs one more than 2.
    let decimals = decimals + usize::from((step * 10_f64.powi(decimals as i32)).fract() > 1e-6);
    let values = (from..=to.min(from + 200)).map(|i| i as f64 * step);
    Fitted {
        scale: Scale::Linear,
        first,
        last,
        ticks: values.map(|v| (v, fixed(v, decimals))).collect(),
    }
}

fn fit_log(first: f64, last: f64, keeps_ends: bool) -> Fitted {
    let is_sound = first > 0.0 && last > 0.0 && first.is_finite() && last.is_finite();
    let (mut first, mut last) = if is_sound { (first, last) } else { (0.1, 10.0) };
    if first == last {
        (first, last) = (first / 2.0, last * 2.0);
    }
    let decades = (last / first).log10().abs();
    let mantissas: &[f64] = match decades {
        d if d < 0.8 => &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
        d if d < 3.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let all = |from: f64, to: f64| -> Vec<f64> {
        let (from, to) = (from.log10().floor() as i32, to.log10().ceil() as i32);
        let decade = |e: i32| mantissas.iter().map(move |m| m * 10_f64.powi(e));
        (from..=to).flat_map(decade).collect()
    };
    let slack = 1.0 + 1e-9;
    if !keeps_ends {
        let marks = all(first / 10.0, last * 10.0);
        let below = |&m: &f64| m <= first * slack;
        let above = |&m: &f64| m >= last / slack;
        first = marks.iter().copied().filter(below).fold(first, |_, m| m);
        last = marks.iter().copied().find(above).unwrap_or(last);
    }
    let (low, high) = (first.min(last), first.max(last));
    let mut ticks = all(low, high);
    ticks.retain(|&t| t >= low / slack && t <= high * slack);
    // No more than some eight decades get a text.
    let every = ticks.len().div_ceil(9).max(1);
    let ticks = ticks.into_iter().step_by(every);
    Fitted {
        scale: Scale::Log10,
        first,
        last,
        ticks: ticks.map(|t| (t, power_text(t))).collect(),
    }
}

/// 1, 2 or 5 times a power of ten, at least `least`.
fn nice_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    let mut steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter();
    let step = steps.find(|&step| step >= least * (1.0 - 1e-9));
    step.unwrap_or(10.0 * power)
}

/// `0.02`, `500`, or `10⁻⁶` and `2·10⁻⁶` where that is shorter.
fn power_text(value: f64) -> String {
    if (1e-3..1e5).contains(&(value * 1.000_001)) {
        // Ticks have two digits at most.
        let decimals = (1.0 - value.log10().floor()).max(0.0) as usize;
        let text = format!("{value:.decimals$}");
        return match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').into(),
            false => text,
        };
    }
    let exponent = (value * 1.000_001).log10().floor() as i32;
    let digits: String = exponent.to_string().chars().map(superscript).collect();
    let mantissa = value / 10_f64.powi(exponent);
    if (mantissa - 1.0).abs() < 1e-6 {
        format!("10{digits}")
    } else {
        let text = format!("{mantissa:.1}");
        format!("{}·10{digits}", text.trim_end_matches(".0"))
    }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '0'..='9' => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c as usize - '0' as usize],
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis, values: &[f64]) -> Vec<String> {
        let fitted = axis.fit(values.iter().copied(), 5);
        fitted.ticks.into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn linear_axes_end_at_round_values() {
        let x = Axis::linear("");
        assert_eq!(texts(&x, &[0.3, 4.7]), ["0", "1", "2", "3", "4", "5"]);
        assert_eq!(texts(&x, &[-0.01, 0.02]), ["−0.01", "0.00", "0.01", "0.02"]);
        assert_eq!(texts(&x, &[3.0, 3.0]), ["1", "2", "3", "4", "5"]);
        let half = x.over(0.0, 5.0).every(2.5);
        assert_eq!(texts(&half, &[]), ["0.0", "2.5", "5.0"]);
    }

    #[test]
    fn tight_axes_end_just_beyond_the_data() {
        let x = Axis::linear("").tight();
        assert_eq!(texts(&x, &[0.3, 4.7]), ["1", "2", "3", "4"]);
        let fitted = x.fit([0.0, 1.0].into_iter(), 5);
        assert!((fitted.part(0.0) - 0.05 / 1.1).abs() < 1e-12);
        let fitted = Axis::log("").tight().fit([1.0, 100.0].into_iter(), 5);
        assert!((fitted.part(10.0) - 0.5).abs() < 1e-12 && fitted.part(1.0) > 0.04);
        // One value, or none, is no extent.
        assert_eq!(x.fit([3.0].into_iter(), 5).part(3.0), 0.5);
        assert_eq!(x.fit([].into_iter(), 5).part(0.5), 0.5);
    }

    #[test]
    fn azimuths_are_marked_every_45_deg() {
        let ticks = texts(&Axis::azimuth(""), &[]);
        assert_eq!((ticks.len(), &*ticks[0], &*ticks[4]), (9, "−180", "0"));
    }

    #[test]
    fn log_axes_are_marked_by_decades_or_finer() {
        let t = Axis::log("");
        assert_eq!(texts(&t, &[3.0, 40.0]), ["2", "5", "10", "20", "50"]);
        assert_eq!(
            texts(&t, &[1e-7, 3e-3]),
            ["10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴", "0.001", "0.01"]
        );
        assert_eq!(texts(&t, &[1.1e6, 1.8e6]), ["10⁶", "1.5·10⁶", "2·10⁶"]);
    }

    #[test]
    fn data_without_a_place_take_none() {
        let fitted = Axis::log("").fit([0.0, -1.0, f64::NAN].into_iter(), 5);
        assert!(!fitted.ticks.is_empty());
        let fitted = Axis::linear("").fit([f64::INFINITY].into_iter(), 5);
        assert_eq!(fitted.part(0.5), 0.5);
    }

    #[test]
    fn equal_ratios_are_equally_far_apart() {
        let fitted = Axis::log("").over(1.0, 100.0).fit([].into_iter(), 5);
        assert!((fitted.part(10.0) - 0.5).abs() < 1e-15);
        assert_eq!((fitted.part(1e-9), fitted.part(1e9)), (0.0, 1.0));
    }
}
