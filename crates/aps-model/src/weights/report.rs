//! Result of loading.

use std::fmt;

use super::names::listed;

/// Result of loading: number of tensors filled, and names of the exceptions.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// Number of tensors filled.
    pub loaded: usize,
    /// Tensors of the file that are left out: the classifier of a pretrained backbone, tensors of a checkpoint beside the
    /// model's.
    pub dropped: Vec<String>,
    /// Counters (`num_batches_tracked`) the file lacks, as those of old PyTorch do. They are 0; no output depends on them.
    pub zeroed: Vec<String>,
    /// Tensors that keep their values, as the file has none for them: the noise input, in a [`warm_start`](super::warm_start).
    pub kept: Vec<String>,
}

impl fmt::Display for LoadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} tensors loaded", self.loaded)?;
        if !self.dropped.is_empty() {
            write!(f, "; left out: {}", listed(&self.dropped))?;
        }
        if !self.kept.is_empty() {
            write!(f, "; kept: {}", listed(&self.kept))?;
        }
        if !self.zeroed.is_empty() {
            let count = self.zeroed.len();
            write!(f, "; {count} counters not in the file begin at 0")?;
        }
        Ok(())
    }
}
