//! Commands of the runner, to be told to somebody.

/// The command that runs the runner.
const RUNNER: [&str; 2] = ["cargo", "xtask"];

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
    fn words_are_quoted_where_a_shell_needs_it() {
        assert_eq!(
            shown(["dataset", "--maps", "my maps", "it's"]),
            r"cargo xtask dataset --maps 'my maps' 'it'\''s'"
        );
    }
}
