//! Strengths of many waves together: the largest and the sum of squares, never too low.

use std::ops::Range;

use crate::bound::{Direction, WedgeBound, rounded_up};
use crate::leg_ends::LegEnds;

/// The strength of some waves together.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Strength {
    /// Upper bound of the largest strength.
    pub max: f32,
    /// Upper bound of the sum of the strengths' squares.
    pub power: f32,
}

impl Strength {
    /// The strength of one wave.
    pub fn of(strength: f64) -> Self {
        Self {
            max: rounded_up(strength),
            power: rounded_up(strength * strength),
        }
    }

    /// Maximum and power in 16 bits each.
    pub fn rounded(&self) -> RowSum {
        let [max, power] = [self.max, self.power].map(|bound| Bound::up(bound.into()));
        RowSum { max, power }
    }

    /// Adds other waves.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        self.max = self.max.max(other.max);
        self.power = rounded_up(f64::from(self.power) + f64::from(other.power));
    }
}

/// An upper bound in 16 bits, the upper half of a single: a search reads thousands of them from memory that is not at hand.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Bound(u16);

impl Bound {
    #[inline]
    pub fn up(bound: f64) -> Self {
        let bits = rounded_up(bound).to_bits();
        // The carry of the rounding may go into the exponent, up to infinity.
        Self((bits.saturating_add(0xffff).min(f32::INFINITY.to_bits()) >> 16) as u16)
    }

    #[inline]
    pub fn get(self) -> f64 {
        f32::from_bits(u32::from(self.0) << 16).into()
    }
}

/// Upper bounds of the strengths of waves along some legs, each of some kinds of waves: a row a leg.
///
/// The sums of rows lie side by side: of most rows a search reads nothing else.
#[derive(Debug, Clone, Default)]
pub(crate) struct Table {
    /// Sums of rows.
    sums: Vec<RowSum>,
    /// Bounds of rows, kind by kind.
    bounds: Vec<Bound>,
}

/// Rows of a table that belong together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows {
    first: usize,
    first_bound: usize,
    kinds: usize,
}

/// The largest strength of a row and the sum of squares.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RowSum {
    max: Bound,
    power: Bound,
}

impl RowSum {
    #[inline]
    pub fn max(self) -> f64 {
        self.max.get()
    }

    #[inline]
    pub fn power(self) -> f64 {
        self.power.get()
    }
}

impl Table {
    /// Memory that a row takes.
    pub fn row_bytes(kinds: usize) -> usize {
        size_of::<RowSum>() + kinds * size_of::<Bound>()
    }

    /// Memory that the table takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.sums) + size_of_val(&*self.bounds)
    }

    /// Makes room for some rows with this many bounds in all, and no more.
    pub fn reserve_exact(&mut self, rows: usize, bounds: usize) {
        self.sums.reserve_exact(rows);
        self.bounds.reserve_exact(bounds);
    }

    /// Adds rows without strength.
    pub fn add(&mut self, legs: usize, kinds: usize) -> Rows {
        let (first, first_bound) = (self.sums.len(), self.bounds.len());
        self.sums.resize(first + legs, RowSum::default());
        self.bounds
            .resize(first_bound + legs * kinds, Bound::default());
        Rows {
            first,
            first_bound,
            kinds,
        }
    }

    /// Sums of the rows of legs, counted from the first of those that belong together.
    #[inline]
    pub fn sums(&self, rows: Rows, legs: Range<u32>) -> &[RowSum] {
        &self.sums[rows.first + legs.start as usize..rows.first + legs.end as usize]
    }

    /// Strengths of all kinds along a leg.
    #[inline]
    pub fn row(&self, rows: Rows, leg: u32) -> &[Bound] {
        &self.bounds[rows.first_bound + leg as usize * rows.kinds..][..rows.kinds]
    }
}

/// Strengths of leg ends at one corner, with maxima and powers.
#[derive(Debug, Default)]
pub(crate) struct CornerStrengths {
    bounds: Vec<f64>,
    max: Vec<f64>,
    power: Vec<f64>,
    /// Number of leg ends that any kind reached.
    count: usize,
}

impl CornerStrengths {
    /// Starts at another corner, with a place for each leg end.
    pub fn clear(&mut self, places: usize) {
        for column in [&mut self.max, &mut self.power] {
            column.clear();
            column.resize(places, 0.0);
        }
        self.count = 0;
    }

    /// Adds a kind of waves: those that turn from a ray to the first of the ends at the corner. `strength` gives the factor of a place.
    pub fn add(
        &mut self,
        (wedge, ray): (&WedgeBound, &Direction),
        (ends, count): (&LegEnds, usize),
        strength: impl Fn(usize) -> f64,
        (table, rows, kind): (&mut Table, Rows, usize),
    ) {
        wedge.of_each(ray, &ends.directions, 0..count, &mut self.bounds);
        self.count = self.count.max(count);
        let columns = self.max.iter_mut().zip(&mut self.power);
        for (place, (&bound, (max, power))) in self.bounds.iter().zip(columns).enumerate() {
            let bound = bound * strength(place);
            *max = max.max(bound);
            *power += bound * bound;
            let row = rows.first_bound + ends.slots[place] as usize * rows.kinds;
            table.bounds[row + kind] = Bound::up(bound);
        }
    }

    /// Completes the rows, and visits the strength of each leg end that any kind reached, all kinds together.
    pub fn finish(
        &self,
        ends: &LegEnds,
        (table, rows): (&mut Table, Rows),
        mut visit: impl FnMut(usize, Strength),
    ) {
        for place in 0..self.count {
            let strength = Strength {
                max: rounded_up(self.max[place]),
                power: rounded_up(self.power[place]),
            };
            visit(place, strength);
            table.sums[rows.first + ends.slots[place] as usize] = strength.rounded();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_precision_rounds_a_bound_down() {
        for e in -60..40 {
            for mantissa in [1.0, 1.000_000_01, 1.999_999_99, 1.234_567_891] {
                let bound = mantissa * 10.0_f64.powi(e);
                assert!(f64::from(rounded_up(bound)) >= bound, "{bound:e}");
                let rounded = Bound::up(bound).get();
                assert!(rounded >= bound, "{bound:e}");
                // Below the normal range of singles steps are wide.
                assert!(
                    e < -37 || rounded <= bound * 1.01 || rounded.is_infinite(),
                    "{bound:e}"
                );
            }
        }
        assert!(Bound::up(f64::INFINITY).get().is_infinite());
    }
}
