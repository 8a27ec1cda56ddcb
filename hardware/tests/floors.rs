//! Generated floors and junctions: their ground truth is held against the geometry that robots meet.
#![allow(clippy::unwrap_used)]

mod floors_support;

use std::collections::{BTreeMap, BTreeSet};

use floors_support::{Feature, Site, appendix_a, load};
use nalgebra::Point2;
use orienteer_hardware::world::{
    World,
    floors::{Floor, FloorError, FloorSpec, Heading, Hypothesis, Perturbation, Place, Truth, Width, junction_world},
    geometry::Disc,
    plan::WorldPlan,
};
use orienteer_runtime::random::Streams;
use proptest::prelude::*;

/// A number as people write it: JSON gives it back to the last bit.
fn short(number: f64) -> f64 {
    (1000.0 * number).round() / 1000.0
}

/// A floor of any kind, small enough to look at all of it.
fn specs() -> impl Strategy<Value = FloorSpec> {
    let number = |range: std::ops::Range<f64>| range.prop_map(short);
    let grid = (1..6_u32, 2..5_u32, number(0.0..1.0), number(0.0..1.0));
    let widths = prop::sample::subsequence(vec![Width::Exactly(1.12), Width::Exactly(1.5), Width::Between([1.0, 2.4])], 1..=3);
    let measures = (widths, number(3.0..8.0), number(0.0..2.0), number(0.0..10.0));
    let contents = (number(0.0..1.0), prop::sample::select(vec![0.88, 1.12]), number(0.0..1.0), 0..3_u32);
    (grid, measures, contents).prop_map(|((columns, rows, loops, dead_ends), (corridor_width, gap, jitter, more), contents)| {
        let (doors, door_width, boxes, people) = contents;
        let pitch = short(gap + jitter + 2.4 + more);
        let people = people.min(columns * rows - 1);
        let spec = FloorSpec {
            columns,
            rows,
            corridor_width,
            pitch,
            jitter,
            gap,
            loops,
            dead_ends,
            doors,
            door_width,
            boxes,
            ..FloorSpec::default()
        };
        FloorSpec { people, clear: 1.0, berth: 0.4, ..spec }
    })
}

/// A floor with nothing in its corridors; `None` if a straight corridor leaves no place for the people asked for.
fn floor(seed: u64, spec: &FloorSpec) -> Option<Floor> {
    match Floor::generate(seed, spec) {
        Ok(floor) => Some(floor),
        Err(FloorError::Crowded { .. } | FloorError::NoRoomForBoxes { .. }) => None,
        Err(other) => panic!("{other}: {spec:?}"),
    }
}

/// How far one gets from a point before something solid, m; at most `reach`.
fn ray(world: &World, from: Point2<f64>, heading: Heading, reach: f64) -> f64 {
    let hit = world.obstacles.sweep(Disc::new(from, 1e-4), heading.vector() * reach);
    hit.map_or(reach, |hit| hit.share * reach)
}

/// Every corridor of a place is open over its whole width for 2 m, and where there is neither corridor nor doorway is wall.
fn arms_are_open_and_nothing_else(world: &World, place: &Place) {
    for heading in Heading::ALL {
        if let Some(arm) = place.arm(heading) {
            for share in [-0.49, 0.0, 0.49] {
                let mouth = place.point() + heading.vector() * arm.mouth;
                let from = mouth + heading.left().vector() * (share * arm.width);
                assert!(ray(world, from, heading, 2.0) == 2.0, "{} {heading:?}", place.name);
            }
            continue;
        }
        let across = [heading.left(), heading.right(), heading.back()].into_iter().find_map(|side| place.arm(side)).unwrap();
        let open = ray(world, place.point(), heading, 6.0);
        match place.doorways.iter().find(|doorway| doorway.side == heading) {
            Some(doorway) => assert!(open > 0.5 * across.width + doorway.thickness + 1.9, "{} {heading:?}: {open}", place.name),
            None => assert!((open - 0.5 * across.width).abs() < 2e-3, "{} {heading:?}: {open}", place.name),
        }
    }
}

