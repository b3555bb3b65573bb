//! Remarks on what is allowed and yet deserves a second look: a line each, once a command.

use aps_raytrace::TraceConfig;

use crate::note;

/// Prints a remark when walls are made of a material whose source does not state it for the carrier.
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

/// Prints a remark when there are links with ends nearer to each other than a wavelength.
pub fn tell_near(trace: &TraceConfig, links: u64) {
    if links > 0 {
        note!(
            "note: links with ends less than a wavelength, {:.3} m, apart: {links}; the formulas are those of the far field, \
             their gains are too large",
            trace.wavelength_m()
        );
    }
}
