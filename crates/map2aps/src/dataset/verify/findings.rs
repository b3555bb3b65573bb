//! Findings of a check.

/// Receiver and number of findings.
pub struct Findings<'a> {
    pub found: &'a mut dyn FnMut(String),
    pub count: usize,
}

impl Findings<'_> {
    /// Hands over a finding as one line.
    pub fn add(&mut self, finding: impl Into<String>) {
        (self.found)(finding.into().replace('\n', " "));
        self.count += 1;
    }
}
