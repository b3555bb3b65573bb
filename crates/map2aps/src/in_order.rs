//! Parts made on all threads and taken in their order.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Makes every part on the threads of the current rayon pool, and hands what was made to `take` in the order of the parts.
///
/// A thread that has finished a part begins the next one at once. What is done before a slower part ahead of it waits in memory.
/// `make` must not use the pool itself.
///
/// # Errors
/// The first error of `make` or `take` in the order of the parts, on any number of threads. No part is begun after it.
pub fn in_order<T: Sync, R: Send, E: Send>(
    parts: &[T],
    make: impl Fn(&T) -> Result<R, E> + Sync,
    take: impl FnMut(R) -> Result<(), E> + Send,
) -> Result<(), E> {
    let begun = AtomicUsize::new(0);
    let queue = Mutex::new(Queue {
        taken: 0,
        waiting: BTreeMap::new(),
        take,
        outcome: Ok(()),
    });
    let make_the_next = |_: &rayon::Scope<'_>| {
        loop {
            let part = begun.fetch_add(1, Ordering::Relaxed);
            let Some(input) = parts.get(part) else {
                break;
            };
            let made = make(input);
            let mut queue = queue.lock().expect("a panic ends the scope");
            if queue.add(part, made).is_err() {
                begun.store(parts.len(), Ordering::Relaxed);
            }
        }
    };
    rayon::scope(|scope| {
        (0..rayon::current_num_threads()).for_each(|_| scope.spawn(make_the_next));
    });
    queue.into_inner().expect("a panic ends the scope").outcome
}

/// The parts that are done.
struct Queue<R, E, F> {
    taken: usize,
    waiting: BTreeMap<usize, Result<R, E>>,
    take: F,
    outcome: Result<(), E>,
}

/// No further part is worth a beginning.
struct Failed;

impl<R, E, F: FnMut(R) -> Result<(), E>> Queue<R, E, F> {
    /// Adds a part, and takes all that wait for no other.
    fn add(&mut self, part: usize, made: Result<R, E>) -> Result<(), Failed> {
        let is_sound = made.is_ok();
        self.waiting.insert(part, made);
        while let Some(made) = self.waiting.remove(&self.taken) {
            self.taken += 1;
            if self.outcome.is_ok() {
                self.outcome = made.and_then(&mut self.take);
            }
        }
        (is_sound && self.outcome.is_ok())
            .then_some(())
            .ok_or(Failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(run)
    }

    #[test]
    fn parts_are_taken_in_order_and_the_first_error_is_told() {
        let parts: Vec<usize> = (0..200).collect();
        for threads in [1, 2, 5] {
            let run = |wrong: &[usize], refused: usize| {
                let mut taken = Vec::new();
                // Later parts are done sooner.
                let make = |&part: &usize| {
                    let work = (0..(200 - part as u64) * 50)
                        .fold(part as u64, |x, i| x.rotate_left(7) ^ i);
                    std::hint::black_box(work);
                    if wrong.contains(&part) {
                        Err(part)
                    } else {
                        Ok(part)
                    }
                };
                let take = |part: usize| {
                    taken.push(part);
                    if part == refused {
                        Err(1000 + part)
                    } else {
                        Ok(())
                    }
                };
                let outcome = on_threads(threads, || in_order(&parts, make, take));
                (outcome, taken)
            };
            assert_eq!(run(&[], 200), (Ok(()), parts.clone()));
            assert_eq!(run(&[150, 31, 32], 200), (Err(31), parts[..31].to_vec()));
            assert_eq!(run(&[40], 31), (Err(1031), parts[..32].to_vec()));
        }
    }

    #[test]
    fn no_part_is_begun_after_an_error() {
        let begun = AtomicUsize::new(0);
        let make = |&part: &usize| {
            begun.fetch_add(1, Ordering::Relaxed);
            if part == 3 { Err(()) } else { Ok(()) }
        };
        let parts: Vec<usize> = (0..100).collect();
        let outcome = on_threads(1, || in_order(&parts, make, Ok));
        assert_eq!((outcome, begun.into_inner()), (Err(()), 4));
    }
}
