//! `cargo xtask report`: measure, and write down what was measured.

use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::command_line;
use crate::machine;
use crate::maps::{IdList, MapSource};
use crate::studies::{Conditions, MapChoice, Profile, Setup, StudyName, publish, studies_folder};

/// What the options' one line each leaves open.
const WHAT_IS_WRITTEN: &str = "\
What is written into --out:
  numerics.md                       the report, of all studies in the folder beside it
  numerics/STUDY.json               what a study says, and how it came about
  numerics/STUDY-*.csv, *.svg       its data and figures

A study that is not named keeps the files of its last run, and its place in the report. Times are taken on one thread; they
are only worth something on a machine that does nothing else.";

/// Measure error against run time: studies of the tracer, the label, diffraction and pruning.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Study to run; may be repeated [default: all].
    #[arg(long, value_enum)]
    study: Vec<StudyName>,
    /// How much to measure: full takes about ten minutes, smoke seconds.
    #[arg(long, value_enum, default_value_t = Profile::Full)]
    profile: Profile,
    /// Maps for the study of the tracer: synthetic cities of five densities, or a folder of RadioMapSeer files.
    #[arg(long, default_value = "synthetic")]
    maps: MapSource,
    /// Ids of maps in that folder, such as 0,7,30-33 [default: five, from the fewest walls to the most].
    #[arg(long, alias = "map-ids")]
    ids: Option<IdList>,
    /// Seed of terminals, synthetic cities and drawn numbers.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Folder of the report [default: docs/reports; data/report-smoke for smoke].
    #[arg(long)]
    out: Option<PathBuf>,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let usual = self.profile.choose("data/report-smoke", "docs/reports");
        let out = self.out.clone().unwrap_or_else(|| usual.into());
        let folder = studies_folder(&out);
        let setup = Setup {
            profile: self.profile,
            seed: self.seed,
            maps: MapChoice::new(self.maps.clone(), self.ids.clone())?,
        };
        let mut studies = match self.study.is_empty() {
            true => StudyName::ALL.to_vec(),
            false => self.study.clone(),
        };
        studies.sort_unstable();
        studies.dedup();
        // Before the first study is written, which may change a file under version control.
        let commit = machine::describe().commit;
        for study in studies {
            let mut conditions = Conditions::now(self.profile, self.seed, self.command(study));
            conditions.machine.commit.clone_from(&commit);
            let measured = study.run(&setup);
            let measured = measured.with_context(|| format!("study '{}'", study.name()))?;
            measured.write(&folder, conditions.ended())?;
        }
        println!("report '{}'", publish(&out)?.display());
        Ok(())
    }

    /// The command that measures a study again, as somebody else would type it.
    fn command(&self, study: StudyName) -> String {
        let mut words = vec!["report".to_owned(), "--study".into(), study.name().into()];
        if let (StudyName::Tracer, MapSource::Folder(_)) = (study, &self.maps) {
            words.extend(["--maps".into(), "path/to/maps".into()]);
            if let Some(ids) = &self.ids {
                words.extend(["--ids".into(), crate::maps::ranges(&ids.0)]);
            }
        }
        words.extend(["--profile".into(), self.profile.name().into()]);
        words.extend(["--seed".into(), self.seed.to_string()]);
        command_line::shown(words)
    }
}
