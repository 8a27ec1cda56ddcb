#![allow(clippy::unwrap_used)]

use std::sync::mpsc;

use orienteer_runtime::geometry::Limits;

use super::*;

struct Witness {
    platform: Platform,
    told: mpsc::Sender<(Instant, Twist)>,
}

impl BaseDriver for Witness {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        Ok(Odometry { stamp: now, ..Odometry::default() })
    }

    fn command(&mut self, _now: Time, twist: Twist) -> Result<(), DriverError> {
        let deaf = |_| DriverError::Refused { what: "nobody listens".into() };
        self.told.send((Instant::now(), twist)).map_err(deaf)
    }

    fn stop(&mut self) {
        let _ = self.told.send((Instant::now(), Twist::STOP));
    }
}

fn platform() -> Platform {
    Platform {
        name: "witness".into(),
        radius: 0.3,
        limits: Limits::NONE,
        acceleration: 1.0,
        angular_acceleration: 1.0,
        turning_radius: 0.0,
    }
}

/// A base whose commands hold until a time, and what it is told.
fn guarded(period: Duration, until: Time) -> (Guarded, mpsc::Receiver<(Instant, Twist)>) {
    let (told, hears) = mpsc::channel();
    let platform = platform();
    let base = Guarded::new(Box::new(Witness { platform, told }), "test", period).unwrap();
    base.guard().hold_until(until);
    (base, hears)
}

#[test]
fn a_command_that_is_not_renewed_is_replaced_by_a_stop_even_if_its_giver_sleeps() {
    let period = Duration::from_millis(50);
    let (mut base, hears) = guarded(period, Time::FAR);
    let given = Instant::now();
    base.command(Time::START, Twist::new(0.5, 0.0)).unwrap();
    thread::sleep(Duration::from_millis(300));
    drop(base);
    let told: Vec<_> = hears.try_iter().collect();
    let last_moving = told.iter().filter(|(_, twist)| !twist.is_stop()).map(|(when, _)| *when).max().unwrap();
    let stopped = told.iter().find(|(when, twist)| *when > last_moving && twist.is_stop()).unwrap().0;
    // A machine that stalls can only make the stop later than this; the order of events is what is checked.
    assert!(last_moving.duration_since(given) <= period + Duration::from_millis(10), "moved on after its time");
    assert!(stopped > last_moving && told.last().unwrap().1.is_stop());
}

#[test]
fn a_command_is_as_old_as_the_step_that_brings_it() {
    let (mut base, hears) = guarded(Duration::from_millis(50), Time::FAR);
    base.poll(Time::from_secs_f64(1.0)).unwrap();
    // A behaviour sleeps in this step, after another has claimed the base.
    thread::sleep(Duration::from_millis(100));
    base.command(Time::from_secs_f64(1.0), Twist::new(0.5, 0.0)).unwrap();
    thread::sleep(Duration::from_millis(30));
    drop(base);
    assert!(hears.try_iter().all(|(_, twist)| twist.is_stop()), "an old command was executed");
}

#[test]
fn a_command_never_outlives_the_decision_behind_it() {
    let (mut base, hears) = guarded(Duration::from_millis(500), Time::START);
    base.poll(Time::from_secs_f64(1.0)).unwrap();
    base.command(Time::from_secs_f64(1.0), Twist::new(0.5, 0.0)).unwrap();
    thread::sleep(Duration::from_millis(30));
    drop(base);
    let told: Vec<_> = hears.try_iter().collect();
    assert!(told.len() > 2 && told.iter().all(|(_, twist)| twist.is_stop()), "the decision was over before it came");
}

/// A base whose driver panics or refuses once it is told to move.
struct Faulty {
    witness: Witness,
    panics: bool,
    stops: mpsc::Sender<()>,
}

impl BaseDriver for Faulty {
    fn platform(&self) -> &Platform {
        self.witness.platform()
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.witness.poll(now)
    }

    fn command(&mut self, _now: Time, twist: Twist) -> Result<(), DriverError> {
        match twist.is_stop() {
            true => Ok(()),
            false if self.panics => std::panic::resume_unwind(Box::new("a bug")),
            false => Err(DriverError::Refused { what: "a broken axle".into() }),
        }
    }

    fn stop(&mut self) {
        let _ = self.stops.send(());
    }
}

#[test]
fn a_driver_that_panics_or_refuses_is_told_to_stop_and_its_node_hears_of_it() {
    for panics in [true, false] {
        let ((told, _hears), (stops, stopped)) = (mpsc::channel(), mpsc::channel());
        let faulty = Faulty { witness: Witness { platform: platform(), told }, panics, stops };
        let mut base = Guarded::new(Box::new(faulty), "test", Duration::from_millis(50)).unwrap();
        base.guard().hold_until(Time::FAR);
        base.poll(Time::from_secs_f64(1.0)).unwrap();
        base.command(Time::from_secs_f64(1.0), Twist::new(0.5, 0.0)).unwrap();
        stopped.recv_timeout(Duration::from_secs(10)).unwrap();
        thread::sleep(Duration::from_millis(30));
        let heard = (base.poll(Time::from_secs_f64(1.05)), base.command(Time::from_secs_f64(1.05), Twist::STOP));
        match panics {
            true => assert!(matches!(heard.0, Err(DriverError::LinkLost { .. })), "{heard:?}"),
            false => assert!(matches!(heard.1, Err(DriverError::Refused { .. })), "{heard:?}"),
        }
    }
}
