//! Strengths of ways by a perceptron, added by direction: a link at a time, so that what lies between the layers stays in cache.

use rayon::prelude::*;

use super::buffer::Buffer;
use super::exponential::exp;
use super::gelu::{gelu_of, multiply_by_slope};
use super::matmul::{Matrix, multiply};

/// Links of one task of a gradient.
const LINKS: usize = 4;

/// Lists of ways, (links, slots, features + 2) with direction and kind behind the features, and the perceptron that makes a strength
/// of each: a layer of the features and the kind as a unit vector, a layer, and an output, with GELU between.
///
/// A way's strength is exp(`spread` times the output, at most `max_log`), times (feature 0 + `least_share`), times feature 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WaysShape {
    /// Ways in the list of a link.
    pub slots: usize,
    pub features: usize,
    pub kinds: usize,
    pub directions: usize,
    /// Outputs of the first two layers.
    pub hidden: usize,
    pub spread: f32,
    pub max_log: f32,
    pub least_share: f32,
}

/// The parameters of the perceptron: matrices (out, in), and biases.
struct Parameters<'a> {
    embed: &'a [f32],
    hidden: &'a [f32],
    hidden_bias: &'a [f32],
    out: &'a [f32],
    out_bias: &'a [f32],
}

/// Values of the layers of one link, before and after the activation: (ways, hidden), and the outputs (ways).
struct Layers<'a> {
    embedded: &'a mut [f32],
    embedded_after: &'a mut [f32],
    hidden: &'a mut [f32],
    hidden_after: &'a mut [f32],
    out: &'a mut [f32],
}

/// Adds the strengths of ways by direction: (links, directions). `parameters` holds weight and bias of each layer one after the other.
///
/// # Panics
/// If the direction or kind of a way is not below its number.
pub(crate) fn sums(ways: &[f32], parameters: &[f32], s: &WaysShape) -> Vec<f32> {
    let (parameters, of_kind) = s.prepared(parameters);
    let links = ways.len() / (s.slots * s.per_way());
    let mut out = vec![0.0; links * s.directions];
    let of_links = ways.par_chunks_exact(s.slots * s.per_way());
    let of_links = of_links.zip(out.par_chunks_exact_mut(s.directions));
    of_links.for_each(|(ways, sums)| {
        let ways = s.without_padding(ways);
        let mut memory = s.memory(ways);
        let layers = s.forward(ways, &parameters, &of_kind, &mut memory);
        for (way, &out) in ways.chunks_exact(s.per_way()).zip(&*layers.out) {
            sums[way[s.features] as usize] += s.strength(way, out);
        }
    });
    out
}

/// The gradient of [`sums`] by its parameters.
pub(crate) fn gradient(ways: &[f32], parameters: &[f32], grad: &[f32], s: &WaysShape) -> Vec<f32> {
    let count = parameters.len();
    let (parameters, of_kind) = s.prepared(parameters);
    let per_link = s.slots * s.per_way();
    let tasks = ways.par_chunks(LINKS * per_link);
    let tasks = tasks.zip(grad.par_chunks(LINKS * s.directions));
    let of_task = |(ways, grad): (&[f32], &[f32])| {
        let mut sums = vec![0.0; count];
        let mut by_kind = vec![0.0; of_kind.len()];
        let links = ways
            .chunks_exact(per_link)
            .zip(grad.chunks_exact(s.directions));
        for (ways, grad) in links {
            let ways = s.without_padding(ways);
            let mut memory = s.memory(ways);
            let layers = s.forward(ways, &parameters, &of_kind, &mut memory);
            s.backward(ways, &parameters, layers, grad, &mut sums, &mut by_kind);
        }
        s.add_by_kind(&by_kind, &mut sums);
        sums
    };
    let of_tasks: Vec<Vec<f32>> = tasks.map(of_task).collect();
    let sum = |i: usize| of_tasks.iter().map(|task| f64::from(task[i])).sum::<f64>() as f32;
    (0..count).map(sum).collect()
}

