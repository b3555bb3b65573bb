//! Exact signs for the geometric decisions, and the plane vectors they act on.
//!
//! A path exists or it does not; rounding must not decide. Every decision that depends on a sign
//! goes through [`orient`], which is exact for any finite coordinates (Shewchuk 1997, through the
//! `robust` crate) and costs a handful of flops when the sign is not in doubt.
//!
//! ```
//! use aps_raytrace::{glam::DVec2, predicates::{orient, strictly_between}};
//!
//! // On the line in every bit, and off it by the last bit of one coordinate.
//! let (a, b, c) = (DVec2::new(0.1, 0.1), DVec2::new(12.0, 12.0), DVec2::new(0.7, 0.7));
//! assert_eq!(orient(a, b, c), 0.0);
//! assert!(orient(a, b, DVec2::new(0.7, 0.7_f64.next_up())) > 0.0);
//! assert!(strictly_between(a, b, c) && !strictly_between(a, b, a));
//! ```

use glam::DVec2;

/// Error factor of the plain determinant: (3 + 16 eps) eps, Shewchuk 1997, section 4.3.
const ORIENT_ERROR: f64 = 3.330_669_073_875_471_6e-16;

/// Twice the signed area of the triangle `a`, `b`, `c`: positive when `c` lies left of the
/// directed line from `a` to `b`. \[m^2\]
///
/// The sign, zero included, is that of the exact value; the magnitude is good to a relative
/// 1e-15 or so when the points are near a line.
#[inline]
#[must_use]
pub fn orient(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let left = (a.x - c.x) * (b.y - c.y);
    let right = (a.y - c.y) * (b.x - c.x);
    let det = left - right;
    if det.abs() > ORIENT_ERROR * (left.abs() + right.abs()) {
        det
    } else {
        orient_exact(a, b, c)
    }
}

#[cold]
fn orient_exact(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// Returns true when `c`, known to lie on the line through `p` and `q`, lies strictly between them.
#[inline]
#[must_use]
pub fn strictly_between(p: DVec2, q: DVec2, c: DVec2) -> bool {
    let (lo, hi, v) = if (q.x - p.x).abs() >= (q.y - p.y).abs() {
        (p.x.min(q.x), p.x.max(q.x), c.x)
    } else {
        (p.y.min(q.y), p.y.max(q.y), c.y)
    };
    lo < v && v < hi
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientation_is_exact_where_rounding_hides_it() {
        let a = DVec2::new(0.1, 0.1);
        let b = DVec2::new(0.2, 0.2);
        let c = DVec2::new(0.3, 0.3);
        // 0.1, 0.2 and 0.3 are not on one line in binary, but equal coordinates are.
        assert_eq!(orient(a, b, c), 0.0);
        let above = DVec2::new(0.3, 0.3_f64.next_up());
        assert!(orient(a, b, above) > 0.0);
        assert!(orient(b, a, above) < 0.0);
    }

    #[test]
    fn between_excludes_the_ends() {
        let (p, q) = (DVec2::new(0.0, 0.0), DVec2::new(4.0, 2.0));
        assert!(strictly_between(p, q, DVec2::new(2.0, 1.0)));
        assert!(!strictly_between(p, q, p));
        assert!(!strictly_between(p, q, q));
        assert!(!strictly_between(p, q, DVec2::new(6.0, 3.0)));
    }
}
