//! Parts made on all threads and taken in their order.

use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, PoisonError};

/// Parts a thread that may wait for a slower part before them.
const WAITING_A_THREAD: usize = 4;

/// Makes every part on the threads of the current rayon pool, and hands what was made to `take` in the order of the parts.
///
/// A thread that has finished a part begins the next one at once, unless too many wait in memory for a slower part before them: four a
/// thread. `make` and `take` must not use the pool themselves.
///
/// # Errors
/// The first error of `make` or `take` in the order of the parts, on any number of threads. No part is begun once it is known.
pub fn in_order<T: Sync, R: Send, E: Send>(
    parts: &[T],
    make: impl Fn(&T) -> Result<R, E> + Sync,
    take: impl FnMut(R) -> Result<(), E> + Send,
) -> Result<(), E> {
    let threads = rayon::current_num_threads();
    let queue = Mutex::new(Queue {
        left: 0..parts.len(),
        taken: 0,
        waiting: BTreeMap::new(),
        take,
        outcome: Ok(()),
    });
    let change = Condvar::new();
    let make_parts = |_: &rayon::Scope<'_>| {
        let _end = EndAtPanic(&queue, &change);
        let mut own = queue.lock().expect(PANICKED);
        loop {
            let far = own.taken + WAITING_A_THREAD * threads;
            if own.left.start >= far && !own.left.is_empty() {
                own = change.wait(own).expect(PANICKED);
                continue;
            }
            let Some(part) = own.left.next() else {
                break;
            };
            drop(own);
            let made = make(&parts[part]);
            own = queue.lock().expect(PANICKED);
            own.add(part, made);
            change.notify_all();
        }
    };
    rayon::scope(|scope| (0..threads).for_each(|_| scope.spawn(make_parts)));
    queue.into_inner().expect(PANICKED).outcome
}

/// Message of a thread that ends since another panicked.
const PANICKED: &str = "no other thread panicked";

/// The parts that are left, and those that are done.
struct Queue<R, E, F> {
    left: std::ops::Range<usize>,
    taken: usize,
    waiting: BTreeMap<usize, Result<R, E>>,
    take: F,
    outcome: Result<(), E>,
}

impl<R, E, F: FnMut(R) -> Result<(), E>> Queue<R, E, F> {
    /// Adds a part, and takes all that wait for no other.
    fn add(&mut self, part: usize, made: Result<R, E>) {
        let is_sound = made.is_ok();
        self.waiting.insert(part, made);
        while let Some(made) = self.waiting.remove(&self.taken) {
            self.taken += 1;
            if self.outcome.is_ok() {
                self.outcome = made.and_then(&mut self.take);
            }
        }
        if !is_sound || self.outcome.is_err() {
            self.left = 0..0;
        }
    }
}

/// Ends the work of all threads where one panics: nobody makes its part, for which others may wait.
struct EndAtPanic<'q, R, E, F>(&'q Mutex<Queue<R, E, F>>, &'q Condvar);

impl<R, E, F> Drop for EndAtPanic<'_, R, E, F> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).left = 0..0;
            self.1.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

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
    fn a_panic_ends_all_threads() {
        let parts: Vec<usize> = (0..100).collect();
        let made = AtomicUsize::new(0);
        let make = |&part: &usize| {
            // The others go on until they would wait for it.
            while part == 0 && made.load(Ordering::Relaxed) + 1 < 2 * WAITING_A_THREAD {
                std::hint::spin_loop();
            }
            assert!(part > 0, "the first part panics");
            made.fetch_add(1, Ordering::Relaxed);
            Ok::<(), ()>(())
        };
        let run = std::panic::AssertUnwindSafe(|| on_threads(2, || in_order(&parts, make, Ok)));
        assert!(std::panic::catch_unwind(run).is_err());
        assert!(made.into_inner() < 2 * WAITING_A_THREAD + 1);
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
