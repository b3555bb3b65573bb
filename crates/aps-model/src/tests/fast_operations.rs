//! The fast operations on the CPU against the portable ones in f64: values, gradients, and the same bits on any number of
//! threads.

use std::sync::{Arc, Mutex};

use candle_core::{DType, Device, Result, Tensor, Var};
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{flat, on_threads};
use crate::kernels::KernelCache;
use crate::ops::{self, Activation, BatchNormTensors, ConvTensors, portable};

type Operation<'a> = &'a dyn Fn(&[Tensor]) -> Result<Tensor>;

/// Values in [-1, 1) on a coarse grid, so that ties occur.
fn values(rng: &mut ChaCha8Rng, shape: &[usize]) -> Tensor {
    let draw = |_| (f64::from(rng.next_u32() % 256) - 128.0) / 128.0;
    let values: Vec<f64> = (0..shape.iter().product()).map(draw).collect();
    Tensor::from_vec(values, shape, &Device::Cpu).unwrap()
}

/// Output, and the gradients by all inputs of the output weighted with fixed numbers.
fn with_gradients(f: Operation<'_>, inputs: &[Tensor], dtype: DType) -> Vec<Vec<f64>> {
    let var = |t: &Tensor| Var::from_tensor(&t.to_dtype(dtype).unwrap()).unwrap();
    let vars: Vec<Var> = inputs.iter().map(var).collect();
    let tensors: Vec<Tensor> = vars.iter().map(|v| v.as_tensor().clone()).collect();
    let y = f(&tensors).unwrap();
    let weights = values(&mut ChaCha8Rng::seed_from_u64(9), y.dims());
    let weighted = (&y * weights.to_dtype(dtype).unwrap()).unwrap();
    let gradients = weighted.sum_all().unwrap().backward().unwrap();
    let mut all = vec![flat(&y)];
    all.extend(vars.iter().map(|v| flat(gradients.get(v).unwrap())));
    all
}

/// Fast and portable agree to f32's rounding, and one and three threads to the bit.
fn check(fast: Operation<'_>, reference: Operation<'_>, inputs: &[Tensor]) {
    let expected = with_gradients(reference, inputs, DType::F64);
    let found = with_gradients(fast, inputs, DType::F32);
    for (part, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert_eq!(found.len(), expected.len());
        let scale = expected.iter().fold(1.0, |m: f64, v| m.max(v.abs()));
        for (i, (f, e)) in found.iter().zip(expected).enumerate() {
            let is_close = (f - e).abs() < 3e-6 * scale;
            assert!(is_close, "part {part}, value {i}: {f}, expected {e}");
        }
    }
}

fn same_bits_on_any_threads(fast: impl Fn(&[Tensor]) -> Result<Tensor> + Sync, inputs: &[Tensor]) {
    let on = |threads| on_threads(threads, || with_gradients(&fast, inputs, DType::F32));
    assert_eq!(on(1), on(3));
}

/// [batch, in, height, width], out, kernel, stride, padding
type Sizes = ([usize; 4], usize, (usize, usize), usize, (usize, usize));

fn check_convolution(([n, i, h, w], o, (kh, kw), stride, padding): Sizes, threads: bool) {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let inputs = [&[n, i, h, w][..], &[o, i, kh, kw], &[o]].map(|shape| values(rng, shape));
    let fast = |t: &[Tensor]| ops::conv2d(&t[0], &t[1], t.get(2), stride, padding);
    let reference = |t: &[Tensor]| portable::conv2d(&t[0], &t[1], t.get(2), stride, padding);
    check(&fast, &reference, &inputs);
    if threads {
        same_bits_on_any_threads(fast, &inputs);
    }
    // Without bias.
    check(&fast, &reference, &inputs[..2]);
}

