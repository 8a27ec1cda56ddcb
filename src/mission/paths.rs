//! The ways of all bodies, for the picture.

use std::sync::{Arc, PoisonError};

use nalgebra::Point2;
use orienteer_hardware::{
    sim::Arena,
    world::draw::{self, Canvas},
};
use orienteer_runtime::time::Time;

use image::Rgb;

/// Seconds between two points of a trail.
const EVERY: f64 = 0.5;
/// Metres per pixel of the picture.
const RESOLUTION: f64 = 0.02;
/// Robots' colours, in turn.
const COLOURS: [Rgb<u8>; 6] =
    [Rgb([214, 60, 40]), Rgb([38, 110, 190]), Rgb([40, 150, 80]), Rgb([150, 80, 170]), Rgb([220, 140, 20]), Rgb([20, 150, 160])];
const PEOPLE: Rgb<u8> = Rgb([120, 120, 120]);

/// Where the robots of a simulation have been.
pub struct Trails {
    arena: Option<Arc<Arena>>,
    trails: Vec<Vec<Point2<f64>>>,
    next: f64,
}

impl Trails {
    pub fn new(arena: Option<Arc<Arena>>) -> Self {
        let robots = arena.as_ref().map_or(0, |arena| arena.robots().len());
        Self { arena, trails: vec![Vec::new(); robots], next: 0.0 }
    }

    pub fn after_step(&mut self, now: Time) {
        let Some(arena) = self.arena.as_ref().filter(|_| now.as_secs_f64() >= self.next) else { return };
        self.next = now.as_secs_f64() + EVERY;
        for (trail, robot) in self.trails.iter_mut().zip(arena.robots()) {
            trail.push(robot.lock().unwrap_or_else(PoisonError::into_inner).pose().point());
        }
    }

    /// The world with everybody in it and the ways that the robots took; `None` without a simulated world.
    pub fn picture(&self) -> Option<Canvas> {
        let arena = self.arena.as_ref()?;
        let size = arena.world().outline.bounds.size();
        // A huge map must not become a huge picture.
        let resolution = RESOLUTION.max(size.x.max(size.y) / 4000.0);
        let mut canvas = draw::outline(&arena.world().outline, resolution);
        for (i, trail) in self.trails.iter().enumerate() {
            canvas.path(trail.iter().copied(), 0.06, COLOURS[i % COLOURS.len()]);
        }
        arena.with_bodies(|bodies| {
            let robots = bodies.robots().iter().zip(COLOURS.into_iter().cycle());
            for (disc, colour) in robots.chain(bodies.people().iter().map(|disc| (disc, PEOPLE))) {
                canvas.disc(*disc, colour);
            }
        });
        Some(canvas)
    }
}
