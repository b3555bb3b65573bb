//! A perceptron for each way, and what it makes of the ways of a link: a strength of each direction.

use candle_core::{DType, Device, Module, Result, Tensor, bail};
use candle_nn::VarBuilder;
use rayon::prelude::*;

use crate::condition::PolarShape;
use crate::layers::Linear;
use crate::ops::{self, WaysShape};
use crate::recording::schema::{FLOAT, INT64};
use crate::recording::{Graph, Value, int, recorded, word};

/// Features within the perceptron of a way.
const HIDDEN: usize = 48;

/// Factor of a way's output to the logarithm of its strength, which has to spread over 50 dB and more.
const SPREAD: f64 = 6.0;

/// Largest logarithm of a strength: its exponential is a number in f32 and bf16.
const MAX_LOG: f64 = 60.0;

/// Share of a ray that a way arrives along at least.
const LEAST_SHARE: f64 = 0.01;

/// A perceptron for each way: `embed` of its features and its kind as a unit vector, `hidden`, `out`, with GELU between.
#[derive(Debug, Clone)]
pub(super) struct Ways {
    shape: PolarShape,
    dtype: DType,
    device: Device,
    embed: Linear,
    hidden: Linear,
    out: Linear,
}

impl Ways {
    pub fn new(shape: &PolarShape, vb: VarBuilder<'_>) -> Result<Self> {
        let inputs = shape.features + shape.kinds;
        Ok(Self {
            shape: *shape,
            dtype: vb.dtype(),
            device: vb.device().clone(),
            embed: Linear::new(inputs, HIDDEN, vb.pp("embed"))?,
            hidden: Linear::new(HIDDEN, HIDDEN, vb.pp("hidden"))?,
            out: Linear::new(HIDDEN, 1, vb.pp("out"))?,
        })
    }

    /// Adds the strengths of ways (links, ways, numbers) by direction: (links, directions), in f32 at least. The ways are data: no
    /// gradient is followed through them.
    pub fn sums(&self, ways: &Tensor) -> Result<Tensor> {
        self.check(ways)?;
        let on_device = ways.detach().to_device(&self.device)?;
        let [[a, b], [c, d], [e, f]] = [&self.embed, &self.hidden, &self.out].map(Linear::tensors);
        let shape = WaysShape {
            slots: ways.dim(1)?,
            features: self.shape.features,
            kinds: self.shape.kinds,
            directions: self.shape.directions,
            hidden: HIDDEN,
            spread: SPREAD as f32,
            max_log: MAX_LOG as f32,
            least_share: LEAST_SHARE as f32,
        };
        match ops::sums_of_ways(&on_device, [a, b, c, d, e, f], shape)? {
            Some(sums) => Ok(sums),
            None => self.sums_of_operations(ways, &on_device),
        }
    }

    /// [`Ways::sums`] of any type and device, one operation after the other; `input` is the tensor that a graph knows.
    fn sums_of_operations(&self, input: &Tensor, ways: &Tensor) -> Result<Tensor> {
        let nodes = |g: &mut Graph, v: &[Value]| rows_of(g, v[0], &self.shape);
        let rows = recorded(&[input], nodes, || self.rows(ways))?;
        let x = ops::gelu(&self.embed.forward(&rows)?)?;
        let out = self.out.forward(&ops::gelu(&self.hidden.forward(&x)?)?)?;
        // As normalisations, strengths, shares and the spectrum are computed in f32 at least: a maximum takes most digits away.
        let log = ops::scale(&ops::at_least_f32(&out)?, SPREAD)?;
        let column = |n: usize| ops::at_least_f32(&ops::narrow(&rows, 1, n, 1)?);
        let strength = ops::exp(&ops::at_most(&log, MAX_LOG)?)?;
        let strength = ops::mul(&strength, &ops::shift(&column(0)?, LEAST_SHARE)?)?;
        // A way of zeros has no strength.
        let strength = ops::mul(&strength, &column(1)?)?;
        let nodes = |g: &mut Graph, v: &[Value]| sums_of_rows(g, v[0], v[1], &self.shape);
        recorded(&[&strength, input], nodes, || {
            self.by_direction(&strength, ways)
        })
    }

