//! The exact field at a perfectly conducting wedge, by its eigenfunction series.
//!
//! A plane wave of amplitude 1, its electric field parallel to the edge, comes from phi_i and meets a
//! wedge with an open angle of n pi (faces at phi = 0 and n pi, time factor e^{+j omega t}). At rho
//! from the edge, in the direction phi, the field is
//!
//! u = (4 / n) sum_{m >= 1} e^{j v pi / 2} J_v(k rho) sin(v phi) sin(v phi_i),   v = m / n
//!
//! (Bowman, Senior, Uslenghi, "Electromagnetic and Acoustic Scattering by Simple Shapes", 1969,
//! section 6.2; conjugated for the time factor). `tests/golden/wedge.py` computes the same by SciPy's
//! Bessel functions; here they come from Miller's backward recurrence.

use std::f64::consts::{FRAC_PI_2, PI};

use aps_raytrace::Complex64;

/// Field at one distance from one wedge, in any direction.
#[derive(Debug, Clone)]
pub struct ExactWedge {
    n: f64,
    k_rho: f64,
    /// Weight of order v = m / n, m = 1, 2, ...
    weights: Vec<Complex64>,
}

impl ExactWedge {
    /// A wedge with a whole interior angle \[deg\], 0 (a half plane) to 179, seen at `k_rho` > 0.
    ///
    /// # Panics
    /// For other values.
    #[must_use]
    pub fn new(interior_deg: u32, k_rho: f64) -> Self {
        assert!(interior_deg < 180, "a wedge of {interior_deg} deg is none");
        assert!(k_rho > 0.0 && k_rho.is_finite(), "k rho = {k_rho}");
        let open = 360 - interior_deg;
        let divisor = greatest_common_divisor(open, 180);
        // n = a / b: orders m b / a, so a different fractions.
        let (a, b) = ((open / divisor) as usize, (180 / divisor) as usize);
        let n = f64::from(open) / 180.0;
        // Orders well beyond k rho are nothing.
        let last = k_rho + 20.0 * k_rho.cbrt() + 30.0;
        let chains: Vec<Vec<f64>> = (0..a)
            .map(|i| bessel_chain(i as f64 / a as f64, k_rho, last as usize + 2))
            .collect();
        let weight = |m: usize| {
            let bessel = chains[m * b % a][m * b / a];
            Complex64::cis(FRAC_PI_2 * m as f64 / n) * (4.0 / n * bessel)
        };
        let terms = (n * last) as usize;
        Self {
            n,
            k_rho,
            weights: (1..=terms).map(weight).collect(),
        }
    }

    /// Open angle over pi.
    #[must_use]
    pub fn n(&self) -> f64 {
        self.n
    }

    /// Distance in wavelengths times 2 pi.
    #[must_use]
    pub fn k_rho(&self) -> f64 {
        self.k_rho
    }

    /// The field in direction `phi` \[rad\] for a wave from `incident` \[rad\], both 0..=n pi, in parts of the wave's
    /// amplitude; good to 1e-11.
    #[must_use]
    pub fn field(&self, incident: f64, phi: f64) -> Complex64 {
        let term = |(weight, m): (&Complex64, i32)| {
            let v = f64::from(m) / self.n;
            weight * ((v * phi).sin() * (v * incident).sin())
        };
        self.weights.iter().zip(1..).map(term).sum()
    }
}

/// The incident wave and its reflections at the faces, each where geometrical optics has it. A shadow boundary belongs to
/// the wave, a reflection boundary of the 0-face to the reflection, one of the n-face not, as in
/// [`aps_raytrace::utd::diffraction_coefficient`].
#[must_use]
pub fn geometrical_optics(n: f64, k_rho: f64, incident: f64, phi: f64) -> Complex64 {
    let (difference, sum) = ((phi - incident).abs(), phi + incident);
    let plane = |angle: f64| Complex64::cis(k_rho * angle.cos());
    let mut field = Complex64::ZERO;
    if difference <= PI {
        field += plane(difference);
    }
    if sum <= PI {
        field -= plane(sum);
    }
    if sum > (2.0 * n - 1.0) * PI {
        field -= plane(2.0 * n * PI - sum);
    }
    field
}

