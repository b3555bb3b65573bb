//! The command line of this process, to be told to somebody.

/// The command that runs the runner.
const RUNNER: [&str; 2] = ["cargo", "xtask"];

/// This process's command without the named options and their values, and without what ran it.
pub fn own_without(options: &[&str]) -> Vec<String> {
    let args = std::env::args_os().skip(1);
    without(args.map(|arg| arg.to_string_lossy().into_owned()), options)
}

fn without(args: impl Iterator<Item = String>, options: &[&str]) -> Vec<String> {
    let mut kept = Vec::new();
    let mut is_value = false;
    for arg in args {
        if std::mem::take(&mut is_value) {
            continue;
        }
        let name = arg.split('=').next().unwrap_or_default();
        match options.contains(&name) {
            true => is_value = !arg.contains('='),
            false => kept.push(arg),
        }
    }
    kept
}

/// A command of the runner as one would type it.
pub fn shown<S: AsRef<str>>(words: impl IntoIterator<Item = S>) -> String {
    format!("{} {}", RUNNER.join(" "), self::words(words))
}

/// Words as one would type them.
pub fn words<S: AsRef<str>>(words: impl IntoIterator<Item = S>) -> String {
    let words = words.into_iter().map(|word| quoted(word.as_ref()));
    words.collect::<Vec<_>>().join(" ")
}

/// A word as one would type it: in quotes where a shell needs them.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./,:=+@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_go_with_their_values() {
        let args = "dataset --out x --maps m --shard=1/2 --seed 4 --out=y";
        let kept = without(args.split(' ').map(Into::into), &["--out", "--shard"]);
        assert_eq!(kept, ["dataset", "--maps", "m", "--seed", "4"]);
    }

    #[test]
    fn words_are_quoted_where_a_shell_needs_it() {
        assert_eq!(
            shown(["dataset", "--maps", "my maps", "it's"]),
            r"cargo xtask dataset --maps 'my maps' 'it'\''s'"
        );
    }
}
