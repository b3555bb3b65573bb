//! Laws every label obeys, for links drawn at random.

use crate::common::{
    MAXIMUM_ERROR, assert_power_db, label, labeler, linear, link, path, tolerance, total_power,
};
use aps_label::{Array, Label, LabelConfig, Labeler, PathSample, Protocol, Scratch, Status};
use proptest::prelude::*;

fn circular(protocol: Protocol, elements: usize) -> Labeler {
    let array = Array::UniformCircular {
        elements,
        radius_wavelengths: 1.0,
    };
    Labeler::new(&LabelConfig {
        array,
        pdp: true,
        ..LabelConfig::of(protocol)
    })
    .expect("valid array")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn order_of_the_paths_does_not_change_a_bit(paths in link(), seed in any::<prop::sample::Index>()) {
        let mut other = paths.clone();
        other.rotate_left(seed.index(paths.len()));
        other.reverse();
        for protocol in Protocol::ALL {
            let labeler = labeler(protocol);
            prop_assert_eq!(label(&labeler, &paths), label(&labeler, &other));
        }
    }

    #[test]
    fn buffers_used_before_do_not_change_a_bit(first in link(), second in link()) {
        for protocol in Protocol::ALL {
            let labeler = labeler(protocol);
            let mut scratch = Scratch::default();
            let mut got = Label::default();
            for paths in [&first, &second, &first] {
                let status = labeler.label_into(paths, &mut scratch, &mut got).expect("good paths");
                prop_assert_eq!(status, Status::Labelled);
                prop_assert_eq!(&got, &label(&labeler, paths));
            }
        }
    }

    #[test]
    fn scaling_all_gains_shifts_the_label(paths in link(), shift_db in -80.0..60.0) {
        let mut shifted = paths.clone();
        shifted.iter_mut().for_each(|path| path.gain_db += shift_db);
        let labeler = labeler(Protocol::Paper);
        let (a, b) = (label(&labeler, &paths), label(&labeler, &shifted));
        for (a, b) in a.aps_db.iter().chain(&a.pdp_db).zip(b.aps_db.iter().chain(&b.pdp_db)) {
            let error: f64 = a + shift_db - b;
            prop_assert!(error.abs() < 1e-10, "{} + {} is not {}", a, shift_db, b);
        }
    }

    #[test]
    fn linear_array_labels_mirrored_paths_alike(paths in link()) {
        let mut mirrored = paths.clone();
        mirrored.iter_mut().for_each(|path| path.arrival_azimuth_rad = std::f64::consts::PI - path.arrival_azimuth_rad);
        for protocol in Protocol::ALL {
            let labeler = labeler(protocol);
            let total = total_power(protocol, &paths);
            let (a, b) = (label(&labeler, &paths), label(&labeler, &mirrored));
            for (a, b) in a.aps_db.iter().zip(&b.aps_db) {
                assert_power_db(*a, *b, total, "mirrored");
            }
        }
    }

    #[test]
    fn linear_array_label_is_its_own_mirror_image(paths in link()) {
        let a = label(&labeler(Protocol::Paper), &paths).aps_db;
        // Bin j is at 2 j - 180 deg, its mirror image at 360 - 2 j = 2 (270 - j) - 180 deg.
        for j in 0..180 {
            prop_assert_eq!(a[j], a[(270 - j) % 180]);
        }
    }

    #[test]
    fn another_path_never_lowers_a_bin(paths in link(), more in path()) {
        let mut superset = paths.clone();
        superset.push(more);
        for protocol in Protocol::ALL {
            for labeler in [labeler(protocol), circular(protocol, 16)] {
                let (a, b) = (label(&labeler, &paths), label(&labeler, &superset));
                for (a, b) in a.aps_db.iter().chain(&a.pdp_db).zip(b.aps_db.iter().chain(&b.pdp_db)) {
                    // 1e-6 dB where the maximum is continuous.
                    prop_assert!(*b >= a - if protocol == Protocol::Paper { 1e-6 } else { 1e-10 }, "{} fell to {}", a, b);
                }
            }
        }
    }

    #[test]
    fn sampled_label_is_the_largest_q_of_the_delay_axis(paths in link(), bin in 0_usize..180, odd in 0_usize..2) {
        for labeler in [labeler(Protocol::Released), circular(Protocol::Released, 12 + odd)] {
            let total = total_power(Protocol::Released, &paths);
            let theta = labeler.angles_deg()[bin].to_radians();
            let want = labeler.delays_s().iter()
                .map(|&tau| labeler.q(&paths, tau, theta).expect("finite"))
                .fold(0.0, f64::max);
            assert_power_db(label(&labeler, &paths).aps_db[bin], 10.0 * (want + 1e-35).log10(), total, "bin");
        }
    }

    #[test]
    fn continuous_maximum_is_attained_and_never_exceeded(paths in link(), bin in 0_usize..180) {
        for labeler in [labeler(Protocol::Paper), circular(Protocol::Paper, 9)] {
            let total = total_power(Protocol::Paper, &paths);
            let theta = labeler.angles_deg()[bin].to_radians();
            let label = label(&labeler, &paths);
            let got = linear(label.aps_db[bin]);
            let q = |tau| labeler.q(&paths, tau, theta).expect("finite");
            let attained = q(label.aps_delay_s[bin]);
            let allowed = MAXIMUM_ERROR * got + tolerance(got, total);
            prop_assert!((got - attained).abs() <= allowed, "{:e} is not Q = {:e}", got, attained);
            // 0.2 ns is a twenty-fifth of the pulse's width: a peak between two points shows all
            // but 1.3e-3 of itself, so a wrong peak would be found out.
            let mut tau = 0.0;
            while tau < 1.5e-6 {
                prop_assert!(q(tau) <= got + allowed, "Q({:e}) = {:e} > {:e}", tau, q(tau), got);
                tau += 2e-10;
            }
        }
    }

    #[test]
    fn anything_finite_gives_finite_numbers(
        paths in prop::collection::vec(
            (0.0..1.0, prop::num::f64::NORMAL, -1e4..1e4).prop_map(|(delay_s, arrival_azimuth_rad, gain_db)| {
                PathSample { delay_s, arrival_azimuth_rad, gain_db }
            }),
            1..12,
        ),
    ) {
        for protocol in Protocol::ALL {
            for labeler in [labeler(protocol), circular(protocol, 7)] {
                if let Some(label) = labeler.label(&paths).expect("finite paths") {
                    let values = [&label.aps_db, &label.aps_delay_s, &label.pdp_db, &label.pdp_angle_deg];
                    prop_assert!(values.iter().all(|v| v.iter().all(|x| x.is_finite())));
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn heading_is_counted_from(azimuth_rad in -20.0..20.0, heading_rad in -7.0..7.0) {
        let path = PathSample { delay_s: 1e-7, arrival_azimuth_rad: azimuth_rad, gain_db: -90.0 };
        prop_assert_eq!(path.from_heading(0.0), path);
        let seen = path.from_heading(heading_rad);
        let at = seen.arrival_azimuth_rad;
        prop_assert!(at.abs() <= std::f64::consts::PI);
        let (sine, cosine) = (azimuth_rad - heading_rad).sin_cos();
        prop_assert!((at.sin() - sine).hypot(at.cos() - cosine) < 1e-14);
        prop_assert_eq!((seen.delay_s, seen.gain_db), (path.delay_s, path.gain_db));
    }
}
