//! The newest request of each page: older ones are not computed.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::fault::Fault;

/// Pages that are remembered.
const MAX_COUNTERS: usize = 256;

/// The counters of newest requests, one for each page and kind of work.
#[derive(Debug, Default)]
pub struct LatestRequests(Mutex<BTreeMap<(u64, &'static str), Arc<AtomicU64>>>);

/// The place of a request among those of its page.
#[derive(Debug, Clone)]
pub struct RequestHandle {
    number: u64,
    newest: Arc<AtomicU64>,
    is_given_up: Arc<AtomicBool>,
}

impl LatestRequests {
    /// Registers a request as the newest of its kind.
    pub fn register(&self, page: u64, kind: &'static str) -> RequestHandle {
        let mut latest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if latest.len() >= MAX_COUNTERS {
            // Without a request under way nothing is lost with the counter.
            latest.retain(|_, newest| Arc::strong_count(newest) > 1);
        }
        let newest = Arc::clone(latest.entry((page, kind)).or_default());
        RequestHandle {
            number: newest.fetch_add(1, Ordering::Relaxed) + 1,
            newest,
            is_given_up: Arc::default(),
        }
    }
}

impl RequestHandle {
    /// Returns true when nobody waits for the answer any more.
    pub fn is_past(&self) -> bool {
        self.is_given_up.load(Ordering::Relaxed)
            || self.newest.load(Ordering::Relaxed) != self.number
    }

    /// Ends a request that nobody waits for.
    ///
    /// # Errors
    /// [`Fault::Overtaken`].
    pub fn check(&self) -> Result<(), Fault> {
        match self.is_past() {
            true => Err(Fault::Overtaken),
            false => Ok(()),
        }
    }

    /// Gives the request up when the value that is returned is dropped, as happens with a connection that ends.
    pub fn held(&self) -> Held {
        Held(Arc::clone(&self.is_given_up))
    }
}

/// Keeps a request from being given up.
#[derive(Debug)]
pub struct Held(Arc<AtomicBool>);

impl Drop for Held {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newer_request_of_the_same_page_and_kind_overtakes() {
        let latest = LatestRequests::default();
        let first = latest.register(1, "link");
        let others = [latest.register(2, "link"), latest.register(1, "coverage")];
        assert!(first.check().is_ok());
        let second = latest.register(1, "link");
        assert!(matches!(first.check(), Err(Fault::Overtaken)));
        assert!(second.check().is_ok() && others.iter().all(|other| !other.is_past()));
    }

    #[test]
    fn request_is_given_up_with_its_connection() {
        let handle = LatestRequests::default().register(1, "link");
        let held = handle.held();
        assert!(!handle.is_past());
        drop(held);
        assert!(handle.is_past());
    }

    #[test]
    fn pages_that_are_gone_are_forgotten_and_those_that_wait_are_not() {
        let latest = LatestRequests::default();
        let waiting = latest.register(0, "link");
        for page in 1..10 * MAX_COUNTERS as u64 {
            latest.register(page, "link");
        }
        assert!(latest.0.lock().unwrap().len() <= MAX_COUNTERS);
        latest.register(0, "link");
        assert!(waiting.is_past());
    }
}
