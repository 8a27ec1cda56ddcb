//! Whole worlds against the definition of solid and free: point by point, element by element.
#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;

use nalgebra::{Point2, Rotation2, Vector2};
use orienteer_hardware::world::{
    World,
    geometry::Corner,
    plan::{Block, Column, Corridor, Door, Polygon, Room, Wall, WorldPlan, Xy},
};
use proptest::prelude::*;

fn xy(p: Point2<f64>) -> Xy {
    // As people write: to the millimetre.
    Xy([(p.x * 1e3).round() / 1e3, (p.y * 1e3).round() / 1e3])
}

fn places() -> impl Strategy<Value = Point2<f64>> {
    (-8.0..8.0, -8.0..8.0).prop_map(|(x, y)| Point2::new(x, y))
}

/// Polylines of two to four points that bend by less than 110°.
fn lines() -> impl Strategy<Value = Vec<Xy>> {
    let bends = proptest::collection::vec((-1.9..1.9f64, 2.5..6.0f64), 0..3);
    (places(), 0.0..TAU, 2.5..6.0f64, bends).prop_map(|(start, heading, length, bends)| {
        let mut line = vec![xy(start)];
        let (mut at, mut heading) = (start, heading);
        for (turn, length) in std::iter::once((0.0, length)).chain(bends) {
            heading += turn;
            at += Rotation2::new(heading) * Vector2::new(length, 0.0);
            line.push(xy(at));
        }
        line
    })
}

fn walls() -> impl Strategy<Value = Wall> {
    (lines(), 0.05..0.4f64, 0.4..0.9f64, any::<bool>()).prop_map(|(along, thickness, width, open)| {
        let at = xy(nalgebra::center(&along[0].point(), &along[1].point()));
        let doors = vec![Door { at, width, open }];
        Wall { name: None, along, thickness, closed: false, doors, reflectance: 1.0 }
    })
}

fn triangles() -> impl Strategy<Value = Vec<Xy>> {
    (places(), 0.0..TAU, 0.5..3.0f64, 0.5..2.5f64, 0.5..2.5f64).prop_map(|(c, heading, r, a, b)| {
        [0.0, a, a + b].map(|angle| xy(c + Rotation2::new(heading + angle) * Vector2::new(r, 0.0))).to_vec()
    })
}

fn boxes() -> impl Strategy<Value = Block> {
    (places(), 0.1..3.0f64, 0.1..3.0f64, prop_oneof![Just(0.0), Just(90.0), -360.0..360.0f64])
        .prop_map(|(c, w, h, rotation_deg)| Block { name: None, center: xy(c), size: [w, h], rotation_deg, reflectance: 0.5 })
}

fn plans() -> impl Strategy<Value = WorldPlan> {
    let carved = (
        proptest::collection::vec((lines(), 0.5..3.0f64), 0..4),
        proptest::collection::vec(triangles(), 0..3),
        proptest::collection::vec((places(), places()), 0..3),
    );
    let matter = (
        proptest::collection::vec(walls(), 0..5),
        proptest::collection::vec(triangles(), 0..3),
        proptest::collection::vec(boxes(), 0..5),
        proptest::collection::vec((places(), 0.1..1.0f64), 0..3),
    );
    (any::<bool>(), carved, matter).prop_map(|(open_ground, (corridors, outlines, rectangles), (wall, solids, boxes, discs))| {
        let room = |corners| Room { name: None, corners, doors: vec![], reflectance: 1.0 };
        let rectangles = rectangles.into_iter().filter(|(a, b)| (a.x - b.x).abs() > 0.3 && (a.y - b.y).abs() > 0.3);
        let mut plan = WorldPlan {
            corridor: corridors
                .into_iter()
                .map(|(along, width)| Corridor { name: None, along, width, closed: false, reflectance: 1.0 })
                .collect(),
            room: outlines.into_iter().map(room).chain(rectangles.map(|(a, b)| room(vec![xy(a), xy(b)]))).collect(),
            wall,
            polygon: solids.into_iter().map(|corners| Polygon { name: None, corners, reflectance: 1.0 }).collect(),
            boxes,
            disc: discs.into_iter().map(|(c, radius)| Column { name: None, center: xy(c), radius, reflectance: 1.0 }).collect(),
            ..WorldPlan::default()
        };
        if open_ground {
            plan.corridor.clear();
            plan.room.clear();
        }
        plan
    })
}

