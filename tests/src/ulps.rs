//! Largest error of each numerical kernel, measured against its value in 32 digits.
//!
//! The unit is the ulp, 2^-52 of the value: a correctly rounded result is off by at most 0.5. Where
//! a kernel has zeros a relative error says nothing there; such kernels are measured in ulps of their
//! full scale, and relative only where the value is at least a millionth of it.
//!
//! Arguments are fixed, so the same numbers come out of every run.

use aps_label::{
    Array, LabelConfig, Labeler, MeanStd, Moments, Normalization, PathSample, relative_power,
};
use aps_metrics::{DataRange, Metric, Protocol as Scoring, Scorer};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{
    Complex64, Material, SPEED_OF_LIGHT_M_PER_S, TraceConfig, Tracer, VACUUM_PERMITTIVITY_F_PER_M,
    transition, utd,
};
use serde::Serialize;

use crate::double_complex::{self, DoubleComplex, spherical_wave};
use crate::double_double::{DoubleDouble, PI, dd};
use crate::label::{array_response, linear, path, q, squared_sinc};
use crate::shapes::scene;

/// Measured errors of one kernel, whose scale is 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct KernelError {
    /// The crate it belongs to.
    pub of: &'static str,
    /// Quantity that it computes.
    pub kernel: &'static str,
    /// Largest error in ulps of the value, where that is at least 1e-6 of the scale.
    pub relative_ulps: f64,
    /// Largest error anywhere, in ulps of the scale.
    pub absolute_ulps: f64,
    /// Argument at which the relative one was met.
    pub at: String,
    /// Number of arguments tried.
    pub points: usize,
}

impl KernelError {
    fn new(of: &'static str, kernel: &'static str) -> Self {
        Self {
            of,
            kernel,
            ..Self::default()
        }
    }

    fn add(&mut self, error: DoubleDouble, size: DoubleDouble, at: impl FnOnce() -> String) {
        self.points += 1;
        let ulps = error.abs().to_f64() / f64::EPSILON;
        self.absolute_ulps = self.absolute_ulps.max(ulps);
        let size = size.abs().to_f64();
        if size >= 1e-6 && ulps / size > self.relative_ulps {
            (self.relative_ulps, self.at) = (ulps / size, at());
        }
    }

    fn real(&mut self, got: f64, want: DoubleDouble, at: impl FnOnce() -> String) {
        self.add(dd(got) - want, want, at);
    }

    fn complex(&mut self, got: Complex64, want: DoubleComplex, at: impl FnOnce() -> String) {
        self.add((DoubleComplex::from(got) - want).norm(), want.norm(), at);
    }
}

/// Measures every kernel: a second or two.
#[must_use]
pub fn worst_errors() -> Vec<KernelError> {
    let mut all = vec![transition_function(), diffraction_coefficient()];
    all.extend([reflection_coefficient(), free_space()]);
    all.extend([delay_kernel(), continuous_maximum()]);
    let line = linear(16, 0.5);
    let circle = Array::UniformCircular {
        elements: 15,
        radius_wavelengths: 1.0,
    };
    all.extend([
        array_direct("array response, linear, direct", line),
        array_direct("array response, circular, direct", circle),
        array_tables("array response, linear, tables", line),
        array_tables("array response, circular, tables", circle),
    ]);
    all.extend([decibels(), powers(), standardised(), deviation()]);
    all.extend(scores());
    all
}

fn transition_function() -> KernelError {
    let mut meter = KernelError::new("aps-raytrace", "transition function F");
    for i in -63..=63 {
        let x = 10_f64.powf(f64::from(i) / 7.0);
        let want = double_complex::transition(dd(x));
        meter.complex(transition::transition(x), want, || format!("x = {x:.3e}"));
    }
    meter
}

