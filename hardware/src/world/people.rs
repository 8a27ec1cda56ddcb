//! People who walk about.
//!
//! A person is an upright cylinder that follows straight legs between waypoints at constant speed, turns on the spot, and
//! pauses where told. A courteous one looks at the strip of floor that the body will sweep: when a robot in it is nearer than
//! [`STOPS_SHORT`], the person stands until it is gone. Others walk on as if no robot were there. People don't mind each
//! other: two who meet pass through one another.

use nalgebra::{Point2, Vector2};
use orienteer_runtime::random::Streams;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::{
    build,
    disc_grid::DiscGrid,
    geometry::Disc,
    plan::{Courtesy, Loop, Person},
};

/// Gap between the surfaces at which a courteous person stops, m.
pub const STOPS_SHORT: f64 = 0.5;
/// Who has stopped goes on when the gap has grown by this, m.
const HYSTERESIS: f64 = 0.1;
/// Room that a person wants on either side, m.
const ELBOW_ROOM: f64 = 0.1;

/// A moving body at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Its cross-section.
    pub disc: Disc,
    /// Its mean velocity over the last step, m/s.
    pub velocity: Vector2<f64>,
}

/// Everybody who walks about in a world.
#[derive(Debug, Clone)]
pub struct People {
    walkers: Vec<Walker>,
    bodies: Vec<Body>,
}

impl People {
    /// The people of a [`World`](super::World) at the start of a run. Each draws random numbers from a stream of its own, `("world", "person
    /// <number>")`.
    #[must_use]
    pub fn new(people: &[Person], streams: &Streams) -> Self {
        let seeded = |(i, person)| Walker::new(person, i, streams.stream("world", &format!("person {}", i + 1)));
        let walkers: Vec<Walker> = people.iter().enumerate().map(seeded).collect();
        let bodies = walkers.iter().map(|w| Body { disc: w.disc(), velocity: Vector2::zeros() }).collect();
        Self { walkers, bodies }
    }

    /// Lets `dt` seconds pass among these robots. A `dt` that is not positive changes nothing.
    pub fn advance(&mut self, dt: f64, robots: &DiscGrid) {
        if !(dt > 0.0 && dt.is_finite()) {
            return;
        }
        for (walker, body) in self.walkers.iter_mut().zip(&mut self.bodies) {
            let before = walker.position();
            walker.advance(dt, robots);
            *body = Body { disc: walker.disc(), velocity: (walker.position() - before) / dt };
        }
    }

    /// Where everybody is, in the order of the plan.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Their names, in the same order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.walkers.iter().map(|w| w.name.as_str())
    }
}

#[derive(Debug, Clone)]
struct Walker {
    name: String,
    radius: f64,
    path: Vec<Point2<f64>>,
    looping: Loop,
    usual_speed: f64,
    /// Standard deviation of the speed as a share of the usual one, if it varies.
    variation: Option<Normal<f64>>,
    pause: f64,
    courtesy: Courtesy,
    patience: Option<f64>,
    random: Pcg64,

    /// Indices of the waypoints between which the person is.
    from: usize,
    to: usize,
    /// True if the waypoints are visited in the order written.
    forward: bool,
    /// Distance walked since `from`, m.
    walked: f64,
    speed: f64,
    /// What is left of a pause, s.
    pausing: f64,
    /// How long a robot has been in the way, s.
    waiting: f64,
}

impl Walker {
    fn new(person: &Person, index: usize, random: Pcg64) -> Self {
        let mut walker = Self {
            name: person.name.clone().unwrap_or_else(|| format!("person {}", index + 1)),
            radius: person.radius,
            path: build::points(&person.path),
            looping: person.looping,
            usual_speed: person.speed,
            variation: Normal::new(0.0, person.speed_variation).ok().filter(|_| person.speed_variation > 0.0),
            pause: person.pause,
            courtesy: person.courtesy,
            patience: person.patience,
            random,
            from: 0,
            to: 0,
            forward: true,
            walked: 0.0,
            speed: person.speed,
            pausing: 0.0,
            waiting: 0.0,
        };
        if walker.path.is_empty() {
            walker.path.push(Point2::origin());
        }
        walker.to = walker.after(0);
        walker.start_at(person.start);
        walker.draw_speed();
        walker
    }

    fn start_at(&mut self, start: f64) {
        let once: f64 = self.path.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let round = match (self.looping, self.path.first(), self.path.last()) {
            (Loop::Round, Some(first), Some(last)) => once + (first - last).norm(),
            _ => 2.0 * once,
        };
        if round <= 0.0 {
            return;
        }
        self.walked = start % round;
        // One round passes each leg at most twice.
        for _ in 0..2 * self.path.len() {
            let leg = self.leg().norm();
            if self.walked < leg {
                break;
            }
            self.walked -= leg;
            self.next_leg();
        }
    }

