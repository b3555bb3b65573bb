//! The cluster bootstrap against closed forms, against NumPy and SciPy, and its laws.

use aps_metrics::{Bootstrap, Error, Estimate};
use proptest::prelude::*;

fn estimate(bootstrap: Bootstrap, clusters: &[(u32, u32)], values: &[f64]) -> Estimate {
    let estimate = bootstrap.draw(clusters).expect("a share").mean(values);
    estimate.expect("finite").expect("samples")
}

fn with_replicates(replicates: usize) -> Bootstrap {
    Bootstrap {
        replicates,
        ..Bootstrap::default()
    }
}

/// The links of `tests/golden/bootstrap.py`: five maps, 3 to 7 transmitters, 1 to 6 links.
fn links() -> (Vec<(u32, u32)>, Vec<f64>) {
    let mut found = (Vec::new(), Vec::new());
    for m in 0..5_u32 {
        for t in 0..3 + m {
            for r in 0..1 + (2 * t + m) % 6 {
                let noise = f64::from((37 * m + 101 * t + 53 * r) % 97) / 97.0;
                let (m_, t_) = (f64::from(m), f64::from((t * t) % 5));
                found.0.push((m, t));
                found.1.push(0.3 * m_ * (m_ - 2.0) + 0.2 * t_ + noise);
            }
        }
    }
    found
}

#[test]
fn interval_agrees_with_nested_loops_in_numpy() {
    let (clusters, values) = links();
    let found = estimate(with_replicates(40_000), &clusters, &values);
    // tests/golden/bootstrap.py, line "nested".
    assert_eq!(found.samples, 87);
    assert!((found.mean - 1.715_155_824_150).abs() < 1e-11, "{found:?}");
    assert!((found.low - 0.7493).abs() < 0.01, "{found:?}");
    assert!((found.high - 2.6628).abs() < 0.02, "{found:?}");
}

#[test]
fn one_map_with_a_link_a_transmitter_is_the_ordinary_bootstrap() {
    let values: Vec<f64> = (0..40).map(|i| f64::from((i * i) % 23) / 23.0).collect();
    let clusters: Vec<(u32, u32)> = (0..40).map(|t| (46, t)).collect();
    let found = estimate(with_replicates(40_000), &clusters, &values);
    // tests/golden/bootstrap.py, line "flat": scipy.stats.bootstrap(method="percentile").
    assert!((found.mean - 0.351_086_956_522).abs() < 1e-11, "{found:?}");
    assert!((found.low - 0.2761).abs() < 0.002, "{found:?}");
    assert!((found.high - 0.4283).abs() < 0.002, "{found:?}");
}

#[test]
fn spread_of_balanced_clusters_is_the_closed_form() {
    // M maps of T transmitters of 2 links: Var* = (between maps + within maps / T) / M, variances
    // of transmitter means with divisors M and T.
    let (m, t) = (12_u32, 9_u32);
    let tx_mean = |i: u32, j: u32| f64::from((i * i * 7) % 11) + 0.5 * f64::from((j * 5 + i) % 9);
    let mut clusters = Vec::new();
    let mut values = Vec::new();
    let (mut map_means, mut within) = (Vec::new(), 0.0);
    for i in 0..m {
        let means: Vec<f64> = (0..t).map(|j| tx_mean(i, j)).collect();
        for (j, mean) in means.iter().enumerate() {
            for step in [-0.25, 0.25] {
                clusters.push((i, j as u32));
                values.push(mean + step);
            }
        }
        let mean = means.iter().sum::<f64>() / f64::from(t);
        within += means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(t * m);
        map_means.push(mean);
    }
    let mean = map_means.iter().sum::<f64>() / f64::from(m);
    let between = map_means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / f64::from(m);
    let deviation = ((between + within / f64::from(t)) / f64::from(m)).sqrt();

    // The mean of 108 transmitters in 12 maps is nearly normal: 68.27 % within one deviation.
    let bootstrap = Bootstrap {
        level: 0.682_689_5,
        ..with_replicates(40_000)
    };
    let found = estimate(bootstrap, &clusters, &values);
    let half = (found.high - found.low) / 2.0;
    assert!((found.mean - mean).abs() < 1e-12);
    assert!((half / deviation - 1.0).abs() < 0.03, "{half} {deviation}");
}

