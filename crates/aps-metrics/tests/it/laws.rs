//! Laws that hold for all spectra.

use aps_metrics::{
    Definition, Evaluation, Metric, Peak, PeakFinder, Protocol, Scorer, Spectra, Topology,
};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::common::{range, score, spectrum_peaks};

const BINS: usize = 36;

fn protocol() -> impl Strategy<Value = Protocol> {
    prop::sample::select(&Protocol::ALL[..])
}

/// Few levels: ties, plateaus, constants and negative spectra are likely.
fn coarse(bins: impl Into<proptest::collection::SizeRange>) -> impl Strategy<Value = Vec<f64>> {
    (vec(-2_i8..4, bins), -3_i8..3)
        .prop_map(|(values, shift)| values.iter().map(|&v| f64::from(v + shift)).collect())
}

/// Values in general position: no two alike, not even by reflection or rotation.
fn generic() -> impl Strategy<Value = Vec<f64>> {
    vec(0.0..1.0, BINS).prop_map(|noise| {
        let value = |(bin, noise): (usize, f64)| (noise * 64.0).floor() + bin as f64 / 100.0;
        noise.into_iter().enumerate().map(value).collect()
    })
}

fn spectrum() -> impl Strategy<Value = Vec<f64>> {
    prop_oneof![coarse(BINS), generic(), vec(-1e3..1e3, BINS)]
}

/// Anything a spectrum may hold, from subnormal to the largest magnitude.
fn extreme() -> impl Strategy<Value = Vec<f64>> {
    let limit = aps_metrics::MAX_MAGNITUDE;
    let value = prop_oneof![
        Just(0.0),
        Just(-0.0),
        Just(5e-324),
        Just(-1e-8),
        Just(limit),
        Just(-limit),
        -1.0..1.0,
        any::<f64>().prop_filter("in range", move |v| v.abs() <= limit),
    ];
    vec(value, 1..12)
}

/// Values with NaN and infinities, which only the peak finder accepts.
fn wild() -> impl Strategy<Value = Vec<f64>> {
    let value = prop_oneof![
        12 => (-2_i8..5).prop_map(f64::from),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(f64::NEG_INFINITY),
    ];
    vec(value, 0..24)
}

/// Peaks and their prominence by walking, literally as defined.
pub(crate) fn peaks_by_walking(values: &[f64], topology: Topology) -> Vec<(Peak, f64)> {
    let count = values.len() as isize;
    let at = |bin: isize| match topology {
        Topology::Ring => Some(values[bin.rem_euclid(count) as usize]),
        Topology::Line => values.get(usize::try_from(bin).ok()?).copied(),
    };
    let base = |from: isize, step: isize| {
        let height = values[from as usize];
        (0..count)
            .map_while(|steps| at(from + steps * step).filter(|&v| v <= height))
            .fold(f64::INFINITY, f64::min)
    };
    let mut peaks = Vec::new();
    for left in 0..count {
        let height = values[left as usize];
        let run = (0..count)
            .take_while(|&steps| at(left + steps) == Some(height))
            .count();
        let below = |bin| at(bin).is_some_and(|v| v < height);
        if below(left - 1) && below(left + run as isize) {
            let bin = (left + (run as isize - 1) / 2).rem_euclid(count);
            let prominence = height - base(bin, -1).max(base(bin, 1));
            let bin = bin as usize;
            peaks.push((Peak { bin, height }, prominence));
        }
    }
    peaks.sort_by_key(|(peak, _)| peak.bin);
    peaks
}

fn rotated(spectrum: &[f64], steps: usize) -> Vec<f64> {
    let mut turned = spectrum.to_vec();
    turned.rotate_right(steps);
    turned
}

/// The spectrum in which each direction has changed places with its mirror twin.
fn mirrored(spectrum: &[f64]) -> Vec<f64> {
    (0..BINS)
        .map(|bin| spectrum[(BINS / 2 + BINS - bin) % BINS])
        .collect()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * (1.0 + a.abs())
}

