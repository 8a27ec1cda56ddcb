//! What a good mission means, and that the schema for editors agrees.
#![allow(clippy::unwrap_used)]

mod config_support;

use config_support::{Avoidance, Fake, Follower, MISSION, Strategy, load, sources};
use orienteer_runtime::{
    config::{
        Mission, Section, Sources,
        mission::{StartAt, WorldKind, schema},
        validate::{Rules, check, no_names},
    },
    geometry::Pose,
};

#[test]
fn templates_repetition_and_overrides() {
    let mut sources = sources(MISSION);
    let id = sources.read("mission.toml").unwrap();
    let mission = Mission::load(&mut sources, id, &Fake::default()).unwrap();
    assert_eq!(mission.settings.name, "office floor");
    assert_eq!(mission.world.as_ref().map(|world| world.kind), Some(WorldKind::File));
    assert_eq!(sources.files().iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["mission.toml", "worlds/office.toml"]);
    let names: Vec<&str> = mission.robots.iter().map(|robot| robot.name.as_str()).collect();
    assert_eq!(names, ["ann", "bob-1", "bob-2", "bob-3", "real"]);

    let [ann, bob, _, third, real] = mission.robots.as_slice() else { unreachable!() };
    let agents: Vec<&str> = ann.agents.iter().map(|agent| agent.name.as_str()).collect();
    assert_eq!(agents, ["where-am-i", "avoidance", "corridor-follower", "draw"]);
    assert_eq!(ann.agents[3].kind, "mapper");
    assert_eq!(ann.start.as_ref().unwrap().at, StartAt::Pose(Pose::new(1.0, 2.0, std::f64::consts::FRAC_PI_2)));
    assert_eq!((ann.agents[1].priority, ann.agents[1].deadline), (20, Some(0.005)));
    let avoidance: Avoidance = ann.agents[1].section.deserialize(&sources).unwrap();
    assert_eq!((avoidance.clearance, avoidance.escape_speed), (0.5, 0.2));
    assert!(matches!(avoidance.strategy, Strategy::Retreat { distance: 0.7 }));

    let follower: Follower = bob.agents[2].section.deserialize(&sources).unwrap();
    assert_eq!((follower.speed, follower.width), (0.2, (1.0, 2.5)));
    let start = third.start.as_ref().unwrap();
    assert!(matches!(&start.at, StartAt::Place { name, heading: Some(_) } if name == "north"));
    assert_eq!(start.offset, (0.0, 1.5));

    // Another driver stands alone: nothing of the simulated one is left.
    assert_eq!(serde_json::to_string(&real.base.section).unwrap(), r#"{"port":"/dev/ttyUSB0"}"#);
    assert_eq!(real.disabled.iter().map(|agent| agent.name.as_str()).collect::<Vec<_>>(), ["avoidance"]);
    assert_eq!(real.agents.len(), 2);
    // A value of a template is still known to stand in the template.
    let place = sources.locate(&real.agents[1].section.span_of("speed")).unwrap();
    assert_eq!(place.to_string(), "mission.toml:36:9");
}

#[test]
fn what_a_recording_carries_loads_the_same_mission() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("worlds")).unwrap();
    std::fs::write(folder.path().join("mission.toml"), MISSION).unwrap();
    std::fs::write(folder.path().join("worlds/office.toml"), config_support::WORLD).unwrap();
    let (mut disk, id) = Sources::open(folder.path().join("mission.toml")).unwrap();
    let first = Mission::load(&mut disk, id, &Fake::default()).unwrap();
    let carried: Vec<(String, Vec<u8>)> = disk.files().iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect();
    let mut memory = Sources::embedded(carried);
    let id = memory.read("mission.toml").unwrap();
    let again = Mission::load(&mut memory, id, &Fake::default()).unwrap();
    assert_eq!(serde_json::to_string(&first).unwrap(), serde_json::to_string(&again).unwrap());
    assert_eq!(disk.files(), memory.files());
}

#[test]
fn the_least_mission() {
    let mission = load("[[robot]]\nname = 'r'\nbase = { driver = 'arcos', port = 'tcp:8101' }").unwrap();
    assert_eq!((mission.settings.name.as_str(), mission.settings.control_rate_hz), ("mission", 20.0));
    assert!(mission.world.is_none() && mission.record.enabled && mission.robots[0].sonar.is_none());
}

/// The text as the reader of the schema sees it.
fn against_schema(text: &str) -> Vec<String> {
    let schema = schemars::Schema::try_from(schema(&Fake::default())).unwrap();
    let mut sources = sources(text);
    let id = sources.read("mission.toml").unwrap();
    let section = Section::parse(&sources, id).unwrap();
    let rules =
        Rules { schema: &schema, common: None, partial: false, name: "the mission", names: &no_names, elsewhere: &|_| None };
    check(&section, &rules, &sources).iter().map(ToString::to_string).collect()
}

#[test]
fn the_schema_for_editors_knows_kinds_drivers_and_names() {
    assert_eq!(against_schema(MISSION), [""; 0]);
    let changed = |from: &str, to: &str| {
        assert!(MISSION.contains(from));
        against_schema(&MISSION.replace(from, to)).join("\n")
    };
    assert!(changed("clearance", "clearanse").contains("did you mean `clearance`?"));
    assert!(changed("ring = \"denning-16\"", "ring = \"denning-15\"").contains("did you mean `denning-16`?"));
    assert!(changed("distance = 0.7", "distance = 70").contains("above the maximum of 5"));
    assert!(changed("cell = 0.05", "sell = 0.05").contains("unknown key `sell`"));
    assert!(changed("driver = \"arcos\"", "driver = \"arkos\"").contains("did you mean `arcos`?"));
}

#[test]
fn the_schema_resolves_all_its_references() {
    let schema = schema(&Fake::default());
    let mut references = Vec::new();
    fn gather(value: &serde_json::Value, references: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(object) => {
                references.extend(object.get("$ref").and_then(|target| target.as_str()).map(str::to_owned));
                object.values().for_each(|value| gather(value, references));
            }
            serde_json::Value::Array(values) => values.iter().for_each(|value| gather(value, references)),
            _ => {}
        }
    }
    gather(&schema, &mut references);
    assert!(references.len() > 20);
    for reference in references {
        assert!(schema.pointer(reference.strip_prefix('#').unwrap()).is_some(), "{reference}");
    }
}
