//! A data set and the links of it that models are measured on.

use std::path::Path;

use aps_data::{Dataset, Part as SplitPart};
use aps_model::ModelKind;
use aps_model::candle_core::Device;
use aps_report::benchmark::{Latency, ScoreTable, Training};
use map2aps::DatasetPlan;

use crate::config::Config;
use crate::data;
use crate::error::Result;
use crate::part::Part;
use crate::test_set::TestSet;
use crate::watch::Watch;

/// A data set and the links of it that models are measured on.
///
/// ```ignore
/// let config = Profile::Smoke.config();
/// let bed = TestBed::open(&config, folder.join("data"), Watch::default())?;
/// let small = bed.measure(&config, ModelKind::MsMlp, folder.join("small"), Watch::default())?;
/// println!("{:?}", small.scores.mean(Metric::Cosine));
/// ```
#[derive(Debug)]
pub struct TestBed {
    pub(crate) plan: DatasetPlan,
    pub(crate) data: Part,
    pub(crate) dataset: Dataset,
    pub(crate) test: TestSet,
    pub(crate) device: Device,
    /// If true, what earlier runs finished is made anew.
    pub(crate) fresh: bool,
}

/// A model that was trained and measured.
#[derive(Debug, Clone)]
pub struct Measured {
    /// Its training.
    pub training: Training,
    /// Its run times, one for each size of batch.
    pub latency: Vec<Latency>,
    /// Its scores by the definitions of the paper, link by link.
    pub scores: ScoreTable,
}

impl TestBed {
    /// Makes the data set of a benchmark in a folder, or opens it if it is there, and chooses the test links.
    ///
    /// # Errors
    /// Settings out of range, maps that cannot be used, and a cancelled making: whole maps are kept.
    pub fn open(config: &Config, folder: impl AsRef<Path>, watch: Watch<'_>) -> Result<Self> {
        config.check()?;
        let device = config.device.open()?;
        let test = (SplitPart::Test, config.data.test_links);
        Self::with_links(config, device, folder.as_ref(), test, false, watch)
    }

    /// Opens the data set with so many links of a part of the split.
    pub(crate) fn with_links(
        config: &Config,
        device: Device,
        folder: &Path,
        (part, limit): (SplitPart, Option<usize>),
        fresh: bool,
        watch: Watch<'_>,
    ) -> Result<Self> {
        let (plan, split) = data::plan(config)?;
        let (data, dataset) = data::open(&plan, &split, folder, fresh, watch)?;
        Ok(Self {
            test: TestSet::load(&dataset, part, limit, config.seed)?,
            plan,
            data,
            dataset,
            device,
            fresh,
        })
    }

    /// Number of links that models are measured on.
    pub fn links(&self) -> usize {
        self.test.len()
    }

    /// Trains a model in a folder, or takes the training that is there with the same settings, and measures its best weights. Of
    /// `config` the training, the models' settings and the latency count.
    ///
    /// # Errors
    /// Settings out of range, a training that fails or is cancelled; it is continued the next time.
    pub fn measure(
        &self,
        config: &Config,
        kind: ModelKind,
        folder: impl AsRef<Path>,
        watch: Watch<'_>,
    ) -> Result<Measured> {
        config.check()?;
        let (plan, part) = self.training(config, kind, folder.as_ref())?;
        let training = self.train(&plan, &part, watch)?;
        let answer = self.ask(&self.trained(&plan, &part)?, &config.latency, watch)?;
        let paper = aps_metrics::Protocol::Paper;
        Ok(Measured {
            training,
            latency: answer.latency,
            scores: self.test.score(&answer.predictions, paper)?,
        })
    }
}
