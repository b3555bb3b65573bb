//! Labels of links that span what numbers can span.

use std::f64::consts::PI;

use aps_label::{
    Array, ConfigError, DelayAxis, Label, LabelConfig, Labeler, PathError, PathSample, Protocol,
};
use aps_tests::double_double::{self, DoubleDouble, dd};
use aps_tests::label::{array_response, linear, path, q, squared_sinc};

fn labeled(config: &LabelConfig, paths: &[PathSample]) -> Label {
    let label = Labeler::new(config).unwrap().label(paths).unwrap().unwrap();
    let all = [
        &label.aps_db,
        &label.aps_delay_s,
        &label.pdp_db,
        &label.pdp_angle_deg,
    ];
    assert!(all.into_iter().flatten().all(|v| v.is_finite()));
    label
}

/// The relative error allowed for a value where no response vanishes: 1e-6 dB of a continuous
/// maximum, rounding otherwise.
fn relative_error(protocol: Protocol) -> f64 {
    match protocol {
        Protocol::Paper => 2.3e-7,
        Protocol::Released => 1e-11,
    }
}

/// Compares each bin of a label with Q at the label's own delay, in 32 digits. `root` is the error
/// allowed for the root of a single response.
fn check(config: &LabelConfig, paths: &[PathSample], root: f64, what: &str) -> f64 {
    let label = labeled(config, paths);
    let labeler = Labeler::new(config).unwrap();
    let send_db = config.protocol.sent_power_db();
    let strongest = paths.iter().map(|p| p.gain_db).fold(f64::MIN, f64::max) + send_db;
    let total: f64 = paths
        .iter()
        .map(|p| 10_f64.powf(0.1 * (p.gain_db + send_db - strongest)))
        .sum();
    let mut worst = 0.0_f64;
    let bins = label.aps_db.iter().zip(&label.aps_delay_s);
    for ((db, tau), theta) in bins.zip(labeler.angles_deg()) {
        let theta_half_turns = dd(*theta) / dd(180.0);
        let want = q(config, paths, dd(*tau), theta_half_turns) / dd(strongest).from_decibel();
        let (got, want) = (10_f64.powf(0.1 * (db - strongest)), want.to_f64());
        let allowed = relative_error(config.protocol) * want
            + 2.0 * root * (want * total).sqrt()
            + root * root * total
            + 1.1e-35;
        assert!(
            (got - want).abs() <= allowed,
            "{what}: bin {theta} is {got:e}, not {want:e}"
        );
        if want > 1e-12 * total {
            worst = worst.max((got / want - 1.0).abs());
        }
    }
    worst
}

/// Powers from 1e-30 to 1 W in one link, each from a direction and at a delay of its own. Where
/// the array has a null for the strong paths the weak ones are all that is there; nothing may be
/// lost to the sum. Expected: Q of 32 digits.
#[test]
fn three_hundred_decibels_in_one_link() {
    let of = |i: f64| path(1e-7 + 2.7e-8 * i, -3.0 + 0.2 * i, -10.0 * i - 0.5);
    let paths: Vec<PathSample> = (0..=30).map(|i| of(i.into())).collect();
    for protocol in Protocol::ALL {
        let worst = check(&LabelConfig::of(protocol), &paths, 2e-14, "300 dB");
        eprintln!("{protocol}: powers over 300 dB, worst relative error {worst:.1e}");
    }
    // The weakest alone at a delay 1 us from all others: its own bin is its power plus what the
    // others' pulses leave there.
    let weak = [path(1e-8, 0.3, 0.0 - 1e-9), path(9e-7, 0.3, -300.0)];
    check(&LabelConfig::paper(), &weak, 2e-14, "weak beside strong");
}

/// 10,000 equal paths are one path 40 dB stronger, in any protocol: the sum has no order to get
/// wrong, and the work of the continuous search must not grow with the square of what coincides.
#[test]
fn ten_thousand_equal_paths_are_forty_decibels() {
    for protocol in Protocol::ALL {
        let config = LabelConfig {
            pdp: true,
            ..LabelConfig::of(protocol)
        };
        let one = path(4e-7, 0.7, -90.0);
        let single = labeled(&config, &[one]);
        let many = labeled(&config, &vec![one; 10_000]);
        // Where the floor of -350 dB does not count.
        let spectra = single.aps_db.iter().zip(&many.aps_db);
        for (a, b) in spectra.chain(single.pdp_db.iter().zip(&many.pdp_db)) {
            assert!(
                *a < -300.0 || (b - a - 40.0).abs() < 1e-10,
                "{protocol}: {a} {b}"
            );
        }
        assert_eq!(single.aps_delay_s, many.aps_delay_s);
        assert_eq!(single.pdp_angle_deg, many.pdp_angle_deg);
    }
}