    /// The waypoint that follows `to` in the present direction; a single waypoint follows itself.
    fn after(&mut self, to: usize) -> usize {
        let last = self.path.len() - 1;
        match self.looping {
            _ if last == 0 => 0,
            Loop::Round if self.forward => (to + 1) % (last + 1),
            Loop::Round => (to + last) % (last + 1),
            Loop::BackAndForth => {
                if (self.forward && to == last) || (!self.forward && to == 0) {
                    self.forward = !self.forward;
                }
                if self.forward { to + 1 } else { to - 1 }
            }
        }
    }

    fn next_leg(&mut self) {
        self.from = self.to;
        self.to = self.after(self.to);
    }

    fn turn_round(&mut self) {
        self.walked = self.leg().norm() - self.walked;
        std::mem::swap(&mut self.from, &mut self.to);
        self.forward = !self.forward;
    }

    fn draw_speed(&mut self) {
        let Some(variation) = self.variation else { return };
        // Three standard deviations of at most 0.3 leave a tenth of the speed.
        let share = variation.sample(&mut self.random).clamp(-3.0 * variation.std_dev(), 3.0 * variation.std_dev());
        self.speed = self.usual_speed * (1.0 + share);
    }

    fn leg(&self) -> Vector2<f64> {
        self.path[self.to] - self.path[self.from]
    }

    fn direction(&self) -> Vector2<f64> {
        self.leg().try_normalize(0.0).unwrap_or_else(Vector2::zeros)
    }

    fn position(&self) -> Point2<f64> {
        self.path[self.from] + self.direction() * self.walked
    }

    fn disc(&self) -> Disc {
        Disc::new(self.position(), self.radius)
    }

    fn advance(&mut self, dt: f64, robots: &DiscGrid) {
        if self.path.len() < 2 || self.speed <= 0.0 {
            return;
        }
        let mut left = dt;
        // A step has no more legs than this; worlds refuse paths whose waypoints coincide, other callers might not.
        let mut legs = 10_000;
        while left > 0.0 && legs > 0 {
            legs -= 1;
            if self.pausing > 0.0 {
                let pause = self.pausing.min(left);
                self.pausing -= pause;
                left -= pause;
                continue;
            }
            let to_waypoint = self.leg().norm() - self.walked;
            let free = self.free_ahead(robots, to_waypoint.min(self.speed * left));
            if self.speed * left < to_waypoint.min(free) {
                self.walked += self.speed * left;
                self.waiting = 0.0;
                return;
            }
            if to_waypoint <= free {
                left -= to_waypoint / self.speed;
                self.arrive();
            } else {
                self.walked += free;
                self.wait(left - free / self.speed);
                return;
            }
        }
    }

    fn arrive(&mut self) {
        self.walked = 0.0;
        self.waiting = 0.0;
        self.pausing = self.pause;
        self.next_leg();
        self.draw_speed();
    }

    /// Stands for so many seconds, and turns round when patience ends; walking back begins with the next step.
    fn wait(&mut self, seconds: f64) {
        // Even the instant of stopping counts as waiting, or the larger gap would not be asked for.
        self.waiting += seconds.max(f64::MIN_POSITIVE);
        if self.patience.is_some_and(|patience| self.waiting >= patience) {
            self.waiting = 0.0;
            self.turn_round();
        }
    }

