//! Robots of several makes, each with its own ring, on the office floor.
#![allow(clippy::unwrap_used, missing_docs)]

use orienteer::{
    Registry,
    mission::{self, RunOptions},
};

fn patrol(platform: &str, ring: &str, seed: u64) -> mission::Outcome {
    let world = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/worlds/office-floor.toml");
    let text = format!(
        "[mission]\nduration = 120\nlinks = 'direct'\n[record]\nenabled = false\n[world]\nfile = 'office-floor.toml'\n\
         [[robot]]\nname = 'r'\nstart.place = 'south-west'\nbase = {{ driver = 'sim', platform = '{platform}' }}\n\
         sonar = {{ driver = 'sim', ring = '{ring}' }}\n[robot.agent.where-am-i]\n[robot.agent.avoidance]\npriority = 10\n\
         [robot.agent.corridor-follower]\npriority = 5\ncruise_speed = 0.3\n[robot.agent.patrol]\npriority = 4\n"
    );
    let files = [("mission.toml".to_owned(), text.into_bytes()), ("office-floor.toml".to_owned(), std::fs::read(world).unwrap())];
    let loaded = mission::load_files(files, "mission.toml", &Registry::standard()).unwrap();
    mission::run(loaded, &Registry::standard(), RunOptions { seed: Some(seed), ..RunOptions::default() }).unwrap()
}

/// Three seeds each: twelve patrols of two minutes, and none drives into anything.
#[test]
fn robots_with_a_ring_to_see_by_patrol_a_floor() {
    for (platform, ring) in
        [("p3dx", "p3dx-16"), ("amigobot", "amigobot-8"), ("b12-huey", "denning-16"), ("b12-luey", "luey-8-square")]
    {
        for seed in 1..=3 {
            let outcome = patrol(platform, ring, seed);
            let fact = |name| outcome.robots[0].fact(name).unwrap();
            assert_eq!(fact("collisions"), 0.0, "{platform}, seed {seed}");
            assert!(fact("distance_m") > 5.0, "{platform}, seed {seed}: {} m", fact("distance_m"));
        }
    }
}

/// A Pioneer that somebody has put down a hand's breadth or less from a wall, into a corner, or before one, whichever way it looks: it
/// has gone its way within two minutes and a half, and touched nothing.
#[test]
fn a_robot_that_was_put_down_at_a_wall_or_in_a_corner_gets_away() {
    let ring = "[[room]]\ncorners = [[0, 0], [14, 12]]\n[[box]]\ncenter = [7, 6]\nsize = [10.4, 8.4]\n";
    for (x, y) in [(13.72, 5.0), (13.6, 3.0), (13.72, 0.28), (0.4, 11.6), (1.78, 1.48)] {
        for heading in (-180..180).step_by(60) {
            let text = format!(
                "[mission]\nduration = 150\nlinks = 'direct'\n[record]\nenabled = false\n[world]\nfile = 'ring.toml'\n[[robot]]\n\
                 name = 'r'\nstart = {{ x = {x}, y = {y}, heading_deg = {heading} }}\nbase = {{ driver = 'sim', platform = 'p3dx' }}\n\
                 sonar = {{ driver = 'sim', ring = 'p3dx-16' }}\n[robot.agent.where-am-i]\n[robot.agent.avoidance]\n\
                 [robot.agent.corridor-follower]\ncruise_speed = 0.3\n[robot.agent.patrol]\nleast_width = 1.4\n"
            );
            let files = [("mission.toml".to_owned(), text.into_bytes()), ("ring.toml".to_owned(), ring.as_bytes().to_vec())];
            let loaded = mission::load_files(files, "mission.toml", &Registry::standard()).unwrap();
            let outcome = mission::run(loaded, &Registry::standard(), RunOptions::default()).unwrap();
            let fact = |name| outcome.robots[0].fact(name).unwrap();
            assert_eq!(fact("collisions"), 0.0, "at ({x}, {y}), {heading} deg");
            assert!(fact("distance_m") > 4.0, "at ({x}, {y}), {heading} deg: {} m", fact("distance_m"));
        }
    }
}

/// A robot that only feels, in a room with two pillars: five minutes on each of five seeds. It touches what it meets, never stays there,
/// and gets everywhere.
#[test]
fn a_robot_with_nothing_but_a_bumper_wanders_about() {
    let text = "[mission]\nduration = 300\nlinks = 'direct'\n[record]\nenabled = false\n[world]\nfile = 'room.toml'\n[[robot]]\n\
                name = 'r'\nbase = { driver = 'sim', platform = 'amigobot', protection = { sonar_required = false } }\n\
                [robot.agent.wander]\n";
    let room = "[[room]]\ncorners = [[-3, -2], [3, 2]]\n[[disc]]\ncenter = [1.5, 0.5]\nradius = 0.2\n\
                [[disc]]\ncenter = [-1.5, -0.5]\nradius = 0.3\n";
    for seed in 1..=5 {
        let files = [("mission.toml".to_owned(), text.as_bytes().to_vec()), ("room.toml".to_owned(), room.as_bytes().to_vec())];
        let loaded = mission::load_files(files, "mission.toml", &Registry::standard()).unwrap();
        let outcome =
            mission::run(loaded, &Registry::standard(), RunOptions { seed: Some(seed), ..RunOptions::default() }).unwrap();
        let fact = |name| outcome.robots[0].fact(name).unwrap();
        // Half of the time goes for backing off and turning.
        assert!(
            fact("driving_s") > 200.0 && fact("touched") > 8.0,
            "seed {seed}: {:?}",
            outcome.robots[0].facts().collect::<Vec<_>>()
        );
        assert!(fact("collisions") <= fact("touched") + 1.0 && fact("held") <= 2.0, "seed {seed}");
    }
}

#[test]
fn where_a_ring_is_blind_is_told() {
    let text = "[[robot]]\nname = 'r'\nbase = { driver = 'sim' }\nsonar = { driver = 'sim', custom = { transducer = [{ x = 0, y = 0, bearing_deg = 0 }, { x = 0, y = 0, bearing_deg = 90 }] } }\n\
                [robot.agent.where-am-i]\n[robot.agent.corridor-follower]\nautostart = true\n";
    let hall = "[world]\nfile = 'hall.toml'\n";
    let files = [
        ("mission.toml".to_owned(), format!("{hall}{text}").into_bytes()),
        ("hall.toml".to_owned(), b"[[room]]\ncorners = [[-4, -4], [4, 4]]\n".to_vec()),
    ];
    let loaded = mission::load_files(files, "mission.toml", &Registry::standard()).unwrap();
    let told = mission::run(loaded, &Registry::standard(), RunOptions::default()).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("looks to the right"), "{told}");
}
