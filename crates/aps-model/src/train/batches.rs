//! Batches of examples: in the order of the seed, put together ahead of time.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use rand::RngExt;
use rand::seq::SliceRandom;

use crate::ANGLE_BINS;
use crate::condition::{Link, ModelInput};
use crate::data::Examples;
use crate::random::{Purpose, generator};

/// Batches that wait; with the one being made and the one in use there are at most four in memory.
const AHEAD: usize = 2;

/// Examples of a group that come soon after each other in an epoch: enough for the work that they share to be small beside the
/// network's, few enough for batches to hold many groups, and an epoch's parts many more.
const TOGETHER: usize = 16;

/// Parts of groups that an epoch draws from at a time.
const OPEN: usize = 256;

/// Order of the examples in the batches of all epochs: all shuffled, or in an order in which examples of a group are near each
/// other.
#[derive(Debug, Clone)]
pub(super) struct Order {
    seed: u64,
    examples: usize,
    batch: usize,
    /// Examples that share work; without any, all are shuffled.
    groups: Arc<Vec<Vec<u32>>>,
    /// The epoch last asked for and its order.
    epoch: Option<(u64, Vec<u32>)>,
}

impl Order {
    /// Creates the order of at least one example, in batches of at least one.
    pub fn new(seed: u64, examples: usize, batch: usize) -> Self {
        Self {
            seed,
            examples,
            batch: batch.min(examples),
            groups: Arc::default(),
            epoch: None,
        }
    }

    /// Groups examples whose inputs share work, so that they come near each other.
    pub fn grouped(self, examples: &dyn Examples, input: &dyn ModelInput) -> Self {
        let mut groups: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
        for example in 0..self.examples {
            let Some(group) = input.group(&examples.link(example)) else {
                return self;
            };
            groups.entry(group).or_default().push(example as u32);
        }
        Self {
            groups: Arc::new(groups.into_values().collect()),
            ..self
        }
    }

    pub fn batch(&self) -> usize {
        self.batch
    }

    pub fn steps_per_epoch(&self) -> u64 {
        (self.examples / self.batch) as u64
    }

    /// Returns the examples of a step. O(1), but for the first of an epoch, which shuffles all.
    pub fn of_step(&mut self, step: u64) -> &[u32] {
        let (epoch, within) = (step / self.steps_per_epoch(), step % self.steps_per_epoch());
        if self.epoch.as_ref().is_none_or(|(e, _)| *e != epoch) {
            self.epoch = Some((epoch, self.of_epoch(epoch)));
        }
        let (_, order) = self.epoch.as_ref().expect("made above");
        &order[within as usize * self.batch..][..self.batch]
    }

    fn of_epoch(&self, epoch: u64) -> Vec<u32> {
        let mut generator = generator(self.seed, Purpose::Order, epoch);
        if self.groups.is_empty() {
            let mut order: Vec<u32> = (0..self.examples as u32).collect();
            order.shuffle(&mut generator);
            return order;
        }
        let mut groups = self.groups.to_vec();
        for group in &mut groups {
            group.shuffle(&mut generator);
        }
        let parts = groups.iter().flat_map(|group| group.chunks(TOGETHER));
        let mut parts: Vec<&[u32]> = parts.collect();
        parts.shuffle(&mut generator);
        let mut waiting = parts.into_iter();
        let mut open: Vec<&[u32]> = waiting.by_ref().take(OPEN).collect();
        let mut order = Vec::with_capacity(self.examples);
        while !open.is_empty() {
            let drawn = generator.random_range(0..open.len());
            let [example, rest @ ..] = open[drawn] else {
                unreachable!("parts are not empty");
            };
            order.push(*example);
            open[drawn] = rest;
            if rest.is_empty() {
                match waiting.next() {
                    Some(part) => open[drawn] = part,
                    None => drop(open.swap_remove(drawn)),
                }
            }
        }
        order
    }
}

/// Batch of one step: numbers of examples, their links and targets.
#[derive(Debug)]
pub(super) struct Batch {
    pub examples: Vec<u32>,
    pub links: Vec<Link>,
    /// Shape (links, bins); empty where they lie on the device.
    pub targets: Vec<f32>,
}

/// A thread that makes the batches of consecutive steps; it ends when this is dropped.
#[derive(Debug)]
pub(super) struct Prefetch {
    batches: Option<Receiver<Batch>>,
    thread: Option<JoinHandle<()>>,
}

