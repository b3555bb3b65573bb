//! Computes a label from paths.

use multiversion::multiversion;

use crate::continuous::Continuous;
use crate::paths::{self, PathSample, Paths};
use crate::product::{LANES, Lanes, ROWS, lane_maxima, pack_lanes, pack_rows};
use crate::protocol::FLOOR_POWER;
use crate::pulse::{in_lanes, pulses};
use crate::response::Columns;
use crate::select::Selector;
use crate::trig::{decibel, sinc_squared};
use crate::{ConfigError, LabelConfig, MAX_PATHS, PathError, Protocol};

/// Paths times points of the delay axis, 8 bytes each.
const MAX_PULSES: usize = 1 << 28;

/// A label: the APS, and the PDP if the configuration asks for it.
///
/// Powers are in dBm in `Released` (1 dBm sent) and in dB relative to the power sent in `Paper`.
/// The vectors are empty after [`Status::NoPath`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Label {
    /// a(theta_j) = max over tau of Q(tau, theta_j), one value a bin \[dB\].
    pub aps_db: Vec<f64>,
    /// The delay where that maximum is \[s\]; the first of equal ones in `Released`.
    pub aps_delay_s: Vec<f64>,
    /// max over the angle bins of Q(tau_i, theta), one value a point of the delay axis \[dB\].
    /// Empty unless asked for.
    pub pdp_db: Vec<f64>,
    /// The bin's angle where that maximum is \[deg\]; the first of equal ones. Empty unless asked
    /// for.
    pub pdp_angle_deg: Vec<f64>,
}

impl Label {
    fn clear(&mut self) {
        self.aps_db.clear();
        self.aps_delay_s.clear();
        self.pdp_db.clear();
        self.pdp_angle_deg.clear();
    }
}

/// Outcome for a link: a label, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub enum Status {
    /// The label was written.
    Labelled,
    /// No path was given, or the protocol dropped all of them: there is no label.
    NoPath,
}

/// Buffers of [`Labeler::label_into`], one for each thread; they grow to the largest link seen.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    paths: Paths,
    /// Sine and cosine of one path's phase at each element of a circular array.
    phases: Vec<(f64, f64)>,
    response: Vec<Lanes>,
    pulse: Vec<Lanes>,
    maxima: Maxima,
    continuous: Continuous,
}

/// A matrix `[path][block]` with its number of points, the last block's padding left out.
#[derive(Debug, Clone, Copy)]
struct Matrix<'a> {
    values: &'a [Lanes],
    blocks: usize,
    points: usize,
}

/// Maxima of the product of two matrices over the points of one of them.
#[derive(Debug, Clone, Default)]
struct Maxima {
    selector: Selector,
    lanes: Vec<Lanes>,
    rows: Vec<[f64; ROWS]>,
    /// The maximum for each point of the other, and its position among the selector's rows.
    best: Vec<Lanes>,
    first: Vec<Lanes>,
}

impl Maxima {
    /// Finds the maximum of each point of `across` over the points of `over` that can win.
    fn fill(&mut self, across: Matrix<'_>, over: Matrix<'_>) {
        let (selector, rows) = (&mut self.selector, &mut self.rows);
        selector.select(over.values, over.blocks, over.points);
        pack_lanes(across.values, across.blocks, &mut self.lanes);
        pack_rows(over.values, over.blocks, &selector.rows, rows);
        self.best.resize(across.blocks, [0.0; LANES]);
        self.first.resize(across.blocks, [0.0; LANES]);
        let paths = across.values.len() / across.blocks;
        lane_maxima(paths, &self.lanes, rows, &mut self.best, &mut self.first);
    }
}

/// Computes labels: the tables of one configuration, to be shared by all threads.
///
/// ```
/// use aps_label::{Label, LabelConfig, Labeler, PathSample, Scratch, Status};
///
/// let labeler = Labeler::new(&LabelConfig::released())?;
/// let (mut scratch, mut label) = (Scratch::default(), Label::default()); // one pair a thread
/// for delay_ns in [100.0, 250.0, 400.0] {
///     let path = PathSample { delay_s: delay_ns * 1e-9, arrival_azimuth_rad: 0.5, gain_db: -90.0 };
///     let status = labeler.label_into(&[path], &mut scratch, &mut label)?;
///     assert_eq!((status, label.aps_db.len()), (Status::Labelled, labeler.angles_deg().len()));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Labeler {
    config: LabelConfig,
    angles_deg: Vec<f64>,
    delays_s: Vec<f64>,
    /// Delays, padded to whole vectors.
    delay_lanes: Vec<Lanes>,
    columns: Columns,
}

