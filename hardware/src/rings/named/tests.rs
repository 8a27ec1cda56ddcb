#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use orienteer_runtime::time::Time;

use super::*;
use crate::echo::Pinger;

/// Mount as (x, y, heading) in cm and degrees, rounded to a tenth.
fn mount(ring: &str, index: usize) -> [f64; 3] {
    let mount = find(ring).unwrap().ring.transducers[index].mount;
    [100.0 * mount.x, 100.0 * mount.y, mount.heading.to_degrees()].map(|v| (10.0 * v).round() / 10.0 + 0.0)
}

#[test]
fn every_ring_runs_and_fires_all_its_transducers() {
    let names: BTreeSet<_> = all().map(|named| named.ring.name).collect();
    assert_eq!(names.len(), 8);
    for named in all() {
        let name = named.ring.name.clone();
        let every = u32::MAX >> (32 - named.ring.transducers.len());
        assert_eq!(named.ring.program.transducers(), every, "{name}");
        assert!(Pinger::new(named.ring, &named.model, Time::START).is_ok(), "{name}");
    }
}

#[test]
fn huey_counts_clockwise() {
    assert_eq!(mount("denning-16", 0), [8.0, 0.0, 0.0]);
    assert_eq!(mount("denning-16", 4), [0.0, -8.0, -90.0]);
    assert_eq!(mount("denning-16", 12), [0.0, 8.0, 90.0]);
    assert_eq!(mount("denning-16", 1)[2], -22.5);
    assert_eq!(mount("denning-16", 8)[2].abs(), 180.0);
}

#[test]
fn luey_has_the_mounts_of_the_table() {
    // Radius (cm) and angle δ between facing and mounting point, the table's other form of the same mounts
    let table = [
        ("luey-8-square", 0, 11.8, -43.97),
        ("luey-8-square", 1, 12.5, 40.80),
        ("luey-8-square", 2, 13.3, -64.59),
        ("luey-8-square", 3, 12.4, 62.61),
        ("luey-8-square", 4, 17.3, -39.59),
        ("luey-8-square", 5, 17.9, 42.06),
        ("luey-8-square", 6, 17.9, 61.72),
        ("luey-8-square", 7, 18.4, -58.98),
        ("luey-8-front", 3, 16.1, -1.00),
        ("luey-8-front", 2, 15.4, 3.67),
    ];
    for (ring, index, radius, offset) in table {
        let mount = find(ring).unwrap().ring.transducers[index].mount;
        let from_facing = orienteer_runtime::geometry::angle::turn(mount.heading, mount.y.atan2(mount.x)).to_degrees();
        assert!((100.0 * mount.x.hypot(mount.y) - radius).abs() < 0.1, "{ring} {index}");
        assert!((from_facing - offset).abs() < 0.5, "{ring} {index}: {from_facing}");
    }
    let fired: Vec<_> = find("luey-8-front").unwrap().ring.program.slots.iter().map(|slot| slot.trailing_zeros()).collect();
    assert_eq!(fired, [0, 5, 2, 7, 4, 1, 6, 3]);
}

#[test]
fn each_group_of_yamabico_looks_in_four_directions() {
    let ring = find("yamabico-12").unwrap().ring;
    for slot in ring.program.slots.iter() {
        let looks: BTreeSet<_> = (0..12).filter(|i| slot & (1 << i) != 0).map(|i| mount("yamabico-12", i)[2] as i32).collect();
        assert_eq!(looks.len(), 4);
    }
}

/// Shanley's table counts from the front axle, the robot frame lies at the rear one, half a metre behind.
#[test]
fn the_wheelchairs_angled_pair_is_crossed() {
    assert_eq!(mount("wheelchair-6", 0), [50.0, 0.0, 0.0]);
    assert_eq!(mount("wheelchair-6", 2), [50.0, 20.0, -67.5]);
    assert_eq!(mount("wheelchair-6", 3), [50.0, -20.0, 67.5]);
    assert_eq!(mount("wheelchair-6", 1), [0.0, 0.0, 180.0]);
    assert_eq!(mount("wheelchair-6", 4), [5.0, 25.0, 90.0]);
}

#[test]
fn symmetric_rings_are_symmetric() {
    for name in ["p3dx-16", "amigobot-8", "robond-8", "denning-16", "yamabico-12", "wheelchair-6"] {
        let count = find(name).unwrap().ring.transducers.len();
        let mounts: Vec<_> = (0..count).map(|i| mount(name, i)).collect();
        let is_mirror = |a: &[f64; 3], b: &[f64; 3]| a[0] == b[0] && a[1] == -b[1] && (a[2] + b[2]).rem_euclid(360.0) < 1e-9;
        for a in &mounts {
            assert!(mounts.iter().any(|b| is_mirror(a, b)), "{name}: {a:?} has no mirror image");
        }
    }
}

#[test]
fn the_pioneer_looks_where_its_parameter_file_says() {
    let bearings: Vec<_> = (0..16).map(|i| mount("p3dx-16", i)[2]).collect();
    assert_eq!(bearings[..8], [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0]);
    assert_eq!(bearings[8..], [-90.0, -130.0, -150.0, -170.0, 170.0, 150.0, 130.0, 90.0]);
}
