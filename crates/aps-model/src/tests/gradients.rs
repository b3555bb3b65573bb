//! Gradients of every operation against central differences, in double precision.

use candle_core::{Device, Result, Tensor, Var};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::flat;
use crate::ops::portable;

/// Values in [-1, 1) that are never closer to each other than 1e-3, so that no difference crosses a tie or a kink.
fn values(generator: &mut ChaCha8Rng, shape: &[usize]) -> Tensor {
    let count: usize = shape.iter().product();
    let mut order: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        order.swap(i, generator.next_u64() as usize % (i + 1));
    }
    let value = |&o: &usize| (2 * o + 1) as f64 / count as f64 - 1.0 + 1e-3;
    let data: Vec<f64> = order.iter().map(value).collect();
    Tensor::from_vec(data, shape, &Device::Cpu).unwrap()
}

/// Compares gradients of a random projection of `f` with central differences, at every element of every input.
fn check(name: &str, shapes: &[&[usize]], f: impl Fn(&[Tensor]) -> Result<Tensor>) {
    let mut generator = ChaCha8Rng::seed_from_u64(5);
    let mut draw = |shape: &&[usize]| Var::from_tensor(&values(&mut generator, shape)).unwrap();
    let inputs: Vec<Var> = shapes.iter().map(&mut draw).collect();
    let output = || {
        let tensors: Vec<Tensor> = inputs.iter().map(|v| v.as_tensor().clone()).collect();
        f(&tensors).unwrap()
    };
    let projection = values(&mut generator, output().dims());
    let objective = || (output() * &projection).unwrap().sum_all().unwrap();
    let store = objective().backward().unwrap();
    for (which, var) in inputs.iter().enumerate() {
        let gradient: Vec<f64> = flat(store.get(var.as_tensor()).unwrap());
        let original = var.as_tensor().copy().unwrap();
        let at = flat(&original);
        for (i, &analytic) in gradient.iter().enumerate() {
            let step = 1e-5;
            let shifted = |by: f64| {
                let mut moved = at.clone();
                moved[i] += by;
                let moved = Tensor::from_vec(moved, original.dims(), &Device::Cpu).unwrap();
                var.set(&moved).unwrap();
                objective().to_scalar::<f64>().unwrap()
            };
            let numeric = (shifted(step) - shifted(-step)) / (2.0 * step);
            assert!(
                (analytic - numeric).abs() <= 1e-7 * (1.0 + numeric.abs()),
                "{name}, input {which}, element {i}: {analytic}, by differences {numeric}"
            );
        }
        var.set(&original).unwrap();
    }
}

/// Shapes of input and kernel, stride, padding.
type Case = (&'static [usize], &'static [usize], usize, (usize, usize));

#[test]
fn of_convolutions() {
    // Convolutions of the models, and sizes that strides do not divide.
    let cases: [Case; 9] = [
        (&[2, 3, 6, 5], &[4, 3, 3, 3], 1, (1, 1)),
        (&[2, 2, 6, 6], &[3, 2, 3, 3], 2, (1, 1)),
        (&[1, 2, 7, 6], &[3, 2, 3, 3], 2, (1, 1)),
        (&[1, 3, 9, 8], &[2, 3, 7, 7], 2, (3, 3)),
        (&[2, 3, 4, 4], &[2, 3, 1, 1], 1, (0, 0)),
        (&[2, 3, 5, 4], &[2, 3, 1, 1], 2, (0, 0)),
        (&[2, 3, 1, 9], &[2, 3, 1, 5], 1, (0, 2)),
        (&[1, 2, 8, 8], &[3, 2, 4, 4], 4, (0, 0)),
        (&[1, 2, 4, 9], &[2, 2, 3, 2], 3, (2, 0)),
    ];
    for (x, weight, stride, padding) in cases {
        let name = format!("conv2d {x:?} {weight:?} stride {stride} padding {padding:?}");
        check(&name, &[x, weight, &[weight[0]]], |t| {
            portable::conv2d(&t[0], &t[1], Some(&t[2]), stride, padding)
        });
    }
    let shapes: [&[usize]; 2] = [&[1, 2, 4, 4], &[2, 2, 3, 3]];
    check("conv2d without bias", &shapes, |t| {
        portable::conv2d(&t[0], &t[1], None, 1, (1, 1))
    });
    let shapes: [&[usize]; 3] = [&[2, 3, 3, 2], &[3, 2, 2, 2], &[2]];
    check("conv_transpose2x2", &shapes, |t| {
        portable::conv_transpose2x2(&t[0], &t[1], &t[2])
    });
}

