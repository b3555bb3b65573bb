//! The ways of an input that there are.

use candle_core::{DType, Device, Result, Tensor, bail};
use rayon::prelude::*;

use crate::condition::PolarShape;
use crate::ops;
use crate::recording::{Graph, Value, int, recorded};

/// Form in which ways are given: see [`PolarShape`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Every,
    Listed,
}

impl Form {
    /// Tells the number of links of an input, and its form.
    pub fn of(input: &Tensor, shape: &PolarShape) -> Result<(usize, Self)> {
        let (every, listed) = ([shape.directions, shape.values()], shape.listed());
        match *input.dims() {
            [links, directions, values] if links > 0 && [directions, values] == every => {
                Ok((links, Self::Every))
            }
            [links, ways, numbers] if links * ways > 0 && numbers == listed => {
                Ok((links, Self::Listed))
            }
            ref found => bail!(
                "ways along rays must have the shape [links, {}, {}] or [links, ways, {listed}], one link at least, not {found:?}",
                every[0],
                every[1]
            ),
        }
    }
}

/// The ways that there are, out of all links, directions and kinds. They are data: no gradient is followed through them.
pub(super) struct Found {
    /// (ways, features and kind as a unit vector)
    pub rows: Tensor,
    direction: Direction,
}

/// Direction of each way.
enum Direction {
    /// Its number plus the number of directions times that of the link: (ways).
    OfAll(Tensor),
    /// Its number, as many ways a link: (links, ways of a link). Sums of links are then independent of each other.
    ByLink(Tensor),
}

impl Found {
    /// Finds the ways of an input on the CPU, in f32, as they are made; for a model on another device takes lists as they are.
    pub fn of(input: &Tensor, form: Form, shape: &PolarShape, device: &Device) -> Result<Self> {
        let given = input.detach();
        let lists = match form {
            Form::Every => lists_of(&on_cpu(&given)?, shape)?,
            Form::Listed => given,
        };
        if !device.is_cpu() {
            let lists = lists.to_device(device)?.to_dtype(input.dtype())?;
            return Self::listed(&lists, shape);
        }
        let (rows, directions) = ops::with_slices([&on_cpu(&lists)?], |[all]| {
            picked(all, lists.dims3()?.1, shape)
        })??;
        let count = directions.len();
        let rows = Tensor::from_vec(rows, (count, shape.features + shape.ways), device)?;
        let nodes = |g: &mut Graph, v: &[Value]| every_way(g, v[0], shape);
        Ok(Self {
            rows: recorded(&[input], nodes, || rows.to_dtype(input.dtype()))?,
            direction: Direction::OfAll(Tensor::from_vec(directions, count, device)?),
        })
    }

    /// Takes all ways of lists, those of zeros too: they have no strength.
    fn listed(lists: &Tensor, shape: &PolarShape) -> Result<Self> {
        let &PolarShape { ways, features, .. } = shape;
        let (links, slots, numbers) = lists.dims3()?;
        let exact = match lists.dtype() {
            DType::BF16 => 1 << 8,
            DType::F16 => 1 << 11,
            _ => 1 << 24,
        };
        if shape.directions.max(ways) > exact {
            let dtype = lists.dtype();
            bail!("{dtype:?} has no room for the numbers of more than {exact} directions or ways");
        }
        let rows = lists.reshape((links * slots, numbers))?;
        let numbers = rows.narrow(1, features, 2)?.to_dtype(DType::F32)?;
        let kinds = Tensor::arange(0.0_f32, ways as f32, lists.device())?.unsqueeze(0)?;
        let kinds = numbers.narrow(1, 1, 1)?.broadcast_eq(&kinds)?;
        let features = rows.narrow(1, 0, features)?;
        let direction = numbers.narrow(1, 0, 1)?.reshape((links, slots))?;
        // A number that is none may not lead out of the sums.
        let direction = direction.clamp(0.0, (shape.directions - 1) as f64)?;
        Ok(Self {
            rows: Tensor::cat(&[features, kinds.to_dtype(lists.dtype())?], 1)?,
            direction: Direction::ByLink(direction.to_dtype(DType::U32)?),
        })
    }

