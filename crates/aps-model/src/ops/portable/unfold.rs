//! Windows of images laid side by side, so that a convolution becomes a matrix product.

use candle_core::backend::{BackendDevice, BackendStorage};
use candle_core::{
    CpuStorage, CudaStorage, CustomOp1, Layout, MetalStorage, Result, Shape, Tensor, bail,
};

/// Copies all windows of `x` (batch, height, width, channels), `stride` apart: (batch, rows, columns, kernel height x kernel
/// width x channels). Nothing in it has a gradient.
///
/// # Errors
/// If the kernel is larger than the image.
pub(super) fn unfold(x: &Tensor, kernel: [usize; 2], stride: usize) -> Result<Tensor> {
    let (batch, height, width, channels) = x.dims4()?;
    let ([high, wide], x) = (kernel, x.contiguous()?);
    if high > height || wide > width {
        bail!(
            "a kernel of {high} x {wide} does not fit into an image of {height} x {width}, padding included"
        );
    }
    if (kernel, stride) == ([1, 1], 1) {
        return Ok(x);
    }
    let (rows, columns) = ((height - high) / stride + 1, (width - wide) / stride + 1);
    let row = width * channels;
    let windows = Windows {
        shape: vec![batch, rows, columns, high, wide * channels],
        // Within a window a row is contiguous: its pixels are neighbours.
        strides: vec![height * row, stride * row, stride * channels, row, 1],
    };
    let windows = x.apply_op1_no_bwd(&windows)?;
    windows.reshape((batch, rows, columns, high * wide * channels))
}

/// One copy of a contiguous tensor as a view whose elements overlap, which candle's own views cannot.
struct Windows {
    shape: Vec<usize>,
    strides: Vec<usize>,
}

impl Windows {
    fn copy<S: Store>(&self, x: &S, layout: &Layout) -> Result<(S, Shape)> {
        let shape = Shape::from(self.shape.as_slice());
        let view = Layout::new(shape, self.strides.clone(), layout.start_offset());
        copied(x, &view)
    }
}

/// Memory of a device, of which the device can give more.
pub(super) trait Store: BackendStorage<Device: BackendDevice<Storage = Self>> {}

impl<S: BackendStorage<Device: BackendDevice<Storage = S>>> Store for S {}

/// Copies the elements of a view in its order.
pub(super) fn copied<S: Store>(from: &S, view: &Layout) -> Result<(S, Shape)> {
    let mut copy = from.device().zeros_impl(view.shape(), from.dtype())?;
    from.copy_strided_src(&mut copy, 0, view)?;
    Ok((copy, view.shape().clone()))
}

impl CustomOp1 for Windows {
    fn name(&self) -> &'static str {
        "unfold"
    }

    fn cpu_fwd(&self, x: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        self.copy(x, layout)
    }

    fn cuda_fwd(&self, x: &CudaStorage, layout: &Layout) -> Result<(CudaStorage, Shape)> {
        self.copy(x, layout)
    }

    fn metal_fwd(&self, x: &MetalStorage, layout: &Layout) -> Result<(MetalStorage, Shape)> {
        self.copy(x, layout)
    }
}
