//! Two independent answers to the question of [`cone`](super::cone()), slow and plain, and the tests that compare all three.
//!
//! * [`fan`]: very many rays, a loop over everything for each.
//! * [`sweep`]: all angles at which the first surface or its answering can change, in order; between two of them the first
//!   surface is the same and its range monotone, so the ends of the intervals hold the minimum.

#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::*;

#[derive(Debug, Clone, Default)]
struct World {
    walls: Vec<Wall>,
    vertices: Vec<Vertex>,
    pillars: Vec<Disc>,
    bodies: Vec<Disc>,
}

#[derive(Debug, Clone, Copy)]
struct View {
    origin: Point2<f64>,
    heading: f64,
    half_beam: f64,
    max_range: f64,
}

#[derive(Debug, Clone, Copy)]
struct Hit {
    range: f64,
    incidence: f64,
    reflectance: f64,
    source: Source,
}

impl World {
    fn grid(&self) -> SegmentGrid {
        SegmentGrid::new(&self.walls, &self.vertices, &self.pillars).unwrap()
    }

    fn discs(&self) -> impl Iterator<Item = (Source, &Disc)> {
        let pillars = self.pillars.iter().enumerate().map(|(i, d)| (Source::Pillar(i), d));
        pillars.chain(self.bodies.iter().enumerate().map(|(i, d)| (Source::Body(i), d)))
    }

    /// The first surface in a direction.
    fn ray(&self, origin: Point2<f64>, angle: f64) -> Option<Hit> {
        let direction = Vector2::new(angle.cos(), angle.sin());
        let walls = self.walls.iter().enumerate().filter_map(|(i, wall)| {
            let along = wall.b - wall.a;
            let (to_a, turn) = (wall.a - origin, direction.perp(&along));
            let (range, share) = (to_a.perp(&along) / turn, to_a.perp(&direction) / turn);
            let incidence = (direction.dot(&along) / along.norm()).abs().min(1.0).asin();
            (range >= 0.0 && (0.0..=1.0).contains(&share)).then_some(Hit {
                range,
                incidence,
                reflectance: wall.reflectance,
                source: Source::Wall(i),
            })
        });
        let discs = self.discs().filter_map(|(source, disc)| {
            let to = disc.centre - origin;
            let (along, aside) = (to.dot(&direction), to.perp(&direction));
            let depth = (disc.radius * disc.radius - aside * aside).sqrt();
            let incidence = (aside / disc.radius).abs().min(1.0).asin();
            (along > 0.0 && depth >= 0.0).then_some(Hit {
                range: along - depth,
                incidence,
                reflectance: disc.reflectance,
                source,
            })
        });
        walls.chain(discs).min_by(|a, b| a.range.total_cmp(&b.range))
    }

    fn vertex_ranges(&self, view: View, acoustics: &Acoustics) -> impl Iterator<Item = f64> {
        self.vertices.iter().filter_map(move |vertex| {
            let to = vertex.at - view.origin;
            let (range, angle) = (to.norm(), to.y.atan2(to.x));
            let in_beam =
                (to.y * view.heading.cos() - to.x * view.heading.sin()).atan2(to.dot(&view.axis())).abs() <= view.half_beam;
            let heard = range <= acoustics.vertex_reach(vertex.strength) && range <= view.max_range;
            let hidden = in_beam && heard && self.ray(view.origin, angle).is_some_and(|hit| hit.range < range - 1e-7);
            (in_beam && heard && !hidden).then_some(range)
        })
    }
}

impl View {
    fn axis(&self) -> Vector2<f64> {
        Vector2::new(self.heading.cos(), self.heading.sin())
    }

    fn beam(&self) -> Beam {
        Beam::along(self.origin, self.axis(), self.half_beam, self.max_range)
    }

    fn answers(&self, acoustics: &Acoustics, hit: &Hit) -> bool {
        hit.range <= self.max_range && acoustics.answers(hit.range, hit.incidence.cos(), hit.reflectance)
    }
}

fn least(ranges: impl Iterator<Item = f64>) -> Option<f64> {
    ranges.min_by(f64::total_cmp)
}

fn fan(world: &World, view: View, acoustics: &Acoustics, rays: usize) -> Option<f64> {
    let angle = |i: usize| view.heading + view.half_beam * (2.0 * i as f64 / (rays - 1) as f64 - 1.0);
    let hits = (0..rays).filter_map(|i| world.ray(view.origin, angle(i)));
    let echoes = hits.filter(|hit| view.answers(acoustics, hit)).map(|hit| hit.range);
    least(echoes.chain(world.vertex_ranges(view, acoustics)))
}