    /// Sums values (ways, 1) over the ways of each direction: (links, directions).
    pub fn sums(&self, values: &Tensor, links: usize, shape: &PolarShape) -> Result<Tensor> {
        let &PolarShape {
            directions, ways, ..
        } = shape;
        let nodes = |g: &mut Graph, v: &[Value]| {
            let values = g.regroup(v[0], &[directions, ways]);
            let last = g.whole(&[-1]);
            g.node("ReduceSum", &[values, last], [int("keepdims", 0)])
        };
        recorded(&[values], nodes, || match &self.direction {
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

/// Lists the ways that there are of all values, on the CPU in f32.
fn lists_of(every: &Tensor, shape: &PolarShape) -> Result<Tensor> {
    let &PolarShape { ways, features, .. } = shape;
    let per_link = shape.directions * shape.values();
    let of_link = |values: &[f32]| {
        let mut list = Vec::new();
        for (n, way) in values.chunks_exact(features).enumerate() {
            if way[1] != 0.0 {
                list.extend_from_slice(way);
                list.extend([n / ways, n % ways].map(|number| number as f32));
            }
        }
        list
    };
    let lists: Vec<Vec<f32>> = ops::with_slices([every], |[all]| {
        all.par_chunks_exact(per_link).map(of_link).collect()
    })?;
    shape.lists(&lists)
}

/// Picks the ways out of lists of some ways each: features and kind, and direction.
fn picked(lists: &[f32], slots: usize, shape: &PolarShape) -> Result<(Vec<f32>, Vec<u32>)> {
    let &PolarShape { ways, features, .. } = shape;
    let of_link = |(link, list): (usize, &[f32])| {
        let (mut rows, mut directions) = (Vec::new(), Vec::new());
        for (n, way) in list.chunks_exact(shape.listed()).enumerate() {
            let [direction, kind] = [way[features], way[features + 1]];
            let is_known = (0.0..shape.directions as f32).contains(&direction)
                && (0.0..ways as f32).contains(&kind);
            if !is_known {
                bail!("way {n} of the list of link {link} is of no direction or kind of {shape:?}");
            }
            if way[1] == 0.0 {
                continue;
            }
            directions.push((link * shape.directions + direction as usize) as u32);
            rows.extend_from_slice(&way[..features]);
            rows.resize(rows.len() + ways, 0.0);
            let first = rows.len() - ways;
            rows[first + kind as usize] = 1.0;
        }
        Ok((rows, directions))
    };
    let links = lists.par_chunks_exact(slots * shape.listed()).enumerate();
    let links = links.map(of_link).collect::<Result<Vec<_>>>()?;
    let (rows, directions): (Vec<_>, Vec<_>) = links.into_iter().unzip();
    let (mut rows, mut directions) = (rows.concat(), directions.concat());
    if directions.is_empty() {
        // Layers take no empty batch: a way of zeros, which has no strength, stands in.
        directions.push(0);
        rows.resize(features + ways, 0.0);
    }
    Ok((rows, directions))
}

/// Makes the rows of [`Found`] in a graph: of every way, there or not, since those that are not have no strength.
fn every_way(g: &mut Graph, input: Value, shape: &PolarShape) -> Value {
    let &PolarShape { ways, features, .. } = shape;
    let all = g.regroup(input, &[ways, features]);
    let unit = |n: usize| f64::from(u8::from(n / ways == n % ways));
    let kinds = (0..ways * ways).map(unit).collect::<Vec<_>>();
    let kinds = g.numbers(&[1, ways, ways], &kinds);
    let kinds = g.repeat(kinds, &[ways, ways], all);
    let all = g.node("Concat", &[all, kinds], [int("axis", 2)]);
    g.regroup(all, &[features + ways])
}

#[cfg(test)]
mod tests {
    use candle_core::Var;
    use candle_nn::VarMap;

    use super::super::PolarReg;
    use super::*;

    const SHAPE: PolarShape = PolarShape {
        directions: 20,
        ways: 3,
        features: 4,
    };

    const LINKS: usize = 3;

    /// Ways of which there are some, those of the last link far apart, as all values and as lists.
    fn forms() -> [Tensor; 2] {
        let count = LINKS * SHAPE.directions * SHAPE.ways;
        let is_there = |n: usize| n * 7919 % 11 < [5, 1, 3][n / (SHAPE.directions * SHAPE.ways)];
        let feature = |n: usize, f: usize| {
            if f == 1 {
                1.0
            } else {
                ((n * 31 + f * 17) % 64) as f32 / 64.0
            }
        };
        let mut every = Vec::new();
        let mut lists = vec![Vec::new(); LINKS];
        for n in 0..count {
            let of_way: Vec<f32> = (0..SHAPE.features).map(|f| feature(n, f)).collect();
            let factor = f32::from(u8::from(is_there(n)));
            every.extend(of_way.iter().map(|value| factor * value));
            if is_there(n) {
                let list = &mut lists[n / (SHAPE.directions * SHAPE.ways)];
                list.extend(of_way);
                list.extend([n / SHAPE.ways % SHAPE.directions, n % SHAPE.ways].map(|n| n as f32));
            }
        }
        let longest = lists.iter().map(Vec::len).max().unwrap();
        lists.iter_mut().for_each(|list| list.resize(longest, 0.0));
        let every_shape = (LINKS, SHAPE.directions, SHAPE.values());
        let list_shape = (LINKS, longest / SHAPE.listed(), SHAPE.listed());
        [
            Tensor::from_vec(every, every_shape, &Device::Cpu).unwrap(),
            Tensor::from_vec(lists.concat(), list_shape, &Device::Cpu).unwrap(),
        ]
    }

    /// Sums of a number that tells each feature and kind, by direction.
    fn sums(found: &Found) -> Vec<f32> {
        let weights = [1.0_f32, 10.0, 3.0, 7.0, 100.0, 200.0, 300.0];
        let weights = Tensor::new(&weights, &Device::Cpu).unwrap().unsqueeze(1);
        let rows = found.rows.to_dtype(DType::F32).unwrap();
        let there = rows.narrow(1, 1, 1).unwrap();
        let values = (rows.matmul(&weights.unwrap()).unwrap() * there).unwrap();
        let sums = found.sums(&values, LINKS, &SHAPE).unwrap();
        sums.flatten_all().unwrap().to_vec1().unwrap()
    }

    #[test]
    fn lists_on_the_host_and_on_a_device_have_the_ways_of_all_values() {
        let [every, lists] = forms();
        let of = |input: &Tensor, form| Found::of(input, form, &SHAPE, &Device::Cpu).unwrap();
        let expected = sums(&of(&every, Form::Every));
        assert!(expected.iter().filter(|&&sum| sum > 0.0).count() > 20);
        for dtype in [DType::F32, DType::F16, DType::BF16] {
            let lists = lists.to_dtype(dtype).unwrap();
            assert_eq!(sums(&of(&lists, Form::Listed)), expected);
            let on_device = Found::listed(&lists, &SHAPE).unwrap();
            assert_eq!(on_device.rows.dtype(), dtype);
            assert_eq!(sums(&on_device), expected);
        }
    }

    #[test]
    fn the_form_of_an_input_is_told_by_its_shape() {
        let [every, lists] = forms();
        let of = |input: &Tensor| Form::of(input, &SHAPE);
        assert_eq!(of(&every).unwrap(), (LINKS, Form::Every));
        assert_eq!(of(&lists).unwrap(), (LINKS, Form::Listed));
        for wrong in [
            every.narrow(1, 0, 5),
            every.narrow(0, 0, 0),
            lists.narrow(1, 0, 0),
        ] {
            let refused = of(&wrong.unwrap()).unwrap_err().to_string();
            assert!(
                refused.contains("[links, 20, 12] or [links, ways, 6]"),
                "{refused}"
            );
        }
    }

    #[test]
    fn lists_of_parts_of_ways_are_refused() {
        let whole = vec![0.5; SHAPE.listed()];
        let lists = SHAPE.lists(&[whole.clone(), Vec::new(), [&whole[..], &whole[..]].concat()]);
        assert_eq!(lists.unwrap().dims(), [3, 2, SHAPE.listed()]);
        let refused = SHAPE.lists(&[whole, vec![0.5; 3]]).unwrap_err().to_string();
        assert!(
            refused.starts_with("the list of link 1 has 3 numbers"),
            "{refused}"
        );
    }

    #[test]
    fn a_way_of_no_direction_is_refused() {
        for (place, number) in [(4, 20.0), (4, -1.0), (5, 3.0), (5, f32::NAN)] {
            let mut list = vec![0.0_f32; 2 * SHAPE.listed()];
            list[SHAPE.listed() + place] = number;
            let list = Tensor::from_vec(list, (1, 2, SHAPE.listed()), &Device::Cpu).unwrap();
            let refused = Found::of(&list, Form::Listed, &SHAPE, &Device::Cpu);
            let refused = refused.err().unwrap().to_string();
            assert!(
                refused.starts_with("way 1 of the list of link 0"),
                "{refused}"
            );
            // On a device nothing is read back, but nothing is written beside the sums either.
            let found = Found::listed(&list, &SHAPE).unwrap();
            let values = Tensor::new(&[[0.0_f32], [1.0]], &Device::Cpu).unwrap();
            let sums = found.sums(&values, 1, &SHAPE).unwrap();
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
        let [every, lists] = forms();
        let weights = Tensor::arange(0.0_f32, (LINKS * SHAPE.directions) as f32, &Device::Cpu);
        let weights = weights.unwrap().reshape((LINKS, SHAPE.directions)).unwrap();
        let learnt = |found: &Found| {
            let power = model.shares(found, LINKS).unwrap();
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
        let picked = Found::of(&every, Form::Every, &SHAPE, &Device::Cpu).unwrap();
        let expected = learnt(&picked);
        let found = learnt(&Found::listed(&lists, &SHAPE).unwrap());
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
