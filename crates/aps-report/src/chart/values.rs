//! Values made ready for a chart: histograms, the Pareto front.

/// Counts of values in bins.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Ends of the bins, ascending; one more than there are bins.
    pub edges: Vec<f64>,
    /// Number of values in each bin, its upper end excluded.
    pub counts: Vec<u64>,
    /// Number of values outside of all bins, or not finite.
    pub outside: u64,
}

impl Histogram {
    /// Equal bins from `first` to `last`; a value at `last` falls into the last one.
    ///
    /// # Panics
    /// If there are no bins or `first` is not below `last`.
    pub fn of(values: impl Iterator<Item = f64>, first: f64, last: f64, bins: usize) -> Self {
        assert!(bins > 0 && first < last, "no bins from {first} to {last}");
        let width = (last - first) / bins as f64;
        let mut counts = vec![0; bins];
        let mut outside = 0;
        for value in values {
            if value >= first && value <= last {
                counts[(((value - first) / width) as usize).min(bins - 1)] += 1;
            } else {
                outside += 1;
            }
        }
        Self {
            edges: (0..=bins).map(|i| first + width * i as f64).collect(),
            counts,
            outside,
        }
    }

    /// Some `bins` equal bins between round ends around all finite values.
    pub fn around(values: &[f64], bins: usize) -> Self {
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return Self::of(values.iter().copied(), 0.0, 1.0, 1);
        }
        let least = ((high - low) / bins.max(1) as f64)
            .max(1e-12 * high.abs())
            .max(1e-300);
        let power = 10_f64.powf(least.log10().floor());
        let mut widths = [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * power).into_iter();
        let width = widths.find(|&w| w >= least).unwrap_or(10.0 * power);
        let first = (low / width).floor();
        let last = ((high / width).floor() + 1.0).max(first + 1.0);
        let (bins, values) = ((last - first) as usize, values.iter().copied());
        Self::of(values, first * width, last * width, bins)
    }

    /// One bin a whole number, centred on it, from 0 or the smallest to the largest.
    pub fn counts(values: impl Iterator<Item = u64> + Clone) -> Self {
        let last = values.clone().max().unwrap_or(0);
        let first = values.clone().min().unwrap_or(0).min(1);
        let (from, to) = (first as f64 - 0.5, last as f64 + 0.5);
        let bins = (last - first + 1) as usize;
        Self::of(values.map(|v| v as f64), from, to, bins)
    }

    /// Height of each bin in percent of all values, those outside included.
    pub fn percent(&self) -> Vec<f64> {
        let all = (self.counts.iter().sum::<u64>() + self.outside).max(1) as f64;
        let counts = self.counts.iter();
        counts.map(|&n| 100.0 * n as f64 / all).collect()
    }
}

/// The places of the points that no other beats in both coordinates, smaller being better, by ascending x: a line through
/// them is the Pareto front. A point that is not finite is left out, as is one better than the last by less than the part
/// `least_gain` of it (0: any gain counts).
pub fn pareto_front(points: &[[f64; 2]], least_gain: f64) -> Vec<usize> {
    let finite = |&i: &usize| points[i].iter().all(|v| v.is_finite());
    let mut front: Vec<usize> = (0..points.len()).filter(finite).collect();
    let order = |&i: &usize, &j: &usize| {
        let (p, q) = (points[i], points[j]);
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1]))
    };
    front.sort_by(order);
    let mut best = f64::INFINITY;
    front.retain(|&i| {
        let is_better = points[i][1] < best - least_gain * best.abs().min(f64::MAX);
        if is_better {
            best = points[i][1];
        }
        is_better
    });
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_once() {
        let values = [0.0, 0.5, 1.0, 1.5, 2.0, 2.1, f64::NAN];
        let h = Histogram::of(values.into_iter(), 0.0, 2.0, 2);
        assert_eq!((&*h.counts, h.outside), (&[2, 3][..], 2));
        let h = Histogram::around(&values, 10);
        assert_eq!((h.counts.iter().sum::<u64>(), h.outside), (6, 1));
        let equal = Histogram::around(&[7.0; 3], 10);
        assert_eq!(equal.counts.iter().sum::<u64>(), 3);
        assert_eq!(Histogram::around(&[], 10).counts, [0]);
    }

    #[test]
    fn whole_numbers_have_a_bin_each() {
        let h = Histogram::counts([2, 4, 4].into_iter());
        assert_eq!(h.counts, [0, 1, 0, 2]);
        assert_eq!(h.edges, [0.5, 1.5, 2.5, 3.5, 4.5]);
    }

    #[test]
    fn front_holds_what_nothing_beats() {
        let points = [
            [3.0, 1.0],
            [1.0, 3.0],
            [2.0, 4.0],
            [2.0, 2.0],
            [f64::NAN, 0.0],
            [3.0, 2.0],
        ];
        assert_eq!(pareto_front(&points, 0.0), [1, 3, 0]);
        assert_eq!(pareto_front(&points, 0.4), [1, 0]);
        // Larger is better in the second, negated: negative values have a front too.
        let scores = [[1.0, -0.5], [2.0, -0.5], [3.0, -0.9]];
        assert_eq!(pareto_front(&scores, 0.0), [0, 2]);
    }
}
