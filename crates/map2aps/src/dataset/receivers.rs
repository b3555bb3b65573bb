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
    /// Points that every transmitter looks at, neighbours one after the other.
    sure: Vec<u32>,
    prepared: Vec<OnceLock<Receiver>>,
}

impl Pool {
    /// Takes the points, and prepares the first `sure` of them on all threads.
    pub fn new(tracer: &Tracer<'_>, points: &[DVec2], sure: usize) -> Result<Self> {
        let pool = Self {
            points: points.to_vec(),
            sure: neighbour_by_neighbour(&points[..sure.min(points.len())]),
            prepared: points.iter().map(|_| OnceLock::new()).collect(),
        };
        pool.sure
            .par_iter()
            .try_for_each(|&id| pool.get(tracer, id).map(|_| ()))?;
        Ok(pool)
    }

    /// The points in the order in which a transmitter best looks at them: first those that it is sure to look at, neighbours one after
    /// the other, since what is read for one is then at hand for the next.
    pub fn order(&self) -> impl Iterator<Item = u32> {
        let rest = self.sure.len() as u32..self.points.len() as u32;
        self.sure.iter().copied().chain(rest)
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

/// Returns an order of points: up and down in stripes about as wide as the points are apart.
fn neighbour_by_neighbour(points: &[DVec2]) -> Vec<u32> {
    let west = points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let east = points.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    let stripes = (points.len() as f64 / 2.0).sqrt().ceil();
    let place = |&id: &u32| {
        let DVec2 { x, y } = points[id as usize];
        // All points on one line from south to north are one stripe.
        let stripe = ((x - west) / (east - west) * stripes) as u32;
        (stripe, if stripe.is_multiple_of(2) { y } else { -y })
    };
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by(|p, q| {
        let (p, q) = (place(p), place(q));
        p.0.cmp(&q.0).then(p.1.total_cmp(&q.1))
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_looked_at_once_whatever_the_places() {
        let scattered =
            (0..200).map(|i| DVec2::new(f64::from(i * 37 % 101), f64::from(i * 53 % 97)));
        let on_a_line = (0..50).map(|i| DVec2::new(7.0, f64::from(i * 11 % 50)));
        for points in [
            scattered.collect(),
            on_a_line.collect(),
            vec![DVec2::ONE; 3],
            Vec::new(),
        ] {
            let points: Vec<DVec2> = points;
            let order = neighbour_by_neighbour(&points);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..points.len() as u32).collect::<Vec<_>>());
            let way = |order: &[u32]| -> f64 {
                let legs = order.windows(2);
                legs.map(|leg| points[leg[0] as usize].distance(points[leg[1] as usize]))
                    .sum()
            };
            let drawn: Vec<u32> = (0..points.len() as u32).collect();
            assert!(
                way(&order) <= 0.3 * way(&drawn),
                "{} of {}",
                way(&order),
                way(&drawn)
            );
        }
    }
}
