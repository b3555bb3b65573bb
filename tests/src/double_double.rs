//! Numbers of 32 digits as the sum of two doubles: the reference that rounding errors are measured
//! against.
//!
//! Sums and products after T. J. Dekker, A floating-point technique for extending the available
//! precision, Numer. Math. 18, 1971; elementary functions by their series. Every operation is good
//! to about 1e-31 of its result, trigonometric ones to that absolutely. Made to be trusted, not to
//! be fast.

use std::f64::consts;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The unevaluated sum of two doubles, the second at most half an ulp of the first.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct DoubleDouble {
    /// The nearest double.
    pub high: f64,
    /// Remainder: the value less `high`.
    pub low: f64,
}

/// pi.
pub const PI: DoubleDouble = DoubleDouble::new(consts::PI, 1.224_646_799_147_353_2e-16);
/// Natural logarithm of 2.
const LN_2: DoubleDouble = DoubleDouble::new(consts::LN_2, 2.319_046_813_846_299_6e-17);
/// Natural logarithm of 10.
const LN_10: DoubleDouble = DoubleDouble::new(consts::LN_10, -2.170_756_223_382_249_4e-16);

/// A double as it is.
#[must_use]
pub const fn dd(x: f64) -> DoubleDouble {
    DoubleDouble::new(x, 0.0)
}

fn exact_sum(a: f64, b: f64) -> DoubleDouble {
    let high = a + b;
    let bb = high - a;
    DoubleDouble::new(high, (a - (high - bb)) + (b - bb))
}

fn exact_product(a: f64, b: f64) -> DoubleDouble {
    let high = a * b;
    DoubleDouble::new(high, a.mul_add(b, -high))
}

fn renormalised(high: f64, low: f64) -> DoubleDouble {
    let sum = high + low;
    DoubleDouble::new(sum, low - (sum - high))
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        dd(high)
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let s = exact_sum(self.high, other.high);
        let t = exact_sum(self.low, other.low);
        let s = renormalised(s.high, s.low + t.high);
        renormalised(s.high, s.low + t.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.high, -self.low)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = exact_product(self.high, other.high);
        let low = self.high * other.low + self.low * other.high;
        renormalised(p.high, p.low + low)
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let q1 = self.high / other.high;
        let rest = self - other * q1.into();
        let q2 = rest.high / other.high;
        let rest = rest - other * q2.into();
        Self::from(q1) + q2.into() + (rest.high / other.high).into()
    }
}

impl DoubleDouble {
    /// 0.
    pub const ZERO: Self = dd(0.0);
    /// 1.
    pub const ONE: Self = dd(1.0);

    const fn new(high: f64, low: f64) -> Self {
        Self { high, low }
    }

    /// The nearest double.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        self.high + self.low
    }

    /// Magnitude.
    #[must_use]
    pub fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }

    /// Square root of a number that is not negative.
    #[must_use]
    pub fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        let root = Self::from(self.high.sqrt());
        let step = |x: Self| (x + self / x) * 0.5.into();
        step(step(root))
    }

    /// e to this power.
    #[must_use]
    pub fn exp(self) -> Self {
        let n = (self.high / LN_2.high).round();
        // Half of a 64th of ln 2: twelve terms are enough, then six squarings.
        let r = (self - LN_2 * n.into()) * (1.0 / 64.0).into();
        let (mut term, mut sum) = (Self::ONE, Self::ZERO);
        for i in 1..=14 {
            term = term * r / f64::from(i).into();
            sum = sum + term;
        }
        // (1 + s)^2 - 1 = 2 s + s^2 keeps the digits of s.
        for _ in 0..6 {
            sum = sum + sum + sum * sum;
        }
        let power = |e: f64| e.exp2();
        let half = (n / 2.0).trunc();
        (sum + Self::ONE) * power(half).into() * power(n - half).into()
    }

    /// Natural logarithm of a positive number.
    #[must_use]
    pub fn ln(self) -> Self {
        let y = Self::from(self.high.ln());
        // Newton's step for e^y = x, twice.
        let step = |y: Self| y + self * (-y).exp() - Self::ONE;
        step(step(y))
    }

    /// 10 log10 of a positive number \[dB\].
    #[must_use]
    pub fn decibel(self) -> Self {
        self.ln() / LN_10 * 10.0.into()
    }

    /// 10^(x/10): the power of so many dB.
    #[must_use]
    pub fn from_decibel(self) -> Self {
        (self * LN_10 / 10.0.into()).exp()
    }

    /// Sine and cosine of pi times this number.
    #[must_use]
    pub fn sin_cos_pi(self) -> (Self, Self) {
        // To within a quarter of a quarter turn; the subtraction is exact.
        let quarters = (self.high * 2.0).round();
        let angle = PI * (self - (quarters * 0.5).into());
        let (sin, cos) = angle.series();
        match quarters.rem_euclid(4.0) as u8 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }

    /// Sine and cosine of this angle \[rad\], for up to some thousand turns.
    #[must_use]
    pub fn sin_cos(self) -> (Self, Self) {
        (self / PI).sin_cos_pi()
    }

    /// By the power series, for at most pi / 4.
    fn series(self) -> (Self, Self) {
        let square = self * self;
        let sum = |first: Self, start: f64| {
            let (mut term, mut sum, mut n) = (first, first, start);
            while term.high.abs() > 1e-34 * sum.high.abs() {
                term = -(term * square / ((n + 1.0) * (n + 2.0)).into());
                sum = sum + term;
                n += 2.0;
            }
            sum
        };
        (sum(self, 1.0), sum(Self::ONE, 0.0))
    }

    /// sqrt(x^2 + y^2).
    #[must_use]
    pub fn hypot(x: Self, y: Self) -> Self {
        (x * x + y * y).sqrt()
    }
}

impl std::iter::Sum for DoubleDouble {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::ZERO, |sum, term| sum + term)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Digits from mpmath: each constant split into its nearest double and the nearest of the rest.
    #[test]
    fn functions_have_thirty_digits() {
        let split = DoubleDouble::new;
        let (sin_1, cos_1) = DoubleDouble::ONE.sin_cos();
        let (sin, cos) = dd(1e6 + 0.25).sin_cos_pi();
        let root_2 = split(consts::SQRT_2, -9.667_293_313_452_913e-17);
        let table = [
            (dd(2.0).sqrt(), root_2),
            (dd(1.0).exp(), split(consts::E, 1.445_646_891_729_250_2e-16)),
            (dd(2.0).ln(), LN_2),
            (dd(10.0).ln(), LN_10),
            (dd(0.1) / dd(0.3) * dd(0.3), dd(0.1)),
            (
                sin_1,
                split(0.841_470_984_807_896_5, 1.776_845_092_935_536e-18),
            ),
            (
                cos_1,
                split(0.540_302_305_868_139_8, -4.760_954_612_604_417e-17),
            ),
            (sin, root_2 / dd(2.0)),
            (cos, root_2 / dd(2.0)),
            (dd(-87.3).from_decibel().decibel(), dd(-87.3)),
            (dd(1e-300).ln().exp(), dd(1e-300)),
        ];
        for (got, want) in table {
            let error = (got - want).abs().to_f64() / want.abs().to_f64();
            assert!(error < 1e-29, "{got:?} is not {want:?}: {error:e}");
        }
    }
}