#[test]
fn convolutions_of_the_models() {
    for sizes in [
        // ResNet: stem, blocks, halving blocks, shortcuts, the smallest images
        ([5, 3, 32, 32], 16, (7, 7), 2, (3, 3)),
        ([4, 16, 16, 16], 16, (3, 3), 1, (1, 1)),
        ([4, 16, 16, 16], 40, (3, 3), 2, (1, 1)),
        ([4, 16, 16, 16], 40, (1, 1), 2, (0, 0)),
        ([8, 70, 2, 2], 130, (3, 3), 1, (1, 1)),
        ([3, 8, 1, 1], 9, (3, 3), 2, (1, 1)),
        // by minimal filtering: even and odd sizes, paddings, more tiles than a chunk holds, parts of images
        ([13, 16, 8, 8], 40, (3, 3), 1, (1, 1)),
        ([12, 17, 5, 7], 16, (3, 3), 1, (1, 1)),
        ([16, 18, 6, 4], 19, (3, 3), 1, (0, 2)),
        ([9, 130, 7, 9], 140, (3, 3), 1, (2, 1)),
        ([70, 120, 6, 6], 110, (3, 3), 1, (1, 1)),
        ([2, 80, 66, 70], 90, (3, 3), 1, (1, 1)),
        // one image, large enough for more than one tile
        ([1, 3, 40, 48], 65, (3, 3), 1, (1, 1)),
        ([4, 24, 40, 48], 3, (3, 3), 1, (1, 1)),
        // one dimension
        ([3, 20, 1, 45], 12, (1, 5), 1, (0, 2)),
        ([4, 12, 1, 180], 1, (1, 1), 1, (0, 0)),
    ] {
        check_convolution(sizes, true);
    }
}

#[test]
fn transposed_convolution() {
    let rng = &mut ChaCha8Rng::seed_from_u64(2);
    for (n, i, h, w, o) in [(2, 6, 5, 7, 4), (5, 40, 8, 8, 20), (1, 3, 1, 1, 1)] {
        let inputs = [&[n, i, h, w][..], &[i, o, 2, 2], &[o]].map(|shape| values(rng, shape));
        let fast = |t: &[Tensor]| ops::conv_transpose2x2(&t[0], &t[1], &t[2]);
        let reference = |t: &[Tensor]| portable::conv_transpose2x2(&t[0], &t[1], &t[2]);
        check(&fast, &reference, &inputs);
        same_bits_on_any_threads(fast, &inputs);
    }
}

#[test]
fn pooling_with_many_ties() {
    let rng = &mut ChaCha8Rng::seed_from_u64(3);
    for (h, w) in [(8, 8), (7, 9), (2, 3)] {
        let coarse = (values(rng, &[3, 5, h, w]) * 2.0).unwrap().round().unwrap();
        let inputs = [coarse];
        let fast = |t: &[Tensor]| ops::max_pool_2x2(&t[0]);
        check(&fast, &|t| portable::max_pool_2x2(&t[0]), &inputs);
        let fast = |t: &[Tensor]| ops::max_pool_3x3_s2_p1(&t[0]);
        check(&fast, &|t| portable::max_pool_3x3_s2_p1(&t[0]), &inputs);
        same_bits_on_any_threads(fast, &inputs);
    }
}

#[test]
fn residual_sum_rectified() {
    let rng = &mut ChaCha8Rng::seed_from_u64(4);
    let inputs = [values(rng, &[3, 70_000]), values(rng, &[3, 70_000])];
    let fast = |t: &[Tensor]| ops::add_relu(&t[0], &t[1]);
    check(&fast, &|t| portable::relu(&(&t[0] + &t[1])?), &inputs);
    same_bits_on_any_threads(fast, &inputs);
}

#[test]
fn batch_normalisation_in_training_and_use() {
    let rng = &mut ChaCha8Rng::seed_from_u64(5);
    for shape in [vec![4, 6, 5, 7], vec![9, 3], vec![2, 20, 33]] {
        let channels = shape[1];
        // A mean far above the deviation, as behind a layer that has drifted.
        let x = (values(rng, &shape) + 30.0).unwrap();
        let inputs = [x, values(rng, &[channels]), values(rng, &[channels])];
        for train in [false, true] {
            for relu in [false, true] {
                let moved = Mutex::new(Vec::new());
                let run = |t: &[Tensor], portable: bool| {
                    let start = |v: f64| {
                        let t = Tensor::full(v, channels, &Device::Cpu)?.to_dtype(t[0].dtype())?;
                        Var::from_tensor(&t)
                    };
                    let (running_mean, running_var) = (&start(29.5)?, &start(0.3)?);
                    let tensors = BatchNormTensors {
                        weight: &t[1],
                        bias: &t[2],
                        running_mean,
                        running_var,
                    };
                    let y = match (portable, relu) {
                        (false, relu) => ops::batch_norm(&t[0], tensors, train, relu),
                        (true, false) => portable::batch_norm(&t[0], tensors, train),
                        (true, true) => portable::batch_norm(&t[0], tensors, train)
                            .and_then(|y| portable::relu(&y)),
                    };
                    let both = Tensor::cat(&[running_mean.as_tensor(), running_var], 0)?;
                    let both = both.to_dtype(DType::F64)?.to_vec1::<f64>()?;
                    moved.lock().unwrap().push(both);
                    y
                };
                check(&|t| run(t, false), &|t| run(t, true), &inputs);
                let moved = moved.lock().unwrap();
                for (a, b) in moved[0].iter().zip(&moved[1]) {
                    assert!((a - b).abs() < 1e-5, "running statistics {a} and {b}");
                }
            }
        }
    }
}

