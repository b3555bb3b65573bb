//! Diffraction: the uniform theory and cheaper ones against the exact field at a wedge, and ways to compute the
//! transition function.

mod boundary;
mod methods;
mod transition;
mod wedges;

use anyhow::Result;

use super::{Setup, Study, StudyName};
use crate::progress;

/// Measures.
pub fn run(setup: &Setup) -> Result<Study> {
    let mut study = Study::new(
        StudyName::Diffraction.name(),
        "Diffraction: theory and its computation",
    )
    .at(3);
    study.text(
        "A plane wave at a perfectly conducting wedge, its electric field parallel to the edge: the one case with an exact solution, \
         the eigenfunction series (Bowman, Senior and Uslenghi, 1969), here by Miller's recurrence and checked against SciPy's. \
         Errors are in parts of the incident field. rho is the distance from the edge; at 3.5 GHz, k rho = 100 are 1.4 m.",
    );
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
