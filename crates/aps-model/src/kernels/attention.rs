//! Self-attention with several heads, from queries, keys and values side by side.
//!
//! One thread computes each head of each sequence, from the scores to its part of the result. The backward pass computes
//! the weights anew instead of keeping tokens x tokens values a head.

use rayon::prelude::*;

use super::buffer::Buffer;
use super::matmul::{Matrix, multiply};
use super::rows::ROWS;
use super::softmax::{softmax_gradient_row, softmax_row};

/// Sizes of an attention. A token has `3 * heads * depth` values: queries, keys and values, each head after head.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heads {
    pub tokens: usize,
    pub heads: usize,
    pub depth: usize,
}

impl Heads {
    fn width(&self) -> usize {
        self.heads * self.depth
    }

    fn factor(&self) -> f32 {
        (1.0 / (self.depth as f64).sqrt()) as f32
    }

    /// Queries (0), keys (1) or values (2) of one head, counted over the batch: tokens x depth.
    fn part<'a>(&self, all: &'a [f32], number: usize, part: usize) -> Matrix<'a> {
        let (sequence, head) = (number / self.heads, number % self.heads);
        let row = 3 * self.width();
        let start = sequence * self.tokens * row + part * self.width() + head * self.depth;
        Matrix::rows(&all[start..], row)
    }

    /// One head of something (batch, tokens, width): tokens x depth.
    fn head<'a>(&self, values: &'a [f32], number: usize) -> Matrix<'a> {
        let (sequence, head) = (number / self.heads, number % self.heads);
        let start = sequence * self.tokens * self.width() + head * self.depth;
        Matrix::rows(&values[start..], self.width())
    }

    /// tokens x tokens, row by row.
    fn square<'a>(&self, values: &'a [f32]) -> Matrix<'a> {
        Matrix::rows(values, self.tokens)
    }

    /// Writes the attention weights of one head into `out`: queries x keys, rows adding up to 1.
    fn weights(&self, all: &[f32], number: usize, out: &mut [f32]) {
        let (queries, keys) = (self.part(all, number, 0), self.part(all, number, 1));
        let sizes = (self.tokens, self.tokens, self.depth);
        multiply(sizes, keys, queries.transposed(), out, self.tokens, false);
        for row in out.chunks_exact_mut(self.tokens) {
            softmax_row(row, self.factor());
        }
    }

    /// `a b` row by row into `out`, where `a` is tokens x tokens and `b` tokens x depth.
    fn mix(&self, a: Matrix<'_>, b: Matrix<'_>, out: &mut [f32]) {
        let sizes = (self.depth, self.tokens, self.tokens);
        let [b, a] = [b, a].map(Matrix::transposed);
        multiply(sizes, b, a, out, self.depth, false);
    }
}

/// Computes the attention of all sequences in `all` (batch, tokens, 3 width): (batch, tokens, width).
pub(crate) fn attend(all: &[f32], sizes: Heads) -> Vec<f32> {
    let Heads { tokens, depth, .. } = sizes;
    let mut planes = Buffer::of(all.len() / 3);
    planes
        .par_chunks_mut(tokens * depth)
        .enumerate()
        .for_each(|(number, out)| {
            let mut weights = Buffer::of(tokens * tokens);
            sizes.weights(all, number, &mut weights);
            let values = sizes.part(all, number, 2);
            sizes.mix(sizes.square(&weights), values, out);
        });
    joined(&planes, sizes, 1)
}

/// Computes the gradient by `all`, from the gradient by the result.
pub(crate) fn attend_gradient(all: &[f32], grad: &[f32], sizes: Heads) -> Vec<f32> {
    let Heads { tokens, depth, .. } = sizes;
    let mut planes = Buffer::of(all.len());
    planes
        .par_chunks_mut(3 * tokens * depth)
        .enumerate()
        .for_each(|(number, out)| {
            let [queries, keys, values] = [0, 1, 2].map(|part| sizes.part(all, number, part));
            let grad = sizes.head(grad, number);
            let mut weights = Buffer::of(tokens * tokens);
            sizes.weights(all, number, &mut weights);
            let (by_queries, rest) = out.split_at_mut(tokens * depth);
            let (by_keys, by_values) = rest.split_at_mut(tokens * depth);
            sizes.mix(sizes.square(&weights).transposed(), grad, by_values);

            let mut by_scores = Buffer::of(tokens * tokens);
            let (product, grad) = ((tokens, tokens, depth), grad.transposed());
            multiply(product, values, grad, &mut by_scores, tokens, false);
            let rows = by_scores.chunks_exact_mut(tokens);
            for (by_scores, weights) in rows.zip(weights.chunks_exact(tokens)) {
                softmax_gradient_row(weights, by_scores, sizes.factor());
            }
            let by_scores = sizes.square(&by_scores);
            sizes.mix(by_scores, keys, by_queries);
            sizes.mix(by_scores.transposed(), queries, by_keys);
        });
    joined(&planes, sizes, 3)
}

/// `parts` a head, (batch, heads, parts, tokens, depth), to (batch, tokens, parts, heads, depth).
fn joined(planes: &[f32], sizes: Heads, parts: usize) -> Vec<f32> {
    let (tokens, heads, depth) = (sizes.tokens, sizes.heads, sizes.depth);
    let mut out = vec![0.0; planes.len()];
    out.par_chunks_mut(parts * sizes.width())
        .with_min_len(ROWS)
        .enumerate()
        .for_each(|(row, out)| {
            let (sequence, token) = (row / tokens, row % tokens);
            for (i, out) in out.chunks_exact_mut(depth).enumerate() {
                let (part, head) = (i / heads, i % heads);
                let plane = (sequence * heads + head) * parts + part;
                out.copy_from_slice(&planes[(plane * tokens + token) * depth..][..depth]);
            }
        });
    out
}
