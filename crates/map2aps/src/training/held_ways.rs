//! Ways of all links of a training on the device.

use std::collections::HashMap;

use aps_model::Result;
use aps_model::candle_core::{DType, Device, Result as DeviceResult, Tensor};
use aps_raytrace::polar::{FEATURES, Mirror, PER_WAY};
use half::f16;

use crate::Error;
use crate::polar::{PolarViews, SeenLink};

/// Most bytes that ways take on a device. The 2.3 million links of the paper's size have some 330 ways each: 24 GB.
const MAX_BYTES: usize = 32 << 30;

/// Memory of a device that is left for the network and its gradients.
const RESERVE_BYTES: usize = 4 << 30;

/// Ways of a tensor at most: candle's selection on CUDA counts its elements in 32 bits.
const MAX_WAYS: usize = 1 << 27;

/// Links whose ways are found at a time.
const AT_ONCE: usize = 1 << 12;

/// A link as it is in the map: its map, and its coordinates in steps of 2^-30 m, for a link mirrored twice may be off by a rounding.
/// Links within a step of each other are taken for the same.
type Key = (usize, [i64; 4]);

/// The key of a link; `None` if an end is not finite.
fn key(link: &SeenLink) -> Option<Key> {
    let [[tx_x, tx_y], [rx_x, rx_y]] = [link.tx_m, link.rx_m];
    let ends = [tx_x, tx_y, rx_x, rx_y];
    let steps = |x_m: f64| (x_m * f64::from(1 << 30)).round() as i64;
    let is_finite = ends.iter().all(|x_m| x_m.is_finite());
    is_finite.then(|| (link.map, ends.map(steps)))
}

/// Ways of links in half precision, 32 bytes each, so that for a batch only their places are sent. Mirror images are made of them
/// on the device.
///
/// Rounding is at most 2^-11 of a feature; numbers of directions and kinds are exact.
#[derive(Debug)]
pub(super) struct HeldWays {
    /// Each (ways, [`PER_WAY`]); the first way is none, all zeros.
    blocks: Vec<Tensor>,
    places: HashMap<Key, Ways>,
    /// Factor of each number of a way in each mirror image: (images, [`PER_WAY`]).
    factors: Tensor,
    /// Direction in each mirror image of a direction of the map: (images * directions).
    directions: Tensor,
}

/// Place of a link's ways.
#[derive(Debug, Clone, Copy, Default)]
struct Ways {
    block: u32,
    first: u32,
    count: u32,
}

impl HeldWays {
    /// Finds the ways of links, each once whatever its mirror image, and puts them onto a device; `None` if it has no room for
    /// them and 4 GiB besides, or they would take more than 32 GiB.
    pub fn new(
        views: &PolarViews,
        links: impl Iterator<Item = Result<SeenLink>>,
        device: &Device,
    ) -> Result<Option<Self>> {
        Self::in_blocks(views, links, device, MAX_WAYS)
    }

    /// Does what [`HeldWays::new`] does, with at most `max_ways` ways in a block, or those of one link.
    pub(super) fn in_blocks(
        views: &PolarViews,
        links: impl Iterator<Item = Result<SeenLink>>,
        device: &Device,
        max_ways: usize,
    ) -> Result<Option<Self>> {
        let mut places: HashMap<Key, Ways> = HashMap::new();
        let mut blocks = Blocks::new(device, max_ways);
        let mut links = links.peekable();
        while links.peek().is_some() {
            let mut some = Vec::with_capacity(AT_ONCE);
            for link in links.by_ref().take(AT_ONCE) {
                let link = link?;
                let key = key(&link);
                // An end that is not finite is refused below.
                if key.is_none_or(|key| !places.contains_key(&key)) {
                    places.extend(key.map(|key| (key, Ways::default())));
                    let mirror = Mirror::default();
                    some.push(SeenLink { mirror, ..link });
                }
            }
            let lists = views.ways(&some).map_err(|error| match error {
                // Its number among some links says nothing.
                Error::At { source, .. } => aps_model::Error::Input(source),
                error => aps_model::Error::Input(error.into()),
            })?;
            for (link, list) in some.iter().zip(lists) {
                // A device without room refuses.
                let Ok(place) = blocks.push(&list) else {
                    return Ok(None);
                };
                places.extend(key(link).map(|key| (key, place)));
            }
            if blocks.bytes() > MAX_BYTES {
                return Ok(None);
            }
        }
        let blocks = blocks.finish();
        // What training takes besides must have room.
        let has_room =
            || device.is_cpu() || Tensor::zeros(RESERVE_BYTES, DType::U8, device).is_ok();
        let (true, Ok(blocks)) = (has_room(), blocks) else {
            return Ok(None);
        };
        let factors = Mirror::ALL.map(|mirror| {
            let mut factors = [1.0; PER_WAY];
            factors[2] = mirror.turn() as f32;
            factors
        });
        let directions = PolarViews::fan().directions;
        let of_image =
            |mirror: Mirror| (0..directions).map(move |d| mirror.direction(d, directions));
        let directions = Mirror::ALL.into_iter().flat_map(of_image);
        Ok(Some(Self {
            blocks,
            places,
            factors: Tensor::new(&factors, device)?,
            directions: Tensor::from_iter(directions.map(|d| d as f32), device)?,
        }))
    }

