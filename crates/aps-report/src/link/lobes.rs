//! Lobes of a spectrum, and the paths that make them.
//!
//! Q at the bin of a lobe and at the delay of its maximum is a sum over paths, so each path has a
//! share of it. A uniform linear array shows each path twice, at theta and at 180 deg - theta; and again wherever the phases of its
//! elements differ by whole turns, as those of waves from -90 and 90 deg at half a wavelength.

use aps_label::{Array, LabelConfig, Labeler, PathError, PathSample, Protocol};

use super::{Spectrum, angle_deg, apart_deg, mirror_deg};

/// A path with at least this share of a lobe makes it.
const CAUSE: f64 = 0.5;

/// A path with at least this share of a lobe is named.
const LEADING: f64 = 0.2;

/// Lobes are mirror images when they are this near to it, two bins \[deg\].
const MIRROR_TOLERANCE_DEG: f64 = 4.1;

/// Between a path and a sidelobe of a circular array its response falls below this part of the sidelobe's.
const VALLEY: f64 = 0.9;

/// The maximum of a lobe lies at the nearest bin, which of a narrow one may be half a lobe away \[deg\].
const BIN_DEG: f64 = 2.0;

/// Losses of the released label are told up to here \[dB\].
const MOST_LOSS_DB: f64 = 200.0;

/// Direction of a lobe, seen from a path that makes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The path comes from there.
    Own,
    /// The path's mirror image, beyond a linear array.
    Mirror,
    /// A grating lobe: between elements of a linear array the path has other phases there, by whole turns.
    Grating,
    /// A sidelobe of a circular array: it answers the path there, though weaker.
    Sidelobe,
}

impl Side {
    /// `own`, `mirror`, `grating` or `sidelobe`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Mirror => "mirror",
            Self::Grating => "grating",
            Self::Sidelobe => "sidelobe",
        }
    }

    /// The side of a path from `own_deg` on which an array sees a lobe at `angle_deg`, both in the sense of one protocol.
    pub fn of(array: &Array, angle_deg: f64, own_deg: f64) -> Self {
        let &Array::UniformLinear {
            spacing_wavelengths,
            ..
        } = array
        else {
            let response = |deg: f64| array.power_response(deg.to_radians(), own_deg.to_radians());
            let apart = (angle_deg - own_deg + 180.0).rem_euclid(360.0) - 180.0;
            let on_the_way =
                (1..=180).map(|part| response(own_deg + apart * f64::from(part) / 180.0));
            let has_valley = on_the_way.fold(1.0, f64::min) < VALLEY * response(angle_deg);
            return match has_valley && apart.abs() > BIN_DEG {
                true => Self::Sidelobe,
                false => Self::Own,
            };
        };
        let [there, own] = [angle_deg, own_deg].map(|deg| deg.to_radians().sin());
        if (spacing_wavelengths * (there - own)).abs() > 0.5 {
            Self::Grating
        } else if apart_deg(mirror_deg(own_deg), angle_deg) < apart_deg(own_deg, angle_deg) {
            Self::Mirror
        } else {
            Self::Own
        }
    }
}

/// A dominant peak of an APS and what it is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobe {
    /// Place of its maximum \[deg\], in the sense of the spectrum's protocol.
    pub angle_deg: f64,
    /// Its height over the power sent \[dB\].
    pub level_db: f64,
    /// Paths by their share of its power, largest first; the shares of all paths add up to 1.
    pub shares: Vec<(usize, f64)>,
    /// Its side of the path with the largest share.
    pub side: Side,
    /// Its mirror image among the lobes, by index, if the array makes one and it is a dominant
    /// peak too.
    pub twin: Option<usize>,
}

impl Lobe {
    /// Angle of its mirror image \[deg\]; `None` if that is not apart from it, as near -90 and 90 deg.
    pub fn mirror_deg(&self) -> Option<f64> {
        let mirror = mirror_deg(self.angle_deg);
        (apart_deg(mirror, self.angle_deg) > MIRROR_TOLERANCE_DEG).then_some(mirror)
    }

    /// The path that makes most of it.
    pub fn cause(&self) -> Option<usize> {
        let first = self.shares.first();
        first.filter(|s| s.1 >= CAUSE).map(|s| s.0)
    }

