//! Folds over the bins of a spectrum, in lanes that become vector instructions.

/// Number of partial results. Fixed, so that sums do not depend on the machine's vectors; not
/// more, so that all partial sums fit the 16 registers every x86-64 has.
const LANES: usize = 4;

/// Sums over the bins of one sample.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    /// |truth - prediction|
    pub absolute_error: f64,
    /// (truth - prediction)^2
    pub squared_error: f64,
    /// truth^2
    pub truth_power: f64,
    /// prediction^2
    pub prediction_power: f64,
    /// truth * prediction
    pub product: f64,
}

impl Sums {
    /// Sums of two spectra of equal length, always in the same order.
    pub fn of(truth: &[f64], prediction: &[f64]) -> Self {
        let mut lanes = [[0.0; LANES]; 5];
        let (truth, truth_rest) = truth.as_chunks::<LANES>();
        let (prediction, prediction_rest) = prediction.as_chunks::<LANES>();
        for (t, p) in truth.iter().zip(prediction) {
            for lane in 0..LANES {
                add(&mut lanes, lane, t[lane], p[lane]);
            }
        }
        for (lane, (&t, &p)) in truth_rest.iter().zip(prediction_rest).enumerate() {
            add(&mut lanes, lane, t, p);
        }
        let [absolute, squared, truth, prediction, product] =
            lanes.map(|partial| partial.iter().sum());
        Self {
            absolute_error: absolute,
            squared_error: squared,
            truth_power: truth,
            prediction_power: prediction,
            product,
        }
    }
}

#[inline(always)]
fn add(lanes: &mut [[f64; LANES]; 5], lane: usize, truth: f64, prediction: f64) {
    let error = truth - prediction;
    lanes[0][lane] += error.abs();
    lanes[1][lane] += error * error;
    lanes[2][lane] += truth * truth;
    lanes[3][lane] += prediction * prediction;
    lanes[4][lane] += truth * prediction;
}

/// The largest of `values` that are not NaN; negative infinity if there are none.
pub(crate) fn maximum(values: &[f64]) -> f64 {
    fold(
        values,
        f64::NEG_INFINITY,
        |best, v| if v > best { v } else { best },
    )
}

/// The smallest of `values` that are not NaN; infinity if there are none.
pub(crate) fn minimum(values: &[f64]) -> f64 {
    fold(
        values,
        f64::INFINITY,
        |best, v| if v < best { v } else { best },
    )
}

/// Folds with a function for which order does not matter.
#[inline(always)]
fn fold(values: &[f64], start: f64, better: impl Fn(f64, f64) -> f64) -> f64 {
    let mut lanes = [start; LANES];
    let (chunks, rest) = values.as_chunks::<LANES>();
    for chunk in chunks {
        for lane in 0..LANES {
            lanes[lane] = better(lanes[lane], chunk[lane]);
        }
    }
    lanes
        .iter()
        .chain(rest)
        .fold(start, |best, &v| better(best, v))
}
