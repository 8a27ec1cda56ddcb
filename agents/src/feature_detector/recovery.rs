//! What a detector does when somebody comes between (Randazza 1989, §6.2 asks for it).
//!
//! A part of a manoeuvre (a turn, a stretch along a wall, a look around) that is cut short begins again: the robot waits until the base is free, goes back to
//! where the part began, and does it once more. So somebody who walks past costs time, and not the whole detector. If it happens too often, the detector ends.

use std::{cell::Cell, future::poll_fn, pin::pin, time::Duration};

use orienteer_runtime::{
    agent::{Aborted, Pilot},
    geometry::Pose,
    time::Time,
    topics::BaseDecision,
};

/// Somebody who came between is given so long to go on.
const GIVE_WAY: Duration = Duration::from_secs(3);
/// Somebody who stands in the way is given so long.
const WAIT: Duration = Duration::from_secs(18);
/// So often it tries to get back to where a part began.
const RETURNS: u32 = 8;
/// Whoever came between so lately may be what is in the way now.
const LATELY: Duration = Duration::from_secs(120);

/// How often a detector may still begin a part again.
#[derive(Debug)]
pub(super) struct Recovery {
    overrides: Cell<u32>,
    waits: Cell<u32>,
}

/// When somebody last came between, for all detectors of a robot.
pub(super) type LastOverride = Cell<Option<Time>>;

/// True if somebody came between since a detector `began`, or so soon before it was `blocked` that they may be what stands there.
pub(super) fn is_disturbed(last: &LastOverride, began: Time, now: Time, blocked: bool) -> bool {
    last.get().is_some_and(|last| last >= began || (blocked && now.since(last) < LATELY))
}

/// Waits for this; also says whether more than one client had the base meanwhile. Who does not hold the base does not notice that somebody
/// drives it on.
pub(super) async fn watched<T>(pilot: &Pilot, detection: impl Future<Output = T>) -> (T, bool) {
    let (mut detection, mut holder, mut shared) = (pin!(detection), None, false);
    let ended = poll_fn(|context| {
        if let Some(now) = pilot.latest::<BaseDecision>().and_then(|decision| decision.holder.known()) {
            shared |= *holder.get_or_insert(now) != now;
        }
        detection.as_mut().poll(context)
    });
    (ended.await, shared)
}

impl Recovery {
    /// After so many overrides the detector ends.
    pub fn new(overrides: u32) -> Self {
        Self { overrides: Cell::new(overrides), waits: Cell::new(1) }
    }

    /// True if a part that ended so may begin again.
    fn may_go_on(&self, why: Aborted, now: Time, last: &LastOverride) -> bool {
        let take = |left: &Cell<u32>| left.get().checked_sub(1).inspect(|rest| left.set(*rest)).is_some();
        match why {
            Aborted::Overridden { .. } => {
                last.set(Some(now));
                take(&self.overrides)
            }
            // A wall does not go away; somebody may.
            Aborted::Blocked => take(&self.waits),
            Aborted::Busy | Aborted::Lapsed | Aborted::TimedOut => false,
        }
    }

    /// Carries out a part that begins at `start`, once more whenever somebody came between. `speed` is in m/s, `rate` in rad/s.
    pub async fn undisturbed<T>(
        &self,
        pilot: &Pilot,
        last: &LastOverride,
        start: Pose,
        (speed, rate): (f64, f64),
        part: impl AsyncFn() -> Result<T, Aborted>,
    ) -> Result<T, Aborted> {
        loop {
            let why = match part().await {
                Ok(done) => return Ok(done),
                Err(why) => why,
            };
            if !self.may_go_on(why, pilot.now(), last) {
                return Err(why);
            }
            pilot.release();
            if why == Aborted::Blocked {
                pilot.sleep(WAIT).await?;
            }
            return_to(pilot, start, speed, rate).await?;
        }
    }
}

async fn return_to(pilot: &Pilot, start: Pose, speed: f64, rate: f64) -> Result<(), Aborted> {
    let mut ended = Ok(());
    for _ in 0..RETURNS {
        pilot.release();
        pilot.sleep(GIVE_WAY).await?;
        ended = async {
            pilot.go(start.point(), speed, rate).await?;
            pilot.face(start.heading, rate).await
        }
        .await;
        if ended.is_ok() {
            break;
        }
    }
    ended
}
