//! Batches of examples: in the order of the seed, put together ahead of time.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use rand::seq::SliceRandom;

use crate::ANGLE_BINS;
use crate::condition::Link;
use crate::data::Examples;
use crate::random::{Purpose, generator};

/// Batches that wait; with the one being made and the one in use there are at most four in memory.
const AHEAD: usize = 2;

/// Order of the examples in the batches of all epochs.
#[derive(Debug, Clone)]
pub(super) struct Order {
    seed: u64,
    examples: usize,
    batch: usize,
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
            epoch: None,
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
            let mut order: Vec<u32> = (0..self.examples as u32).collect();
            order.shuffle(&mut generator(self.seed, Purpose::Order, epoch));
            self.epoch = Some((epoch, order));
        }
        let (_, order) = self.epoch.as_ref().expect("made above");
        &order[within as usize * self.batch..][..self.batch]
    }
}

/// Batch of one step: numbers of examples, their links and targets.
#[derive(Debug)]
pub(super) struct Batch {
    pub examples: Vec<u32>,
    pub links: Vec<Link>,
    /// Shape (links, bins).
    pub targets: Vec<f32>,
}

/// A thread that makes the batches of consecutive steps; it ends when this is dropped.
#[derive(Debug)]
pub(super) struct Prefetch {
    batches: Option<Receiver<Batch>>,
    thread: Option<JoinHandle<()>>,
}

impl Prefetch {
    /// Starts the thread, with step `first`; it ends before step `end`.
    pub fn start(examples: Arc<dyn Examples>, mut order: Order, first: u64, end: u64) -> Self {
        let (sender, batches) = sync_channel(AHEAD);
        let work = move || {
            for step in first..end {
                // Nobody waits any more: the training was dropped.
                let batch = assemble(&*examples, order.of_step(step));
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
        batches
            .recv()
            .unwrap_or_else(|_| match self.thread.take().map(JoinHandle::join) {
                Some(Err(panic)) => std::panic::resume_unwind(panic),
                _ => panic!("no batch is left beyond the last step"),
            })
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

fn assemble(examples: &dyn Examples, numbers: &[u32]) -> Batch {
    let mut targets = vec![0.0; numbers.len() * ANGLE_BINS];
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

    #[test]
    fn a_batch_is_no_larger_than_all_examples() {
        let mut order = Order::new(0, 3, 512);
        assert_eq!((order.steps_per_epoch(), order.of_step(5).len()), (1, 3));
    }
}
