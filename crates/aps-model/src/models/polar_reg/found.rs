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
    /// Direction of each: its number plus the number of directions times that of the link.
    direction: Tensor,
}

impl Found {
    /// Takes lists on a device as they are, and picks the ways out of others on the host, in f32, to send them to the device: most
    /// values of an input are of ways that are not there.
    pub fn of(input: &Tensor, form: Form, shape: &PolarShape, device: &Device) -> Result<Self> {
        if form == Form::Listed && !input.device().is_cpu() {
            return Self::listed(&input.detach(), shape);
        }
        let &PolarShape { ways, features, .. } = shape;
        let host = input.detach().to_device(&Device::Cpu)?;
        let host = host.to_dtype(DType::F32)?.contiguous()?;
        let per_link = host.elem_count() / host.dim(0)?;
        let pick = |[all]: [&[f32]; 1]| picked(all, per_link, form, shape);
        let (mut rows, mut directions) = ops::with_slices([&host], pick)??;
        if directions.is_empty() {
            // Layers take no empty batch: a way of zeros, which has no strength, stands in.
            directions.push(0);
            rows.resize(features + ways, 0.0);
        }
        let count = directions.len();
        let rows = Tensor::from_vec(rows, (count, features + ways), device)?;
        Ok(Self {
            rows: recorded(
                &[input],
                |g, v| every_way(g, v[0], shape),
                || rows.to_dtype(input.dtype()),
            )?,
            direction: Tensor::from_vec(directions, count, device)?,
        })
    }

    /// Takes all ways of lists, those of zeros too: they have no strength.
    fn listed(lists: &Tensor, shape: &PolarShape) -> Result<Self> {
        let &PolarShape { ways, features, .. } = shape;
        let (links, slots, numbers) = lists.dims3()?;
        if lists.dtype().size_in_bytes() < 4 && shape.directions.max(ways) > 257 {
            bail!("bf16 has no room for the numbers of more than 257 directions or ways");
        }
        let rows = lists.reshape((links * slots, numbers))?;
        let numbers = rows.narrow(1, features, 2)?.to_dtype(DType::F32)?;
        let kinds = Tensor::arange(0.0_f32, ways as f32, lists.device())?.unsqueeze(0)?;
        let kinds = numbers.narrow(1, 1, 1)?.broadcast_eq(&kinds)?;
        let features = rows.narrow(1, 0, features)?;
        let first = (0..links as u32).map(|link| link * shape.directions as u32);
        let first = Tensor::from_vec(first.collect(), (links, 1), lists.device())?;
        let direction = numbers.narrow(1, 0, 1)?.reshape((links, slots))?;
        // A number that is none may not lead out of the sums.
        let direction = direction.clamp(0.0, (shape.directions - 1) as f64)?;
        let direction = direction.to_dtype(DType::U32)?.broadcast_add(&first)?;
        Ok(Self {
            rows: Tensor::cat(&[features, kinds.to_dtype(lists.dtype())?], 1)?,
            direction: direction.flatten_all()?,
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
        recorded(&[values], nodes, || {
            let sums = Tensor::zeros((links * directions, 1), values.dtype(), values.device())?;
            let sums = sums.index_add(&self.direction, &values.contiguous()?, 0)?;
            sums.reshape((links, directions))
        })
    }
}

/// Picks the ways that there are out of all values: features and kind of each, and its direction.
fn picked(
    values: &[f32],
    per_link: usize,
    form: Form,
    shape: &PolarShape,
) -> Result<(Vec<f32>, Vec<u32>)> {
    let &PolarShape { ways, features, .. } = shape;
    let is_known = |way: &[f32]| {
        let [direction, kind] = [way[features], way[features + 1]];
        (0.0..shape.directions as f32).contains(&direction) && (0.0..ways as f32).contains(&kind)
    };
    if form == Form::Listed
        && let Some(at) = values
            .chunks_exact(shape.listed())
            .position(|way| !is_known(way))
    {
        bail!("way {at} of the lists is of no direction or kind of {shape:?}");
    }
    let of_link = |(link, values): (usize, &[f32])| {
        let (mut rows, mut directions) = (Vec::new(), Vec::new());
        let mut push = |way: &[f32], direction: usize, kind: usize| {
            directions.push((link * shape.directions + direction) as u32);
            rows.extend_from_slice(&way[..features]);
            rows.extend((0..ways).map(|n| f32::from(u8::from(n == kind))));
        };
        let is_there = |way: &&[f32]| way[1] != 0.0;
        match form {
            Form::Every => {
                let all = values.chunks_exact(features).enumerate();
                let all = all.filter(|(_, way)| is_there(way));
                all.for_each(|(n, way)| push(way, n / ways, n % ways));
            }
            Form::Listed => {
                let all = values.chunks_exact(shape.listed()).filter(is_there);
                all.for_each(|way| push(way, way[features] as usize, way[features + 1] as usize));
            }
        }
        (rows, directions)
    };
    let links = values.par_chunks_exact(per_link).enumerate().map(of_link);
    let (rows, directions): (Vec<_>, Vec<_>) = links.unzip();
    Ok((rows.concat(), directions.concat()))
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
    fn a_way_of_no_direction_is_refused() {
        for (place, number) in [(4, 20.0), (4, -1.0), (5, 3.0), (5, f32::NAN)] {
            let mut list = vec![0.0_f32; 2 * SHAPE.listed()];
            list[SHAPE.listed() + place] = number;
            let list = Tensor::from_vec(list, (1, 2, SHAPE.listed()), &Device::Cpu).unwrap();
            let refused = Found::of(&list, Form::Listed, &SHAPE, &Device::Cpu);
            let refused = refused.err().unwrap().to_string();
            assert!(refused.starts_with("way 1 of the lists"), "{refused}");
            // On a device nothing is read back, but nothing is written beside the sums either.
            let found = Found::listed(&list, &SHAPE).unwrap();
            assert_eq!(
                found
                    .sums(&found.rows.narrow(1, 1, 1).unwrap(), 1, &SHAPE)
                    .unwrap()
                    .dims(),
                [1, 20]
            );
        }
    }
}
