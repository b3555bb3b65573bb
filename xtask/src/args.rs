//! Arguments that several commands share, and how their values are read.

use std::fmt;
use std::str::FromStr;

use aps_data::Access;
use aps_label::{Array, LabelConfig, Protocol};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Material, TraceConfig};
use clap::{Args, ValueEnum};

use aps_data::Stored;

/// A value of `--shard`: `I/N`, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1 to `count`.
    pub number: u32,
    pub count: u32,
}

impl Shard {
    /// The maps it may write.
    pub fn access(self) -> Access {
        Access::Shard {
            index: self.number - 1,
            count: self.count,
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let parts = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((number, count)) if (1..=count).contains(&number) => Ok(Self { number, count }),
            _ => Err(format!("'{text}' is not a shard; try 1/4, 2/4, 3/4, 4/4")),
        }
    }
}

/// Named limits of the tracer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Limits {
    /// 2 reflections, 1 diffraction, paths within 60 dB of the strongest.
    R2d1,
    /// 5 reflections, 2 diffractions, paths within 30 dB: more changes labels by less than 1 dB in the mean, at about five
    /// times the time.
    Converged,
}

impl Limits {
    fn config(self) -> TraceConfig {
        match self {
            Self::R2d1 => TraceConfig::default(),
            Self::Converged => TraceConfig::converged(),
        }
    }
}

/// Settings of the trace.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Tracing")]
pub struct TraceArgs {
    /// Limits where nothing else is said.
    #[arg(long, value_enum, default_value_t = Limits::R2d1)]
    pub limits: Limits,
    /// Most reflections on a path [default: as the limits have it].
    #[arg(long)]
    pub max_reflections: Option<usize>,
    /// Most diffractions on a path [default: as the limits have it].
    #[arg(long)]
    pub max_diffractions: Option<usize>,
    /// Most interactions on a path [default: the sum of the two limits above].
    #[arg(long)]
    pub max_interactions: Option<usize>,
    /// Leave out paths weaker than the link's strongest by more than this [dB; default: as the limits have it].
    #[arg(long)]
    pub dynamic_range_db: Option<f64>,
    /// Keep every path inside the limits, however weak.
    #[arg(long)]
    pub no_prune: bool,
    /// A link without a path goes on with up to this many diffractions along the best chains of corners, whose levels are
    /// estimates; 0 turns it off.
    #[arg(long, default_value_t = TraceConfig::default().max_fallback_diffractions)]
    pub max_fallback_diffractions: usize,
    /// Carrier [Hz].
    #[arg(long, default_value_t = 3.5e9)]
    pub frequency_hz: f64,
    /// Walls: concrete (ITU-R P.2040), pec (perfect conductor), or EPS,SIGMA
    /// (relative permittivity, conductivity in S/m).
    #[arg(long, default_value = "concrete", value_parser = parse_material)]
    pub material: Material,
}

impl TraceArgs {
    /// The tracer's configuration.
    pub fn config(&self) -> TraceConfig {
        let limits = self.limits.config();
        let max_reflections = self.max_reflections.unwrap_or(limits.max_reflections);
        let max_diffractions = self.max_diffractions.unwrap_or(limits.max_diffractions);
        let range_db = self.dynamic_range_db.or(limits.dynamic_range_db);
        TraceConfig {
            frequency_hz: self.frequency_hz,
            material: self.material,
            max_reflections,
            max_diffractions,
            max_interactions: self
                .max_interactions
                .unwrap_or(max_reflections.saturating_add(max_diffractions)),
            dynamic_range_db: range_db.filter(|_| !self.no_prune),
            max_fallback_diffractions: self.max_fallback_diffractions,
            ..limits
        }
    }
}

/// Things a data set can store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Store {
    /// Angle power spectra.
    Aps,
    /// Power delay profiles.
    Pdp,
    /// Propagation paths: labels can be made anew from them.
    Paths,
}

/// Converts the values of `--store` to the kinds of data they name.
pub fn stored(named: &[Store]) -> Stored {
    Stored {
        aps: named.contains(&Store::Aps),
        pdp: named.contains(&Store::Pdp),
        paths: named.contains(&Store::Paths),
    }
}

/// Settings of labels for paths that were not traced here.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Labels")]
pub struct LabelArgs {
    /// Definition of the label: released (what the published code computes) or paper.
    #[arg(long, default_value = "released")]
    pub protocol: Protocol,
    /// Elements of the linear array.
    #[arg(long, alias = "elements", default_value_t = 16)]
    pub kernel_n: usize,
    /// Their spacing [wavelengths].
    #[arg(long, default_value_t = 0.5)]
    pub spacing: f64,
    /// Sampling rate of the delay kernel [Hz].
    #[arg(long, default_value_t = 200e6)]
    pub fs_hz: f64,
}

impl LabelArgs {
    /// The label's configuration, with the delay axis of the protocol.
    pub fn config(&self, pdp: bool) -> LabelConfig {
        LabelConfig {
            sampling_rate_hz: self.fs_hz,
            array: Array::UniformLinear {
                elements: self.kernel_n,
                spacing_wavelengths: self.spacing,
            },
            pdp,
            ..LabelConfig::of(self.protocol)
        }
    }
}

/// Reads `X,Y` in metres.
pub fn parse_point(text: &str) -> Result<DVec2, String> {
    parse_pair(text).map(|(x, y)| DVec2::new(x, y))
}

fn parse_pair(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("'{text}' is not a pair of numbers like 12.5,40");
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let number = |s: &str| s.trim().parse::<f64>().map_err(|_| wrong());
    Ok((number(x)?, number(y)?))
}

fn parse_material(text: &str) -> Result<Material, String> {
    match text {
        "concrete" => Ok(Material::Concrete),
        "pec" => Ok(Material::PerfectConductor),
        _ => {
            let (relative_permittivity, conductivity_s_per_m) = parse_pair(text)
                .map_err(|_| format!("'{text}' is none of concrete, pec, EPS,SIGMA"))?;
            Material::Dielectric {
                relative_permittivity,
                conductivity_s_per_m,
            }
            .validate()
            .map_err(|e| e.to_string())
        }
    }
}