proptest! {
    #[test]
    fn one_pass_finds_what_walking_finds(
        values in prop_oneof![wild(), spectrum()],
        min_prominence in prop_oneof![Just(0.0), 0.5..3.0],
    ) {
        for topology in [Topology::Line, Topology::Ring] {
            let mut expected = peaks_by_walking(&values, topology);
            expected.retain(|&(_, prominence)| prominence >= min_prominence);
            let expected: Vec<Peak> = expected.into_iter().map(|(peak, _)| peak).collect();
            let mut finder = PeakFinder::default();
            prop_assert_eq!(finder.find(&values, topology, min_prominence), expected);
        }
    }

    #[test]
    fn identical_spectra_score_perfectly(protocol in protocol(), truth in spectrum()) {
        let scores = score(protocol, &truth, &truth);
        let constant_zero = truth.iter().all(|&v| v == 0.0);
        prop_assert_eq!((scores.mae, scores.mse, scores.nmse), (0.0, 0.0, 0.0));
        prop_assert_eq!(scores.cosine, if constant_zero { 0.0 } else { 1.0 });
        prop_assert_eq!((scores.ple_deg, scores.mirror_ple_deg), (0.0, 0.0));
        prop_assert_eq!(scores.recall, [1.0, 1.0]);
        prop_assert_eq!(scores.hit(0.0), scores.truth_peaks > 0);
        prop_assert_eq!(scores.mirror_hit(0.0), scores.truth_peaks > 0);
    }

    #[test]
    fn every_metric_is_finite_and_in_its_range(
        protocol in protocol(),
        (truth, prediction) in extreme().prop_flat_map(|truth| {
            let bins = truth.len();
            (Just(truth), vec(prop_oneof![Just(0.0), -1e70..1e70, -1.0..1.0], bins))
        }),
    ) {
        let scores = score(protocol, &truth, &prediction);
        for metric in Metric::ALL {
            prop_assert!(metric.of(&scores, range(1.0)).is_finite(), "{:?}: {:?}", metric, scores);
        }
        prop_assert!((-1.0..=1.0).contains(&scores.cosine));
        prop_assert!((0.0..=180.0).contains(&scores.spectral_angle_deg()));
        prop_assert!((0.0..=180.0).contains(&scores.ple_deg));
        for recall in scores.recall {
            prop_assert!((0.0..=1.0).contains(&recall));
        }
    }

    #[test]
    fn a_wider_tolerance_never_hurts(
        protocol in protocol(),
        truth in spectrum(),
        prediction in spectrum(),
    ) {
        let scores = score(protocol, &truth, &prediction);
        prop_assert!(scores.hit(2.0) <= scores.hit(4.0));
        prop_assert!(scores.mirror_hit(2.0) <= scores.mirror_hit(4.0));
        prop_assert!(scores.recall[0] <= scores.recall[1]);
    }

    #[test]
    fn accepting_the_twin_never_hurts(
        protocol in protocol(),
        truth in spectrum(),
        prediction in spectrum(),
    ) {
        let scores = score(protocol, &truth, &prediction);
        prop_assert!(scores.mirror_ple_deg <= scores.ple_deg);
        prop_assert!(scores.mirror_top_error_deg <= scores.top_error_deg);
    }

    #[test]
    fn swapped_twins_are_perfect_to_the_mirror_metrics(truth in generic()) {
        let scores = score(Protocol::Paper, &truth, &mirrored(&truth));
        prop_assert_eq!(scores.mirror_ple_deg, 0.0);
        prop_assert_eq!(scores.mirror_top_error_deg, Some(0.0));
    }

    #[test]
    fn paper_metrics_do_not_know_where_zero_is(
        truth in generic(),
        prediction in generic(),
        steps in 0..BINS,
    ) {
        let scores = score(Protocol::Paper, &truth, &prediction);
        let turned = score(Protocol::Paper, &rotated(&truth, steps), &rotated(&prediction, steps));
        // Only the axis of the mirror is tied to a direction.
        prop_assert_eq!(scores.ple_deg, turned.ple_deg);
        prop_assert_eq!(scores.top_error_deg, turned.top_error_deg);
        prop_assert_eq!(scores.recall, turned.recall);
        prop_assert!(near(scores.mae, turned.mae));
        prop_assert!(near(scores.mse, turned.mse));
        prop_assert!(near(scores.nmse, turned.nmse));
        prop_assert!(near(scores.cosine, turned.cosine));
    }

    #[test]
    fn cosine_does_not_know_the_scale(
        protocol in protocol(),
        truth in generic(),
        prediction in spectrum(),
        scale in 1e-3..1e3,
    ) {
        prop_assume!(prediction.iter().any(|v| v.abs() > 1e-3));
        let scaled: Vec<f64> = prediction.iter().map(|v| v * scale).collect();
        let cosine = score(protocol, &truth, &prediction).cosine;
        prop_assert!(near(cosine, score(protocol, &truth, &scaled).cosine));
    }

    #[test]
    fn dominant_peaks_are_peaks_and_never_missing(protocol in protocol(), values in spectrum()) {
        let peaks = spectrum_peaks(&values, protocol);
        prop_assert_eq!(peaks.all().is_empty(), peaks.dominant().is_empty());
        prop_assert!(peaks.dominant().iter().all(|peak| peaks.all().contains(peak)));
        prop_assert_eq!(peaks.strongest().is_some(), !peaks.all().is_empty());
    }

    #[test]
    fn any_cut_and_any_number_of_threads_give_the_same(
        values in vec(prop_oneof![20 => -4.0..4.0, 1 => Just(f64::NAN)], 20 * 9),
        cut in 0_usize..=20,
        threads in 1_usize..4,
    ) {
        let bins = 9;
        let prediction: Vec<f64> = values.iter().map(|v| 0.5 - v).collect();
        let maps: Vec<u32> = (0..20).map(|sample| sample / 7).collect();
        let scored = |chunks: &[std::ops::Range<usize>]| {
            let row = |values| Spectra::new(values, bins).expect("whole rows");
            let mut evaluation = Evaluation::new(Protocol::Paper);
            for samples in chunks {
                let flat = samples.start * bins..samples.end * bins;
                let ids = &maps[samples.clone()];
                evaluation
                    .push(row(&values[flat.clone()]), row(&prediction[flat]), Some(ids))
                    .expect("equal shapes");
            }
            evaluation
        };
        let all = 0..20;
        let all = std::slice::from_ref(&all);
        let whole = scored(all);
        prop_assert_eq!(&scored(&[0..cut, cut..20]), &whole);

        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        prop_assert_eq!(pool.install(|| scored(all).report(range(2.0))), whole.report(range(2.0)));
    }

    #[test]
    fn changing_one_choice_of_a_definition_is_scored(
        truth in generic(),
        prediction in generic(),
    ) {
        // Circular distances are never longer than plain ones counted in the same unit.
        let plain = Protocol::Released.definition();
        let ring = Definition { distance: Topology::Ring, ..plain };
        let score = |definition| {
            Scorer::new(definition).score(&truth, &prediction).expect("finite")
        };
        prop_assert!(score(ring).ple_deg <= score(plain).ple_deg);
        prop_assert!(score(ring).recall >= score(plain).recall);
    }
}
