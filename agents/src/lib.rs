#![allow(missing_docs)]

pub mod certainty_grid;
pub mod mapper;
