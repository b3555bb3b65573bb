//! Ways to the field behind a wedge.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use aps_raytrace::transition::transition;
use aps_raytrace::{Complex64, utd};
use aps_tests::wedge::by_rays;

const PERFECT: Complex64 = Complex64::new(-1.0, 0.0);

/// A theory, and how it is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The uniform theory as aps-raytrace computes it.
    Utd,
    /// The uniform theory as printed, with the usual transition function of three pieces.
    ThreePieces,
    /// The uniform theory as printed, with the transition function by quadrature.
    Quadrature,
    /// Keller's theory: no transition function, infinite at the boundaries.
    Keller,
    /// Recommendation ITU-R P.526, the approximation for a knife edge: a level, and only in the shadow.
    KnifeEdge,
}

impl Method {
    pub const ALL: [Self; 5] = [
        Self::Utd,
        Self::ThreePieces,
        Self::Quadrature,
        Self::Keller,
        Self::KnifeEdge,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Utd => "UTD (aps-raytrace)",
            Self::ThreePieces => "UTD, F in three pieces",
            Self::Quadrature => "UTD, F by quadrature",
            Self::Keller => "Keller's GTD",
            Self::KnifeEdge => "knife edge (P.526)",
        }
    }

    /// The total field at `k_rho` in direction `phi` for a wave of amplitude 1 from `incident` [rad]. The knife edge
    /// gives its level alone, as a real number.
    pub fn field(self, n: f64, k_rho: f64, incident: f64, phi: f64) -> Complex64 {
        let printed = |f: &dyn Fn(f64) -> Complex64| {
            by_rays(
                n,
                k_rho,
                incident,
                phi,
                coefficient(n, k_rho, [incident, phi], f),
            )
        };
        match self {
            // Lengths in units of 1/k.
            Self::Utd => {
                let d =
                    utd::diffraction_coefficient(n, 1.0, k_rho, incident, phi, PERFECT, PERFECT);
                by_rays(n, k_rho, incident, phi, d)
            }
            Self::ThreePieces => printed(&three_pieces),
            Self::Quadrature => printed(&aps_tests::utd::transition),
            Self::Keller => printed(&|_| Complex64::ONE),
            Self::KnifeEdge => {
                let beyond = (phi - incident).abs() - PI;
                let v = 2.0 * (0.5 * beyond).sin() * (k_rho / PI).sqrt() - 0.1;
                let loss_db = 6.9 + 20.0 * ((v * v + 1.0).sqrt() + v).log10();
                Complex64::from(10_f64.powf(-0.05 * loss_db))
            }
        }
    }
}

/// Kouyoumjian and Pathak 1974, eq. 25, as printed, for a perfect conductor; lengths in units of 1/k. Not defined on a
/// boundary itself.
fn coefficient(n: f64, distance: f64, phi: [f64; 2], f: &dyn Fn(f64) -> Complex64) -> Complex64 {
    let (difference, sum) = (phi[0] - phi[1], phi[0] + phi[1]);
    let product = |beta: f64, sign: f64| {
        let nearest = ((beta + sign * PI) / (TAU * n)).round();
        let a = 2.0 * ((TAU * n * nearest - beta) / 2.0).cos().powi(2);
        f(distance * a) / ((PI + sign * beta) / (2.0 * n)).tan()
    };
    let bracket = product(difference, 1.0) + product(difference, -1.0)
        - product(sum, -1.0)
        - product(sum, 1.0);
    -Complex64::cis(-FRAC_PI_4) / (2.0 * n * TAU.sqrt()) * bracket
}

/// The usual F: two terms below 0.3, lines between eight tabulated values, five terms from 5.5 on (Kouyoumjian and
/// Pathak 1974, eqs. 28 and 29; the table as in McNamara, Pistorius and Malherbe, "Introduction to the Uniform Geometrical
/// Theory of Diffraction", 1990).
pub fn three_pieces(x: f64) -> Complex64 {
    const TABLE: [(f64, f64, f64); 8] = [
        (0.3, 0.5729, 0.2677),
        (0.5, 0.6768, 0.2682),
        (0.7, 0.7439, 0.2549),
        (1.0, 0.8095, 0.2322),
        (1.5, 0.8730, 0.1982),
        (2.3, 0.9240, 0.1577),
        (4.0, 0.9658, 0.1073),
        (5.5, 0.9797, 0.0828),
    ];
    if x < TABLE[0].0 {
        let start = (PI * x).sqrt()
            - 2.0 * x * Complex64::cis(FRAC_PI_4)
            - 2.0 / 3.0 * x * x * Complex64::cis(-FRAC_PI_4);
        start * Complex64::cis(FRAC_PI_4 + x)
    } else if x < TABLE[7].0 {
        let above = TABLE.partition_point(|row| row.0 <= x);
        let (p, q) = (TABLE[above - 1], TABLE[above]);
        let part = (x - p.0) / (q.0 - p.0);
        Complex64::new(p.1 + part * (q.1 - p.1), p.2 + part * (q.2 - p.2))
    } else {
        let v = 1.0 / (2.0 * x);
        Complex64::new(1.0 - 3.0 * v * v + 75.0 * v.powi(4), v - 15.0 * v.powi(3))
    }
}

/// A transition function.
pub type Transition = fn(f64) -> Complex64;

/// Ways to it.
pub const TRANSITIONS: [(&str, Transition); 3] = [
    ("aps-raytrace", transition),
    ("three pieces", three_pieces),
    ("quadrature", aps_tests::utd::transition),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_of_the_usual_transition_function_meet() {
        for (x, within) in [(0.3, 1e-4), (5.5, 5e-3)] {
            let (below, above) = (three_pieces(x * (1.0 - 1e-12)), three_pieces(x));
            assert!((below - above).norm() < within, "{x}: {below} {above}");
        }
    }

    #[test]
    fn printed_coefficient_is_the_crate_s_off_the_boundaries() {
        for n in [1.2, 1.5, 2.0] {
            for (incident, phi) in [(0.4, 1.3), (0.4, 3.55), (1.1, 3.0)] {
                let at = |method: Method| method.field(n, 37.0, incident, phi);
                let gap = (at(Method::Utd) - at(Method::Quadrature)).norm();
                assert!(gap < 1e-9, "{n} {incident} {phi}: {gap:e}");
            }
        }
    }
}
