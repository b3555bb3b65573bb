//! Findings of a check.

/// Receiver and number of findings.
pub struct Findings<'a> {
    found: &'a mut dyn FnMut(String),
    count: usize,
}

impl<'a> Findings<'a> {
    /// Findings that are handed over to `found`, none so far.
    pub fn new(found: &'a mut dyn FnMut(String)) -> Self {
        Self { found, count: 0 }
    }

    /// Hands over a finding as one line.
    pub fn add(&mut self, finding: impl Into<String>) {
        (self.found)(finding.into().replace('\n', " "));
        self.count += 1;
    }

    /// Number of findings so far.
    pub fn count(&self) -> usize {
        self.count
    }
}
