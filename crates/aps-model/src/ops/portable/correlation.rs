//! Cross-correlation with both gradients by matrix products.
//!
//! candle 0.11 computes the gradient by the input in a loop over pixels and the one by the kernel as a convolution whose kernel
//! is as large as the image, and takes the remainder of the rows by the stride for that of the columns as well. Here each of the
//! three is a product of matrices, with unfolded windows in the order (batch, height, width, channels). The graph keeps no
//! windows: gradients unfold them again.

use candle_core::{CustomOp2, Result, Tensor};

use super::computed::{Computed, forward};
use super::norm::at_least_f32;
use super::unfold::unfold;

/// Settings of a correlation.
#[derive(Debug, Clone, Copy)]
struct Settings {
    stride: usize,
    /// Zeros before and after, of rows and of columns.
    padding: [[usize; 2]; 2],
    /// Largest size of windows in memory at once.
    at_once_bytes: usize,
}

/// Cross-correlation of `x` (batch, in, height, width) with `weight` (out, in, kernel height, kernel width) of the same type,
/// so many zeros around the rows and columns.
///
/// The windows of an image take output pixels x kernel pixels x input channels x size of a value, in the gradient by the input
/// input pixels x kernel pixels / stride² x output channels x size of a value. A batch whose windows take more than
/// `at_once_bytes` is computed in parts of at least one image.
pub(crate) fn correlate(
    x: &Tensor,
    weight: &Tensor,
    stride: usize,
    padding: [usize; 2],
    at_once_bytes: usize,
) -> Result<Tensor> {
    let kernel = weight.detach().permute((2, 3, 1, 0))?;
    let settings = Settings {
        stride,
        padding: padding.map(|pad| [pad; 2]),
        at_once_bytes,
    };
    let y = products(&channels_last(x)?, &kernel, settings)?;
    let result = Computed::new(y.permute((0, 3, 1, 2))?);
    x.apply_op2(weight, Correlation { settings, result })
}

fn channels_last(x: &Tensor) -> Result<Tensor> {
    x.detach().permute((0, 2, 3, 1))?.contiguous()
}

/// Correlates `x` (batch, height, width, in) with `kernel` (height, width, in, out).
fn products(x: &Tensor, kernel: &Tensor, settings: Settings) -> Result<Tensor> {
    let (high, wide, inputs, outputs) = kernel.dims4()?;
    let matrix = kernel.reshape((high * wide * inputs, outputs))?;
    let mut parts = Vec::new();
    each_part(x, [high, wide], settings, |_, windows| {
        let (batch, rows, columns, values) = windows.dims4()?;
        let y = windows.reshape(((), values))?.matmul(&matrix)?;
        parts.push(y.reshape((batch, rows, columns, outputs))?);
        Ok(())
    })?;
    Tensor::cat(&parts, 0)
}

/// Gives `f` the windows of some images at a time, and the number of the first of them.
fn each_part(
    x: &Tensor,
    kernel: [usize; 2],
    settings: Settings,
    mut f: impl FnMut(usize, &Tensor) -> Result<()>,
) -> Result<()> {
    let (stride, padding) = (settings.stride, settings.padding);
    let (batch, height, width, channels) = x.dims4()?;
    let positions = |at: usize, size: usize| {
        let room = (size + padding[at].iter().sum::<usize>()).saturating_sub(kernel[at]);
        room / stride + 1
    };
    let pixels = positions(0, height) * positions(1, width);
    let values = pixels * kernel[0] * kernel[1] * channels;
    let bytes = values * x.dtype().size_in_bytes();
    let at_once = (settings.at_once_bytes / bytes.max(1)).clamp(1, batch.max(1));
    for first in (0..batch.max(1)).step_by(at_once) {
        let mut part = x.narrow(0, first, at_once.min(batch - first))?;
        for (dim, [before, after]) in padding.into_iter().enumerate() {
            part = part.pad_with_zeros(dim + 1, before, after)?;
        }
        f(first, &unfold(&part, kernel, stride)?)?;
    }
    Ok(())
}

/// The operation in candle's graph.
struct Correlation {
    settings: Settings,
    result: Computed,
}

