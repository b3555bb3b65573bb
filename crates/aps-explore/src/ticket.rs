//! The newest request of each page: older ones are not computed.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::fault::Fault;

/// Pages that are remembered.
const MAX_LANES: usize = 256;

/// The counters of newest requests, one for each page and kind of work.
#[derive(Debug, Default)]
pub struct Lanes(Mutex<BTreeMap<(u64, &'static str), Arc<AtomicU64>>>);

/// The place of a request among those of its page.
#[derive(Debug, Clone)]
pub struct Ticket {
    number: u64,
    newest: Arc<AtomicU64>,
    is_given_up: Arc<AtomicBool>,
}

impl Lanes {
    /// Takes a request of a page in: from now on it is the newest of its kind.
    pub fn enter(&self, page: u64, kind: &'static str) -> Ticket {
        let mut lanes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if lanes.len() >= MAX_LANES {
            // Without a request under way nothing is lost with the counter.
            lanes.retain(|_, newest| Arc::strong_count(newest) > 1);
        }
        let newest = Arc::clone(lanes.entry((page, kind)).or_default());
        Ticket {
            number: newest.fetch_add(1, Ordering::Relaxed) + 1,
            newest,
            is_given_up: Arc::default(),
        }
    }
}

impl Ticket {
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
        let lanes = Lanes::default();
        let first = lanes.enter(1, "link");
        let others = [lanes.enter(2, "link"), lanes.enter(1, "coverage")];
        assert!(first.check().is_ok());
        let second = lanes.enter(1, "link");
        assert!(matches!(first.check(), Err(Fault::Overtaken)));
        assert!(second.check().is_ok() && others.iter().all(|other| !other.is_past()));
    }

    #[test]
    fn request_is_given_up_with_its_connection() {
        let ticket = Lanes::default().enter(1, "link");
        let held = ticket.held();
        assert!(!ticket.is_past());
        drop(held);
        assert!(ticket.is_past());
    }

    #[test]
    fn pages_that_are_gone_are_forgotten_and_those_that_wait_are_not() {
        let lanes = Lanes::default();
        let waiting = lanes.enter(0, "link");
        for page in 1..10 * MAX_LANES as u64 {
            lanes.enter(page, "link");
        }
        assert!(lanes.0.lock().unwrap().len() <= MAX_LANES);
        lanes.enter(0, "link");
        assert!(waiting.is_past());
    }
}
