//! `cargo xtask report`: measure, and write down what was measured.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::ValueEnum;
use map2aps::maps::{NamedMaps, ranges};
use xtask::{IdList, command_line, machine, say};
use xtask_launch::{child, hand_over};

use crate::{Conditions, MapChoice, Profile, Setup, Study, StudyName, publish, studies_folder};
use crate::{diffraction, fullwave, label, pruning, rounding, tracer};

/// The files, which the options' one line each leaves open.
const WHAT_IS_WRITTEN: &str = "\
What is written into --out:
  numerics.md                       the report, of all studies in the folder beside it
  numerics/STUDY.json               a study: tables, figures, verdicts; settings, machine
  numerics/STUDY-*.csv, *.svg       its data and figures

A study that is not named keeps the files of its last run, and its place in the report. The study of models comes last: it is
built when it is asked for, which takes some minutes the first time. Times are taken on one thread, those of models on all;
they are only worth something on a machine that does nothing else.";

/// Measure error against run time: studies of the tracer, the label, diffraction, pruning and the models.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Study to run; may be repeated [default: all].
    #[arg(long, value_enum)]
    study: Vec<StudyName>,
    /// Amount of measurement: full takes about ten minutes, smoke seconds.
    #[arg(long, value_enum, default_value_t = Profile::Full)]
    profile: Profile,
    /// Maps for the studies of the tracer and of models: synthetic cities, or a folder of RadioMapSeer files.
    #[arg(long, default_value = "synthetic")]
    maps: NamedMaps,
    /// Ids of maps in that folder for the tracer, such as 0,7,30-33 [default: five, from the fewest walls to the most].
    #[arg(long, alias = "map-ids")]
    ids: Option<IdList>,
    /// Seed of terminals, synthetic cities and drawn numbers.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Folder of the report [default: docs/reports; data/report-smoke for smoke].
    #[arg(long)]
    out: Option<PathBuf>,
    /// Folder of the study of models: its data set and trained models, reused where settings agree [default: data/report-models].
    #[arg(long)]
    work: Option<PathBuf>,
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
            true => StudyName::value_variants().to_vec(),
            false => self.study.clone(),
        };
        studies.sort_unstable();
        studies.dedup();
        // Before the first study is written, which may change a file under version control.
        let commit = machine::describe().commit;
        for &study in &studies {
            let mut conditions = Conditions::now(self.profile, self.seed, self.command(study));
            conditions.machine.commit.clone_from(&commit);
            let measured = study.run(&setup);
            let measured = measured.with_context(|| format!("study '{}'", study.name()))?;
            if let Some(measured) = measured {
                measured.write(&folder, conditions.ended())?;
            }
        }
        // If the study of models fails, the others are in the report.
        if studies != [StudyName::Models] {
            say!("report '{}'", publish(&out)?.display())?;
        }
        match studies.contains(&StudyName::Models) {
            true => self.hand_over_models(&out),
            false => Ok(()),
        }
    }

    /// Becomes the study of models, which joins the report itself.
    fn hand_over_models(&self, out: &Path) -> Result<()> {
        let mut args: Vec<OsString> = vec!["report".into(), "--profile".into()];
        args.extend([self.profile.name().into(), "--seed".into()]);
        args.extend([self.seed.to_string().into(), "--out".into(), out.into()]);
        if let NamedMaps::Folder(maps) = &self.maps {
            args.extend(["--maps".into(), maps.into()]);
        }
        if let Some(work) = &self.work {
            args.extend(["--work".into(), work.into()]);
        }
        hand_over(child("xtask-models", &args)).context("cannot start cargo")
    }

    /// The command that measures a study again, as somebody else would type it.
    fn command(&self, study: StudyName) -> String {
        let mut words = vec!["report".to_owned(), "--study".into(), study.name()];
        if let (StudyName::Tracer, NamedMaps::Folder(_)) = (study, &self.maps) {
            words.extend(["--maps".into(), "path/to/maps".into()]);
            if let Some(ids) = &self.ids {
                words.extend(["--ids".into(), ranges(&ids.0)]);
            }
        }
        words.extend(["--profile".into(), self.profile.name()]);
        words.extend(["--seed".into(), self.seed.to_string()]);
        command_line::shown(words)
    }
}

impl StudyName {
    /// Measures a study, with a progress bar; returns none for that of models, which another program measures, as it links candle.
    ///
    /// # Errors
    /// Maps that cannot be read or hold too few outdoor points.
    pub fn run(self, setup: &Setup) -> Result<Option<Study>> {
        let study = match self {
            Self::Tracer => tracer::run(setup),
            Self::Label => label::run(setup),
            Self::Diffraction => diffraction::run(setup),
            Self::Fullwave => fullwave::run(setup),
            Self::Pruning => pruning::run(setup),
            Self::Rounding => rounding::run(),
            Self::Models => return Ok(None),
        };
        study.map(Some)
    }
}
