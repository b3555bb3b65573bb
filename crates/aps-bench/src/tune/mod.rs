//! The choice of each model's settings for a budget, on the development maps.

mod grid;
mod trial;

use std::cell::RefCell;
use std::fmt::Write;
use std::path::Path;

use aps_data::{Part as SplitPart, replace_file};
use aps_metrics::Metric;
use aps_model::ModelKind;
use aps_model::condition::InputKind;
use map2aps::training::{RunFolder, usual_image_size};
use toml::Table;

use crate::benchmark::Benchmark;
use crate::config::ModelConfig;
use crate::error::{Error, Result};
use crate::files::{claim_folder, read_json, write_json};
use crate::summary::source;
use crate::test_bed::TestBed;
use crate::watch::{Event, Watch};
use grid::{choose, longer};

pub use trial::{Outcome, Trial};

/// Development links by which a setting is chosen.
const LINKS: usize = 1000;

/// Development links whose score is taken while a setting is trained: with all of a long budget's, a short training would do little else.
const LINKS_WHILE_TRAINING: usize = 200;

/// Steps below which a training says little.
const FEW_STEPS: u64 = 20;

/// Beginning of the part of a profile's file that is written here, and of the first line of that part.
const HEAD: &str = "\n\n# Written by `cargo xtask bench-models --tune";

/// A choice of settings that is under way.
struct Search<'a> {
    bench: &'a Benchmark,
    bed: TestBed,
    budget_s: f64,
    watch: Watch<'a>,
}

impl Benchmark {
    /// Trains every model with each setting of a grid for a share of the budget, then at a few rates for five times as long, and
    /// writes the best into a profile's file, behind what is there. No test map is looked at.
    ///
    /// # Errors
    /// Settings without a budget, a share of it that is none, a file that is no profile's, a model of which every training
    /// failed, and [`Error::Interrupted`]: trainings that were made are used again.
    pub fn tune(&self, share: f64, file: &Path, watch: Watch<'_>) -> Result<()> {
        watch.ended(self.choose_settings(share, file, watch))
    }

    fn choose_settings(&self, share: f64, file: &Path, watch: Watch<'_>) -> Result<()> {
        let budget_s = self.config.budget_s()?.ok_or(Error::NoBudget)?;
        if !(share.is_finite() && share * budget_s >= 1e-3) {
            return Err(Error::Share { share, budget_s });
        }
        let device = self.config.device.open()?;
        let _lock = claim_folder(&self.out, &self.config)?;
        let (folder, links) = (self.out.join("data"), (SplitPart::Develop, Some(LINKS)));
        let bed = TestBed::with_links(&self.config, device, &folder, links, self.fresh, watch)?;
        let text = std::fs::read_to_string(file).map_err(Error::file("profile", file))?;
        let (own, written) = text.split_once(HEAD).unwrap_or((&text, ""));
        let (_, written) = written.split_once('\n').unwrap_or_default();
        let mut tables: Table = written
            .parse()
            .map_err(Error::file::<toml::de::Error>("profile", file))?;
        let longer = longer(share);
        let shares = match longer {
            Some(longer) => format!("shares {share} and {longer}"),
            None => format!("share {share}"),
        };
        let head = format!(
            "{}{HEAD} {share}`: {shares} of {budget_s} s a model, {}:\n",
            own.trim_end(),
            source(&self.config)
        );
        watch.tell(Event::TuningBegins);
        let search = Search {
            bench: self,
            bed,
            budget_s,
            watch,
        };
        for kind in self.config.kinds() {
            let best = search.best(kind, (share, longer))?;
            let models = tables.entry("model").or_insert(Table::new().into());
            let models = models.as_table_mut().ok_or("'model' is no table");
            let models = models.map_err(Error::file("profile", file))?;
            models.insert(kind.name().into(), toml::Value::try_from(best.settings)?);
            // After each model, so that an interrupted choice keeps what is chosen.
            let text = format!("{head}{}", toml::to_string(&tables)?);
            replace_file(file, text.as_bytes())?;
            watch.tell(Event::Chosen(&best));
        }
        Ok(())
    }
}

