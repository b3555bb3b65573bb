//! Entries of a benchmark: everything that is scored, made or taken as it was made before.

use std::path::Path;

use aps_data::{Part as SplitPart, sha256_of, size_and_sha256};
use aps_model::candle_core::Device;
use aps_model::weights::Shipped;
use aps_report::benchmark::Entry;
use map2aps::targets::Target;
use map2aps::training::Trained;
use map2aps::{Draw, Examples, check_links, links_file};
use serde_json::{Value, json};

use crate::answer::{self, Answer};
use crate::baselines;
use crate::benchmark::Benchmark;
use crate::error::Result;
use crate::job::{Job, stem};
use crate::part::{Part, State};
use crate::test_bed::TestBed;
use crate::test_set::no_links;
use crate::tracer::{self, PathSubset};
use crate::watch::{Event, Watch};

/// Data that all entries of a benchmark share.
pub struct Context<'a> {
    pub bench: &'a Benchmark,
    pub bed: TestBed,
    /// Mean of the training targets.
    mean: Vec<f64>,
    pub train_links: usize,
    watch: Watch<'a>,
}

impl<'a> Context<'a> {
    /// Makes the data set, or opens it.
    pub fn open(bench: &'a Benchmark, device: Device, watch: Watch<'a>) -> Result<Self> {
        let (config, folder) = (&bench.config, bench.out.join("data"));
        let test = (SplitPart::Test, config.data.test_links);
        let bed = TestBed::with_links(config, device, &folder, test, bench.fresh, watch)?;
        let (limit, seed) = (config.training.links, config.seed);
        let draw = limit.map(|links| Draw { links, seed });
        let target = Target::Normalised(bed.test.normalization);
        let maps = &bed.dataset.manifest().split.train;
        let train = Examples::of_maps(&bed.dataset, maps, target, draw)?;
        if train.list().is_empty() {
            return Err(no_links("training", maps));
        }
        Ok(Self {
            bench,
            mean: train.mean_target(),
            train_links: train.list().len(),
            bed,
            watch,
        })
    }

    /// Makes an entry, or takes it as it was made before.
    pub fn entry(&self, job: &Job) -> Result<Entry> {
        let (bed, config) = (&self.bed, &self.bench.config);
        let (name, kind) = job.title();
        let folder = Path::new("scores").join(stem(&name));
        let training = match job {
            &Job::Model(kind) => {
                let folder = self.bench.out.join("models").join(kind.name());
                Some(bed.training(config, kind, &folder)?)
            }
            Job::Mean
            | Job::LineOfSight
            | Job::StrongestPath
            | Job::Tracer(_)
            | Job::Shipped(_)
            | Job::Weights(..)
            | Job::External(..) => None,
        };
        let made_of = match (job, &training) {
            (_, Some((_, part))) => json!(part.hash),
            (Job::External(_, file), _) => sums([file, &links_file(file)])?,
            (Job::Weights(_, file), _) => sums([file, &file.with_file_name("config.json")])?,
            (&Job::Shipped(kind), _) => {
                let bytes = Shipped::of(kind).map_or(&[][..], |shipped| shipped.bytes);
                json!(sha256_of(bytes))
            }
            (
                Job::Mean | Job::LineOfSight | Job::StrongestPath | Job::Tracer(_) | Job::Model(_),
                None,
            ) => json!([config.training.links, config.seed]),
        };
        let part = Part::new(
            self.bench.out.join(&folder),
            json!({
                "name": name,
                "data": bed.data.hash,
                "test_links": config.data.test_links,
                "seed": config.seed,
                "latency": config.latency,
                // Run times depend on it.
                "threads": rayon::current_num_threads(),
                "made_of": made_of,
            }),
        );
        let state = part.open(bed.fresh, self.watch)?;
        // Scores outlive their model's weights, unless these are to be made anew.
        if state == State::Finished {
            return answer::entry(&part.folder);
        }
        let (test, mean) = (&bed.test, &self.mean);
        let answer = match (job, &training) {
            (Job::Mean, _) => baselines::mean(test, mean),
            (Job::LineOfSight, _) => baselines::line_of_sight(test, &bed.plan, mean)?,
            (&Job::Tracer(interactions), _) => self.trace(PathSubset::Within(interactions))?,
            (Job::StrongestPath, _) => self.trace(PathSubset::Strongest)?,
            (Job::External(_, file), _) => {
                check_links(&bed.dataset, SplitPart::Test, file)?;
                Answer {
                    predictions: test.choose(&bed.dataset, answer::spectra(file)?)?,
                    ..Answer::default()
                }
            }
            (Job::Weights(_, file), _) => {
                self.ask(Trained::load(file, None, None, &bed.device)?)?
            }
            (&Job::Shipped(kind), _) => self.ask(Trained::shipped(kind, &bed.device)?)?,
            (Job::Model(_), Some((plan, training))) => {
                let made = bed.train(plan, training, self.watch)?;
                Answer {
                    training: Some(made),
                    ..bed.ask(&bed.trained(plan, training)?, &config.latency, self.watch)?
                }
            }
            (Job::Model(_), None) => unreachable!("a model has a training"),
        };
        let entry = answer::keep(answer, (&name, kind), test, &self.bench.out, &folder)?;
        part.finish()?;
        Ok(entry)
    }

    fn trace(&self, subset: PathSubset) -> Result<Answer> {
        let batches = &self.bench.config.latency.batches;
        let batch = batches.iter().copied().max().unwrap_or(1);
        tracer::answer(&self.bed.test, &self.bed.plan, subset, &self.mean, batch)
    }

    /// Asks a model that was trained elsewhere, perhaps on data with other statistics.
    fn ask(&self, trained: Trained) -> Result<Answer> {
        let bed = &self.bed;
        for difference in trained.differences(&bed.dataset)? {
            self.watch.tell(Event::Foreign(&difference));
        }
        if let Some(size) = trained.assumed_image_size() {
            self.watch.tell(Event::ImagesAssumed(size));
        }
        let trained = trained
            .with_maps(Some(bed.plan.maps.clone()))
            .for_targets(Target::Normalised(bed.test.normalization));
        bed.ask(&trained, &self.bench.config.latency, self.watch)
    }
}

/// Checksums of a file and of one beside it, which may not be there.
fn sums([file, beside]: [&Path; 2]) -> Result<Value> {
    let beside = beside.is_file().then(|| size_and_sha256(beside));
    let beside = beside.transpose()?.map(|(_, sum)| sum);
    Ok(json!([size_and_sha256(file)?.1, beside]))
}
