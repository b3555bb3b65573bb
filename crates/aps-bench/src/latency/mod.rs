//! Time a link.

mod terminals;

use std::time::{Duration, Instant};

use aps_model::Model;
use aps_model::candle_core::{Device, DeviceLocation};
use aps_model::condition::{Link, ModelInput};
use aps_report::benchmark::Latency;

use crate::config::LatencyConfig;
use crate::error::Result;
use terminals::{shares_ms, terminals_ms};

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
        Ok(Latency {
            batch,
            median_ms_per_link: quantile(&mut passes, 0.5),
            p95_ms_per_link: quantile(&mut passes, 0.95),
            input_ms_per_link: quantile(&mut inputs, 0.5) + shares_ms,
            device: match device.location() {
                DeviceLocation::Cpu => "cpu".into(),
                DeviceLocation::Cuda { gpu_id } => format!("cuda:{gpu_id}"),
                DeviceLocation::Metal { gpu_id } => format!("metal:{gpu_id}"),
            },
        })
    };
    config.batches.iter().map(measure).collect()
}

/// Run times from measured times a link \[ms\], of something that needs no input and runs on the processor.
pub fn of_times(batch: usize, mut ms_per_link: Vec<f64>) -> Latency {
    Latency {
        batch,
        median_ms_per_link: quantile(&mut ms_per_link, 0.5),
        p95_ms_per_link: quantile(&mut ms_per_link, 0.95),
        input_ms_per_link: 0.0,
        device: "cpu".into(),
    }
}

/// The time of some links, divided by their number \[ms\].
pub fn ms_per_link(time: Duration, links: usize) -> f64 {
    time.as_secs_f64() * 1e3 / links as f64
}

/// The smallest of the values that is at least as large as `share` of them; sorts them.
///
/// # Panics
/// When there is none.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (share * values.len() as f64).ceil() as usize;
    values[rank.clamp(1, values.len()) - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_were_measured() {
        let mut values: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!(quantile(&mut values, 0.5), 10.0);
        assert_eq!(quantile(&mut values, 0.95), 19.0);
        assert_eq!(quantile(&mut [3.0], 0.95), 3.0);
    }
}
