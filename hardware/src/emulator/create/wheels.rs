//! The wheels of a Create: what they were told.

use orienteer_runtime::geometry::Twist;

use crate::wire::oi::command::{Command, STRAIGHT, TOP_SPEED};

/// The greatest duty of a motor.
const FULL_DUTY: i16 = 255;
/// The greatest radius, mm.
const WIDEST: i16 = 2000;

/// Two wheels and what they were told.
#[derive(Debug, Clone)]
pub(super) struct Wheels {
    /// Distance between them, m.
    tread: f64,
    /// mm/s.
    right: i16,
    /// mm/s.
    left: i16,
    /// Velocity and radius of the last Drive.
    circle: (i16, i16),
}

impl Wheels {
    /// Wheels that stand, so far apart, m.
    pub fn new(tread: f64) -> Self {
        Self { tread, right: 0, left: 0, circle: (0, 0) }
    }

    pub fn stand(&mut self) {
        (self.right, self.left, self.circle) = (0, 0, (0, 0));
    }

    /// What the right and the left one were told, mm/s.
    pub fn speeds(&self) -> (i16, i16) {
        (self.right, self.left)
    }

    /// Velocity, mm/s, and radius, mm, of the last Drive.
    pub fn circle(&self) -> (i16, i16) {
        self.circle
    }

    /// Does what a command says, if it is one for wheels.
    pub fn obey(&mut self, command: Command<'_>) {
        let top = |speed: i16| speed.clamp(-TOP_SPEED, TOP_SPEED);
        match command {
            Command::DriveDirect { right, left } => (self.right, self.left) = (top(right), top(left)),
            Command::DrivePwm { right, left } => {
                // On a level floor, about.
                let speed = |duty: i16| {
                    let share = f64::from(duty.clamp(-FULL_DUTY, FULL_DUTY)) / f64::from(FULL_DUTY);
                    rounded(share * f64::from(TOP_SPEED))
                };
                (self.right, self.left) = (speed(right), speed(left));
            }
            Command::Drive { velocity, radius } => self.go_round(top(velocity), radius),
            _ => {}
        }
    }

    fn go_round(&mut self, velocity: i16, radius: i16) {
        self.circle = (velocity, radius);
        let half = self.tread * 500.0;
        let (right, left) = match radius {
            // 32767 and -32768 are both in use.
            i16::MAX | STRAIGHT | 0 => (1.0, 1.0),
            1 => (1.0, -1.0),
            -1 => (-1.0, 1.0),
            radius => {
                let radius = f64::from(radius.clamp(-WIDEST, WIDEST));
                (1.0 + half / radius, 1.0 - half / radius)
            }
        };
        let speed = |share: f64| rounded(f64::from(velocity) * share);
        (self.right, self.left) = (speed(right), speed(left));
    }

    /// How a body moves on these wheels.
    pub fn twist(&self) -> Twist {
        let (right, left) = (f64::from(self.right) / 1000.0, f64::from(self.left) / 1000.0);
        Twist::new((right + left) / 2.0, (right - left) / self.tread)
    }
}

/// A speed that a wheel can have, mm/s.
#[allow(clippy::cast_possible_truncation)]
fn rounded(speed: f64) -> i16 {
    speed.clamp((-TOP_SPEED).into(), TOP_SPEED.into()).round() as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(command: Command<'_>) -> (i16, i16) {
        let mut wheels = Wheels::new(0.235);
        wheels.obey(command);
        wheels.speeds()
    }

    #[test]
    fn circles_are_those_of_the_specification() {
        let drive = |velocity, radius| told(Command::Drive { velocity, radius });
        assert_eq!([drive(200, STRAIGHT), drive(200, i16::MAX)], [(200, 200); 2]);
        assert_eq!([drive(200, 1), drive(200, -1)], [(200, -200), (-200, 200)]);
        // To the left the right wheel goes the longer way.
        assert_eq!(drive(200, 500), (247, 153));
        assert_eq!(drive(-200, -500), (-153, -247));
        assert_eq!(drive(9999, 100), (500, -88));
    }

    #[test]
    fn what_is_too_fast_goes_as_fast_as_it_can() {
        assert_eq!(told(Command::DriveDirect { right: 501, left: i16::MIN }), (500, -500));
        assert_eq!(told(Command::DrivePwm { right: 255, left: -9999 }), (500, -500));
        assert_eq!(told(Command::DrivePwm { right: 0, left: 50 }), (0, 98));
    }
}