    /// Paths worth naming, with their shares.
    pub fn leading(&self) -> impl Iterator<Item = (usize, f64)> {
        let is_leading = |s: &(usize, f64)| s.1 >= LEADING;
        self.shares.iter().copied().filter(is_leading)
    }

    /// Share of a path.
    pub fn share_of(&self, path: usize) -> f64 {
        let found = self.shares.iter().find(|s| s.0 == path);
        found.map_or(0.0, |s| s.1)
    }
}

/// The dominant peaks of a spectrum that these paths make, by ascending angle.
pub fn lobes(
    labeler: &Labeler,
    samples: &[PathSample],
    spectrum: &Spectrum,
) -> Result<Vec<Lobe>, PathError> {
    let protocol = labeler.config().protocol;
    let peaks = spectrum.dominant_peaks();
    let mut lobes = Vec::new();
    for peak in peaks.dominant() {
        let angle = spectrum.angles_deg[peak.bin];
        let delay_s = spectrum.delay_s[peak.bin];
        let part = |path: &PathSample| labeler.q(&[*path], delay_s, angle.to_radians());
        let parts = samples.iter().map(part).collect::<Result<Vec<f64>, _>>()?;
        let total: f64 = parts.iter().sum();
        let mut shares: Vec<(usize, f64)> = parts
            .into_iter()
            .map(|power| if total > 0.0 { power / total } else { 0.0 })
            .enumerate()
            .collect();
        shares.sort_by(|p, q| q.1.total_cmp(&p.1));
        let own = angle_deg(samples[shares[0].0].arrival_azimuth_rad, protocol);
        lobes.push(Lobe {
            angle_deg: angle,
            level_db: spectrum.aps_db[peak.bin],
            side: Side::of(&labeler.config().array, angle, own),
            shares,
            twin: None,
        });
    }
    if has_mirrors(labeler.config()) {
        let angles: Vec<f64> = lobes.iter().map(|lobe| lobe.angle_deg).collect();
        for (i, lobe) in lobes.iter_mut().enumerate() {
            let Some(mirror_deg) = lobe.mirror_deg() else {
                continue;
            };
            let away = |&j: &usize| apart_deg(angles[j], mirror_deg);
            let others = (0..angles.len()).filter(|&j| j != i);
            let nearest = others.min_by(|a, b| away(a).total_cmp(&away(b)));
            lobe.twin = nearest.filter(|j| away(j) <= MIRROR_TOLERANCE_DEG);
        }
    }
    Ok(lobes)
}

/// Tells if the array makes a second lobe for each path.
pub fn has_mirrors(label: &LabelConfig) -> bool {
    matches!(label.array, Array::UniformLinear { .. })
}

/// Loss of a path in a label that takes its maximum over sampled delays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SampledLoss {
    /// Its delay lies between two of the axis: lowered, by nothing on one of them.
    Sampled {
        /// The loss \[dB\].
        lost_db: f64,
    },
    /// Its delay lies beyond the axis, and is lowered.
    Beyond {
        /// The end of the axis \[ns\].
        last_ns: f64,
        /// The loss \[dB\].
        lost_db: f64,
    },
    /// Its loss is outside of the range that the protocol counts.
    Dropped {
        /// The loss of the path \[dB\].
        loss_db: f64,
    },
}

