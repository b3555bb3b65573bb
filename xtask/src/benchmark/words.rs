//! Numbers and verdicts in words.

use aps_metrics::{Estimate, Metric};

use super::analysis::{Gain, Verdict};

/// Digits after the point that mean something for a metric.
fn decimals(metric: Metric) -> usize {
    match metric {
        Metric::PsnrDb | Metric::NmseDb | Metric::SpectralAngleDeg => 2,
        Metric::PleDeg | Metric::MirrorPleDeg => 2,
        _ => 3,
    }
}

/// A value of a metric, without unit.
pub fn value(metric: Metric, value: f64) -> String {
    fixed(value, decimals(metric))
}

/// The heading of a metric with its unit and an arrow that points to the better side.
pub fn heading(metric: Metric) -> String {
    let arrow = match metric.better() {
        aps_metrics::Better::Lower => '\u{2193}',
        aps_metrics::Better::Higher => '\u{2191}',
    };
    match metric.unit() {
        "" => format!("{}\u{a0}{arrow}", metric.label()),
        unit => format!("{} [{unit}]\u{a0}{arrow}", metric.label()),
    }
}

/// A metric with its unit, as the name of an axis.
pub fn axis(metric: Metric) -> String {
    match metric.unit() {
        "" => metric.label().into(),
        unit => format!("{} [{unit}]", metric.label()),
    }
}

/// `0.931 to 0.952`: an interval.
pub fn interval(metric: Metric, estimate: &Estimate) -> String {
    format!(
        "{} to {}",
        value(metric, estimate.low),
        value(metric, estimate.high)
    )
}

/// `0.931…0.952`: the same for narrow columns.
pub fn short_interval(metric: Metric, estimate: &Estimate) -> String {
    interval(metric, estimate).replace(" to ", "…")
}

/// `0.94 (0.93 to 0.95)`: a mean and its interval.
pub fn estimate(metric: Metric, estimate: &Estimate) -> String {
    format!(
        "{} ({})",
        value(metric, estimate.mean),
        interval(metric, estimate)
    )
}

/// `better by 0.02 (0.01 to 0.03)`: the amount always as a positive number in the interval's sense.
pub fn gain(metric: Metric, gain: &Gain) -> String {
    let e = gain.estimate;
    let unit = match metric.unit() {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let amount = |mean: f64, low: f64, high: f64| {
        format!(
            "{}{unit} ({} to {})",
            value(metric, mean),
            value(metric, low),
            value(metric, high)
        )
    };
    match gain.verdict() {
        Verdict::Better => format!("better by {}", amount(e.mean, e.low, e.high)),
        Verdict::Worse => format!("worse by {}", amount(-e.mean, -e.high, -e.low)),
        Verdict::Undecided if e.mean < 0.0 => format!(
            "worse by {}, which the interval leaves open",
            amount(-e.mean, -e.high, -e.low)
        ),
        Verdict::Undecided => format!(
            "better by {}, which the interval leaves open",
            amount(e.mean, e.low, e.high)
        ),
    }
}

/// A number with digits after the point, with a true minus.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text
        .trim_start_matches('-')
        .chars()
        .all(|c| c == '0' || c == '.');
    match text.strip_prefix('-') {
        Some(rest) if is_zero => rest.into(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => text,
    }
}

/// A positive number with three digits that count: `0.0123`, `4.56`, `789`, `12300`.
pub fn three_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".into();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    if digits >= 0 {
        return fixed(value, digits.min(9) as usize);
    }
    let power = 10_f64.powi(-digits);
    fixed((value / power).round() * power, 0)
}

/// A duration: `45 s`, `12 min`, `3.4 h`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{} s", three_digits(s)),
        s if s < 7200.0 => format!("{} min", fixed(s / 60.0, 0)),
        s => format!("{} h", fixed(s / 3600.0, 1)),
    }
}

/// `a`, `a and b`, `a, b and c`.
pub fn list<S: AsRef<str>>(items: &[S]) -> String {
    match items {
        [] => "none".into(),
        [one] => one.as_ref().into(),
        [first @ .., last] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", first.join(", "), last.as_ref())
        }
    }
}

/// A whole number in groups of three digits.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// Letters and digits in lower case, the rest as single hyphens: part of a file name.
pub fn stem(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            out.push(c.to_ascii_lowercase());
        } else if !out.ends_with('-') && !out.is_empty() {
            out.push('-');
        }
    }
    out.trim_end_matches('-').into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(-20.034, 2), "\u{2212}20.03");
        let texts = [0.01234, 4.561, 789.4, 12_345.0, 9.999, 0.0].map(three_digits);
        assert_eq!(texts, ["0.0123", "4.56", "789", "12300", "10.00", "0"]);
        assert_eq!(count(249_993), "249,993");
        assert_eq!(list(&["a", "b", "c"]), "a, b and c");
        assert_eq!(stem("tracer R2 D1"), "tracer-r2-d1");
    }

    #[test]
    fn gains_say_which_way() {
        let gain_of = |mean: f64, low: f64, high: f64| {
            let estimate = Estimate {
                mean,
                low,
                high,
                samples: 9,
            };
            gain(Metric::PleDeg, &Gain { estimate })
        };
        assert_eq!(gain_of(0.5, 0.2, 0.8), "better by 0.50 deg (0.20 to 0.80)");
        assert_eq!(
            gain_of(-0.5, -0.8, -0.2),
            "worse by 0.50 deg (0.20 to 0.80)"
        );
        let open = gain_of(-0.5, -1.0, 0.25);
        assert!(
            open.starts_with("worse by 0.50 deg (\u{2212}0.25 to 1.00)"),
            "{open}"
        );
    }
}
