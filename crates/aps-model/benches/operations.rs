//! Convolutions of ResNet-18 at 64 px, batch 32, forward and with both gradients: the loops for CPUs beside the portable
//! operations, composed of candle's. Throughput is in floating-point operations (a fused multiply-add is two). Then the same
//! in use, normalised and rectified, with and without a kernel cache; and an activation of a transformer.
//!
//! Operations are private to the library: the bench compiles their modules itself.
#![allow(dead_code, unused_imports, missing_docs)]

use std::hint::black_box;
use std::sync::Arc;

use candle_core::{DType, Device, Result, Tensor, Var};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

#[path = "../src/kernels/mod.rs"]
mod kernels;
#[path = "../src/ops/mod.rs"]
mod ops;
#[path = "../src/recording/mod.rs"]
mod recording;

use ops::portable;

/// name, in, pixels a side, out, kernel, stride
const LAYERS: [(&str, usize, usize, usize, usize, usize); 6] = [
    ("stem", 3, 64, 64, 7, 2),
    ("layer1", 64, 16, 64, 3, 1),
    ("layer2", 128, 8, 128, 3, 1),
    ("layer3", 256, 4, 256, 3, 1),
    ("layer4, halving", 256, 4, 512, 3, 2),
    ("layer4", 512, 2, 512, 3, 1),
];
const BATCH: usize = 32;

type Convolution = fn(&Tensor, &Tensor, Option<&Tensor>, usize, (usize, usize)) -> Result<Tensor>;

fn random(shape: &[usize]) -> Tensor {
    Tensor::randn(0f32, 1.0, shape, &Device::Cpu).unwrap()
}

fn convolutions(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("convolution");
    group.sample_size(10);
    for (name, inputs, side, outputs, kernel, stride) in LAYERS {
        let x = Var::from_tensor(&random(&[BATCH, inputs, side, side])).unwrap();
        let weight = Var::from_tensor(&random(&[outputs, inputs, kernel, kernel])).unwrap();
        let padding = (kernel / 2, kernel / 2);
        let multiplications = BATCH * (side / stride).pow(2) * outputs * inputs * kernel.pow(2);
        for (how, convolve) in [
            ("loops", ops::conv2d as Convolution),
            ("portable", portable::conv2d as Convolution),
        ] {
            group.throughput(Throughput::Elements(2 * multiplications as u64));
            group.bench_function(format!("{name}, forward, {how}"), |bencher| {
                bencher.iter(|| convolve(black_box(&x), &weight, None, stride, padding).unwrap());
            });
            group.throughput(Throughput::Elements(6 * multiplications as u64));
            group.bench_function(format!("{name}, with gradients, {how}"), |bencher| {
                bencher.iter(|| {
                    let y = convolve(black_box(&x), &weight, None, stride, padding).unwrap();
                    y.sum_all().unwrap().backward().unwrap()
                });
            });
        }
    }
}

/// Batch normalisation with ReLU over the largest feature map of the same network.
fn normalisation(criterion: &mut Criterion) {
    let x = Var::from_tensor(&random(&[BATCH, 64, 32, 32])).unwrap();
    let constant = |v: f64| {
        let t = Tensor::full(v, 64, &Device::Cpu).unwrap();
        Var::from_tensor(&t.to_dtype(DType::F32).unwrap()).unwrap()
    };
    let (weight, bias, running_mean, running_var) =
        (constant(1.0), constant(0.0), constant(0.0), constant(1.0));
    let tensors = ops::BatchNormTensors {
        weight: &weight,
        bias: &bias,
        running_mean: &running_mean,
        running_var: &running_var,
    };
    let mut group = criterion.benchmark_group("batch normalisation and ReLU with gradients");
    group.sample_size(10);
    group.bench_function("loops", |bencher| {
        bencher.iter(|| {
            let y = ops::batch_norm(black_box(&x), tensors, true, true).unwrap();
            y.sum_all().unwrap().backward().unwrap()
        });
    });
    group.bench_function("portable", |bencher| {
        bencher.iter(|| {
            let y = portable::batch_norm(black_box(&x), tensors, true).unwrap();
            let y = portable::relu(&y).unwrap();
            y.sum_all().unwrap().backward().unwrap()
        });
    });
}

/// Evaluation: one operation a layer.
fn in_use(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("convolution in use");
    group.sample_size(10);
    for (name, inputs, side, outputs, kernel, stride) in LAYERS {
        let x = random(&[BATCH, inputs, side, side]);
        let weight = random(&[outputs, inputs, kernel, kernel]);
        let ones = Tensor::ones(outputs, DType::F32, &Device::Cpu).unwrap();
        let running = Var::from_tensor(&ones).unwrap();
        let norm = ops::BatchNormTensors {
            weight: &ones,
            bias: &ones,
            running_mean: &running,
            running_var: &running,
        };
        for (how, cache) in [("anew", None), ("cached", Some(Arc::default()))] {
            let conv = ops::ConvTensors {
                weight: weight.clone(),
                bias: None,
                stride,
                padding: (kernel / 2, kernel / 2),
                cache,
            };
            group.bench_function(format!("{name}, kernels {how}"), |bencher| {
                bencher.iter(|| {
                    let activation = ops::Activation::Relu;
                    ops::normed_conv2d(black_box(&x), &conv, norm, activation, false).unwrap()
                });
            });
        }
    }
}

/// One layer of ViT-Reg, paper preset, four links.
fn transformer(criterion: &mut Criterion) {
    type Operation = fn(&Tensor) -> Result<Tensor>;
    let mut group = criterion.benchmark_group("transformer with gradients");
    group.sample_size(10);
    let x = Var::from_tensor(&random(&[4, 197, 3072])).unwrap();
    let operations: [(&str, Operation); 2] = [("loops", ops::gelu), ("portable", portable::gelu)];
    for (how, operation) in operations {
        group.bench_function(format!("GELU, {how}"), |bencher| {
            bencher.iter(|| {
                let y = operation(black_box(&x)).unwrap();
                y.sum_all().unwrap().backward().unwrap()
            });
        });
    }
}

criterion_group!(benches, convolutions, normalisation, in_use, transformer);
criterion_main!(benches);
