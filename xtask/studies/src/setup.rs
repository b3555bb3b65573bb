//! The studies, and settings of all of them.

use clap::ValueEnum;

use crate::profile::{Profile, name_of};
use crate::scenes::MapChoice;
use crate::study::Study;

/// The studies, in the order in which they run and, but for that of models, stand in the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum StudyName {
    /// Limits of the tracer: label error against time a link.
    Tracer,
    /// Delay axis of the label: error against time a label.
    Label,
    /// The diffraction coefficient against exact solutions.
    Diffraction,
    /// The tracer against the solution of the wave equation in small scenes.
    Fullwave,
    /// Savings by leaving out, and their costs.
    Pruning,
    /// Worst errors of the kernels in ulps.
    Rounding,
    /// Precision, batch and image size of models: error against time an answer.
    Models,
}

/// Settings of all studies.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Amount of measurement.
    pub profile: Profile,
    /// Seed of terminals, synthetic cities and drawn numbers.
    pub seed: u64,
    /// The maps of the study of the tracer.
    pub maps: MapChoice,
}

impl StudyName {
    /// Name on the command line and in the names of files.
    pub fn name(self) -> String {
        name_of(&self)
    }

    /// The study without anything in it, in the place of its name.
    pub(crate) fn study(self, title: &str) -> Study {
        Study {
            place: 1 + self as u32,
            ..Study::new(&self.name(), title)
        }
    }
}
