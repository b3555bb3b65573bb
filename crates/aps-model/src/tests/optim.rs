//! Losses and optimizers against PyTorch (`tests/golden/optimizers.py`), and the laws they keep.

use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Result, Tensor, Var};
use candle_nn::{Optimizer, VarMap};
use proptest::prelude::*;
use serde_json::Value;

use super::{builder, flat, on_threads};
use crate::optim::{AdamConfig, AdamW, clip_factor, gradient_norm};
use crate::train::{Budget, Schedule};
use crate::{loss, trainable};

const SHAPES: [(&str, &[usize]); 2] = [("a", &[3, 5]), ("b", &[7])];

fn golden() -> Value {
    serde_json::from_str(include_str!("../../../../tests/golden/optimizers.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().unwrap().iter();
    numbers.map(|x| x.as_f64().unwrap()).collect()
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64], relative: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (f, e)) in found.iter().zip(expected).enumerate() {
        let tolerance = relative * e.abs().max(1e-3);
        assert!((f - e).abs() <= tolerance, "{i}: {f} is not {e}");
    }
}

fn letter(name: &str) -> usize {
    name.as_bytes()[0].into()
}

/// As in the script.
fn start(name: &str, n: usize) -> Vec<f64> {
    let value = |i: usize| ((7 * i + name.len() + letter(name)) % 11) as f64 - 5.0;
    (0..n).map(|i| value(i) / 5.0).collect()
}

/// As in the script.
fn gradient(name: &str, n: usize, step: usize) -> Vec<f64> {
    let scale = if step.is_multiple_of(3) { 0.75 } else { 0.05 };
    let value = |i: usize| ((3 * i + 5 * step + letter(name)) % 13) as f64 - 6.0;
    (0..n).map(|i| scale * value(i) / 6.0).collect()
}

fn tensor(values: Vec<f64>, shape: &[usize], dtype: DType) -> Tensor {
    let tensor = Tensor::from_vec(values, shape, &Device::Cpu).unwrap();
    tensor.to_dtype(dtype).unwrap()
}

/// Gradients with these values: those of the sum of products with them.
fn gradients(of: &[(Var, Tensor)]) -> GradStore {
    let mut loss = Tensor::zeros((), of[0].0.dtype(), &Device::Cpu).unwrap();
    for (var, gradient) in of {
        loss = (loss + (var.as_tensor() * gradient).unwrap().sum_all().unwrap()).unwrap();
    }
    loss.backward().unwrap()
}

fn variables(dtype: DType) -> Vec<(String, Var)> {
    let parameters = VarMap::new();
    for (name, shape) in SHAPES {
        builder(&parameters, dtype, 0).get(shape, name).unwrap();
    }
    let variables = trainable(&parameters);
    for (name, var) in &variables {
        let values = start(name, var.elem_count());
        var.set(&tensor(values, var.dims(), dtype)).unwrap();
    }
    variables
}

fn optimizer(variables: &[(String, Var)], config: AdamConfig) -> AdamW {
    let vars = variables.iter().map(|(_, var)| var.clone()).collect();
    AdamW::new(vars, config.with_rate(0.0)).unwrap()
}

fn step_gradients(variables: &[(String, Var)], step: usize) -> GradStore {
    let of = |(name, var): &(String, Var)| {
        let values = gradient(name, var.elem_count(), step);
        let gradient = tensor(values, var.dims(), var.dtype());
        (var.clone(), gradient)
    };
    gradients(&variables.iter().map(of).collect::<Vec<_>>())
}

fn values(variables: &[(String, Var)]) -> Vec<Vec<f64>> {
    variables.iter().map(|(_, var)| flat(var)).collect()
}

