//! Savings by leaving out: time and label with and without each kind of omission, scene by scene.

mod needless;
mod omissions;

use anyhow::Result;
use xtask::progress;

use super::scenes::typical;
use super::{Setup, Study, StudyName};

/// Measures.
pub fn run(setup: &Setup) -> Result<Study> {
    let scenes = typical(setup.profile, setup.seed)?;
    let mut study = StudyName::Pruning.study("Pruning: what leaving out saves");
    let bar = progress::bar(2 * scenes.len() as u64, "scenes");
    bar.set_message("pruning");
    // Transmitters and receivers of a scene.
    let ends = setup.profile.choose((1, 4), (4, 40));
    omissions::study(setup, ends, &scenes, &bar, &mut study)?;
    needless::study(setup, ends, &scenes, &bar, &mut study)?;
    bar.finish_and_clear();
    Ok(study)
}
