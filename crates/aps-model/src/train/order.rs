//! Batch and random numbers of each step: functions of the seed alone.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Use of random numbers; each has streams of its own.
#[derive(Debug, Clone, Copy)]
pub enum Use {
    /// Shuffling of an epoch.
    Order,
    /// Dropout of a step.
    Dropout,
}

/// Returns the generator of one epoch or step.
pub fn generator(seed: u64, of: Use, number: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(number << 1 | of as u64);
    generator
}

/// Order of the examples in the batches of all epochs.
#[derive(Debug, Clone)]
pub struct Order {
    seed: u64,
    examples: usize,
    batch: usize,
    /// The epoch last asked for and its order.
    epoch: Option<(u64, Vec<u32>)>,
}

impl Order {
    /// The order of at least one example, in batches of at least one.
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
            order.shuffle(&mut generator(self.seed, Use::Order, epoch));
            self.epoch = Some((epoch, order));
        }
        let (_, order) = self.epoch.as_ref().expect("made above");
        &order[within as usize * self.batch..][..self.batch]
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
