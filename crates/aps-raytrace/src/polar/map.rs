//! The polar view of one scene: the work done once for all terminals.

use std::borrow::Cow;

use glam::DVec2;

use super::corners::Corners;
use super::error::PolarError;
use super::fan::Fan;
use crate::local_scene::LocalScene;
use crate::scene::Scene;

/// A scene prepared for looking at it along rays.
#[derive(Debug, Clone)]
pub struct PolarMap<'s> {
    pub(super) scene: LocalScene<'s>,
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

    /// Prepares a map that owns its scene.
    ///
    /// # Errors
    /// As [`PolarMap::new`].
    pub fn owning(scene: Scene, fan: Fan) -> Result<PolarMap<'static>, PolarError> {
        PolarMap::of(Cow::Owned(scene), fan)
    }

    fn of(given: Cow<'s, Scene>, fan: Fan) -> Result<Self, PolarError> {
        fan.check()?;
        let scene = LocalScene::new(given);
        Ok(Self {
            corners: Corners::new(scene.local())?,
            scene,
            fan,
        })
    }

    /// Returns the place of a terminal in the local scene.
    pub(super) fn place(&self, position: DVec2) -> Result<DVec2, PolarError> {
        let checked = self.scene.given.check_terminal(position);
        checked.map_err(PolarError::Terminal)?;
        Ok(position - self.scene.origin)
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
}
