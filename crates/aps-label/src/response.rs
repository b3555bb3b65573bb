//! The array's response over the angle axis, one path after another.
//!
//! Sine and cosine of both angles of a difference are known beforehand (the grid's once a labeler,
//! the path's once a path), so that a bin costs a handful of multiplications and, for the linear
//! array, one division. An angle addition has an absolute error of about 3e-16, which is nothing
//! unless sin psi is small; there the squared Dirichlet kernel is a short power series in
//! sin^2 psi instead, and no quotient of two rounding errors is ever formed. The result is that of
//! [`Array::power_response`] within a relative 1e-15 N, plus what an error of 1e-15 in sin theta
//! means near a zero.

use multiversion::multiversion;

use crate::Array;
use crate::paths::Paths;
use crate::product::{LANES, Lanes};
use crate::trig::{cos_pi, horner, sin_pi};

/// The distinct directions among the bins: bins the array cannot tell apart share a column.
///
/// With the paper's axis and a linear array that is 91 columns for 180 bins.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    /// Column of each bin.
    pub of_bin: Vec<usize>,
    /// The lowest bin of each column.
    pub first_bin: Vec<usize>,
    response: Response,
}

/// Tables over the columns, padded to a multiple of [`LANES`] with copies of the first column.
#[derive(Debug, Clone)]
enum Response {
    Linear(Linear),
    Circular(Circular),
}

/// sin and cos of alpha = pi d_lambda sin(theta) and of N alpha, one value a column.
#[derive(Debug, Clone)]
struct Linear {
    elements: f64,
    spacing_wavelengths: f64,
    series: [f64; SERIES],
    sin: Vec<f64>,
    cos: Vec<f64>,
    sin_n: Vec<f64>,
    cos_n: Vec<f64>,
}

/// sin and cos of 2 pi r cos(theta - phi_m), element after element.
#[derive(Debug, Clone)]
struct Circular {
    /// 2 r cos(phi_m), 2 r sin(phi_m): with them a path's phase is two products \[half turns\].
    positions: Vec<(f64, f64)>,
    /// Elements with an opposite twin are kept once: the pair's sum is real.
    paired: bool,
    /// `[block][element]`: sine and cosine.
    tables: Vec<(Lanes, Lanes)>,
}

impl Columns {
    pub fn new(array: &Array, angles_deg: &[f64]) -> Self {
        let linear = matches!(array, Array::UniformLinear { .. });
        let mut directions: Vec<(f64, f64)> = Vec::new();
        let mut first_bin = Vec::new();
        let mut of_bin = Vec::with_capacity(angles_deg.len());
        for (bin, &angle) in angles_deg.iter().enumerate() {
            let (sin, cos) = sin_cos_deg(angle);
            let twin = directions
                .iter()
                .position(|d| d.0 == sin && (linear || d.1 == cos));
            of_bin.push(twin.unwrap_or_else(|| {
                directions.push((sin, cos));
                first_bin.push(bin);
                directions.len() - 1
            }));
        }
        directions.resize(directions.len().next_multiple_of(LANES), directions[0]);
        let response = match *array {
            Array::UniformLinear {
                elements,
                spacing_wavelengths,
            } => Response::Linear(Linear::new(elements, spacing_wavelengths, &directions)),
            Array::UniformCircular {
                elements,
                radius_wavelengths,
            } => Response::Circular(Circular::new(elements, radius_wavelengths, &directions)),
        };
        Self {
            of_bin,
            first_bin,
            response,
        }
    }

    /// Number of columns without the padding.
    pub fn len(&self) -> usize {
        self.first_bin.len()
    }

    /// Number of blocks of [`LANES`] columns.
    pub fn blocks(&self) -> usize {
        self.len().div_ceil(LANES)
    }

    /// W as `[path][block]`: each path's power times the response of each column to it. `phases` is
    /// scratch space.
    pub fn response(&self, paths: &Paths, phases: &mut Vec<(f64, f64)>, out: &mut [Lanes]) {
        match &self.response {
            Response::Linear(table) => linear(table, paths, out),
            Response::Circular(table) => {
                phases.resize(table.positions.len(), (0.0, 0.0));
                circular(table, paths, phases, out);
            }
        }
    }
}

impl Linear {
    fn new(elements: usize, spacing_wavelengths: f64, directions: &[(f64, f64)]) -> Self {
        let n = elements as f64;
        let of = |f: fn(f64) -> f64, factor: f64| {
            directions
                .iter()
                .map(|&(sin, _)| f(factor * (spacing_wavelengths * sin)))
                .collect()
        };
        Self {
            elements: n,
            spacing_wavelengths,
            series: dirichlet_series(n),
            sin: of(sin_pi, 1.0),
            cos: of(cos_pi, 1.0),
            sin_n: of(sin_pi, n),
            cos_n: of(cos_pi, n),
        }
    }
}