/// Corridors join the places as the truth has it: each arm is one end of one corridor, and each corridor is as long as it says.
fn corridors_join_places(truth: &Truth) {
    let mut ends = BTreeSet::new();
    for corridor in &truth.corridors {
        let [from, to] = [&corridor.from, &corridor.to].map(|end| (truth.place(&end.place).unwrap(), end.arm));
        assert!([Heading::East, Heading::North].contains(&from.1) && to.1 == from.1.back());
        let way = from.1.vector() * corridor.length;
        assert!((from.0.point() + way - to.0.point()).norm() < 2e-3, "{corridor:?}");
        for (place, heading) in [from, to] {
            let arm = place.arm(heading).unwrap();
            assert_eq!(arm.width, corridor.width);
            assert!(ends.insert((place.name.clone(), heading)), "{corridor:?} is there twice");
        }
        let wall = corridor.length - from.0.arm(from.1).unwrap().mouth - to.0.arm(to.1).unwrap().mouth;
        assert!(wall > truth.spec.gap - 2e-3, "{wall} m between {corridor:?}");
    }
    assert_eq!(ends.len(), truth.places.iter().map(|place| place.arms.len()).sum::<usize>());
}

fn is_connected(truth: &Truth) -> bool {
    let mut part: BTreeMap<&str, usize> = truth.places.iter().enumerate().map(|(i, place)| (place.name.as_str(), i)).collect();
    for corridor in &truth.corridors {
        let (keep, drop) = (part[corridor.from.place.as_str()], part[corridor.to.place.as_str()]);
        part.values_mut().filter(|it| **it == drop).for_each(|it| *it = keep);
    }
    part.values().collect::<BTreeSet<_>>().len() == 1
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn the_truth_is_what_a_robot_meets(seed: u64, spec in specs()) {
        let Some(floor) = floor(seed, &FloorSpec { people: 0, ..spec.clone() }) else { return Ok(()) };
        prop_assert!(is_connected(&floor.truth));
        corridors_join_places(&floor.truth);
        // Boxes begin half a metre sooner than rays end.
        let world = load(&WorldPlan { boxes: Vec::new(), ..floor.plan.clone() });
        for place in &floor.truth.places {
            arms_are_open_and_nothing_else(&world, place);
        }
        for corridor in &floor.truth.corridors {
            let from = floor.truth.place(&corridor.from.place).unwrap().point();
            prop_assert_eq!(ray(&world, from, corridor.from.arm, corridor.length), corridor.length);
        }
    }

    #[test]
    fn a_text_is_the_world_that_it_was_made_from(seed: u64, spec in specs()) {
        let Some(floor) = floor(seed, &spec) else { return Ok(()) };
        let read = WorldPlan::parse(&floor.text()).unwrap();
        prop_assert_eq!(&read, &floor.plan);
        let world = load(&read);
        prop_assert_eq!(world.places.len(), floor.truth.places.len());
        prop_assert_eq!(world.people.len(), spec.people as usize);
        let truth = serde_json::to_string(&floor.truth).unwrap();
        prop_assert_eq!(serde_json::from_str::<Truth>(&truth).unwrap(), floor.truth.clone());
        let again = Floor::generate(seed, &floor.truth.spec).unwrap();
        prop_assert_eq!(&again, &floor);
    }

    #[test]
    fn boxes_leave_room_to_pass_and_keep_off_places(seed: u64, spec in specs()) {
        let spec = FloorSpec { boxes: 1.0, people: 0, ..spec };
        let Some(floor) = floor(seed, &spec) else { return Ok(()) };
        let world = load(&floor.plan);
        for it in &floor.plan.boxes {
            let wide = it.size[0] > it.size[1];
            let sides = if wide { [Heading::North, Heading::South] } else { [Heading::East, Heading::West] };
            let half = 0.5 * it.size[usize::from(wide)];
            let beside = |side: Heading| it.center.point() + side.vector() * (half + 1e-3);
            let passage = sides.map(|side| if world.is_free(beside(side)) { ray(&world, beside(side), side, 6.0) } else { 0.0 });
            let free = passage[0].max(passage[1]) + 1e-3;
            let to_middle = 0.5 * (free + 2.0 * half) - 2.0 * half;
            prop_assert!(to_middle > spec.berth - 2e-3, "{it:?}: {passage:?}");
            prop_assert!(passage.contains(&0.0), "{it:?} stands at no wall");
            for place in &floor.truth.places {
                let off = (it.center.point() - place.point()).abs();
                let apart = [off.x - 0.5 * it.size[0], off.y - 0.5 * it.size[1]];
                prop_assert!(apart.iter().any(|gap| *gap > spec.clear), "{it:?} at {}", place.name);
            }
        }
    }

    #[test]
    fn rooms_have_walls_all_round_but_for_their_doors(seed: u64, spec in specs()) {
        let Some(floor) = floor(seed, &FloorSpec { doors: 1.0, people: 0, boxes: 0.0, ..spec }) else { return Ok(()) };
        let world = load(&floor.plan);
        for room in &floor.plan.room {
            let [low, high] = [room.corners[0].point(), room.corners[1].point()];
            let door = &room.doors[0];
            let steps = |from: f64, to: f64| (0..=((to - from) / 0.05) as u32).map(move |i| from + 0.05 * f64::from(i));
            let across = steps(low.x, high.x).flat_map(|x| [low.y - 0.07, high.y + 0.07].map(|y| Point2::new(x, y)));
            let along = steps(low.y, high.y).flat_map(|y| [low.x - 0.07, high.x + 0.07].map(|x| Point2::new(x, y)));
            for point in across.chain(along) {
                let off = (point - door.at.point()).abs();
                let in_door = off.x.max(off.y) < 0.5 * door.width + 1e-6 && off.x.min(off.y) < 0.08;
                prop_assert!(in_door || !world.is_free(point), "{room:?} is open at {point}");
            }
        }
    }

    #[test]
    fn what_a_place_is_called_is_what_its_walls_make_it(seed: u64, columns in 2..6_u32, rows in 2..5_u32, pitch in 9.0..20.0) {
        let floor = Floor::generate(seed, &FloorSpec { columns, rows, pitch, doors: 1.0, ..FloorSpec::default() }).unwrap();
        let world = load(&floor.plan);
        for arm in floor.truth.places.iter().flat_map(|place| &place.arms) {
            if arm.meets == Hypothesis::DeadEnd {
                continue;
            }
            let site = Site { world: &world, start: arm.start, half: 50.0 * arm.width, far: 8.0 + 200.0 * arm.mouth, wall: 14.0 };
            let found: Vec<Feature> = Feature::ALL.into_iter().filter(|feature| site.has(*feature)).collect();
            prop_assert_eq!(found, appendix_a(arm.meets), "{}", arm.meets);
        }
    }

    #[test]
    fn a_perturbed_junction_has_the_features_of_its_hypothesis(seed: u64, which in 0..12_usize) {
        let mut random = Streams::new(seed).stream("test", "perturbation");
        let perturbation = Perturbation::draw(0.1, &mut random);
        let junction = junction_world(Hypothesis::ALL[which], &perturbation).unwrap();
        let arm = *junction.place.arm(Heading::South).unwrap();
        prop_assert_eq!(arm.start, junction.start);
        prop_assert!((arm.width / 1.12 - perturbation.corridor).abs() < 2e-3);
        prop_assert!((arm.mouth / 0.56 - perturbation.opening).abs() < 2e-3);
        prop_assert_eq!(&WorldPlan::parse(&junction.text()).unwrap(), &junction.plan);
        let world = load(&junction.plan);
        let wall = junction.place.doorways.first().map_or(14.0, |doorway| 100.0 * doorway.thickness);
        let site = Site { world: &world, start: arm.start, half: 50.0 * arm.width, far: 8.0 + 200.0 * arm.mouth, wall };
        for feature in appendix_a(junction.hypothesis) {
            prop_assert!(site.has(feature), "{feature:?} of {}", junction.hypothesis);
        }
        arms_are_open_and_nothing_else(&world, &junction.place);
    }
}

