//! The study of models in the numerical report: costs of precision, batches and image size.

mod precision;
mod resolution;

use std::path::PathBuf;

use anyhow::Result;
use xtask::say;
use xtask_studies::{Conditions, Profile, Study, publish, studies_folder};

/// Place in the report: behind diffraction, before pruning.
const PLACE: u32 = 4;

/// Measure what precision, size of batch and size of image cost a model in error and in time.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Amount of measurement: full takes about ten minutes, smoke seconds.
    #[arg(long, value_enum)]
    profile: Profile,
    /// Folder of RadioMapSeer files to learn from, or synthetic.
    #[arg(long, default_value = "synthetic")]
    maps: String,
    /// Seed of weights, terminals and synthetic cities.
    #[arg(long)]
    seed: u64,
    /// Folder of the report.
    #[arg(long)]
    out: PathBuf,
    /// Folder of the data set and the trained models, reused where settings agree [default: data/report-models].
    #[arg(long)]
    work: Option<PathBuf>,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let conditions = Conditions::now(self.profile, self.seed, self.command());
        let mut study = Study::new("models", "Models: precision, batches, images");
        study.place = PLACE;
        let threads = rayon::current_num_threads();
        study.section.text(format!(
            "Times of a pass on {threads} threads, images ready."
        ));
        precision::study(self.profile, self.seed, &mut study)?;
        let work = self.work.clone();
        let work = work.unwrap_or_else(|| "data/report-models".into());
        resolution::study(self.profile, self.seed, &self.maps, &work, &mut study)?;
        study.write(&studies_folder(&self.out), conditions.ended())?;
        say!("report '{}'", publish(&self.out)?.display())?;
        Ok(())
    }

    /// The command that measures it again, as somebody else would type it.
    fn command(&self) -> String {
        let maps = match self.maps.as_str() {
            "synthetic" => "",
            _ => " --maps path/to/maps",
        };
        let (profile, seed) = (self.profile.name(), self.seed);
        format!("cargo xtask report --study models{maps} --profile {profile} --seed {seed}")
    }
}
