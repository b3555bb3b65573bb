//! One formula in several precisions.

use std::ops::{Add, Div, Mul, Sub};

use aps_tests::double_double::DoubleDouble;

/// A number as the kernels of a label need it.
pub trait Number:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The nearest number.
    fn of(value: f64) -> Self;
    /// The nearest double.
    fn to_f64(self) -> f64;
    /// Sine of pi times this.
    fn sin_pi(self) -> Self;
    /// Sine of an angle [rad].
    fn sin(self) -> Self;
}

/// By the standard library, as anybody would write it.
macro_rules! number {
    ($t:ident) => {
        impl Number for $t {
            fn of(value: f64) -> Self {
                value as $t
            }
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn sin_pi(self) -> Self {
                (std::$t::consts::PI * self).sin()
            }
            fn sin(self) -> Self {
                $t::sin(self)
            }
        }
    };
}

number!(f32);
number!(f64);

impl Number for DoubleDouble {
    fn of(value: f64) -> Self {
        value.into()
    }
    fn to_f64(self) -> f64 {
        DoubleDouble::to_f64(self)
    }
    fn sin_pi(self) -> Self {
        self.sin_cos_pi().0
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
}
