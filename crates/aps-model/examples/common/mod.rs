//! Links, targets and input that follow from numbers, for the examples that time and compare models.

use std::error::Error;

use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::candle_nn::{VarBuilder, VarMap};
use aps_model::condition::{
    ConditionConfig, ConditionImages, InputKind, InputShape, Link, ModelInput, PolarShape, Rasters,
};
use aps_model::data::Samples;
use aps_model::train::{Precision, TrainConfig, Trainer};
use aps_model::{ANGLE_BINS, LabelFacts, ModelKind, Preset, seeded};

/// Result of an example.
pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// A model under test, with the device that it is on.
pub struct Case {
    pub kind: ModelKind,
    pub preset: Preset,
    pub image_size: usize,
    pub device: Device,
    pub precision: Precision,
}

/// Ways in such numbers as links of the paper's maps have.
#[derive(Debug)]
struct SomeWays(PolarShape, Device);

/// Ways of a link.
const WAYS: usize = 330;

impl ModelInput for SomeWays {
    fn batch(&self, links: &[Link]) -> aps_model::Result<Tensor> {
        let PolarShape {
            directions,
            kinds,
            features,
        } = self.0;
        let way = |n: usize| {
            let feature = move |f: usize| match f {
                1 => 1.0,
                _ => ((n * features + f) * 7919 % 1000) as f32 / 1000.0,
            };
            let numbers = [n * 37 % directions, n % kinds].map(|number| number as f32);
            (0..features).map(feature).chain(numbers)
        };
        let values = (0..links.len() * WAYS).flat_map(way).collect::<Vec<f32>>();
        let shape = (links.len(), WAYS, self.0.per_way());
        Ok(Tensor::from_vec(values, shape, &self.1)?)
    }

    fn device(&self) -> &Device {
        &self.1
    }

    fn shape(&self) -> InputShape {
        InputShape::Polar(self.0)
    }
}

/// Opens a device by name.
pub fn device(name: &str) -> Outcome<Device> {
    Ok(match name {
        "cpu" => Device::Cpu,
        "cuda" => Device::new_cuda(0)?,
        "metal" => Device::new_metal(0)?,
        other => return Err(format!("'{other}' is none of cpu, cuda, metal").into()),
    })
}

/// Links of one map.
pub fn links(count: usize) -> Vec<Link> {
    let link = |i: usize| Link {
        map: 0,
        tx_m: [(i * 37 % 256) as f64, (i * 11 % 256) as f64],
        rx_m: [(i * 53 % 256) as f64, (i * 29 % 256) as f64],
    };
    (0..count).map(link).collect()
}

impl Case {
    /// Makes the input of links.
    pub fn input(&self) -> Outcome<Box<dyn ModelInput>> {
        let is_built = |i: usize| f32::from((i / 256 / 30).is_multiple_of(2));
        let city: Vec<f32> = (0..256 * 256).map(is_built).collect();
        let rasters = Rasters {
            pixels: &city,
            height: 256,
            width: 256,
            metres_per_pixel: 1.0,
        };
        let config = ConditionConfig {
            image_size: self.image_size,
            ..ConditionConfig::default()
        };
        let ways = PolarShape {
            directions: 720,
            kinds: 15,
            features: 14,
        };
        Ok(match self.kind.input() {
            InputKind::Images => Box::new(ConditionImages::new(rasters, config, &self.device)?),
            InputKind::Polar => Box::new(SomeWays(ways, self.device.clone())),
        })
    }

    fn builder(&self, parameters: &VarMap, seed: u64) -> VarBuilder<'static> {
        seeded(parameters, seed, DType::F32, &self.device)
    }

    /// Draws the weights, the same on every device.
    pub fn parameters(&self, shape: InputShape) -> Outcome<VarMap> {
        let parameters = VarMap::new();
        let vb = self.builder(&parameters, 1);
        self.kind.build(self.preset, shape, vb)?;
        if let InputShape::Polar(PolarShape { directions, .. }) = shape {
            let near = |i: usize| f64::from(i / directions == i % directions);
            let facts = LabelFacts {
                array: (0..ANGLE_BINS * directions).map(near).collect(),
                mean: 0.1,
                deviation: 0.3,
                is_by_link: false,
            };
            facts.set(&parameters)?;
        }
        Ok(parameters)
    }

    /// A training with the paper's settings, without end.
    pub fn trainer(&self, batch: usize) -> Outcome<Trainer> {
        let links = links(4 * batch);
        let target = |i: usize| ((i * 7919 % 1000) as f32 - 500.0) / 290.0;
        let targets = (0..links.len() * ANGLE_BINS).map(target).collect();
        let config = TrainConfig {
            epochs: 1_000_000,
            batch,
            precision: self.precision,
            ..self.kind.train_config(self.preset)
        };
        let input = self.input()?;
        let parameters = self.parameters(input.shape())?;
        let vb = self.builder(&parameters, 1);
        let model = self.kind.build(self.preset, input.shape(), vb)?;
        let samples = Box::new(Samples::new(links, targets)?);
        let trainer = Trainer::new(model, &parameters, self.kind.loss(), input, samples, config)?;
        // As a training does.
        let trainer = match self.device.is_cpu() {
            true => trainer,
            false => trainer.hold()?,
        };
        let of_regularizer = VarMap::new();
        let vb = self.builder(&of_regularizer, 2);
        Ok(match self.kind.build_regularizer(self.preset, vb)? {
            Some(regularizer) => trainer.with_regularizer(regularizer, &of_regularizer)?,
            None => trainer,
        })
    }

    /// Input of the first links in the type that the network computes in.
    pub fn conditions(&self, count: usize) -> Outcome<Tensor> {
        let input = self.input()?;
        let shape = input.shape();
        Ok(self
            .precision
            .of_input(&input.batch(&links(count))?, shape)?)
    }
}
