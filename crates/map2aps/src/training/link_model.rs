//! Predictions for links of scenes, without a data set.

use aps_label::{LabelConfig, MeanStd, Normalization};
use aps_metrics::{SampleScores, Scorer};
use aps_model::ANGLE_BINS;
use aps_model::condition::InputKind;
use aps_raytrace::TraceConfig;

use super::polar;
use super::{Trained, TrainingError};
use crate::error::Result;
use crate::polar::{PolarViews, SeenLink};
use crate::settings;

/// A model that is given the geometry of links, with the settings of the labels that it learnt.
///
/// ```
/// use map2aps::aps_model::{ModelKind, candle_core::Device};
/// use map2aps::aps_raytrace::{Scene, polar::Mirror};
/// use map2aps::training::{LinkModel, Trained};
/// use map2aps::{PolarViews, SeenLink};
///
/// let model = LinkModel::new(Trained::shipped(ModelKind::PolarReg, &Device::Cpu)?)?;
/// let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]")?;
/// let views = PolarViews::new([Ok((0, scene))].into_iter())?;
/// let link = SeenLink { map: 0, tx_m: [20.0, 70.0], rx_m: [70.0, 30.0], mirror: Mirror::default() };
/// let spectra = model.predict(&views, &[link])?;
/// assert_eq!(spectra[0].relative_power().count(), 180);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LinkModel {
    trained: Trained,
    label: LabelConfig,
    trace: TraceConfig,
    statistics: MeanStd,
}

/// The spectrum that is predicted for a link.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictedLink {
    /// The normalised spectrum, in the bins of [`LinkModel::label`].
    pub normalised: Vec<f32>,
    statistics: MeanStd,
}

impl LinkModel {
    /// Takes a model with its settings.
    ///
    /// # Errors
    /// [`TrainingError::NoGeometry`], [`TrainingError::NoPower`], and settings that this version does not know.
    pub fn new(trained: Trained) -> Result<Self> {
        let kind = trained.label().kind;
        if kind.input() != InputKind::Polar {
            return Err(TrainingError::NoGeometry(kind).into());
        }
        let known = trained.settings().and_then(|settings| {
            let Normalization::Paper(statistics) = settings.normalization() else {
                return None;
            };
            Some((&settings.data_configuration, statistics))
        });
        let (configuration, statistics) = known.ok_or(TrainingError::NoPower(kind))?;
        let (_, trace) =
            settings::tracing_of(configuration)?.ok_or(TrainingError::NoPower(kind))?;
        Ok(Self {
            label: settings::label_of(configuration)?,
            trace,
            statistics,
            trained,
        })
    }

    /// Settings of the labels that the model learnt.
    pub fn label(&self) -> &LabelConfig {
        &self.label
    }

    /// Settings of the paths that these labels are of.
    pub fn trace(&self) -> &TraceConfig {
        &self.trace
    }

    /// Predicts the spectra of links on the maps of `views`, all at a time.
    ///
    /// # Errors
    /// As [`PolarViews::ways`], and [`TrainingError::NotFinite`].
    ///
    /// # Panics
    /// When a link is on none of the maps.
    pub fn predict(&self, views: &PolarViews, links: &[SeenLink]) -> Result<Vec<PredictedLink>> {
        if links.is_empty() {
            return Ok(Vec::new());
        }
        let spectra = self.trained.forward(&polar::ways(views, links)?)?;
        let predicted = spectra.chunks(ANGLE_BINS).map(|bins| PredictedLink {
            normalised: bins.to_vec(),
            statistics: self.statistics,
        });
        Ok(predicted.collect())
    }
}

impl PredictedLink {
    /// Power in each bin over that in the strongest bin of the label, linear. It may be negative or above 1, as predictions are.
    pub fn relative_power(&self) -> impl Iterator<Item = f64> {
        let MeanStd { mean, std } = self.statistics;
        self.normalised
            .iter()
            .map(move |&x| f64::from(x) * std + mean)
    }

    /// Scores it against a label \[dB\] of the same bins, both normalised, as predictions for data sets are.
    ///
    /// # Errors
    /// A label that cannot be normalised, or has other bins.
    pub fn score(&self, label_db: &[f64]) -> Result<SampleScores> {
        let mut truth = label_db.to_vec();
        Normalization::Paper(self.statistics).apply(&mut truth)?;
        Ok(Scorer::new(aps_metrics::Protocol::Paper).score(&truth, &self.normalised)?)
    }
}
