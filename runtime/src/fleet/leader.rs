//! Another process that sets the beat.

use std::time::Duration;

use crate::link::{Bus, BusOptions, Doorbell, LinkError, Wake};

/// A leader that has not rung for so long is gone, and looked for.
const SILENCE: Duration = Duration::from_millis(500);

/// A robot of another run, in whose steps a fleet at wall time takes its own: as soon as that one has rung, and by its own clock if it
/// does not. So what is sensed there is answered at once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leader {
    /// The run.
    pub run: String,
    /// The robot in it.
    pub robot: String,
}

/// A leader's bell, and whether there is one.
pub(super) struct Beat {
    leader: Leader,
    doorbell: Option<Doorbell>,
    /// Nobody has rung for so long.
    silence: Duration,
}

impl Beat {
    pub fn of(leader: Leader) -> Self {
        Self { leader, doorbell: None, silence: SILENCE }
    }

    /// True if the leader has been heard of late.
    pub fn is_led(&self) -> bool {
        self.doorbell.is_some() && self.silence < SILENCE
    }

    /// Waits for a ring for as long as this; true if it came.
    pub async fn wait(&mut self, patience: Duration) -> bool {
        if self.silence >= SILENCE {
            // Nobody need hear why there is none: the nodes that stand in for its devices look for it, too.
            (self.doorbell, self.silence) = (self.open().ok(), Duration::ZERO);
        }
        let rung = match &mut self.doorbell {
            Some(doorbell) => {
                let rung = tokio::time::timeout(patience, doorbell.wait()).await;
                matches!(rung, Ok(Ok(Wake::Rung)))
            }
            None => {
                tokio::time::sleep(patience).await;
                false
            }
        };
        self.silence = if rung { Duration::ZERO } else { self.silence + patience };
        rung
    }

    fn open(&self) -> Result<Doorbell, LinkError> {
        let bus = Bus::attach(&self.leader.run, &BusOptions::default())?.robot(&self.leader.robot)?.open();
        Ok(bus.doorbell()?.of_the_owner())
    }
}
