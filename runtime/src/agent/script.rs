//! A manoeuvre as an `async fn`, polled once per step.

use std::{
    cell::RefCell,
    future::Future,
    pin::Pin,
    rc::Rc,
    task::{Context, Poll, Waker},
};

use super::{
    Inputs, Outputs, Wiring,
    pilot::{Aborted, Desk, Pilot},
};
use crate::time::Time;

/// A manoeuvre written as an `async fn` over a [`Pilot`].
///
/// A script is stepped like any behaviour: it is polled once per step, with what has come since the last. There are no
/// threads and no timers, so it is as deterministic as a state machine, and it can be tested without an actor.
///
/// ```
/// use orienteer_runtime::agent::{Inputs, Outputs, Script, Wiring};
/// use orienteer_runtime::{time::Time, topics::MotionKind};
///
/// let wiring = Wiring::default();
/// let mut script = Script::new(&wiring, |pilot| async move {
///     pilot.translate(0.5, 0.2).await?;
///     pilot.rotate(std::f64::consts::FRAC_PI_2, 0.5).await?;
///     Ok(())
/// });
/// let (inputs, mut out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
/// assert!(script.step(Time::START, &inputs, &mut out).is_none(), "it drives");
/// let claim = out.base.claim(Time::START, std::time::Duration::from_millis(100));
/// assert_eq!(claim.motion.kind(), MotionKind::Translate { distance: 0.5, speed: 0.2 });
/// ```
pub struct Script {
    desk: Rc<RefCell<Desk>>,
    course: Option<Pin<Box<dyn Future<Output = Result<(), Aborted>>>>>,
}

impl Script {
    /// A script that may look at the topics that `wiring` reads. It starts in the first step.
    pub fn new<F, C>(wiring: &Wiring, script: F) -> Self
    where
        F: FnOnce(Pilot) -> C,
        C: Future<Output = Result<(), Aborted>> + 'static,
    {
        let desk = Rc::new(RefCell::new(Desk::new(wiring)));
        let course: Pin<Box<dyn Future<Output = Result<(), Aborted>>>> = Box::pin(script(Pilot::new(desk.clone())));
        Self { desk, course: Some(course) }
    }

    /// Goes on to the script's next `await` that has to wait. Returns how it ended in the step in which it ends; the base is
    /// released then.
    pub fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) -> Option<Result<(), Aborted>> {
        let course = self.course.as_mut()?;
        self.desk.borrow_mut().open(now, inputs, &out.base);
        let polled = course.as_mut().poll(&mut Context::from_waker(Waker::noop()));
        let mut desk = self.desk.borrow_mut();
        if let Poll::Ready(end) = polled {
            desk.release();
            desk.close(out);
            drop(desk);
            self.course = None;
            return Some(end);
        }
        desk.close(out);
        None
    }

    /// True until the script has ended.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.course.is_some()
    }
}

impl std::fmt::Debug for Script {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Script").field("is_running", &self.is_running()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topics::{Odometry, Payload};

    #[test]
    fn a_topic_that_was_not_declared_is_reported_while_the_script_waits_for_it() {
        let wiring = Wiring::default();
        let mut script = Script::new(&wiring, |pilot| async move { pilot.next::<Odometry>().await.map(|_| ()) });
        let (inputs, mut out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
        for _ in 0..3 {
            assert!(script.step(Time::START, &inputs, &mut out).is_none());
        }
        assert_eq!(out.undeclared().news(), [Odometry::TOPIC]);
    }

    #[test]
    fn a_topic_that_was_declared_is_not() {
        let mut wiring = Wiring::default();
        wiring.reads::<Odometry>();
        let mut script = Script::new(&wiring, |pilot| async move { pilot.next::<Odometry>().await.map(|_| ()) });
        let (inputs, mut out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
        assert!(script.step(Time::START, &inputs, &mut out).is_none());
        assert!(script.step(Time::START, &inputs, &mut out).is_none());
        assert!(out.undeclared().news().is_empty());
    }
}
