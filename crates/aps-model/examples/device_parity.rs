//! Table of all models on a device against the CPU's loops, which tests hold to PyTorch: `device_parity [DEVICE [PIXELS]]`. Ends with
//! status 1 if one is further off than is allowed.
//!
//! `spectra` is the largest difference of spectra in use over their deviation, in f32; `mixed` the length of the difference of those in
//! mixed precision over the length of those in f32; `losses` the largest relative difference of the losses of three training steps in f32,
//! and `mixed losses` the same in mixed precision.

mod common;

use std::process::ExitCode;

use aps_model::candle_core::{DType, Device};
use aps_model::train::Precision;
use aps_model::{ModelKind, Preset, frozen};
use common::{Case, Outcome};

/// Links of a batch.
const LINKS: usize = 16;

/// Allowed differences, in the order of the columns. Losses of later steps carry the differences of the weights before.
const ALLOWED: [f64; 4] = [1e-4, 0.03, 1e-2, 0.1];

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn spectra(case: &Case) -> Outcome<Vec<f64>> {
    let shape = case.input()?.shape();
    let parameters = case.parameters(shape)?;
    let model = case.kind.build(case.preset, shape, frozen(&parameters)?)?;
    let spectra = model.forward_t(&case.conditions(LINKS)?, false)?;
    let spectra = spectra.to_dtype(DType::F32)?.to_device(&Device::Cpu)?;
    Ok(spectra.flatten_all()?.to_dtype(DType::F64)?.to_vec1()?)
}

fn losses(case: &Case) -> Outcome<Vec<f64>> {
    let mut trainer = case.trainer(LINKS)?;
    let mut losses = Vec::new();
    for _ in 0..3 {
        let report = trainer.step()?.ok_or("the training has steps")?;
        losses.push(report.loss);
        losses.extend(report.regularizer_loss);
    }
    Ok(losses)
}

fn length(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    // NaN counts as the largest of all.
    let larger = |a: f64, b: f64| if b > a || b.is_nan() { b } else { a };
    values.into_iter().fold(0.0, larger)
}

/// The four differences of a model.
fn differences(kind: ModelKind, image_size: usize, device: &Device) -> Outcome<[f64; 4]> {
    let case = |device: &Device, precision| Case {
        kind,
        preset: Preset::Small,
        image_size,
        device: device.clone(),
        precision,
    };
    let reference = case(&Device::Cpu, Precision::Full);
    let (expected, told) = (spectra(&reference)?, losses(&reference)?);
    let mean = expected.iter().sum::<f64>() / expected.len() as f64;
    let deviation = length(expected.iter().map(|v| v - mean)) / (expected.len() as f64).sqrt();
    let mut found = [0.0; 4];
    for (n, precision) in Precision::ALL.into_iter().enumerate() {
        let case = case(device, precision);
        let spectra = spectra(&case)?;
        let apart = || spectra.iter().zip(&expected).map(|(f, e)| f - e);
        found[n] = match precision {
            Precision::Full => largest(apart().map(f64::abs)) / deviation,
            Precision::Mixed => length(apart()) / length(expected.iter().copied()),
        };
        let losses = losses(&case)?;
        let apart = losses.iter().zip(&told).map(|(f, t)| (f / t - 1.0).abs());
        found[2 + n] = largest(apart);
    }
    Ok(found)
}

fn compare(device: &str, image_size: usize) -> Outcome<bool> {
    let device = common::device(device)?;
    println!("| model | spectra | mixed | losses | mixed losses | |\n|---|---|---|---|---|---|");
    let mut is_good = true;
    for kind in ModelKind::ALL {
        let found = differences(kind, image_size, &device)?;
        let mut pairs = found.iter().zip(ALLOWED);
        let passes = pairs.all(|(found, allowed)| *found <= allowed);
        let ([a, b, c, d], title) = (found, kind.title());
        let verdict = if passes { "PASS" } else { "FAIL" };
        println!("| {title} | {a:.1e} | {b:.1e} | {c:.1e} | {d:.1e} | {verdict} |");
        is_good &= passes;
    }
    let [a, b, c, d] = ALLOWED;
    println!("| allowed | {a:.0e} | {b:.0e} | {c:.0e} | {d:.0e} | |");
    Ok(is_good)
}

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let device = words.next().unwrap_or("cpu".into());
    let pixels = words.next().map_or(Ok(64), |word| word.parse());
    let outcome = pixels
        .map_err(Into::into)
        .and_then(|pixels| compare(&device, pixels));
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
