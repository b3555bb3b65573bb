//! The program under test, run as a user types it.

use std::process::{Command, Output};

use crate::PROGRAM;

/// The words of a command line; what stands between single quotes is one, with its spaces.
pub fn words(line: &str) -> Vec<&str> {
    let parts = line.split('\'').enumerate();
    let words = parts.flat_map(|(i, part)| match i % 2 {
        0 => part.split_whitespace().collect::<Vec<_>>(),
        _ => vec![part],
    });
    words.collect()
}

/// The program with the words of a line.
pub fn run(line: &str) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(words(line)).output().expect("it starts")
}

/// Standard output of a run that must succeed.
#[track_caller]
pub fn succeed(line: &str) -> String {
    let output = run(line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let stdout = String::from_utf8(output.stdout).expect("output is text");
    assert!(output.status.success(), "{line}: {stderr}{stdout}");
    stdout
}

/// Standard error of a run that must succeed.
#[track_caller]
pub fn remarks(line: &str) -> String {
    let output = run(line);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {stderr}");
    stderr
}

/// Standard error of a run that must fail.
#[track_caller]
pub fn fail(line: &str) -> String {
    let output = run(line);
    assert!(!output.status.success(), "{line} succeeded");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Fails if a text lacks one of these parts.
#[track_caller]
pub fn assert_told(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "'{part}' is not in\n{text}");
    }
}
