//! Fields of the tracer beside those of the reference.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Complex64, InteractionKind, Link, PathRecord, Scene, TraceConfig, Tracer};
use aps_tests::fullwave::{FullWave, WAVENUMBER_PER_M, Walls, line_source_field};

use super::setting::Setting;
use crate::Stopwatch;

/// Errors beyond this, and links without a path, count as this.
const MOST_DB: f64 = 40.0;
/// Fields that much below those of free space are not compared: down to here the reference is good to 0.13 dB.
const FLOOR_DB: f64 = -80.0;
/// Elements of an array, half a wavelength apart.
const ELEMENTS: usize = 16;
/// The element where the paths are traced to.
const CENTRE: usize = 7;
/// Directions tried, evenly spread over their cosine.
const DIRECTIONS: usize = 1441;

/// A scene with walls of one material, and the fields there.
pub struct Reference<'f> {
    pub full: &'f FullWave,
    pub walls: Walls,
    scene: Scene,
    sources: Vec<DVec2>,
    receivers: Vec<DVec2>,
    /// Fields by source, then by receiver.
    fields: Vec<Complex64>,
}

/// Results of a setting, link by link.
#[derive(Default)]
pub struct Comparison {
    /// Field found over the field there; 0 for no path.
    ratio: Vec<Complex64>,
    /// Ratio with the reference's reflection coefficients.
    ratio_of_its_material: Vec<Complex64>,
    /// Corners on the strongest path.
    pub corners: Vec<usize>,
    /// The least distance of any of them to its boundary.
    pub boundaries: Vec<Option<f64>>,
    /// Links to the middle of an array, and the errors of its strongest direction \[deg\].
    pub directions: Vec<(usize, f64)>,
    /// Paths of all links.
    pub paths: usize,
    /// Time of a link \[us\]: of one run, unless it was taken more often.
    pub time_us: f64,
}

impl<'f> Reference<'f> {
    pub fn new(full: &'f FullWave, walls: Walls) -> Result<Self> {
        let sources = full.sources();
        Ok(Self {
            full,
            walls,
            scene: full.scene()?,
            fields: (0..sources.len())
                .flat_map(|source| full.fields(walls, source))
                .collect(),
            sources,
            receivers: full.receivers(),
        })
    }

    pub fn link_count(&self) -> usize {
        self.fields.len()
    }

    /// Source and place of the receiver of a link.
    pub fn link(&self, i: usize) -> (usize, DVec2) {
        let count = self.receivers.len();
        (i / count, self.receivers[i % count])
    }

    /// Level over free space.
    pub fn level_db(&self, i: usize) -> f64 {
        let (source, place) = self.link(i);
        let distance = self.sources[source].distance(place);
        20.0 * (self.fields[i].norm() * distance.sqrt()).log10()
    }

    /// The links that are compared.
    pub fn compared(&self) -> impl Iterator<Item = usize> {
        (0..self.link_count()).filter(|&i| self.level_db(i) > FLOOR_DB)
    }

    fn tracer(&self, config: &TraceConfig) -> Result<Tracer<'_>> {
        Ok(Tracer::new(&self.scene, self.walls.config(config.clone()))?)
    }

    pub fn compare(&self, config: &TraceConfig) -> Result<Comparison> {
        let began = Instant::now();
        let tracer = self.tracer(config)?;
        let receivers = self.receivers.iter().map(|&place| tracer.receiver(place));
        let receivers = receivers.collect::<Result<Vec<_>, _>>()?;
        let mut found = Comparison::default();
        let mut time = began.elapsed();
        let mut link = Link::default();
        for (i, &source) in self.sources.iter().enumerate() {
            let began = Instant::now();
            let tx = tracer.transmitter(source)?;
            time += began.elapsed();
            let mut all = Vec::new();
            for (rx, &place) in receivers.iter().zip(&self.receivers) {
                let began = Instant::now();
                tracer.link(&tx, rx, &mut link)?;
                time += began.elapsed();
                let truth = self.fields[found.ratio.len()];
                found.push(self, &link.paths, [source, place], truth);
                all.push(link.paths.clone());
            }
            for first in self.full.arrays(ELEMENTS) {
                let error = self.direction_error_deg(i, first, &all[first + CENTRE]);
                let link = i * self.receivers.len() + first + CENTRE;
                found.directions.extend(error.map(|error| (link, error)));
            }
        }
        found.time_us = 1e6 * time.as_secs_f64() / self.link_count() as f64;
        Ok(found)
    }

    /// The error of the strongest direction of an array; none where its field is below the floor or no path is found.
    fn direction_error_deg(
        &self,
        source: usize,
        first: usize,
        paths: &[PathRecord],
    ) -> Option<f64> {
        let at = source * self.receivers.len() + first;
        if paths.is_empty() || self.level_db(at + CENTRE) < FLOOR_DB {
            return None;
        }
        let axis = (self.receivers[first + 1] - self.receivers[first]).normalize();
        let mut elements = [Complex64::ZERO; ELEMENTS];
        for path in paths {
            let towards = DVec2::from_angle(path.arrival_azimuth_rad);
            for (m, element) in elements.iter_mut().enumerate() {
                let phase = PI * (m as f64 - CENTRE as f64) * towards.dot(axis);
                *element += line_source_field(path) * Complex64::cis(phase);
            }
        }
        let [found, truth] = [&elements[..], &self.fields[at..at + ELEMENTS]].map(strongest);
        Some((found.acos() - truth.acos()).abs().to_degrees())
    }

    /// Time a link [s] at each of the settings.
    pub fn times(&self, settings: &[Setting], stopwatch: Stopwatch) -> Result<Vec<f64>> {
        let trace = |setting: &Setting| -> Result<usize> {
            let tracer = self.tracer(&setting.config)?;
            let receivers = self.receivers.iter().map(|&place| tracer.receiver(place));
            let receivers = receivers.collect::<Result<Vec<_>, _>>()?;
            let (mut link, mut paths) = (Link::default(), 0);
            for &source in &self.sources {
                let tx = tracer.transmitter(source)?;
                for rx in &receivers {
                    tracer.link(&tx, rx, &mut link)?;
                    paths += link.paths.len();
                }
            }
            Ok(paths)
        };
        // No error comes here: `compare` traced the same before.
        let time = |setting: &Setting| drop(std::hint::black_box(trace(setting)));
        stopwatch.each(settings, self.link_count(), time)
    }
}

