//! The command line of this process, to be told to somebody.

pub use aps_report::command_line::{quoted, shown, words};

/// Returns this process's command without the named options and their values, and without the program that runs it.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_go_with_their_values() {
        let args = "dataset --out x --maps m --shard=1/2 --seed 4 --out=y";
        let kept = without(args.split(' ').map(Into::into), &["--out", "--shard"]);
        assert_eq!(kept, ["dataset", "--maps", "m", "--seed", "4"]);
    }
}