/// True if `p` is inside the polygon, by its winding number.
fn in_polygon(corners: &[Xy], p: Point2<f64>) -> bool {
    let angle = |a: Vector2<f64>, b: Vector2<f64>| a.perp(&b).atan2(a.dot(&b));
    let n = corners.len();
    let total: f64 = (0..n).map(|i| angle(corners[i].point() - p, corners[(i + 1) % n].point() - p)).sum();
    total.abs() > 3.0
}

fn in_outline(corners: &[Xy], p: Point2<f64>) -> bool {
    match corners {
        [a, b] => {
            let (a, b) = (a.point(), b.point());
            (p.x - a.x) * (p.x - b.x) < 0.0 && (p.y - a.y) * (p.y - b.y) < 0.0
        }
        all => in_polygon(all, p),
    }
}

/// Position along and beside a leg, and the leg's length.
fn local(a: Xy, b: Xy, p: Point2<f64>) -> (f64, f64, f64) {
    let leg = b.point() - a.point();
    let d = leg.normalize();
    let to = p - a.point();
    (d.dot(&to), d.perp(&to), leg.norm())
}

/// True if `p` is on a line drawn with a pen of this width, bends mitred.
fn on_stroke(along: &[Xy], width: f64, p: Point2<f64>) -> bool {
    let half = 0.5 * width;
    let on_leg = along.windows(2).any(|w| {
        let (x, y, length) = local(w[0], w[1], p);
        0.0 < x && x < length && y.abs() < half
    });
    on_leg
        || along.windows(3).any(|w| {
            let (x1, y1, length) = local(w[0], w[1], p);
            let (x2, y2, _) = local(w[1], w[2], p);
            x1 >= length && x2 <= 0.0 && y1.abs() < half && y2.abs() < half
        })
}

fn in_door(wall: &Wall, p: Point2<f64>) -> bool {
    let (x, y, length) = local(wall.along[0], wall.along[1], p);
    let door = &wall.doors[0];
    // The door was put at the middle of the first leg, to the millimetre.
    let (middle, _, _) = local(wall.along[0], wall.along[1], door.at.point());
    assert!((middle - 0.5 * length).abs() < 0.01);
    door.open && (x - middle).abs() < 0.5 * door.width && y.abs() <= 0.5 * wall.thickness
}

fn in_box(b: &Block, p: Point2<f64>) -> bool {
    let local = Rotation2::new(-b.rotation_deg.to_radians()) * (p - b.center.point());
    local.x.abs() < 0.5 * b.size[0] && local.y.abs() < 0.5 * b.size[1]
}

fn is_free(plan: &WorldPlan, p: Point2<f64>) -> bool {
    let carved =
        plan.corridor.iter().any(|c| on_stroke(&c.along, c.width, p)) || plan.room.iter().any(|r| in_outline(&r.corners, p));
    let open_ground = plan.corridor.is_empty() && plan.room.is_empty();
    let wall = plan.wall.iter().any(|w| on_stroke(&w.along, w.thickness, p)) && !plan.wall.iter().any(|w| in_door(w, p));
    let solid = wall
        || plan.polygon.iter().any(|s| in_outline(&s.corners, p))
        || plan.boxes.iter().any(|b| in_box(b, p))
        || plan.disc.iter().any(|d| (p - d.center.point()).norm() < d.radius);
    (carved || open_ground) && !solid
}

/// What the definition says at `p`, unless a border passes within `margin`.
fn clearly(plan: &WorldPlan, p: Point2<f64>, margin: f64) -> Option<bool> {
    let here = is_free(plan, p);
    let around = (0..8).map(|i| p + Rotation2::new(f64::from(i) * TAU / 8.0) * Vector2::new(margin, 0.0));
    around.into_iter().all(|q| is_free(plan, q) == here).then_some(here)
}

