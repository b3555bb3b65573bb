//! Values made on demand, of which the most recently used are kept.

use std::sync::{Arc, Mutex, PoisonError};

/// A list of values by their keys, the most recently used first.
#[derive(Debug)]
pub struct LruCache<K, V> {
    most: usize,
    #[expect(clippy::type_complexity, reason = "named nowhere else")]
    kept: Mutex<Vec<(K, Arc<Mutex<Option<Arc<V>>>>)>>,
}

impl<K: PartialEq, V> LruCache<K, V> {
    /// Keeps up to `most` values.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            kept: Mutex::default(),
        }
    }

    /// Returns the value of a key, made now if it is not there. Whoever asks for it meanwhile waits; a failure is not kept.
    ///
    /// # Errors
    /// Errors of `make`.
    pub fn get<E>(&self, key: K, make: impl FnOnce() -> Result<V, E>) -> Result<Arc<V>, E> {
        let shared = self.place(key);
        let mut place = shared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = &*place {
            return Ok(Arc::clone(value));
        }
        let made = make().map(Arc::new);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        match &made {
            // Only what is made displaces something.
            Ok(value) => {
                *place = Some(Arc::clone(value));
                kept.truncate(self.most);
            }
            Err(_) => kept.retain(|(_, place)| !Arc::ptr_eq(place, &shared)),
        }
        made
    }

    fn place(&self, key: K) -> Arc<Mutex<Option<Arc<V>>>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = match kept.iter().position(|(known, _)| *known == key) {
            Some(i) => kept.remove(i),
            None => (key, Arc::default()),
        };
        let place = Arc::clone(&entry.1);
        kept.insert(0, entry);
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_made_once_while_they_are_in_use() {
        let cache = LruCache::new(2);
        let make = |value: u32| move || Ok::<_, ()>(value);
        let fail = || Err::<u32, _>("made again");
        cache.get("a", make(1)).unwrap();
        cache.get("b", make(2)).unwrap();
        assert_eq!(*cache.get("a", fail).unwrap(), 1);
        cache.get("c", make(3)).unwrap();
        assert_eq!(*cache.get("a", fail).unwrap(), 1);
        assert_eq!(cache.get("b", fail), Err("made again"));
    }

    #[test]
    fn failure_is_not_kept() {
        let cache = LruCache::new(2);
        assert_eq!(cache.get("a", || Err::<u32, _>("no")), Err("no"));
        assert_eq!(*cache.get("a", || Ok::<_, ()>(1)).unwrap(), 1);
        for key in ["b", "c", "d"] {
            assert_eq!(cache.get(key, || Err::<u32, _>("no")), Err("no"));
        }
        assert_eq!(*cache.get("a", || Err::<u32, _>("gone")).unwrap(), 1);
    }
}