/// All angles off the axis at which something changes, for a limit of incidence that does not depend on range.
fn critical_angles(world: &World, view: View, limit: f64) -> Vec<f64> {
    let mut angles = vec![-view.half_beam, view.half_beam];
    let mut point = |at: Point2<f64>| {
        let to = at - view.origin;
        angles.push(view.axis().perp(&to).atan2(view.axis().dot(&to)));
    };
    for (i, wall) in world.walls.iter().enumerate() {
        point(wall.a);
        point(wall.b);
        let along = (wall.b - wall.a).normalize();
        for other in &world.walls[..i] {
            let across = other.b - other.a;
            let share = (other.a - wall.a).perp(&across) / along.perp(&across);
            point(wall.a + along * share);
        }
        for (_, disc) in world.discs() {
            let foot = along * (disc.centre - wall.a).dot(&along);
            let half = (disc.radius.powi(2) - (wall.a + foot - disc.centre).norm_squared()).sqrt();
            point(wall.a + foot + along * half);
            point(wall.a + foot - along * half);
        }
    }
    let discs: Vec<_> = world.discs().map(|(_, disc)| *disc).collect();
    // Where a disc leaves the range it meets the circle of that radius.
    let reach = Disc { centre: view.origin, radius: view.max_range, reflectance: 1.0 };
    let circles: Vec<_> = std::iter::once(reach).chain(discs.iter().copied()).collect();
    for (i, disc) in circles.iter().enumerate() {
        for other in &circles[..i] {
            let between = other.centre - disc.centre;
            let distance = between.norm();
            let offset = (distance * distance + disc.radius.powi(2) - other.radius.powi(2)) / (2.0 * distance);
            let half = (disc.radius.powi(2) - offset * offset).sqrt();
            let (along, left) = (between / distance, Vector2::new(-between.y, between.x) / distance);
            point(disc.centre + along * offset + left * half);
            point(disc.centre + along * offset - left * half);
        }
    }
    let bearing = |to: Vector2<f64>| view.axis().perp(&to).atan2(view.axis().dot(&to));
    for wall in &world.walls {
        let along = wall.b - wall.a;
        for normal in [Vector2::new(-along.y, along.x), Vector2::new(along.y, -along.x)] {
            let middle = bearing(normal);
            angles.extend([middle - limit, middle, middle + limit].map(orienteer_runtime::geometry::angle::wrap));
        }
        for sign in [-1.0, 1.0] {
            // Where the wall leaves the range
            let unit = along.normalize();
            let foot = wall.a + unit * (view.origin - wall.a).dot(&unit);
            let half = (view.max_range.powi(2) - (foot - view.origin).norm_squared()).sqrt();
            angles.push(bearing(foot + unit * (sign * half) - view.origin));
        }
    }
    for disc in &discs {
        let to = disc.centre - view.origin;
        let middle = bearing(to);
        for reach in [(disc.radius / to.norm()).asin(), (disc.radius * limit.sin() / to.norm()).asin(), 0.0] {
            angles.extend([middle - reach, middle + reach]);
        }
    }
    angles.retain(|angle| angle.abs() <= view.half_beam);
    angles.sort_by(f64::total_cmp);
    angles
}

/// The exact answer, but for glimpses narrower than `gap` rad.
fn sweep(world: &World, view: View, acoustics: &Acoustics, limit: f64, gap: f64) -> Option<f64> {
    let angles = critical_angles(world, view, limit);
    let ranges = angles.windows(2).filter(|pair| pair[1] - pair[0] > gap).filter_map(|pair| {
        let hit = world.ray(view.origin, view.heading + 0.5 * (pair[0] + pair[1]))?;
        let inside = 1e-3 * (pair[1] - pair[0]).min(1e-6);
        let ends =
            [pair[0] + inside, pair[1] - inside].map(|angle| world.ray(view.origin, view.heading + angle).map(|h| h.range));
        view.answers(acoustics, &hit).then(|| ends.into_iter().flatten().fold(hit.range, f64::min))
    });
    least(ranges.chain(world.vertex_ranges(view, acoustics)))
}

fn random_world(seed: u64) -> (World, View) {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut world = World::default();
    let size = rng.random_range(2.0..8.0);
    let spot = |rng: &mut Pcg64| Point2::new(rng.random_range(-size..size), rng.random_range(-size..size));
    for _ in 0..rng.random_range(0..8) {
        let wall = Wall { a: spot(&mut rng), b: spot(&mut rng), reflectance: rng.random_range(0.2..1.0) };
        world.walls.push(wall);
    }
    for _ in 0..rng.random_range(0..5) {
        // A box, its corners shared by walls and heard as vertices
        let (corner, turn) = (spot(&mut rng), rng.random_range(0.0..TAU));
        let (w, h) = (rng.random_range(0.1..3.0), rng.random_range(0.1..3.0));
        let at = |x: f64, y: f64| corner + nalgebra::Rotation2::new(turn) * Vector2::new(x, y);
        let corners = [at(0.0, 0.0), at(w, 0.0), at(w, h), at(0.0, h)];
        for i in 0..4 {
            world.walls.push(Wall::new(corners[i], corners[(i + 1) % 4]));
            world.vertices.push(Vertex { at: corners[i], strength: rng.random_range(0.0..1.0) });
        }
    }
    let disc = |rng: &mut Pcg64| Disc {
        centre: spot(rng),
        radius: rng.random_range(0.05..0.7),
        reflectance: rng.random_range(0.0..1.0),
    };
    for _ in 0..rng.random_range(0..3) {
        world.pillars.push(disc(&mut rng));
    }
    for _ in 0..rng.random_range(0..4) {
        world.bodies.push(disc(&mut rng));
    }
    let view = View {
        origin: Point2::new(rng.random_range(-size..size), rng.random_range(-size..size)),
        heading: rng.random_range(-3.1..3.1),
        half_beam: rng.random_range(0.02..0.6),
        max_range: rng.random_range(1.0..9.0),
    };
    // From inside a body there is nothing to compare.
    let outside = |disc: &Disc| (disc.centre - view.origin).norm() > disc.radius + 1e-6;
    world.pillars.retain(outside);
    world.bodies.retain(outside);
    (world, view)
}

