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

/// Development links whose score is taken while a setting is trained: with all of a long budget's, a short training would do little else.
const LINKS_WHILE_TRAINING: usize = 200;

/// Factors of the rate that the grid found, tried again with more time: a few steps forgive a rate that a whole training does not.
const RATES_AGAIN: [f64; 3] = [1.0, 1.0 / 3.0, 0.1];

/// Share of the budget of the second stage, in shares of the first.
const LONGER: f64 = 5.0;

/// Steps below which a training says little.
const FEW_STEPS: u64 = 20;

/// Beginning of the part of a profile's file that is written here, and of the first line of that part.
const HEAD: &str = "\n\n# Written by `cargo xtask bench-models --tune";

impl Bench {
    /// Trains every model with each setting of the grid for a share of the budget, then at a few rates for longer, prints a table, and
    /// writes the best into a profile's file.
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
        let _lock = self.claim_folder()?;
        let (plan, split) = dataset::plan(&self.config)?;
        let context = self.context(plan, &split)?;
        let seed = self.config.seed;
        let links = TestSet::load(&context.dataset, SplitPart::Develop, Some(LINKS), seed)?;
        let place = || format!("profile '{}'", file.display());
        let text = std::fs::read_to_string(file).with_context(place)?;
        let (own, written) = text.split_once(HEAD).unwrap_or((&text, ""));
        let (_, written) = written.split_once('\n').unwrap_or_default();
        let mut tables: Table = written.parse().with_context(place)?;
        let longer = longer(share);
        let shares = match longer {
            Some(longer) => format!("shares {share} and {longer}"),
            None => format!("share {share}"),
        };
        let head = format!(
            "{}{HEAD} {share}`: {shares} of {budget_s} s a model, {}:\n",
            own.trim_end(),
            self.source()
        );
        say!(
            "{:14} {:>10} {:>6} {:>6} {:>7} {:>9} {:>7}",
            "model",
            "rate",
            "batch",
            "pixels",
            "warm-up",
            "share",
            "CosSim"
        )?;
        for kind in self.config.kinds() {
            let best = self.best(kind, (share, longer), &context, &links)?;
            let models = tables.entry("model").or_insert(Table::new().into());
            let models = models.as_table_mut().with_context(place)?;
            models.insert(kind.name().into(), toml::Value::try_from(best)?);
            // After each model, so that an interrupted choice keeps what is chosen.
            let text = format!("{head}{}", toml::to_string(&tables)?);
            replace_file(file, text.as_bytes())?;
        }
        note!("written into '{}'; the next build takes it", file.display());
        Ok(())
    }

    /// The best settings of a model, of trainings of a share of the budget, then of a longer one.
    fn best(
        &self,
        kind: ModelKind,
        shares: (f64, Option<f64>),
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
        let (best, cosine) = choose(usual, shares, &mut |settings, share| {
            self.score(kind, settings, share, context, links)
        })?;
        ensure!(
            cosine.is_finite(),
            "no training of {kind} made a step: nothing is written; give a larger share"
        );
        let share = shares.1.unwrap_or(shares.0);
        say!("{} <- best, CosSim {cosine:.3}", row(kind, best, share))?;
        Ok(best)
    }

    /// Mean cosine similarity on the development links of a model trained with some settings; a training that fails has none.
    fn score(
        &self,
        kind: ModelKind,
        settings: ModelConfig,
        share: f64,
        context: &BenchContext,
        links: &TestSet,
    ) -> Result<f64> {
        let seconds = share * self.config.budget_s()?.unwrap_or_default();
        let mut config = self.config.clone();
        config.model.insert(kind.name().into(), settings);
        config.training.budget = Some(format!("{}ms", (seconds * 1e3).round()));
        let develop_links = config.training.develop_links.unwrap_or(usize::MAX);
        config.training.develop_links = Some(develop_links.min(LINKS_WHILE_TRAINING));
        let plan = model::plan(&config, kind, Some(&context.plan.maps))?;
        let mut name = kind.name().to_owned();
        for number in [
            settings.learning_rate.map(|rate| rate.to_string()),
            settings.batch.map(|batch| batch.to_string()),
            settings.image_size.map(|size| size.to_string()),
            settings.warmup_steps.map(|steps| steps.to_string()),
            Some(format!("{seconds}s")),
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
        let steps = match made {
            Ok(training) => training.curve.last().map_or(0, |last| last.steps),
            Err(error) if self.interrupted.load(Ordering::Relaxed) => {
                return Err(error);
            }
            Err(error) => {
                say!("{} failed: {error:#}", row(kind, settings, share))?;
                return Ok(f64::NEG_INFINITY);
            }
        };
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
                part.finish()?;
                cosine
            }
        };
        let few = match steps < FEW_STEPS {
            true => format!(", of only {steps} steps"),
            false => String::new(),
        };
        say!("{} {cosine:7.3}{few}", row(kind, settings, share))?;
        Ok(cosine)
    }
}

/// Share of the budget of the second stage, the whole of it at most; none where the first has as much.
fn longer(share: f64) -> Option<f64> {
    let longer = (share * LONGER).min(1.0);
    (longer > share).then_some(longer)
}

