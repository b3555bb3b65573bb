//! Numbers as people read them.

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

/// A number with three digits that count: `0.0123`, `4.56`, `789`, `12300`.
pub fn three_digits(value: f64) -> String {
    // Of the number as it is rounded: 9.999 has one digit more before the point.
    let rounded = format!("{value:.2e}");
    let power = rounded
        .split_once('e')
        .map(|(_, power)| power.parse::<i32>());
    match power {
        Some(Ok(power)) if value != 0.0 => {
            let digits = (2 - power).clamp(0, 9) as usize;
            fixed(rounded.parse().unwrap_or(value), digits)
        }
        _ if value == 0.0 => "0".into(),
        // Neither has digits.
        _ => value.to_string(),
    }
}

/// A number that may be very small or very large: three digits, else by a power of ten.
pub fn small(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        v if (1e-3..1e6).contains(&v) => three_digits(value),
        _ => {
            let text = format!("{value:.1e}");
            text.replace("e-", "e\u{2212}").replace(".0e", "e")
        }
    }
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

/// Letters and digits in lower case, the rest as single hyphens: part of a file name, an anchor.
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
        let texts = [0.01234, 4.561, 789.4, 12_345.0, 9.999, 999.6, 0.0].map(three_digits);
        assert_eq!(
            texts,
            ["0.0123", "4.56", "789", "12300", "10.0", "1000", "0"]
        );
        assert_eq!([f64::NAN, f64::INFINITY].map(three_digits), ["NaN", "inf"]);
        assert_eq!(count(249_993), "249,993");
        assert_eq!(list(&["a", "b", "c"]), "a, b and c");
        assert_eq!(stem("tracer R2 D1"), "tracer-r2-d1");
        assert!(!stem("scores-/../../x").contains(['/', '.']));
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
