//! Spectra of one link under either protocol, on common terms: power over the power sent.

use aps_label::{Labeler, PathError, PathSample, Protocol, relative_power};
use aps_metrics::{SpectrumPeaks, spectrum_peaks};

/// An APS and, if the configuration asks for it, a PDP.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Definition of the label.
    pub protocol: Protocol,
    /// Angle of each bin in the protocol's sense \[deg\].
    pub angles_deg: Vec<f64>,
    /// Power in each, over the power sent \[dB\].
    pub aps_db: Vec<f64>,
    /// Delay of the maximum in each \[s\].
    pub delay_s: Vec<f64>,
    /// `[delay in ns, power over the power sent in dB]`; empty unless asked for.
    pub pdp: Vec<[f64; 2]>,
}

impl Spectrum {
    /// The spectrum of the paths of a link; none if the protocol counts none of them.
    pub fn of(labeler: &Labeler, samples: &[PathSample]) -> Result<Option<Self>, PathError> {
        let protocol = labeler.config().protocol;
        let sent_db = protocol.sent_power_db();
        Ok(labeler.label(samples)?.map(|label| Self {
            protocol,
            angles_deg: labeler.angles_deg().to_vec(),
            aps_db: label.aps_db.iter().map(|db| db - sent_db).collect(),
            delay_s: label.aps_delay_s,
            pdp: labeler
                .delays_s()
                .iter()
                .zip(&label.pdp_db)
                .map(|(s, db)| [s * 1e9, db - sent_db])
                .collect(),
        }))
    }

    /// Its maximum \[dB\].
    pub fn top_db(&self) -> f64 {
        let levels = self.aps_db.iter().copied();
        levels.fold(f64::NEG_INFINITY, f64::max)
    }

    /// `[angle in deg, dB]` by ascending angle in the sense of `protocol`, which may be another.
    pub fn points(&self, protocol: Protocol) -> Vec<[f64; 2]> {
        let points = self.angles_deg.iter().zip(&self.aps_db);
        let mut points: Vec<[f64; 2]> = points.map(|(&angle, &db)| [angle, db]).collect();
        if protocol != self.protocol {
            for point in &mut points {
                point[0] = wrap_deg(point[0] + 180.0);
            }
            points.sort_by(|p, q| p[0].total_cmp(&q[0]));
        }
        points
    }

    /// Its dominant peaks, in order of their bins.
    pub fn dominant_peaks(&self) -> SpectrumPeaks {
        dominant_peaks(&self.aps_db, self.protocol)
    }
}

/// The peaks of an APS \[dB\] as a share of its maximum, under the metrics of its protocol; none without bins.
pub fn dominant_peaks(aps_db: &[f64], protocol: Protocol) -> SpectrumPeaks {
    let mut shape = aps_db.to_vec();
    if relative_power(&mut shape).is_err() {
        return SpectrumPeaks::default();
    }
    let definition = aps_metrics::Protocol::from(protocol).definition();
    spectrum_peaks(&shape, &definition).unwrap_or_default()
}

/// The angle at which a protocol shows a path that comes from `arrival_azimuth_rad` \[deg\].
pub fn angle_deg(arrival_azimuth_rad: f64, protocol: Protocol) -> f64 {
    wrap_deg(arrival_azimuth_rad.to_degrees() + turn_deg(protocol))
}

/// Angle of a protocol's axis at which an arrival along +x stands \[deg\].
pub fn turn_deg(protocol: Protocol) -> f64 {
    match protocol {
        Protocol::Released => 180.0,
        Protocol::Paper => 0.0,
    }
}

/// The direction that a uniform linear array along y cannot tell from this one: 180 deg minus it.
/// It has the same sine in either sense of direction.
pub fn mirror_deg(angle_deg: f64) -> f64 {
    wrap_deg(180.0 - angle_deg)
}

/// Shorter way around from one direction to another \[deg\], 0 to 180.
pub fn apart_deg(a: f64, b: f64) -> f64 {
    wrap_deg(a - b).abs()
}

/// Wraps to [-180, 180) deg.
fn wrap_deg(angle: f64) -> f64 {
    (angle + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use aps_label::{Array, LabelConfig};

    #[test]
    fn mirror_has_the_same_sine_and_is_its_own_mirror() {
        let array = LabelConfig::paper().array;
        assert!(matches!(array, Array::UniformLinear { .. }));
        for i in -180..180 {
            let angle = f64::from(i);
            let mirror = mirror_deg(angle);
            assert!((mirror.to_radians().sin() - angle.to_radians().sin()).abs() < 1e-12);
            assert!(apart_deg(mirror_deg(mirror), angle) < 1e-9);
            let response = array.power_response(mirror.to_radians(), angle.to_radians());
            assert!((response - 1.0).abs() < 1e-9, "{angle}: {response}");
        }
    }

    #[test]
    fn protocols_agree_on_where_a_path_comes_from() {
        // One path on a delay of the released grid: nothing is lost between two delays.
        let sample = PathSample {
            delay_s: 10e-6 / 127.0,
            arrival_azimuth_rad: 0.7,
            gain_db: -80.0,
        };
        let mut tops = Vec::new();
        for protocol in [Protocol::Paper, Protocol::Released] {
            let labeler = Labeler::new(&LabelConfig::of(protocol)).unwrap();
            let spectrum = Spectrum::of(&labeler, &[sample]).unwrap().unwrap();
            assert!((spectrum.top_db() + 80.0).abs() < 0.3, "{protocol}");
            // Seen in the paper's sense, one of the two highest bins is at the angle of arrival.
            let mut points = spectrum.points(Protocol::Paper);
            points.sort_by(|p, q| q[1].total_cmp(&p[1]));
            let is_near = |p: &[f64; 2]| apart_deg(p[0], 0.7_f64.to_degrees()) < 1.1;
            assert!(points[..2].iter().any(is_near), "{protocol}: {points:?}");
            tops.push(points[0][0]);
        }
    }
}