    /// Number of links, mirror images not counted.
    #[cfg(test)]
    pub fn links(&self) -> usize {
        self.places.len()
    }

    /// Tells if all of some links are held.
    pub fn has(&self, links: &[SeenLink]) -> bool {
        links.iter().all(|link| self.place(link).is_some())
    }

    fn place(&self, link: &SeenLink) -> Option<Ways> {
        self.places.get(&key(link)?).copied()
    }

    /// Lists of the ways of links in f32; `None` unless all are held.
    pub fn batch(&self, links: &[SeenLink]) -> Option<DeviceResult<Tensor>> {
        let places = links.iter().map(|link| self.place(link));
        let places = places.collect::<Option<Vec<_>>>()?;
        let of_image = |link: &SeenLink| Mirror::ALL.iter().position(|&m| m == link.mirror);
        let images = links.iter().map(of_image).collect::<Option<Vec<_>>>()?;
        Some(self.lists(&places, &images))
    }

    fn lists(&self, places: &[Ways], images: &[usize]) -> DeviceResult<Tensor> {
        let (links, device) = (places.len(), self.factors.device());
        let slots = places.iter().map(|ways| ways.count).max();
        let slots = slots.unwrap_or(0).max(1);
        let images = images.iter().map(|&image| image as u32).collect::<Vec<_>>();
        let images = Tensor::from_vec(images, links, device)?;

        let slot = Tensor::arange(0, slots, device)?.unsqueeze(0)?;
        let mut ways = Tensor::zeros((links * slots as usize, PER_WAY), DType::F32, device)?;
        for (block, all) in (0..).zip(&self.blocks) {
            if places.iter().all(|ways| ways.block != block) {
                continue;
            }
            let column = |of: fn(&Ways) -> u32| {
                let values = places.iter();
                let values = values.map(|ways| if ways.block == block { of(ways) } else { 0 });
                Tensor::from_vec(values.collect(), (links, 1), device)
            };
            let is_there = slot.broadcast_lt(&column(|ways| ways.count)?)?;
            let at = slot.broadcast_add(&column(|ways| ways.first)?)?;
            let at = is_there.where_cond(&at, &at.zeros_like()?)?;
            let found = all.index_select(&at.flatten_all()?, 0)?;
            ways = (ways + found.to_dtype(DType::F32)?)?;
        }
        let ways = ways.reshape((links, slots as usize, PER_WAY))?;
        let factors = self.factors.index_select(&images, 0)?.unsqueeze(1)?;
        let ways = ways.broadcast_mul(&factors)?;

        let directions = self.directions.elem_count() / Mirror::ALL.len();
        let row = (images.to_dtype(DType::F32)? * directions as f64)?;
        let direction = ways.narrow(2, FEATURES, 1)?;
        let direction = direction.broadcast_add(&row.reshape((links, 1, 1))?)?;
        let direction = direction.to_dtype(DType::U32)?.flatten_all()?;
        let direction = self.directions.index_select(&direction, 0)?;
        let direction = direction.reshape((links, slots as usize, 1))?;
        let (features, kind) = (
            ways.narrow(2, 0, FEATURES)?,
            ways.narrow(2, FEATURES + 1, 1)?,
        );
        Tensor::cat(&[features, direction, kind], 2)
    }
}

/// Tensors that are filled one after another.
struct Blocks<'a> {
    device: &'a Device,
    max_ways: usize,
    full: Vec<Tensor>,
    /// Parts of the block that is being filled, and its ways that are not among them yet.
    parts: Vec<Tensor>,
    values: Vec<f16>,
    /// Ways of that block, and of all.
    ways: usize,
    all: usize,
}

impl<'a> Blocks<'a> {
    fn new(device: &'a Device, max_ways: usize) -> Self {
        Self {
            device,
            max_ways,
            full: Vec::new(),
            parts: Vec::new(),
            values: vec![f16::ZERO; PER_WAY],
            ways: 1,
            all: 1,
        }
    }

    /// Adds the ways of a link, all to one block.
    fn push(&mut self, list: &[f32]) -> DeviceResult<Ways> {
        let count = list.len() / PER_WAY;
        if self.ways > 1 && self.ways + count > self.max_ways {
            self.close()?;
        }
        let first = self.ways;
        self.values.extend(list.iter().copied().map(f16::from_f32));
        self.ways += count;
        self.all += count;
        if self.values.len() > PER_WAY << 20 {
            self.send()?;
        }
        let [block, first, count] = [self.full.len(), first, count].map(|n| n as u32);
        Ok(Ways {
            block,
            first,
            count,
        })
    }

    fn bytes(&self) -> usize {
        self.all * PER_WAY * size_of::<f16>()
    }

    fn send(&mut self) -> DeviceResult<()> {
        let values = std::mem::take(&mut self.values);
        if values.is_empty() {
            return Ok(());
        }
        let shape = (values.len() / PER_WAY, PER_WAY);
        self.parts
            .push(Tensor::from_vec(values, shape, self.device)?);
        Ok(())
    }

    fn close(&mut self) -> DeviceResult<()> {
        self.send()?;
        self.full
            .push(Tensor::cat(&std::mem::take(&mut self.parts), 0)?);
        (self.values, self.ways) = (vec![f16::ZERO; PER_WAY], 1);
        Ok(())
    }

    fn finish(mut self) -> DeviceResult<Vec<Tensor>> {
        self.close()?;
        Ok(self.full)
    }
}