/// Searches the grid at the first share, then the rate and the usual image size at the second, if there is one: few steps favour high
/// rates and small images. `score` gives the score of settings at a share,
/// minus infinity where there is none. Returns the best settings with the score of the last stage.
fn choose(
    usual: ModelConfig,
    (share, longer): (f64, Option<f64>),
    score: &mut dyn FnMut(ModelConfig, f64) -> Result<f64>,
) -> Result<(ModelConfig, f64)> {
    let mut best = (usual, score(usual, share)?);
    for line in GRID {
        let before = best.0;
        for change in line {
            let mut settings = before;
            change(&mut settings, &usual);
            if settings.image_size != before.image_size && usual.image_size.is_none() {
                continue;
            }
            best = better(best, settings, score(settings, share)?);
        }
    }
    let Some(share) = longer else {
        return Ok(best);
    };
    let found = best.0;
    best.1 = f64::NEG_INFINITY;
    for factor in RATES_AGAIN {
        let settings = ModelConfig {
            learning_rate: times(found.learning_rate, factor),
            ..found
        };
        best = better(best, settings, score(settings, share)?);
    }
    if found.image_size != usual.image_size {
        let settings = ModelConfig {
            image_size: usual.image_size,
            ..best.0
        };
        best = better(best, settings, score(settings, share)?);
    }
    Ok(best)
}

fn better(best: (ModelConfig, f64), other: ModelConfig, cosine: f64) -> (ModelConfig, f64) {
    match cosine > best.1 {
        true => (other, cosine),
        false => best,
    }
}

fn row(kind: ModelKind, settings: ModelConfig, share: f64) -> String {
    format!(
        "{:14} {:>10.1e} {:>6} {:>6} {:>7} {share:>9.4}",
        kind.name(),
        settings.learning_rate.unwrap_or_default(),
        settings.batch.unwrap_or_default(),
        settings.image_size.unwrap_or_default(),
        settings.warmup_steps.unwrap_or_default(),
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::super::config::{Config, Profile};
    use super::*;

    const USUAL: ModelConfig = ModelConfig {
        image_size: Some(64),
        batch: Some(64),
        learning_rate: Some(1e-3),
        warmup_steps: Some(500),
    };

    /// The nearer a rate is to the best one of a share, the better.
    fn choice(share: f64, best_rates: [f64; 2]) -> (ModelConfig, Vec<(f64, f64)>) {
        let mut tried = Vec::new();
        let chosen = choose(USUAL, (share, longer(share)), &mut |settings, at| {
            let rate = settings.learning_rate.unwrap();
            tried.push((at, rate));
            let best = best_rates[usize::from(at > share)];
            Ok(-(rate / best).ln().abs() - f64::from(settings.batch != Some(32)))
        });
        (chosen.unwrap().0, tried)
    }

    #[test]
    fn a_rate_that_is_best_for_a_few_steps_alone_is_not_chosen() {
        let (chosen, tried) = choice(0.05, [1e-2, 1e-3]);
        assert_eq!((chosen.learning_rate, chosen.batch), (Some(1e-3), Some(32)));
        let (grid, again) = tried.split_at(tried.len() - RATES_AGAIN.len());
        assert!(grid.iter().all(|&(share, _)| share == 0.05));
        assert_eq!(again, [(0.25, 1e-2), (0.25, 3.3e-3), (0.25, 1e-3)]);
        let (chosen, _) = choice(0.05, [1e-2, 1e-2]);
        assert_eq!(chosen.learning_rate, Some(1e-2));
    }

    /// Small images are better at the first share, the usual ones at the second if `is_better_in_time`.
    fn size_chosen(is_better_in_time: bool) -> (Option<usize>, usize) {
        let mut tried = 0;
        let (chosen, _) = choose(USUAL, (0.05, longer(0.05)), &mut |settings, share| {
            let is_usual = settings.image_size == USUAL.image_size;
            let is_long = share > 0.05;
            tried += usize::from(is_long && is_usual);
            Ok(f64::from(is_usual == (is_long && is_better_in_time)))
        })
        .unwrap();
        (chosen.image_size, tried)
    }

    #[test]
    fn the_usual_image_size_is_tried_again_with_more_time() {
        assert_eq!(size_chosen(true), (USUAL.image_size, 1));
        assert_eq!(size_chosen(false), (Some(32), 1));
    }

    #[test]
    fn no_training_is_longer_than_the_budget() {
        assert_eq!(longer(0.05), Some(0.25));
        assert_eq!(longer(0.5), Some(1.0));
        assert_eq!(longer(1.0), None);
        let (chosen, tried) = choice(1.0, [1e-2, 1e-3]);
        assert_eq!(chosen.learning_rate, Some(1e-2));
        assert!(tried.iter().all(|&(share, _)| share == 1.0));
    }

    /// Trains for real, two seconds at most.
    #[test]
    fn what_did_best_is_written_with_its_conditions() {
        let root = tempfile::tempdir().unwrap();
        let flags = "models = ['polar_reg']\ntraining.budget = '2s'\nmodel.polar_reg.batch = 7";
        let config = Config::resolve(Profile::Smoke, None, flags.parse().unwrap()).unwrap();
        let bench = Bench {
            profile: "custom",
            device: config.device.open().unwrap(),
            config,
            out: root.path().join("bench"),
            fresh: false,
            interrupted: Default::default(),
        };
        let file = root.path().join("tiny.toml");
        let own = fs::read_to_string(Profile::Smoke.path()).unwrap();
        // As versions before wrote it, of a model that is not asked for now.
        let earlier = "[model.vit_reg]\nbatch = 5\n";
        fs::write(&file, format!("{own}{HEAD}`:\n{earlier}")).unwrap();
        bench.tune(0.5, &file).unwrap();

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