fn diffraction_coefficient() -> KernelError {
    let k = std::f64::consts::TAU * 3.5e9 / SPEED_OF_LIGHT_M_PER_S;
    let minus_one = Complex64::new(-1.0, 0.0);
    // |D| is at most 2 sqrt(L).
    let mut meter = KernelError::new("aps-raytrace", "diffraction coefficient D / sqrt(L)");
    for n in [1.1, 1.5, 1.9, 2.0] {
        for distance_m in [0.05, 5.0, 500.0] {
            for (i, j) in [(0.11, 0.93), (0.25, 0.61), (0.4, 0.47), (0.07, 0.12)] {
                let open = n * std::f64::consts::PI;
                let phi = [i * open, j * open];
                let got = utd::diffraction_coefficient(
                    n, k, distance_m, phi[0], phi[1], minus_one, minus_one,
                );
                let want = double_complex::diffraction(dd(n), dd(k), dd(distance_m), phi.map(dd));
                let root = dd(distance_m).sqrt();
                let off = (DoubleComplex::from(got) - want).norm();
                let [p, q] = phi;
                meter.add(off / root, want.norm() / root, || {
                    format!("n = {n}, L = {distance_m} m, phi = {p:.3}, {q:.3}")
                });
            }
        }
    }
    meter
}

fn reflection_coefficient() -> KernelError {
    let mut meter = KernelError::new("aps-raytrace", "reflection coefficient");
    let omega = std::f64::consts::TAU * 3.5e9;
    for (eps, sigma) in [(5.24, 0.123), (1.000_001, 0.0), (3.0, 1e-4), (1.0, 6e7)] {
        let material = Material::Dielectric {
            relative_permittivity: eps,
            conductivity_s_per_m: sigma,
        };
        let reflector = material.at(3.5e9);
        // The loss as a double: what the kernel is given.
        let loss = sigma / (omega * VACUUM_PERMITTIVITY_F_PER_M);
        let permittivity = DoubleComplex::new(dd(eps), dd(-loss));
        for i in 0..=400 {
            let cos = if i <= 200 {
                f64::from(i) / 200.0
            } else {
                10_f64.powf(-f64::from(i - 200) / 20.0)
            };
            let want = double_complex::reflection(permittivity, dd(cos));
            meter.complex(reflector.reflection(cos), want, || {
                format!("eps = {eps}, sigma = {sigma} S/m, cos = {cos:.3e}")
            });
        }
    }
    meter
}

/// A direct ray, as the tracer yields it: length, spreading and phase.
fn free_space() -> KernelError {
    let mut meter = KernelError::new("aps-raytrace", "gain of free space, phase included");
    let scene = scene(&[]);
    let tracer = Tracer::new(&scene, TraceConfig::default()).expect("default settings");
    for i in 0..200 {
        let rx = DVec2::from_angle(0.3 * f64::from(i)) * 10_f64.powf(f64::from(i % 60) / 20.0);
        let link = tracer.trace(DVec2::ZERO, rx).expect("two places");
        let want = spherical_wave(DoubleDouble::hypot(dd(rx.x), dd(rx.y)), 3.5e9);
        let off = (DoubleComplex::from(link.paths[0].gain) - want).norm();
        // Relative to the amplitude.
        meter.add(off / want.norm(), DoubleDouble::ONE, || {
            format!("{:.3} m", rx.length())
        });
    }
    meter
}

fn labeler(array: Array, base: LabelConfig) -> Labeler {
    let config = LabelConfig { array, ..base };
    Labeler::new(&config).expect("settings in range")
}

/// sinc^2(f_s tau), one term by the formula.
fn delay_kernel() -> KernelError {
    let mut meter = KernelError::new("aps-label", "delay kernel, direct");
    let faster = LabelConfig {
        sampling_rate_hz: 1e9,
        ..LabelConfig::paper()
    };
    let labeler = labeler(linear(1, 0.5), faster);
    for i in 0..4000 {
        let tau = 1e-12 * f64::from(i * i % 7919) * 10_f64.powf(f64::from(i % 9) - 3.0);
        let got = labeler.q(&[path(0.0, 0.0, 0.0)], tau, 0.0).expect("finite");
        // The argument as the kernel gets it.
        let want = squared_sinc(dd(1e9 * tau));
        meter.real(got, want, || format!("f_s tau = {:.6}", 1e9 * tau));
    }
    meter
}

