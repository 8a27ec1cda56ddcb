//! What a behaviour calls: its own side of the arbitration.
//!
//! A [`BaseHandle`] keeps one client's part of the protocol, a [`SonarHandle`] the same for the sonar. They are as pure as the
//! arbiters: the host tells a handle what it has heard, lets the behaviour make its step, and publishes the claim that
//! comes out.
//!
//! ```text
//!   notices, decision, report ─▶ hear ─▶ behaviour's step: drive, translate, limit, … ─▶ claim ─▶ publish
//! ```
//!
//! # A dialogue
//!
//! ```
//! use std::time::Duration;
//! use orienteer_runtime::arbitration::{Clients, base::BaseArbiter, client::{BaseHandle, BaseState}};
//! use orienteer_runtime::geometry::{Limits, Twist};
//! use orienteer_runtime::time::Time;
//! use orienteer_runtime::topics::{BaseDecision, ClientId, Motion};
//!
//! let clients: Clients = [("follower", 5), ("avoidance", 10)].into_iter().collect();
//! let mut arbiter = BaseArbiter::new(&clients);
//! let mut follower = BaseHandle::new(ClientId(0));
//! let mut avoidance = BaseHandle::new(ClientId(1));
//!
//! // What a host does after the behaviours' steps: claims to the arbiter, its answers back to the handles.
//! let mut now = Time::START;
//! let mut settle = |follower: &mut BaseHandle, avoidance: &mut BaseHandle| -> BaseDecision {
//!     now = now + Duration::from_millis(50);
//!     let mut notices = Vec::new();
//!     for handle in [&mut *follower, &mut *avoidance] {
//!         arbiter.claim(&handle.claim(now, Duration::from_millis(120)));
//!     }
//!     let decision = arbiter.decide(now, &mut notices);
//!     for handle in [follower, avoidance] {
//!         handle.hear(&notices, Some(&decision), None);
//!     }
//!     decision
//! };
//! let ahead = Twist::new(0.3, 0.0);
//! let back = Twist::new(-0.1, 0.0);
//!
//! // The follower drives; something comes near, and avoidance slows it down without taking the base.
//! follower.drive(ahead);
//! avoidance.limit(Limits { linear: 0.15, ..Limits::NONE });
//! let decision = settle(&mut follower, &mut avoidance);
//! assert_eq!(decision.limited_motion(), Motion::velocity(Twist::new(0.15, 0.0)));
//! assert_eq!(follower.state(), BaseState::Holding);
//!
//! // That is not enough: avoidance backs off. The follower hangs on, it has only to go on driving.
//! follower.drive(ahead);
//! avoidance.drive(back);
//! assert_eq!(settle(&mut follower, &mut avoidance).limited_motion(), Motion::velocity(back));
//! assert_eq!(follower.state(), BaseState::Overridden { by: ClientId(1) });
//! assert_eq!(follower.overrider_motion(), Motion::velocity(back));
//!
//! // Avoidance yields, and the follower has the base again.
//! follower.drive(ahead);
//! avoidance.release();
//! assert_eq!(settle(&mut follower, &mut avoidance).limited_motion(), Motion::velocity(ahead));
//!
//! // A holder that does not say so in every step does not drive.
//! assert_eq!(settle(&mut follower, &mut avoidance).motion, Motion::STOP);
//! assert_eq!(follower.state(), BaseState::Holding);
//! ```

mod base;
mod sonar;

pub use base::{BaseHandle, BaseState, MotionId, OnOverride};
pub use sonar::{SonarHandle, SonarState};