#[test]
fn of_pooling() {
    for size in [[4, 6], [5, 7], [1, 2], [3, 2]] {
        let shape: &[usize] = &[2, 2, size[0], size[1]];
        check("max_pool_3x3_s2_p1", &[shape], |t| {
            portable::max_pool_3x3_s2_p1(&t[0])
        });
        for out in [1, 2, 4] {
            check("adaptive_avg_pool", &[shape], |t| {
                portable::adaptive_avg_pool(&t[0], out)
            });
        }
        if size[0] > 1 {
            check("max_pool_2x2", &[shape], |t| portable::max_pool_2x2(&t[0]));
        }
    }
}

#[test]
fn of_changes_of_resolution() {
    for (height, width) in [(7, 3), (2, 9), (4, 4), (4, 5)] {
        check("resize_bilinear", &[&[2, 1, 4, 5]], |t| {
            portable::resize_bilinear(&t[0], height, width)
        });
    }
    check("upsample_nearest_2x", &[&[2, 3, 5]], |t| {
        portable::upsample_nearest_2x(&t[0])
    });
}

#[test]
fn of_normalisations() {
    for (x, channels) in [(&[3, 2, 2, 3][..], 2), (&[4, 3], 3), (&[2, 3, 5], 3)] {
        for train in [false, true] {
            let buffer = |value| {
                Var::from_tensor(&Tensor::full(value, channels, &Device::Cpu).unwrap()).unwrap()
            };
            for relu in [false, true] {
                check("batch_norm", &[x, &[channels], &[channels]], |t| {
                    // Fresh ones: each pass moves them.
                    let (running_mean, running_var) = (buffer(0.2_f64), buffer(0.7));
                    let tensors = portable::BatchNormTensors {
                        weight: &t[1],
                        bias: &t[2],
                        running_mean: &running_mean,
                        running_var: &running_var,
                    };
                    let y = portable::batch_norm(&t[0], tensors, train)?;
                    if relu { portable::relu(&y) } else { Ok(y) }
                });
            }
        }
    }
    check("layer_norm", &[&[2, 3, 5], &[5], &[5]], |t| {
        portable::layer_norm(&t[0], &t[1], &t[2])
    });
}

#[test]
fn of_elementwise_functions_and_products() {
    check("relu", &[&[3, 4]], |t| portable::relu(&t[0]));
    check("leaky_relu", &[&[3, 4]], |t| {
        portable::leaky_relu(&t[0], 0.2)
    });
    check("gelu", &[&[3, 4]], |t| portable::gelu(&(&t[0] * 3.0)?));
    check("max_last", &[&[2, 3, 4]], |t| portable::max_last(&t[0]));
    check("softmax_last", &[&[2, 3, 4]], |t| {
        portable::softmax_last(&t[0])
    });
    check("linear", &[&[2, 3, 4], &[5, 4], &[5]], |t| {
        portable::linear(&t[0], &t[1], &t[2])
    });
}

#[test]
fn of_ties_goes_to_the_first_and_of_relu_at_zero_is_zero() {
    let gradient = |x: &[f32], shape: [usize; 4], f: fn(&Tensor) -> Result<Tensor>| {
        let x = Var::from_tensor(&Tensor::from_slice(x, &shape, &Device::Cpu).unwrap()).unwrap();
        let sum = f(x.as_tensor()).unwrap().sum_all().unwrap();
        flat(sum.backward().unwrap().get(x.as_tensor()).unwrap())
    };
    // torch.nn.functional.max_pool2d gives the same.
    let ties = gradient(&[1.0; 4], [1, 1, 2, 2], portable::max_pool_2x2);
    assert_eq!(ties, [1.0, 0.0, 0.0, 0.0]);
    let second_row = gradient(&[0.0, 1.0, 1.0, 1.0], [1, 1, 2, 2], portable::max_pool_2x2);
    assert_eq!(second_row, [0.0, 1.0, 0.0, 0.0]);
    let overlapping = gradient(&[3.0; 9], [1, 1, 3, 3], portable::max_pool_3x3_s2_p1);
    assert_eq!(overlapping, [1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let relu = gradient(&[-1.0, 0.0, 2.0, -0.0], [1, 1, 2, 2], portable::relu);
    assert_eq!(relu, [0.0, 0.0, 1.0, 0.0]);
}