/// The largest of two pulses' sum over a continuous delay, which is a polynomial's top, compared with
/// the sum in 32 digits at the delay found.
fn continuous_maximum() -> KernelError {
    let mut meter = KernelError::new("aps-label", "maximum over a continuous delay");
    let labeler = labeler(linear(1, 0.5), LabelConfig::paper());
    for i in 0..200 {
        let apart = 0.01 * f64::from(i) / 200e6;
        let paths = [path(3e-7, 0.0, 0.0), path(3e-7 + apart, 0.0, -3.0)];
        let label = labeler.label(&paths).expect("finite").expect("two paths");
        let tau = dd(label.aps_delay_s[0]);
        let want = q(labeler.config(), &paths, tau, DoubleDouble::ZERO);
        let got = dd(label.aps_db[0]).from_decibel();
        meter.add(got - want, want, || {
            format!("{:.2} pulses apart", 0.01 * f64::from(i))
        });
    }
    meter
}

fn array_direct(name: &'static str, array: Array) -> KernelError {
    let mut meter = KernelError::new("aps-label", name);
    for i in 0..600 {
        let theta = f64::from(i) * 0.013 - 3.1;
        let theta_k = f64::from(i * 7 % 60) * 0.1 - 2.9;
        let want = array_response(&array, dd(theta) / PI, dd(theta_k) / PI);
        meter.real(array.power_response(theta, theta_k), want, || {
            format!("{theta:.3} rad for {theta_k:.3} rad")
        });
    }
    meter
}

/// A path at a delay of the released label's axis, where its pulse is 1, that counts with this power \[dBm\].
fn at_first_delay(arrival_azimuth_rad: f64, power_dbm: f64) -> PathSample {
    path(0.0, arrival_azimuth_rad, power_dbm - 1.0)
}

/// Error of the response in a label's tables: one path, its own delay.
fn array_tables(name: &'static str, array: Array) -> KernelError {
    let mut meter = KernelError::new("aps-label", name);
    let labeler = labeler(array, LabelConfig::released());
    for i in 0..12 {
        let theta_k = f64::from(i) * 0.53 - 3.1;
        let paths = [at_first_delay(theta_k, 0.0)];
        let label = labeler.label(&paths).expect("finite").expect("a path");
        for (db, theta) in label.aps_db.iter().zip(labeler.angles_deg()) {
            let want = array_response(
                &labeler.config().array,
                dd(*theta) / dd(180.0),
                dd(theta_k) / PI + DoubleDouble::ONE,
            );
            let got = dd(*db).from_decibel();
            meter.add(got - want, want, || {
                format!("{theta} deg for {theta_k:.3} rad")
            });
        }
    }
    meter
}

/// 10 log10 of a sum of two powers.
fn decibels() -> KernelError {
    let mut meter = KernelError::new("aps-label", "power to dB");
    let labeler = labeler(linear(1, 0.5), LabelConfig::released());
    for i in 1..600 {
        let gain_db = -0.05 * f64::from(i);
        let paths = [at_first_delay(0.0, 0.0), at_first_delay(0.0, gain_db)];
        let label = labeler.label(&paths).expect("finite").expect("two paths");
        let rounded = dd(paths[1].gain_db) + DoubleDouble::ONE;
        let want = (DoubleDouble::ONE + rounded.from_decibel()).decibel();
        meter.real(label.aps_db[0], want, || {
            format!("0 dB and {gain_db:.2} dB")
        });
    }
    meter
}

/// 10^(dB/10) of labels.
fn powers() -> KernelError {
    let mut meter = KernelError::new("aps-label", "dB to relative power");
    let row: Vec<f64> = (0..3000).map(|i| -0.017 * f64::from(i)).collect();
    let mut values = row.clone();
    relative_power(&mut values).expect("finite");
    for (got, db) in values.iter().zip(&row) {
        meter.real(*got, dd(*db).from_decibel(), || format!("{db:.3} dB"));
    }
    meter
}

