//! What the tests of links share.
#![allow(dead_code, clippy::unwrap_used)] // No test uses all of it.

pub mod actors;

use std::path::{Path, PathBuf};

use iceoryx2::prelude::ZeroCopySend;
use orienteer_runtime::{
    link::{Backend, Bus, BusOptions, Subscriber},
    topics::Payload,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub const BACKENDS: [Backend; 3] = [Backend::Shared, Backend::Local, Backend::Direct];

/// A topic with one writer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("test::Reading.v1")]
pub struct Reading {
    pub writer: u32,
    pub value: u32,
}

impl Payload for Reading {
    const TOPIC: &'static str = "test/reading";
    const QUEUE: usize = 4;
}

/// A topic with many writers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("test::Claim.v1")]
pub struct Claim {
    pub writer: u32,
    pub value: u32,
}

impl Payload for Claim {
    const TOPIC: &'static str = "test/claims";
    const QUEUE: usize = 3;
    const MANY_WRITERS: bool = true;
}

/// The topic of [`Reading`] with another layout, as another version of the program would have it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("test::Reading.v2")]
pub struct NewReading {
    pub value: f64,
    pub quality: f64,
}

impl Payload for NewReading {
    const TOPIC: &'static str = "test/reading";
    const QUEUE: usize = 4;
}

/// A directory for runs that no other test uses, gone when dropped.
pub struct Root {
    directory: tempfile::TempDir,
}

impl Root {
    pub fn new() -> Self {
        let place = Path::new("/dev/shm");
        let place = if place.is_dir() { place.to_path_buf() } else { std::env::temp_dir() };
        Self { directory: tempfile::Builder::new().prefix("or-t-").tempdir_in(place).unwrap() }
    }

    /// The directory that runs are made in; it exists only while there are any.
    pub fn path(&self) -> PathBuf {
        self.directory.path().join("r")
    }

    pub fn options(&self, run: Option<&str>) -> BusOptions {
        BusOptions { run: run.map(str::to_owned), root: Some(self.path()) }
    }

    pub fn open(&self, backend: Backend) -> Bus {
        Bus::open(backend, &self.options(None)).unwrap()
    }

    /// The identifiers of the sessions in it.
    pub fn sessions(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.path())
            .into_iter()
            .flatten()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| !name.starts_with("run-"))
            .collect();
        names.sort();
        names
    }
}

/// The files in `/dev/shm` that belong to a session.
pub fn segments_of(session: &str) -> usize {
    let prefix = format!("or{session}_");
    std::fs::read_dir("/dev/shm")
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix))
        .count()
}

/// Sweeps what a process that the test has killed left behind.
impl Drop for Root {
    fn drop(&mut self) {
        if self.path().is_dir() {
            let _ = Bus::open(Backend::Shared, &self.options(None));
        }
    }
}

pub fn drained<P: Payload>(subscriber: &mut Subscriber<P>) -> Vec<P> {
    let mut samples = Vec::new();
    let count = subscriber.drain(|sample| samples.push(*sample));
    assert_eq!(count, samples.len());
    samples
}
