//! Convolutions by matrix products, which GPUs compute with, against candle's own convolution and the loops of the CPU. With the
//! feature `cuda` the former run on the first GPU.

use candle_core::{DType, Device, Result, Tensor, Var};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::flat;
use crate::ops::{self, portable};

/// Input, kernel, stride, padding of rows and of columns.
#[derive(Debug, Clone, Copy)]
struct Case {
    x: [usize; 4],
    weight: [usize; 4],
    stride: usize,
    padding: [usize; 2],
}

const fn square(
    batch: usize,
    channels: [usize; 2],
    size: [usize; 2],
    kernel: usize,
    stride: usize,
) -> Case {
    Case {
        x: [batch, channels[0], size[0], size[1]],
        weight: [channels[1], channels[0], kernel, kernel],
        stride,
        padding: [kernel / 2; 2],
    }
}

/// Device of the convolutions under test.
fn device() -> Device {
    match cfg!(feature = "cuda") {
        true => Device::new_cuda(0).unwrap(),
        false => Device::Cpu,
    }
}

fn values(seed: u64, shape: &[usize], dtype: DType, device: &Device) -> Var {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let draw = |_| f64::from(rng.next_u32()) / f64::from(1_u32 << 31) - 1.0;
    let values: Vec<f64> = (0..shape.iter().product()).map(draw).collect();
    let values = Tensor::from_vec(values, shape, device).unwrap();
    Var::from_tensor(&values.to_dtype(dtype).unwrap()).unwrap()
}

/// Result, and the gradients of its sum weighted with fixed numbers by input and kernel.
fn with_gradients(
    case: Case,
    dtype: DType,
    device: &Device,
    f: impl Fn(&Tensor, &Tensor) -> Result<Tensor>,
) -> [Vec<f64>; 3] {
    let x = values(1, &case.x, dtype, device);
    let weight = values(2, &case.weight, dtype, device);
    let y = f(x.as_tensor(), weight.as_tensor()).unwrap();
    let factors = values(3, y.dims(), dtype, device);
    let sum = (&y * factors.as_tensor()).unwrap().sum_all().unwrap();
    let gradients = sum.backward().unwrap();
    let of = |var: &Var| flat(gradients.get(var).unwrap());
    [flat(&y), of(&x), of(&weight)]
}

fn found(
    case: Case,
    dtype: DType,
    f: impl Fn(&Tensor, &Tensor) -> Result<Tensor>,
) -> [Vec<f64>; 3] {
    with_gradients(case, dtype, &device(), f)
}

fn expected(
    case: Case,
    dtype: DType,
    f: impl Fn(&Tensor, &Tensor) -> Result<Tensor>,
) -> [Vec<f64>; 3] {
    with_gradients(case, dtype, &Device::Cpu, f)
}

fn portable(case: Case) -> impl Fn(&Tensor, &Tensor) -> Result<Tensor> {
    let [high, wide] = case.padding;
    move |x, weight| portable::conv2d(x, weight, None, case.stride, (high, wide))
}

/// candle's own, given what it does right: no padding, and no rows or columns that no window reaches.
fn candle_s(case: Case) -> impl Fn(&Tensor, &Tensor) -> Result<Tensor> {
    move |x, weight| {
        let mut x = x.clone();
        for at in [0, 1] {
            x = x.pad_with_zeros(2 + at, case.padding[at], case.padding[at])?;
            let size = x.dim(2 + at)?;
            let unused = (size - case.weight[2 + at]) % case.stride;
            x = x.narrow(2 + at, 0, size - unused)?;
        }
        x.contiguous()?.conv2d(weight, 0, case.stride, 1, 1)
    }
}

/// Compares with a tolerance relative to the largest value of each part.
fn assert_close(
    case: impl std::fmt::Debug,
    found: &[Vec<f64>; 3],
    expected: &[Vec<f64>; 3],
    tolerance: f64,
) {
    let parts = ["result", "by input", "by kernel"];
    for (part, (found, expected)) in parts.iter().zip(found.iter().zip(expected)) {
        assert_eq!(found.len(), expected.len(), "{case:?}, {part}");
        let scale = expected.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let errors = found.iter().zip(expected).map(|(f, e)| (f - e).abs());
        let error = errors.fold(0.0, f64::max);
        assert!(
            error <= tolerance * scale,
            "{case:?}, {part}: wrong by {error}, the largest value is {scale}"
        );
    }
}

/// Convolutions of the models at some image size, with a part of their channels: the stem of ResNet, its blocks, halving blocks and
/// shortcuts, the U-Net, patches, and one-dimensional ones.
fn of_models(pixels: [usize; 2], share: usize) -> Vec<Case> {
    let part = |channels: usize| (channels / share).max(1);
    let at = |halvings: u32| pixels.map(|n| n.div_ceil(1 << halvings));
    let mut cases = vec![
        square(2, [3, part(64)], pixels, 7, 2),
        square(2, [3, part(64)], pixels, 3, 1),
    ];
    for stage in 0..4 {
        let width = part(64 << stage);
        cases.push(square(2, [width, width], at(2 + stage), 3, 1));
        if stage > 0 {
            for kernel in [3, 1] {
                cases.push(square(2, [width / 2, width], at(1 + stage), kernel, 2));
            }
        }
        // Down and up the U-Net, where two halves come together.
        cases.push(square(1, [width, 2 * width], at(1 + stage), 3, 1));
        cases.push(square(1, [2 * width, width], at(stage), 3, 1));
    }
    cases.push(Case {
        padding: [0; 2],
        ..square(2, [3, part(768)], pixels, 16, 16)
    });
    let line = |channels: [usize; 2], length, kernel| Case {
        x: [2, channels[0], 1, length],
        weight: [channels[1], channels[0], 1, kernel],
        stride: 1,
        padding: [0, kernel / 2],
    };
    // Up to the 180 bins of a spectrum.
    cases.push(line([part(256), part(128)], 90, 5));
    cases.push(line([part(128), part(128)], 90, 3));
    cases.push(line([part(32), 1], 180, 1));
    cases
}

