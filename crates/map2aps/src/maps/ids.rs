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
    Ok(ascending(ids))
}

/// Collects values in ascending order, each once.
pub(crate) fn ascending<T: Ord>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut values: Vec<T> = values.into_iter().collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// Returns the chosen maps ascending, each once; all must be among the available ones, which are ascending.
///
/// # Errors
/// [`MapError::Missing`].
pub fn choose(available: &[u32], chosen: &[u32]) -> Result<Vec<u32>, MapError> {
    let chosen = ascending(chosen.iter().copied());
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