    /// Makes rows of features and kind as a unit vector: (links times ways, features + kinds).
    fn rows(&self, ways: &Tensor) -> Result<Tensor> {
        let PolarShape {
            kinds, features, ..
        } = self.shape;
        let rows = ways.flatten(0, 1)?;
        let all_kinds = Tensor::arange(0.0_f32, kinds as f32, ways.device())?.unsqueeze(0)?;
        let kind = rows.narrow(1, features + 1, 1)?.to_dtype(DType::F32)?;
        let kind = kind.broadcast_eq(&all_kinds)?.to_dtype(self.dtype)?;
        let features = rows.narrow(1, 0, features)?.to_dtype(self.dtype)?;
        Tensor::cat(&[features, kind], 1)
    }

    /// Adds values of rows (links times ways, 1) by the direction of their ways.
    fn by_direction(&self, values: &Tensor, ways: &Tensor) -> Result<Tensor> {
        let (links, slots, _) = ways.dims3()?;
        let count = self.shape.directions;
        let direction = ways.narrow(2, self.shape.features, 1)?.squeeze(2)?;
        // A number that is none may not lead out of the sums.
        let direction = direction
            .to_dtype(DType::F32)?
            .clamp(0.0, (count - 1) as f64)?;
        let direction = direction.to_dtype(DType::U32)?.contiguous()?;
        ops::add_to_columns(&values.reshape((links, slots))?, &direction, count)
    }

    /// Refuses ways of another shape or of a type without room for their numbers, and on the CPU a way of no direction or kind.
    fn check(&self, ways: &Tensor) -> Result<()> {
        let shape = &self.shape;
        let slots = match *ways.dims() {
            [links, slots, numbers] if links * slots > 0 && numbers == shape.per_way() => slots,
            ref found => bail!(
                "ways must have the shape [links, ways, {}], one link and one way at least, not {found:?}",
                shape.per_way()
            ),
        };
        let exact = match ways.dtype() {
            DType::BF16 => 1 << 8,
            DType::F16 => 1 << 11,
            _ => 1 << 24,
        };
        if shape.directions.max(shape.kinds) > exact {
            let dtype = ways.dtype();
            bail!("{dtype:?} has no room for the numbers of more than {exact} directions or kinds");
        }
        if !ways.device().is_cpu() {
            return Ok(());
        }
        let is_unknown = |way: &[f32]| {
            let is_known = |number: f32, count: usize| {
                (0.0..count as f32).contains(&number) && number.fract() == 0.0
            };
            let [direction, kind] = [way[shape.features], way[shape.features + 1]];
            !is_known(direction, shape.directions) || !is_known(kind, shape.kinds)
        };
        let ways = ways.detach().to_dtype(DType::F32)?.contiguous()?;
        let first = ops::with_slices([&ways], |[ways]| {
            let ways = ways.par_chunks_exact(shape.per_way());
            ways.position_first(is_unknown)
        })?;
        match first {
            None => Ok(()),
            Some(n) => {
                let (link, n) = (n / slots, n % slots);
                bail!("way {n} of link {link} is of no direction or kind of {shape:?}")
            }
        }
    }
}

/// Makes [`Ways::rows`] in a graph.
fn rows_of(g: &mut Graph, input: Value, shape: &PolarShape) -> Value {
    let &PolarShape {
        kinds, features, ..
    } = shape;
    let rows = g.regroup(input, &[shape.per_way()]);
    let kind = g.slice(rows, 1, [features + 1, features + 2]);
    let all = (0..kinds).map(|kind| kind as f64).collect::<Vec<_>>();
    let all = g.numbers(&[1, kinds], &all);
    let kind = g.node("Equal", &[kind, all], []);
    let kind = g.node("Cast", &[kind], [int("to", FLOAT.into())]);
    let features = g.slice(rows, 1, [0, features]);
    g.node("Concat", &[features, kind], [int("axis", 1)])
}

