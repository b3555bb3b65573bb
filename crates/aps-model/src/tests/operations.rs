//! Values of operations at sizes that the models' golden values do not reach, and behaviour that is not a value.

use candle_core::{DType, Device, ModuleT, Tensor, Var};

use super::flat;
use crate::layers::Dropout;
use crate::ops::portable;

fn image(rows: &[&[f64]]) -> Tensor {
    let data: Vec<f64> = rows.concat();
    Tensor::from_vec(data, (1, 1, rows.len(), rows[0].len()), &Device::Cpu).unwrap()
}

#[test]
fn average_over_parts_that_overlap() {
    // Five elements in two parts: 0..3 and 2..5.
    let x = image(&[&[0.0, 3.0, 6.0, 9.0, 12.0]]);
    let found = flat(&portable::adaptive_avg_pool(&x, 2).unwrap());
    for (found, expected) in found.iter().zip([3.0, 9.0, 3.0, 9.0]) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
}

#[test]
fn maximum_of_negative_values_does_not_see_the_padding() {
    let x = image(&[&[-4.0, -3.0], &[-2.0, -1.0]]);
    assert_eq!(flat(&portable::max_pool_3x3_s2_p1(&x).unwrap()), [-1.0]);
}

#[test]
fn maximum_leaves_out_an_odd_last_column() {
    let x = image(&[&[1.0, 2.0, 9.0], &[3.0, 4.0, 9.0]]);
    assert_eq!(flat(&portable::max_pool_2x2(&x).unwrap()), [4.0]);
}

#[test]
fn nan_is_not_hidden_by_rectifiers_and_maxima() {
    let values = |x: &Tensor| x.flatten_all().unwrap().to_vec1::<f32>().unwrap();
    for place in 0..4 {
        let mut pixels = [-1.0, -0.0, 0.5, 3.0_f32];
        pixels[place] = f32::NAN;
        let x = Tensor::from_slice(&pixels, (1, 1, 2, 2), &Device::Cpu).unwrap();
        for pool in [portable::max_pool_2x2, portable::max_pool_3x3_s2_p1] {
            let found = values(&pool(&x).unwrap());
            assert!(found[0].is_nan(), "{found:?} of {pixels:?}");
        }
        let found = values(&portable::relu(&x).unwrap());
        for (i, (found, pixel)) in found.iter().zip(pixels).enumerate() {
            let is_same = match i == place {
                true => found.is_nan(),
                false => found.to_bits() == (pixel.max(0.0) + 0.0).to_bits(),
            };
            assert!(is_same, "value {i} of {pixels:?} is {found}");
        }
    }
}

#[test]
fn resizing_doubles_and_halves_as_pytorch_does() {
    // torch.nn.functional.interpolate(mode="bilinear", align_corners=False)
    let resized = |row: &[f64], width| {
        let resized = portable::resize_bilinear(&image(&[row]), 1, width);
        flat(&resized.unwrap())
    };
    assert_eq!(resized(&[0.0, 4.0], 4), [0.0, 1.0, 3.0, 4.0]);
    assert_eq!(resized(&[1.0, 3.0, 5.0, 7.0], 2), [2.0, 6.0]);
}

#[test]
fn running_statistics_move_by_a_tenth_with_the_unbiased_variance() {
    let vector = |v: f64| Tensor::from_vec(vec![v], 1, &Device::Cpu).unwrap();
    let [mean, variance] = [1.0, 2.0].map(|v| Var::from_tensor(&vector(v)).unwrap());
    let x = Tensor::from_vec(vec![2.0, 4.0, 6.0], (3, 1), &Device::Cpu).unwrap();
    let tensors = portable::BatchNormTensors {
        weight: &vector(1.0),
        bias: &vector(0.0),
        running_mean: &mean,
        running_var: &variance,
    };
    let y = portable::batch_norm(&x, tensors, true).unwrap();
    // Mean 4, variance 8/3 over n and 4 over n - 1.
    let expected = 2.0 / (8.0_f64 / 3.0 + 1e-5).sqrt();
    assert!((flat(&y)[2] - expected).abs() < 1e-12);
    assert!((flat(mean.as_tensor())[0] - 1.3).abs() < 1e-12);
    assert!((flat(variance.as_tensor())[0] - 2.2).abs() < 1e-12);

    let one = x.narrow(0, 0, 1).unwrap();
    let refused = portable::batch_norm(&one, tensors, true);
    let refused = refused.unwrap_err().to_string();
    let told = ["more than one value a channel", "[1, 1]"];
    assert!(told.iter().all(|told| refused.contains(told)), "{refused}");
}

#[test]
fn dropout_keeps_the_mean_and_follows_its_seed() {
    let x = Tensor::ones(100_000, DType::F64, &Device::Cpu).unwrap();
    let dropout = Dropout::new(0.1);
    let drop = |seed, step| {
        dropout.seed(seed, step);
        flat(&dropout.forward_t(&x, true).unwrap())
    };
    let dropped = drop(1, 0);
    let mean = dropped.iter().sum::<f64>() / dropped.len() as f64;
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
    let zeros = dropped.iter().filter(|&&v| v == 0.0).count();
    let is_tenth = (9_500..10_500).contains(&zeros);
    assert!(is_tenth, "{zeros} of 100,000 dropped");
    let next = flat(&dropout.forward_t(&x, true).unwrap());
    assert_ne!(dropped, next, "passes differ");
    assert_eq!(dropped, drop(1, 0));
    assert_ne!(dropped, drop(2, 0));
    assert_ne!(dropped, drop(1, 1));
    assert_eq!(flat(&dropout.forward_t(&x, false).unwrap()), flat(&x));
}

#[test]
fn gelu_of_half_precision_is_rounded_once() {
    let x: Vec<f32> = (-160..160).map(|i| i as f32 / 32.0).collect();
    let x = Tensor::new(x, &Device::Cpu).unwrap();
    let exact = portable::gelu(&x).unwrap().to_dtype(DType::BF16).unwrap();
    let found = portable::gelu(&x.to_dtype(DType::BF16).unwrap()).unwrap();
    assert_eq!((found.dtype(), flat(&found)), (DType::BF16, flat(&exact)));
}
