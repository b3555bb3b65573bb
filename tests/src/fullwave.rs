//! The field of line sources in small scenes, computed without rays: `tests/golden/fullwave`.
//!
//! Lengths are in wavelengths, and the tracer's carrier is such that a wavelength is 1 m. A line source's waves are circles: a path
//! with the legs s_i brings prod D prod Gamma e^{-j k L} / sqrt(prod s_i), which is its gain times sqrt(L) 4 pi / lambda.

use std::f64::consts::{PI, TAU};

use aps_raytrace::glam::DVec2;
use aps_raytrace::{
    Complex64, Footprint, Interaction, InteractionKind, Material, PathRecord,
    SPEED_OF_LIGHT_M_PER_S, Scene, SceneError, TraceConfig, VACUUM_PERMITTIVITY_F_PER_M, Wall,
};
use serde::Deserialize;

/// Wavenumber \[1/m\] of a wavelength of 1 m.
pub const WAVENUMBER_PER_M: f64 = TAU;

/// Relative permittivity of concrete at 3.5 GHz, real and the magnitude of the imaginary part.
const CONCRETE: [f64; 2] = [5.24, 0.6322];

/// A material of all walls of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walls {
    /// A perfect conductor.
    Conductor,
    /// Concrete: the tracer has a dielectric, the reference an impedance near it.
    Concrete,
}

impl Walls {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::Conductor, Self::Concrete];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Conductor => "conductor",
            Self::Concrete => "concrete",
        }
    }

    /// Returns `limits` for these walls and a wavelength of 1 m.
    #[must_use]
    pub fn config(self, limits: TraceConfig) -> TraceConfig {
        let frequency_hz = SPEED_OF_LIGHT_M_PER_S;
        let [permittivity, loss] = CONCRETE;
        TraceConfig {
            frequency_hz,
            material: match self {
                Self::Conductor => Material::PerfectConductor,
                Self::Concrete => Material::Dielectric {
                    relative_permittivity: permittivity,
                    conductivity_s_per_m: loss * TAU * frequency_hz * VACUUM_PERMITTIVITY_F_PER_M,
                },
            },
            ..limits
        }
    }
}

#[derive(Debug, Clone, Deserialize)]
struct Stored {
    polygons: Vec<Vec<[f64; 2]>>,
    sources: Vec<[f64; 2]>,
    receivers: Vec<[f64; 2]>,
    admittance: [f64; 2],
    perfect_conductor: Vec<Vec<f64>>,
    impedance: Vec<Vec<f64>>,
}

/// A scene with its fields.
#[derive(Debug, Clone)]
pub struct FullWave {
    /// Name of its file.
    pub name: &'static str,
    stored: Stored,
}

/// Names and contents of the stored scenes.
const FILES: [(&str, &str); 10] = [
    ("block05", include_str!("../golden/fullwave/block05.json")),
    ("block10", include_str!("../golden/fullwave/block10.json")),
    ("block20", include_str!("../golden/fullwave/block20.json")),
    ("block40", include_str!("../golden/fullwave/block40.json")),
    ("canyon", include_str!("../golden/fullwave/canyon.json")),
    ("behind", include_str!("../golden/fullwave/behind.json")),
    (
        "courtyard",
        include_str!("../golden/fullwave/courtyard.json"),
    ),
    ("terrace", include_str!("../golden/fullwave/terrace.json")),
    ("needle", include_str!("../golden/fullwave/needle.json")),
    ("town", include_str!("../golden/fullwave/town.json")),
];

