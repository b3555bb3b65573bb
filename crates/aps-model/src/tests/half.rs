//! Every model in bf16, on a CPU.

use candle_core::{DType, Device, Tensor};
use candle_nn::VarMap;

use super::{WAYS, builder, flat, shape_of, some_ways};
use crate::condition::InputKind;
use crate::{ANGLE_BINS, LabelFacts, ModelKind, Preset, frozen};

/// bf16 has eight bits of a number: an answer is off by some hundredths of the outputs' spread, not by orders.
#[test]
fn every_model_answers_in_half_precision() {
    let value = |i: usize| f32::from(i % 61 < 20) + (i % 7) as f32 / 8.0;
    let images: Vec<f32> = (0..2 * 3 * 64 * 64).map(value).collect();
    let images = Tensor::from_vec(images, (2, 3, 64, 64), &Device::Cpu).unwrap();
    let ways = some_ways(2, 40);
    // An array that sees a direction and its neighbours.
    let share = WAYS.directions / ANGLE_BINS;
    let near = |i: usize| f64::from(i / WAYS.directions == i % WAYS.directions / share);
    let facts = LabelFacts {
        array: (0..ANGLE_BINS * WAYS.directions).map(near).collect(),
        mean: 0.1,
        deviation: 0.2,
        is_by_link: false,
    };
    for kind in ModelKind::ALL {
        let shape = shape_of(kind);
        let answer = |dtype: DType| -> Vec<f64> {
            let parameters = VarMap::new();
            let vb = builder(&parameters, dtype, 3);
            kind.build(Preset::Small, shape, vb).unwrap();
            facts.set(&parameters).unwrap();
            if kind == ModelKind::PolarReg {
                // Drawn weights share the power out evenly: of spectra that are all maximum only rounding would be compared.
                let out = parameters.data().lock().unwrap()["ways.out.weight"].clone();
                let larger = (out.as_detached_tensor() * 16.0).unwrap();
                out.set(&larger).unwrap();
            }
            let model = kind.build(Preset::Small, shape, frozen(&parameters).unwrap());
            let input = match kind.input() {
                InputKind::Images => images.to_dtype(dtype).unwrap(),
                InputKind::Polar => ways.clone(),
            };
            let y = model.unwrap().forward_t(&input, false);
            let y = y.unwrap_or_else(|e| panic!("{kind} in {dtype:?}: {e}"));
            assert_eq!(y.dims(), [2, ANGLE_BINS]);
            flat(&y)
        };
        let (full, half) = (answer(DType::F32), answer(DType::BF16));
        let mean = full.iter().sum::<f64>() / full.len() as f64;
        let norm = |f: &dyn Fn(usize) -> f64| -> f64 {
            (0..full.len()).map(|i| f(i).powi(2)).sum::<f64>().sqrt()
        };
        let spread = norm(&|i| full[i] - mean);
        let error = norm(&|i| half[i] - full[i]) / spread;
        println!("{kind}: off by {error:.1e} of the outputs' spread");
        assert!(error > 0.0 && error < 0.2, "{kind}: {error}");
    }
}
