//! The entries to score, in their order.

use std::path::PathBuf;

use aps_model::ModelKind;
use aps_model::weights::Shipped;
use aps_report::benchmark::{EntryKind, MEAN};

use crate::config::Config;
use crate::error::{Error, Result};

/// Interactions of the tracer whose paths are the lines of sight.
pub const SIGHT: usize = 0;

/// Entry to score.
#[derive(Debug, Clone)]
pub enum Job {
    /// The mean of the training targets.
    Mean,
    /// One straight path.
    LineOfSight,
    /// The strongest path of each link.
    StrongestPath,
    /// The tracer with at most so many interactions on a path.
    Tracer(usize),
    /// A model trained here.
    Model(ModelKind),
    /// Weights that come with the program.
    Shipped(ModelKind),
    /// Weights that were trained before.
    Weights(String, PathBuf),
    /// Predictions from elsewhere.
    External(String, PathBuf),
}

impl Job {
    /// Name in tables, and kind.
    pub fn title(&self) -> (String, EntryKind) {
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

/// The jobs of a benchmark.
///
/// # Errors
/// Something from elsewhere that has the name of another entry.
pub fn of(config: &Config) -> Result<Vec<Job>> {
    let mut jobs = vec![Job::Mean, Job::LineOfSight, Job::Tracer(SIGHT)];
    // Beyond the limits of the labels there are no further paths.
    let most = config.data.limits.config().max_interactions;
    let interactions = config.tracer.interactions.iter();
    jobs.extend(interactions.map(|&interactions| Job::Tracer(interactions.min(most))));
    jobs.push(Job::StrongestPath);
    jobs.extend(config.kinds().into_iter().map(Job::Model));
    jobs.extend(Shipped::all().map(|shipped| Job::Shipped(shipped.label.kind)));
    let weights = config.weights.iter();
    jobs.extend(weights.map(|(name, file)| Job::Weights(name.clone(), file.clone())));
    let external = config.external.iter();
    jobs.extend(external.map(|(name, file)| Job::External(name.clone(), file.clone())));
    // A name comes twice for a tracer that is asked for twice, which is made once, or for something from elsewhere.
    let mut unique: Vec<Job> = Vec::new();
    for job in jobs {
        let (name, _) = job.title();
        let is_taken = unique.iter().any(|one| stem(&one.title().0) == stem(&name));
        if let (true, Job::External(..) | Job::Weights(..)) = (is_taken, &job) {
            let told = format!("'{name}' is the name of another entry; choose another");
            return Err(Error::Setting(told));
        }
        if !is_taken {
            unique.push(job);
        }
    }
    Ok(unique)
}

/// The name of an entry as that of a folder.
pub fn stem(name: &str) -> String {
    let plain = |c: char| match c.is_ascii_alphanumeric() {
        true => c.to_ascii_lowercase(),
        false => '-',
    };
    name.chars().map(plain).collect()
}
