//! Operations written down as nodes of ONNX while they are computed: what [`crate::onnx`] makes files of.

mod graph;
mod record;
pub(crate) mod schema;

pub(crate) use graph::{Graph, Value, float, int, ints, word};
pub(crate) use record::{is_recording, record, recorded};
