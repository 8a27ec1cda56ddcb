//! The `orienteer` command.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use orienteer::{Registry, cli};

fn main() -> ExitCode {
    cli::main(&Registry::standard())
}
