//! Transformed kernels, made for one call or cached for all.

use std::ops::Deref;
use std::sync::OnceLock;

use super::super::buffer::Buffer;
use super::tiles::Size;

/// Kernel cache of a weight that never changes, filled by the first call that needs it: 16/9 of the weight's memory for
/// tiles of 2 x 2 outputs, 4 times it for 4 x 4.
#[derive(Debug, Default)]
pub(crate) struct KernelCache {
    two: OnceLock<Vec<f32>>,
    four: OnceLock<Vec<f32>>,
}

/// Transformed kernels.
pub(super) enum Kernels<'a> {
    Cached(&'a [f32]),
    Own(Buffer),
}

impl KernelCache {
    /// Returns the kernels for tiles of `size`, which `make` writes into `len` values.
    ///
    /// Calls at the same time may each make them. They cannot wait for one another: `make` works in parallel, and a thread
    /// that waits in it for its parts may take up another call meanwhile.
    pub(super) fn get_or_make(
        cache: Option<&Self>,
        size: Size,
        len: usize,
        make: impl Fn(&mut [f32]),
    ) -> Kernels<'_> {
        let Some(cache) = cache else {
            let mut own = Buffer::of(len);
            make(&mut own);
            return Kernels::Own(own);
        };
        let place = match size {
            Size::Two => &cache.two,
            Size::Four => &cache.four,
        };
        Kernels::Cached(match place.get() {
            Some(kernels) => kernels,
            None => {
                let mut kernels = vec![0.0; len];
                make(&mut kernels);
                place.get_or_init(|| kernels)
            }
        })
    }
}

impl Deref for Kernels<'_> {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        match self {
            Self::Cached(kernels) => kernels,
            Self::Own(kernels) => kernels,
        }
    }
}
