//! Batches put together ahead of time.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use super::order::Order;
use crate::ANGLE_BINS;
use crate::condition::Link;
use crate::data::Examples;

/// Batches that wait; with the one being made and the one in use there are at most four in memory.
const AHEAD: usize = 2;

/// Batch of one step: numbers of examples, their links and targets.
#[derive(Debug)]
pub struct Batch {
    pub examples: Vec<u32>,
    pub links: Vec<Link>,
    /// Shape (links, bins).
    pub targets: Vec<f32>,
}

/// A thread that makes the batches of consecutive steps; it ends when this is dropped.
#[derive(Debug)]
pub struct Prefetch {
    batches: Option<Receiver<Batch>>,
    thread: Option<JoinHandle<()>>,
}

impl Prefetch {
    /// Starts with step `first` and ends before step `end`.
    pub fn start(examples: Arc<dyn Examples>, mut order: Order, first: u64, end: u64) -> Self {
        let (sender, batches) = sync_channel(AHEAD);
        let work = move || {
            for step in first..end {
                // Nobody waits any more: the training was dropped.
                if sender
                    .send(assemble(&*examples, order.of_step(step)))
                    .is_err()
                {
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