/// The table of appendix A, cell by cell, from the reference worlds: 37 of the 156 are features.
#[test]
fn the_reference_worlds_have_exactly_the_features_of_appendix_a() {
    let mut cells = 0;
    for hypothesis in Hypothesis::ALL.into_iter().filter(|it| *it != Hypothesis::DeadEnd) {
        let junction = junction_world(hypothesis, &Perturbation::NONE).unwrap();
        let world = load(&junction.plan);
        let site = Site { world: &world, start: junction.start, half: 56.0, far: 120.0, wall: 14.0 };
        let found: Vec<Feature> = Feature::ALL.into_iter().filter(|feature| site.has(*feature)).collect();
        assert_eq!(found, appendix_a(hypothesis), "{hypothesis}");
        cells += found.len();
    }
    assert_eq!(cells, 37);
}

#[test]
fn a_dead_end_ends() {
    let junction = junction_world(Hypothesis::DeadEnd, &Perturbation::NONE).unwrap();
    let world = load(&junction.plan);
    assert_eq!(world.outline.segments.len(), 4);
    assert!((ray(&world, Point2::origin(), Heading::North, 2.0) - 0.56).abs() < 2e-3);
    assert!(ray(&world, Point2::origin(), Heading::South, 6.0) == 6.0);
}