    /// How far the person can walk before a robot is too near, m. Robots that are none within `distance` don't count.
    fn free_ahead(&self, robots: &DiscGrid, distance: f64) -> f64 {
        if self.courtesy == Courtesy::Ignores {
            return f64::INFINITY;
        }
        let (position, direction) = (self.position(), self.direction());
        let gap = STOPS_SHORT + if self.waiting > 0.0 { HYSTERESIS } else { 0.0 };
        let mut free = f64::INFINITY;
        // Length and half the width of the strip in which a robot stops the person, but for the robot's own radius: each adds
        // that once, and once is in the query already.
        let (length, width) = (self.radius + gap + distance, self.radius + ELBOW_ROOM);
        robots.each_near(position, length + width + robots.largest_radius(), |_, robot| {
            let to = robot.center - position;
            let (ahead, aside) = (direction.dot(&to), direction.perp(&to).abs());
            let reach = self.radius + robot.radius;
            if ahead > 0.0 && aside < reach + ELBOW_ROOM {
                free = free.min((ahead - reach - gap).max(0.0));
            }
        });
        free
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use proptest::prelude::*;

    use super::*;
    use crate::world::plan::WorldPlan;

    fn people(toml: &str) -> People {
        People::new(&WorldPlan::parse(toml).unwrap().person, &Streams::new(1))
    }

    fn among(robots: &[Disc]) -> DiscGrid {
        let mut grid = DiscGrid::default();
        grid.arrange(robots.iter().copied());
        grid
    }

    fn walk(people: &mut People, seconds: f64, dt: f64, robots: &[Disc]) {
        let robots = among(robots);
        for _ in 0..(seconds / dt).round() as usize {
            people.advance(dt, &robots);
        }
    }

    fn at(people: &People) -> Point2<f64> {
        people.bodies()[0].disc.center
    }

    #[test]
    fn back_and_forth_with_pauses() {
        let mut crowd = people("[[person]]\npath = [[0, 0], [4, 0]]\nspeed = 1.0\npause = 2.0");
        walk(&mut crowd, 3.0, 0.1, &[]);
        assert!((at(&crowd) - Point2::new(3.0, 0.0)).norm() < 1e-9);
        assert!((crowd.bodies()[0].velocity - Vector2::new(1.0, 0.0)).norm() < 1e-9);
        walk(&mut crowd, 2.0, 0.1, &[]);
        assert!((at(&crowd) - Point2::new(4.0, 0.0)).norm() < 1e-9);
        walk(&mut crowd, 2.0, 0.1, &[]);
        assert!((at(&crowd) - Point2::new(3.0, 0.0)).norm() < 1e-9, "{:?}", at(&crowd));
    }

    #[test]
    fn a_round_ends_where_it_began() {
        let mut crowd = people("[[person]]\npath = [[0, 0], [3, 0], [3, 4]]\nspeed = 0.5\nloop = \"round\"\nstart = 12.5");
        assert!((at(&crowd) - Point2::new(0.5, 0.0)).norm() < 1e-9, "12 m is one round: {:?}", at(&crowd));
        walk(&mut crowd, 24.0, 0.01, &[]);
        assert!((at(&crowd) - Point2::new(0.5, 0.0)).norm() < 1e-6);
    }

    #[test]
    fn a_courteous_person_stops_half_a_metre_short_and_goes_on_when_the_way_is_free() {
        let mut crowd = people("[[person]]\npath = [[0, 0], [10, 0]]\nspeed = 1.3");
        let robot = Disc::new(Point2::new(5.0, 0.3), 0.25);
        walk(&mut crowd, 20.0, 0.05, &[robot]);
        assert!((at(&crowd).x - 4.0).abs() < 1e-9, "{:?}", at(&crowd));
        assert_eq!(crowd.bodies()[0].velocity, Vector2::zeros());
        let aside = Disc::new(Point2::new(5.0, 0.7), 0.25);
        walk(&mut crowd, 1.0, 0.05, &[aside]);
        assert!((at(&crowd).x - 5.3).abs() < 1e-9, "{:?}", at(&crowd));
    }

    #[test]
    fn patience_ends() {
        let mut crowd = people("[[person]]\npath = [[0, 0], [10, 0]]\nspeed = 1.0\npatience = 3.0");
        let robot = Disc::new(Point2::new(5.0, 0.0), 0.25);
        walk(&mut crowd, 6.9, 0.1, &[robot]);
        assert!((at(&crowd).x - 4.0).abs() < 1e-9);
        walk(&mut crowd, 2.0, 0.1, &[robot]);
        assert!(at(&crowd).x < 3.0 && crowd.bodies()[0].velocity.x < 0.0);
    }

    #[test]
    fn who_ignores_walks_on() {
        let mut crowd = people("[[person]]\npath = [[0, 0], [10, 0]]\nspeed = 1.0\ncourtesy = \"ignores\"");
        walk(&mut crowd, 6.0, 0.1, &[Disc::new(Point2::new(5.0, 0.0), 0.25)]);
        assert!((at(&crowd).x - 6.0).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn steps_of_any_length_lead_to_the_same_place(
            seed in 0..1000u64, cuts in proptest::collection::vec(0.01..3.0f64, 1..40)
        ) {
            let text = "[[person]]\npath = [[0, 0], [2, 0], [2, 1]]\nspeed = 0.9\nspeed_variation = 0.2\npause = 0.4";
            let person = WorldPlan::parse(text).unwrap().person;
            let mut fine = People::new(&person, &Streams::new(seed));
            let mut coarse = fine.clone();
            coarse.advance(cuts.iter().sum(), &among(&[]));
            cuts.iter().for_each(|dt| fine.advance(*dt, &among(&[])));
            prop_assert!((at(&fine) - at(&coarse)).norm() < 1e-9);
        }

        #[test]
        fn a_courteous_person_never_walks_into_a_robot_that_stands(
            x in 0.0..8.0f64, y in -1.0..1.0f64, radius in 0.1..0.5f64, dt in 0.01..0.5f64
        ) {
            let mut crowd = people("[[person]]\npath = [[-2, 0], [10, 0]]\nspeed = 1.2");
            let robot = Disc::new(Point2::new(x, y), radius);
            let robots = among(&[robot]);
            for _ in 0..100 {
                crowd.advance(dt, &robots);
                prop_assert!((at(&crowd) - robot.center).norm() >= radius + 0.25 - 1e-9);
            }
        }
    }
}
