//! Operations that a convolution applies to its sums while they are still in cache.

use multiversion::multiversion;

/// `relu(scale * sum + shift + shortcut)`, each part where it is wanted.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Epilogue<'a> {
    /// A factor each output channel.
    pub scale: Option<&'a [f32]>,
    /// A summand each output channel.
    pub shift: Option<&'a [f32]>,
    /// A summand each output value.
    pub shortcut: Option<&'a [f32]>,
    pub relu: bool,
}

impl<'a> Epilogue<'a> {
    /// Adds a bias where there is one.
    pub fn bias(bias: Option<&'a [f32]>) -> Self {
        Self {
            shift: bias,
            ..Self::default()
        }
    }

    /// Works on `values`, all of one channel; the first of them is output value `place`.
    pub(super) fn apply(&self, channel: usize, place: usize, values: &mut [f32]) {
        let scale = self.scale.map_or(1.0, |s| s[channel]);
        let shift = self.shift.map_or(0.0, |s| s[channel]);
        let floor = if self.relu { 0.0 } else { f32::NEG_INFINITY };
        match self.shortcut {
            Some(s) => with_shortcut(values, &s[place..], scale, shift, floor),
            None if self.scale.is_none() && self.shift.is_none() && !self.relu => {}
            None => alone(values, scale, shift, floor),
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn alone(values: &mut [f32], scale: f32, shift: f32, floor: f32) {
    for v in values {
        let y = *v * scale + shift;
        // Not `max`: a NaN must stay one.
        *v = if y < floor { floor } else { y };
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn with_shortcut(values: &mut [f32], shortcut: &[f32], scale: f32, shift: f32, floor: f32) {
    for (v, s) in values.iter_mut().zip(shortcut) {
        let y = *v * scale + shift + s;
        *v = if y < floor { floor } else { y };
    }
}