impl Search<'_> {
    /// The best settings of a model, of trainings of a share of the budget, then of a longer one.
    fn best(&self, model: ModelKind, shares: (f64, Option<f64>)) -> Result<Trial<'static>> {
        let preset = self.bench.config.training.preset;
        let papers = model.train_config(preset);
        let takes_images = model.input() == InputKind::Images;
        let usual = ModelConfig {
            image_size: takes_images.then(|| usual_image_size(preset)),
            batch: Some(papers.batch),
            learning_rate: Some(papers.learning_rate),
            warmup_steps: Some(papers.warmup_steps),
        };
        let failed = RefCell::new(None);
        let mut score = |settings, share| match self.score(model, settings, share)? {
            Ok(cosine) => Ok(cosine),
            Err(error) => {
                failed.replace(Some(Box::new(error)));
                Ok(f64::NEG_INFINITY)
            }
        };
        let (settings, cosine) = choose(usual, shares, &mut score)?;
        if !cosine.is_finite() {
            let source = failed.take();
            return Err(Error::NoTraining { model, source });
        }
        Ok(Trial {
            model,
            settings,
            share: shares.1.unwrap_or(shares.0),
            outcome: Outcome::Scored {
                cosine,
                few_steps: None,
            },
        })
    }

    /// Mean cosine similarity on the development links of a model trained with some settings; the error of a training that fails.
    fn score(&self, model: ModelKind, settings: ModelConfig, share: f64) -> Result<Result<f64>> {
        let tried = |outcome: Outcome<'_>| {
            self.watch.tell(Event::Tried(&Trial {
                model,
                settings,
                share,
                outcome,
            }));
        };
        let seconds = share * self.budget_s;
        let mut config = self.bench.config.clone();
        config.model.insert(model.name().into(), settings);
        config.training.budget = Some(format!("{}ms", (seconds * 1e3).round()));
        let develop_links = config.training.develop_links.unwrap_or(usize::MAX);
        config.training.develop_links = Some(develop_links.min(LINKS_WHILE_TRAINING));
        let folder = self.bench.out.join("tune");
        let folder = folder.join(folder_of(model, settings, seconds));
        let (bed, links) = (&self.bed, &self.bed.test);
        let (plan, part) = bed.training(&config, model, &folder)?;
        let training = match bed.train(&plan, &part, self.watch) {
            Ok(training) => training,
            Err(error) if self.watch.is_cancelled() => return Err(error),
            Err(error) => {
                tried(Outcome::Failed(&error));
                return Ok(Err(error));
            }
        };
        let kept = part.folder.join("score.json");
        let cosine = match kept.is_file() {
            true => read_json(&kept)?,
            false => {
                let predicted = bed.trained(&plan, &part)?.predict(&links.examples)?;
                let table = links.score(&predicted, links.protocol.into())?;
                let cosine = table.mean(Metric::Cosine).ok_or(Error::NothingScored)?;
                write_json(&kept, &cosine)?;
                // There are many of them, and they are large.
                let run = RunFolder::create(&part.folder)?;
                for weights in [run.best(), run.checkpoint()] {
                    std::fs::remove_file(&weights).map_err(Error::file("file", &weights))?;
                }
                part.finish()?;
                cosine
            }
        };
        let steps = training.curve.last().map_or(0, |last| last.steps);
        let few_steps = (steps < FEW_STEPS).then_some(steps);
        tried(Outcome::Scored { cosine, few_steps });
        Ok(Ok(cosine))
    }
}

/// Name of the folder of a training.
fn folder_of(model: ModelKind, settings: ModelConfig, seconds: f64) -> String {
    let mut name = model.name().to_owned();
    for number in [
        settings.learning_rate.map(|rate| rate.to_string()),
        settings.batch.map(|batch| batch.to_string()),
        settings.image_size.map(|size| size.to_string()),
        settings.warmup_steps.map(|steps| steps.to_string()),
        Some(format!("{seconds}s")),
    ] {
        let _ = write!(name, "-{}", number.unwrap_or_default());
    }
    name
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::*;
    use crate::config::{Config, Profile};

    /// Trains for real, two seconds at most.
    #[test]
    fn what_did_best_is_written_with_its_conditions() {
        let root = tempfile::tempdir().unwrap();
        let flags = "models = ['polar_reg']\ntraining.budget = '2s'\nmodel.polar_reg.batch = 7";
        let config = Config::resolve(Profile::Smoke, None, flags.parse().unwrap()).unwrap();
        let bench = Benchmark::new(config, root.path().join("bench")).unwrap();
        let file = root.path().join("tiny.toml");
        let own = fs::read_to_string(Profile::Smoke.path()).unwrap();
        // As versions before wrote it, of a model that is not asked for now.
        let earlier = "[model.vit_reg]\nbatch = 5\n";
        fs::write(&file, format!("{own}{HEAD}`:\n{earlier}")).unwrap();
        bench.tune(0.5, &file, Watch::default()).unwrap();

        let text = fs::read_to_string(&file).unwrap();
        let (before, written) = text.split_once(HEAD).unwrap();
        assert_eq!(before.trim_end(), own.trim_end());
        let (conditions, tables) = written.split_once('\n').unwrap();
        let told = " 0.5`: shares 0.5 and 1 of 2 s a model, synthetic city, seed 42:";
        assert_eq!(conditions, told);
        let tables: Table = tables.parse().unwrap();
        let models: BTreeMap<String, ModelConfig> = tables["model"].clone().try_into().unwrap();
        assert_eq!(models["vit_reg"].batch, Some(5));

        // Of the trainings of the longer share, the one with these settings has the highest score.
        let trials = fs::read_dir(bench.out.join("tune")).unwrap();
        let names = trials.map(|trial| trial.unwrap().file_name().into_string().unwrap());
        let longer = names.filter(|name| name.ends_with("-2s"));
        let score = |name: String| {
            let file = bench.out.join("tune").join(&name).join("score.json");
            file.is_file()
                .then(|| (read_json::<f64>(&file).unwrap(), name))
        };
        let best = longer.filter_map(score).max_by(|a, b| a.0.total_cmp(&b.0));
        let ModelConfig {
            batch,
            learning_rate,
            warmup_steps,
            ..
        } = models["polar_reg"];
        let expected = format!(
            "polar_reg-{}-{}--{}-2s",
            learning_rate.unwrap(),
            batch.unwrap(),
            warmup_steps.unwrap()
        );
        assert_eq!(best.unwrap().1, expected);
    }
}
