//! Tests of what is not public: operations, layers, models of other sizes, steps of training.

mod convolutions;
mod counts;
mod fast_operations;
mod gradients;
mod half;
mod mixed;
mod onnx;
mod operations;
mod optim;
mod parity;
mod stability;
mod train;

use candle_core::{DType, Device, Shape, Tensor};
use candle_nn::var_builder::SimpleBackend;
use candle_nn::{Init, VarBuilder, VarMap};

use crate::condition::{
    ConditionConfig, ConditionImages, InputKind, InputShape, PolarShape, Rasters,
};
use crate::{ModelKind, seeded};

/// Shape of the ways of a link, as `map2aps` makes them.
const WAYS: PolarShape = PolarShape {
    directions: 720,
    kinds: 15,
    features: 14,
};

/// Returns a shape of input that a model takes.
fn shape_of(kind: ModelKind) -> InputShape {
    match kind.input() {
        InputKind::Images => InputShape::Images,
        InputKind::Polar => InputShape::Polar(WAYS),
    }
}

/// Returns so many ways of each of some links, from any direction and of any kind.
fn some_ways(links: usize, ways: usize) -> Tensor {
    let way = |n: usize| {
        let feature = move |f: usize| match f {
            1 => 1.0,
            _ => ((n * 14 + f) * 7919 % 1000) as f32 / 1000.0,
        };
        let numbers = [n * 37 % WAYS.directions, n % WAYS.kinds].map(|number| number as f32);
        (0..WAYS.features).map(feature).chain(numbers)
    };
    let values: Vec<f32> = (0..links * ways).flat_map(way).collect();
    Tensor::from_vec(values, (links, ways, WAYS.per_way()), &Device::Cpu).unwrap()
}

/// Returns condition images of square maps that are `side` pixels wide.
fn conditions(
    pixels: &[f32],
    side: usize,
    metres_per_pixel: f64,
    image_size: usize,
) -> ConditionImages {
    let rasters = Rasters {
        pixels,
        height: side,
        width: side,
        metres_per_pixel,
    };
    let config = ConditionConfig {
        image_size,
        sigma_px: 2.5,
        ..ConditionConfig::default()
    };
    ConditionImages::new(rasters, config, &Device::Cpu).unwrap()
}

/// Returns a builder of tensors on the CPU.
fn builder(parameters: &VarMap, dtype: DType, seed: u64) -> VarBuilder<'static> {
    seeded(parameters, seed, dtype, &Device::Cpu)
}

/// Returns a builder of tensors on the CPU that are zero where weights would be drawn, which takes most of the time of a large model.
fn blank(parameters: &VarMap, dtype: DType) -> VarBuilder<'static> {
    VarBuilder::from_backend(Box::new(Blank(parameters.clone())), dtype, Device::Cpu)
}

struct Blank(VarMap);

impl SimpleBackend for Blank {
    fn get(
        &self,
        shape: Shape,
        name: &str,
        init: Init,
        dtype: DType,
        device: &Device,
    ) -> candle_core::Result<Tensor> {
        let init = match init {
            Init::Const(_) => init,
            _ => Init::Const(0.0),
        };
        self.0.get(shape, name, init, dtype, device)
    }

    fn get_unchecked(
        &self,
        name: &str,
        dtype: DType,
        device: &Device,
    ) -> candle_core::Result<Tensor> {
        SimpleBackend::get_unchecked(&self.0, name, dtype, device)
    }

    fn contains_tensor(&self, name: &str) -> bool {
        self.0.contains_tensor(name)
    }
}

/// Returns all values in double precision.
pub(crate) fn flat(tensor: &Tensor) -> Vec<f64> {
    let flat = tensor.flatten_all().unwrap().to_dtype(DType::F64).unwrap();
    flat.to_vec1().unwrap()
}

/// Runs `f` on so many threads.
pub(crate) fn on_threads<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(f)
}