impl Labeler {
    /// Makes the tables of a configuration.
    ///
    /// # Errors
    ///
    /// The first field of `config` that is out of range.
    pub fn new(config: &LabelConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let angles_deg: Vec<f64> = config.protocol.angle_axis_deg().values().collect();
        let delays_s = config.delay_axis.delays_s();
        let mut delay_lanes = Vec::new();
        in_lanes(delays_s.iter().copied(), &mut delay_lanes);
        let columns = Columns::new(&config.array, &angles_deg);
        Ok(Self {
            config: config.clone(),
            angles_deg,
            delays_s,
            delay_lanes,
            columns,
        })
    }

    /// The configuration given.
    pub fn config(&self) -> &LabelConfig {
        &self.config
    }

    /// Angle of each APS bin \[deg\], ascending, counter-clockwise from +x: the direction towards
    /// the last interaction in `Paper`, the direction of travel in `Released`.
    pub fn angles_deg(&self) -> &[f64] {
        &self.angles_deg
    }

    /// Delay of each point of the delay axis \[s\].
    pub fn delays_s(&self) -> &[f64] {
        &self.delays_s
    }

    /// The most paths a link may have: [`MAX_PATHS`](crate::MAX_PATHS), and fewer on a delay axis of more
    /// than 16,384 points, so that the pulses of all paths on the axis take at most 2 GiB.
    pub fn max_paths(&self) -> usize {
        MAX_PATHS.min(MAX_PULSES / self.delays_s.len())
    }

    /// The label of one link, or `None` if it has no path the protocol counts.
    ///
    /// [`label_into`](Self::label_into) is the same without the allocations.
    ///
    /// # Errors
    ///
    /// A path with a field that is not finite or with an impossible delay, or more than
    /// [`max_paths`](Self::max_paths) paths.
    pub fn label(&self, paths: &[PathSample]) -> Result<Option<Label>, PathError> {
        let mut label = Label::default();
        let status = self.label_into(paths, &mut Scratch::default(), &mut label)?;
        Ok((status == Status::Labelled).then_some(label))
    }

    /// Writes the label of one link into `label`, whose former content is dropped.
    ///
    /// The result is a pure function of the configuration and the set of paths: neither their order
    /// nor what `scratch` was used for before, neither the CPU nor the thread changes a bit of it.
    /// Nothing is allocated once the buffers have grown to the largest link.
    ///
    /// # Errors
    ///
    /// As [`label`](Self::label); `label` is empty then.
    pub fn label_into(
        &self,
        paths: &[PathSample],
        scratch: &mut Scratch,
        label: &mut Label,
    ) -> Result<Status, PathError> {
        label.clear();
        let max = self.max_paths();
        scratch.paths.prepare(self.config.protocol, paths, max)?;
        if scratch.paths.len() == 0 {
            return Ok(Status::NoPath);
        }
        self.fill_response(scratch);
        match self.config.protocol {
            Protocol::Paper => {
                self.continuous_aps(scratch, label);
                if self.config.pdp {
                    self.fill_pulse(scratch);
                }
            }
            Protocol::Released => {
                self.fill_pulse(scratch);
                self.sampled_aps(scratch, label);
            }
        }
        if self.config.pdp {
            self.pdp(scratch, label);
        }
        Ok(Status::Labelled)
    }

    /// Q(tau, theta) at one point, linear power \[mW\] in `Released`, relative to the power sent in
    /// `Paper`; no floor. 0 if no path counts, infinite where a power is beyond doubles, above 3083 dB.
    ///
    /// `theta_rad` is in the protocol's sense, as [`angles_deg`](Self::angles_deg). Made for plots
    /// and tests: every term by the formula, in the order of `paths`.
    ///
    /// # Errors
    ///
    /// A bad path, as in [`label`](Self::label), or a point that is not finite.
    pub fn q(&self, paths: &[PathSample], tau_s: f64, theta_rad: f64) -> Result<f64, PathError> {
        for (field, value) in [("tau_s", tau_s), ("theta_rad", theta_rad)] {
            if !value.is_finite() {
                return Err(PathError::Point { field, value });
            }
        }
        let protocol = self.config.protocol;
        // The direction of travel is half a turn from the direction the path comes from; turning
        // both angles of a difference changes nothing, and turning this one keeps the path's exact.
        let towards_source = match protocol {
            Protocol::Paper => theta_rad,
            Protocol::Released => theta_rad - std::f64::consts::PI,
        };
        let mut sum = 0.0;
        for (index, path) in paths.iter().enumerate() {
            paths::check(index, path)?;
            if paths::used(protocol, path.gain_db) {
                let power = libm::exp10(0.1 * paths::power_db(protocol, path.gain_db));
                let pulses = self.config.sampling_rate_hz * (tau_s - path.delay_s);
                let pulse = sinc_squared(pulses.clamp(f64::MIN, f64::MAX));
                let response = self
                    .config
                    .array
                    .power_response(towards_source, path.arrival_azimuth_rad);
                let share = pulse * response;
                // A power may be infinite.
                sum += if share > 0.0 { power * share } else { 0.0 };
            }
        }
        Ok(sum)
    }

