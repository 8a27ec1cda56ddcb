//! What a node tells of its device's failures.

use std::time::Duration;

use orienteer_runtime::{
    agent::{Level, Outputs},
    time::Time,
};

use crate::driver::DriverError;

/// A device that is not there yet is given so long before anybody hears of it.
const PATIENCE: Duration = Duration::from_secs(1);

/// How a device's trouble ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ended {
    /// It had not been there before.
    There,
    /// It had.
    Back,
}

/// The failures of one device: each is told once, and its end once.
pub(crate) struct Trouble {
    device: &'static str,
    since: Option<Time>,
    told: Option<String>,
    /// It has not been there yet.
    waiting: bool,
}

impl Trouble {
    pub fn new(device: &'static str) -> Self {
        Self { device, since: None, told: None, waiting: false }
    }

    /// True from the first failure to its end.
    pub fn is_on(&self) -> bool {
        self.since.is_some()
    }

    /// The device has failed.
    pub fn happen(&mut self, now: Time, error: &DriverError, out: &mut Outputs) {
        let since = *self.since.get_or_insert(now);
        self.waiting = matches!(error, DriverError::Waiting { .. });
        if !self.waiting {
            if self.told.is_none() {
                out.log(Level::ERROR, format!("the {} fails: {error}", self.device));
                self.told = Some(String::new());
            }
        } else if now.since(since) >= PATIENCE {
            // The reasons are few, and each says something else to be done.
            let text = error.to_string();
            if self.told.as_ref() != Some(&text) {
                out.log(Level::WARN, format!("waiting for the {}: {text}", self.device));
                self.told = Some(text);
            }
        }
    }

    /// The device works.
    pub fn end(&mut self, out: &mut Outputs) -> Ended {
        self.since = None;
        let ended = if self.waiting { Ended::There } else { Ended::Back };
        if self.told.take().is_some() {
            let state = if self.waiting { "there" } else { "back" };
            out.log(Level::INFO, format!("the {} is {state}", self.device));
        }
        ended
    }

    /// What to say of it when all is over, if it is on.
    pub fn last_words(&self) -> Option<&'static str> {
        self.since.map(|_| if self.waiting { "it never was there" } else { "it had failed, and was not back at the end" })
    }
}
