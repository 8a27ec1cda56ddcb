//! What a sonar scan costs: a ring of 16 beams of ±12° and 7.77 m, from 200 poses, in worlds of 50, 500 and 5000 walls.
//!
//! * `random`: walls of 0.5 to 3 m anywhere (50 and 500 in 20 m, 5000 in 60 m), both ends heard as vertices.
//! * `office`: rooms of 4 m with doors, corners and door posts heard as vertices.
//!
//! `cones` is the search alone, `pinger` a whole pass with noise as the simulated driver runs it. Three people walk about.

#![allow(missing_docs, clippy::unwrap_used)]

use std::{hint::black_box, time::Duration};

use criterion::{Bencher, BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::Point2;
use orienteer_hardware::{
    echo::{Acoustics, Beam, Disc, PERSON_REFLECTANCE, Pinger, Scratch, SegmentGrid, Vertex, Wall, cone},
    rings,
};
use orienteer_runtime::{geometry::Pose, robot_model::Transducer, time::Time};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const POSES: usize = 200;

struct World {
    grid: SegmentGrid,
    bodies: [Disc; 3],
    poses: Vec<Pose>,
}

fn world(walls: &[Wall], size: f64, rng: &mut Pcg64) -> World {
    let vertices: Vec<_> = walls.iter().flat_map(|w| [w.a, w.b]).map(|at| Vertex { at, strength: 1.0 }).collect();
    let mut spot = || Point2::new(rng.random_range(0.0..size), rng.random_range(0.0..size));
    let bodies = [spot(), spot(), spot()].map(|centre| Disc { centre, radius: 0.2, reflectance: PERSON_REFLECTANCE });
    let poses = (0..POSES).map(|i| Pose::new(spot().x, spot().y, i as f64)).collect();
    World { grid: SegmentGrid::new(walls, &vertices, &[]).unwrap(), bodies, poses }
}

fn random(count: usize, size: f64) -> World {
    let mut rng = Pcg64::seed_from_u64(count as u64);
    let mut wall = || {
        let a = Point2::new(rng.random_range(0.0..size), rng.random_range(0.0..size));
        let (length, angle): (f64, f64) = (rng.random_range(0.5..3.0), rng.random_range(0.0..6.3));
        Wall::new(a, Point2::new(a.x + length * angle.cos(), a.y + length * angle.sin()))
    };
    let walls: Vec<_> = (0..count).map(|_| wall()).collect();
    world(&walls, size, &mut rng)
}

/// About `count` walls: every room of 4 m brings the two pieces beside a door on its left and below.
fn office(count: usize) -> World {
    let rooms = ((count as f64 / 4.0).sqrt().round() as usize).max(1);
    let mut walls = Vec::new();
    for (i, j) in (0..rooms).flat_map(|i| (0..rooms).map(move |j| (i, j))) {
        let (x, y) = (4.0 * i as f64, 4.0 * j as f64);
        for (from, to) in [(0.0, 1.5), (2.5, 4.0)] {
            walls.push(Wall::new(Point2::new(x, y + from), Point2::new(x, y + to)));
            walls.push(Wall::new(Point2::new(x + from, y), Point2::new(x + to, y)));
        }
    }
    world(&walls, 4.0 * rooms as f64, &mut Pcg64::seed_from_u64(count as u64))
}

fn scans(c: &mut Criterion) {
    let worlds = [
        ("random", 50, random(50, 20.0)),
        ("random", 500, random(500, 20.0)),
        ("random", 5000, random(5000, 60.0)),
        ("office", 50, office(50)),
        ("office", 500, office(500)),
        ("office", 5000, office(5000)),
    ];
    for (kind, count, world) in &worlds {
        let id = |what| BenchmarkId::new(format!("{what}/{kind}"), count);
        c.benchmark_group("scan")
            .bench_function(id("cones"), |b| cones(b, world))
            .bench_function(id("pinger"), |b| pinger(b, world));
    }
}

fn cones(bencher: &mut Bencher<'_>, world: &World) {
    let named = rings::find("denning-16").unwrap();
    let acoustics = Acoustics::new(&named.model).unwrap();
    let beam = |pose: &Pose, t: &Transducer| Beam::new(pose.then(t.mount), t.half_beam, named.ring.max_range);
    let beams: Vec<Vec<_>> =
        world.poses.iter().map(|pose| named.ring.transducers.iter().map(|t| beam(pose, t)).collect()).collect();
    let mut scratch = Scratch::default();
    let mut scan = 0;
    bencher.iter(|| {
        scan += 1;
        for beam in &beams[scan % POSES] {
            black_box(cone(&world.grid, &world.bodies, beam, &acoustics, &mut scratch));
        }
    });
}

fn pinger(bencher: &mut Bencher<'_>, world: &World) {
    let named = rings::find("denning-16").unwrap();
    let mut pinger = Pinger::new(named.ring, &named.model, Time::START).unwrap();
    let mut rng = Pcg64::seed_from_u64(1);
    let mut scans = Vec::new();
    let mut now = Time::START;
    bencher.iter(|| {
        let pose = world.poses[(now.as_nanos() / 25_000_000) as usize % POSES];
        let next = now + Duration::from_millis(25);
        pinger.poll(now, next, |_| pose, &world.grid, &world.bodies, &mut rng, &mut scans);
        now = next;
        assert_eq!(scans.len(), 1);
        scans.clear();
    });
}

criterion_group!(benches, scans);
criterion_main!(benches);