fn searched(world: &World, view: View, acoustics: &Acoustics) -> Option<Answer> {
    cone(&world.grid(), &world.bodies, &view.beam(), acoustics, &mut Scratch::default())
}

/// The claimed point must itself be visible and answer, a hair to one side of it.
fn is_sound(world: &World, view: View, acoustics: &Acoustics, answer: &Answer) -> bool {
    if let Source::Vertex(_) = answer.source {
        return world.vertex_ranges(view, acoustics).any(|range| (range - answer.range).abs() < 1e-9);
    }
    [0.0, -1e-6, 1e-6, -2e-6, 2e-6].iter().any(|nudge| {
        world.ray(view.origin, view.heading + answer.bearing() + nudge).is_some_and(|hit| {
            hit.source == answer.source
                && (hit.range - answer.range).abs() < 1e-3
                && hit.reflectance > 0.0
                && acoustics.answers(answer.range, (hit.incidence - 1e-4).max(0.0).cos(), hit.reflectance)
        })
    })
}

fn ranged_model() -> SonarModel {
    let limits = [(0.5, 60.0), (1.0, 30.0), (3.0, 10.0), (8.0, 2.0)];
    SonarModel {
        incidence_limit: limits.iter().map(|&(range, limit_deg)| IncidencePoint { range, limit_deg }).collect(),
        detection: vec![DetectionPoint { range: 0.0, reflectance: 0.0 }, DetectionPoint { range: 9.0, reflectance: 1.0 }],
        ..SonarModel::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn agrees_with_an_exact_sweep(seed in any::<u64>(), limit_deg in 3.0..89.0f64) {
        let (world, view) = random_world(seed);
        let acoustics = Acoustics::new(&SonarModel::default().with_incidence_limit(limit_deg)).unwrap();
        // What is seen through a gap of a few µrad only may be heard or not.
        let expected = [5e-6, 1e-9].map(|gap| sweep(&world, view, &acoustics, limit_deg.to_radians(), gap));
        let range = searched(&world, view, &acoustics).map(|answer| answer.range);
        let agrees = |expected: &Option<f64>| match (range, expected) {
            (Some(range), Some(expected)) => (range - expected).abs() < 1e-4,
            (range, expected) => range.is_none() && expected.is_none(),
        };
        prop_assert!(expected.iter().any(agrees), "{range:?} is not {expected:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn agrees_with_a_fan_of_rays(seed in any::<u64>(), limit_deg in 3.0..90.0f64, by_range in any::<bool>()) {
        let (world, view) = random_world(seed);
        let model = if by_range { ranged_model() } else { SonarModel::default().with_incidence_limit(limit_deg) };
        let acoustics = Acoustics::new(&model).unwrap();
        let rays = fan(&world, view, &acoustics, 4001);
        let answer = searched(&world, view, &acoustics);
        // Nothing that a ray hears is missed, ...
        if let Some(rays) = rays {
            let answer = answer.map(|a| a.range);
            prop_assert!(answer.is_some_and(|range| range <= rays + 1e-9), "{answer:?}, but a ray hears {rays}");
        }
        // ... and nothing is heard that no ray could hear.
        if let Some(answer) = answer {
            prop_assert!(is_sound(&world, view, &acoustics, &answer), "{answer:?} is not there, rays say {rays:?}");
        }
    }

    #[test]
    fn a_ray_meets_what_a_plain_loop_meets(seed in any::<u64>()) {
        let (world, view) = random_world(seed);
        let expected = world.ray(view.origin, view.heading).filter(|hit| hit.range <= view.max_range);
        let contact = first_surface(&world.grid(), &world.bodies, &view.beam(), None, &mut Scratch::default());
        prop_assert_eq!(contact.map(|c| c.source), expected.map(|hit| hit.source));
        if let (Some(contact), Some(hit)) = (contact, expected) {
            prop_assert!((contact.range - hit.range).abs() < 1e-9);
            prop_assert!((-contact.normal.dot(&view.axis()) - hit.incidence.cos()).abs() < 1e-6);
        }
    }

    #[test]
    fn one_memory_serves_many_worlds(seeds in proptest::collection::vec(any::<u64>(), 1..8)) {
        let acoustics = Acoustics::new(&SonarModel::default()).unwrap();
        let mut scratch = Scratch::default();
        for seed in seeds {
            let (world, view) = random_world(seed);
            let fresh = searched(&world, view, &acoustics);
            prop_assert_eq!(cone(&world.grid(), &world.bodies, &view.beam(), &acoustics, &mut scratch), fresh);
        }
    }
}
