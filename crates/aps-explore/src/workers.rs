//! Threads that work for requests, as many at a time as there are processors.
//!
//! They are no pool of rayon: there a thread that waits for the rest of its own work takes up another request, and hangs for ever if
//! that waits for what it is preparing itself.

use std::num::NonZero;
use std::sync::Arc;

use tokio::sync::Semaphore;

use crate::cache::Cache;
use crate::fault::Fault;

/// Threads for requests of one kind.
#[derive(Debug, Clone)]
pub struct Workers {
    /// Prepared objects that they work with.
    pub cache: Cache,
    places: Arc<Semaphore>,
}

impl Workers {
    /// Threads that work with a cache.
    pub fn new(cache: Cache) -> Self {
        Self {
            cache,
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
        job: impl FnOnce(&Cache) -> Result<T, Fault> + Send + 'static,
    ) -> Result<T, Fault> {
        let place = Arc::clone(&self.places).acquire_owned().await;
        let cache = self.cache.clone();
        let done = tokio::task::spawn_blocking(move || {
            let done = job(&cache);
            drop(place);
            done
        });
        done.await.unwrap_or(Err(Fault::Broken))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::tests::cache;

    #[test]
    fn job_that_panics_leaves_its_thread_to_others() {
        let workers = Workers::new(cache());
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
