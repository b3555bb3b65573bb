//! Limits as the stages ask them.

/// Upper limits of the interactions on a path, and of memory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    pub reflections: u32,
    pub diffractions: u32,
    pub interactions: u32,
    /// Memory that the waves of one terminal may take.
    pub bytes: usize,
}

impl Limits {
    /// Returns true when a path with these numbers of interactions is within the limits.
    #[inline]
    pub fn allow(&self, reflections: u32, diffractions: u32) -> bool {
        reflections <= self.reflections
            && diffractions <= self.diffractions
            && reflections + diffractions <= self.interactions
    }

    /// Number of further reflections that a path with these numbers may have; `None` if it exceeds the limits already.
    #[inline]
    pub fn left(&self, reflections: u32, diffractions: u32) -> Option<u32> {
        let most = self.interactions.checked_sub(diffractions)?;
        let left = self.reflections.min(most).checked_sub(reflections)?;
        (diffractions <= self.diffractions).then_some(left)
    }
}