#[test]
fn activations() {
    let rng = &mut ChaCha8Rng::seed_from_u64(11);
    for shape in [&[1][..], &[7, 3], &[3, 5, 1200], &[2, 20_000]] {
        let inputs = [(values(rng, shape) * 5.0).unwrap()];
        let gelu = |t: &[Tensor]| ops::gelu(&t[0]);
        check(&gelu, &|t| portable::gelu(&t[0]), &inputs);
        same_bits_on_any_threads(gelu, &inputs);
        let leaky = |t: &[Tensor]| ops::leaky_relu(&t[0], 0.2);
        check(&leaky, &|t| portable::leaky_relu(&t[0], 0.2), &inputs);
    }
}

#[test]
fn attention() {
    let rng = &mut ChaCha8Rng::seed_from_u64(16);
    for (batch, tokens, heads, depth, factor) in [
        (1, 1, 1, 1, 2.0),
        (1, 16, 1, 3, 2.0),
        (2, 5, 3, 4, 2.0),
        (3, 33, 2, 17, 2.0),
        (2, 50, 4, 64, 2.0),
        // The tokens of ViT-Reg, and scores up to a hundred apart.
        (1, 197, 2, 4, 8.0),
    ] {
        // Scores far enough apart that weights differ by orders.
        let inputs = [(values(rng, &[batch, tokens, 3 * heads * depth]) * factor).unwrap()];
        let attend = |t: &[Tensor]| ops::self_attention(&t[0], heads);
        let reference = |t: &[Tensor]| portable::self_attention(&t[0], heads);
        check(&attend, &reference, &inputs);
        same_bits_on_any_threads(attend, &inputs);
    }
    let odd = values(rng, &[1, 2, 9]).to_dtype(DType::F32).unwrap();
    assert!(ops::self_attention(&odd, 2).is_err());
}

#[test]
fn layer_normalisation() {
    let rng = &mut ChaCha8Rng::seed_from_u64(13);
    for (shape, mean) in [
        (&[3, 5][..], 0.0),
        (&[2, 19, 100], 8.0),
        (&[4, 50, 193], 0.0),
    ] {
        let features = shape[shape.len() - 1];
        let inputs = [
            (values(rng, shape) + mean).unwrap(),
            values(rng, &[features]),
            values(rng, &[features]),
        ];
        let norm = |t: &[Tensor]| ops::layer_norm(&t[0], &t[1], &t[2]);
        let reference = |t: &[Tensor]| portable::layer_norm(&t[0], &t[1], &t[2]);
        check(&norm, &reference, &inputs);
        same_bits_on_any_threads(norm, &inputs);
    }
}

#[test]
fn affine_maps() {
    let rng = &mut ChaCha8Rng::seed_from_u64(14);
    for (shape, outputs) in [
        (&[1, 1][..], 1),
        (&[3, 5], 7),
        (&[2, 33, 40], 70),
        (&[6, 300], 513),
    ] {
        let weight = [outputs, shape[shape.len() - 1]];
        let inputs = [shape, &weight, &[outputs]].map(|shape| values(rng, shape));
        let linear = |t: &[Tensor]| ops::linear(&t[0], &t[1], &t[2]);
        let reference = |t: &[Tensor]| portable::linear(&t[0], &t[1], &t[2]);
        check(&linear, &reference, &inputs);
        same_bits_on_any_threads(linear, &inputs);
    }
}

/// A convolution in half precision rounds what f32 gives.
#[test]
fn convolution_in_half_precision() {
    let rng = &mut ChaCha8Rng::seed_from_u64(15);
    let (x, w) = (values(rng, &[2, 3, 9, 8]), values(rng, &[4, 3, 3, 3]));
    for dtype in [DType::BF16, DType::F16] {
        let to = |t: &Tensor, dtype| t.to_dtype(dtype).unwrap();
        let half = ops::conv2d(&to(&x, dtype), &to(&w, DType::F32), None, 2, (1, 1)).unwrap();
        assert_eq!(half.dtype(), dtype);
        // The inputs are exact in either.
        let full = ops::conv2d(&to(&x, DType::F32), &to(&w, DType::F32), None, 2, (1, 1)).unwrap();
        assert_eq!(flat(&half), flat(&to(&full, dtype)));
    }
}