impl Correlation {
    /// Gradient by the input. Pixels whose rows and columns leave the same remainders by the stride see the same part of the
    /// kernel: those of each remainder are a correlation of the gradient with that part, reversed.
    fn by_input(&self, size: [usize; 2], weight: &Tensor, grad: &Tensor) -> Result<Tensor> {
        let (batch, rows, columns, _) = grad.dims4()?;
        let (_, inputs, high, wide) = weight.dims4()?;
        // (height, width, out, in)
        let kernel = weight.permute((2, 3, 0, 1))?.contiguous()?;
        let (stride, padding) = (self.settings.stride, self.settings.padding);
        let steps = |at: usize| (size[at] + 2 * padding[at][0]).div_ceil(stride);
        let steps = [steps(0), steps(1)];
        let mut of_rows = Vec::new();
        for row in 0..stride {
            let mut of_columns = Vec::new();
            for column in 0..stride {
                let (down, right) = (self.taps(high, row), self.taps(wide, column));
                let shape = (batch, steps[0], 1, steps[1], 1, inputs);
                let y = if down.is_empty() || right.is_empty() {
                    Tensor::zeros(shape, grad.dtype(), grad.device())?
                } else {
                    let padding = [
                        [down.len() - 1, steps[0] - rows],
                        [right.len() - 1, steps[1] - columns],
                    ];
                    let index = |taps| Tensor::new(taps, grad.device());
                    let part = kernel
                        .index_select(&index(down)?, 0)?
                        .index_select(&index(right)?, 1)?;
                    let settings = Settings {
                        stride: 1,
                        padding,
                        ..self.settings
                    };
                    products(grad, &part, settings)?.reshape(shape)?
                };
                of_columns.push(y);
            }
            of_rows.push(Tensor::cat(&of_columns, 4)?);
        }
        let all = Tensor::cat(&of_rows, 2)?;
        let padded = all.reshape((batch, steps[0] * stride, steps[1] * stride, inputs))?;
        let image = padded.narrow(1, padding[0][0], size[0])?;
        let image = image.narrow(2, padding[1][0], size[1])?;
        image.permute((0, 3, 1, 2))?.contiguous()
    }

    /// Rows or columns of a kernel that meet pixels of a remainder, the last first.
    fn taps(&self, size: usize, remainder: usize) -> Vec<u32> {
        let taps = (remainder..size).step_by(self.settings.stride);
        taps.map(|tap| tap as u32).rev().collect()
    }

    /// Gradient by the kernel. Parts of a batch are summed in f32 at least, as a product sums its pixels.
    fn by_weight(&self, x: &Tensor, weight: &Tensor, grad: &Tensor) -> Result<Tensor> {
        let (outputs, inputs, high, wide) = weight.dims4()?;
        let x = channels_last(x)?;
        let shape = (high * wide * inputs, outputs);
        let mut sum = at_least_f32(&Tensor::zeros(shape, x.dtype(), x.device())?)?;
        each_part(&x, [high, wide], self.settings, |first, windows| {
            let (batch, _, _, values) = windows.dims4()?;
            let grad = grad.narrow(0, first, batch)?.reshape(((), outputs))?;
            let windows = windows.reshape(((), values))?;
            sum = (&sum + at_least_f32(&windows.t()?.matmul(&grad)?)?)?;
            Ok(())
        })?;
        let sum = sum.to_dtype(x.dtype())?;
        let sum = sum.reshape((high, wide, inputs, outputs))?;
        sum.permute((3, 2, 0, 1))?.contiguous()
    }
}

impl CustomOp2 for Correlation {
    fn name(&self) -> &'static str {
        "correlation"
    }

    forward!(cpu_fwd, CpuStorage, Cpu, CpuStorage);
    forward!(cuda_fwd, CudaStorage, Cuda, CudaStorage);
    forward!(metal_fwd, MetalStorage, Metal, MetalStorage);

    fn bwd(
        &self,
        x: &Tensor,
        weight: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let (_, _, height, width) = x.dims4()?;
        let grad = channels_last(grad)?;
        let by_input = || self.by_input([height, width], &weight.detach(), &grad);
        let by_weight = || self.by_weight(x, weight, &grad);
        Ok((
            x.track_op().then(by_input).transpose()?,
            weight.track_op().then(by_weight).transpose()?,
        ))
    }
}
