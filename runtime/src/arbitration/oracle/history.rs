//! Random histories of claims for the oracle.

use std::time::Duration;

use rand::{Rng, RngExt, seq::SliceRandom};

use crate::{
    arbitration::{Client, Clients},
    geometry::{Limits, Twist},
    time::Time,
    topics::{BaseClaim, ClientId, Motion},
};

/// The claims of one step, in the order in which they arrive, and the time of the decision that follows.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// When it is decided.
    pub now: Time,
    /// What has been claimed since the last step.
    pub claims: Vec<BaseClaim>,
}

/// All that an arbiter gets to see.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// The clients' priorities, in order.
    pub priorities: Vec<u8>,
    /// What happens.
    pub steps: Vec<Step>,
}

/// Times are multiples of this, so that deadlines, lapses and decisions often coincide.
const TICK: Duration = Duration::from_millis(10);

/// What a random client is about.
struct Mood {
    claim: BaseClaim,
    /// The highest number used yet.
    count: u32,
}

impl History {
    /// The clients, under names made up.
    #[must_use]
    pub fn clients(&self) -> Clients {
        let client = |(i, priority): (usize, &u8)| Client { name: format!("client {i}"), priority: *priority };
        Clients::new(self.priorities.iter().enumerate().map(client).collect())
    }

    /// One to six clients with few different priorities do what clients may do, and some of what they should not do.
    #[must_use]
    pub fn random(rng: &mut impl Rng) -> Self {
        let spread = rng.random_range(1..=6);
        let priorities: Vec<u8> = (0..rng.random_range(1..=6)).map(|_| rng.random_range(0..spread)).collect();
        let mood = |i: usize| Mood { claim: BaseClaim { client: ClientId(i as u16), ..BaseClaim::default() }, count: 0 };
        let mut moods: Vec<Mood> = (0..priorities.len()).map(mood).collect();
        // From no change at all in most steps to a change by everyone in nearly every step.
        let haste = rng.random_range(0.1..1.0);
        let mut now = Time::START;
        let mut steps = Vec::new();
        for _ in 0..rng.random_range(4..=40) {
            now = now + TICK * *pick(rng, &[1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 3, 0, 7]);
            let mut claims = Vec::new();
            for mood in &mut moods {
                while rng.random_bool(0.9) {
                    claims.push(mood.claim(now, haste, rng));
                    if rng.random_bool(0.9) {
                        break;
                    }
                }
            }
            claims.shuffle(rng);
            steps.push(Step { now, claims });
        }
        // Nobody says any more, so everybody must be out by then.
        steps.push(Step { now: now + Duration::from_secs(3600), claims: Vec::new() });
        Self { priorities, steps }
    }

    /// Histories with one step or one claim less.
    pub fn shorter(&self) -> impl Iterator<Item = History> + '_ {
        let without_step = |step: usize| {
            let mut history = self.clone();
            history.steps.remove(step);
            history
        };
        let without_claim = |step: usize, claim: usize| {
            let mut history = self.clone();
            history.steps[step].claims.remove(claim);
            history
        };
        let claims = |step: usize| (0..self.steps[step].claims.len()).map(move |claim| (step, claim));
        let steps = 0..self.steps.len();
        steps.clone().map(without_step).chain(steps.flat_map(claims).map(move |(step, claim)| without_claim(step, claim)))
    }
}

impl Mood {
    /// Perhaps changes its mind, and says what it wants.
    fn claim(&mut self, now: Time, haste: f64, rng: &mut impl Rng) -> BaseClaim {
        let maybe_over = self.claim.wait_until <= now || self.claim.valid_until <= now;
        self.claim.stamp = now;
        if maybe_over && rng.random_bool(0.1) {
            self.claim.transaction = 0;
        }
        if rng.random_bool(haste) {
            match rng.random_range(0..20) {
                0..6 => self.begin(now, rng),
                6 | 7 => self.claim.transaction = 0,
                // A number from before, or out of the blue.
                8 if rng.random_bool(0.3) => self.claim.transaction = rng.random_range(0..=self.count + 1),
                9 => self.claim.wait_until = deadline(now, rng),
                10..13 => self.claim.limits = limits(rng),
                _ => self.claim.motion = motion(rng),
            }
        }
        let lease = if rng.random_bool(0.02) { rng.random_range(0..4) } else { rng.random_range(5..9) };
        self.claim.valid_until = now + TICK * lease;
        match rng.random_range(0..60) {
            // Late, or with a clock of its own.
            0 => BaseClaim { stamp: now - TICK * rng.random_range(1..9), ..self.claim },
            1 => BaseClaim { client: ClientId(rng.random_range(6..9)), ..self.claim },
            2 => BaseClaim { client: ClientId::NONE, ..self.claim },
            _ => self.claim,
        }
    }

    fn begin(&mut self, now: Time, rng: &mut impl Rng) {
        // Sometimes without need: surrender and new number in one.
        if self.claim.transaction == 0 || rng.random_bool(0.1) {
            self.count += 1;
            self.claim.transaction = self.count;
            self.claim.wait_until = deadline(now, rng);
        }
    }
}

fn deadline(now: Time, rng: &mut impl Rng) -> Time {
    if rng.random_bool(0.7) { Time::FAR } else { now + TICK * rng.random_range(0..10) }
}

fn limits(rng: &mut impl Rng) -> Limits {
    const BOUNDS: [f64; 10] = [0.0, 0.1, 0.2, 0.2, 0.5, -0.3, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let mut bound = || if rng.random_bool(0.5) { f64::MAX } else { *pick(rng, &BOUNDS) };
    Limits { linear: bound(), angular: bound() }
}

fn motion(rng: &mut impl Rng) -> Motion {
    const NUMBERS: [f64; 9] = [0.1, 0.3, -0.3, 1.0, 0.0, 7.0, 1e300, f64::NAN, f64::INFINITY];
    let (first, second) = (*pick(rng, &NUMBERS), *pick(rng, &NUMBERS));
    let id = rng.random_range(0..3);
    match rng.random_range(0..5) {
        0 => Motion::STOP,
        1 => Motion::translate(id, first, second),
        2 => Motion::rotate(id, first, second),
        _ => Motion::velocity(Twist::new(first, second)),
    }
}

fn pick<'a, T>(rng: &mut impl Rng, from: &'a [T]) -> &'a T {
    &from[rng.random_range(0..from.len())]
}