/// The released target: relative power, affine, standardised by its own mean and deviation.
fn standardised() -> KernelError {
    let mut meter = KernelError::new("aps-label", "standardised target");
    let split = MeanStd {
        mean: 0.17,
        std: 0.26,
    };
    for seed in 0..8 {
        let row: Vec<f64> = (0..180)
            .map(|i| -80.0 - f64::from((i * i + 31 * seed) % 97) * 0.3)
            .collect();
        let mut values = row.clone();
        Normalization::Released(split)
            .apply(&mut values)
            .expect("finite");
        let peak = row.iter().copied().fold(f64::MIN, f64::max);
        let n = dd(180.0);
        let affine = |db: f64| ((dd(db) - dd(peak)).from_decibel() - dd(0.17)) / dd(0.26);
        let wide: Vec<DoubleDouble> = row.iter().map(|&db| affine(db)).collect();
        let mean = wide.iter().copied().sum::<DoubleDouble>() / n;
        let squares = wide.iter().map(|&x| (x - mean) * (x - mean));
        let std = (squares.sum::<DoubleDouble>() / n).sqrt() + dd(1e-8);
        for ((got, x), bin) in values.iter().zip(&wide).zip(0..) {
            meter.real(*got, (*x - mean) / std, || format!("row {seed}, bin {bin}"));
        }
    }
    meter
}

fn deviation() -> KernelError {
    let mut meter = KernelError::new("aps-label", "deviation of a training split");
    for centre in [0.0, 0.1, 0.5] {
        let values: Vec<f64> = (0..9000)
            .map(|i| centre + 0.3 * f64::from(i * 7 % 1000) / 1000.0)
            .collect();
        let mut moments = Moments::default();
        moments.add(&values).expect("finite");
        let n = dd(9000.0);
        let mean = values.iter().map(|&x| dd(x)).sum::<DoubleDouble>() / n;
        let square = |&x: &f64| (dd(x) - mean) * (dd(x) - mean);
        let want = (values.iter().map(square).sum::<DoubleDouble>() / n).sqrt();
        let got = moments.mean_std().expect("values").std;
        meter.real(got, want, || format!("values around {centre}"));
    }
    meter
}

/// The metrics that are sums over bins.
fn scores() -> Vec<KernelError> {
    let metrics = [
        (Metric::Mae, "MAE"),
        (Metric::Mse, "MSE"),
        (Metric::Nmse, "NMSE"),
        (Metric::NmseDb, "NMSE [dB]"),
        (Metric::PsnrDb, "PSNR [dB]"),
        (Metric::Cosine, "cosine similarity"),
    ];
    let mut meters = metrics.map(|(_, name)| KernelError::new("aps-metrics", name));
    let mut scorer = Scorer::new(Scoring::Paper);
    let range = DataRange::new(7.5).expect("positive");
    for seed in 0..40 {
        let wave = |i: i32, k: f64| (f64::from(i) * 0.37 + f64::from(seed) * k).sin();
        let truth: Vec<f64> = (0..180).map(|i| wave(i, 0.3) + 0.1).collect();
        let prediction: Vec<f64> = (0..180).map(|i| 0.9 * wave(i, 0.31) - 0.2).collect();
        let scores = scorer.score(&truth, &prediction).expect("finite");
        let pairs = || truth.iter().zip(&prediction).map(|(&t, &p)| (dd(t), dd(p)));
        let n = dd(180.0);
        let mean = |of: fn(DoubleDouble, DoubleDouble) -> DoubleDouble| {
            pairs().map(|(t, p)| of(t, p)).sum::<DoubleDouble>() / n
        };
        let mse = mean(|t, p| (t - p) * (t - p));
        let power = mean(|t, _| t * t);
        let want = [
            mean(|t, p| (t - p).abs()),
            mse,
            mse / power,
            (mse / power).decibel(),
            (dd(7.5) * dd(7.5) / mse).decibel(),
            mean(|t, p| t * p) / (power * mean(|_, p| p * p)).sqrt(),
        ];
        for ((meter, (metric, _)), want) in meters.iter_mut().zip(metrics).zip(want) {
            meter.real(metric.of(&scores, range), want, || format!("pair {seed}"));
        }
    }
    meters.to_vec()
}
