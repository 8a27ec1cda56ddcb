//! What every family of bases has in common when it is spoken to.

use orienteer_runtime::{geometry::Twist, time::Time, topics::Odometry};

use crate::wire::{Counts, PacketError};

/// How far a conversation has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The base has not answered.
    Unanswered,
    /// It has, and has not said where it is.
    Answered,
    /// It says where it is, and obeys.
    Open,
}

/// A client's side of a conversation with a base: takes the bytes that have come, gives those that are to be sent, and is told the time.
pub trait Conversation {
    /// The language, as people call it.
    const LANGUAGE: &'static str;
    /// A base that speaks another one, and may be at the end of the line by mistake.
    const STRANGER: &'static str;

    /// Begins with the greeting: the line is a new one, and whoever is at its other end has heard nothing.
    fn begin_anew(&mut self);

    /// Takes in the bytes that have come until `now`.
    fn receive(&mut self, now: Time, bytes: &[u8]);

    /// Appends all that is to be sent at `now`.
    fn transmit(&mut self, now: Time, into: &mut Vec<u8>);

    /// Wants this velocity from `now` on; one that is not a number is a stop. One that nobody renews holds for no longer than a quarter of
    /// a second.
    fn drive(&mut self, now: Time, twist: Twist);

    /// Wants to stand, and appends what says so at once.
    fn halt(&mut self, into: &mut Vec<u8>);

    /// Appends what ends the conversation, if there is one, and goes back to its beginning.
    fn close(&mut self, into: &mut Vec<u8>);

    /// How far it has come.
    fn stage(&self) -> Stage;

    /// How often in a row the base was greeted and did not answer.
    fn unanswered(&self) -> u8;

    /// The newest odometry; `None` before the first.
    fn odometry(&self) -> Option<Odometry>;

    /// What came over the wire so far.
    fn counts(&self) -> Counts;

    /// What can't be understood of the newest packet that should have said where the base is, if that was so.
    fn parse_error(&self) -> Option<PacketError> {
        None
    }

    /// Why this base can't be driven, if it can't: words that follow its address, and what to do.
    fn refusal(&self) -> Option<String> {
        None
    }
}
