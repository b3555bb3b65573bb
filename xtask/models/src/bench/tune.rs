//! Settings of each model for a budget, chosen on the development maps.

use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::{Context, Result, ensure};
use aps_data::{Part as SplitPart, replace_file};
use aps_metrics::Metric;
use aps_model::ModelKind;
use aps_model::condition::InputKind;
use map2aps::training::{RunFolder, usual_image_size};
use toml::Table;
use xtask::{note, say};

use super::config::ModelConfig;
use super::stamp::{Part, read_json, write_json};
use super::test_set::TestSet;
use super::{Bench, BenchContext, dataset, model};

/// Development links by which a setting is chosen.
const LINKS: usize = 1000;

/// One change of a model's settings.
type Change = fn(&mut ModelConfig, usual: &ModelConfig);

/// The settings tried, the same for every model: first the paper's, then of each line what is better than what was best before.
const GRID: [&[Change]; 4] = [
    &[
        |m, usual| m.learning_rate = times(usual.learning_rate, 1.0 / 3.0),
        |m, usual| m.learning_rate = times(usual.learning_rate, 3.0),
        |m, usual| m.learning_rate = times(usual.learning_rate, 10.0),
    ],
    &[
        |m, _| m.batch = Some(16),
        |m, _| m.batch = Some(32),
        |m, _| m.batch = Some(128),
    ],
    &[|m, _| m.image_size = Some(32)],
    &[|m, _| m.warmup_steps = Some(50)],
];

/// A rate times a factor, to two digits.
fn times(rate: Option<f64>, factor: f64) -> Option<f64> {
    format!("{:.1e}", rate? * factor).parse().ok()
}

/// Beginning of the part of a profile's file that is written here.
const HEAD: &str = "\n\n# Written by `cargo xtask bench-models --tune`:";

impl Bench {
    /// Trains every model with each setting of the grid for a share of the budget, prints a table, and writes the best into a
    /// profile's file.
    pub fn tune(&self, share: f64, file: &Path) -> Result<()> {
        let budget_s = self.config.budget_s()?;
        let budget_s = budget_s.context("--tune is for a profile with a budget")?;
        ensure!(
            share > 0.0 && share.is_finite(),
            "--tune is {share}: must be positive"
        );
        ensure!(
            share * budget_s >= 1e-3,
            "--tune {share} leaves a training less than a millisecond of {budget_s} s"
        );
        self.claim_folder()?;
        let (plan, split) = dataset::plan(&self.config)?;
        let context = self.context(plan, &split)?;
        let seed = self.config.seed;
        let links = TestSet::load(&context.dataset, SplitPart::Develop, Some(LINKS), seed)?;
        let place = || format!("profile '{}'", file.display());
        let text = std::fs::read_to_string(file).with_context(place)?;
        let (own, written) = text.split_once(HEAD).unwrap_or((&text, ""));
        let mut tables: Table = written.parse().with_context(place)?;
        say!(
            "{:14} {:>10} {:>6} {:>6} {:>7} {:>7}",
            "model",
            "rate",
            "batch",
            "pixels",
            "warm-up",
            "CosSim"
        )?;
        for kind in self.config.kinds() {
            let best = self.best(kind, share * budget_s, &context, &links)?;
            let models = tables.entry("model").or_insert(Table::new().into());
            let models = models.as_table_mut().with_context(place)?;
            models.insert(kind.name().into(), toml::Value::try_from(best)?);
            // After each model, so that an interrupted choice keeps what is chosen.
            let head = format!("{}{HEAD}\n", own.trim_end());
            let text = format!("{head}{}", toml::to_string(&tables)?);
            replace_file(file, text.as_bytes())?;
        }
        note!("written into '{}'; the next build takes it", file.display());
        Ok(())
    }

    fn best(
        &self,
        kind: ModelKind,
        seconds: f64,
        context: &BenchContext,
        links: &TestSet,
    ) -> Result<ModelConfig> {
        let takes_images = kind.input() == InputKind::Images;
        let papers = kind.train_config(self.config.training.preset);
        let usual = ModelConfig {
            image_size: takes_images.then(|| usual_image_size(self.config.training.preset)),
            batch: Some(papers.batch),
            learning_rate: Some(papers.learning_rate),
            warmup_steps: Some(papers.warmup_steps),
        };
        let score = |settings: ModelConfig| self.score(kind, settings, seconds, context, links);
        let mut best = (usual, score(usual)?);
        for line in GRID {
            let before = best.0;
            for change in line {
                let mut settings = before;
                change(&mut settings, &usual);
                if settings.image_size != before.image_size && !takes_images {
                    continue;
                }
                let cosine = score(settings)?;
                if cosine > best.1 {
                    best = (settings, cosine);
                }
            }
        }
        let (best, cosine) = best;
        ensure!(
            cosine.is_finite(),
            "no training of {kind} made a step: nothing is written; give a larger share"
        );
        say!("{} <- best, CosSim {cosine:.3}", row(kind, best))?;
        Ok(best)
    }

    /// Mean cosine similarity on the development links of a model trained with some settings; a training that fails has none.
    fn score(
        &self,
        kind: ModelKind,
        settings: ModelConfig,
        seconds: f64,
        context: &BenchContext,
        links: &TestSet,
    ) -> Result<f64> {
        let mut config = self.config.clone();
        config.model.insert(kind.name().into(), settings);
        config.training.budget = Some(format!("{}ms", (seconds * 1e3).round()));
        let plan = model::plan(&config, kind, Some(&context.plan.maps))?;
        let mut name = kind.name().to_owned();
        for number in [
            settings.learning_rate.map(|rate| rate.to_string()),
            settings.batch.map(|batch| batch.to_string()),
            settings.image_size.map(|size| size.to_string()),
            settings.warmup_steps.map(|steps| steps.to_string()),
        ] {
            let _ = write!(name, "-{}", number.unwrap_or_default());
        }
        let folder = self.out.join("tune").join(name);
        let part = Part::new(folder, model::settings(&plan, context.data.hash()));
        let made = model::train(
            &part,
            &plan,
            &context.dataset,
            self.fresh,
            &self.interrupted,
        );
        match made {
            Ok(_) => {}
            Err(error) if self.interrupted.load(Ordering::Relaxed) => {
                return Err(error);
            }
            Err(error) => {
                say!("{} failed: {error:#}", row(kind, settings))?;
                return Ok(f64::NEG_INFINITY);
            }
        }
        let kept = part.folder().join("score.json");
        let cosine = match kept.is_file() {
            true => read_json(&kept)?,
            false => {
                let trained = model::trained(&part, &plan, &self.device)?;
                let predicted = trained.predict(links.examples())?;
                let table = links.score(&predicted, links.protocol.into())?;
                let column = table.column(Metric::Cosine).context("cosine is scored")?;
                let cosine = column.iter().sum::<f64>() / column.len() as f64;
                write_json(&kept, &cosine)?;
                // There are many of them, and they are large.
                let run = RunFolder::create(part.folder())?;
                for weights in [run.best(), run.checkpoint()] {
                    std::fs::remove_file(weights)?;
                }
                cosine
            }
        };
        say!("{} {cosine:7.3}", row(kind, settings))?;
        Ok(cosine)
    }
}

fn row(kind: ModelKind, settings: ModelConfig) -> String {
    format!(
        "{:14} {:>10.1e} {:>6} {:>6} {:>7}",
        kind.name(),
        settings.learning_rate.unwrap_or_default(),
        settings.batch.unwrap_or_default(),
        settings.image_size.unwrap_or_default(),
        settings.warmup_steps.unwrap_or_default(),
    )
}
