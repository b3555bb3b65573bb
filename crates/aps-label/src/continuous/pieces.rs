//! Polynomials to be searched, by eights.

use crate::product::{LANES, Lanes};

/// A polynomial to be searched, and the part of the delay axis that its \[-1, 1\] stands for.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    pub column: usize,
    pub middle: f64,
    pub half_width: f64,
    /// Upper bound of the polynomial, once it is searched.
    pub upper: f64,
}

/// Pieces, and their polynomials' values by eights, `[node][lane]`.
#[derive(Debug, Clone, Default)]
pub struct Pieces {
    pub list: Vec<Piece>,
    pub values: Vec<[Lanes; LANES]>,
}

impl Pieces {
    pub fn clear(&mut self) {
        self.list.clear();
        self.values.clear();
    }

    #[inline(always)]
    pub fn push(&mut self, piece: Piece, values: Lanes) {
        let lane = self.list.len() % LANES;
        if lane == 0 {
            self.values.push([[0.0; LANES]; LANES]);
        }
        if let Some(last) = self.values.last_mut() {
            for (row, value) in last.iter_mut().zip(values) {
                row[lane] = value;
            }
        }
        self.list.push(piece);
    }
}
