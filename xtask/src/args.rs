//! Arguments that several commands share, and how their values are read.

use std::error::Error;
use std::path::Path;
use std::str::FromStr;

use anyhow::{Result, ensure};
use aps_data::{Access, Part, Stored};
use aps_label::{ArrayForm, DelayAxis, HEADINGS_DEG, LabelConfig, Protocol};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Material, Scene, TraceConfig};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args, ValueEnum};
use map2aps::maps::{self, NamedMaps, TileSettings};
use map2aps::{Domain, Limits, MapError, MapSource, SEED, SceneSettings};
use serde_json::Value;

use crate::note;

/// Settings by which a city in GeoJSON becomes maps.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "City in GeoJSON")]
pub struct TileArgs {
    /// Side of the maps it is cut into [m]; numbered row by row from the south-west [default: 256, or as the data set
    /// at hand was made].
    #[arg(long, value_name = "METRES")]
    tile: Option<f64>,
    /// Leave out maps with fewer buildings [default: 1, or as the data set at hand was made].
    #[arg(long)]
    min_buildings: Option<usize>,
    /// Its coordinates are metres, not degrees.
    #[arg(long)]
    metric: bool,
    /// Take every polygon for a building, with or without a building tag.
    #[arg(long)]
    all_polygons: bool,
    /// South-west corner of the first map, LON,LAT or X,Y with --metric [default: that of all buildings, or as the data set at
    /// hand was made].
    #[arg(long, value_name = "X,Y", value_parser = parse_point, allow_hyphen_values = true)]
    corner: Option<DVec2>,
}

impl TileArgs {
    /// The settings for maps of one's own.
    pub fn settings(&self) -> TileSettings {
        self.over(TileSettings::default())
    }

    /// Opens maps of one's own, of synthetic cities so many unless a number is asked for; a city is described.
    ///
    /// # Errors
    /// A city that cannot be read or holds no map.
    pub fn open(&self, maps: &NamedMaps, synthetic: u32) -> Result<MapSource> {
        described(maps.open(self.settings(), synthetic)?)
    }

    /// Opens the maps that a data set was made of, if they are named; a city is cut by the settings in its `configuration`.
    ///
    /// # Errors
    /// As [`TileArgs::open`], a city of another data set, and settings of tiles without maps.
    pub fn open_for(
        &self,
        maps: Option<&NamedMaps>,
        configuration: &Value,
    ) -> Result<Option<MapSource>> {
        let Some(maps) = maps else {
            return self.must_be_default().map(|()| None);
        };
        let tiles = match maps {
            NamedMaps::City(_) => self.over(TileSettings::of_dataset(configuration)),
            NamedMaps::Folder(_) | NamedMaps::Synthetic { .. } => self.settings(),
        };
        let source = described(maps.open(tiles, 0)?)?;
        // Maps of other sources are compared by their buildings, map by map.
        if let MapSource::City(_) = source {
            source
                .must_be_of(configuration)
                .map_err(map2aps::Error::from)?;
        }
        Ok(Some(source))
    }

    /// Refuses settings where there is no city to be cut.
    pub fn must_be_default(&self) -> Result<()> {
        Ok(self
            .settings()
            .must_be_default()
            .map_err(map2aps::Error::from)?)
    }

    /// The settings given, and others where none are.
    fn over(&self, others: TileSettings) -> TileSettings {
        TileSettings {
            tile_m: self.tile.unwrap_or(others.tile_m),
            min_buildings: self.min_buildings.unwrap_or(others.min_buildings),
            metric: self.metric || others.metric,
            all_polygons: self.all_polygons || others.all_polygons,
            corner: self.corner.map(DVec2::into).or(others.corner),
        }
    }
}

/// Tells what a city was cut into.
fn described(maps: MapSource) -> Result<MapSource> {
    if let MapSource::City(city) = &maps {
        note!("{city}");
    }
    Ok(maps)
}

/// Settings of the scenes made from maps.
#[derive(Debug, Clone, Copy, Args)]
pub struct SceneArgs {
    /// Fill slits between walls that are narrower [m]; 0 leaves all open.
    #[arg(
        long = "close-gaps",
        value_name = "METRES",
        default_value_t = SceneSettings::default().close_gaps_m,
        value_parser = parse_width
    )]
    close_gaps_m: f64,
}

impl SceneArgs {
    /// The settings.
    pub fn settings(self) -> SceneSettings {
        SceneSettings {
            close_gaps_m: self.close_gaps_m,
            ..SceneSettings::default()
        }
    }
}

fn parse_width(text: &str) -> Result<f64, String> {
    let width: Result<f64, _> = text.parse();
    let is_width = |w: &f64| w.is_finite() && *w >= 0.0;
    let wrong = || format!("'{text}' is no width in metres: it must be finite and not negative");
    width.ok().filter(is_width).ok_or_else(wrong)
}

