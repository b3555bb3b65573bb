//! A scene as a map computes in it: near zero, with the map's identifier.

use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec2;

use crate::scene::Scene;

/// A scene, moved to zero where it lies far off.
#[derive(Debug, Clone)]
pub(crate) struct LocalScene<'s> {
    /// Identifier of the map, unique in this process but for its copies.
    pub id: u64,
    /// The scene as it was given.
    pub given: Cow<'s, Scene>,
    /// The given scene moved by `-origin`, where that is another.
    moved: Option<Scene>,
    /// Position of zero in the given scene's coordinates \[m\].
    pub origin: DVec2,
}

impl<'s> LocalScene<'s> {
    /// Moves a scene where it lies far off.
    pub fn new(given: Cow<'s, Scene>) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let (moved, origin) = given.near_zero();
        Self {
            id: COUNT.fetch_add(1, Ordering::Relaxed),
            given,
            moved,
            origin,
        }
    }

    /// The scene in which everything is computed.
    pub fn local(&self) -> &Scene {
        self.moved.as_ref().unwrap_or(&self.given)
    }
}
