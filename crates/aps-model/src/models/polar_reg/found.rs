//! The ways of an input.

use candle_core::{DType, Device, Result, Tensor, bail};
use rayon::prelude::*;

use crate::condition::PolarShape;
use crate::ops;
use crate::recording::schema::{FLOAT, INT64};
use crate::recording::{Graph, Value, int, recorded, word};

/// The ways of some links. They are data: no gradient is followed through them.
pub(super) struct Found {
    /// (links, ways, numbers), as they are given.
    given: Tensor,
    /// (rows, features and kind as a unit vector)
    pub rows: Tensor,
    direction: Direction,
}

/// Direction of each row.
enum Direction {
    /// Its number plus the number of directions times that of the link: (rows).
    OfAll(Tensor),
    /// Its number, as many rows a link: (links, rows of a link). Sums of links are then independent of each other.
    ByLink(Tensor),
}

impl Found {
    /// Finds the ways of links, for a network of a type: on the CPU those that are no ways of zeros; on another device all, since
    /// ways of zeros have no strength.
    pub fn of(input: &Tensor, shape: &PolarShape, dtype: DType, device: &Device) -> Result<Self> {
        match *input.dims() {
            [links, ways, numbers] if links * ways > 0 && numbers == shape.per_way() => (),
            ref found => bail!(
                "ways must have the shape [links, ways, {}], one link and one way at least, not {found:?}",
                shape.per_way()
            ),
        }
        let exact = match input.dtype() {
            DType::BF16 => 1 << 8,
            DType::F16 => 1 << 11,
            _ => 1 << 24,
        };
        if shape.directions.max(shape.kinds) > exact {
            let dtype = input.dtype();
            bail!("{dtype:?} has no room for the numbers of more than {exact} directions or kinds");
        }
        if !device.is_cpu() {
            let given = input.detach().to_device(device)?;
            return Self::all(&given, shape, dtype);
        }
        let slots = input.dim(1)?;
        let (rows, directions) = ops::with_slices([&on_cpu(&input.detach())?], |[all]| {
            picked(all, slots, shape)
        })??;
        let count = directions.len();
        let rows = Tensor::from_vec(rows, (count, shape.features + shape.kinds), device)?;
        let nodes = |g: &mut Graph, v: &[Value]| every_row(g, v[0], shape);
        Ok(Self {
            given: input.clone(),
            rows: recorded(&[input], nodes, || rows.to_dtype(dtype))?,
            direction: Direction::OfAll(Tensor::from_vec(directions, count, device)?),
        })
    }

    /// Takes all ways, those of zeros too.
    fn all(given: &Tensor, shape: &PolarShape, dtype: DType) -> Result<Self> {
        let &PolarShape {
            kinds, features, ..
        } = shape;
        let (links, slots, numbers) = given.dims3()?;
        let rows = given.reshape((links * slots, numbers))?;
        let numbers = rows.narrow(1, features, 2)?.to_dtype(DType::F32)?;
        let all_kinds = Tensor::arange(0.0_f32, kinds as f32, given.device())?.unsqueeze(0)?;
        let kind = numbers.narrow(1, 1, 1)?.broadcast_eq(&all_kinds)?;
        let features = rows.narrow(1, 0, features)?.to_dtype(dtype)?;
        let direction = numbers.narrow(1, 0, 1)?.reshape((links, slots))?;
        // A number that is none may not lead out of the sums.
        let direction = direction.clamp(0.0, (shape.directions - 1) as f64)?;
        Ok(Self {
            given: given.clone(),
            rows: Tensor::cat(&[features, kind.to_dtype(dtype)?], 1)?,
            direction: Direction::ByLink(direction.to_dtype(DType::U32)?),
        })
    }

    /// Sums values (rows, 1) over the ways of each direction: (links, directions).
    pub fn sums(&self, values: &Tensor, shape: &PolarShape) -> Result<Tensor> {
        let (links, directions) = (self.given.dim(0)?, shape.directions);
        let nodes = |g: &mut Graph, v: &[Value]| sums_of_rows(g, v[0], v[1], shape);
        recorded(&[values, &self.given], nodes, || match &self.direction {
            Direction::OfAll(direction) => {
                let sums = Tensor::zeros((links * directions, 1), values.dtype(), values.device())?;
                let sums = sums.index_add(direction, &values.contiguous()?, 0)?;
                sums.reshape((links, directions))
            }
            Direction::ByLink(direction) => {
                ops::add_to_columns(&values.reshape(direction.shape())?, direction, directions)
            }
        })
    }
}

