//! What the tests of the command line share.
#![allow(dead_code, clippy::unwrap_used, missing_docs)]

use std::{
    path::{Path, PathBuf},
    process::Output,
};

use assert_cmd::Command;

/// The program, called in this directory.
pub fn orienteer(directory: &Path) -> Command {
    let mut command = Command::cargo_bin("orienteer").unwrap();
    command.current_dir(directory).env_remove("NO_COLOR");
    command
}

/// Runs the program and returns its exit code, standard output and standard error.
pub fn call(directory: &Path, arguments: &[&str]) -> (i32, String, String) {
    told(&orienteer(directory).args(arguments).output().unwrap())
}

pub fn told(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

/// Runs the built-in mission for some seconds and returns its recording.
pub fn record(directory: &Path, seconds: &str) -> PathBuf {
    let (code, _, errors) = call(directory, &["run", "--for", seconds]);
    assert_eq!(code, 0, "{errors}");
    directory.join("out/office-floor.mcap")
}

pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// No line is wider than a terminal; paths and hashes can't be broken.
pub fn fits(text: &str) {
    for line in text.lines() {
        assert!(line.chars().count() <= 80 || !line.contains("  "), "{} columns: {line}", line.chars().count());
    }
}
