//! Cache of ways and rays, one entry a terminal, kept while it is likely to be asked for again.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use aps_raytrace::polar::PolarError;

/// A terminal: its map, and the bits of its coordinates \[m\].
pub type Key = (usize, [u64; 2]);

/// Place of what is made of one terminal, by the first who needs it.
pub type Cell<T> = Arc<OnceLock<Result<T, PolarError>>>;

/// Calls of [`Cache::cells`] whose results are kept whatever their number: those of the batches under way.
const UNDER_WAY: u64 = 8;

/// The latest results, so many at most beside those under way. What is kept decides times, never results.
#[derive(Debug)]
pub struct Cache<T> {
    capacity: usize,
    state: Mutex<State<T>>,
}

#[derive(Debug)]
struct State<T> {
    /// Each with the call that last asked for it.
    cells: HashMap<Key, (Cell<T>, u64)>,
    calls: u64,
}

impl<T> Cache<T> {
    /// Keeps results of so many bytes each in a memory of a size.
    pub fn new(bytes: usize, of_one: usize) -> Self {
        Self {
            capacity: bytes / of_one.max(1),
            state: Mutex::new(State {
                cells: HashMap::new(),
                calls: 0,
            }),
        }
    }

    /// Returns the cells of some terminals, one a key.
    pub fn cells(&self, keys: impl Iterator<Item = Key>) -> Vec<Cell<T>> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { cells, calls } = &mut *state;
        *calls += 1;
        let cell = |key| {
            let (cell, last) = cells.entry(key).or_default();
            *last = *calls;
            Arc::clone(cell)
        };
        let asked = keys.map(cell).collect();
        if cells.len() > self.capacity {
            let mut order: Vec<u64> = cells.values().map(|(_, last)| *last).collect();
            order.sort_unstable_by(|a, b| b.cmp(a));
            // All of the call that the first one too many was asked for in.
            let oldest = order[self.capacity].min(calls.saturating_sub(UNDER_WAY));
            cells.retain(|_, (_, last)| *last > oldest);
        }
        asked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_and_those_under_way_are_kept() {
        let cache: Cache<u32> = Cache::new(40, 4);
        let ask = |keys: std::ops::Range<usize>| cache.cells(keys.map(|i| (i, [0; 2])));
        let is_kept = |key: usize| {
            cache
                .state
                .lock()
                .unwrap()
                .cells
                .contains_key(&(key, [0; 2]))
        };
        let first = ask(0..20);
        first[3].get_or_init(|| Ok(7));
        assert!(is_kept(0), "more than there is room for, but under way");
        for call in 0..UNDER_WAY as usize {
            assert!(is_kept(3));
            ask(100 + call..101 + call);
        }
        assert!(!is_kept(3), "as many as there is room for came later");
        assert_eq!(
            first[3].get(),
            Some(&Ok(7)),
            "whoever holds a cell keeps it"
        );
        assert_eq!(ask(3..4)[0].get(), None);
        assert!((100..100 + UNDER_WAY as usize).all(is_kept));
    }
}
