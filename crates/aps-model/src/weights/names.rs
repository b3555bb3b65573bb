//! Names in a file to names in a model: past what wrappers and checkpoints put before them, and in today's spelling.

use std::collections::BTreeMap;

/// Segments that wrappers leave in names, in any number and order: `DataParallel` and averaged models, `torch.compile`, FSDP,
/// activation checkpointing. No model has a part of that name.
const WRAPPERS: [&str; 4] = [
    "module",
    "_orig_mod",
    "_fsdp_wrapped_module",
    "_checkpoint_wrapped_module",
];

/// Names of the two linear maps of a transformer's block in torchvision: until its release 0.13, and now. The files it
/// offers for download still have the old names.
const RENAMED: [(&str, &str); 2] = [(".mlp.linear_1.", ".mlp.0."), (".mlp.linear_2.", ".mlp.3.")];

/// Names of the model's dictionary in a checkpoint with several copies, as an average beside it; the first present counts.
const PREFERRED: [&str; 7] = [
    "p_state_dict",
    "g_state_dict",
    "model_state_dict",
    "state_dict",
    "model_state",
    "model",
    "net",
];

/// Levels of a checkpoint above its state dict: more are not looked through.
const LEVELS: usize = 16;

/// The tensors of a file, seen from one model.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Names {
    /// The model's names, with the file's.
    pub found: BTreeMap<String, String>,
    /// Names where the model's are, which it does not have, with the file's.
    pub unknown: BTreeMap<String, String>,
    /// The file's names that lie elsewhere: an optimizer's, another network's.
    pub elsewhere: Vec<String>,
}

impl Names {
    /// Finds the model's tensors among all of a file: below the prefix where more than half of them are, if there is one, as
    /// `module.` or `state_dict.model.`, else as they are called. `total` is the number of the model's tensors, `own` gives
    /// the model's name of a plain one, if it has it.
    ///
    /// The error names the tensors that stand in two places.
    pub(super) fn of<'a>(
        stored: impl Iterator<Item = &'a str> + Clone,
        total: usize,
        own: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, String> {
        let mut votes: BTreeMap<&str, usize> = BTreeMap::new();
        for name in stored.clone() {
            for (prefix, rest) in divisions(name) {
                if own(&plain(rest)).is_some() {
                    *votes.entry(prefix).or_default() += 1;
                }
            }
        }
        let prefix = elect(&votes, total)?;
        let mut names = Self::default();
        for name in stored {
            let Some(rest) = name.strip_prefix(prefix) else {
                names.elsewhere.push(name.to_owned());
                continue;
            };
            let plain = plain(rest);
            let (own, known) = match own(&plain) {
                Some(own) => (own, &mut names.found),
                None => (plain, &mut names.unknown),
            };
            if let Some(other) = known.insert(own, name.to_owned()) {
                return Err(format!("{other} and {name} are one tensor of the model"));
            }
        }
        Ok(names)
    }
}

/// The prefix that most tensors of the model have in the file, if more than half of them have it; the empty one else.
fn elect<'a>(votes: &BTreeMap<&'a str, usize>, total: usize) -> Result<&'a str, String> {
    let most = votes.values().copied().max().unwrap_or(0);
    if 2 * most <= total {
        return Ok("");
    }
    let rank = |prefix: &str| match prefix.split_once('.') {
        None => 0,
        Some((first, _)) => {
            let place = PREFERRED.iter().position(|&known| known == first);
            1 + place.unwrap_or(PREFERRED.len())
        }
    };
    let places = votes.iter().filter(|&(_, &count)| count == most);
    let mut places: Vec<&str> = places.map(|(&prefix, _)| prefix).collect();
    places.sort_by_key(|prefix| rank(prefix));
    match places[..] {
        [first, second, ..] if rank(first) == rank(second) => Err(format!(
            "it holds the model's tensors more than once, below {}: keep one of them, or put it under {}",
            places.join(" and "),
            PREFERRED.join(", ")
        )),
        [first, ..] => Ok(first),
        [] => Ok(""),
    }
}

/// A name divided before each of its first segments but a wrapper's, which belongs to what comes before.
fn divisions(name: &str) -> impl Iterator<Item = (&str, &str)> {
    let dots = name.match_indices('.').map(|(at, _)| at + 1);
    std::iter::once(0)
        .chain(dots)
        .take(LEVELS)
        .map(|at| name.split_at(at))
        .filter(|(_, rest)| !rest.split('.').next().is_some_and(is_wrapper))
}

fn is_wrapper(segment: &str) -> bool {
    WRAPPERS.contains(&segment)
}

/// A name without the wrappers of parts of a model, in today's spelling.
fn plain(name: &str) -> String {
    let segments: Vec<&str> = name.split('.').filter(|s| !is_wrapper(s)).collect();
    let joined = segments.join(".");
    RENAMED
        .iter()
        .fold(joined, |name, (old, new)| name.replace(old, new))
}

/// Joins names; of a long list some.
pub(super) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 8;
    match names.len().saturating_sub(SHOWN) {
        0 => names.join(", "),
        more => format!("{} and {more} more", names[..SHOWN].join(", ")),
    }
}
