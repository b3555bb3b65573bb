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

impl Metric {
    /// The columns of the paper's result tables, in their order.
    pub const PAPER_COLUMNS: [Metric; 10] = [
        Metric::Mae,
        Metric::PsnrDb,
        Metric::Cosine,
        Metric::NmseDb,
        Metric::SpectralAngleDeg,
        Metric::PleDeg,
        Metric::Hit2Deg,
        Metric::Hit4Deg,
        Metric::Recall2Deg,
        Metric::Recall4Deg,
    ];

    /// Every metric, the paper's columns first.
    pub const ALL: [Metric; 16] = [
        Metric::Mae,
        Metric::PsnrDb,
        Metric::Cosine,
        Metric::NmseDb,
        Metric::SpectralAngleDeg,
        Metric::PleDeg,
        Metric::Hit2Deg,
        Metric::Hit4Deg,
        Metric::Recall2Deg,
        Metric::Recall4Deg,
        Metric::Mse,
        Metric::Rmse,
        Metric::Nmse,
        Metric::MirrorPleDeg,
        Metric::MirrorHit2Deg,
        Metric::MirrorHit4Deg,
    ];

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
        match self {
            Metric::Mae => "mae",
            Metric::PsnrDb => "psnr_db",
            Metric::Cosine => "cosine",
            Metric::NmseDb => "nmse_db",
            Metric::SpectralAngleDeg => "spectral_angle_deg",
            Metric::PleDeg => "ple_deg",
            Metric::Hit2Deg => "hit_2deg",
            Metric::Hit4Deg => "hit_4deg",
            Metric::Recall2Deg => "recall_2deg",
            Metric::Recall4Deg => "recall_4deg",
            Metric::Mse => "mse",
            Metric::Rmse => "rmse",
            Metric::Nmse => "nmse",
            Metric::MirrorPleDeg => "mirror_ple_deg",
            Metric::MirrorHit2Deg => "mirror_hit_2deg",
            Metric::MirrorHit4Deg => "mirror_hit_4deg",
        }
    }

    /// Name as a column heading, as the paper writes it.
    pub fn label(self) -> &'static str {
        match self {
            Metric::Mae => "MAE",
            Metric::PsnrDb => "PSNR",
            Metric::Cosine => "CosSim",
            Metric::NmseDb => "NMSE",
            Metric::SpectralAngleDeg => "Angle",
            Metric::PleDeg => "PLE",
            Metric::Hit2Deg => "Hit@2",
            Metric::Hit4Deg => "Hit@4",
            Metric::Recall2Deg => "Rec.@2",
            Metric::Recall4Deg => "Rec.@4",
            Metric::Mse => "MSE",
            Metric::Rmse => "RMSE",
            Metric::Nmse => "NMSE lin.",
            Metric::MirrorPleDeg => "mirror PLE",
            Metric::MirrorHit2Deg => "mirror Hit@2",
            Metric::MirrorHit4Deg => "mirror Hit@4",
        }
    }

    /// Unit of the metric; empty for a plain number or the unit of the spectra.
    pub fn unit(self) -> &'static str {
        match self {
            Metric::PsnrDb | Metric::NmseDb => "dB",
            Metric::SpectralAngleDeg | Metric::PleDeg | Metric::MirrorPleDeg => "deg",
            _ => "",
        }
    }

    /// Returns the direction in which the metric improves.
    pub fn better(self) -> Better {
        match self {
            Metric::Mae
            | Metric::NmseDb
            | Metric::SpectralAngleDeg
            | Metric::PleDeg
            | Metric::Mse
            | Metric::Rmse
            | Metric::Nmse
            | Metric::MirrorPleDeg => Better::Lower,
            Metric::PsnrDb
            | Metric::Cosine
            | Metric::Hit2Deg
            | Metric::Hit4Deg
            | Metric::Recall2Deg
            | Metric::Recall4Deg
            | Metric::MirrorHit2Deg
            | Metric::MirrorHit4Deg => Better::Higher,
        }
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Metric {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}
