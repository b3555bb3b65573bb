//! The APS over the angle, and the PDP over the delay.

use aps_label::Protocol;

use crate::chart::{Axis, Chart, Series};
use crate::link::Spectrum;
use crate::theme::Colour;

/// Shown below the maximum \[dB\].
const RANGE_DB: f64 = 45.0;

/// Room above it for badges \[dB\].
const ROOM_DB: f64 = 12.0;

/// Axes for spectra of a link: angles in the sense of `protocol`, powers below `top_db`, with room
/// for badges above or not.
pub fn axes(protocol: Protocol, top_db: f64, with_room: bool) -> Chart {
    Chart::new(azimuth(protocol), level_axis(top_db, with_room))
}

/// The axis of angles in the sense of a protocol.
pub fn azimuth(protocol: Protocol) -> Axis {
    Axis::azimuth(match protocol {
        Protocol::Released => "direction of travel at the receiver [deg]",
        Protocol::Paper => "angle of arrival [deg]",
    })
}

/// A curve over these axes, in the sense of `protocol`.
pub fn curve(spectrum: &Spectrum, protocol: Protocol, colour: Colour) -> Series {
    let name = spectrum.protocol.to_string();
    Series::curve_in(name, colour, spectrum.points(protocol))
}

/// Power over delay up to `last_ns` of some spectra, each in its colour.
pub fn delay_chart(last_ns: f64, spectra: &[(Spectrum, Colour)]) -> Chart {
    let levels = spectra.iter().flat_map(|(s, _)| &s.pdp).map(|p| p[1]);
    let top_db = levels.fold(f64::NEG_INFINITY, f64::max);
    let x = Axis::linear("delay [ns]").over(0.0, last_ns);
    let chart = Chart::new(x, level_axis(top_db, false));
    let curve = |(s, colour): &(Spectrum, Colour)| {
        Series::curve_in(s.protocol.to_string(), *colour, s.pdp.clone())
    };
    spectra.iter().map(curve).fold(chart, Chart::with)
}

/// The part of a power axis that matters.
fn level_axis(top_db: f64, with_room: bool) -> Axis {
    let top_db = if top_db.is_finite() { top_db } else { 0.0 };
    let room = if with_room { ROOM_DB } else { 2.0 };
    Axis::linear("power over power sent [dB]")
        .over((top_db - RANGE_DB).floor(), (top_db + room).ceil())
        .every(10.0)
}
