//! Local maxima and their prominence, on a line and on a ring.
//!
//! # Definition of a peak
//!
//! On a **line** ([`Topology::Line`]) the definition is that of `scipy.signal.find_peaks` (SciPy
//! 1.17): a peak is a run of one or more equal values whose two neighbouring values are both
//! smaller. The first and the last value have only one neighbour and never belong to a peak. A
//! run from bin `l` to bin `r` counts once, at bin `(l + r) / 2` rounded down.
//!
//! On a **ring** ([`Topology::Ring`]) the first value is the right neighbour of the last, so there
//! are no ends. A run may cross the seam; it counts at the bin `(length - 1) / 2` steps, rounded
//! down, after its first bin in the direction of rising index. A ring of equal values has no peak.
//!
//! # Prominence
//!
//! From the peak walk to each side as long as the values do not exceed the peak's height; on a
//! line a walk also ends where the line does, on a ring it goes round at most once. The base of a
//! side is the smallest value met. The prominence is the height minus the higher of the two bases.
//! A value equal to the height does not stop a walk. On a ring the highest peaks, which nothing
//! stops, have prominence maximum - minimum.
//!
//! # NaN and infinity
//!
//! As in SciPy, every comparison with NaN is false: NaN is no peak, a value next to NaN is none,
//! and a walk stops before NaN. Infinite values are ordered like any other.

use crate::pointwise::minimum;

/// Arrangement of the bins: on a line with two ends or on a ring without ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Topology {
    /// First and last bin are ends, as far from each other as bins can be.
    Line,
    /// First and last bin are neighbours.
    Ring,
}

/// One peak.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Peak {
    /// Bin of the maximum; the middle of a plateau.
    pub bin: usize,
    /// Value at `bin`, in the unit of the searched values.
    pub height: f64,
}

/// Finds peaks in any number of spectra without allocating for each.
///
/// ```
/// use aps_metrics::{PeakFinder, Topology};
///
/// let mut finder = PeakFinder::default();
/// let spectrum = [9.0, 1.0, 4.0, 4.0, 3.0, 5.0, 0.0, 7.0];
///
/// let bins: Vec<_> = finder.find(&spectrum, Topology::Line, 0.0).iter().map(|p| p.bin).collect();
/// assert_eq!(bins, [2, 5]); // The plateau counts once, the ends never.
///
/// let bins: Vec<_> = finder.find(&spectrum, Topology::Ring, 0.0).iter().map(|p| p.bin).collect();
/// assert_eq!(bins, [0, 2, 5]); // Bin 0 is higher than both of its neighbours, 7 and 1.
/// ```
#[derive(Debug, Clone, Default)]
pub struct PeakFinder {
    peaks: Vec<Peak>,
    ring: Vec<f64>,
}

impl PeakFinder {
    /// Returns the peaks of `values` with a prominence of at least `min_prominence` (same unit as
    /// `values`), in order of their bins. See the module's text for the definition.
    ///
    /// On a line these are the indices of `scipy.signal.find_peaks(values,
    /// prominence=min_prominence)`, exactly. O(n), where walking from each peak is O(n * peaks).
    pub fn find(&mut self, values: &[f64], topology: Topology, min_prominence: f64) -> &[Peak] {
        self.peaks.clear();
        match topology {
            Topology::Line => self.scan(values, min_prominence),
            Topology::Ring => self.scan_ring(values, min_prominence),
        }
        &self.peaks
    }

