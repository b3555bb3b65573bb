//! Tests inputs that are refused or have no label, and sharing between threads.

use std::f64::consts::PI;

use crate::common::label;
use aps_label::{
    Array, Label, LabelConfig, Labeler, MAX_DELAY_S, MAX_PATHS, PathError, PathSample, Protocol,
    Scratch, Status,
};

const GOOD: PathSample = PathSample {
    delay_s: 3e-7,
    arrival_azimuth_rad: 0.5,
    gain_db: -90.0,
};

fn labeler(protocol: Protocol) -> Labeler {
    Labeler::new(&LabelConfig::of(protocol)).expect("valid preset")
}

#[test]
fn a_bad_path_is_named_and_leaves_no_label() {
    let not_finite = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let bad = not_finite.into_iter().flat_map(|x| {
        [
            PathSample { delay_s: x, ..GOOD },
            PathSample {
                arrival_azimuth_rad: x,
                ..GOOD
            },
            PathSample { gain_db: x, ..GOOD },
        ]
    });
    for protocol in Protocol::ALL {
        let labeler = labeler(protocol);
        let mut scratch = Scratch::default();
        let mut label = Label::default();
        for path in bad.clone() {
            let status = labeler.label_into(&[GOOD], &mut scratch, &mut label);
            assert_eq!(status, Ok(Status::Labelled));
            let error = labeler
                .label_into(&[GOOD, GOOD, path], &mut scratch, &mut label)
                .unwrap_err();
            assert!(matches!(error, PathError::NotFinite { index: 2, .. }));
            assert_eq!(label, Label::default());
            assert!(labeler.q(&[path], 3e-7, 0.0).is_err());
        }
    }
}

#[test]
fn an_impossible_delay_is_an_error() {
    for delay_s in [-1e-12, 300.0, 1.1 * MAX_DELAY_S] {
        let labeler = labeler(Protocol::Paper);
        let error = labeler.label(&[PathSample { delay_s, ..GOOD }]);
        let error = error.unwrap_err();
        let (index, value) = (0, delay_s);
        assert_eq!(error, PathError::Delay { index, value });
        assert!(error.to_string().contains("seconds"));
    }
}

#[test]
fn more_paths_than_a_link_can_have_are_an_error() {
    let (count, max) = (MAX_PATHS + 1, MAX_PATHS);
    let error = labeler(Protocol::Paper).label(&[GOOD; MAX_PATHS + 1]);
    assert_eq!(error, Err(PathError::TooMany { count, max }));
}

#[test]
fn a_link_without_counted_paths_has_no_label() {
    let too_weak = PathSample {
        gain_db: -310.1,
        ..GOOD
    };
    for (protocol, paths) in [
        (Protocol::Paper, [].as_slice()),
        (Protocol::Released, &[]),
        (Protocol::Released, &[too_weak]),
    ] {
        let labeler = labeler(protocol);
        assert_eq!(labeler.label(paths), Ok(None));
        let mut label = label(&labeler, &[GOOD]);
        let status = labeler.label_into(paths, &mut Scratch::default(), &mut label);
        assert_eq!(status, Ok(Status::NoPath));
        assert_eq!(label, Label::default(), "the former label is gone");
        assert_eq!(labeler.q(paths, 3e-7, 0.0), Ok(0.0));
    }
}

#[test]
fn a_point_that_is_not_finite_is_an_error() {
    let labeler = labeler(Protocol::Paper);
    for (tau, theta) in [(f64::NAN, 0.0), (0.0, f64::INFINITY)] {
        assert!(matches!(
            labeler.q(&[GOOD], tau, theta),
            Err(PathError::Point { .. })
        ));
    }
}

#[test]
fn q_is_never_nan() {
    let labeler = labeler(Protocol::Paper);
    let strong = PathSample {
        gain_db: 4000.0,
        ..GOOD
    };
    let pulse_s = 1.0 / labeler.config().sampling_rate_hz;
    let at = |path: PathSample, tau_s| labeler.q(&[path], tau_s, path.arrival_azimuth_rad);
    assert_eq!(at(strong, strong.delay_s), Ok(f64::INFINITY));
    let on_time = PathSample {
        delay_s: 0.0,
        ..strong
    };
    assert_eq!(at(on_time, pulse_s), Ok(0.0), "a zero of the pulse");
    assert_eq!(at(GOOD, f64::MAX), Ok(0.0));
    assert_eq!(at(GOOD, f64::MIN), Ok(0.0));
}

/// Released angles are the direction of travel, Paper's point towards the source.
#[test]
fn the_protocols_look_in_opposite_directions() {
    // An array that knows front from back.
    let array = Array::UniformCircular {
        elements: 16,
        radius_wavelengths: 1.0,
    };
    for (protocol, want_deg) in [(Protocol::Paper, 60.0), (Protocol::Released, -120.0)] {
        let config = LabelConfig {
            array,
            ..LabelConfig::of(protocol)
        };
        let labeler = Labeler::new(&config).expect("valid");
        let path = PathSample {
            arrival_azimuth_rad: PI / 3.0,
            ..GOOD
        };
        let label = label(&labeler, &[path]);
        let peak = (0..180)
            .max_by(|&a, &b| label.aps_db[a].total_cmp(&label.aps_db[b]))
            .expect("bins");
        assert!((labeler.angles_deg()[peak] - want_deg).abs() <= 1.01);
    }
}

/// The largest loss of the released delay grid: a path half-way between two delays.
#[test]
fn released_label_loses_almost_twelve_db_half_way_between_two_delays() {
    let step = 1e-6 / 127.0;
    let path = PathSample {
        delay_s: 40.5 * step,
        arrival_azimuth_rad: PI,
        ..GOOD
    };
    let label = label(&labeler(Protocol::Released), &[path]);
    let peak = label.aps_db.iter().copied().fold(f64::MIN, f64::max);
    assert!((-89.0 - peak - 11.8).abs() < 0.5, "peak {peak}");
}
