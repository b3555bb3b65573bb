//! Polynomials, searched and halved until the maximum is settled.

use std::mem;

use multiversion::multiversion;

use super::Continuous;
use super::pieces::Piece;
use crate::polynomial::{self, NODES};
use crate::product::LANES;

/// Relative room left to a polynomial above the best value found; with the error of the
/// interpolation, M is found to 2.25e-7 of itself, 9.8e-7 dB.
const TOLERANCE: f64 = 4e-8;

/// Searches the pieces, and halves of them, until none can be above (1 + TOLERANCE) times the best
/// of its column.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub fn settle(search: &mut Continuous) {
    let (best, place) = (
        search.best.as_flattened_mut(),
        search.place.as_flattened_mut(),
    );
    let (pieces, halves) = (&mut search.pieces, &mut search.halves);
    while !pieces.list.is_empty() {
        #[cfg(test)]
        {
            search.polynomials += pieces.list.len();
        }
        for (eight, values) in pieces.list.chunks_mut(LANES).zip(&pieces.values) {
            let mut c = polynomial::interpolate(values);
            let (x, upper) = polynomial::top(&mut c);
            for (l, piece) in eight.iter_mut().enumerate() {
                piece.upper = upper[l];
                if c[0][l] > best[piece.column] {
                    best[piece.column] = c[0][l];
                    place[piece.column] = piece.middle + piece.half_width * x[l];
                }
            }
        }
        halves.clear();
        for (i, piece) in pieces.list.iter().enumerate() {
            if piece.upper > (1.0 + TOLERANCE) * best[piece.column] {
                let c = polynomial::interpolate(
                    &pieces.values[i / LANES].map(|values| [values[i % LANES]]),
                );
                for middle in [-0.5, 0.5] {
                    let half = Piece {
                        middle: piece.middle + piece.half_width * middle,
                        half_width: 0.5 * piece.half_width,
                        ..*piece
                    };
                    let value = |x: f64| c.iter().rev().fold(0.0, |sum, [c]| sum * x + c);
                    halves.push(half, NODES.map(|node| value(middle + 0.5 * node)));
                }
            }
        }
        mem::swap(pieces, halves);
    }
}
