//! The APS over the angle, and the PDP over the delay.

use aps_label::Protocol;

use crate::chart::{Axis, Chart, Series};
use crate::link::Spectrum;
use crate::theme::Colour;

/// Shown below the maximum \[dB\].
const RANGE_DB: f64 = 45.0;

/// Room above it for badges \[dB\].
const ROOM_DB: f64 = 12.0;

/// Points that a delay profile shows apart from each other.
const FEW: usize = 160;

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

/// The upper envelope of power over delay up to `last_ns` of some spectra, each in its colour.
pub fn delay_chart(last_ns: f64, spectra: &[(Spectrum, Colour)]) -> Chart {
    let levels = spectra.iter().flat_map(|(s, _)| &s.pdp).map(|p| p[1]);
    let top_db = levels.fold(f64::NEG_INFINITY, f64::max);
    let x = Axis::linear("delay [ns]").over(0.0, last_ns);
    let chart = Chart::new(x, level_axis(top_db, false));
    let curve = |(s, colour): &(Spectrum, Colour)| {
        Series::curve_in(s.protocol.to_string(), *colour, envelope(&s.pdp))
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

/// The local maxima of a curve, and its ends: at 200 MHz the side lobes of a pulse lie two pixels apart, and drawn whole they fill
/// what they should outline. One of few points, as the released definition has it, stays whole.
fn envelope(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let level = |i: usize| points.get(i).map_or(f64::NEG_INFINITY, |p| p[1]);
    let is_end = |i: usize| i == 0 || i + 1 == points.len();
    let is_top = |i: usize| level(i) >= level(i - 1).max(level(i + 1));
    let is_kept = |&i: &usize| points.len() <= FEW || is_end(i) || is_top(i);
    (0..points.len())
        .filter(is_kept)
        .map(|i| points[i])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_keeps_the_maxima_and_the_ends() {
        let wave = |i: usize| [i as f64, (2.0 * i as f64).sin()];
        let points: Vec<[f64; 2]> = (0..1000).map(wave).collect();
        let kept = envelope(&points);
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[999]));
        // A maximum each period of pi points.
        assert!((310..=330).contains(&kept.len()), "{}", kept.len());
        assert!(kept[1..kept.len() - 1].iter().all(|p| p[1] > 0.5));
        assert_eq!(envelope(&points[..FEW]), points[..FEW]);
        assert!(envelope(&[]).is_empty());
    }
}
