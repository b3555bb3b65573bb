//! Time of a training step or of inference [ms], the best of some seconds: `step_time MODEL-WHAT-PIXELS-BATCH [DEVICE [PRECISION
//! [SECONDS]]]`, WHAT being `train` or `infer`, like `step_time ms_areg-train-64-32 cuda mixed 1`. Polar-Reg gets ways whatever the
//! pixels: those of the facade are 40.
//!
//! A training step holds all that a real one does: making the images, both networks of an adversarial model, clipping,
//! optimizers. Weights are the initial ones, links random.

mod common;

use std::time::{Duration, Instant};

use aps_model::{Preset, frozen};
use common::{Case, Outcome};

/// The runner's allocator: memory of a step is used again in the next one, rather than asked anew from the system page by page.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Outcome<()> {
    let mut words = std::env::args().skip(1);
    let mut word = |usual: &str| words.next().unwrap_or(usual.into());
    let name = word("resnet_mlp-train-64-32");
    let parts: Vec<&str> = name.split('-').collect();
    let &[model, what, pixels, batch] = parts.as_slice() else {
        return Err("expected MODEL-WHAT-PIXELS-BATCH".into());
    };
    let device = common::device(&word("cpu"))?;
    let precision = word("full").parse()?;
    let seconds = Duration::from_secs_f64(word("3").parse()?);
    let case = Case {
        kind: model.parse()?,
        preset: Preset::Paper,
        image_size: pixels.parse()?,
        device,
        precision,
    };
    let batch: usize = batch.parse()?;
    let best = match what {
        "train" => {
            let mut trainer = case.trainer(batch)?;
            best_of(seconds, || {
                trainer.step()?;
                Ok(case.device.synchronize()?)
            })?
        }
        "infer" => {
            let shape = case.input()?.shape();
            let parameters = case.parameters(shape)?;
            let conditions = case.conditions(batch)?;
            let model = case.kind.build(case.preset, shape, frozen(&parameters)?)?;
            best_of(seconds, || {
                model.forward_t(&conditions, false)?;
                Ok(case.device.synchronize()?)
            })?
        }
        other => return Err(format!("'{other}' is neither train nor infer").into()),
    };
    println!("{}", best.as_secs_f64() * 1e3);
    Ok(())
}

fn best_of(seconds: Duration, mut run: impl FnMut() -> Outcome<()>) -> Outcome<Duration> {
    run()?;
    run()?;
    let (started, mut best) = (Instant::now(), Duration::MAX);
    while started.elapsed() < seconds {
        let one = Instant::now();
        run()?;
        best = best.min(one.elapsed());
    }
    Ok(best)
}
