//! The bridge between candle's tensors and the loops of [`crate::kernels`]: an operation with its gradient, over slices.

use std::ops::Deref;

use candle_core::{
    CpuStorage, CustomOp1, CustomOp2, CustomOp3, DType, Layout, Result, Shape, Storage, Tensor,
    bail,
};

/// Returns true when the loops of this crate take all of the tensors: f32 on the CPU.
pub(super) fn are_fast(tensors: &[&Tensor]) -> bool {
    let is_fast = |t: &&Tensor| is_on_cpu(t) && t.dtype() == DType::F32;
    tensors.iter().all(is_fast)
}

/// Returns true when a tensor lies on the CPU, and there are ways for the CPU.
pub(super) fn is_on_cpu(tensor: &Tensor) -> bool {
    #[cfg(test)]
    if AS_ON_A_DEVICE.get() {
        return false;
    }
    tensor.device().is_cpu()
}

#[cfg(test)]
std::thread_local! {
    static AS_ON_A_DEVICE: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Runs `f` with the operations that another device would take.
#[cfg(test)]
pub(crate) fn as_on_a_device<T>(f: impl FnOnce() -> T) -> T {
    AS_ON_A_DEVICE.set(true);
    let result = f();
    AS_ON_A_DEVICE.set(false);
    result
}

/// Values of a backward pass.
pub(super) struct Backward<'a, const N: usize> {
    pub inputs: [&'a [f32]; N],
    pub output: &'a [f32],
    /// Gradient by the output.
    pub grad: &'a [f32],
    /// True for the inputs that something asks a gradient of.
    pub wanted: [bool; N],
}

/// Computes an operation of one to three [fast](are_fast) tensors: `forward` gives the values of the result, of the shape
/// `shape`, and `backward` the gradients by the inputs.
pub(super) fn apply<const N: usize>(
    name: &'static str,
    inputs: [&Tensor; N],
    shape: &[usize],
    forward: impl Fn([&[f32]; N]) -> Vec<f32> + Send + Sync + 'static,
    backward: impl Fn(Backward<'_, N>) -> [Option<Vec<f32>>; N] + Send + Sync + 'static,
) -> Result<Tensor> {
    let op = Operation {
        name,
        shape: Shape::from(shape),
        forward: Box::new(forward),
        backward: Box::new(backward),
    };
    let inputs = inputs.iter().map(|t| t.contiguous());
    let inputs = inputs.collect::<Result<Vec<_>>>()?;
    match &inputs[..] {
        [x] => x.apply_op1(op),
        [x, y] => x.apply_op2(y, op),
        [x, y, z] => x.apply_op3(y, z, op),
        _ => bail!("{name} has {N} inputs, candle's operations one to three"),
    }
}

/// An operation of N inputs. It implements candle's three traits, of which [`apply`] uses the one for N.
struct Operation<const N: usize> {
    name: &'static str,
    shape: Shape,
    forward: Box<Forward<N>>,
    backward: Box<Gradients<N>>,
}

type Forward<const N: usize> = dyn Fn([&[f32]; N]) -> Vec<f32> + Send + Sync;
type Gradients<const N: usize> = dyn Fn(Backward<'_, N>) -> [Option<Vec<f32>>; N] + Send + Sync;

impl<const N: usize> Operation<N> {
    fn run(&self, inputs: &[(&CpuStorage, &Layout)]) -> Result<(CpuStorage, Shape)> {
        let mut slices: [&[f32]; N] = [&[]; N];
        for (target, (storage, layout)) in slices.iter_mut().zip(inputs) {
            *target = slice(storage, layout)?;
        }
        let values = (self.forward)(slices);
        Ok((CpuStorage::F32(values), self.shape.clone()))
    }

    fn gradients<const M: usize>(
        &self,
        inputs: [&Tensor; M],
        output: &Tensor,
        grad: &Tensor,
    ) -> Result<[Option<Tensor>; M]> {
        let mut wanted = [false; N];
        for (wanted, input) in wanted.iter_mut().zip(inputs) {
            *wanted = input.track_op();
        }
        let grad = grad.contiguous()?;
        let values = with_slices(inputs, |slices| {
            with_slices([output, &grad], |[output, grad]| {
                let mut inputs: [&[f32]; N] = [&[]; N];
                inputs.copy_from_slice(&slices);
                (self.backward)(Backward {
                    inputs,
                    output,
                    grad,
                    wanted,
                })
            })
        })??;
        let mut gradients = [const { None }; M];
        for ((gradient, values), input) in gradients.iter_mut().zip(values).zip(inputs) {
            let tensor = |values| Tensor::from_vec(values, input.shape(), input.device());
            *gradient = values.map(tensor).transpose()?;
        }
        Ok(gradients)
    }
}

impl<const N: usize> CustomOp1 for Operation<N> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn cpu_fwd(&self, x: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        self.run(&[(x, layout)])
    }

    fn bwd(&self, x: &Tensor, output: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let [x] = self.gradients([x], output, grad)?;
        Ok(x)
    }
}

impl<const N: usize> CustomOp2 for Operation<N> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        y: &CpuStorage,
        y_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        self.run(&[(x, x_layout), (y, y_layout)])
    }

    fn bwd(
        &self,
        x: &Tensor,
        y: &Tensor,
        output: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        self.gradients([x, y], output, grad).map(Into::into)
    }
}

impl<const N: usize> CustomOp3 for Operation<N> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        y: &CpuStorage,
        y_layout: &Layout,
        z: &CpuStorage,
        z_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        self.run(&[(x, x_layout), (y, y_layout), (z, z_layout)])
    }

    fn bwd(
        &self,
        x: &Tensor,
        y: &Tensor,
        z: &Tensor,
        output: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        self.gradients([x, y, z], output, grad).map(Into::into)
    }
}

/// Returns the values of a contiguous f32 argument of a custom operation.
fn slice<'a>(storage: &'a CpuStorage, layout: &Layout) -> Result<&'a [f32]> {
    match layout.contiguous_offsets() {
        Some((start, end)) => Ok(&storage.as_slice::<f32>()?[start..end]),
        None => bail!("expected a contiguous tensor, found {layout:?}"),
    }
}

/// Gives `f` the values of contiguous f32 tensors.
pub(crate) fn with_slices<const N: usize, R>(
    tensors: [&Tensor; N],
    f: impl FnOnce([&[f32]; N]) -> R,
) -> Result<R> {
    let guards = tensors.map(Tensor::storage_and_layout);
    let mut slices: [&[f32]; N] = [&[]; N];
    for (target, (storage, layout)) in slices.iter_mut().zip(&guards) {
        match storage.deref() {
            Storage::Cpu(storage) => *target = slice(storage, layout)?,
            _ => bail!("expected a tensor on the CPU"),
        }
    }
    Ok(f(slices))
}
