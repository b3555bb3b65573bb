//! `cargo xtask bench-models`: data, models, baselines, scores, run times, and a report of them.

mod answer;
mod args;
mod baselines;
pub(crate) mod config;
pub(crate) mod dataset;
mod examples;
mod latency;
pub(crate) mod model;
pub(crate) mod stamp;
pub(crate) mod test_set;
mod tune;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use answer::Answer;
use anyhow::{Context, Result, bail, ensure};
use aps_data::{Dataset, LOCK_FILE, Part as SplitPart, Split};
use aps_model::weights::Shipped;
use aps_model::{ModelKind, candle_core};
use aps_report::benchmark::{
    DataSummary, Entry, EntryKind, FORMAT, Failure, MEAN, Machine, Results,
};
use baselines::Found;
use config::Config;
use map2aps::targets::{Target, labelled_links};
use map2aps::training::{Trained, Training, TrainingError};
use map2aps::{DatasetPlan, Draw, Examples};
use serde_json::{Value, json};
use stamp::{Part, State};
use test_set::TestSet;
use xtask::{machine, output};
use xtask::{note, say};

pub use args::Args;

/// Interactions of the tracer whose paths are the lines of sight.
const SIGHT: usize = 0;

/// Something to be scored.
#[derive(Debug, Clone)]
enum Job {
    Mean,
    LineOfSight,
    StrongestPath,
    /// Most interactions on a path.
    Tracer(usize),
    Model(ModelKind),
    /// Weights that come with the program.
    Shipped(ModelKind),
    /// Weights that were trained before.
    Weights(String, PathBuf),
    External(String, PathBuf),
}

impl Job {
    fn title(&self) -> (String, EntryKind) {
        match self {
            Self::Mean => (MEAN.into(), EntryKind::Baseline),
            Self::LineOfSight => ("line of sight".into(), EntryKind::Baseline),
            Self::StrongestPath => ("strongest path".into(), EntryKind::Ceiling),
            Self::Tracer(1) => ("tracer, 1 interaction".into(), EntryKind::Tracer),
            Self::Tracer(most) => (format!("tracer, {most} interactions"), EntryKind::Tracer),
            Self::Model(kind) => (kind.title().into(), EntryKind::Model),
            Self::Shipped(kind) => (format!("{}, shipped", kind.title()), EntryKind::Shipped),
            Self::Weights(name, _) => (name.clone(), EntryKind::Shipped),
            Self::External(name, _) => (name.clone(), EntryKind::External),
        }
    }
}

/// A benchmark with its folder.
struct Bench {
    /// Name of the profile, or `custom`.
    profile: &'static str,
    config: Config,
    out: PathBuf,
    /// If true, parts that earlier runs finished are made anew.
    fresh: bool,
    interrupted: Arc<AtomicBool>,
    device: candle_core::Device,
}

/// Data set and settings that all jobs share.
struct BenchContext {
    plan: DatasetPlan,
    data: Part,
    dataset: Dataset,
    test: TestSet,
    /// Mean of the training targets.
    mean: Vec<f64>,
    train_links: usize,
}