#[test]
fn links_taken_for_independent_would_look_far_too_certain() {
    let (clusters, values) = links();
    let independent: Vec<(u32, u32)> = (0..values.len() as u32).map(|t| (0, t)).collect();
    let wide = estimate(Bootstrap::default(), &clusters, &values);
    let narrow = estimate(Bootstrap::default(), &independent, &values);
    assert!(wide.high - wide.low > 2.0 * (narrow.high - narrow.low));
}

#[test]
fn a_single_transmitter_has_no_spread() {
    let found = estimate(Bootstrap::default(), &[(3, 7); 4], &[1.0, 2.0, 3.0, 6.0]);
    assert_eq!((found.low, found.mean, found.high), (3.0, 3.0, 3.0));
}

#[test]
fn no_replicates_leave_the_mean_alone() {
    let found = estimate(with_replicates(0), &[(0, 0), (1, 0)], &[1.0, 2.0]);
    assert_eq!((found.low, found.mean, found.high), (1.5, 1.5, 1.5));
}

#[test]
fn no_samples_have_no_mean() {
    assert_eq!(Bootstrap::default().draw(&[]).unwrap().mean(&[]), Ok(None));
}

#[test]
fn values_that_do_not_fit_are_refused() {
    let resamples = Bootstrap::default().draw(&[(0, 0), (0, 1)]).unwrap();
    let few = Error::ValuesOfSamples {
        values: 1,
        samples: 2,
    };
    assert_eq!(resamples.mean(&[1.0]), Err(few));
    let (index, limit) = (1, 1e160);
    let bad = Error::NotFinite { index, limit };
    for value in [f64::NAN, f64::INFINITY, -1.1e160] {
        assert_eq!(resamples.mean(&[1.0, value]), Err(bad));
    }
    assert!(bad.to_string().ends_with("beyond 1e160"), "{bad}");
}

#[test]
fn settings_that_make_no_interval_are_refused() {
    let draw = |replicates, level| {
        let bootstrap = Bootstrap {
            replicates,
            level,
            ..Bootstrap::default()
        };
        bootstrap.draw(&[(0, 0), (1, 0)]).map(|_| ())
    };
    assert_eq!([0.0, 1.0].map(|level| draw(1, level)), [Ok(()); 2]);
    for level in [-0.1, 1.1] {
        assert_eq!(draw(1, level), Err(Error::Level(level)));
    }
    assert!(matches!(draw(1, f64::NAN), Err(Error::Level(_))));
    for replicates in [usize::MAX, usize::MAX / 2] {
        let clusters = 2;
        let too_many = Error::Replicates {
            replicates,
            clusters,
        };
        assert_eq!(draw(replicates, 0.95), Err(too_many));
    }
}

/// Clusters with values.
fn samples() -> impl Strategy<Value = Vec<((u32, u32), f64)>> {
    prop::collection::vec(((0..4_u32, 0..4_u32), -10.0..10.0_f64), 1..40)
}

proptest! {
    #[test]
    fn ends_move_with_the_values(list in samples(), scale in 0.1..5.0_f64, shift in -9.0..9.0_f64) {
        let (clusters, values): (Vec<_>, Vec<_>) = list.into_iter().unzip();
        let resamples = with_replicates(200).draw(&clusters).unwrap();
        let plain = resamples.mean(&values).unwrap().unwrap();
        let moved: Vec<f64> = values.iter().map(|v| scale * v + shift).collect();
        let moved = resamples.mean(&moved).unwrap().unwrap();
        for (p, m) in [(plain.mean, moved.mean), (plain.low, moved.low), (plain.high, moved.high)] {
            prop_assert!((scale * p + shift - m).abs() < 1e-10, "{plain:?} {moved:?}");
        }
    }

    #[test]
    fn order_of_links_and_names_of_clusters_do_not_matter(list in samples()) {
        let of = |list: &[((u32, u32), f64)], far: u32| {
            let clusters: Vec<_> = list.iter().map(|&((m, t), _)| (m + far, t + far)).collect();
            let values: Vec<_> = list.iter().map(|s| s.1).collect();
            estimate(with_replicates(200), &clusters, &values)
        };
        let mut turned = list.clone();
        turned.reverse();
        let (a, b) = (of(&list, 0), of(&turned, 1000));
        for (a, b) in [(a.mean, b.mean), (a.low, b.low), (a.high, b.high)] {
            prop_assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn threads_do_not_matter(list in samples()) {
        let (clusters, values): (Vec<_>, Vec<_>) = list.into_iter().unzip();
        let of = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| estimate(with_replicates(100), &clusters, &values))
        };
        prop_assert_eq!(of(1), of(5));
    }
}
