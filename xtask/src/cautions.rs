//! Remarks on what is allowed and yet deserves a second look: a line each, once a command.

use aps_raytrace::TraceConfig;
use aps_raytrace::glam::DVec2;

use crate::note;

/// Says when walls are made of a material whose source does not state it for the carrier.
pub fn tell_carrier(trace: &TraceConfig) {
    if let Some(source) = trace.material_out_of_range() {
        note!(
            "note: {} states concrete for carriers of {:e} to {:e} Hz; its values are continued to {:e} Hz",
            source.document,
            source.carriers_hz.start(),
            source.carriers_hz.end(),
            trace.frequency_hz
        );
    }
}

/// Number of links whose ends are nearer to each other than a wavelength, and not at one point, which is no link.
pub fn count_near(trace: &TraceConfig, links: impl IntoIterator<Item = (DVec2, DVec2)>) -> u64 {
    let wavelength_m = trace.wavelength_m();
    let is_near = |(tx, rx): &(DVec2, DVec2)| tx != rx && tx.distance(*rx) < wavelength_m;
    links.into_iter().filter(is_near).count() as u64
}

/// Says that there are such links, if there are.
pub fn tell_near(trace: &TraceConfig, links: u64) {
    if links > 0 {
        note!(
            "note: links with ends less than a wavelength, {:.3} m, apart: {links}; the formulas are those of the far field, \
             their gains are too large",
            trace.wavelength_m()
        );
    }
}
