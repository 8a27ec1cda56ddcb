//! Tells a mission that the hardware lives, and people whether a mission does.

use std::time::Duration;

use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Level, Outputs, Phase, Wiring},
    clock::Epoch,
    time::Time,
    topics::{Fingerprint, HardwareState, MissionPulse},
};

/// A mission that says nothing for so long is gone.
const SILENCE: Duration = Duration::from_millis(500);
/// A mission that has not come is given so long before anybody hears of it.
const PATIENCE: Duration = Duration::from_secs(1);
/// Of so many samples it is known when they were sent.
const REMEMBERED: usize = 64;

/// The hardware's word that it lives, and what it hears of the mission: in the sense phase, when it says so, and in the act phase, to
/// which the mission's answer may have come.
pub struct Presence {
    epoch: Epoch,
    fingerprint: Fingerprint,
    seq: u64,
    /// When the last samples were sent, by their number.
    sent: [Time; REMEMBERED],
    pulse: Option<MissionPulse>,
    /// When it came.
    came: Time,
    heard: u64,
    lost: u64,
    answered: u64,
    round_trip: f64,
    /// Whether a mission drives, as far as people have been told.
    driven: Option<bool>,
}

impl Presence {
    /// Of hardware whose time begins at this epoch, and whose configuration has this [fingerprint](super::fingerprint).
    #[must_use]
    pub fn new(epoch: Epoch, fingerprint: Fingerprint) -> Self {
        Self {
            epoch,
            fingerprint,
            seq: 0,
            sent: [Time::START; REMEMBERED],
            pulse: None,
            came: Time::START,
            heard: 0,
            lost: 0,
            answered: 0,
            round_trip: -1.0,
            driven: None,
        }
    }

    /// The topics that it reads and writes.
    #[must_use]
    pub fn wiring() -> Wiring {
        let mut wiring = Wiring::default();
        wiring.reads::<MissionPulse>().writes::<HardwareState>();
        wiring
    }

    fn hear(&mut self, now: Time, pulse: &MissionPulse) {
        self.heard += 1;
        // A mission that begins anew counts anew.
        let last = self.pulse.filter(|last| pulse.seq > last.seq).map_or(pulse.seq.saturating_sub(1), |last| last.seq);
        self.lost = self.lost.saturating_add(pulse.seq.saturating_sub(last + 1));
        let is_new = self.pulse.is_none_or(|last| last.echo != pulse.echo);
        if is_new && pulse.echo > 0 && self.seq.checked_sub(pulse.echo).is_some_and(|ago| ago < REMEMBERED as u64) {
            self.round_trip = now.secs_since(self.sent[(pulse.echo % REMEMBERED as u64) as usize]);
        }
        self.answered += u64::from(is_new && pulse.echo == self.seq);
        (self.pulse, self.came) = (Some(*pulse), now);
    }
}

impl Behaviour for Presence {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        for pulse in inputs.each::<MissionPulse>() {
            self.hear(now, pulse);
        }
        if inputs.phase != Phase::Sense {
            return;
        }
        let driven = self.pulse.is_some() && now.since(self.came) < SILENCE;
        let text = match (self.driven, driven) {
            (None | Some(false), true) => Some((Level::INFO, "a mission drives")),
            (Some(true), false) => Some((Level::WARN, "the mission is gone; waiting for one")),
            (None, false) if now >= Time::START + PATIENCE => {
                Some((Level::WARN, "waiting for a mission: `orienteer run` with this configuration"))
            }
            _ => None,
        };
        if let Some((level, text)) = text {
            self.driven = Some(driven);
            out.log(level, text);
        }
        let Some(epoch) = self.epoch.nanos() else { return };
        self.seq += 1;
        self.sent[(self.seq % REMEMBERED as u64) as usize] = now;
        out.publish(HardwareState {
            stamp: now,
            epoch,
            seq: self.seq,
            age: self.pulse.map_or(-1.0, |pulse| now.secs_since(pulse.stamp)),
            round_trip: self.round_trip,
            heard: self.heard,
            lost: self.lost,
            answered: self.answered,
            fingerprint: self.fingerprint,
        });
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("pulses_heard", self.heard as f64);
        last_words.fact("pulses_lost", self.lost as f64);
        last_words.fact("answered", self.answered as f64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_are_missing_are_counted_whatever_their_numbers_are() {
        let mut presence = Presence::new(Epoch::default(), Fingerprint::default());
        let mut lost_after = |seq| {
            presence.hear(Time::START, &MissionPulse { stamp: Time::START, seq, echo: u64::MAX });
            presence.lost
        };
        // One in order, two that are missing, a mission that begins anew, one in order.
        assert_eq!([1, 2, 5, 1, 2].map(&mut lost_after), [0, 0, 2, 2, 2]);
        // Nobody who means well has such numbers.
        assert_eq!([u64::MAX, 0, u64::MAX].map(lost_after), [u64::MAX - 1, u64::MAX - 1, u64::MAX]);
    }
}
