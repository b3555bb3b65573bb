//! Time a link.

mod terminals;
mod time;

use std::time::{Duration, Instant};

use aps_metrics::Distribution;
use aps_model::Model;
use aps_model::candle_core::{Device, DeviceLocation};
use aps_model::condition::{Link, ModelInput};
use aps_report::benchmark::Latency;

use crate::config::LatencyConfig;
use crate::error::Result;
use terminals::{shares_ms, terminals_ms};

pub use time::{ms_per_link, of_times};

/// Fewest and most repetitions of a measurement.
const REPETITIONS: (usize, usize) = (3, 1000);

/// Time of a model a link, for each size of batch. The making of its input and the making of spectra are timed apart, each until the
/// device is done; the first pass warms up and is not counted.
///
/// An input may prepare each terminal once, for all links that have it. Then terminals are prepared before a pass, and timed apart on
/// an input that knows none, which `fresh` makes. To a link that is asked for alone all of that time is added, else its share
/// ([`terminals`]).
pub fn of_model(
    model: &dyn Model,
    input: &dyn ModelInput,
    fresh: &dyn Fn() -> Result<Box<dyn ModelInput>>,
    links: &[Link],
    config: &LatencyConfig,
    device: &Device,
) -> Result<Vec<Latency>> {
    let is_shared = links.iter().any(|link| input.group(link).is_some());
    let measure = |&batch: &usize| {
        let shares_ms = match is_shared {
            true => shares_ms(batch, terminals_ms(&*fresh()?, links, batch)?),
            false => 0.0,
        };
        let mut links = links.iter().copied().cycle();
        let mut pass = || -> Result<[Duration; 2]> {
            let batch: Vec<Link> = links.by_ref().take(batch).collect();
            input.prepare(&batch)?;
            let started = Instant::now();
            let images = input.batch(&batch)?;
            device.synchronize()?;
            let built = Instant::now();
            model.forward_t(&images, false)?;
            device.synchronize()?;
            Ok([built - started, built.elapsed()])
        };
        pass()?;
        let (mut inputs, mut passes) = (Vec::new(), Vec::new());
        let started = Instant::now();
        while passes.len() < REPETITIONS.0
            || (passes.len() < REPETITIONS.1 && started.elapsed().as_secs_f64() < config.seconds)
        {
            let [input, pass] = pass()?;
            inputs.push(ms_per_link(input, batch));
            passes.push(ms_per_link(pass, batch));
        }
        let inputs = Distribution::of(inputs).expect("a time was taken");
        Ok(Latency {
            input_ms_per_link: inputs.median + shares_ms,
            device: match device.location() {
                DeviceLocation::Cpu => "cpu".into(),
                DeviceLocation::Cuda { gpu_id } => format!("cuda:{gpu_id}"),
                DeviceLocation::Metal { gpu_id } => format!("metal:{gpu_id}"),
            },
            ..of_times(batch, passes)
        })
    };
    config.batches.iter().map(measure).collect()
}