fn on_cpu(tensor: &Tensor) -> Result<Tensor> {
    let tensor = tensor.to_device(&Device::Cpu)?;
    tensor.to_dtype(DType::F32)?.contiguous()
}

/// Picks out what is no way of zeros: features and kind, and direction.
fn picked(ways: &[f32], slots: usize, shape: &PolarShape) -> Result<(Vec<f32>, Vec<u32>)> {
    let &PolarShape {
        kinds, features, ..
    } = shape;
    let of_link = |(link, ways): (usize, &[f32])| {
        let (mut rows, mut directions) = (Vec::new(), Vec::new());
        for (n, way) in ways.chunks_exact(shape.per_way()).enumerate() {
            let [direction, kind] = [way[features], way[features + 1]];
            let is_known = |number: f32, count: usize| {
                (0.0..count as f32).contains(&number) && number.fract() == 0.0
            };
            let is_known = is_known(direction, shape.directions) && is_known(kind, kinds);
            if !is_known {
                bail!("way {n} of link {link} is of no direction or kind of {shape:?}");
            }
            if way[1] == 0.0 {
                continue;
            }
            directions.push((link * shape.directions + direction as usize) as u32);
            rows.extend_from_slice(&way[..features]);
            rows.resize(rows.len() + kinds, 0.0);
            let first = rows.len() - kinds;
            rows[first + kind as usize] = 1.0;
        }
        Ok((rows, directions))
    };
    let links = ways.par_chunks_exact(slots * shape.per_way()).enumerate();
    let links = links.map(of_link).collect::<Result<Vec<_>>>()?;
    let (rows, directions): (Vec<_>, Vec<_>) = links.into_iter().unzip();
    let (mut rows, mut directions) = (rows.concat(), directions.concat());
    if directions.is_empty() {
        // Layers take no empty batch: a way of zeros, which has no strength, stands in.
        directions.push(0);
        rows.resize(features + kinds, 0.0);
    }
    Ok((rows, directions))
}

