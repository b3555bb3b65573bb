//! Time of a training step or of inference [ms], the best of some seconds: `step_time MODEL-WHAT-PIXELS-BATCH`, WHAT being
//! `train` or `infer`, like `step_time ms_areg-train-64-32`.
//!
//! A training step holds all that a real one does: making the images, both networks of an adversarial model, clipping,
//! optimizers. Weights are the initial ones, links random.

use std::error::Error;
use std::time::{Duration, Instant};

use aps_model::candle_core::{DType, Device};
use aps_model::candle_nn::VarMap;
use aps_model::condition::{ConditionConfig, Link, Rasters};
use aps_model::data::Samples;
use aps_model::train::{TrainConfig, Trainer};
use aps_model::{ANGLE_BINS, ModelKind, Preset, frozen, seeded};

/// The runner's allocator: memory of a step is used again in the next one, rather than asked anew from the system page by page.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

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
    let input = kind.input(rasters, config, &device)?;
    let link = |i: usize| Link {
        map: 0,
        tx_m: [(i * 37 % 256) as f64, (i * 11 % 256) as f64],
        rx_m: [(i * 53 % 256) as f64, (i * 29 % 256) as f64],
    };
    let links: Vec<Link> = (0..4 * batch).map(link).collect();

    let builder = |parameters, seed| seeded(parameters, seed, DType::F32, &device);
    let (parameters, of_regularizer) = (VarMap::new(), VarMap::new());
    let model = kind.build(Preset::Paper, builder(&parameters, 1))?;
    let best = match what {
        "train" => {
            let target = |i: usize| ((i * 7919 % 1000) as f32 - 500.0) / 290.0;
            let targets = (0..links.len() * ANGLE_BINS).map(target).collect();
            let config = TrainConfig {
                epochs: 1_000_000,
                batch,
                ..match kind.is_adversarial() {
                    true => TrainConfig::adversarial(),
                    false => TrainConfig::regression(),
                }
            };
            let samples = Samples::new(links, targets)?;
            let mut trainer = Trainer::new(model, &parameters, input, samples, config)?;
            let vb = builder(&of_regularizer, 2);
            if let Some(regularizer) = kind.build_regularizer(Preset::Paper, vb)? {
                trainer = trainer.with_regularizer(regularizer, &of_regularizer)?;
            }
            best_of(|| trainer.step().map(|_| ()))?
        }
        "infer" => {
            let images = input.batch(&links[..batch])?;
            let model = kind.build(Preset::Paper, frozen(&parameters)?)?;
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
