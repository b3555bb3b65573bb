//! A wall of the scene, and the geometry of its line.

use glam::DVec2;

use crate::material::Material;

/// One edge of the union of all buildings. The building lies to the left of `a` -> `b`, the
/// street to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// Start \[m\].
    pub a: DVec2,
    /// End \[m\].
    pub b: DVec2,
    /// The wall before this one on its outline; its `b` is this wall's `a`.
    pub previous: u32,
    /// The wall after this one on its outline; its `a` is this wall's `b`.
    pub next: u32,
    /// Index of its building among the footprints given.
    pub building: usize,
    /// Material, where the footprint names one.
    pub material: Option<Material>,
}

impl Wall {
    /// Vector from `a` to `b` \[m\], not normalised: exact for integer coordinates.
    #[inline]
    #[must_use]
    pub fn along(&self) -> DVec2 {
        self.b - self.a
    }

    /// Vector towards the street, as long as the wall \[m\].
    #[inline]
    #[must_use]
    pub fn outward(&self) -> DVec2 {
        let d = self.along();
        DVec2::new(d.y, -d.x)
    }

    /// Length \[m\].
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.along().length()
    }

    /// Coordinates of `p` in the wall's own frame, times the wall's length \[m^2\]: along the
    /// wall from `a`, and outward from it.
    #[inline]
    pub(crate) fn frame(&self, p: DVec2) -> (f64, f64) {
        let r = p - self.a;
        (r.dot(self.along()), r.dot(self.outward()))
    }

    /// Coordinates of `p` in the frame of the wall's end, times the wall's length \[m^2\]: along the wall from `b` towards `a`, and
    /// outward.
    #[inline]
    pub(crate) fn frame_from_end(&self, p: DVec2) -> (f64, f64) {
        let r = p - self.b;
        (r.dot(-self.along()), r.dot(self.outward()))
    }

    /// Mirror image of `p` over the wall's line \[m\].
    #[inline]
    pub(crate) fn mirror(&self, p: DVec2) -> DVec2 {
        let n = self.outward();
        p - n * (2.0 * (p - self.a).dot(n) / n.length_squared())
    }
}
