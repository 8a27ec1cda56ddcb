#![allow(missing_docs)]
pub mod echo;
pub mod rings;

pub mod world;
