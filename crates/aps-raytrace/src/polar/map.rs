//! The polar view of one scene: the work done once for all terminals.

use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec2;

use super::corners::Corners;
use super::error::PolarError;
use super::fan::Fan;
use super::rays::ReceiverRays;
use super::ways::TransmitterWays;
use crate::scene::Scene;

/// A scene prepared for looking at it along rays.
#[derive(Debug, Clone)]
pub struct PolarMap<'s> {
    /// Told by no other map of this process.
    number: u64,
    given: Cow<'s, Scene>,
    /// Scene in which everything is computed, where that is another: moved by `-origin` where it lies far off.
    moved: Option<Scene>,
    origin: DVec2,
    fan: Fan,
    pub(super) corners: Corners,
}

impl<'s> PolarMap<'s> {
    /// Prepares a scene: work done once a map, spread over the threads. Costs a visibility test for each pair of corners before
    /// whose walls the other one lies on one side.
    ///
    /// # Errors
    /// [`PolarError::Fan`], [`PolarError::TooManyCorners`].
    pub fn new(scene: &'s Scene, fan: Fan) -> Result<Self, PolarError> {
        Self::of(Cow::Borrowed(scene), fan)
    }

    /// Does the same, and keeps the scene.
    ///
    /// # Errors
    /// As [`PolarMap::new`].
    pub fn owning(scene: Scene, fan: Fan) -> Result<PolarMap<'static>, PolarError> {
        PolarMap::of(Cow::Owned(scene), fan)
    }

    fn of(given: Cow<'s, Scene>, fan: Fan) -> Result<Self, PolarError> {
        fan.check()?;
        let (moved, origin) = given.near_zero();
        static MAPS: AtomicU64 = AtomicU64::new(0);
        Ok(Self {
            number: MAPS.fetch_add(1, Ordering::Relaxed),
            corners: Corners::new(moved.as_ref().unwrap_or(&given))?,
            given,
            moved,
            origin,
            fan,
        })
    }

    /// Finds the ways of a transmitter to the corners.
    ///
    /// # Errors
    /// [`PolarError::Terminal`] where none can stand, [`PolarError::TooManyWays`].
    pub fn transmitter(&self, position: DVec2) -> Result<TransmitterWays, PolarError> {
        TransmitterWays::new(self, self.place(position)?)
    }

    /// Follows the rays of a receiver.
    ///
    /// # Errors
    /// [`PolarError::Terminal`] where none can stand.
    pub fn receiver(&self, position: DVec2) -> Result<ReceiverRays, PolarError> {
        Ok(ReceiverRays::new(self, self.place(position)?))
    }

    /// Returns the place of a terminal in the local scene.
    fn place(&self, position: DVec2) -> Result<DVec2, PolarError> {
        let checked = self.given.check_terminal(position);
        checked.map_err(PolarError::Terminal)?;
        Ok(position - self.origin)
    }

    /// The number that terminals tell their map by.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// The rays.
    #[must_use]
    pub fn fan(&self) -> Fan {
        self.fan
    }

    /// Number of corners that ways bend around.
    #[must_use]
    pub fn corner_count(&self) -> usize {
        self.corners.corners.len()
    }

    pub(super) fn scene(&self) -> &Scene {
        self.moved.as_ref().unwrap_or(&self.given)
    }
}
