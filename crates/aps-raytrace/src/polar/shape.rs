//! Order of the values of a link.

/// Kinds of ways along a ray: straight from the transmitter; over one corner, which the transmitter lights straight, after one
/// reflection, or after two; over several corners.
pub const KINDS: usize = 5;

/// Features of a way: see [`PolarLink`](super::PolarLink).
pub const FEATURES: usize = 14;

/// Numbers of a way in a list: see [`PolarLink::list`](super::PolarLink::list).
pub const LISTED: usize = FEATURES + 2;

/// Number of values of a link, in the order (direction, value): for each kind of way and each number of bounces, in this order,
/// the features.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shape {
    /// Number of directions.
    pub directions: usize,
    /// Most reflections of a ray.
    pub bounces: usize,
}

impl Shape {
    /// Number of ways a direction.
    #[must_use]
    pub fn ways(self) -> usize {
        KINDS * (self.bounces + 1)
    }

    /// Number of values a direction.
    #[must_use]
    pub fn per_direction(self) -> usize {
        self.ways() * FEATURES
    }

    /// Number of values a link.
    #[must_use]
    pub fn values(self) -> usize {
        self.directions * self.per_direction()
    }
}