#[test]
fn of_the_models_agree_with_candle_s_own() {
    // f64: rounding alone. Odd sizes leave remainders of the strides, one of rows and another of columns.
    for (pixels, share) in [([64, 64], 16), ([45, 38], 16), ([37, 64], 32), ([1, 2], 16)] {
        for case in of_models(pixels, share) {
            let fits = |at: usize| case.weight[2 + at] <= case.x[2 + at] + 2 * case.padding[at];
            // Patches of an image that holds none.
            if !fits(0) || !fits(1) {
                continue;
            }
            let found = found(case, DType::F64, portable(case));
            let expected = expected(case, DType::F64, candle_s(case));
            assert_close(case, &found, &expected, 1e-13);
        }
    }
}

fn agree_with_the_loops_of_the_cpu(pixels: [usize; 2], share: usize) {
    for case in of_models(pixels, share) {
        let fast = |x: &Tensor, weight: &Tensor| {
            ops::conv2d(x, weight, None, case.stride, case.padding.into())
        };
        let found = found(case, DType::F32, portable(case));
        assert_close(case, &found, &expected(case, DType::F32, fast), 1e-5);
    }
}

#[test]
fn of_the_models_agree_with_the_loops_of_the_cpu() {
    agree_with_the_loops_of_the_cpu([64, 64], 1);
    agree_with_the_loops_of_the_cpu([256, 256], 16);
}

#[test]
#[ignore = "long: images of 256 px and all channels"]
fn of_the_models_at_256_px_agree_with_the_loops_of_the_cpu() {
    agree_with_the_loops_of_the_cpu([256, 256], 1);
}

#[test]
fn transposed_ones_of_the_u_net_agree_with_the_loops_of_the_cpu() {
    for (width, pixels) in [
        (512, [4, 4]),
        (256, [8, 9]),
        (64, [32, 32]),
        (4, [128, 128]),
    ] {
        let case = Case {
            x: [2, 2 * width, pixels[0], pixels[1]],
            weight: [2 * width, width, 2, 2],
            stride: 2,
            padding: [0; 2],
        };
        let bias = |x: &Tensor| Tensor::zeros(width, x.dtype(), x.device());
        let products =
            |x: &Tensor, weight: &Tensor| portable::conv_transpose2x2(x, weight, &bias(x)?);
        let fast = |x: &Tensor, weight: &Tensor| ops::conv_transpose2x2(x, weight, &bias(x)?);
        let found = found(case, DType::F32, products);
        assert_close(case, &found, &expected(case, DType::F32, fast), 1e-5);
    }
}

#[test]
fn of_a_kernel_that_is_a_view_have_its_gradients() {
    let case = square(2, [3, 5], [6, 6], 3, 1);
    let turned = |weight: &Tensor| weight.permute((1, 0, 3, 2));
    let of_view = |x: &Tensor, stored: &Tensor| portable(case)(x, &turned(stored)?);
    let of_copy = |x: &Tensor, stored: &Tensor| candle_s(case)(x, &turned(stored)?.contiguous()?);
    let stored = Case {
        weight: [3, 5, 3, 3],
        ..case
    };
    let found = found(stored, DType::F64, of_view);
    assert_close(case, &found, &expected(stored, DType::F64, of_copy), 1e-13);
}

#[test]
fn in_parts_of_a_batch_are_those_of_the_whole() {
    for stride in [1, 2] {
        let case = square(5, [2, 3], [6, 7], 3, stride);
        let whole = expected(case, DType::F64, portable(case));
        // With stride 1 an image's windows take 42 x 18 x 8 bytes: parts of one, two and four images.
        for at_once_bytes in [0, 13_000, 30_000] {
            let in_parts = |x: &Tensor, weight: &Tensor| {
                portable::correlate(x, weight, stride, case.padding, at_once_bytes)
            };
            assert_close(case, &found(case, DType::F64, in_parts), &whole, 1e-13);
        }
    }
}

#[test]
fn of_bf16_round_to_it() {
    // bf16 keeps 8 bits: inputs, results and gradients are rounded each.
    for case in of_models([33, 30], 16) {
        let found = found(case, DType::BF16, portable(case));
        let expected = expected(case, DType::F64, portable(case));
        assert_close(case, &found, &expected, 0.02);
    }
}

#[test]
fn with_a_kernel_larger_than_the_image_are_refused() {
    let of = |shape: &[usize]| values(1, shape, DType::F32, &device());
    let (x, weight) = (of(&[1, 1, 2, 4]), of(&[1, 1, 3, 3]));
    let refused = portable::conv2d(&x, &weight, None, 1, (0, 0));
    let refused = refused.unwrap_err().to_string();
    let sizes = ["3 x 3", "2 x 4"];
    assert!(sizes.iter().all(|size| refused.contains(size)), "{refused}");
}
