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

/// The latest results, of so many bytes at most beside those under way. What is kept decides times, never results.
#[derive(Debug)]
pub struct Cache<T> {
    bytes: usize,
    /// Memory that a result takes.
    size: fn(&T) -> usize,
    state: Mutex<State<T>>,
}

#[derive(Debug)]
struct State<T> {
    /// Each with the call that last asked for it.
    cells: HashMap<Key, (Cell<T>, u64)>,
    calls: u64,
}

impl<T> Cache<T> {
    /// Keeps results in a memory of so many bytes, of which each takes its `size` and a place.
    pub fn new(bytes: usize, size: fn(&T) -> usize) -> Self {
        Self {
            bytes,
            size,
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
        let known = cells.len();
        *calls += 1;
        let cell = |key| {
            let (cell, last) = cells.entry(key).or_default();
            *last = *calls;
            Arc::clone(cell)
        };
        let asked = keys.map(cell).collect();
        if cells.len() > known {
            let sizes = cells.values();
            let mut sizes: Vec<_> = sizes.map(|(cell, last)| (*last, self.of(cell))).collect();
            sizes.sort_unstable_by_key(|&(last, _)| std::cmp::Reverse(last));
            let mut sum = 0;
            let too_many = sizes.iter().find(|(_, bytes)| {
                sum += bytes;
                sum > self.bytes
            });
            // All of the call that the first one too many was asked for in.
            if let Some(&(last, _)) = too_many {
                let oldest = last.min(calls.saturating_sub(UNDER_WAY));
                cells.retain(|_, (_, last)| *last > oldest);
            }
        }
        asked
    }

    /// Memory of a place and of what is in it; what is yet to be made counts when it is there.
    fn of(&self, cell: &Cell<T>) -> usize {
        let made = cell.get().and_then(|made| made.as_ref().ok());
        size_of::<(Key, Cell<T>, u64)>() + size_of::<T>() + made.map_or(0, self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_and_those_under_way_are_kept() {
        let place = Cache::<u32>::new(0, |_| 0).of(&Cell::default());
        let cache: Cache<u32> = Cache::new(10 * place, |_| 0);
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

    /// As many large ones are kept as fit, and ten times as many small ones.
    #[test]
    fn memory_is_counted_by_what_is_in_it() {
        let room = 1_000_000;
        for size in [10_000_usize, 100_000] {
            let cache: Cache<usize> = Cache::new(room, |&size| size);
            for call in 0..500 {
                let cells = cache.cells(std::iter::once((call, [0; 2])));
                cells[0].get_or_init(|| Ok(size));
            }
            let kept = cache.state.lock().unwrap().cells.len();
            // The last one asked for is not made when it is counted.
            let fit = room / (size + cache.of(&Cell::default())) + 1;
            assert!((fit - 1..=fit).contains(&kept), "{kept} of {size} bytes");
        }
    }
}
