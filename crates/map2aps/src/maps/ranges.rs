//! Map ids in words.

/// Writes ascending ids as a list that [`parse_ids`](super::parse_ids) reads, like `0-4,7`.
pub fn ranges(ids: &[u32]) -> String {
    let runs = ids.chunk_by(|a, b| a + 1 == *b);
    let run = |run: &[u32]| match run {
        [first, .., last] => format!("{first}-{last}"),
        ids => ids.iter().map(u32::to_string).collect(),
    };
    runs.map(run).collect::<Vec<_>>().join(",")
}
