//! Diffraction: the uniform theory and cheaper ones against the exact field at a wedge, and ways to compute the
//! transition function.

mod boundary;
mod methods;
mod transition;
mod wedges;

use anyhow::Result;
use xtask::progress;

use super::{Setup, Study, StudyName};

/// Measures.
pub fn run(setup: &Setup) -> Result<Study> {
    let mut study = StudyName::Diffraction.study("Diffraction: theory and its computation");
    let bar = progress::bar(3, "parts");
    bar.set_message("diffract");
    wedges::study(setup, &mut study)?;
    bar.inc(1);
    boundary::study(setup, &mut study)?;
    bar.inc(1);
    transition::study(setup, &mut study)?;
    bar.finish_and_clear();
    Ok(study)
}
