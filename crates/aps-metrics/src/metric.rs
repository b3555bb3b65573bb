//! The metrics by name, in the order tables list them.

use crate::protocol::TOLERANCES_DEG;
use crate::range::DataRange;
use crate::sample::SampleScores;

/// Metric of a prediction, one number a sample. [`SampleScores`] defines each.
///
/// ```
/// use aps_metrics::{Better, Metric};
///
/// let smaller_is_better = |m: &Metric| m.better() == Better::Lower;
/// assert!(smaller_is_better(&Metric::Mae) && !smaller_is_better(&Metric::Cosine));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Metric {
    /// Mean absolute error.
    Mae,
    /// Peak signal-to-noise ratio \[dB\].
    PsnrDb,
    /// Cosine similarity.
    Cosine,
    /// Mean squared error over the truth's mean square \[dB\].
    NmseDb,
    /// Spectral angle \[deg\].
    SpectralAngleDeg,
    /// Peak location error \[deg\].
    PleDeg,
    /// Hit within 2 deg: 1 if the strongest peaks are at most 2 deg apart, else 0.
    Hit2Deg,
    /// Hit within 4 deg: 1 if the strongest peaks are at most 4 deg apart, else 0.
    Hit4Deg,
    /// Share of the dominant true peaks found within 2 deg.
    Recall2Deg,
    /// Share of the dominant true peaks found within 4 deg.
    Recall4Deg,
    /// Mean squared error.
    Mse,
    /// Root mean squared error.
    Rmse,
    /// Mean squared error over the truth's mean square, linear.
    Nmse,
    /// Peak location error that accepts mirror twins \[deg\].
    MirrorPleDeg,
    /// [`Metric::Hit2Deg`] that accepts the mirror twin.
    MirrorHit2Deg,
    /// [`Metric::Hit4Deg`] that accepts the mirror twin.
    MirrorHit4Deg,
}

/// Direction in which a metric improves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// Smaller is better.
    Lower,
    /// Larger is better.
    Higher,
}

/// Each metric in the order of its variant, with key, heading, unit and direction.
const ABOUT: [(Metric, &str, &str, &str, Better); 16] = {
    use Better::{Higher, Lower};
    use Metric::*;
    [
        (Mae, "mae", "MAE", "", Lower),
        (PsnrDb, "psnr_db", "PSNR", "dB", Higher),
        (Cosine, "cosine", "CosSim", "", Higher),
        (NmseDb, "nmse_db", "NMSE", "dB", Lower),
        (
            SpectralAngleDeg,
            "spectral_angle_deg",
            "Angle",
            "deg",
            Lower,
        ),
        (PleDeg, "ple_deg", "PLE", "deg", Lower),
        (Hit2Deg, "hit_2deg", "Hit@2", "", Higher),
        (Hit4Deg, "hit_4deg", "Hit@4", "", Higher),
        (Recall2Deg, "recall_2deg", "Rec.@2", "", Higher),
        (Recall4Deg, "recall_4deg", "Rec.@4", "", Higher),
        (Mse, "mse", "MSE", "", Lower),
        (Rmse, "rmse", "RMSE", "", Lower),
        (Nmse, "nmse", "NMSE lin.", "", Lower),
        (MirrorPleDeg, "mirror_ple_deg", "mirror PLE", "deg", Lower),
        (MirrorHit2Deg, "mirror_hit_2deg", "mirror Hit@2", "", Higher),
        (MirrorHit4Deg, "mirror_hit_4deg", "mirror Hit@4", "", Higher),
    ]
};

const fn first<const N: usize>() -> [Metric; N] {
    let mut first = [Metric::Mae; N];
    let mut i = 0;
    while i < N {
        first[i] = ABOUT[i].0;
        i += 1;
    }
    first
}

impl Metric {
    /// The columns of the paper's result tables, in their order.
    pub const PAPER_COLUMNS: [Metric; 10] = first();

    /// Columns beside the paper's: the twin of a direction, which a uniform linear array cannot tell from it, is accepted.
    pub const MIRROR_COLUMNS: [Metric; 3] = [
        Metric::MirrorPleDeg,
        Metric::MirrorHit2Deg,
        Metric::MirrorHit4Deg,
    ];

    /// Every metric, the paper's columns first.
    pub const ALL: [Metric; 16] = first();

    /// Returns the value of the metric for one sample. Finite. Only PSNR depends on `range`.
    pub fn of(self, scores: &SampleScores, range: DataRange) -> f64 {
        let [tight, loose] = TOLERANCES_DEG;
        match self {
            Metric::Mae => scores.mae,
            Metric::PsnrDb => scores.psnr_db(range),
            Metric::Cosine => scores.cosine,
            Metric::NmseDb => scores.nmse_db(),
            Metric::SpectralAngleDeg => scores.spectral_angle_deg(),
            Metric::PleDeg => scores.ple_deg,
            Metric::Hit2Deg => f64::from(scores.hit(tight)),
            Metric::Hit4Deg => f64::from(scores.hit(loose)),
            Metric::Recall2Deg => scores.recall[0],
            Metric::Recall4Deg => scores.recall[1],
            Metric::Mse => scores.mse,
            Metric::Rmse => scores.rmse(),
            Metric::Nmse => scores.nmse,
            Metric::MirrorPleDeg => scores.mirror_ple_deg,
            Metric::MirrorHit2Deg => f64::from(scores.mirror_hit(tight)),
            Metric::MirrorHit4Deg => f64::from(scores.mirror_hit(loose)),
        }
    }

    /// Name as a key in machine-read output, with its unit.
    pub fn key(self) -> &'static str {
        ABOUT[self as usize].1
    }

    /// Name as a column heading, as the paper writes it.
    pub fn label(self) -> &'static str {
        ABOUT[self as usize].2
    }

    /// Unit of the metric; empty for a plain number or the unit of the spectra.
    pub fn unit(self) -> &'static str {
        ABOUT[self as usize].3
    }

    /// Label and unit, as a table has them above a column: `PLE [deg]`.
    pub fn heading(self) -> String {
        match self.unit() {
            "" => self.label().into(),
            unit => format!("{} [{unit}]", self.label()),
        }
    }

    /// Decimals that the paper prints: two of a value with a unit, else three.
    pub fn decimals(self) -> usize {
        3 - usize::from(!self.unit().is_empty())
    }

    /// Returns the direction in which the metric improves.
    pub fn better(self) -> Better {
        ABOUT[self as usize].4
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Metric {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_metric_is_at_its_place() {
        for (place, metric) in Metric::ALL.into_iter().enumerate() {
            assert_eq!(metric as usize, place);
        }
        assert_eq!(Metric::PAPER_COLUMNS[9], Metric::Recall4Deg);
        assert_eq!(Metric::MIRROR_COLUMNS, Metric::ALL[13..]);
    }
}
