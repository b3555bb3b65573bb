//! Working memory that is used again.

use std::cell::RefCell;
use std::ops::{Deref, DerefMut};

/// Buffers a thread keeps for later.
const KEPT: usize = 4;

thread_local! {
    static SPARE: RefCell<Vec<Vec<f32>>> = const { RefCell::new(Vec::new()) };
}

/// Memory for intermediate values, from and back to a store of this thread: fresh pages would cost as much as filling
/// them. A thread keeps the few largest it had in use at once.
pub(super) struct Buffer(Vec<f32>);

impl Buffer {
    /// Takes a buffer of `len` values, which hold anything: write them before reading.
    pub fn of(len: usize) -> Self {
        let mut values = SPARE.with_borrow_mut(|spare| {
            // The smallest that is large enough, else the largest; the store is sorted by size.
            let fitting = spare.partition_point(|v| v.capacity() < len);
            let index = fitting.min(spare.len().saturating_sub(1));
            match spare.is_empty() {
                true => Vec::new(),
                false => spare.remove(index),
            }
        });
        if values.capacity() < len {
            // Nothing is worth copying.
            values = Vec::new();
        }
        values.resize(len, 0.0);
        Self(values)
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        let values = std::mem::take(&mut self.0);
        // A thread that ends has no store any more.
        let _ = SPARE.try_with(|spare| {
            let mut spare = spare.borrow_mut();
            let at = spare.partition_point(|v| v.capacity() < values.capacity());
            spare.insert(at, values);
            if spare.len() > KEPT {
                spare.remove(0);
            }
        });
    }
}

impl Deref for Buffer {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.0
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_comes_back() {
        let first = Buffer::of(1000);
        let address = first.as_ptr();
        drop(first);
        let smaller = Buffer::of(10);
        assert_eq!(smaller.as_ptr(), address);
        assert_eq!(smaller.len(), 10);
    }

    #[test]
    fn few_are_kept() {
        let many: Vec<Buffer> = (1..10).map(Buffer::of).collect();
        drop(many);
        SPARE.with_borrow(|spare| {
            assert_eq!(spare.len(), KEPT);
            assert!(spare.iter().all(|v| v.capacity() > 4));
        });
    }
}
