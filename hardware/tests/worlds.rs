//! The worlds that come with Orienteer, and what is said about worlds that make no sense.
#![allow(clippy::unwrap_used)]

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use nalgebra::Point2;
use orienteer_hardware::world::{
    World,
    disc_grid::DiscGrid,
    draw,
    geometry::{Corner, Disc},
    people::People,
    plan::WorldPlan,
};
use orienteer_runtime::random::Streams;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn shipped(name: &str) -> World {
    World::load(&root().join("configs/worlds").join(name), &|path| fs::read(path)).unwrap()
}

fn refused(toml: &str) -> String {
    let plan = WorldPlan::parse(toml).unwrap();
    World::from_plan(&plan, &|path| Err(io::Error::new(io::ErrorKind::NotFound, format!("no {}", path.display()))))
        .unwrap_err()
        .to_string()
}

/// Area of free space, by Green's theorem over the outline.
fn free_area(world: &World) -> f64 {
    let rings: f64 = world.outline.segments.iter().map(|s| 0.5 * s.a.coords.perp(&s.b.coords)).sum();
    let pillars: f64 = world.outline.pillars.iter().map(|p| std::f64::consts::PI * p.disc.radius.powi(2)).sum();
    rings - pillars
}

#[test]
fn every_shipped_world_loads() {
    let mut names: Vec<_> = fs::read_dir(root().join("configs/worlds")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert!(names.len() >= 5);
    for name in names {
        let world = shipped(name.to_str().unwrap());
        assert!(!world.name.is_empty() && !world.places.is_empty(), "{name:?}");
    }
}

#[test]
fn a_hallway_is_four_walls_at_the_written_coordinates() {
    let world = shipped("hallway.toml");
    assert_eq!(world.outline.segments.len(), 4);
    assert_eq!(world.outline.bounds.min, Point2::new(0.0, -1.23));
    assert_eq!(world.outline.bounds.max, Point2::new(20.0, 1.23));
    assert!(world.outline.vertices.iter().all(|v| v.kind == Corner::Concave));
}

#[test]
fn an_opening_has_two_clean_convex_corners() {
    for (file, width) in [("corridor-1.12.toml", 1.12), ("corridor-1.5.toml", 1.5)] {
        let world = shipped(file);
        let convex: Vec<_> = world.outline.vertices.iter().filter(|v| v.kind == Corner::Convex).map(|v| v.at).collect();
        assert_eq!(convex.len(), 2, "{file}");
        for x in [11.44, 12.56] {
            assert!(convex.contains(&Point2::new(x, -0.5 * width)), "{file}: {convex:?}");
        }
        assert_eq!(world.outline.segments.len(), 8, "{file}");
    }
}

#[test]
fn the_picture_of_the_office_floor_shows_its_free_space() {
    let world = shipped("office-floor.toml");
    let canvas = draw::outline(&world.outline, 0.02);
    canvas.image.save(Path::new(env!("CARGO_TARGET_TMPDIR")).join("office-floor.png")).unwrap();
    let white = canvas.image.pixels().filter(|p| **p == draw::FREE).count() as f64 * 0.02 * 0.02;
    assert!((white - free_area(&world)).abs() < 0.01 * white, "{white} m² drawn, {} m² free", free_area(&world));
}

#[test]
fn people_on_the_office_floor_never_touch_a_wall() {
    let world = shipped("office-floor.toml");
    let mut people = People::new(&world.people, &Streams::new(3));
    let mut robots = DiscGrid::default();
    robots.push(Disc::new(Point2::new(15.0, 5.2), 0.3));
    let names: Vec<_> = people.names().map(str::to_owned).collect();
    assert_eq!(names, ["Ada", "Ben", "Cleo"]);
    let mut walked = vec![0.0; names.len()];
    for _ in 0..6000 {
        people.advance(0.1, &robots);
        for (body, walked) in people.bodies().iter().zip(&mut walked) {
            assert!(!world.obstacles.overlaps(body.disc) && world.is_free(body.disc.center));
            *walked += body.velocity.norm() * 0.1;
        }
    }
    assert!(walked.iter().all(|d| *d > 50.0), "{walked:?}");
}

#[test]
fn the_depot_map_becomes_a_world_of_straight_walls() {
    let folder = root().join("../shared/data/ros-maps");
    if !folder.join("depot.yaml").exists() {
        eprintln!("skipped: {} is not there", folder.display());
        return;
    }
    let plan = WorldPlan::parse("[map]\nfile = \"depot.yaml\"").unwrap();
    let world = World::from_plan(&plan, &|path| fs::read(folder.join(path))).unwrap();
    let canvas = draw::outline(&world.outline, 0.025);
    canvas.image.save(Path::new(env!("CARGO_TARGET_TMPDIR")).join("depot.png")).unwrap();
    let exact = WorldPlan::parse("[map]\nfile = \"depot.yaml\"\ntolerance = 0").unwrap();
    let exact = World::from_plan(&exact, &|path| fs::read(folder.join(path))).unwrap();
    eprintln!("{} segments, {} before straightening", world.outline.segments.len(), exact.outline.segments.len());
    assert!(world.outline.segments.len() * 3 < exact.outline.segments.len());
    let size = world.outline.bounds.size();
    assert!(size.x > 25.0 && size.x < 30.5 && size.y > 13.0 && size.y < 15.5, "{size}");
    let (area, exact_area) = (-free_area(&world), -free_area(&exact));
    assert!((area - exact_area).abs() < 0.02 * exact_area, "{area} m² solid, {exact_area} m² by cells");
}

#[test]
fn errors_name_the_element() {
    let room = "[[room]]\nname = \"lab\"\ncorners = [[0, 0], [4, 3]]\n";
    for (toml, message) in [
        ("[[box]]\ncenter = [0, 0]\nsize = [1, nan]", "[[box]] 1: size is NaN, not within 0.01 to 500"),
        ("[[corridor]]\nalong = [[0, 0], [9, 0]]\nwidth = 0.0", "[[corridor]] 1: width is 0, not within 0.3 to 50"),
        ("[[wall]]\nalong = [[0, 0], [0, 0]]", "[[wall]] 1: points 1 and 2 of along are the same"),
        ("[[polygon]]\ncorners = [[0, 0], [2, 2], [2, 0], [0, 2]]", "[[polygon]] 1: sides 1 and 3 of its outline cross"),
        (
            &format!("{room}doors = [{{ at = [2, 0] }}]"),
            "[[room]] 1 \"lab\": the door at [2, 0] leads nowhere: there is no free space within 1.5 m behind the wall",
        ),
        (
            &format!("{room}doors = [{{ at = [0.3, 0] }}]"),
            "[[room]] 1 \"lab\": the door at [0.3, 0] is 0.88 m wide and sticks out 0.14 m past a corner",
        ),
        (
            &format!("{room}doors = [{{ at = [2, 1.2] }}]"),
            "[[room]] 1 \"lab\": the door at [2, 1.2] is 1.20 m away from its nearest wall",
        ),
        (&format!("{room}[[place]]\nname = \"out\"\nat = [9, 9]"), "[[place]] 1 \"out\": lies inside solid matter"),
        (
            &format!("{room}[[person]]\nname = \"Ada\"\npath = [[1, 1], [1, 5]]"),
            "[[person]] 1 \"Ada\": waypoint 2 is nearer to solid matter than the radius allows",
        ),
        (
            "[[wall]]\nalong = [[0, -1], [0, 1]]\n[[person]]\npath = [[-2, 0], [2, 0]]",
            "[[person]] 1: the way from waypoint 1 to 2 touches solid matter",
        ),
        ("[map]\nfile = \"gone.yaml\"", "[map]: can't read gone.yaml: no gone.yaml"),
    ] {
        assert_eq!(refused(toml), message);
    }
}

#[test]
fn a_door_joins_rooms_through_a_slanted_wall() {
    let toml = "
        [[room]]
        corners = [[0, 0], [4, 0], [4, 3], [0, 2]]
        doors = [{ at = [2, 2.5] }]
        [[corridor]]
        along = [[-2, 3], [6, 5]]
        width = 1.5";
    let world = World::from_plan(&WorldPlan::parse(toml).unwrap(), &|_| unreachable!()).unwrap();
    let leaf = Disc::new(Point2::new(2.25, 1.5), 0.43);
    let through = nalgebra::Vector2::new(-0.5, 2.0);
    assert!(world.obstacles.sweep(leaf, through).is_none(), "{:?}", world.obstacles.sweep(leaf, through));
    assert_eq!(world.outline.vertices.iter().filter(|v| v.kind == Corner::Convex).count(), 4);
}

#[test]
fn a_surface_has_the_reflectance_of_its_element() {
    let toml = "
        [[corridor]]
        along = [[0, 0], [10, 0]]
        width = 2.0
        [[room]]
        corners = [[2, 1.2], [8, 4]]
        doors = [{ at = [5, 1.2] }]
        reflectance = 0.6
        [[box]]
        center = [9, 0.8]
        size = [0.5, 0.4]
        reflectance = 0.3";
    let world = World::from_plan(&WorldPlan::parse(toml).unwrap(), &|_| unreachable!()).unwrap();
    let at = |x: f64, y: f64| {
        let p = Point2::new(x, y);
        let near = |s: &&orienteer_hardware::world::geometry::Segment| (s.nearest(p) - p).norm() < 1e-9;
        world.outline.segments.iter().find(near).map(|s| s.material.reflectance)
    };
    assert_eq!(at(4.0, 4.0), Some(0.6), "wall of the room");
    assert_eq!(at(4.56, 1.1), Some(0.6), "jamb of its door");
    assert_eq!(at(3.0, 1.0), Some(1.0), "wall of the corridor");
    assert_eq!(at(9.0, 0.6), Some(0.3), "front of the box");
    let corner = world.outline.vertices.iter().find(|v| v.at == Point2::new(4.56, 1.0)).unwrap();
    assert_eq!(corner.material.reflectance, 0.6, "the weaker of the two");
}

/// Every number that the schema of a world file knows has a least and a greatest value.
#[test]
fn every_number_of_a_world_file_has_a_range() {
    fn walk(value: &serde_json::Value, path: &str, numbers: &mut usize) {
        match value {
            serde_json::Value::Object(map) => {
                let is_number = |t: &serde_json::Value| t == "number" || t == "integer";
                let kind = map.get("type");
                if kind.is_some_and(|t| is_number(t) || t.as_array().is_some_and(|all| all.iter().any(is_number))) {
                    *numbers += 1;
                    assert!(map.contains_key("minimum") && map.contains_key("maximum"), "{path} has no range");
                }
                map.iter().for_each(|(key, inner)| walk(inner, &format!("{path}/{key}"), numbers));
            }
            serde_json::Value::Array(all) => all.iter().for_each(|inner| walk(inner, path, numbers)),
            _ => {}
        }
    }
    let schema = serde_json::to_value(schemars::schema_for!(WorldPlan)).unwrap();
    let mut numbers = 0;
    walk(&schema, "", &mut numbers);
    assert!(numbers > 25, "{numbers}");
}
