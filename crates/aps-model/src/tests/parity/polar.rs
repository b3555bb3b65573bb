//! Polar-Reg: `tests/golden/polar_reg.py` of the repository says what is compared.

use candle_core::{DType, Device, ModuleT, Result, Tensor};
use candle_nn::VarMap;

use super::super::{WAYS, blank};
use super::golden::Golden;
use super::optimizer::{Adam, gradients};
use super::rule::{BATCH, set_weights, values};
use super::training::{Tolerances, check_after, check_gradients, check_loss, scalar, tensors};
use crate::condition::PolarShape;
use crate::models::polar_reg::PolarReg;
use crate::parameters::FIXED;
use crate::{ANGLE_BINS, LabelFacts, Loss};

/// Power response of a half-wavelength linear array on the y axis, at most 1: bins from -180 degrees, directions from half a
/// step of theirs.
fn response(elements: f64) -> Vec<f64> {
    let [bin_rad, direction_rad] =
        [ANGLE_BINS, WAYS.directions].map(|count| std::f64::consts::TAU / count as f64);
    let of = |bin: usize, direction: usize| {
        let look = bin as f64 * bin_rad - std::f64::consts::PI;
        let half_phase = 0.5
            * std::f64::consts::PI
            * (look.sin() - ((direction as f64 + 0.5) * direction_rad).sin());
        let (one, many) = (half_phase.sin(), (elements * half_phase).sin());
        match one.abs() < 1e-12 {
            true => 1.0,
            false => (many / (elements * one)).powi(2),
        }
    };
    let bins = 0..ANGLE_BINS;
    bins.flat_map(|bin| (0..WAYS.directions).map(move |direction| of(bin, direction)))
        .collect()
}

fn facts(elements: f64) -> LabelFacts {
    LabelFacts {
        array: response(elements),
        mean: 0.125,
        deviation: 0.25,
        is_by_link: false,
    }
}

fn model(dtype: DType) -> (PolarReg, VarMap) {
    let parameters = VarMap::new();
    let model = PolarReg::new(WAYS, blank(&parameters, dtype)).unwrap();
    set_weights(&parameters);
    facts(16.0).set(&parameters).unwrap();
    (model, parameters)
}

/// A way from each direction and of each kind, features between 0 and 1; half of them are zeros.
fn ways(dtype: DType) -> Tensor {
    let PolarShape {
        directions,
        kinds,
        features,
    } = WAYS;
    let all: Vec<f64> = values("ways", BATCH * directions * kinds * features).collect();
    let way = |(n, way): (usize, &[f64])| -> Vec<f64> {
        if way[1] <= 0.0 {
            return vec![0.0; WAYS.per_way()];
        }
        let numbers = [n / kinds % directions, n % kinds].map(|number| number as f64);
        let mut way: Vec<f64> = way.iter().map(|value| value.abs()).chain(numbers).collect();
        way[1] = 1.0;
        way
    };
    let data: Vec<f64> = all.chunks(features).enumerate().flat_map(way).collect();
    let shape = (BATCH, directions * kinds, WAYS.per_way());
    let ways = Tensor::from_vec(data, shape, &Device::Cpu).unwrap();
    ways.to_dtype(dtype).unwrap()
}

/// Standardised spectra with maximum 1, most of them low.
fn targets(dtype: DType) -> Tensor {
    let power: Vec<f64> = values("spectra", BATCH * ANGLE_BINS)
        .map(|u| ((u + 1.0) / 2.0).powi(4))
        .collect();
    let standard = |row: &[f64]| -> Vec<f64> {
        let top = row.iter().copied().fold(0.0, f64::max);
        row.iter().map(|p| (p / top - 0.125) / 0.25).collect()
    };
    let data: Vec<f64> = power.chunks(ANGLE_BINS).flat_map(standard).collect();
    let targets = Tensor::from_vec(data, (BATCH, ANGLE_BINS), &Device::Cpu).unwrap();
    targets.to_dtype(dtype).unwrap()
}

fn outputs_are_pytorch_s(dtype: DType, tolerance: f64) -> Result<()> {
    let golden = Golden::of("polar_reg");
    let (model, parameters) = model(dtype);
    let ways = ways(dtype);
    golden.check_absolute("power", &model.power(&ways)?, tolerance);
    golden.check_absolute("eval", &model.forward_t(&ways, false)?, tolerance);
    // Another array is another matrix.
    facts(8.0).set(&parameters).unwrap();
    golden.check_absolute("eval_8", &model.forward_t(&ways, false)?, tolerance);
    Ok(())
}

fn training_is_pytorch_s(dtype: DType) -> Result<()> {
    let (golden, tolerances) = (Golden::of("polar_reg"), Tolerances::of(dtype));
    let (model, parameters) = model(dtype);
    let array = tensors(&parameters);
    let array = array.iter().filter(|(name, _)| name == "fixed.array");
    let array: Vec<_> = array
        .map(|(_, array)| ("array".to_owned(), array.clone()))
        .collect();
    check_gradients(&golden.rows("array", &array), &tolerances);
    let (ways, targets) = (ways(dtype), targets(dtype));
    let mut optimizer = Adam::new(3e-4, [0.9, 0.999], 0.01);
    for step in 0..tolerances.steps {
        let output = model.forward_t(&ways, true)?;
        let loss = Loss::AbsoluteAndCosine.error(&output, &targets)?;
        let store = loss.backward()?;
        let moves = gradients(&parameters, &store);
        if step == 0 {
            golden.check_absolute("train", &output, tolerances.output);
            check_gradients(&golden.rows("gradients", &moves), &tolerances);
        }
        check_loss(&golden.values("losses"), step, scalar(&loss), &tolerances);
        optimizer.step(&parameters, &moves);
    }
    if tolerances.steps == 3 {
        let mut all = tensors(&parameters);
        all.retain(|(name, _)| !name.starts_with(FIXED));
        check_after(&golden.rows("after", &all));
    }
    Ok(())
}

#[test]
fn outputs_of_polar_reg() {
    outputs_are_pytorch_s(DType::F32, 1e-4).unwrap();
    outputs_are_pytorch_s(DType::F64, 1e-9).unwrap();
}

#[test]
fn gradients_of_polar_reg() {
    training_is_pytorch_s(DType::F32).unwrap();
}

#[test]
fn three_steps_of_polar_reg() {
    training_is_pytorch_s(DType::F64).unwrap();
}

#[test]
fn a_batch_without_links_is_refused() {
    let (model, _) = model(DType::F32);
    let none = ways(DType::F32).narrow(0, 0, 0).unwrap();
    let refused = model.forward_t(&none, false).unwrap_err().to_string();
    assert!(
        refused.contains("one link and one way at least"),
        "{refused}"
    );
}

#[test]
fn links_that_no_way_reaches_have_spectra() {
    let (model, _) = model(DType::F32);
    let nothing = ways(DType::F32).zeros_like().unwrap();
    for train in [false, true] {
        let spectra = model.forward_t(&nothing, train).unwrap();
        let spectra: Vec<f32> = spectra.flatten_all().unwrap().to_vec1().unwrap();
        assert!(spectra.iter().all(|value| value.is_finite()));
    }
}