    /// W_k(theta) = p_k times the array's response, over the columns.
    fn fill_response(&self, scratch: &mut Scratch) {
        let size = scratch.paths.len() * self.columns.blocks();
        scratch.response.resize(size, [0.0; LANES]);
        let (phases, response) = (&mut scratch.phases, &mut scratch.response);
        self.columns.response(&scratch.paths, phases, response);
    }

    /// S_k(tau) over the delay axis.
    fn fill_pulse(&self, scratch: &mut Scratch) {
        let (places, pulse) = (&scratch.paths.delay_s, &mut scratch.pulse);
        pulse.resize(places.len() * self.delay_lanes.len(), [0.0; LANES]);
        pulses(
            self.config.sampling_rate_hz,
            &self.delay_lanes,
            places,
            pulse,
        );
    }

    /// The maximum over the delay axis.
    fn sampled_aps(&self, scratch: &mut Scratch, label: &mut Label) {
        let maxima = &mut scratch.maxima;
        maxima.fill(
            self.matrix_of_columns(&scratch.response),
            self.matrix_of_delays(&scratch.pulse),
        );
        let (first, selector) = (maxima.first.as_flattened(), &maxima.selector);
        let delay_s = |column: usize, power| self.delays_s[selector.winner(power, first[column])];
        let powers = maxima.best.as_flattened_mut();
        self.write_aps(scratch.paths.strongest_db, powers, delay_s, label);
    }

    /// The maximum over a continuous delay.
    fn continuous_aps(&self, scratch: &mut Scratch, label: &mut Label) {
        let search = &mut scratch.continuous;
        let rate = self.config.sampling_rate_hz;
        let earliest = search.search(
            &scratch.paths.delay_s,
            rate,
            &scratch.response,
            self.columns.blocks(),
            self.columns.len(),
        );
        let places = search.place.as_flattened();
        let delay_s = |column: usize, _| earliest + places[column] / rate;
        let powers = search.best.as_flattened_mut();
        self.write_aps(scratch.paths.strongest_db, powers, delay_s, label);
    }

    /// Writes the maxima of the columns bin by bin, and where they are, given column and power.
    fn write_aps(
        &self,
        strongest_db: f64,
        powers: &mut [f64],
        delay_s: impl Fn(usize, f64) -> f64,
        label: &mut Label,
    ) {
        let columns = || self.columns.of_bin.iter().copied();
        let delays_s = columns().map(|column| delay_s(column, powers[column]));
        label.aps_delay_s.extend(delays_s);
        self.to_db(strongest_db, powers);
        label.aps_db.extend(columns().map(|column| powers[column]));
    }

    /// The maximum over the angles.
    fn pdp(&self, scratch: &mut Scratch, label: &mut Label) {
        let maxima = &mut scratch.maxima;
        maxima.fill(
            self.matrix_of_delays(&scratch.pulse),
            self.matrix_of_columns(&scratch.response),
        );
        let used = self.delays_s.len();
        let powers = &mut maxima.best.as_flattened_mut()[..used];
        let (first, selector) = (maxima.first.as_flattened(), &maxima.selector);
        label
            .pdp_angle_deg
            .extend(powers.iter().zip(first).map(|(&power, &first)| {
                self.angles_deg[self.columns.first_bin[selector.winner(power, first)]]
            }));
        self.to_db(scratch.paths.strongest_db, powers);
        label.pdp_db.extend_from_slice(powers);
    }

    fn matrix_of_columns<'a>(&self, values: &'a [Lanes]) -> Matrix<'a> {
        Matrix {
            values,
            blocks: self.columns.blocks(),
            points: self.columns.len(),
        }
    }

    fn matrix_of_delays<'a>(&self, values: &'a [Lanes]) -> Matrix<'a> {
        Matrix {
            values,
            blocks: self.delay_lanes.len(),
            points: self.delays_s.len(),
        }
    }

    /// Power relative to the strongest path to dB in the protocol's unit, with its floor.
    fn to_db(&self, strongest_db: f64, powers: &mut [f64]) {
        match self.config.protocol {
            Protocol::Paper => floor_relative(strongest_db, powers),
            Protocol::Released => floor_absolute(libm::exp10(0.1 * strongest_db), powers),
        }
    }
}

/// 10 log10 max(Q, floor) + the strongest path's dB, Q relative to the strongest path.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn floor_relative(strongest_db: f64, powers: &mut [f64]) {
    for power in powers {
        *power = decibel(power.max(FLOOR_POWER)) + strongest_db;
    }
}

/// 10 log10(Q + floor).
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn floor_absolute(strongest: f64, powers: &mut [f64]) {
    for power in powers {
        *power = decibel(*power * strongest + FLOOR_POWER);
    }
}
