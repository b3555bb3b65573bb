//! Input that is empty, constant, negative, not finite or of the wrong shape; names of none.

use aps_metrics::{
    DataRange, Defect, Error, Evaluation, LevelDistance, Metric, PeakCensus, Protocol, Scorer,
    Side, Spectra, spectrum_peaks,
};

use crate::common::{dominant_bins, peak_bins, range, score};

fn push(truth: &[f32], prediction: &[f32], bins: usize) -> Result<Evaluation, Error> {
    let mut evaluation = Evaluation::new(Protocol::Paper);
    let truth = Spectra::new(truth, bins)?;
    evaluation.push(truth, Spectra::new(prediction, bins)?, None)?;
    Ok(evaluation)
}

#[test]
fn wrong_shapes_are_named() {
    let mut evaluation = Evaluation::new(Protocol::Released);
    let values = [0.0; 12];
    let truth = Spectra::new(&values, 6).expect("two rows");
    let prediction = Spectra::new(&values, 4).expect("three rows");
    let error = evaluation
        .push(truth, prediction, None)
        .expect_err("shapes differ");
    let text = error.to_string();
    assert!(text.contains("(2, 6)") && text.contains("(3, 4)"), "{text}");
    assert_eq!(evaluation.samples(), 0);

    let error = Scorer::new(Protocol::Paper)
        .score(&[1.0; 3], &[1.0; 4])
        .expect_err("lengths");
    assert!(error.to_string().contains("(1, 3)") && error.to_string().contains("(1, 4)"));
}

#[test]
fn empty_spectra_are_an_error() {
    assert_eq!(Spectra::<f32>::new(&[], 0).err(), Some(Error::NoBins));
    let scores = Scorer::new(Protocol::Paper).score::<f64, f64>(&[], &[]);
    assert_eq!(scores, Err(Error::NoBins));
    let peaks = spectrum_peaks::<f64>(&[], &Protocol::Paper.definition());
    assert_eq!(peaks, Err(Error::NoBins));
}

#[test]
fn incomplete_rows_are_an_error() {
    let error = Error::IncompleteRow { values: 7, bins: 3 };
    assert_eq!(Spectra::new(&[0.0_f32; 7], 3).err(), Some(error));
}

#[test]
fn no_samples_have_an_empty_report() {
    let evaluation = push(&[], &[], 180).expect("no rows are fine");
    assert_eq!(evaluation.truth_range(), None);
    let report = evaluation.report(range(1.0));
    assert_eq!(report.overall.samples, 0);
    assert_eq!(report.overall.get(Metric::Mae), None);
    assert!(report.maps.is_empty());
}

#[test]
fn chunks_must_agree() {
    let mut evaluation = push(&[0.0; 4], &[0.0; 4], 4).expect("one row");
    let five = Spectra::new(&[0.0_f32; 5], 5).expect("one row");
    let error = Error::BinsChanged {
        expected: 4,
        found: 5,
    };
    assert_eq!(evaluation.push(five, five, None), Err(error));
    let four = Spectra::new(&[0.0_f32; 4], 4).expect("one row");
    let error = Error::MapIds { ids: 2, samples: 1 };
    assert_eq!(evaluation.push(four, four, Some(&[1, 2])), Err(error));
    assert_eq!(evaluation.samples(), 1);
}