impl WaysShape {
    fn per_way(&self) -> usize {
        self.features + 2
    }

    fn inputs(&self) -> usize {
        self.features + self.kinds
    }

    /// Numbers of parameters, in their order.
    fn lengths(&self) -> [usize; 6] {
        let hidden = self.hidden;
        let embed = hidden * self.inputs();
        [embed, hidden, hidden * hidden, hidden, hidden, 1]
    }

    /// Takes the parameters apart, and makes the first layer's bias for each kind: (kinds, hidden).
    fn prepared<'a>(&self, parameters: &'a [f32]) -> (Parameters<'a>, Vec<f32>) {
        let mut rest = parameters;
        let [embed, embed_bias, hidden, hidden_bias, out, out_bias] = self.lengths().map(|len| {
            let (first, others) = rest.split_at(len);
            rest = others;
            first
        });
        let column = |kind: usize| {
            let rows = embed.chunks_exact(self.inputs()).zip(embed_bias);
            rows.map(move |(row, bias)| bias + row[self.features + kind])
        };
        let of_kind = (0..self.kinds).flat_map(column).collect();
        let parameters = Parameters {
            embed,
            hidden,
            hidden_bias,
            out,
            out_bias,
        };
        (parameters, of_kind)
    }

    /// Cuts off the ways of zeros at the end of a list.
    fn without_padding<'a>(&self, ways: &'a [f32]) -> &'a [f32] {
        let last = ways
            .chunks_exact(self.per_way())
            .rposition(|way| way[1] != 0.0);
        &ways[..last.map_or(0, |last| (last + 1) * self.per_way())]
    }

    fn memory(&self, ways: &[f32]) -> Buffer {
        Buffer::of(ways.len() / self.per_way() * (4 * self.hidden + 1))
    }

    fn strength(&self, way: &[f32], out: f32) -> f32 {
        let log = self.spread * out;
        // Not `min`, which makes a number of NaN.
        let log = if log > self.max_log {
            self.max_log
        } else {
            log
        };
        exp(log) * (way[0] + self.least_share) * way[1]
    }

    fn forward<'a>(
        &self,
        ways: &[f32],
        parameters: &Parameters<'_>,
        of_kind: &[f32],
        memory: &'a mut [f32],
    ) -> Layers<'a> {
        let (count, hidden) = (ways.len() / self.per_way(), self.hidden);
        let (embedded, rest) = memory.split_at_mut(count * hidden);
        let (embedded_after, rest) = rest.split_at_mut(count * hidden);
        let (second, rest) = rest.split_at_mut(count * hidden);
        let (second_after, out) = rest.split_at_mut(count * hidden);
        let rows = embedded
            .chunks_exact_mut(hidden)
            .zip(ways.chunks_exact(self.per_way()));
        for (row, way) in rows {
            let kind = way[self.features + 1] as usize;
            row.copy_from_slice(&of_kind[kind * hidden..][..hidden]);
        }
        // Rows of a layer are the columns that a product writes.
        let weight = Matrix::rows(parameters.embed, self.inputs());
        let x = Matrix::columns(ways, self.per_way());
        multiply(
            (hidden, count, self.features),
            weight,
            x,
            embedded,
            hidden,
            true,
        );
        gelu_of(embedded, embedded_after);
        for row in second.chunks_exact_mut(hidden) {
            row.copy_from_slice(parameters.hidden_bias);
        }
        let weight = Matrix::rows(parameters.hidden, hidden);
        let x = Matrix::columns(embedded_after, hidden);
        multiply((hidden, count, hidden), weight, x, second, hidden, true);
        gelu_of(second, second_after);
        out.fill(parameters.out_bias[0]);
        let weight = Matrix::rows(parameters.out, hidden);
        let x = Matrix::columns(second_after, hidden);
        multiply((1, count, hidden), weight, x, out, 1, true);
        Layers {
            embedded,
            embedded_after,
            hidden: second,
            hidden_after: second_after,
            out,
        }
    }

    /// Adds the gradients of one link to those of the parameters; those of the first layer's bias by kind, (kinds, hidden). Layers are
    /// overwritten.
    fn backward(
        &self,
        ways: &[f32],
        parameters: &Parameters<'_>,
        layers: Layers<'_>,
        grad: &[f32],
        sums: &mut [f32],
        by_kind: &mut [f32],
    ) {
        let (count, hidden) = (ways.len() / self.per_way(), self.hidden);
        let [embed_len, bias_len, hidden_len, ..] = self.lengths();
        let (by_embed, rest) = sums.split_at_mut(embed_len);
        let (by_hidden, rest) = rest[bias_len..].split_at_mut(hidden_len);
        let (by_hidden_bias, rest) = rest.split_at_mut(hidden);
        let (by_out, by_out_bias) = rest.split_at_mut(hidden);
        let Layers {
            embedded,
            embedded_after,
            hidden: second,
            hidden_after: second_after,
            out,
        } = layers;
        for (way, out) in ways.chunks_exact(self.per_way()).zip(&mut *out) {
            let is_capped = self.spread * *out > self.max_log;
            let slope = if is_capped { 0.0 } else { self.spread };
            *out = grad[way[self.features] as usize] * self.strength(way, *out) * slope;
            by_out_bias[0] += *out;
        }
        let by_row = Matrix::columns(out, count);
        let after = Matrix::columns(second_after, hidden);
        multiply((hidden, 1, count), after, by_row, by_out, hidden, true);
        // What comes after an activation is done with, and takes the gradient.
        for (row, &by_row) in second_after.chunks_exact_mut(hidden).zip(&*out) {
            for (value, weight) in row.iter_mut().zip(parameters.out) {
                *value = by_row * weight;
            }
        }
        multiply_by_slope(second, second_after);
        add_rows(second_after, by_hidden_bias);
        let after = Matrix::columns(embedded_after, hidden);
        let by_second = Matrix::rows(second_after, hidden);
        multiply(
            (hidden, hidden, count),
            after,
            by_second,
            by_hidden,
            hidden,
            true,
        );
        let weight = Matrix::columns(parameters.hidden, hidden);
        let by_second = by_second.transposed();
        multiply(
            (hidden, count, hidden),
            weight,
            by_second,
            embedded_after,
            hidden,
            false,
        );
        multiply_by_slope(embedded, embedded_after);
        let x = Matrix::columns(ways, self.per_way());
        let by_first = Matrix::rows(embedded_after, hidden);
        let sizes = (self.features, hidden, count);
        multiply(sizes, x, by_first, by_embed, self.inputs(), true);
        for (row, way) in embedded_after
            .chunks_exact(hidden)
            .zip(ways.chunks_exact(self.per_way()))
        {
            let kind = way[self.features + 1] as usize;
            add_rows(row, &mut by_kind[kind * hidden..][..hidden]);
        }
    }

    /// Adds gradients by kind, (kinds, hidden), to those of the first layer's weight and bias.
    fn add_by_kind(&self, by_kind: &[f32], sums: &mut [f32]) {
        let (by_embed, rest) = sums.split_at_mut(self.lengths()[0]);
        for (kind, by_kind) in by_kind.chunks_exact(self.hidden).enumerate() {
            let rows = by_embed.chunks_exact_mut(self.inputs()).zip(&mut *rest);
            for ((row, bias), grad) in rows.zip(by_kind) {
                row[self.features + kind] += grad;
                *bias += grad;
            }
        }
    }
}

/// Adds each row to `sum`.
fn add_rows(rows: &[f32], sum: &mut [f32]) {
    for row in rows.chunks_exact(sum.len()) {
        for (sum, value) in sum.iter_mut().zip(row) {
            *sum += value;
        }
    }
}