    /// Descends and climbs in steps of at least the prominence asked for.
    ///
    /// A peak has the prominence when the values fall by that much on both of its sides before
    /// they exceed it. So follow the lowest value until one lies that much above it, then the
    /// highest until one lies that much below: the highest, and all equal to it, are peaks with the
    /// prominence. There are no others, for one lower than the highest would need the same fall
    /// before it. Noise below the prominence moves neither extreme, so branches are predictable.
    fn scan(&mut self, values: &[f64], min_prominence: f64) {
        // Any two different numbers are at least the smallest positive one apart, so this asks
        // for high > low as well.
        let least = if min_prominence <= 0.0 {
            f64::from_bits(1)
        } else {
            min_prominence
        };
        let reaches = |high: f64, low: f64| high - low >= least;
        let mut bins = values.iter().copied().enumerate();
        // Peaks found so far; those beyond wait for the fall that confirms them.
        let mut confirmed = 0;
        let mut lowest = f64::INFINITY;
        'scan: loop {
            let (foot, mut highest) = loop {
                let Some((bin, value)) = bins.next() else {
                    break 'scan;
                };
                if value < lowest {
                    lowest = value;
                } else if reaches(value, lowest) {
                    break (bin, value);
                } else if value.is_nan() {
                    lowest = f64::INFINITY;
                }
            };
            // First bin of the run of highest values, while it lasts.
            let mut run = Some(foot);
            loop {
                let Some((bin, value)) = bins.next() else {
                    break 'scan;
                };
                if value < highest {
                    if let Some(first) = run.take() {
                        self.peaks.push(Peak {
                            bin: (first + bin - 1) / 2,
                            height: highest,
                        });
                    }
                    if reaches(highest, value) {
                        confirmed = self.peaks.len();
                        lowest = value;
                        break;
                    }
                } else if value > highest {
                    (highest, run) = (value, Some(bin));
                    self.peaks.truncate(confirmed);
                } else if value == highest {
                    run = run.or(Some(bin));
                } else {
                    // NaN: nothing confirms these peaks, and the next descent starts anew.
                    self.peaks.truncate(confirmed);
                    lowest = f64::INFINITY;
                    break;
                }
            }
        }
        self.peaks.truncate(confirmed);
    }

    /// Cuts the ring open at its lowest value, which no walk that gets there can go below, and
    /// scans it as a line with this value at both ends.
    fn scan_ring(&mut self, values: &[f64], min_prominence: f64) {
        let lowest = minimum(values);
        let Some(cut) = values.iter().position(|&v| v == lowest) else {
            return;
        };
        let mut ring = std::mem::take(&mut self.ring);
        ring.clear();
        ring.extend_from_slice(&values[cut..]);
        ring.extend_from_slice(&values[..=cut]);
        self.scan(&ring, min_prominence);
        self.ring = ring;

        // Back to the order of the bins: those past the seam come first.
        let before_seam = self
            .peaks
            .partition_point(|peak| peak.bin < values.len() - cut);
        self.peaks.rotate_left(before_seam);
        for peak in &mut self.peaks {
            peak.bin = (peak.bin + cut) % values.len();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peaks and their prominence: each is found for up to its prominence, and for no more.
    fn check(values: &[f64], topology: Topology, expected: &[(usize, f64)]) {
        let mut finder = PeakFinder::default();
        let ends = expected.iter().flat_map(|&(_, p)| [p, p.next_up()]);
        for least in [0.0].into_iter().chain(ends) {
            let peaks = finder.find(values, topology, least).iter();
            let found: Vec<usize> = peaks.map(|peak| peak.bin).collect();
            let enough = expected.iter().filter(|(_, p)| *p >= least);
            let enough: Vec<usize> = enough.map(|&(bin, _)| bin).collect();
            assert_eq!(found, enough, "{topology:?} {values:?} from {least}");
        }
    }

    const NAN: f64 = f64::NAN;
    const INF: f64 = f64::INFINITY;

    #[test]
    fn nothing_to_find() {
        for values in [
            &[][..],
            &[1.0],
            &[1.0, 1.0],
            &[2.0; 7],
            &[INF; 3],
            &[NAN],
            &[NAN, NAN],
        ] {
            check(values, Topology::Line, &[]);
            check(values, Topology::Ring, &[]);
        }
    }

    #[test]
    fn ends_and_ramps() {
        check(&[1.0, 2.0], Topology::Line, &[]);
        check(&[1.0, 2.0, 3.0], Topology::Line, &[]);
        check(&[3.0, 2.0, 2.0, 3.0], Topology::Line, &[]);
        check(&[1.0, 2.0], Topology::Ring, &[(1, 1.0)]);
        check(&[1.0, 2.0, 3.0], Topology::Ring, &[(2, 2.0)]);
        check(&[3.0, 2.0, 2.0, 3.0], Topology::Ring, &[(3, 1.0)]);
    }

    #[test]
    fn even_plateau_counts_left_of_its_middle() {
        check(&[0.0, 5.0, 5.0, 5.0, 5.0, 1.0], Topology::Line, &[(2, 4.0)]);
        check(&[0.0, 5.0, 5.0, 5.0, 5.0, 1.0], Topology::Ring, &[(2, 5.0)]);
    }

    #[test]
    fn plateau_across_the_seam() {
        check(&[5.0, 5.0, 1.0, 0.0, 5.0], Topology::Ring, &[(0, 5.0)]);
        check(&[5.0, 1.0, 0.0, 5.0, 5.0, 5.0], Topology::Ring, &[(4, 5.0)]);
    }

    #[test]
    fn equal_peaks_do_not_stop_the_walk() {
        check(
            &[0.0, 3.0, 2.0, 3.0, 1.0],
            Topology::Line,
            &[(1, 2.0), (3, 2.0)],
        );
        let values = [2.0, 3.0, 1.0, 3.0, 0.0, 4.0, 0.0];
        check(&values, Topology::Line, &[(1, 1.0), (3, 2.0), (5, 4.0)]);
        let values = [0.0, 3.0, 2.0, 3.0, 1.0, 2.0];
        check(&values, Topology::Ring, &[(1, 3.0), (3, 3.0), (5, 1.0)]);
    }

    #[test]
    fn nan_is_a_barrier() {
        check(&[0.0, 2.0, NAN, 2.0, 0.0], Topology::Line, &[]);
        let values = [0.0, 2.0, 1.0, NAN, 9.0, 1.0, 3.0, 2.0];
        check(&values, Topology::Line, &[(1, 1.0), (6, 1.0)]);
        check(&[1.0, 2.0, 1.5, NAN, 0.0], Topology::Ring, &[(1, 0.5)]);
    }

    #[test]
    fn infinities_are_ordered() {
        check(&[0.0, INF, 1.0], Topology::Line, &[(1, INF)]);
        check(&[-INF, 1.0, -INF], Topology::Line, &[(1, INF)]);
    }
}