/// Makes [`Ways::by_direction`] in a graph.
fn sums_of_rows(g: &mut Graph, values: Value, input: Value, shape: &PolarShape) -> Value {
    let &PolarShape {
        directions,
        features,
        ..
    } = shape;
    let by_link = g.node("Shape", &[input], [int("start", 0), int("end", 2)]);
    let values = g.node("Reshape", &[values, by_link], []);
    let direction = g.slice(input, 2, [features, features + 1]);
    let direction = g.node("Reshape", &[direction, by_link], []);
    let direction = g.node("Cast", &[direction], [int("to", INT64.into())]);
    let zeros = g.numbers(&[1, directions], &vec![0.0; directions]);
    let zeros = g.repeat(zeros, &[directions], input);
    let settings = [int("axis", 1), word("reduction", "add")];
    g.node("ScatterElements", &[zeros, direction, values], settings)
}

#[cfg(test)]
mod tests {
    use candle_core::Var;
    use candle_nn::VarMap;

    use super::*;
    use crate::tests::{flat, on_threads};
    use crate::{seeded, trainable};

    const SHAPE: PolarShape = PolarShape {
        directions: 20,
        kinds: 3,
        features: 4,
    };

    const LINKS: usize = 6;
    const SLOTS: usize = 24;

    /// Links of 24, 7, 15, no, 24 and one ways, two of some directions and kinds; the first way of the third link is one of zeros.
    fn ways() -> Tensor {
        let of_link = |link: usize| {
            (0..SLOTS).flat_map(move |n| {
                let is_there = n < [24, 7, 15, 0, 24, 1][link] && (link, n) != (2, 0);
                let feature = move |f: usize| match f {
                    1 => 1.0,
                    _ => ((n * 31 + f * 17 + link) % 64) as f32 / 64.0,
                };
                let numbers = [n * 7 % SHAPE.directions, n % SHAPE.kinds].map(|n| n as f32);
                let way = (0..SHAPE.features).map(feature).chain(numbers);
                way.map(move |number| if is_there { number } else { 0.0 })
            })
        };
        let values: Vec<f32> = (0..LINKS).flat_map(of_link).collect();
        Tensor::from_vec(values, (LINKS, SLOTS, SHAPE.per_way()), &Device::Cpu).unwrap()
    }

    fn model(shape: &PolarShape, dtype: DType) -> (Ways, VarMap) {
        let parameters = VarMap::new();
        let vb = seeded(&parameters, 5, dtype, &Device::Cpu);
        (Ways::new(shape, vb).unwrap(), parameters)
    }

