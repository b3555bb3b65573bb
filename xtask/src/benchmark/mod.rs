//! The benchmark's results and the report made of them.

mod results;

pub use results::{
    CurvePoint, DataSummary, Entry, EntryKind, Example, FILE, FORMAT, Failure, Latency, Machine,
    Prediction, ProtocolScores, Results, TestLink, Training,
};