/// The field by rays: geometrical optics and a diffracted wave with the coefficient `d`, in units of 1/sqrt(k).
#[must_use]
pub fn by_rays(n: f64, k_rho: f64, incident: f64, phi: f64, d: Complex64) -> Complex64 {
    geometrical_optics(n, k_rho, incident, phi) + d * Complex64::cis(-k_rho) / k_rho.sqrt()
}

/// J of the orders `fraction` + 0, 1, ..., `last`, for 0 <= `fraction` < 1.
///
/// Backwards from an order where J is nothing, which is stable, and scaled by Neumann's series
/// (x/2)^f = sum_k (f + 2k) Gamma(f + k) / k! J_{f+2k}(x) (Digital Library of Mathematical Functions, 10.23.15).
fn bessel_chain(fraction: f64, x: f64, last: usize) -> Vec<f64> {
    // J falls off beyond the order x, over a width of the cubic root of x.
    let start = last.max((x + 8.0 * x.cbrt()) as usize) + 40;
    let mut orders = vec![0.0; start + 2];
    orders[start] = 1e-290;
    for i in (1..=start).rev() {
        let order = fraction + i as f64;
        orders[i - 1] = 2.0 * order / x * orders[i] - orders[i + 1];
        if orders[i - 1].abs() > 1e200 {
            orders[i - 1..].iter_mut().for_each(|j| *j *= 1e-200);
        }
    }
    // Gamma(f + k) / k!, but for k = 0, where only f Gamma(f) is needed.
    let gamma = libm::tgamma(1.0 + fraction);
    let mut sum = gamma * orders[0];
    let mut ratio = gamma;
    for k in 1..=start / 2 {
        sum += (fraction + 2.0 * k as f64) * ratio * orders[2 * k];
        ratio *= (fraction + k as f64) / (k as f64 + 1.0);
    }
    let scale = (0.5 * x).powf(fraction) / sum;
    orders.truncate(last + 1);
    orders.iter_mut().for_each(|j| *j *= scale);
    orders
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_agrees_with_the_golden_table() {
        let table = include_str!("../golden/wedge.csv");
        let mut known: Option<(u32, ExactWedge)> = None;
        let mut worst = 0.0_f64;
        for line in table.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|s| s.parse().unwrap()).collect();
            let (interior, k_rho) = (row[0] as u32, row[1]);
            if !known
                .as_ref()
                .is_some_and(|(i, w)| *i == interior && w.k_rho() == k_rho)
            {
                known = Some((interior, ExactWedge::new(interior, k_rho)));
            }
            let (_, wedge) = known.as_ref().unwrap();
            let field = wedge.field(row[2].to_radians(), row[3].to_radians());
            worst = worst.max((field - Complex64::new(row[4], row[5])).norm());
        }
        eprintln!("largest difference from SciPy's series: {worst:.1e} of the incident field");
        assert!(worst < 1e-10, "{worst:e}");
    }

    #[test]
    fn bessel_functions_of_half_orders_are_elementary() {
        // J_1/2(x) = sqrt(2 / (pi x)) sin x; far from it all orders are there at once.
        for x in [0.3, 1.0, 17.0, 900.0] {
            let found = bessel_chain(0.5, x, 10)[0];
            let expected = (2.0 / (PI * x)).sqrt() * x.sin();
            assert!(
                (found - expected).abs() < 1e-13,
                "{x}: {found} is not {expected}"
            );
        }
    }

    #[test]
    fn field_vanishes_on_the_faces() {
        let wedge = ExactWedge::new(75, 40.0);
        for phi in [0.0, wedge.n() * PI] {
            assert!(wedge.field(1.1, phi).norm() < 1e-10);
        }
    }
}