/// The one map of a command that traces links.
#[derive(Debug, Clone, Args)]
pub struct OneMapArgs {
    /// Tile of a city [default: the first with a building].
    #[arg(long, requires = "map")]
    map_id: Option<u32>,
    /// Seed of the synthetic city [default: 42].
    #[arg(long, requires = "map")]
    seed: Option<u64>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    pub tiles: TileArgs,
}

impl OneMapArgs {
    /// Tells if the map is made into a scene as usual.
    pub fn is_usual_scene(&self) -> bool {
        self.scene.settings() == SceneSettings::default()
    }

    /// Reads the map: a RadioMapSeer file, a tile of a city in GeoJSON, which is described, or `synthetic`.
    pub fn load(&self, map: &Path) -> Result<Scene> {
        let scene = self.scene.settings();
        let tiles = self.tiles.settings();
        if map == Path::new("synthetic") {
            self.tiles.must_be_default()?;
            ensure!(
                self.map_id.is_none(),
                "--map-id is for a city in GeoJSON; another synthetic one has another --seed"
            );
            let seed = self.seed.unwrap_or(SEED);
            return Ok(MapSource::Synthetic { count: 1 }.load(0, seed, scene)?);
        }
        ensure!(
            self.seed.is_none(),
            "--seed is for --map synthetic; leave it away"
        );
        let (scene, city) = maps::load_file(map, self.map_id, tiles, scene)?;
        if let Some(city) = city {
            note!("{city}");
        }
        Ok(scene)
    }
}

/// Ids of maps in a list like `0-4,7,46-50`: ascending, each once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IdList(pub Vec<u32>);

impl FromStr for IdList {
    type Err = MapError;

    fn from_str(text: &str) -> Result<Self, MapError> {
        maps::parse_ids(text).map(Self)
    }
}

/// Parser of a part of a data set's split.
pub fn parts() -> impl TypedValueParser<Value = Part> {
    named(Part::ALL.map(|part| {
        PossibleValue::new(part.name()).help(match part {
            Part::Train => "Maps to fit a model's weights on",
            Part::Develop => "Maps to choose a model by",
            Part::Test => "Maps for the figures that are reported",
        })
    }))
}

/// Parser of the form in which labels are compared.
pub fn domains() -> impl TypedValueParser<Value = Domain> {
    let names = Domain::ALL.map(|domain| {
        PossibleValue::new(domain.name()).help(match domain {
            Domain::Normalised => {
                "The protocol's learning target, on which the benchmark's metrics are defined"
            }
            Domain::Linear => "Linear power relative to the sample's maximum, in [0, 1]",
        })
    });
    let domain = |name| Domain::ALL.into_iter().find(|domain| domain.name() == name);
    PossibleValuesParser::new(names).map(move |name| domain(name).expect("one of the names"))
}

/// Parser of named limits.
pub fn limits() -> impl TypedValueParser<Value = Limits> {
    named(Limits::ALL.map(|limits| {
        PossibleValue::new(limits.name()).help(match limits {
            Limits::Converged => {
                "5 reflections, 2 diffractions, paths within 20 dB of the strongest: further reflections and weaker paths change labels by 1 dB in the mean"
            }
            Limits::R2d1 => "2 reflections, 1 diffraction, paths within 60 dB: less time; more of both changes labels by 13 dB in the mean",
        })
    }))
}

/// Reads the maps that a shard may write, `I/N`, counted from 1.
pub fn parse_shard(text: &str) -> Result<Access, String> {
    let parts = text.split_once('/');
    let parts = parts.and_then(|(i, n)| Some((i.parse::<u32>().ok()?, n.parse().ok()?)));
    match parts {
        Some((number, count)) if (1..=count).contains(&number) => {
            let index = number - 1;
            Ok(Access::Shard { index, count })
        }
        _ => Err(format!("'{text}' is not a shard; try 1/4, 2/4, 3/4, 4/4")),
    }
}

/// The shard that may write so, as `--shard` takes it; `None` for a whole data set.
pub fn shard(access: Access) -> Option<String> {
    match access {
        Access::Whole => None,
        Access::Shard { index, count } => Some(format!("{}/{count}", index + 1)),
    }
}