#[test]
fn values_that_are_not_finite_are_listed_and_in_no_mean() {
    let nan = f32::NAN;
    let truth = [1.0, 2.0, 1.0, 1.0, nan, 1.0, 1.0, 9.0, 1.0];
    let prediction = [1.0, 2.0, 1.0, 1.0, nan, 1.0, 1.0, 2.0, f32::INFINITY];
    let evaluation = push(&truth, &prediction, 3).expect("three rows");
    assert_eq!(evaluation.samples(), 3);
    let defect = |side, bin| Defect { side, bin };
    let rejected = evaluation.rejected().iter();
    let rejected: Vec<_> = rejected.map(|r| (r.sample, r.defect)).collect();
    let expected = [
        (1, defect(Side::Truth, 1)),
        (2, defect(Side::Prediction, 2)),
    ];
    assert_eq!(rejected, expected);
    // The truth of a rejected prediction still counts for the range.
    let range = evaluation.truth_range().expect("two finite truths");
    assert_eq!(range.get(), 8.0);
    let report = evaluation.report(range);
    assert_eq!(
        (report.rejected_truths, report.rejected_predictions),
        (1, 1)
    );
    assert_eq!(report.overall.samples, 1);
    assert_eq!(report.overall.get(Metric::Mae).map(|d| d.mean), Some(0.0));

    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e70] {
        let error = Scorer::new(Protocol::Paper).score(&[0.0, 1.0], &[0.0, bad]);
        assert_eq!(error, Err(Error::Unscorable(defect(Side::Prediction, 1))));
        let peaks = spectrum_peaks(&[0.0, bad], &Protocol::Paper.definition());
        assert_eq!(
            peaks,
            Err(Error::NotFinite {
                index: 1,
                limit: 1e70
            })
        );
    }
}

#[test]
fn a_range_must_be_positive_and_finite() {
    for bad in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(matches!(DataRange::new(bad), Err(Error::DataRange(_))));
    }
    let constant = push(&[3.0; 2], &[3.0; 2], 2).expect("one row");
    assert_eq!(constant.truth_range().map(DataRange::get), Some(1e-6));
}

#[test]
fn constant_spectra_have_no_peaks() {
    let peaky = [0.0, 5.0, 0.0, 0.0];
    for protocol in Protocol::ALL {
        for constant in [[0.0; 4], [2.0; 4], [-2.0; 4]] {
            // Nothing to find, nothing missed; but no strongest peak to hit either.
            let scores = score(protocol, &constant, &peaky);
            assert_eq!(
                (scores.ple_deg, scores.recall, scores.hit(180.0)),
                (0.0, [1.0; 2], false)
            );
            let scores = score(protocol, &peaky, &constant);
            assert_eq!(
                (scores.ple_deg, scores.recall, scores.hit(180.0)),
                (180.0, [0.0; 2], false)
            );
            assert_eq!(score(protocol, &constant, &constant).ple_deg, 0.0);
        }
        // Two zero vectors have no direction: the cosine is 0, as PyTorch's floor makes it.
        let zero = score(protocol, &[0.0; 4], &[0.0; 4]);
        assert_eq!((zero.mae, zero.cosine, zero.nmse_db()), (0.0, 0.0, -120.0));
    }
}

#[test]
fn one_bin_has_no_peaks() {
    for protocol in Protocol::ALL {
        let scores = score(protocol, &[2.0], &[1.0]);
        assert_eq!((scores.mae, scores.cosine), (1.0, 1.0));
        assert_eq!(
            (scores.ple_deg, scores.top_error_deg, scores.truth_peaks),
            (0.0, None, 0)
        );
    }
}

#[test]
fn negative_spectra_follow_the_protocol() {
    // Highest at bin 1, lowest at bin 3.
    let negative = [-4.0, -1.0, -4.0, -8.0, -4.0];
    // There is no positive maximum to scale by.
    assert_eq!(peak_bins(&negative, Protocol::Paper), []);
    // Division by a negative maximum turns the spectrum upside down.
    assert_eq!(peak_bins(&negative, Protocol::Released), [3]);
    // Its divisor, max + 1e-8, is 0 here.
    assert_eq!(peak_bins(&[-1.0, -1e-8, -1.0], Protocol::Released), []);
}

#[test]
fn a_peak_at_the_end_exists_on_the_ring_only() {
    let mut end = [0.0; 180];
    end[179] = 1.0;
    let mut start = [0.0; 180];
    start[0] = 1.0;
    let paper = score(Protocol::Paper, &end, &start);
    assert_eq!((paper.ple_deg, paper.top_error_deg), (2.0, Some(2.0)));
    assert!(paper.hit(2.0) && !paper.hit(1.9));
    let released = score(Protocol::Released, &end, &start);
    assert_eq!(
        (released.ple_deg, released.recall, released.truth_peaks),
        (0.0, [1.0; 2], 0)
    );
}