/// Makes the rows of [`Found`] in a graph: of every way, since those of zeros have no strength.
fn every_row(g: &mut Graph, input: Value, shape: &PolarShape) -> Value {
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

/// Makes the sums of [`Found::sums`] in a graph.
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

    use super::super::PolarReg;
    use super::*;

    const SHAPE: PolarShape = PolarShape {
        directions: 20,
        kinds: 3,
        features: 4,
    };

    const LINKS: usize = 3;
    const SLOTS: usize = 24;

    /// Links of 24, 7 and 15 ways, two of some directions and kinds.
    fn ways() -> Tensor {
        let of_link = |link: usize| {
            (0..SLOTS).flat_map(move |n| {
                let is_there = n < [24, 7, 15][link];
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

    /// Sums of a number that tells each feature and kind, by direction.
    fn sums(found: &Found) -> Vec<f32> {
        let weights = [1.0_f32, 10.0, 3.0, 7.0, 100.0, 200.0, 300.0];
        let weights = Tensor::new(&weights, &Device::Cpu).unwrap().unsqueeze(1);
        let rows = found.rows.to_dtype(DType::F32).unwrap();
        let there = rows.narrow(1, 1, 1).unwrap();
        let values = (rows.matmul(&weights.unwrap()).unwrap() * there).unwrap();
        let sums = found.sums(&values, &SHAPE).unwrap();
        sums.flatten_all().unwrap().to_vec1().unwrap()
    }

    #[test]
    fn ways_are_added_by_direction_on_the_host_and_on_a_device() {
        let mut expected = vec![0.0; LINKS * SHAPE.directions];
        let ways = ways();
        for (link, ways) in ways.to_vec3::<f32>().unwrap().iter().enumerate() {
            for way in ways.iter().filter(|way| way[1] == 1.0) {
                let sum = &mut expected[link * SHAPE.directions + way[4] as usize];
                *sum += way[0] + 10.0 + 3.0 * way[2] + 7.0 * way[3] + 100.0 * (way[5] + 1.0);
            }
        }
        for of_input in [DType::F32, DType::F16, DType::BF16] {
            let ways = ways.to_dtype(of_input).unwrap();
            for dtype in [DType::F32, DType::BF16] {
                let found = Found::of(&ways, &SHAPE, dtype, &Device::Cpu).unwrap();
                let on_device = Found::all(&ways, &SHAPE, dtype).unwrap();
                for found in [found, on_device] {
                    assert_eq!(found.rows.dtype(), dtype);
                    assert_eq!(sums(&found), expected);
                }
            }
        }
        let finer = PolarShape {
            directions: 720,
            ..SHAPE
        };
        let ways = ways.to_dtype(DType::BF16).unwrap();
        let refused = Found::of(&ways, &finer, DType::F32, &Device::Cpu);
        let refused = refused.err().unwrap().to_string();
        assert!(refused.contains("BF16 has no room"), "{refused}");
    }

    #[test]
    fn other_shapes_are_refused() {
        let ways = ways();
        for wrong in [
            ways.narrow(2, 0, 5),
            ways.narrow(0, 0, 0),
            ways.narrow(1, 0, 0),
        ] {
            let refused = Found::of(&wrong.unwrap(), &SHAPE, DType::F32, &Device::Cpu);
            let refused = refused.err().unwrap().to_string();
            assert!(refused.contains("[links, ways, 6]"), "{refused}");
        }
    }

    #[test]
    fn a_way_of_no_direction_is_refused() {
        for (place, number) in [(4, 20.0), (4, -1.0), (5, 3.0), (5, f32::NAN), (5, 0.5)] {
            let mut ways = vec![0.0_f32; 2 * SHAPE.per_way()];
            ways[SHAPE.per_way() + place] = number;
            let ways = Tensor::from_vec(ways, (1, 2, SHAPE.per_way()), &Device::Cpu).unwrap();
            let refused = Found::of(&ways, &SHAPE, DType::F32, &Device::Cpu);
            let refused = refused.err().unwrap().to_string();
            assert!(refused.starts_with("way 1 of link 0"), "{refused}");
            // On a device nothing is read back, but nothing is written beside the sums either.
            let found = Found::all(&ways, &SHAPE, DType::F32).unwrap();
            let values = Tensor::new(&[[0.0_f32], [1.0]], &Device::Cpu).unwrap();
            let sums = found.sums(&values, &SHAPE).unwrap();
            let sums: Vec<f32> = sums.flatten_all().unwrap().to_vec1().unwrap();
            let direction = if place == 4 && number > 0.0 { 19 } else { 0 };
            assert!(sums.len() == 20 && sums[direction] == 1.0, "{sums:?}");
        }
    }

    #[test]
    fn a_model_learns_the_same_on_a_device() {
        let parameters = VarMap::new();
        let vb = crate::seeded(&parameters, 5, DType::F32, &Device::Cpu);
        let model = PolarReg::new(SHAPE, vb).unwrap();
        let weights = Tensor::arange(0.0_f32, (LINKS * SHAPE.directions) as f32, &Device::Cpu);
        let weights = weights.unwrap().reshape((LINKS, SHAPE.directions)).unwrap();
        let learnt = |found: &Found| {
            let power = model.shares(found).unwrap();
            let loss = (&power * &weights).unwrap().sum_all().unwrap();
            let store = loss.backward().unwrap();
            let of = |var: &Var| store.get(var).map(|g| g.flatten_all().unwrap());
            let gradients = crate::trainable(&parameters).into_iter();
            let gradients: Vec<_> = gradients.map(|(_, var)| of(&var).unwrap()).collect();
            Tensor::cat(
                &[&[power.flatten_all().unwrap()], &gradients[..]].concat(),
                0,
            )
            .unwrap()
        };
        let ways = ways();
        let expected = learnt(&Found::of(&ways, &SHAPE, DType::F32, &Device::Cpu).unwrap());
        let found = learnt(&Found::all(&ways, &SHAPE, DType::F32).unwrap());
        let largest = |x: &Tensor| {
            x.abs()
                .unwrap()
                .max_all()
                .unwrap()
                .to_scalar::<f32>()
                .unwrap()
        };
        let apart = largest(&(found - &expected).unwrap());
        assert!(apart < 2e-6 * largest(&expected), "{apart}");
    }
}