impl FullWave {
    /// Reads the stored scenes.
    ///
    /// # Panics
    /// For a file that is none.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let scene = |(name, text): (&'static str, &str)| Self {
            name,
            stored: serde_json::from_str(text).expect("a stored scene"),
        };
        FILES.into_iter().map(scene).collect()
    }

    /// The scene of a name.
    ///
    /// # Panics
    /// For a name that no scene has.
    #[must_use]
    pub fn named(name: &str) -> Self {
        let mut all = Self::all().into_iter();
        all.find(|scene| scene.name == name).expect("a scene")
    }

    /// Its houses.
    ///
    /// # Errors
    /// None that the stored scenes cause.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        let house = |ring: &Vec<[f64; 2]>| {
            Footprint::new(ring.iter().map(|&p| p.into()).collect::<Vec<_>>())
        };
        let houses: Vec<_> = self.stored.polygons.iter().map(house).collect();
        Scene::new(&houses, None)
    }

    /// Length of its longest wall.
    #[must_use]
    pub fn longest_wall(&self) -> f64 {
        let rings = self.stored.polygons.iter();
        let walls = rings.flat_map(|ring| {
            let next = ring.iter().cycle().skip(1);
            ring.iter().zip(next)
        });
        let lengths = walls.map(|(&a, &b)| DVec2::from(a).distance(b.into()));
        lengths.fold(0.0, f64::max)
    }

    /// Places of the line sources.
    #[must_use]
    pub fn sources(&self) -> Vec<DVec2> {
        self.stored.sources.iter().map(|&p| p.into()).collect()
    }

    /// Places of the receivers.
    #[must_use]
    pub fn receivers(&self) -> Vec<DVec2> {
        self.stored.receivers.iter().map(|&p| p.into()).collect()
    }

    /// The field at the receivers: far from a source without houses e^{-j k r} / sqrt(r).
    #[must_use]
    pub fn fields(&self, walls: Walls, source: usize) -> Vec<Complex64> {
        let fields = match walls {
            Walls::Conductor => &self.stored.perfect_conductor,
            Walls::Concrete => &self.stored.impedance,
        };
        let (pairs, _) = fields[source].as_chunks::<2>();
        pairs
            .iter()
            .map(|&[re, im]| Complex64::new(re, im))
            .collect()
    }

    /// First receivers of arrays: `count` in a row, half a wavelength apart.
    #[must_use]
    pub fn arrays(&self, count: usize) -> Vec<usize> {
        let receivers = self.receivers();
        let is_array = |&first: &usize| {
            let places = &receivers[first..first + count];
            let step = places[1] - places[0];
            let is_step = |pair: &[DVec2]| (pair[1] - pair[0]).distance(step) < 1e-6;
            (step.length() - 0.5).abs() < 1e-6 && places.windows(2).all(is_step)
        };
        let firsts = 0..(receivers.len() + 1).saturating_sub(count);
        firsts.filter(is_array).collect()
    }

    /// Reflection coefficient of the reference's walls of concrete, from the cosine of the angle of incidence.
    #[must_use]
    pub fn reflection(&self, cos_incidence: f64) -> Complex64 {
        let [re, im] = self.stored.admittance;
        let admittance = Complex64::new(re, im);
        (cos_incidence - admittance) / (cos_incidence + admittance)
    }

    /// Factor that turns a path at walls of concrete into one at the reference's, as far as reflections go; `walls` are the scene's.
    #[must_use]
    pub fn material_factor(&self, path: &PathRecord, tx: DVec2, walls: &[Wall]) -> Complex64 {
        let material = Walls::Concrete.config(TraceConfig::default()).material;
        let reflector = material.at(SPEED_OF_LIGHT_M_PER_S);
        let before = std::iter::once(tx).chain(path.interactions.iter().map(|i| i.point));
        let factor = |(before, at): (DVec2, &Interaction)| {
            if at.kind == InteractionKind::Diffraction {
                return Complex64::ONE;
            }
            let ray = (at.point - before).normalize_or_zero();
            let outward = walls[at.id as usize].outward().normalize_or_zero();
            let cos = ray.dot(outward).abs();
            self.reflection(cos) / reflector.reflection(cos)
        };
        before.zip(&path.interactions).map(factor).product()
    }
}

/// The field that a path brings from a line source.
#[must_use]
pub fn line_source_field(path: &PathRecord) -> Complex64 {
    path.gain * (path.length_m.sqrt() * 4.0 * PI)
}