fn build(plan: &WorldPlan) -> World {
    World::from_plan(plan, &|_| unreachable!()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn a_point_is_free_where_the_definition_says_so(plan in plans(), points in proptest::collection::vec(places(), 200)) {
        let world = build(&plan);
        for p in points {
            if let Some(free) = clearly(&plan, p, 1e-4) {
                prop_assert_eq!(world.is_free(p), free, "at {}", p);
            }
        }
    }

    #[test]
    fn every_segment_parts_free_from_solid(plan in plans()) {
        let world = build(&plan);
        for s in &world.outline.segments {
            prop_assert!(s.length() > 1e-5);
            let middle = nalgebra::center(&s.a, &s.b);
            let hidden = world.outline.pillars.iter().any(|d| d.disc.distance(middle) < 1e-3);
            // In a crack the probe would land in the far side.
            let crack = world.outline.segments.iter().filter(|t| (t.nearest(middle) - middle).norm() < 2e-3).count() > 1;
            if s.length() > 1e-2 && !hidden && !crack {
                let (free, solid) = (middle + s.normal() * 1e-3, middle - s.normal() * 1e-3);
                prop_assert_ne!(clearly(&plan, free, 3e-4), Some(false), "left of {:?}", s);
                prop_assert_ne!(clearly(&plan, solid, 3e-4), Some(true), "right of {:?}", s);
            }
        }
    }

    #[test]
    fn a_corner_is_convex_where_most_of_its_surroundings_is_free(plan in plans()) {
        let world = build(&plan);
        for v in &world.outline.vertices {
            let lonely = world.outline.segments.iter().all(|s| (s.nearest(v.at) - v.at).norm() > 2e-3 || s.a == v.at || s.b == v.at)
                && world.outline.pillars.iter().all(|d| d.disc.distance(v.at) > 2e-3)
                && world.outline.segments.iter().filter(|s| s.a == v.at).count() == 1;
            if v.turn > 0.1 && lonely {
                let ring = (0..360).map(|i| v.at + Rotation2::new(f64::from(i) * TAU / 360.0) * Vector2::new(1e-3, 0.0));
                let free = ring.filter(|p| is_free(&plan, *p)).count();
                prop_assert_eq!(v.kind == Corner::Convex, free > 180, "{:?}: {} of 360 free", v, free);
            }
        }
    }

    #[test]
    fn the_order_of_elements_does_not_matter(plan in plans(), points in proptest::collection::vec(places(), 50)) {
        let mut reversed = plan.clone();
        reversed.wall.reverse();
        reversed.corridor.reverse();
        reversed.room.reverse();
        reversed.boxes.reverse();
        let (a, b) = (build(&plan), build(&reversed));
        prop_assert_eq!(a.outline.segments.len(), b.outline.segments.len());
        for p in points.into_iter().filter(|p| clearly(&plan, *p, 1e-4).is_some()) {
            prop_assert_eq!(a.is_free(p), b.is_free(p));
        }
    }
}

/// Ways to spoil a number.
const HOSTILE: [&str; 12] =
    ["nan", "inf", "-inf", "0", "-0.0", "1e308", "-500", "500", "1e-300", "9223372036854775807", "1e-3", "\"x\""];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn a_spoilt_number_is_refused_or_makes_another_world(which in any::<prop::sample::Index>(), hostile in prop::sample::select(&HOSTILE)) {
        let text = include_str!("../../configs/worlds/office-floor.toml");
        let body = text.find("[[corridor]]").unwrap();
        let is_number = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
        let mut numbers: Vec<(usize, usize)> = Vec::new();
        for (at, c) in text.char_indices().skip(body).filter(|(_, c)| is_number(*c)) {
            match numbers.last_mut() {
                Some((_, end)) if *end == at => *end = at + c.len_utf8(),
                _ => numbers.push((at, at + c.len_utf8())),
            }
        }
        let (from, to) = numbers[which.index(numbers.len())];
        let spoilt = format!("{}{hostile}{}", &text[..from], &text[to..]);
        if let Ok(world) = WorldPlan::parse(&spoilt).and_then(|plan| World::from_plan(&plan, &|_| unreachable!())) {
            prop_assert!(world.outline.segments.iter().all(|s| s.length().is_finite() && s.length() > 0.0));
        }
    }
}