impl Comparison {
    fn push(
        &mut self,
        reference: &Reference<'_>,
        paths: &[PathRecord],
        [tx, rx]: [DVec2; 2],
        truth: Complex64,
    ) {
        let walls = reference.scene.walls();
        let of_material = |path: &PathRecord| match reference.walls {
            Walls::Conductor => Complex64::ONE,
            Walls::Concrete => reference.full.material_factor(path, tx, walls),
        };
        let field: Complex64 = paths.iter().map(line_source_field).sum();
        let corrected: Complex64 = paths
            .iter()
            .map(|path| line_source_field(path) * of_material(path))
            .sum();
        self.ratio.push(field / truth);
        self.ratio_of_its_material.push(corrected / truth);
        self.paths += paths.len();
        let best = paths.iter().max_by(|p, q| p.power().total_cmp(&q.power()));
        let turns = best.map_or(Vec::new(), |path| boundaries(path, tx, rx));
        self.corners.push(turns.len());
        self.boundaries.push(turns.into_iter().reduce(f64::min));
    }

    pub fn is_reached(&self, i: usize) -> bool {
        self.ratio[i] != Complex64::ZERO
    }

    /// Level found over the level there.
    pub fn error_db(&self, i: usize) -> f64 {
        error_db(self.ratio[i])
    }

    /// Error of the strongest direction of the array whose middle is the link's receiver \[deg\].
    pub fn direction_error_deg(&self, i: usize) -> Option<f64> {
        let found = self.directions.iter().find(|&&(link, _)| link == i);
        found.map(|&(_, error)| error)
    }

    pub fn error_of_its_material_db(&self, i: usize) -> f64 {
        error_db(self.ratio_of_its_material[i])
    }
}

fn error_db(ratio: Complex64) -> f64 {
    (20.0 * ratio.norm().log10()).clamp(-MOST_DB, MOST_DB)
}

/// sqrt(2 k L) sin(delta / 2) of each corner on a path, delta the angle by which it turns there.
fn boundaries(path: &PathRecord, tx: DVec2, rx: DVec2) -> Vec<f64> {
    let mut places = vec![tx];
    places.extend(path.interactions.iter().map(|i| i.point));
    places.push(rx);
    let is_corner = |i: usize| path.interactions[i - 1].kind == InteractionKind::Diffraction;
    let corners: Vec<usize> = (1..places.len() - 1).filter(|&i| is_corner(i)).collect();
    let length = |from: usize, to: usize| -> f64 {
        let steps = places[from..=to].windows(2);
        steps.map(|step| step[0].distance(step[1])).sum()
    };
    let boundary = |i: usize| {
        let before = if i == 0 { 0 } else { corners[i - 1] };
        let after = corners.get(i + 1).copied().unwrap_or(places.len() - 1);
        let at = corners[i];
        let (a, b) = (length(before, at), length(at, after));
        let (into, out) = (places[at] - places[at - 1], places[at + 1] - places[at]);
        let half = 0.5 * into.angle_to(out);
        (2.0 * WAVENUMBER_PER_M * a * b / (a + b)).sqrt() * half.sin().abs()
    };
    (0..corners.len()).map(boundary).collect()
}

/// The cosine of the angle from the array's axis where its response is largest.
fn strongest(elements: &[Complex64]) -> f64 {
    let response = |cos: f64| {
        let terms = elements.iter().enumerate();
        let sum: Complex64 = terms
            .map(|(m, &element)| element * Complex64::cis(-PI * m as f64 * cos))
            .sum();
        sum.norm_sqr()
    };
    let cosines = (0..DIRECTIONS).map(|i| 2.0 * i as f64 / (DIRECTIONS - 1) as f64 - 1.0);
    let best = cosines.map(|cos| (response(cos), cos));
    best.max_by(|p, q| p.0.total_cmp(&q.0)).map_or(0.0, |p| p.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_finds_the_direction_of_a_plane_wave() {
        let wave: Vec<Complex64> = (0..ELEMENTS)
            .map(|m| Complex64::cis(PI * m as f64 * 0.35 + 1.0))
            .collect();
        assert!((strongest(&wave) - 0.35).abs() < 2e-3);
    }
}