/// 10,000 paths, all different: the continuous search holds pulses at eight delays at a time, instead
/// of what grows with the square of the number of paths. Expected: Q of 32 digits.
#[test]
fn ten_thousand_different_paths_fit_in_memory() {
    let paths: Vec<PathSample> = (0..10_000)
        .map(|i: u32| {
            let j = f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
            path(
                1e-7 + 1e-10 * f64::from(i),
                6.0 * j - 3.0,
                -80.0 - 60.0 * (7.3 * j).fract(),
            )
        })
        .collect();
    for protocol in Protocol::ALL {
        let label = labeled(&LabelConfig::of(protocol), &paths);
        let labeler = Labeler::new(&LabelConfig::of(protocol)).unwrap();
        for bin in [0, 44, 45, 101, 179] {
            let theta = dd(labeler.angles_deg()[bin]) / dd(180.0);
            let want = q(labeler.config(), &paths, dd(label.aps_delay_s[bin]), theta)
                .decibel()
                .to_f64();
            let allowed_db = 10.0 * relative_error(protocol).ln_1p() / std::f64::consts::LN_10;
            assert!(
                (label.aps_db[bin] - want).abs() < allowed_db.max(1e-9),
                "{protocol}, bin {bin}: {} {want}",
                label.aps_db[bin]
            );
        }
    }
    let labeler = Labeler::new(&LabelConfig::paper()).unwrap();
    let error = labeler
        .label(&vec![path(1e-7, 0.0, -90.0); 100_000])
        .unwrap_err();
    assert!(matches!(error, PathError::TooMany { count: 100_000, .. }));
}

/// A single path: its gain, to 1e-6 dB, at exactly its delay, whatever its power.
#[test]
fn one_path_is_its_own_label() {
    for gain_db in [0.0, -90.0, -300.0, 1e4, -1e4] {
        for delay_s in [0.0, 1e-12, 3.1e-7, 0.5, 1.0] {
            let label = labeled(&LabelConfig::paper(), &[path(delay_s, 0.0, gain_db)]);
            assert!((label.aps_db[90] - gain_db).abs() <= 1e-6);
            assert_eq!(label.aps_delay_s[90], delay_s);
        }
    }
}

/// Paths from exactly +-90 deg (where d sin(theta)/d theta is zero and the two ends alias) and
/// +-180 deg (the seam of the grid). Both signs of 180 deg are one direction; +-90 deg alias at half
/// a wavelength. Expected: Q of 32 digits, and the same label for both signs.
#[test]
fn paths_at_quarter_and_half_turns() {
    for protocol in Protocol::ALL {
        let config = LabelConfig::of(protocol);
        for azimuth in [PI / 2.0, PI, 0.0, 1.5 * PI, 2.0 * PI, -7.0 * PI] {
            let [plus, minus] =
                [azimuth, -azimuth].map(|a| [path(3e-7, a, -80.0), path(5e-7, 0.3, -95.0)]);
            check(&config, &plus, 2e-14, "plus");
            check(&config, &minus, 2e-14, "minus");
            let (plus, minus) = (labeled(&config, &plus), labeled(&config, &minus));
            for (a, b) in plus.aps_db.iter().zip(&minus.aps_db) {
                // Nulls are as deep as pi is exact.
                assert!(
                    *a < -250.0
                        || (a - b).abs() < 1e-3_f64.max(1e-13 * 10_f64.powf(-0.05 * (a + 80.0))),
                    "{azimuth}: {a} {b}"
                );
            }
        }
    }
}

/// psi at, and an ulp beside, every multiple of pi that a spacing of whole wavelengths reaches: the
/// kernel is 1 there, a quotient of two zeros. Expected: the response in 32 digits, within what an
/// ulp of the angle means.
#[test]
fn response_at_every_multiple_of_pi() {
    let mut worst = 0.0_f64;
    for elements in [2, 3, 16, 255, 4096] {
        for spacing in [1.0, 4.0, 10.0] {
            let array = linear(elements, spacing);
            // psi = pi d sin(theta) from broadside: m pi at sin(theta) = m / d.
            for m in -(spacing as i32)..=spacing as i32 {
                let grating = (f64::from(m) / spacing).asin();
                for step in -3..=3 {
                    let theta = grating + f64::from(step) * f64::EPSILON;
                    let got = array.power_response(theta, 0.0);
                    let half_turns = dd(theta) / double_double::PI;
                    let want = array_response(&array, half_turns, DoubleDouble::ZERO).to_f64();
                    // The slope of N psi over the angle is at most pi d N.
                    let ulps = 4.0 * f64::EPSILON * PI * spacing * elements as f64;
                    worst = worst.max((got - want).abs());
                    assert!(
                        (got - want).abs() < ulps.max(4e-16),
                        "N {elements}, d {spacing}, m {m}: {got} {want}"
                    );
                    assert!(got <= 1.0 + 1e-15);
                }
            }
        }
    }
    eprintln!("array response next to multiples of pi: absolute error {worst:.1e}");
}

