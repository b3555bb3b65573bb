//! Time of a training step or of inference [ms], the best of some seconds: `step_time MODEL-WHAT-PIXELS-BATCH`, WHAT being
//! `train` or `infer`, like `step_time ms_areg-train-64-32`. Polar-Reg gets ways whatever the pixels: those of the
//! facade are 40.
//!
//! A training step holds all that a real one does: making the images, both networks of an adversarial model, clipping,
//! optimizers. Weights are the initial ones, links random.

use std::error::Error;
use std::time::{Duration, Instant};

use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::candle_nn::VarMap;
use aps_model::condition::{
    ConditionConfig, ConditionImages, InputKind, InputShape, Link, ModelInput, PolarShape, Rasters,
};
use aps_model::data::Samples;
use aps_model::train::{TrainConfig, Trainer};
use aps_model::{ANGLE_BINS, LabelFacts, ModelKind, Preset, frozen, seeded};

/// The runner's allocator: memory of a step is used again in the next one, rather than asked anew from the system page by page.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Ways of a fifth of the kinds along each ray.
#[derive(Debug)]
struct SomeWays(PolarShape);

impl ModelInput for SomeWays {
    fn batch(&self, links: &[Link]) -> aps_model::Result<Tensor> {
        let PolarShape { features, ways, .. } = self.0;
        let value = |i: usize| {
            let (at, way) = (i % self.0.values(), i / features % 5);
            match (way, at % features) {
                _ if at >= ways * features => 0.5,
                (0, 1) => 1.0,
                (0, _) => (i * 7919 % 1000) as f32 / 1000.0,
                _ => 0.0,
            }
        };
        let values = (0..links.len() * self.0.directions * self.0.values()).map(value);
        let shape = (links.len(), self.0.directions, self.0.values());
        Ok(Tensor::from_vec(
            values.collect::<Vec<f32>>(),
            shape,
            &Device::Cpu,
        )?)
    }

    fn device(&self) -> &Device {
        &Device::Cpu
    }

    fn shape(&self) -> InputShape {
        InputShape::Polar(self.0)
    }

    fn image_size(&self) -> usize {
        0
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let case = std::env::args()
        .nth(1)
        .unwrap_or("resnet_mlp-train-64-32".into());
    let parts: Vec<&str> = case.split('-').collect();
    let &[model, what, pixels, batch] = parts.as_slice() else {
        return Err("expected MODEL-WHAT-PIXELS-BATCH".into());
    };
    let kind: ModelKind = model.parse()?;
    let (image_size, batch): (usize, usize) = (pixels.parse()?, batch.parse()?);

    let device = Device::Cpu;
    let city: Vec<f32> = (0..256 * 256)
        .map(|i| f32::from(i / 256 / 30 % 2 == 0))
        .collect();
    let rasters = Rasters {
        pixels: &city,
        height: 256,
        width: 256,
        metres_per_pixel: 1.0,
    };
    let config = ConditionConfig {
        image_size,
        ..ConditionConfig::default()
    };
    let input: Box<dyn ModelInput> = match kind.input() {
        InputKind::Images => Box::new(ConditionImages::new(rasters, config, &device)?),
        InputKind::Polar => Box::new(SomeWays(PolarShape {
            directions: 180,
            ways: 15,
            features: 14,
            numbers: 4,
        })),
    };
    let link = |i: usize| Link {
        map: 0,
        tx_m: [(i * 37 % 256) as f64, (i * 11 % 256) as f64],
        rx_m: [(i * 53 % 256) as f64, (i * 29 % 256) as f64],
    };
    let links: Vec<Link> = (0..4 * batch).map(link).collect();

    let builder = |parameters, seed| seeded(parameters, seed, DType::F32, &device);
    let (parameters, of_regularizer) = (VarMap::new(), VarMap::new());
    let shape = input.shape();
    let model = kind.build(Preset::Paper, shape, builder(&parameters, 1))?;
    if let InputShape::Polar(PolarShape { directions, .. }) = shape {
        let near = |i: usize| f64::from(u8::from(i / directions == i % directions));
        let array = (0..ANGLE_BINS * directions).map(near).collect();
        let (mean, deviation, is_by_link) = (0.1, 0.3, false);
        let facts = LabelFacts {
            array,
            mean,
            deviation,
            is_by_link,
        };
        facts.set(&parameters)?;
    }
    let best = match what {
        "train" => {
            let target = |i: usize| ((i * 7919 % 1000) as f32 - 500.0) / 290.0;
            let targets = (0..links.len() * ANGLE_BINS).map(target).collect();
            let config = TrainConfig {
                epochs: 1_000_000,
                batch,
                ..kind.train_config(Preset::Paper)
            };
            let samples = Samples::new(links, targets)?;
            let trainer = Trainer::new(model, &parameters, input, samples, config)?;
            let mut trainer = trainer.with_loss(kind.loss());
            let vb = builder(&of_regularizer, 2);
            if let Some(regularizer) = kind.build_regularizer(Preset::Paper, vb)? {
                trainer = trainer.with_regularizer(regularizer, &of_regularizer)?;
            }
            best_of(|| trainer.step().map(|_| ()))?
        }
        "infer" => {
            let images = input.batch(&links[..batch])?;
            let model = kind.build(Preset::Paper, shape, frozen(&parameters)?)?;
            best_of(|| model.forward_t(&images, false).map(|_| ()))?
        }
        other => return Err(format!("'{other}' is neither train nor infer").into()),
    };
    println!("{}", best.as_secs_f64() * 1e3);
    Ok(())
}

fn best_of<E>(mut run: impl FnMut() -> Result<(), E>) -> Result<Duration, E> {
    run()?;
    run()?;
    let (started, mut best) = (Instant::now(), Duration::MAX);
    while started.elapsed() < Duration::from_secs(3) {
        let one = Instant::now();
        run()?;
        best = best.min(one.elapsed());
    }
    Ok(best)
}
