//! The receivers of a map, each prepared once, when a transmitter first needs it.

use std::sync::OnceLock;

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Receiver, Tracer};
use rayon::prelude::*;

use crate::error::{At, Place, Result};

/// Choice of the receivers of a map that each transmitter is linked with.
#[derive(Clone, Copy)]
pub enum Choice {
    /// Links every transmitter with all receivers.
    All,
    /// Links each transmitter with the first receivers that it reaches inside the limits, so many at most.
    FirstReached(usize),
}

/// Points where receivers can stand.
pub struct Pool {
    points: Vec<DVec2>,
    prepared: Vec<OnceLock<Receiver>>,
}

impl Pool {
    /// Takes the points, and prepares the first `sure` of them on all threads.
    pub fn new(tracer: &Tracer<'_>, points: &[DVec2], sure: usize) -> Result<Self> {
        let pool = Self {
            points: points.to_vec(),
            prepared: points.iter().map(|_| OnceLock::new()).collect(),
        };
        let sure = sure.min(points.len()) as u32;
        (0..sure)
            .into_par_iter()
            .try_for_each(|id| pool.get(tracer, id).map(|_| ()))?;
        Ok(pool)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// The place of a receiver \[m\].
    pub fn point(&self, id: u32) -> DVec2 {
        self.points[id as usize]
    }

    /// A receiver, prepared if it is not yet.
    pub fn get(&self, tracer: &Tracer<'_>, id: u32) -> Result<&Receiver> {
        let cell = &self.prepared[id as usize];
        if let Some(receiver) = cell.get() {
            return Ok(receiver);
        }
        // Two threads may both prepare it, alike; one result is kept.
        let prepared = tracer.receiver(self.points[id as usize]);
        let prepared = prepared.at(Place::Receiver(id.into()))?;
        Ok(cell.get_or_init(|| prepared))
    }
}
