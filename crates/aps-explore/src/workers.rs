//! Threads that work for requests, as many at a time as there are processors.
//!
//! They are no pool of rayon: there a thread that waits for the rest of its own work takes up another request, and hangs for ever if
//! that waits for what it is preparing itself.

use std::num::NonZero;
use std::sync::Arc;

use tokio::sync::Semaphore;

use crate::fault::Fault;
use crate::stock::Stock;

/// Threads for requests of one kind.
#[derive(Debug, Clone)]
pub struct Workers {
    /// The things that they work with.
    pub stock: Stock,
    places: Arc<Semaphore>,
}

impl Workers {
    /// Threads that work with a stock.
    pub fn new(stock: Stock) -> Self {
        Self {
            stock,
            places: Arc::new(Semaphore::new(Self::most())),
        }
    }

    /// Number of threads.
    pub fn most() -> usize {
        std::thread::available_parallelism().map_or(1, NonZero::get)
    }

    /// Runs a job when a thread is free. Whoever does not wait for that any more gives the job up.
    ///
    /// # Errors
    /// Errors of the job, and [`Fault::Broken`] if it panics.
    pub async fn run<T: Send + 'static>(
        &self,
        job: impl FnOnce(&Stock) -> Result<T, Fault> + Send + 'static,
    ) -> Result<T, Fault> {
        let place = Arc::clone(&self.places).acquire_owned().await;
        let stock = self.stock.clone();
        let done = tokio::task::spawn_blocking(move || {
            let done = job(&stock);
            drop(place);
            done
        });
        done.await.unwrap_or(Err(Fault::Broken))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stock::tests::stock;

    #[test]
    fn job_that_panics_leaves_its_thread_to_others() {
        let workers = Workers::new(stock());
        let runtime = tokio::runtime::Builder::new_current_thread().build();
        runtime.unwrap().block_on(async {
            for _ in 0..2 * Workers::most() {
                let broken = workers.run(|_| -> Result<(), _> { panic!("for a test") });
                assert!(matches!(broken.await, Err(Fault::Broken)));
            }
            assert_eq!(workers.run(|_| Ok(7)).await.unwrap(), 7);
        });
    }
}
