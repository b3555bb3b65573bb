//! Numbers of fronts, by which paths within the limits are counted without a look at each.

/// Numbers of fronts by corner and reflections.
#[derive(Debug, Clone)]
pub(crate) struct Counts {
    most_reflections: usize,
    /// Number of fronts for each corner and number of reflections; cumulative after `sum_up`.
    fronts: Vec<usize>,
}

impl Counts {
    pub fn new(corners: usize, most_reflections: u32) -> Self {
        let most_reflections = most_reflections as usize;
        Self {
            most_reflections,
            fronts: vec![0; corners * (most_reflections + 1)],
        }
    }

    /// Numbers of fronts at a corner, by reflections.
    pub fn at(&mut self, corner: u32) -> &mut [usize] {
        let count = self.most_reflections + 1;
        &mut self.fronts[corner as usize * count..][..count]
    }

    /// Makes the numbers cumulative, once all are counted.
    pub fn sum_up(&mut self) {
        for at_corner in self.fronts.chunks_mut(self.most_reflections + 1) {
            for i in 1..at_corner.len() {
                at_corner[i] += at_corner[i - 1];
            }
        }
    }

    /// Number of all fronts.
    pub fn total(&self) -> usize {
        let at_corners = self.fronts.chunks(self.most_reflections + 1);
        at_corners.map(|at| at[at.len() - 1]).sum()
    }

    /// Number of fronts at a corner with at most this many reflections.
    #[inline]
    pub fn with_at_most(&self, corner: u32, reflections: u32) -> usize {
        let reflections = self.most_reflections.min(reflections as usize);
        self.fronts[corner as usize * (self.most_reflections + 1) + reflections]
    }
}
