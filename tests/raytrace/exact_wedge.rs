//! The diffraction coefficient against the exact solution and against the textbook.

use std::f64::consts::PI;

use aps_raytrace::{Complex64, utd};
use aps_tests::utd::{MATERIALS, Radio};
use aps_tests::wedge;

const PERFECT: Complex64 = Complex64::new(-1.0, 0.0);

/// A row of the golden table: a plane wave of amplitude 1 at a perfectly conducting wedge.
struct Row {
    interior_deg: f64,
    k_rho: f64,
    incident: f64,
    phi: f64,
    field: Complex64,
}

impl Row {
    fn all() -> impl Iterator<Item = Self> {
        let table = include_str!("../golden/wedge.csv");
        table.lines().skip(1).map(|line| {
            let x: Vec<f64> = line.split(',').map(|s| s.parse().unwrap()).collect();
            Self {
                interior_deg: x[0],
                k_rho: x[1],
                incident: x[2].to_radians(),
                phi: x[3].to_radians(),
                field: Complex64::new(x[4], x[5]),
            }
        })
    }

    fn n(&self) -> f64 {
        (360.0 - self.interior_deg) / 180.0
    }

    fn is_in_shadow(&self) -> bool {
        self.phi - self.incident > PI
    }

    /// The rays of geometrical optics and the diffracted one; some rows lie on a boundary.
    fn by_utd(&self) -> Complex64 {
        let (n, rho) = (self.n(), self.k_rho);
        // Lengths in units of 1/k.
        let d =
            utd::diffraction_coefficient(n, 1.0, rho, self.incident, self.phi, PERFECT, PERFECT);
        wedge::by_rays(n, rho, self.incident, self.phi, d)
    }
}

const K_RHO: [f64; 7] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];

/// Largest of `value` over the rows of one wedge and distance.
fn worst(interior_deg: f64, k_rho: f64, value: impl Fn(&Row) -> Option<f64>) -> f64 {
    Row::all()
        .filter(|row| row.interior_deg == interior_deg && row.k_rho == k_rho)
        .filter_map(|row| value(&row))
        .fold(0.0, f64::max)
}

#[test]
fn half_plane_is_exact_at_any_distance() {
    for k_rho in K_RHO {
        let error = worst(0.0, k_rho, |row| Some((row.by_utd() - row.field).norm()));
        eprintln!("half plane, k rho {k_rho}: error {error:.1e} of the incident field");
        assert!(error < 1e-9);
    }
}

#[test]
fn wedges_are_good_to_one_part_in_25_k_rho() {
    eprintln!("largest error over all directions, parts of the incident field");
    eprintln!("k rho      30 deg    60 deg    90 deg   120 deg   150 deg");
    for k_rho in K_RHO {
        let errors = [30.0, 60.0, 90.0, 120.0, 150.0]
            .map(|interior| worst(interior, k_rho, |r| Some((r.by_utd() - r.field).norm())));
        let cells = errors.map(|e| format!("{e:10.1e}"));
        eprintln!("{k_rho:5} {}", cells.concat());
        for error in errors {
            assert!(error * k_rho < 0.04, "{error}");
        }
    }
}

/// Tests the error in decibels of the field in the shadow, which decides links without line of
/// sight. Directions within 5 degrees of the face are left out: the field itself vanishes there.
#[test]
fn shadow_is_good_to_a_tenth_of_a_decibel_from_one_wavelength_on() {
    eprintln!("largest error of the level in the shadow [dB]");
    eprintln!("k rho      30 deg    60 deg    90 deg   120 deg");
    for k_rho in K_RHO {
        let errors = [30.0, 60.0, 90.0, 120.0].map(|interior| {
            worst(interior, k_rho, |row| {
                let off_face = row.n() * PI - row.phi;
                let counts = row.is_in_shadow() && off_face > 5_f64.to_radians();
                counts.then(|| (20.0 * (row.by_utd().norm() / row.field.norm()).log10()).abs())
            })
        });
        let cells = errors.map(|e| format!("{e:10.4}"));
        eprintln!("{k_rho:5} {}", cells.concat());
        for error in errors {
            assert!(error > 0.0, "no rows compared");
            assert!(k_rho < 10.0 || error < 0.1, "{error}");
        }
    }
}

/// Against the printed formula, factor by factor; on a boundary that one is not defined.
#[test]
fn coefficient_is_that_of_the_textbook() {
    let mut worst = 0.0_f64;
    for (material, wall) in MATERIALS {
        let radio = Radio::of(wall);
        let k = radio.wavenumber_per_m();
        let reflector = material.at(radio.frequency_hz);
        for n in [1.001, 1.1, 1.25, 1.5, 1.75, 1.999_999, 2.0] {
            for distance_m in [0.01, 0.5, 20.0, 500.0] {
                for i in 0..=23 {
                    for j in 0..=29 {
                        let (p, q) = (n * PI * f64::from(i) / 23.0, n * PI * f64::from(j) / 29.0);
                        let expected = radio.diffraction(n, distance_m, [p, q]);
                        let [r_0, r_n] =
                            utd::incidence_cosines(n, p, q).map(|cos| reflector.reflection(cos));
                        let found = utd::diffraction_coefficient(n, k, distance_m, p, q, r_0, r_n);
                        // In parts of what D is at a boundary.
                        let error = (found - expected).norm() / (0.5 * distance_m.sqrt());
                        assert!(error < 1e-8, "n {n}, {p}, {q}: {found} is not {expected}");
                        worst = worst.max(error);
                    }
                }
            }
        }
    }
    eprintln!("largest difference from the textbook's formula: {worst:.1e} of D at a boundary");
}
