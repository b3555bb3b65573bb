//! Memory of the search, kept from link to link.

use super::pieces::Pieces;
use crate::cover::Cell;
use crate::product::Lanes;

/// Columns sampled at once.
pub const WIDE: usize = 16;
/// Sample points taken at once.
pub const POINTS: usize = 4;
/// Single precision numbers of columns that are sampled at once.
pub type Wide = [f32; WIDE];

/// Scratch space of the search.
#[derive(Debug, Clone, Default)]
pub struct Continuous {
    /// u_k, in the order of the paths, and sorted.
    pub places: Vec<f64>,
    pub sorted: Vec<f64>,
    pub points: Vec<f64>,
    pub cells: Vec<Cell>,
    /// The pulses at eight points, a row a path.
    pub pulses: Vec<Lanes>,
    /// Pulses in single precision, [`POINTS`] at once.
    pub rows: Vec<[f32; POINTS]>,
    /// Per path: the distance of the nearest of eight points, and the bound of a pulse that is far.
    pub nearest: Vec<f64>,
    pub far: Vec<f32>,
    /// The paths that are near, and their places.
    pub near: Vec<usize>,
    pub near_places: Vec<f64>,
    /// Columns' weights, `[block][path]`.
    pub weights: Vec<Wide>,
    /// `[cell][block]`; and of each column the largest, then the least that keeps a cell.
    pub samples: Vec<Wide>,
    pub least: Vec<Wide>,
    pub remaining: Vec<usize>,
    pub pieces: Pieces,
    pub halves: Pieces,
    /// Per column: the maximum, and where it is [1/f_s after the first path].
    pub best: Vec<Lanes>,
    pub place: Vec<Lanes>,
    /// Polynomials searched so far.
    #[cfg(test)]
    pub polynomials: usize,
}
