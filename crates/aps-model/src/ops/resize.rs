//! Changes of resolution.

use candle_core::{Result, Tensor};

use super::portable;
use crate::recording::{Graph, Value, ints, recorded, word};

/// [`portable::resize_bilinear`].
pub(crate) fn resize_bilinear(x: &Tensor, height: usize, width: usize) -> Result<Tensor> {
    let (_, _, old_height, old_width) = x.dims4()?;
    let nodes = |g: &mut Graph, v: &[Value]| {
        if (old_height, old_width) == (height, width) {
            return v[0];
        }
        let columns = portable::interpolation(old_width, width);
        let rows = portable::interpolation(old_height, height);
        let columns = g.numbers(&[old_width, width], &columns);
        let rows = g.numbers(&[old_height, height], &rows);
        let rows = g.node("Transpose", &[rows], [ints("perm", [1, 0])]);
        let wide = g.node("MatMul", &[v[0], columns], []);
        g.node("MatMul", &[rows, wide], [])
    };
    let compute = || portable::resize_bilinear(x, height, width);
    recorded(&[x], nodes, compute)
}

/// [`portable::upsample_nearest_2x`] of (batch, channels, length).
pub(crate) fn upsample_nearest_2x(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let (none, scales) = (g.none(), g.numbers(&[3], &[1.0, 1.0, 2.0]));
        let settings = [
            word("mode", "nearest"),
            word("coordinate_transformation_mode", "asymmetric"),
            word("nearest_mode", "floor"),
        ];
        g.node("Resize", &[v[0], none, scales], settings)
    };
    recorded(&[x], nodes, || portable::upsample_nearest_2x(x))
}
