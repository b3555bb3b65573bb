//! Lists of map ids.

use super::MapError;

/// Reads ids in a list like `0-4,7,46-50`; returns them ascending, each once.
///
/// # Errors
/// [`MapError::IdList`].
pub fn parse_ids(text: &str) -> Result<Vec<u32>, MapError> {
    let mut ids = Vec::new();
    for part in text.split(',') {
        let wrong = || MapError::IdList(part.into());
        let (from, to) = part.split_once('-').unwrap_or((part, part));
        let from: u32 = from.trim().parse().map_err(|_| wrong())?;
        let to: u32 = to.trim().parse().map_err(|_| wrong())?;
        if from > to || to - from >= 1_000_000 {
            return Err(wrong());
        }
        ids.extend(from..=to);
    }
    ids.sort_unstable();
    ids.dedup();
    Ok(ids)
}

/// Returns the chosen maps ascending, each once; all must be among the available ones, which are ascending.
///
/// # Errors
/// [`MapError::Missing`].
pub fn choose(available: &[u32], chosen: &[u32]) -> Result<Vec<u32>, MapError> {
    let mut chosen = chosen.to_vec();
    chosen.sort_unstable();
    chosen.dedup();
    let missing: Vec<u32> = chosen
        .iter()
        .copied()
        .filter(|id| available.binary_search(id).is_err())
        .collect();
    match missing.is_empty() {
        true => Ok(chosen),
        false => Err(MapError::Missing {
            missing,
            available: available.to_vec(),
        }),
    }
}
