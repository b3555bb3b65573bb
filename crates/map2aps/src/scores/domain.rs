//! Forms of labels that predictions are compared with.

/// Form that a data set's labels are turned into before a prediction is compared with them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Domain {
    /// The protocol's learning target, on which the benchmark's metrics are defined.
    #[default]
    Normalised,
    /// Linear power relative to the sample's maximum, in \[0, 1\].
    Linear,
}

impl Domain {
    /// Both forms, the default first.
    pub const ALL: [Self; 2] = [Self::Normalised, Self::Linear];

    /// `normalised` or `linear`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normalised => "normalised",
            Self::Linear => "linear",
        }
    }
}