impl Bench {
    fn run(&self) -> Result<()> {
        let started = Instant::now();
        let mut machine = machine::describe();
        let _lock = self.claim_folder()?;
        let jobs = self.jobs()?;
        let (plan, split) = dataset::plan(&self.config)?;
        let announce = |stage: usize, name: &str| {
            let (stages, seconds) = (1 + jobs.len(), started.elapsed().as_secs());
            note!("[{stage}/{stages}] {name}, {seconds} s so far");
        };
        announce(1, "data set");
        let context = self.context(plan, &split)?;
        let (mut entries, mut failed, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for (stage, job) in (2..).zip(&jobs) {
            let (name, _) = job.title();
            announce(stage, &name);
            match self.entry(job, &context) {
                Ok(entry) => entries.push(entry),
                Err(error) if self.interrupted.load(Ordering::Relaxed) => {
                    return Err(
                        error.context("what is finished is kept, the same command continues")
                    );
                }
                Err(error) if is_not_applicable(&error) => {
                    let message = output::told(error.as_ref());
                    note!("{name} is left out: {message}");
                    left_out.push(Failure { name, message });
                }
                // The tracer without interactions tells which links are in sight: no report without it.
                Err(error) if matches!(job, Job::Tracer(SIGHT)) => return Err(error),
                Err(error) => {
                    let message = output::told(error.as_ref());
                    note!("{name} failed, the others go on: {message}");
                    failed.push(Failure { name, message });
                }
            }
        }
        ensure!(!entries.is_empty(), "nothing could be scored");
        machine.seconds_total = started.elapsed().as_secs_f64();
        let results = Results {
            failed,
            left_out,
            ..self.results(machine, &context, entries)?
        };
        results.save(&self.out)?;
        let files = aps_report::benchmark::write_report(&results, &self.out)?;
        note!("{} files of the report", files.len());
        for failure in &results.failed {
            say!("failed: {}: {}", failure.name, failure.message)?;
        }
        for reason in &results.left_out {
            say!("left out: {}: {}", reason.name, reason.message)?;
        }
        say!("{}", self.out.join("report.html").display())?;
        let is_model = |entry: &Entry| entry.kind == EntryKind::Model;
        ensure!(
            results.failed.is_empty() || results.entries.iter().any(is_model),
            "every model failed"
        );
        Ok(())
    }

    /// Marks the folder as a benchmark's, so that nothing else is ever removed from it, and locks it.
    fn claim_folder(&self) -> Result<fs::File> {
        let place = || format!("folder '{}'", self.out.display());
        let marker = self.out.join("configuration.json");
        fs::create_dir_all(&self.out).with_context(place)?;
        let mut names = fs::read_dir(&self.out).with_context(place)?;
        let is_foreign = |name: &fs::DirEntry| name.file_name() != LOCK_FILE;
        ensure!(
            !names.any(|name| name.as_ref().is_ok_and(is_foreign)) || marker.is_file(),
            "'{}' holds other files than a benchmark's; give another --out",
            self.out.display()
        );
        let lock = aps_data::lock_folder(&self.out)?;
        stamp::write_json(&marker, &self.config)?;
        Ok(lock)
    }

    fn jobs(&self) -> Result<Vec<Job>> {
        let mut jobs = vec![Job::Mean, Job::LineOfSight, Job::Tracer(SIGHT)];
        let interactions = self.config.tracer.interactions.iter();
        jobs.extend(interactions.copied().map(Job::Tracer));
        jobs.push(Job::StrongestPath);
        jobs.extend(self.config.kinds().into_iter().map(Job::Model));
        jobs.extend(Shipped::all().map(|shipped| Job::Shipped(shipped.label.kind)));
        let weights = self.config.weights.iter();
        jobs.extend(weights.map(|(name, file)| Job::Weights(name.clone(), file.clone())));
        let external = self.config.external.iter();
        jobs.extend(external.map(|(name, file)| Job::External(name.clone(), file.clone())));
        // Later ones of a name are the same tracer again, or something from elsewhere named as something else here.
        let mut unique: Vec<Job> = Vec::new();
        for job in jobs {
            let (name, _) = job.title();
            let is_taken = unique.iter().any(|one| stem(&one.title().0) == stem(&name));
            if let (true, Job::External(..) | Job::Weights(..)) = (is_taken, &job) {
                bail!("'{name}' is the name of another entry; choose another");
            }
            if !is_taken {
                unique.push(job);
            }
        }
        Ok(unique)
    }

    fn context(&self, plan: DatasetPlan, split: &Split) -> Result<BenchContext> {
        let folder = self.out.join("data");
        let (data, dataset) = dataset::open(&self.config, &plan, split, folder, self.fresh)?;
        let limit = self.config.data.test_links;
        let test = TestSet::load(&dataset, SplitPart::Test, limit, self.config.seed)?;
        let train_maps = &dataset.manifest().split.train;
        let (limit, seed) = (self.config.training.links, self.config.seed);
        let draw = limit.map(|links| Draw { links, seed });
        let target = Target::Normalised(test.normalization());
        let train = Examples::of_maps(&dataset, train_maps, target, draw)?;
        ensure!(
            !train.list().is_empty(),
            "the training maps {train_maps:?} have no link with a label"
        );
        Ok(BenchContext {
            mean: train.mean_target(),
            train_links: train.list().len(),
            plan,
            data,
            dataset,
            test,
        })
    }

    /// Makes an entry, or takes it as it was made before.
    fn entry(&self, job: &Job, context: &BenchContext) -> Result<Entry> {
        let (name, kind) = job.title();
        let folder = Path::new("scores").join(stem(&name));
        let training = match job {
            &Job::Model(kind) => Some(self.training(kind, context)?),
            _ => None,
        };
        let made_of = match (job, &training) {
            (_, Some((_, part))) => json!(part.hash()),
            (Job::External(_, file) | Job::Weights(_, file), _) => external_settings(file)?,
            (&Job::Shipped(kind), _) => {
                let bytes = Shipped::of(kind).map_or(&[][..], |shipped| shipped.bytes);
                json!(stamp::digest(bytes)?)
            }
            _ => json!([self.config.training.links, self.config.seed]),
        };
        let part = Part::new(
            self.out.join(&folder),
            json!({
                "name": name,
                "data": context.data.hash(),
                "test_links": self.config.data.test_links,
                "seed": self.config.seed,
                "latency": self.config.latency,
                // Run times depend on it.
                "threads": rayon::current_num_threads(),
                "made_of": made_of,
            }),
        );
        let state = part.open(self.fresh)?;
        // Scores outlive their model's weights, unless these are to be made anew.
        if state == State::Finished {
            return answer::entry(part.folder());
        }
        let (test, interrupted) = (&context.test, &*self.interrupted);
        let answer = match (job, &training) {
            (Job::Mean, _) => baselines::mean(test, &context.mean),
            (Job::LineOfSight, _) => baselines::line_of_sight(test, &context.plan, &context.mean)?,
            (&Job::Tracer(interactions), _) => self.trace(context, Found::Within(interactions))?,
            (Job::StrongestPath, _) => self.trace(context, Found::Strongest)?,
            (Job::External(_, file), _) => Answer {
                predictions: test.choose(&context.dataset, answer::spectra(file)?)?,
                ..Answer::default()
            },
            (Job::Weights(_, file), _) => {
                self.ask(Trained::load(file, None, None, &self.device)?, context)?
            }
            (&Job::Shipped(kind), _) => self.ask(Trained::shipped(kind, &self.device)?, context)?,
            (Job::Model(_), Some((plan, training))) => {
                let made = model::train(training, plan, &context.dataset, self.fresh, interrupted)?;
                let trained = model::trained(training, plan, &self.device)?;
                model::ask(&trained, Some(made), &self.question(test))?
            }
            (Job::Model(_), None) => unreachable!("a model has a training"),
        };
        let entry = answer::keep(answer, (&name, kind), test, &self.out, &folder)?;
        part.finish()?;
        Ok(entry)
    }

    fn trace(&self, context: &BenchContext, found: Found) -> Result<Answer> {
        let batches = &self.config.latency.batches;
        let batch = batches.iter().copied().max().unwrap_or(1);
        let (plan, mean) = (&context.plan, &context.mean);
        baselines::tracer(&context.test, plan, found, mean, batch)
    }

    /// Asks a model that was trained elsewhere, perhaps on data with other statistics.
    fn ask(&self, trained: Trained, context: &BenchContext) -> Result<Answer> {
        for difference in trained.differences(&context.dataset)? {
            note!("note: it learnt other labels than those here: {difference}");
        }
        let trained = trained
            .with_maps(Some(context.plan.maps.clone()))
            .for_targets(Target::Normalised(context.test.normalization()));
        model::ask(&trained, None, &self.question(&context.test))
    }

    fn question<'a>(&'a self, test: &'a TestSet) -> model::Question<'a> {
        model::Question {
            test,
            latency: &self.config.latency,
            device: &self.device,
            interrupted: &self.interrupted,
        }
    }

    fn training(&self, kind: ModelKind, context: &BenchContext) -> Result<(Training, Part)> {
        let plan = model::plan(&self.config, kind, Some(&context.plan.maps))?;
        let folder = self.out.join("models").join(kind.name());
        let settings = model::settings(&plan, context.data.hash());
        Ok((plan, Part::new(folder, settings)))
    }

    /// Origin of the maps, in words.
    fn source(&self) -> String {
        match self.config.data.maps.starts_with("synthetic") {
            true => format!("synthetic city, seed {}", self.config.seed),
            false => {
                let path = Path::new(&self.config.data.maps);
                let name = path.file_name().map(|name| name.to_string_lossy());
                format!("folder {}", name.unwrap_or_default())
            }
        }
    }

    fn results(
        &self,
        machine: Machine,
        context: &BenchContext,
        mut entries: Vec<Entry>,
    ) -> Result<Results> {
        let folder_of = |name: &str| self.out.join("scores").join(stem(name));
        let (sight, _) = Job::Tracer(SIGHT).title();
        let mut line_of_sight = vec![true; context.test.len()];
        for link in answer::substituted(&folder_of(&sight))? {
            line_of_sight[link] = false;
        }
        let split = &context.dataset.manifest().split;
        let develop = labelled_links(&context.dataset, split.maps(SplitPart::Develop));
        let limit = self.config.training.develop_links.unwrap_or(usize::MAX);
        // The tracer that found the lines of sight is in the tables if it was asked for.
        let is_shown = self.config.tracer.interactions.contains(&SIGHT);
        entries.retain(|entry| is_shown || entry.name != sight);
        Ok(Results {
            format: FORMAT,
            profile: self.profile.into(),
            configuration: serde_json::to_value(&self.config)?,
            machine,
            data: DataSummary {
                source: self.source(),
                train_maps: split.train.clone(),
                dev_maps: split.develop.clone(),
                test_maps: split.test.clone(),
                train_links: context.train_links as u64,
                dev_links: develop.min(limit) as u64,
                chosen_by: model::CHOSEN_BY.key().into(),
                test_links: context.test.len() as u64,
                invalid_test_links: context.test.invalid,
                protocol: context.test.protocol.to_string(),
            },
            links: context.test.links(&line_of_sight)?,
            examples: examples::choose(
                &entries,
                &context.test,
                &context.plan,
                &self.out,
                folder_of,
            )?,
            entries,
            failed: Vec::new(),
            left_out: Vec::new(),
        })
    }
}

/// Tells if something was not scored because it predicts labels of another meaning, which is no failure.
fn is_not_applicable(error: &anyhow::Error) -> bool {
    let cause = error.downcast_ref::<map2aps::Error>().map(|e| e.cause());
    matches!(
        cause,
        Some(map2aps::Error::Training(TrainingError::OtherLabels { .. }))
    )
}

/// Settings that decide predictions or weights from elsewhere: the digest of their file.
fn external_settings(file: &Path) -> Result<Value> {
    let digest = fs::File::open(file).and_then(stamp::digest);
    let digest = digest.with_context(|| format!("file '{}'", file.display()))?;
    Ok(json!(digest))
}

/// The name of an entry as that of a folder.
fn stem(name: &str) -> String {
    let plain = |c: char| match c.is_ascii_alphanumeric() {
        true => c.to_ascii_lowercase(),
        false => '-',
    };
    name.chars().map(plain).collect()
}