#[test]
fn every_hypothesis_is_met_somewhere() {
    let mut met = BTreeSet::new();
    for seed in 0..12 {
        let floor = Floor::generate(seed, &FloorSpec::default()).unwrap();
        met.extend(floor.truth.places.iter().flat_map(|place| place.arms.iter().map(|arm| arm.meets)));
    }
    assert_eq!(met.into_iter().collect::<Vec<_>>(), Hypothesis::ALL);
}

#[test]
fn a_grid_grows_until_it_has_the_places() {
    for places in [2, 3, 10, 40] {
        let spec = FloorSpec { places: Some(places), ..FloorSpec::default() };
        let floor = Floor::generate(3, &spec).unwrap();
        let found = floor.truth.places.len();
        assert!(found >= places as usize && found <= 2 * places as usize + 2, "{found} for {places}");
        assert_eq!(Floor::generate(3, &floor.truth.spec).unwrap(), floor, "columns and rows give it again");
    }
    let spec = FloorSpec { places: Some(1600), pitch: 60.0, doors: 0.0, ..FloorSpec::default() };
    let error = Floor::generate(3, &spec).unwrap_err();
    assert!(matches!(error, FloorError::TooFewPlaces { wanted: 1600, .. }) && !error.hint().is_empty(), "{error}");
}

#[test]
fn more_furniture_moves_no_wall() {
    let bare = Floor::generate(9, &FloorSpec::default()).unwrap();
    let full = Floor::generate(9, &FloorSpec { boxes: 1.0, people: 3, ..FloorSpec::default() }).unwrap();
    assert_eq!((&bare.plan.corridor, &bare.plan.room), (&full.plan.corridor, &full.plan.room));
    assert_eq!((bare.plan.boxes.len(), full.plan.person.len()), (0, 3));
    assert!(full.plan.boxes.len() > 3);
}

/// What any machine writes for this seed.
#[test]
fn a_floor_is_the_same_everywhere() {
    let spec = FloorSpec { columns: 3, rows: 3, pitch: 16.0, doors: 0.4, boxes: 0.3, people: 1, ..FloorSpec::default() };
    insta::assert_snapshot!(Floor::generate(4, &spec).unwrap().text());
}
