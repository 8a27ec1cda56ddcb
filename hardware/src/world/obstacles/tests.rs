#![allow(clippy::unwrap_used)]

use proptest::prelude::*;

use super::*;
use crate::world::geometry::{Material, Pillar};

fn points() -> impl Strategy<Value = Point2<f64>> {
    (-12.0..12.0, -8.0..8.0).prop_map(|(x, y)| Point2::new(x, y))
}

fn outlines() -> impl Strategy<Value = Outline> {
    let lines = proptest::collection::vec((points(), (-3.0..3.0, -3.0..3.0)), 0..30);
    let pillars = proptest::collection::vec((points(), 0.05..2.0), 0..5);
    (lines, pillars).prop_map(|(lines, pillars)| {
        let lines: Vec<_> = lines.into_iter().map(|(p, (x, y))| vec![p, p + Vector2::new(x, y)]).collect();
        let mut outline = Outline::from_polylines(&lines);
        outline.pillars =
            pillars.into_iter().map(|(c, r)| Pillar { disc: Disc::new(c, r), material: Material::default() }).collect();
        let rims = outline.pillars.iter().map(|p| Bounds { min: p.disc.center, max: p.disc.center }.grown(p.disc.radius));
        outline.bounds = rims.fold(outline.bounds, |all, b| all.union(&b));
        outline
    })
}

fn brute_nearest(outline: &Outline, p: Point2<f64>) -> f64 {
    let flat = outline.segments.iter().map(|s| (s.nearest(p) - p).norm());
    let round = outline.pillars.iter().map(|d| d.disc.distance(p).max(0.0));
    flat.chain(round).fold(f64::INFINITY, f64::min)
}

proptest! {
    #[test]
    fn nearest_agrees_with_a_plain_loop(
        outline in outlines(), crumbs in proptest::collection::vec(points(), 0..300),
        from in proptest::collection::vec(points(), 30), reach in 0.0..30.0f64
    ) {
        // Many short pieces, so that the nearest is often in a later ring of cells than the first that is found.
        let crumbs: Vec<_> = crumbs.into_iter().map(|p| vec![p, p + Vector2::new(0.02, 0.01)]).collect();
        let mut all = Outline::from_polylines(&crumbs);
        all.segments.extend(&outline.segments);
        all.pillars.extend(&outline.pillars);
        all.bounds = all.bounds.union(&outline.bounds);
        let grid = Obstacles::new(&all);
        for from in from {
            let expected = brute_nearest(&all, from);
            match grid.nearest(from, reach) {
                Some(contact) => prop_assert!((contact.distance - expected).abs() < 1e-12),
                None => prop_assert!(expected > reach),
            }
        }
    }

    #[test]
    fn a_sweep_stops_at_the_first_touch(outline in outlines(), from in points(), to in points(), radius in 0.05..0.6f64) {
        let grid = Obstacles::new(&outline);
        let by = to - from;
        prop_assume!(brute_nearest(&outline, from) > radius + 1e-6);
        let share = grid.sweep(Disc::new(from, radius), by).map_or(1.0, |hit| hit.share);
        // Free all the way up to the touch: no point of the way is nearer than the radius.
        for i in 0..=400 {
            let p = from + by * (share * f64::from(i) / 400.0);
            prop_assert!(brute_nearest(&outline, p) >= radius - 1e-7);
        }
        if let Some(hit) = grid.sweep(Disc::new(from, radius), by) {
            let center = from + by * hit.share;
            prop_assert!((brute_nearest(&outline, center) - radius).abs() < 1e-7);
            prop_assert!((center - hit.at - hit.normal * radius).norm() < 1e-7);
        }
    }

    #[test]
    fn a_body_that_goes_on_as_far_as_it_may_never_gets_into_anything(
        outline in outlines(), from in points(), steps in proptest::collection::vec((-0.4..0.4, -0.4..0.4), 1..60)
    ) {
        let grid = Obstacles::new(&outline);
        let radius = 0.2;
        prop_assume!(brute_nearest(&outline, from) > radius);
        let mut body = Disc::new(from, radius);
        for (x, y) in steps {
            let by = Vector2::new(x, y);
            body.center += by * grid.sweep(body, by).map_or(1.0, |hit| hit.share);
            prop_assert!(brute_nearest(&outline, body.center) > radius - 1e-6);
        }
    }
}

#[test]
fn a_body_at_a_wall_may_slide_and_leave_but_not_press() {
    let wall = Outline::from_polylines(&[vec![Point2::new(0.0, 0.0), Point2::new(10.0, 0.0)]]);
    let grid = Obstacles::new(&wall);
    let body = Disc::new(Point2::new(5.0, 0.2), 0.2);
    assert!(grid.sweep(body, Vector2::new(1.0, 0.0)).is_none());
    assert!(grid.sweep(body, Vector2::new(1.0, 0.1)).is_none());
    assert_eq!(grid.sweep(body, Vector2::new(1.0, -0.1)).unwrap().share, 0.0);
    assert!(!grid.overlaps(body) && grid.overlaps(Disc::new(body.center, 0.21)));
}

#[test]
fn an_empty_world_stops_nothing() {
    let grid = Obstacles::new(&Outline::from_polylines(&[]));
    assert!(grid.nearest(Point2::new(3.0, 4.0), 1e9).is_none());
    assert!(grid.sweep(Disc::new(Point2::origin(), 1.0), Vector2::new(1e6, 0.0)).is_none());
}