impl Circular {
    fn new(elements: usize, radius_wavelengths: f64, directions: &[(f64, f64)]) -> Self {
        let paired = elements.is_multiple_of(2);
        let kept = if paired { elements / 2 } else { elements };
        let diameter = 2.0 * radius_wavelengths;
        let position = |m| {
            let half_turns = 2.0 * m as f64 / elements as f64;
            (diameter * cos_pi(half_turns), diameter * sin_pi(half_turns))
        };
        let positions: Vec<_> = (0..kept).map(position).collect();
        let mut tables = Vec::new();
        for block in directions.chunks_exact(LANES) {
            for &(x, y) in &positions {
                let of =
                    |f: fn(f64) -> f64| std::array::from_fn(|l| f(x * block[l].1 + y * block[l].0));
                tables.push((of(sin_pi), of(cos_pi)));
            }
        }
        Self {
            positions,
            paired,
            tables,
        }
    }
}

/// Sine and cosine of an angle in degrees, exactly symmetric under theta -> 180 deg - theta and
/// theta -> -theta wherever the degrees are.
fn sin_cos_deg(degrees: f64) -> (f64, f64) {
    let magnitude = degrees.abs();
    let (reduced, cos_sign) = if magnitude > 90.0 {
        (180.0 - magnitude, -1.0)
    } else {
        (magnitude, 1.0)
    };
    let sin = sin_pi(reduced / 180.0);
    // Adding 0 makes a negative zero positive.
    (
        sin.copysign(degrees) + 0.0,
        cos_sign * cos_pi(reduced / 180.0) + 0.0,
    )
}

/// Terms of the power series used where N^2 sin^2 psi < [`SERIES_BELOW`]; the first one left out
/// is below 2e-19 there.
const SERIES: usize = 8;
const SERIES_BELOW: f64 = 0.1;

/// Coefficients of \[sin(N psi)/(N sin psi)\]^2 in powers of x = N^2 sin^2 psi.
///
/// sin(N psi)/(N sin psi) is, up to its sign near odd multiples of pi, the hypergeometric function
/// F((1+N)/2, (1-N)/2; 3/2; sin^2 psi) (Abramowitz and Stegun 15.1.16); its series is squared.
fn dirichlet_series(n: f64) -> [f64; SERIES] {
    let mut root = [1.0; SERIES];
    for i in 1..SERIES {
        let odd = (2 * i - 1) as f64;
        let ratio = (odd * odd / (n * n) - 1.0) / ((2 * i + 1) as f64 * (2 * i) as f64);
        root[i] = root[i - 1] * ratio;
    }
    let mut square = [0.0; SERIES];
    for i in 0..SERIES {
        for j in 0..SERIES - i {
            square[i + j] += root[i] * root[j];
        }
    }
    square
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn linear(table: &Linear, paths: &Paths, out: &mut [Lanes]) {
    let columns = table.sin.len();
    let (sines, cosines) = (&table.sin[..columns], &table.cos[..columns]);
    let (sines_n, cosines_n) = (&table.sin_n[..columns], &table.cos_n[..columns]);
    let n = table.elements;
    let rows = out.as_flattened_mut().chunks_exact_mut(columns);
    for (row, (power, direction)) in rows.zip(paths.power.iter().zip(&paths.direction)) {
        let half_turns = table.spacing_wavelengths * direction.0;
        let (sin, cos) = (sin_pi(half_turns), cos_pi(half_turns));
        let (sin_n, cos_n) = (sin_pi(n * half_turns), cos_pi(n * half_turns));
        for j in 0..columns {
            let below = n * (sines[j] * cos - cosines[j] * sin);
            let above = sines_n[j] * cos_n - cosines_n[j] * sin_n;
            let x = below * below;
            let near = horner(&table.series, x);
            let ratio = above / below;
            let response = if x < SERIES_BELOW {
                near
            } else {
                ratio * ratio
            };
            row[j] = power * response;
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn circular(table: &Circular, paths: &Paths, phases: &mut [(f64, f64)], out: &mut [Lanes]) {
    let elements = table.positions.len();
    let scale = 1.0 / (elements * elements) as f64;
    let rows = out.chunks_exact_mut(table.tables.len() / elements);
    for (row, (power, &(sin, cos))) in rows.zip(paths.power.iter().zip(&paths.direction)) {
        for (phase, (x, y)) in phases.iter_mut().zip(&table.positions) {
            let half_turns = x * cos + y * sin;
            *phase = (sin_pi(half_turns), cos_pi(half_turns));
        }
        for (out, elements) in row.iter_mut().zip(table.tables.chunks_exact(elements)) {
            let mut re = [0.0; LANES];
            let mut im = [0.0; LANES];
            for ((s, c), (sin_k, cos_k)) in elements.iter().zip(&*phases) {
                for l in 0..LANES {
                    re[l] += c[l] * cos_k + s[l] * sin_k;
                }
                if !table.paired {
                    for l in 0..LANES {
                        im[l] += s[l] * cos_k - c[l] * sin_k;
                    }
                }
            }
            for l in 0..LANES {
                out[l] = power * (scale * (re[l] * re[l] + im[l] * im[l]));
            }
        }
    }
}
