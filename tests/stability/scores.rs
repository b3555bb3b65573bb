//! Normalisation and metrics of constant, tiny and huge spectra.

use aps_label::{MeanStd, Moments, Normalization, NormalizationError, relative_power};
use aps_metrics::{
    Bootstrap, DataRange, Distribution, Evaluation, MAX_MAGNITUDE, Metric, Protocol, Scorer,
    Spectra,
};
use aps_tests::double_double::{DoubleDouble, dd};

const SPLIT: MeanStd = MeanStd {
    mean: 0.17,
    std: 0.26,
};

/// The metrics of one sample, all of them finite.
fn scores(protocol: Protocol, truth: &[f64], prediction: &[f64]) -> impl Fn(Metric) -> f64 + use<> {
    let scores = Scorer::new(protocol).score(truth, prediction).unwrap();
    let range = DataRange::new(1.0).unwrap();
    let of = move |metric: Metric| metric.of(&scores, range);
    for metric in Metric::ALL {
        let value = of(metric);
        assert!(value.is_finite(), "{protocol:?}: {metric:?} is {value}");
    }
    of
}

/// Constant spectra: no peak, cosine 1 between positive ones and -1 against negative ones, errors
/// that are those of the constants, at every magnitude from denormal to the limit.
#[test]
fn constant_spectra_score_as_their_constants() {
    let magnitudes = [
        5e-324,
        1e-310,
        1e-160,
        1e-20,
        1e-8,
        1.0,
        1e20,
        0.5 * MAX_MAGNITUDE,
    ];
    for protocol in Protocol::ALL {
        for a in magnitudes {
            for b in magnitudes {
                for sign in [1.0, -1.0] {
                    let of = scores(protocol, &[a; 180], &[sign * b; 180]);
                    let want = (a - sign * b).abs();
                    assert!((of(Metric::Mae) - want).abs() <= 1e-14 * want);
                    assert_eq!(of(Metric::PleDeg), 0.0);
                    let cosine = of(Metric::Cosine);
                    let is_small = a.min(b) < 1e-8;
                    assert!(
                        is_small || (cosine - sign).abs() < 1e-14,
                        "{a} {b}: {cosine}"
                    );
                }
            }
        }
    }
}

/// One huge value among ordinary ones, on either side, up to the stated limit: every metric and
/// every statistic over many such samples is finite, as documented.
#[test]
fn one_huge_value_leaves_every_statistic_finite() {
    for huge in [1e30, 3e38, MAX_MAGNITUDE] {
        for protocol in Protocol::ALL {
            let mut ordinary = [0.0; 36];
            ordinary
                .iter_mut()
                .zip(0..)
                .for_each(|(v, i)| *v = f64::from(i % 7) - 3.0);
            let mut spiked = ordinary;
            spiked[5] = huge;
            let mut negative = ordinary;
            negative[9] = -huge;
            for (truth, prediction) in [
                (ordinary, spiked),
                (spiked, ordinary),
                (negative, spiked),
                (spiked, spiked),
                ([0.0; 36], spiked),
            ] {
                let _ = scores(protocol, &truth, &prediction);
            }
            // Many samples, half of them as bad as can be: sums of squares of the metrics.
            let samples = 20_000;
            let truth = vec![0.0; samples * 4];
            let prediction: Vec<f64> = (0..samples * 4)
                .map(|i| if i % 8 < 4 { huge } else { 0.0 })
                .collect();
            let mut evaluation = Evaluation::new(protocol);
            evaluation
                .push(
                    Spectra::new(&truth, 4).unwrap(),
                    Spectra::new(&prediction, 4).unwrap(),
                    None,
                )
                .unwrap();
            assert!(evaluation.rejected().is_empty());
            let range = evaluation.truth_range().unwrap();
            let clusters: Vec<(u32, u32)> = (0..samples as u32).map(|i| (i % 5, i % 50)).collect();
            let resamples = Bootstrap {
                replicates: 20,
                ..Bootstrap::default()
            }
            .draw(&clusters)
            .unwrap();
            for metric in Metric::ALL {
                let column = evaluation.column(metric, range);
                let d = Distribution::of(column.clone()).unwrap();
                let numbers = [
                    d.mean, d.std, d.min, d.q05, d.q25, d.median, d.q75, d.q95, d.max,
                ];
                assert!(
                    numbers.iter().all(|v| v.is_finite()),
                    "{huge:e} {metric:?}: {d:?}"
                );
                let estimate = resamples.mean(&column).unwrap().unwrap();
                let numbers = [estimate.mean, estimate.low, estimate.high];
                let is_finite = numbers.iter().all(|v| v.is_finite());
                assert!(is_finite, "{huge:e} {metric:?}: {estimate:?}");
            }
        }
    }
}