fn assert_trajectory(name: &str, config: AdamConfig, learning_rate: f64, dtype: DType) {
    let expected = &golden()[name];
    let variables = variables(dtype);
    let mut adam = optimizer(&variables, config);
    adam.set_learning_rate(learning_rate);
    let mut compared = 0;
    for (step, norm) in numbers(&expected["norms"]).into_iter().enumerate() {
        let gradients = step_gradients(&variables, step);
        let vars = variables.iter().map(|(_, var)| var);
        let found = gradient_norm(&gradients, vars).unwrap();
        assert_close(&[found], &[norm], 1e-6);
        adam.step_scaled(&gradients, clip_factor(found, 1.0))
            .unwrap();
        if let Some(weights) = expected["weights"].get((step + 1).to_string()) {
            for (name, var) in &variables {
                assert_close(&flat(var), &numbers(&weights[name]), 2e-6);
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 6);
}

const ADAMW: AdamConfig = AdamConfig {
    beta1: 0.9,
    beta2: 0.999,
    epsilon: 1e-8,
    weight_decay: 0.1,
};

#[test]
fn adam_with_clipping_is_pytorchs() {
    assert_trajectory("adam", AdamConfig::adversarial(), 2e-2, DType::F32);
}

#[test]
fn adamw_with_clipping_is_pytorchs() {
    assert_trajectory("adamw", ADAMW, 3e-2, DType::F32);
}

/// Weights of another type take the way of other devices.
#[test]
fn composed_update_is_pytorchs_too() {
    assert_trajectory("adam", AdamConfig::adversarial(), 2e-2, DType::F64);
    assert_trajectory("adamw", ADAMW, 3e-2, DType::F64);
}

#[test]
fn restored_optimizer_goes_on_as_if_never_stopped() {
    let run = |steps: std::ops::Range<usize>, variables: &[(String, Var)], adam: &mut AdamW| {
        adam.set_learning_rate(1e-2);
        for step in steps {
            adam.step_scaled(&step_gradients(variables, step), 0.5)
                .unwrap();
        }
    };
    let straight = variables(DType::F32);
    run(0..9, &straight, &mut optimizer(&straight, ADAMW));

    let stopped = variables(DType::F32);
    let mut adam = optimizer(&stopped, ADAMW);
    run(0..4, &stopped, &mut adam);
    let mut again = optimizer(&stopped, ADAMW);
    let moments = adam.moments().unwrap();
    again.restore(4, &moments).unwrap();
    run(4..9, &stopped, &mut again);
    assert_eq!(values(&straight), values(&stopped));
    assert!(again.restore(4, &moments[1..]).is_err());
}

#[test]
fn variable_without_gradient_stays() {
    let variables = variables(DType::F32);
    let before = values(&variables);
    let mut adam = optimizer(&variables, ADAMW);
    adam.set_learning_rate(0.1);
    let a = variables[0].1.clone();
    let ones = a.ones_like().unwrap();
    adam.step(&gradients(&[(a, ones)])).unwrap();
    let after = values(&variables);
    assert_ne!(before[0], after[0]);
    assert_eq!(before[1], after[1]);
}

type Loss = fn(&Tensor, &Tensor) -> Result<Tensor>;

#[test]
fn losses_and_gradients_are_pytorchs_even_at_huge_logits() {
    let all: [(&str, Loss); 3] = [
        ("mse", candle_nn::loss::mse),
        ("l1", loss::l1),
        ("bce_with_logits", loss::bce_with_logits),
    ];
    for (name, loss) in all {
        let expected = &golden()["losses"][name];
        let read = |key: &str| {
            let values = numbers(&expected[key]);
            let n = values.len();
            tensor(values, &[n], DType::F32)
        };
        let input = Var::from_tensor(&read("input")).unwrap();
        let value = loss(&input, &read("target")).unwrap();
        assert_close(&flat(&value), &[expected["value"].as_f64().unwrap()], 1e-6);
        let gradients = value.backward().unwrap();
        let gradient = flat(gradients.get(&input).unwrap());
        for (found, expected) in gradient.iter().zip(numbers(&expected["gradient"])) {
            // Gradients of saturated logits are tiny, not zero: compared relative to themselves.
            let is_close = (found - expected).abs() <= 1e-5 * expected.abs();
            assert!(is_close, "{name}: {found} is not {expected}");
        }
    }
}

#[test]
fn nothing_moves_by_a_norm_that_is_not_a_number() {
    let variables = variables(DType::F32);
    let before = values(&variables);
    let a = &variables[0].1;
    let bad = (a.ones_like().unwrap() * f64::NAN).unwrap();
    let loss = (a.as_tensor() * bad).unwrap().sum_all().unwrap();
    let mut adam = optimizer(&variables, ADAMW);
    adam.set_learning_rate(0.1);
    assert!(adam.backward_step_clipped(&loss, 1.0).unwrap().is_nan());
    assert_eq!(values(&variables), before);
}

#[test]
fn norm_does_not_depend_on_threads() {
    let n = 200_003;
    let value = |i: usize| ((i * 7919) % 1001) as f64 / 997.0 - 0.5;
    let values = tensor((0..n).map(value).collect(), &[n], DType::F32);
    let var = Var::from_tensor(&values).unwrap();
    let gradients = gradients(&[(var.clone(), values)]);
    let norm = || gradient_norm(&gradients, [&var]).unwrap().to_bits();
    assert_eq!(on_threads(1, norm), on_threads(3, norm));
}

proptest! {
    #[test]
    fn schedule_rises_then_falls_to_zero(warmup in 0_u64..50, more in 1_u64..2000) {
        let total = warmup + more;
        let schedule = Schedule { peak: 2.0, warmup, budget: Budget::Steps(total) };
        let rates: Vec<f64> = (0..=total).map(|s| schedule.at(s, 0.0)).collect();
        let top = warmup.min(total / 10).saturating_sub(1) as usize;
        prop_assert!(rates[..=top].is_sorted());
        prop_assert!(rates[top..].is_sorted_by(|a, b| a > b));
        prop_assert!((rates[top] - 2.0).abs() < 1e-12);
        prop_assert!(rates[..total as usize].iter().all(|&r| r > 0.0));
        prop_assert_eq!(rates[total as usize], 0.0);
    }

    /// Whatever the speed of the machine: some steps a tenth of the budget, or less than one.
    #[test]
    fn schedule_over_time_rises_within_a_tenth_and_ends_at_zero(warmup in 0_u64..50, step_s in 0.01..20.0_f64) {
        let schedule = Schedule { peak: 2.0, warmup, budget: Budget::Seconds(60.0) };
        let steps = (60.0 / step_s).ceil() as u64;
        let rates: Vec<f64> = (0..steps).map(|s| schedule.at(s, s as f64 * step_s)).collect();
        let top = rates.iter().position(|&r| r == rates.iter().copied().fold(0.0, f64::max)).unwrap();
        prop_assert!(rates[..=top].is_sorted());
        prop_assert!(rates[top..].is_sorted_by(|a, b| a >= b));
        prop_assert!(top as f64 * step_s <= 6.0 + step_s, "the peak is step {top}");
        prop_assert!(rates.iter().all(|&r| r > 0.0 && r <= 2.0));
        prop_assert_eq!(schedule.at(steps, 60.0), 0.0);
    }

    #[test]
    fn clipped_gradients_are_never_longer_than_asked(norm in 0.0..1e6_f64, max in 1e-3..1e3_f64) {
        let factor = clip_factor(norm, max);
        prop_assert!(factor <= 1.0 && norm * factor <= max);
        prop_assert!(norm > max || factor > 1.0 - 1e-2 * (1e-4 / max));
    }
}