/// Arrays from 1 to 4096 elements, linear and circular. N psi goes up to 6400 half turns; the error
/// of a root grows in proportion to N and no faster.
#[test]
fn arrays_from_one_to_4096_elements() {
    let paths = [
        path(2.1e-7, 0.4, -70.0),
        path(2.2e-7, -1.9, -75.0),
        path(6e-7, 3.1, -72.0),
    ];
    for elements in [1, 2, 3, 16, 101, 1024, 4096] {
        let circular = Array::UniformCircular {
            elements,
            radius_wavelengths: 0.08 * elements as f64,
        };
        for array in [linear(elements, 0.5), circular] {
            let config = LabelConfig {
                array,
                ..LabelConfig::released()
            };
            let root = 2e-15 * (elements as f64).max(10.0);
            let worst = check(&config, &paths, root, &format!("{array:?}"));
            eprintln!("{array:?}: worst relative error {worst:.1e}");
        }
    }
    for elements in [0, 4097, usize::MAX] {
        let config = LabelConfig {
            array: linear(elements, 0.5),
            ..LabelConfig::paper()
        };
        assert!(matches!(
            Labeler::new(&config).err(),
            Some(ConfigError::Elements { .. })
        ));
    }
}

/// f_s from 1 kHz, where a pulse is 1 ms wide and all paths merge, to 100 GHz, where 1 s is 1e11
/// pulses; delays up to 1 s, alone, and in pairs a fraction of a pulse apart near 1 s, where
/// doubles are 1e-16 s apart. Expected: Q of 32 digits at the delay reported, and that no delay
/// near it has more than the 1e-6 dB that the search promises or than the spacing of doubles allows.
#[test]
fn sampling_rates_from_kilohertz_to_a_hundred_gigahertz() {
    for rate in [1e3, 1e6, 200e6, 1e10, 1e11, 1e12] {
        for start in [0.0, 1e-7, 1e-3, 1.0 - 1e-9] {
            let config = LabelConfig {
                sampling_rate_hz: rate,
                delay_axis: DelayAxis {
                    points: 64,
                    last_s: 1.0,
                },
                pdp: true,
                ..LabelConfig::paper()
            };
            for apart in [0.0, 0.13, 0.5, 0.7, 1.3, 7.9] {
                let at = |u: f64| (start + u / rate).min(1.0);
                let paths = [
                    path(0.0, 0.3, -120.0),
                    path(at(0.0), 0.4, -70.0),
                    path(at(apart), 0.43, -70.5),
                ];
                let label = labeled(&config, &paths);
                let what = format!("{rate:e} Hz, {start} s, {apart}");
                // Delays, differences of delays and places in the search are rounded.
                let slack = (rate * f64::EPSILON * start.max(1e-300) * 4.0).min(1.0);
                for (bin, theta) in [(90, 0.0), (101, 22.0), (103, 26.0)] {
                    let theta = dd(theta) / dd(180.0);
                    let got = 10_f64.powf(0.1 * label.aps_db[bin]);
                    let tau = dd(label.aps_delay_s[bin]);
                    for step in [-0.3, -0.1, -1e-3, 0.0, 1e-3, 0.1, 0.3] {
                        let there = q(&config, &paths, tau + dd(step) / dd(rate), theta).to_f64();
                        assert!(
                            there <= got * (1.0 + relative_error(Protocol::Paper) + 20.0 * slack),
                            "{what}, bin {bin}: {there:e} beside {got:e}"
                        );
                    }
                    let here = q(&config, &paths, tau, theta).to_f64();
                    assert!(
                        (here / got - 1.0).abs() <= relative_error(Protocol::Paper) + 20.0 * slack,
                        "{what}, bin {bin}: {here:e} for {got:e}"
                    );
                }
            }
        }
    }
}

/// The pulse at integers (exactly zero), at halves, beside integers and far out, against 32 digits:
/// a relative error of some ulps everywhere, zeros included.
#[test]
fn pulse_is_good_to_the_last_digits_far_out() {
    let labeler = Labeler::new(&LabelConfig {
        array: linear(1, 0.5),
        sampling_rate_hz: 1e9,
        ..LabelConfig::paper()
    })
    .unwrap();
    let mut worst = 0.0_f64;
    for exponent in -6..=8 {
        for i in 0..200 {
            let u = (1.0 + f64::from(i) * 0.045) * 10_f64.powi(exponent);
            // The kernel's argument is f_s tau as a double.
            let tau = (u / 1e9).min(1.0);
            let got = labeler.q(&[path(0.0, 0.0, 0.0)], tau, 0.0).unwrap();
            let want = squared_sinc(dd(1e9 * tau)).to_f64();
            if want > 1e-30 {
                worst = worst.max((got / want - 1.0).abs());
            }
        }
    }
    eprintln!("pulse: worst relative error {worst:.1e}");
    assert!(worst < 4e-15);
}
