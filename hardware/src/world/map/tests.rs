#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;
use crate::world::{
    geometry::{Material, Outline},
    region::Region,
};

fn grid(rows: &[&str]) -> Grid {
    let cell = |c: char| match c {
        '#' => Cell::Occupied,
        '?' => Cell::Unknown,
        _ => Cell::Free,
    };
    let cells = rows.iter().rev().flat_map(|row| row.chars().map(cell)).collect();
    Grid { width: rows[0].len(), height: rows.len(), cells, resolution: 1.0, origin: Pose::default() }
}

fn area(rings: &[Ring]) -> f64 {
    let doubled = |ring: &Ring| ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| a.coords.perp(&b.coords)).sum::<f64>();
    rings.iter().map(doubled).sum::<f64>() / 2.0
}

fn is_solid(rings: &[Ring], p: Point2<f64>) -> bool {
    let rings: Vec<Ring> = Region::bordered_by(rings).rings().into_iter().map(|r| r.into_iter().rev().collect()).collect();
    !Outline::from_rings(&rings, vec![], false, |_, _| Material::default()).is_free(p)
}

#[test]
fn a_room_has_an_outer_and_an_inner_border() {
    let rings = grid(&["#####", "#...#", "#...#", "#####"]).rings(Unknown::Free, 0, 0.75);
    assert_eq!(rings.len(), 2);
    assert_eq!(area(&rings), 14.0);
    assert!(rings.iter().all(|ring| ring.len() == 4), "{rings:?}");
}

#[test]
fn unknown_is_what_it_is_said_to_be() {
    let map = grid(&["???", "?#?", "???"]);
    assert_eq!(area(&map.rings(Unknown::Free, 0, 0.0)), 1.0);
    assert_eq!(area(&map.rings(Unknown::Solid, 0, 0.0)), 9.0);
}

#[test]
fn specks_vanish_and_pinholes_are_filled() {
    let map = grid(&["#..........", "...######..", "...#.####..", "...######.#", ".#.........", "..#........"]);
    let rings = map.rings(Unknown::Free, 3, 0.0);
    assert_eq!(area(&rings), 18.0);
    assert_eq!(rings.len(), 1);
}

#[test]
fn a_diagonal_chain_of_cells_is_one_straight_wall() {
    let mut map = Grid { width: 40, height: 40, cells: vec![Cell::Free; 1600], resolution: 1.0, origin: Pose::default() };
    (0..40).for_each(|i| map.cells[i * 40 + i] = Cell::Occupied);
    let rings = map.rings(Unknown::Free, 0, 0.75);
    assert_eq!(rings.len(), 1);
    let long: Vec<_> = rings[0].iter().zip(rings[0].iter().cycle().skip(1)).filter(|(a, b)| (*b - *a).norm() > 10.0).collect();
    assert_eq!(long.len(), 2, "{rings:?}");
    for (a, b) in long {
        assert!(((b.y - a.y).atan2(b.x - a.x).rem_euclid(PI) - PI / 4.0).abs() < 0.01);
    }
    // It is closed: no way from one side to the other between its ends.
    for i in 2..38 {
        let middle = Point2::new(f64::from(i) + 0.5, f64::from(i) + 0.5);
        assert!(is_solid(&rings, middle), "gap at {middle}");
    }
}

/// A thick wall at any angle, drawn in cells, gets its own normals back.
#[test]
fn a_slanted_wall_keeps_its_direction() {
    for degrees in [0.0, 3.0, 11.3, 27.0, 45.0, 60.0, 89.0, 123.0] {
        let angle = f64::to_radians(degrees);
        let (width, height, half) = (120, 120, 3.0);
        let cell = |i: usize| {
            let p = nalgebra::Vector2::new((i % width) as f64 + 0.5 - 60.0, (i / width) as f64 + 0.5 - 60.0);
            let along = p.x * angle.cos() + p.y * angle.sin();
            let across = -p.x * angle.sin() + p.y * angle.cos();
            if along.abs() < 40.0 && across.abs() < half { Cell::Occupied } else { Cell::Free }
        };
        let map =
            Grid { width, height, cells: (0..width * height).map(cell).collect(), resolution: 0.05, origin: Pose::default() };
        let rings = map.rings(Unknown::Free, 4, 0.75);
        let sides = rings[0].iter().zip(rings[0].iter().cycle().skip(1));
        let long: Vec<_> = sides.filter(|(a, b)| (*b - *a).norm() > 3.0).collect();
        assert_eq!(long.len(), 2, "{degrees}: {rings:?}");
        for (a, b) in long {
            let off = ((b.y - a.y).atan2(b.x - a.x) - angle + PI / 2.0).rem_euclid(PI) - PI / 2.0;
            assert!(off.abs() < 0.01, "{degrees}°: off by {off} rad");
        }
    }
}

fn bitmaps() -> impl Strategy<Value = Grid> {
    (1..14_usize, 1..14_usize).prop_flat_map(|(width, height)| {
        proptest::collection::vec(proptest::bool::weighted(0.45), width * height).prop_map(move |solid| Grid {
            width,
            height,
            cells: solid.into_iter().map(|s| if s { Cell::Occupied } else { Cell::Free }).collect(),
            resolution: 1.0,
            origin: Pose::default(),
        })
    })
}

