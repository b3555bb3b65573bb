//! Strengths of many waves together: the largest and the sum of squares, never too low.

use crate::bound::{Direction, Directions, WedgeBound, rounded_up};

/// The strength of some waves together.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Strength {
    /// Upper bound of the largest.
    pub max: f32,
    /// Upper bound of the sum of squares.
    pub power: f32,
}

impl Strength {
    /// Adds other waves.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        self.max = self.max.max(other.max);
        self.power = rounded_up(f64::from(self.power) + f64::from(other.power));
    }
}

/// Rows of bounds at one corner, a place for each leg end, and what they come to together.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    row: Vec<f64>,
    max: Vec<f64>,
    power: Vec<f64>,
    /// Places that any row reached.
    count: usize,
}

impl Rows {
    /// Starts at another corner, with so many places.
    pub fn clear(&mut self, places: usize) {
        for column in [&mut self.max, &mut self.power] {
            column.clear();
            column.resize(places, 0.0);
        }
        self.count = 0;
    }

    /// Bounds of |D| between a ray and the first of others: the next row, to be multiplied with strengths.
    pub fn bounds(
        &mut self,
        wedge: &WedgeBound,
        ray: &Direction,
        others: &Directions,
        count: usize,
    ) -> &mut [f64] {
        wedge.of_each(ray, others, 0..count, &mut self.row);
        &mut self.row
    }

    /// Adds the row to the others.
    pub fn add(&mut self) {
        self.count = self.count.max(self.row.len());
        let columns = self.max.iter_mut().zip(&mut self.power);
        for ((max, power), &bound) in columns.zip(&self.row) {
            *max = max.max(bound);
            *power += bound * bound;
        }
    }

    /// Strengths of all rows together, place by place.
    pub fn by_place(&self) -> impl Iterator<Item = Strength> {
        let columns = self.max[..self.count].iter().zip(&self.power);
        columns.map(|(&max, &power)| Strength {
            max: rounded_up(max),
            power: rounded_up(power),
        })
    }
}