#[test]
fn ten_equal_peaks_are_each_just_below_a_tenth() {
    // 1 / (10 + 1e-8) < 0.1, so none is dominant and the first highest is kept.
    let comb: Vec<f64> = (0..20).map(|bin| f64::from(bin % 2)).collect();
    assert_eq!(peak_bins(&comb, Protocol::Paper).len(), 10);
    assert_eq!(dominant_bins(&comb, Protocol::Paper), [1]);
}

#[test]
fn a_peak_of_exactly_the_least_prominence_counts() {
    // 1 / 20 rounds to the threshold 0.05 itself. The released code divides by 20 + 1e-8.
    let peaks = |values: &[f64], protocol| peak_bins(values, protocol).len();
    assert_eq!(peaks(&[0.0, 20.0, 0.0, 1.0, 0.0], Protocol::Paper), 2);
    assert_eq!(peaks(&[0.0, 20.0, 0.0, 1.0, 0.0], Protocol::Released), 1);
    // So does 7 / 140, but not 7 * (1 / 140).
    assert_eq!(peaks(&[0.0, 140.0, 0.0, 7.0, 0.0], Protocol::Paper), 2);
}

#[test]
fn floors_of_the_logarithms() {
    let scores = score(Protocol::Released, &[0.0, 1.0, 0.0], &[0.0, 1.0, 0.0]);
    assert_eq!(scores.psnr_db(range(10.0)), 140.0);
    assert_eq!(scores.nmse_db(), -120.0);
}

#[test]
fn maps_are_told_apart() {
    let mut evaluation = Evaluation::new(Protocol::Paper);
    let truth = [0.0_f32; 4];
    let prediction = [1.0_f64, 1.0, 3.0, 3.0];
    let rows = Spectra::new(&truth, 1).expect("four rows");
    let predicted = Spectra::new(&prediction, 1).expect("four rows");
    evaluation
        .push(rows, predicted, Some(&[50, 46, 50, 50]))
        .expect("equal shapes");
    evaluation
        .push(rows, predicted, None)
        .expect("maps may be unknown");
    let report = evaluation.report(range(1.0));
    let ids = report.maps.iter().map(|m| (m.map_id, m.group.samples));
    assert_eq!(ids.collect::<Vec<_>>(), [(46, 1), (50, 3)]);
    assert_eq!(report.overall.samples, 8);

    let mut alone = Evaluation::new(Protocol::Paper);
    let rows = Spectra::new(&truth[..3], 1).expect("three rows");
    let predicted = Spectra::new(&[1.0, 3.0, 3.0], 1).expect("three rows");
    alone.push(rows, predicted, None).expect("equal shapes");
    assert_eq!(report.maps[1].group, alone.report(range(1.0)).overall);
}

#[test]
fn a_report_counts_peaks() {
    let none = [0.0; 6];
    let one = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    let three = [0.0, 1.0, 0.0, 1.0, 0.0, 1.0];
    let truth = [none, one, three, three].concat();
    let prediction = [one, none, none, three].concat();
    let mut evaluation = Evaluation::new(Protocol::Paper);
    let view = |values| Spectra::new(values, 6).expect("whole rows");
    evaluation
        .push(view(&truth), view(&prediction), None)
        .expect("equal shapes");
    let report = evaluation.report(range(1.0));
    let expected = PeakCensus {
        dominant_true_peaks: 7,
        at_most_two: 2,
        truths_without_peak: 1,
        predictions_without_peak: 2,
    };
    assert_eq!(report.overall.peaks, expected);
}

#[test]
fn a_stored_sample_takes_120_bytes() {
    assert_eq!(size_of::<aps_metrics::ScoredSample>(), 120);
}

#[test]
#[should_panic(expected = "bins of both")]
fn levels_of_other_bins_are_not_compared() {
    let _ = LevelDistance::of(&[0.0, -1.0], Some(&[0.0]));
}