/// Settings of the trace.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Tracing")]
pub struct TraceArgs {
    /// Limits where nothing else is said.
    #[arg(long, value_parser = limits(), default_value_t)]
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
    /// Waves from corner to corner take their slope along: what a wave along a wall is made of.
    #[arg(long, action = ArgAction::Set, value_name = "BOOL", default_value_t = TraceConfig::default().slope_diffraction)]
    pub slope_diffraction: bool,
    /// Leave out paths weaker than the link's strongest by more than this [dB; default: as the limits have it].
    #[arg(long)]
    pub dynamic_range_db: Option<f64>,
    /// Keep every path inside the limits, however weak.
    #[arg(long, conflicts_with = "dynamic_range_db")]
    pub no_prune: bool,
    /// A link without a path goes on with up to this many diffractions along the best chains of corners, whose levels are
    /// estimates; no more than a path may have turns it off.
    #[arg(long, default_value_t = TraceConfig::default().max_fallback_diffractions)]
    pub max_fallback_diffractions: usize,
    /// Carrier [Hz].
    #[arg(long, default_value_t = TraceConfig::default().frequency_hz)]
    pub frequency_hz: f64,
    /// Walls: concrete (ITU-R P.2040), pec (perfect conductor), or EPS,SIGMA
    /// (relative permittivity, conductivity in S/m).
    #[arg(long, default_value = "concrete")]
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
            slope_diffraction: self.slope_diffraction,
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

/// Parser of `--array`.
fn forms() -> impl TypedValueParser<Value = ArrayForm> {
    named(ArrayForm::ALL.map(|form| {
        PossibleValue::new(form.name()).help(match form {
            ArrayForm::Ula => "Uniform and linear: sees a direction and its mirror image alike",
            ArrayForm::Uca => "Uniform and circular: sees every direction for itself",
        })
    }))
}

/// Parser of a value that has one of some names.
pub fn named<T>(
    names: impl IntoIterator<Item = impl Into<PossibleValue>>,
) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err: Into<Box<dyn Error + Send + Sync>>> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse::<T>())
}

/// Array and bandwidth of labels; what is not given stays as it is.
#[derive(Debug, Clone, Args)]
pub struct ArrayArgs {
    /// Form of the array [default: that of the data set, or ula].
    #[arg(long, value_parser = forms())]
    array: Option<ArrayForm>,
    /// Elements of the array [default: those of the data set, or 16].
    #[arg(long, alias = "kernel-n")]
    elements: Option<usize>,
    /// Spacing of neighbouring elements, on a circle along its arc [wavelengths; default: that of the data set, or 0.5].
    #[arg(long)]
    spacing: Option<f64>,
    /// Sampling rate of the delay kernel, the bandwidth [Hz; default: that of the data set, or 200e6].
    #[arg(long)]
    fs_hz: Option<f64>,
}

impl ArrayArgs {
    /// The settings given, and others where none are.
    pub fn over(&self, own: &LabelConfig) -> LabelConfig {
        let is_asked = self.array.is_some() || self.elements.is_some() || self.spacing.is_some();
        let (form, elements, spacing) = own.array.parts();
        let form = self.array.unwrap_or(form);
        let asked = form.array(
            self.elements.unwrap_or(elements),
            self.spacing.unwrap_or(spacing),
        );
        LabelConfig {
            sampling_rate_hz: self.fs_hz.unwrap_or(own.sampling_rate_hz),
            array: if is_asked { asked } else { own.array },
            ..own.clone()
        }
    }
}

/// Delay axis of labels; what is not given stays as it is.
#[derive(Debug, Clone, Args)]
pub struct DelayArgs {
    /// Points of the delay axis [default: those of the data set, if there is one, else 401 paper, 128 released].
    #[arg(long)]
    delay_points: Option<usize>,
    /// Last delay of the axis [s; default: that of the data set, if there is one, else 1e-6].
    #[arg(long)]
    last_delay_s: Option<f64>,
}

impl DelayArgs {
    /// The axis given, and another where none is.
    pub fn over(&self, own: DelayAxis) -> DelayAxis {
        DelayAxis {
            points: self.delay_points.unwrap_or(own.points),
            last_s: self.last_delay_s.unwrap_or(own.last_s),
        }
    }
}

/// Settings of labels.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Labels")]
pub struct LabelArgs {
    /// Definition of the label: paper, or released (what the published code computes).
    #[arg(long, default_value_t)]
    pub protocol: Protocol,
    #[command(flatten)]
    array: ArrayArgs,
}

impl LabelArgs {
    /// The label's configuration, with the delay axis of the protocol.
    pub fn config(&self, pdp: bool) -> LabelConfig {
        LabelConfig {
            pdp,
            ..self.array.over(&LabelConfig::of(self.protocol))
        }
    }
}

/// Reads `X,Y` in metres.
pub fn parse_point(text: &str) -> Result<DVec2, String> {
    let number = |text: &str| text.trim().parse().ok();
    let point = text
        .split_once(',')
        .and_then(|(x, y)| Some(DVec2::new(number(x)?, number(y)?)));
    point.ok_or_else(|| format!("'{text}' is not a pair of numbers like 12.5,40"))
}

/// Reads a heading in degrees.
pub fn parse_heading(text: &str) -> Result<f64, String> {
    let (least, most) = (HEADINGS_DEG.start(), HEADINGS_DEG.end());
    let heading_deg = text.parse::<f64>().ok();
    let heading_deg = heading_deg.filter(|deg| HEADINGS_DEG.contains(deg));
    heading_deg.ok_or_else(|| format!("'{text}' is no heading in degrees, from {least} to {most}"))
}
