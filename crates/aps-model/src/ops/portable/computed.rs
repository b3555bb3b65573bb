//! Operations of candle's graph whose result is computed of tensors, and whose gradient is not candle's.

use std::sync::Mutex;

use candle_core::{Result, Shape, Storage, Tensor, bail};

use super::unfold::{Store, copied};

/// Result of an operation that was computed before candle runs it, for candle gives it no tensors. Taken by the forward pass: else
/// the graph would keep it.
pub(super) struct Computed(Mutex<Option<Tensor>>);

impl Computed {
    pub fn new(result: Tensor) -> Self {
        Self(Mutex::new(Some(result)))
    }

    /// The storage of the result on one kind of device.
    pub fn take<S: Store>(&self, on: impl Fn(&Storage) -> Option<&S>) -> Result<(S, Shape)> {
        let result = self.0.lock().ok().and_then(|mut result| result.take());
        let Some(result) = result else {
            bail!("an operation is computed once");
        };
        let (storage, layout) = result.storage_and_layout();
        match on(&storage) {
            Some(storage) => copied(storage, layout),
            None => bail!("the result lies on another device than the input"),
        }
    }
}

/// Defines the forward pass on one kind of device of an operation with a field `result`, of so many further inputs.
macro_rules! forward {
    ($name:ident, $storage:ident, $device:ident $(, $further:ident)?) => {
        fn $name(
            &self,
            _: &candle_core::$storage,
            _: &candle_core::Layout,
            $(_: &candle_core::$further, _: &candle_core::Layout,)?
        ) -> candle_core::Result<(candle_core::$storage, candle_core::Shape)> {
            self.result.take(|result| match result {
                candle_core::Storage::$device(result) => Some(result),
                _ => None,
            })
        }
    };
}
pub(super) use forward;