    #[test]
    fn ways_of_any_type_become_rows_and_are_added_by_direction() {
        let ways = ways();
        for of_input in [DType::F32, DType::F16, DType::BF16] {
            let ways = ways.to_dtype(of_input).unwrap();
            for dtype in [DType::F32, DType::BF16] {
                let (model, _) = model(&SHAPE, dtype);
                let rows = model.rows(&ways).unwrap();
                assert_eq!(rows.dtype(), dtype);
                // A number that tells each feature and kind.
                let weights = [1.0_f32, 10.0, 3.0, 7.0, 100.0, 200.0, 300.0];
                let weights = Tensor::new(&weights, &Device::Cpu).unwrap().unsqueeze(1);
                let rows = rows.to_dtype(DType::F32).unwrap();
                let values = rows.matmul(&weights.unwrap()).unwrap();
                let values = (values * rows.narrow(1, 1, 1).unwrap()).unwrap();
                let mut expected = vec![0.0; LINKS * SHAPE.directions];
                let lists = ways.to_dtype(DType::F32).unwrap().to_vec3::<f32>().unwrap();
                for (link, ways) in lists.iter().enumerate() {
                    for way in ways.iter().filter(|way| way[1] == 1.0) {
                        let sum = &mut expected[link * SHAPE.directions + way[4] as usize];
                        let features = way[0] + 10.0 + 3.0 * way[2] + 7.0 * way[3];
                        *sum += f64::from(features + 100.0 * (way[5] + 1.0));
                    }
                }
                let found = model.by_direction(&values, &ways).unwrap();
                assert_eq!(flat(&found), expected);
            }
        }
        let finer = PolarShape {
            directions: 720,
            ..SHAPE
        };
        let ways = ways.to_dtype(DType::BF16).unwrap();
        let refused = model(&finer, DType::F32).0.sums(&ways);
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains("BF16 has no room"), "{refused}");
    }

    /// Sums of a model, and the gradients of all of its parameters.
    fn learnt(
        (model, parameters): &(Ways, VarMap),
        sums: impl Fn(&Ways) -> Result<Tensor>,
    ) -> [Vec<f64>; 2] {
        let sums = sums(model).unwrap();
        let count = LINKS * SHAPE.directions;
        let weights = Tensor::arange(0.0_f32, count as f32, &Device::Cpu);
        let weights = weights.unwrap().reshape((LINKS, SHAPE.directions)).unwrap();
        let loss = (&sums * &weights).unwrap().sum_all().unwrap();
        let store = loss.backward().unwrap();
        let of = |var: &Var| flat(store.get(var).unwrap());
        let all = trainable(parameters);
        let gradients = all.iter().flat_map(|(_, var)| of(var)).collect();
        [flat(&sums), gradients]
    }

    #[test]
    fn one_operation_computes_and_learns_what_single_ones_do() {
        // Outputs of larger weights exceed the largest logarithm now and then.
        for scale in [1.0, 100.0] {
            let model = model(&SHAPE, DType::F32);
            let vars = model.1.data().lock().unwrap().clone();
            let larger = (vars["out.weight"].as_detached_tensor() * scale).unwrap();
            vars["out.weight"].set(&larger).unwrap();
            let ways = ways();
            let expected = learnt(&model, |model| model.sums_of_operations(&ways, &ways));
            let found = learnt(&model, |model| model.sums(&ways));
            for (found, expected) in found.iter().zip(&expected) {
                let largest = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                let apart = found.iter().zip(expected).map(|(f, e)| (f - e).abs());
                let apart = apart.fold(0.0, f64::max) / largest;
                // The exponential multiplies what is rounded in 60 at most.
                assert!(apart < 1e-6 * scale, "{apart}");
            }
            for threads in [1, 3] {
                let again = on_threads(threads, || learnt(&model, |model| model.sums(&ways)));
                assert_eq!(again, found);
            }
        }
    }

    #[test]
    fn features_that_are_no_numbers_stay_so() {
        let mut numbers = flat(&ways()).iter().map(|&x| x as f32).collect::<Vec<_>>();
        numbers[3] = f32::NAN;
        let ways = Tensor::from_vec(numbers, ways().shape(), &Device::Cpu).unwrap();
        let (model, _) = model(&SHAPE, DType::F32);
        for sums in [model.sums(&ways), model.sums_of_operations(&ways, &ways)] {
            let unknown = flat(&sums.unwrap()).iter().filter(|x| x.is_nan()).count();
            assert_eq!(unknown, 1);
        }
    }

    #[test]
    fn other_shapes_are_refused() {
        let ways = ways();
        for wrong in [
            ways.narrow(2, 0, 5),
            ways.narrow(0, 0, 0),
            ways.narrow(1, 0, 0),
        ] {
            let refused = model(&SHAPE, DType::F32).0.sums(&wrong.unwrap());
            let refused = refused.unwrap_err().to_string();
            assert!(refused.contains("[links, ways, 6]"), "{refused}");
        }
    }

    #[test]
    fn a_way_of_no_direction_is_refused() {
        for (place, number) in [(4, 20.0), (4, -1.0), (5, 3.0), (5, f32::NAN), (5, 0.5)] {
            let mut ways = vec![0.0_f32; 2 * SHAPE.per_way()];
            ways[SHAPE.per_way() + place] = number;
            let ways = Tensor::from_vec(ways, (1, 2, SHAPE.per_way()), &Device::Cpu).unwrap();
            let (model, _) = model(&SHAPE, DType::F32);
            let refused = model.sums(&ways).unwrap_err().to_string();
            assert!(refused.starts_with("way 1 of link 0"), "{refused}");
            // On a device nothing is read back, but nothing is written beside the sums either.
            let values = Tensor::new(&[[0.0_f32], [1.0]], &Device::Cpu).unwrap();
            let sums = flat(&model.by_direction(&values, &ways).unwrap());
            let direction = if place == 4 && number > 0.0 { 19 } else { 0 };
            assert!(sums.len() == 20 && sums[direction] == 1.0, "{sums:?}");
        }
    }
}
