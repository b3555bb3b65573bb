//! Every model in bf16, on a CPU.

use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::candle_nn::VarMap;
use aps_model::condition::{InputKind, InputShape, PolarShape};
use aps_model::{ANGLE_BINS, LabelFacts, ModelKind, Preset, frozen, seeded};

/// bf16 has eight bits of a number: an answer is off by some hundredths of the outputs' spread, not by orders.
#[test]
fn every_model_answers_in_half_precision() {
    let device = Device::Cpu;
    let values = |shape: &[usize]| {
        let value = |i: usize| f32::from(i % 61 < 20) + (i % 7) as f32 / 8.0;
        let values: Vec<f32> = (0..shape.iter().product()).map(value).collect();
        Tensor::from_vec(values, shape, &device).unwrap()
    };
    let polar = PolarShape {
        directions: 60,
        kinds: 5,
        features: 7,
    };
    let ways = |shape: &PolarShape| {
        let way = |n: usize| {
            let feature = move |f: usize| match f {
                1 => 1.0,
                _ => f32::from(n % 61 < 20) + ((n + f) % 7) as f32 / 8.0,
            };
            let numbers = [n * 7 % shape.directions, n % shape.kinds].map(|n| n as f32);
            (0..shape.features).map(feature).chain(numbers)
        };
        let values: Vec<f32> = (0..2 * 40).flat_map(way).collect();
        Tensor::from_vec(values, (2, 40, shape.per_way()), &device).unwrap()
    };
    // An array that sees a direction and its neighbours.
    let near = |i: usize| f64::from(i / 60 / 3 == i % 60);
    let facts = LabelFacts {
        array: (0..ANGLE_BINS * 60).map(near).collect(),
        mean: 0.1,
        deviation: 0.2,
        is_by_link: false,
    };
    for kind in ModelKind::ALL {
        let (shape, input) = match kind.input() {
            InputKind::Images => (InputShape::Images, values(&[2, 3, 64, 64])),
            InputKind::Polar => (InputShape::Polar(polar), ways(&polar)),
        };
        let answer = |dtype: DType| -> Vec<f32> {
            let parameters = VarMap::new();
            let vb = seeded(&parameters, 3, dtype, &device);
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
                InputKind::Images => input.to_dtype(dtype).unwrap(),
                InputKind::Polar => input.clone(),
            };
            let y = model.unwrap().forward_t(&input, false);
            let y = y.unwrap_or_else(|e| panic!("{kind} in {dtype:?}: {e}"));
            assert_eq!(y.dims(), [2, ANGLE_BINS]);
            let flat = y.flatten_all().unwrap().to_dtype(DType::F32).unwrap();
            flat.to_vec1().unwrap()
        };
        let (full, half) = (answer(DType::F32), answer(DType::BF16));
        let mean = full.iter().sum::<f32>() / full.len() as f32;
        let norm = |f: &dyn Fn(usize) -> f32| -> f32 {
            (0..full.len()).map(|i| f(i).powi(2)).sum::<f32>().sqrt()
        };
        let spread = norm(&|i| full[i] - mean);
        let error = norm(&|i| half[i] - full[i]) / spread;
        println!("{kind}: off by {error:.1e} of the outputs' spread");
        assert!(error > 0.0 && error < 0.2, "{kind}: {error}");
    }
}