/// In evaluation a convolution, its normalisation and the operation after it are one operation.
#[test]
fn normalised_convolution_in_use() {
    let rng = &mut ChaCha8Rng::seed_from_u64(6);
    for (n, i, h, w, o, kernel, stride) in [
        // image by image, all together, one image, by minimal filtering of both sizes, one pixel
        (5, 3, 20, 24, 16, 7, 2),
        (8, 30, 4, 4, 20, 3, 2),
        (1, 20, 9, 7, 18, 3, 1),
        (13, 16, 8, 8, 40, 3, 1),
        (12, 17, 5, 7, 16, 3, 1),
        (6, 10, 1, 1, 12, 1, 1),
        (20, 33, 2, 2, 19, 3, 1),
        (17, 16, 4, 4, 16, 3, 1),
    ] {
        let side = |s: usize| (s - 1) / stride + 1;
        let tensors = [
            values(rng, &[n, i, h, w]),
            values(rng, &[o, i, kernel, kernel]),
            values(rng, &[n, o, side(h), side(w)]),
            values(rng, &[o]),
            values(rng, &[o]),
            // A mean far above the deviation.
            (values(rng, &[o]) + 30.0).unwrap(),
            (values(rng, &[o]) + 1.5).unwrap(),
        ];
        for (after, has_bias) in [(0, false), (1, true), (2, false), (2, true)] {
            let cache = Arc::new(KernelCache::default());
            let run = |dtype: DType, at_once: bool, cache: Option<&Arc<KernelCache>>| {
                let t: Vec<Tensor> = tensors.iter().map(|t| t.to_dtype(dtype).unwrap()).collect();
                let running = |t: &Tensor| Var::from_tensor(t).unwrap();
                let (running_mean, running_var) = (&running(&t[5]), &running(&t[6]));
                let norm = BatchNormTensors {
                    weight: &t[3],
                    bias: &t[4],
                    running_mean,
                    running_var,
                };
                let bias = has_bias.then_some(&t[4]);
                let padding = (kernel / 2, kernel / 2);
                let y = if at_once {
                    let conv = ConvTensors {
                        weight: t[1].clone(),
                        bias: bias.cloned(),
                        stride,
                        padding,
                        cache: cache.cloned(),
                    };
                    let after = match after {
                        0 => Activation::Identity,
                        1 => Activation::Relu,
                        _ => Activation::AddRelu(&t[2]),
                    };
                    ops::normed_conv2d(&t[0], &conv, norm, after, false).unwrap()
                } else {
                    let y = portable::conv2d(&t[0], &t[1], bias, stride, padding).unwrap();
                    let y = portable::batch_norm(&y, norm, false).unwrap();
                    match after {
                        0 => y,
                        1 => portable::relu(&y).unwrap(),
                        _ => portable::relu(&(y + &t[2]).unwrap()).unwrap(),
                    }
                };
                flat(&y)
            };
            let expected = run(DType::F64, false, None);
            let scale = expected.iter().fold(1.0, |m: f64, v| m.max(v.abs()));
            // Twice with the cache: filled, and used again.
            let found =
                [None, Some(&cache), Some(&cache)].map(|cache| run(DType::F32, true, cache));
            for (f, e) in found.iter().flat_map(|found| found.iter().zip(&expected)) {
                assert!((f - e).abs() < 3e-6 * scale, "{f}, expected {e}");
            }
            assert_eq!(found[1], found[2]);
            let on = |threads, cache| on_threads(threads, || run(DType::F32, true, cache));
            assert_eq!(on(1, None), on(3, None));
            assert_eq!(on(1, Some(&cache)), on(3, Some(&Arc::default())));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn convolutions_of_any_size(
        (n, i, o) in (1usize..6, 1usize..9, 1usize..9),
        (kh, kw) in (1usize..5, 1usize..5),
        (more_h, more_w) in (0usize..12, 0usize..12),
        stride in 1usize..4,
        padding in (0usize..3, 0usize..3),
    ) {
        check_convolution(([n, i, kh + more_h, kw + more_w], o, (kh, kw), stride, padding), false);
    }
}