/// Denormal spectra: squares vanish, and with them the cosine, as the floors of its definition
/// say; nothing is divided by zero.
#[test]
fn denormal_spectra_are_zero_to_the_metrics() {
    let tiny: Vec<f64> = (0..180).map(|i| 5e-324 * f64::from(i % 11)).collect();
    for protocol in Protocol::ALL {
        let of = scores(protocol, &tiny, &tiny);
        assert_eq!((of(Metric::Cosine), of(Metric::Mse)), (0.0, 0.0));
        let _ = scores(protocol, &tiny, &[1.0; 180]);
        let _ = scores(protocol, &[1.0; 180], &tiny);
    }
}

/// Normalisation of constant labels: relative power 1 everywhere, so a split of nothing else has
/// deviation exactly 0, and dividing by it is refused; with a split's statistics a constant label
/// becomes a constant, and 0 to the bit where it is divided by its own deviation, of which only the
/// epsilon of 1e-8 is left: rounding of the mean would come out a hundred million times as large.
#[test]
fn constant_labels_normalise_to_constants() {
    let mut moments = Moments::default();
    for level in [-300.0, -87.3, 0.0, 12.5] {
        let mut values = [level; 180];
        assert_eq!(relative_power(&mut values), Ok(level));
        moments.add(&values).unwrap();
        for method in [Normalization::Paper(SPLIT), Normalization::Released(SPLIT)] {
            let mut values = [level; 180];
            method.apply(&mut values).unwrap();
            let want = match method {
                Normalization::Paper(_) => (1.0 - 0.17) / 0.26,
                Normalization::Released(_) => 0.0,
            };
            let is_right = |v: &f64| (v - want).abs() < 1e-15 && *v == values[0];
            assert!(values.iter().all(is_right));
        }
    }
    let statistics = moments.mean_std().unwrap();
    assert_eq!((statistics.mean, statistics.std), (1.0, 0.0));
    let refused = Normalization::Paper(statistics).apply(&mut [0.0; 180]);
    assert!(matches!(
        refused,
        Err(NormalizationError::Statistics { .. })
    ));
}

/// Moments of constants that binary fractions do not hold, and of values so close together that mean
/// square and squared mean agree in nearly all digits. Expected is the stated error of the variance,
/// 4e-16 (mean^2 + variance): no NaN from its root, and no deviation where digits allow none.
#[test]
fn moments_of_nearly_constant_values() {
    for (centre, spread) in [
        (0.1, 0.0),
        (0.7, 1e-6),
        (0.3, 1e-4),
        (-85.3, 1e-3),
        (-85.3, 0.0),
        (1e4 - 1.0, 0.5),
    ] {
        let values: Vec<f64> = (0..9000)
            .map(|i| centre + spread * f64::from(i % 3 - 1))
            .collect();
        let mut moments = Moments::default();
        moments.add(&values).unwrap();
        let got = moments.mean_std().unwrap();
        let n = dd(9000.0);
        let mean = values.iter().map(|&v| dd(v)).sum::<DoubleDouble>() / n;
        let square = |v: f64| (dd(v) - mean) * (dd(v) - mean);
        let std = (values.iter().map(|&v| square(v)).sum::<DoubleDouble>() / n)
            .sqrt()
            .to_f64();
        eprintln!(
            "moments around {centre}: deviation {:e} for {std:e}",
            got.std
        );
        assert!((got.mean - mean.to_f64()).abs() <= 2e-16 * centre.abs());
        let off = (got.std * got.std - std * std).abs();
        assert!(
            off <= 4e-16 * (centre * centre + std * std),
            "{centre} {spread}: {} {std}",
            got.std
        );
    }
}

/// Labels at the ends of what doubles hold: finite targets with the peak where the label has it, but for a label whose
/// range overflows and statistics that targets overflow by, which are refused.
#[test]
fn extreme_labels_are_refused_or_finite() {
    let rows: [(&[f64], bool); 5] = [
        (&[1.7e308, -1.7e308], false),
        (&[-1.7e308; 3], true),
        (&[5e-324, 0.0, -5e-324], true),
        (&[1e300, 0.0], true),
        (&[0.0, -1e4, -350.0], true),
    ];
    let overflowing = Normalization::Paper(MeanStd {
        mean: 0.5,
        std: 1e-310,
    });
    for (row, is_finite) in rows {
        let mut values = row.to_vec();
        assert_eq!(relative_power(&mut values).is_ok(), is_finite, "{row:?}");
        if is_finite {
            assert!(values.iter().all(|v| (0.0..=1.0).contains(v)), "{values:?}");
        }
        assert!(overflowing.apply(&mut row.to_vec()).is_err(), "{row:?}");
        for method in [Normalization::Paper(SPLIT), Normalization::Released(SPLIT)] {
            let mut values = row.to_vec();
            assert_eq!(method.apply(&mut values).is_ok(), is_finite, "{row:?}");
            let peak = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let is_at_peak = values[0] == peak(&values);
            assert!(
                !is_finite || is_at_peak && values.iter().all(|v| v.is_finite()),
                "{method:?} of {row:?}: {values:?}"
            );
        }
    }
}