impl Prefetch {
    /// Starts the thread, which makes the batches of some steps, with or without targets.
    pub fn start(
        examples: Arc<dyn Examples>,
        input: Arc<dyn ModelInput>,
        mut order: Order,
        steps: Range<u64>,
        needs_targets: bool,
    ) -> Self {
        let (sender, batches) = sync_channel(AHEAD);
        let work = move || {
            for step in steps {
                let batch = assemble(&*examples, order.of_step(step), needs_targets);
                // Whoever asks for the batch finds the same error.
                let _ = input.prepare(&batch.links);
                // Nobody waits any more: the training was dropped.
                if sender.send(batch).is_err() {
                    return;
                }
            }
        };
        Self {
            batches: Some(batches),
            thread: Some(std::thread::spawn(work)),
        }
    }

    /// Returns the batch of the next step.
    ///
    /// # Panics
    /// When the examples panicked in their thread, or beyond the last step.
    pub fn next(&mut self) -> Batch {
        let batches = self.batches.as_ref().expect("there until dropped");
        let Ok(batch) = batches.recv() else {
            match self.thread.take().map(JoinHandle::join) {
                Some(Err(panic)) => std::panic::resume_unwind(panic),
                _ => panic!("no batch is left beyond the last step"),
            }
        };
        batch
    }
}

impl Drop for Prefetch {
    fn drop(&mut self) {
        // Hanging up first lets a thread end that waits for room.
        self.batches = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn assemble(examples: &dyn Examples, numbers: &[u32], needs_targets: bool) -> Batch {
    let count = if needs_targets { numbers.len() } else { 0 };
    let mut targets = vec![0.0; count * ANGLE_BINS];
    for (target, &number) in targets.chunks_exact_mut(ANGLE_BINS).zip(numbers) {
        examples.write_target(number as usize, target);
    }
    Batch {
        examples: numbers.to_vec(),
        links: numbers.iter().map(|&n| examples.link(n as usize)).collect(),
        targets,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_epoch_takes_each_example_at_most_once_and_epochs_differ() {
        let mut order = Order::new(7, 103, 10);
        assert_eq!(order.steps_per_epoch(), 10);
        let mut epoch = |e: u64| -> Vec<u32> {
            (0..10)
                .flat_map(|s| order.of_step(e * 10 + s).to_vec())
                .collect()
        };
        let (first, second) = (epoch(0), epoch(1));
        let mut sorted = first.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), 100);
        assert_ne!(first, second);
        assert_eq!(first, epoch(0), "an epoch can be asked for again");
    }

    /// Links of which each transmitter has some.
    #[derive(Debug)]
    struct Transmitters(usize);

    impl Examples for Transmitters {
        fn len(&self) -> usize {
            5000
        }

        fn link(&self, example: usize) -> Link {
            Link {
                map: 0,
                tx_m: [(example / self.0) as f64, 0.0],
                rx_m: [example as f64, 1.0],
            }
        }

        fn write_target(&self, _: usize, _: &mut [f32]) {}
    }

    #[derive(Debug)]
    struct ByTransmitter;

    impl ModelInput for ByTransmitter {
        fn batch(&self, _: &[Link]) -> crate::Result<candle_core::Tensor> {
            unreachable!("no input is made here")
        }

        fn group(&self, link: &Link) -> Option<u64> {
            Some(link.tx_m[0].to_bits())
        }

        fn device(&self) -> &candle_core::Device {
            &candle_core::Device::Cpu
        }
    }

    #[test]
    fn grouped_epochs_take_each_example_once_and_few_transmitters_at_a_time() {
        for of_one in [1, 40, 100, 5000] {
            let examples = Transmitters(of_one);
            let mut order = Order::new(7, 5000, 10).grouped(&examples, &ByTransmitter);
            let mut epoch = |e: u64| -> Vec<u32> {
                let steps = e * 500..(e + 1) * 500;
                steps
                    .flat_map(|step| order.of_step(step).to_vec())
                    .collect()
            };
            let (first, second) = (epoch(0), epoch(1));
            let mut sorted = first.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..5000));
            assert_ne!(first, second);
            assert_eq!(first, epoch(0), "an epoch can be asked for again");

            // A transmitter's part is over before many others begin: its geometry is prepared about once for all of the part.
            let mut made = 0;
            let mut recent: Vec<usize> = Vec::new();
            for example in first {
                let of = example as usize / of_one;
                match recent.iter().position(|&tx| tx == of) {
                    Some(at) => drop(recent.remove(at)),
                    None => made += 1,
                }
                recent.push(of);
                if recent.len() > 2 * OPEN {
                    recent.remove(0);
                }
            }
            let parts = (5000 / of_one) * of_one.div_ceil(TOGETHER);
            assert!(made <= parts * 5 / 4, "{of_one}: {made} for {parts}");
        }
    }

    #[test]
    fn a_batch_is_no_larger_than_all_examples() {
        let mut order = Order::new(0, 3, 512);
        assert_eq!((order.steps_per_epoch(), order.of_step(5).len()), (1, 3));
    }
}