/// Returns the loss of a path in the label of `released`, a labeler of that protocol.
pub fn sampled_loss(released: &Labeler, path: &PathSample) -> Result<SampledLoss, PathError> {
    debug_assert_eq!(released.config().protocol, Protocol::Released);
    let angle_rad = angle_deg(path.arrival_azimuth_rad, Protocol::Released).to_radians();
    let power = |tau_s: f64| released.q(&[*path], tau_s, angle_rad);
    let whole = power(path.delay_s)?;
    if whole == 0.0 {
        let loss_db = -path.gain_db;
        return Ok(SampledLoss::Dropped { loss_db });
    }
    let mut best: f64 = 0.0;
    for &tau_s in released.delays_s() {
        best = best.max(power(tau_s)?);
    }
    let lost_db = (-10.0 * (best / whole).log10()).clamp(0.0, MOST_LOSS_DB);
    let last_s = released.delays_s().last().copied().unwrap_or(0.0);
    if path.delay_s > last_s {
        let last_ns = last_s * 1e9;
        Ok(SampledLoss::Beyond { last_ns, lost_db })
    } else {
        Ok(SampledLoss::Sampled { lost_db })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn sample(delay_ns: f64, angle_deg: f64, gain_db: f64) -> PathSample {
        PathSample {
            delay_s: delay_ns * 1e-9,
            arrival_azimuth_rad: angle_deg.to_radians(),
            gain_db,
        }
    }

    fn explain(config: &LabelConfig, samples: &[PathSample]) -> (Spectrum, Vec<Lobe>) {
        let labeler = Labeler::new(config).unwrap();
        let spectrum = Spectrum::of(&labeler, samples).unwrap().unwrap();
        let lobes = lobes(&labeler, samples, &spectrum).unwrap();
        (spectrum, lobes)
    }

    #[test]
    fn two_paths_far_apart_make_two_lobes_and_their_mirrors() {
        // On delays of the released axis, so that both protocols see them alike.
        let step_ns = 1000.0 / 127.0;
        let samples = [
            sample(38.0 * step_ns, 20.0, -80.0),
            sample(64.0 * step_ns, -50.0, -82.0),
        ];
        for protocol in [Protocol::Paper, Protocol::Released] {
            let (_, lobes) = explain(&LabelConfig::of(protocol), &samples);
            assert_eq!(lobes.len(), 4, "{protocol}: {lobes:?}");
            for (path, s) in samples.iter().enumerate() {
                let own = angle_deg(s.arrival_azimuth_rad, protocol);
                let made: Vec<&Lobe> = lobes.iter().filter(|l| l.cause() == Some(path)).collect();
                assert_eq!(made.len(), 2);
                for lobe in made {
                    let expected = match lobe.side {
                        Side::Own => own,
                        Side::Mirror => mirror_deg(own),
                        Side::Grating | Side::Sidelobe => panic!("{lobe:?}"),
                    };
                    assert!(
                        apart_deg(lobe.angle_deg, expected) <= 1.1,
                        "{protocol} {lobe:?}"
                    );
                    let twin = &lobes[lobe.twin.expect("both are dominant")];
                    assert_eq!(twin.cause(), Some(path));
                    assert_ne!(twin.side, lobe.side);
                }
            }
        }
    }

    #[test]
    fn shares_are_those_of_the_formula() {
        let samples = [
            sample(300.0, 20.0, -80.0),
            sample(303.0, 26.0, -83.0),
            sample(700.0, 150.0, -79.0),
        ];
        let (spectrum, lobes) = explain(&LabelConfig::paper(), &samples);
        for lobe in &lobes {
            let mut angles = spectrum.angles_deg.iter();
            let bin = angles.position(|a| *a == lobe.angle_deg).unwrap();
            let tau_s = spectrum.delay_s[bin];
            // The formula, term by term: p sinc^2 (sin(N psi) / (N sin psi))^2.
            let term = |s: &PathSample| {
                let x = PI * 200e6 * (tau_s - s.delay_s);
                let pulse = if x == 0.0 { 1.0 } else { (x.sin() / x).powi(2) };
                let psi =
                    0.5 * PI * (lobe.angle_deg.to_radians().sin() - s.arrival_azimuth_rad.sin());
                let beam = match psi.sin().abs() < 1e-12 {
                    true => 1.0,
                    false => ((16.0 * psi).sin() / (16.0 * psi.sin())).powi(2),
                };
                10_f64.powf(s.gain_db / 10.0) * pulse * beam
            };
            let total: f64 = samples.iter().map(term).sum();
            assert!(
                (10.0 * total.log10() - lobe.level_db).abs() < 1e-6,
                "{lobe:?}"
            );
            for (path, s) in samples.iter().enumerate() {
                assert!(
                    (lobe.share_of(path) - term(s) / total).abs() < 1e-9,
                    "{lobe:?}"
                );
            }
        }
    }

    #[test]
    fn lobe_of_equal_paths_has_no_single_cause() {
        let samples = [30.0, 30.5, 31.0].map(|angle| sample(400.0, angle, -90.0));
        let (_, lobes) = explain(&LabelConfig::paper(), &samples);
        let is_shared = |l: &Lobe| l.cause().is_none() && l.leading().count() == 3;
        assert!(lobes.iter().all(is_shared), "{lobes:?}");
    }

    #[test]
    fn a_path_from_near_the_end_of_the_array_has_a_grating_lobe_at_the_other() {
        for protocol in [Protocol::Paper, Protocol::Released] {
            let (_, lobes) = explain(&LabelConfig::of(protocol), &[sample(300.0, 71.0, -80.0)]);
            let own = angle_deg(71_f64.to_radians(), protocol);
            let mut sides = Vec::new();
            for lobe in &lobes {
                assert_eq!(lobe.cause(), Some(0));
                let expected = match lobe.side {
                    Side::Own => own,
                    Side::Mirror => mirror_deg(own),
                    Side::Grating => -90.0 * own.signum(),
                    Side::Sidelobe => panic!("{lobe:?}"),
                };
                assert!(apart_deg(lobe.angle_deg, expected) < 3.0, "{lobe:?}");
                let has_twin = lobe.side != Side::Grating;
                assert_eq!(
                    (lobe.mirror_deg().is_some(), lobe.twin.is_some()),
                    (has_twin, has_twin)
                );
                sides.push(lobe.side);
            }
            assert!(
                sides.contains(&Side::Grating) && sides.len() == 3,
                "{lobes:?}"
            );
        }
        // Two wavelengths apart, a linear array sees a path from its side every half unit of the sine.
        let wide = Array::UniformLinear {
            elements: 16,
            spacing_wavelengths: 2.0,
        };
        for (angle, side) in [
            (0.0, Side::Own),
            (179.0, Side::Mirror),
            (30.0, Side::Grating),
        ] {
            assert_eq!(Side::of(&wide, angle, 1.0), side);
        }
    }

    #[test]
    fn a_circular_array_has_sidelobes_and_no_mirrors() {
        // Where elements are half a wavelength apart, a path has more dominant peaks than its own: four answer nearly as well at the back.
        for (elements, radius_wavelengths, sidelobes) in
            [(16, 1.0, 0), (16, 4.0 / PI, 1), (4, 1.0 / PI, 1)]
        {
            let config = LabelConfig {
                array: Array::UniformCircular {
                    elements,
                    radius_wavelengths,
                },
                ..LabelConfig::paper()
            };
            let (_, lobes) = explain(&config, &[sample(300.0, 20.0, -80.0)]);
            let is_own = |l: &&Lobe| l.side == Side::Own;
            let own: Vec<&Lobe> = lobes.iter().filter(is_own).collect();
            assert_eq!((own.len(), lobes.len()), (1, 1 + sidelobes), "{lobes:?}");
            let is_there = apart_deg(
                own[0].angle_deg,
                angle_deg(20_f64.to_radians(), Protocol::Paper),
            );
            assert!(is_there <= BIN_DEG, "{lobes:?}");
            assert!(lobes.iter().all(|l| l.twin.is_none()));
        }
    }

    #[test]
    fn losses_tell_what_the_sampled_delays_do() {
        let released = Labeler::new(&LabelConfig::released()).unwrap();
        let step_ns = 1000.0 / 127.0;
        let of = |delay_ns: f64, gain_db: f64| {
            sampled_loss(&released, &sample(delay_ns, 33.0, gain_db)).unwrap()
        };
        let sampled = |delay_ns: f64| match of(delay_ns, -90.0) {
            SampledLoss::Sampled { lost_db } => lost_db,
            other => panic!("{other:?}"),
        };
        assert!(sampled(40.0 * step_ns) < 1e-9);
        // Half-way: sinc^2 of half a step.
        let lost_db = sampled(40.5 * step_ns);
        let x = PI * 200e6 * 0.5 * step_ns * 1e-9;
        let expected_db = -20.0 * (x.sin() / x).abs().log10();
        assert!((lost_db - expected_db).abs() < 1e-6, "{lost_db}");
        let SampledLoss::Beyond { last_ns, lost_db } = of(1013.0, -90.0) else {
            panic!()
        };
        assert!(last_ns == 1000.0 && lost_db > 15.0, "{lost_db}");
        assert_eq!(of(400.0, -311.0), SampledLoss::Dropped { loss_db: 311.0 });
        assert_eq!(of(400.0, 0.0), SampledLoss::Dropped { loss_db: 0.0 });
    }
}
