//! A link as pictures need it: its paths, its spectrum under either protocol, and the lobes that the paths make.

mod lobes;
mod spectrum;
mod view;

pub use lobes::{Lobe, SampledLoss, Side, has_mirrors, lobes, sampled_loss};
pub use spectrum::{Spectrum, angle_deg, apart_deg, dominant_peaks, mirror_deg, turn_deg};
pub use view::{Bend, LinkView, PathView, heading_words};