proptest! {
    #[test]
    fn an_exact_border_encloses_exactly_the_solid_cells(map in bitmaps()) {
        let rings = map.rings(Unknown::Free, 0, 0.0);
        let solid = map.cells.iter().filter(|c| **c == Cell::Occupied).count();
        prop_assert_eq!(area(&rings), solid as f64);
        for (i, cell) in map.cells.iter().enumerate() {
            let p = Point2::new((i % map.width) as f64 + 0.5, (i / map.width) as f64 + 0.5);
            prop_assert_eq!(is_solid(&rings, p), *cell == Cell::Occupied);
        }
    }

    #[test]
    fn a_straightened_border_stays_near(map in bitmaps()) {
        for ring in map.rings(Unknown::Free, 0, 0.75) {
            for p in ring {
                let near = |i: usize| {
                    let (x, y) = ((i % map.width) as f64, (i / map.width) as f64);
                    let (dx, dy) = ((x - p.x).max(p.x - x - 1.0).max(0.0), (y - p.y).max(p.y - y - 1.0).max(0.0));
                    map.cells[i] == Cell::Occupied && dx.hypot(dy) < 1.6
                };
                prop_assert!((0..map.cells.len()).any(near), "{p} is far from every solid cell");
            }
        }
    }

    #[test]
    fn no_header_panics(bytes in proptest::collection::vec(any::<u8>(), 0..200), text in "[a-z_]{3,15}: [-\\[\\]0-9., a-z]{0,20}\n") {
        let _ = Header::parse(&bytes);
        let _ = Header::parse(text.as_bytes());
        prop_assert!(decode(&bytes).is_err());
    }
}

fn header(extra: &str) -> Header {
    let text =
        format!("image: a.pgm\nresolution: 0.05\norigin: [1.0, -2, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\n{extra}");
    Header::parse(text.as_bytes()).unwrap()
}

fn cells(header: &Header, bytes: &[u8]) -> Vec<Cell> {
    let mut pgm = format!("P5\n{} 1\n255\n", bytes.len()).into_bytes();
    pgm.extend(bytes);
    header.grid(&pgm).unwrap().cells
}

#[test]
fn the_three_modes_read_pixels_as_the_map_server_does() {
    use Cell::{Free, Occupied, Unknown};
    assert_eq!(cells(&header(""), &[0, 254, 205, 100, 80]), [Occupied, Free, Unknown, Unknown, Occupied]);
    assert_eq!(cells(&header("mode: trinary\nnegate: 1"), &[0, 254, 205]), [Free, Occupied, Occupied]);
    assert_eq!(cells(&header("mode: scale"), &[0, 254, 128]), [Occupied, Free, Unknown]);
    assert_eq!(cells(&header("mode: raw"), &[0, 100, 50, 255, 66]), [Free, Occupied, Unknown, Unknown, Occupied]);
}

#[test]
fn the_origin_is_the_lower_left_corner_and_its_yaw_counts() {
    let mut head = header("");
    head.origin[2] = PI / 2.0;
    // Two rows, the lower right cell solid.
    let map = head.grid(b"P5\n2 2\n255\n\xfe\xfe\xfe\x00").unwrap();
    let rings = map.rings(Unknown::Free, 0, 0.0);
    let middle = rings[0].iter().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>() / 4.0;
    assert!((middle - nalgebra::Vector2::new(1.0 - 0.025, -2.0 + 0.075)).norm() < 1e-12, "{middle}");
}

#[test]
fn a_wrong_header_says_what_and_where() {
    let wrong = |text: &str| {
        let error = Header::parse(text.as_bytes()).unwrap_err();
        (error.to_string(), text[error.place().unwrap()].to_owned())
    };
    assert!(wrong("image: a.pgm\nresolution: 0.05\n").0.contains("origin"));
    let text = "image: a\nresolution: -1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.2";
    assert_eq!(wrong(text), ("resolution is -1, not within 0.001 to 5".into(), "resolution".into()));
    assert_eq!(wrong(&text.replace("-1", "wide")).1, "wide");
    assert_eq!(wrong(&text.replace("-1", "1").replace("[0, 0, 0]", "[0, 0, 9]")).1, "origin");
    let place = Header::parse(b"image: \xff\xfe").unwrap_err().place();
    assert_eq!(place, Some(7..8), "no text at all");
}

#[test]
fn a_slip_in_a_key_that_may_be_missing_is_told() {
    let map = |extra: &str| {
        format!("image: a.png\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.2\n{extra}")
            .into_bytes()
    };
    for (extra, key) in [("negat: 1\n", "negate"), ("mod: raw\n", "mode"), ("negate: 0\nMode: raw\n", "mode")] {
        let error = Header::parse(&map(extra)).unwrap_err();
        assert!(error.to_string().contains(&format!("did you mean `{key}`?")), "{extra}: {error}");
        assert!(error.place().is_some_and(|place| place.start > 80), "{extra}: {error:?}");
    }
    for extra in ["negate: 1\nmode: raw\nmod: 3\n", "author: me\nnodes:\n  negat: 1\n", "# negat: 1\n"] {
        assert!(Header::parse(&map(extra)).is_ok(), "{extra}");
    }
}
