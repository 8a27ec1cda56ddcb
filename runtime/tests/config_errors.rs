//! Mistakes that people make, and what they are told. Read the snapshots as a user would.
#![allow(clippy::unwrap_used)]

mod config_support;

use config_support::{Fake, MISSION, load, sources};
use orienteer_runtime::config::{Mission, Problems};

/// The mission with one piece of text replaced.
fn with(from: &str, to: &str) -> String {
    assert_eq!(MISSION.matches(from).count(), 1, "{from} is not in the mission exactly once");
    MISSION.replace(from, to)
}

fn problems(text: &str) -> Problems {
    match load(text) {
        Err(problems) => problems,
        Ok(_) => panic!("this was accepted:\n{text}"),
    }
}

macro_rules! told {
    ($($name:ident: $text:expr;)*) => {$(
        #[test]
        fn $name() {
            let mut settings = insta::Settings::clone_current();
            settings.set_snapshot_path("config_snapshots");
            settings.set_prepend_module_to_snapshot(false);
            settings.set_omit_expression(true);
            settings.bind(|| insta::assert_snapshot!(stringify!($name), problems($text.as_ref()).render(false)));
        }
    )*};
}

told! {
    unknown_key: with("duration = 600.0", "durration = 600.0");
    key_of_another_table: with("[record]\nfile = \"out/office.mcap\"\n", "file_ = 1\nseed = 1\n");
    lost_header: with("[template.huey.agent.avoidance]\n", "");
    wrong_type: with("seed = 7", "seed = \"7\"");
    unit_in_value: with("duration = 600.0", "duration = \"10 min\"");
    unquoted_unit: with("duration = 600.0", "duration = 10 min");
    out_of_range: with("clearance = 0.5", "clearance = 40");
    out_of_range_in_template_of_template: with("noise = 0.02", "noise = 20");
    not_a_number: with("clearance = 0.5", "clearance = nan");
    fraction_for_whole: with("threads = 2", "threads = 2.5");
    name_of_run: with("links = \"shared\"", "run = \"my run\"");
    name_that_leaves_the_directory: with("name = \"office floor\"", "name = \"../evil\"");
    run_nobody_can_attach_to: with("links = \"shared\"", "links = \"local\"\nrun = \"office\"");
    recording_without_its_ending: with("out/office.mcap", "worlds/");
    recording_that_is_switched_off: with("enabled = true", "enabled = false");
    hardware_at_no_place: with("name = \"ann\"", "name = \"ann\"\nhardware = \"elswhere\"");
    unknown_choice: with("links = \"shared\"", "links = \"shard\"");
    unknown_variant: with("kind = \"retreat\"", "kind = \"retreet\"");
    too_few_values: with("width = [1.0, 2.5]", "width = [1.0]");
    duplicate_key: with("seed = 7", "seed = 7\nduration = 60");
    duplicate_table: with("[record]", "[mission]");
    unquoted_text: with("links = \"shared\"", "links = shared");
    decimal_comma: with("speed = 0.3", "speed = 0,3");
    unclosed_text: with("name = \"ann\"", "name = \"ann");
    unclosed_list: with("width = [1.0, 2.5]", "width = [1.0, 2.5");
    unclosed_inline_table: with("distance = 0.7 }", "distance = 0.7");
    colon_for_equals: with("seed = 7", "seed: 7");
    hash_in_key: with("seed = 7", "se#ed = 7");
    no_value: with("seed = 7", "seed =");
    invisible_character: with("seed = 7", "seed = \u{202e}7");
    control_character_in_text: with("\"office floor\"", "\"office\u{1}floor\"");
    too_many_commas: with("[1.0, 2.5]", "[1.0,, 2.5]");
    value_extended: with("[robot.agent.corridor-follower]", "[robot.start.corridor-follower]");
    lost_robot_header: with("[[robot]]\nname = \"bob\"\n", "name = \"bob\"\n");
    keys_of_another_driver: with("driver = \"sim\", ring", "driver = \"arcos\", ring");
    slash_comment: with("#:schema", "//");
    missing_world_file: with("worlds/office.toml", "worlds/ofice.toml");
    no_world: with("[world]\nfile = \"worlds/office.toml\"\n", "");
    two_worlds: with("file = \"worlds/office.toml\"", "file = \"worlds/office.toml\"\nmap = \"depot.yaml\"");
    duplicate_robot: with("name = \"bob\"", "name = \"ann\"").replace("count = 3\n", "").replace("spacing = { x = 2.0, y = 1.5, columns = 2 }\n", "");
    duplicate_robot_by_repetition: with("name = \"real\"", "name = \"bob-2\"");
    bad_robot_name: with("name = \"ann\"", "name = \"ann/1\"");
    taken_agent_name: with("[robot.agent.draw]", "[robot.agent.sonar]");
    no_robot: "[mission]\nname = \"empty\"\n";
    missing_robot_name: with("name = \"real\"\n", "");
    no_base: "[[robot]]\nname = \"ann\"\n";
    unknown_agent: with("[template.huey.agent.avoidance]", "[template.huey.agent.avoidence]");
    unknown_kind: with("kind = \"mapper\"", "kind = \"maper\"");
    unknown_agent_key: with("cell = 0.05", "cell_size = 0.05");
    bad_priority: with("priority = 20", "priority = 300");
    useless_priority: with("cell = 0.05", "cell = 0.05\npriority = 3");
    unsatisfied_topic: with("[template.sonar-robot.agent.where-am-i]\nheading_variance = 0.002\n", "");
    writer_not_enabled: with("heading_variance = 0.002", "enabled = false");
    no_sonar: with("sonar = { driver = \"sim\", ring = \"denning-16\", noise = 0.02 }\n", "").replace("name = \"real\"", "name = \"real2\"");
    two_writers: with("[robot.agent.draw]\nkind = \"mapper\"\ncell = 0.05", "[robot.agent.odometry]\nkind = \"where-am-i\"");
    unknown_driver: with("base = { driver = \"sim\",", "base = { driver = \"simm\",");
    no_driver: with("base = { driver = \"arcos\", port = \"/dev/ttyUSB0\" }", "base = { port = \"/dev/ttyUSB0\" }").replace("name = \"real\"\ntemplate = \"huey\"", "name = \"real\"");
    driver_key_missing: with("base = { driver = \"arcos\", port = \"/dev/ttyUSB0\" }", "base = { driver = \"arcos\" }");
    unknown_ring: with("ring = \"denning-16\"", "ring = \"denning16\"");
    unknown_platform: with("platform = \"b12-huey\"", "platform = \"pioneer\"");
    unknown_template: with("name = \"ann\"\ntemplate = \"huey\"", "name = \"ann\"\ntemplate = \"hewey\"");
    template_cycle: with("[template.sonar-robot]\n", "[template.sonar-robot]\ntemplate = \"huey\"\n");
    template_of_itself: with("[template.sonar-robot]\n", "[template.sonar-robot]\ntemplate = \"sonar-robot\"\n");
    half_a_start: with("start = { x = 1.0, y = 2.0 }", "start = { x = 1.0 }");
    two_starts: with("start = { x = 1.0, y = 2.0 }", "start = { x = 1.0, y = 2.0, place = \"south\" }");
    no_spacing: with("spacing = { x = 2.0, y = 1.5, columns = 2 }\n", "");
    spacing_of_one: with("count = 3\n", "");
    spacing_of_nothing: with("spacing = { x = 2.0, y = 1.5, columns = 2 }", "spacing = { y = 0, columns = 1 }");
    speed_of_real_time: with("clock = \"lockstep\"", "clock = \"wall\"\nspeed = 2.0");
    robot_as_table: with("[[robot]]\nname = \"ann\"", "[robot]\nname = \"ann\"");
    name_with_control_characters: with("name = \"real\"", "name = \"re\\u0007al\"");
    many_at_once: with("seed = 7", "sed = 7").replace("noise = 0.02", "noise = 2").replace("side = \"both\"", "side = \"bth\"");
}

#[test]
fn one_line_and_json() {
    let text = with("clearance = 0.5", "clearance = 40");
    let problems = problems(&text);
    let line = "mission.toml:32:13: error: `clearance` = 40 is above the maximum of 2 (hint: allowed is 0.05 to 2: nearest distance \
                that is left to an obstacle, m; the default is 0.4)";
    assert_eq!(problems.to_string(), line);
    let json = serde_json::json!([{
        "file": "mission.toml", "line": 32, "column": 13, "text": "40",
        "message": "`clearance` = 40 is above the maximum of 2",
        "hint": "allowed is 0.05 to 2: nearest distance that is left to an obstacle, m; the default is 0.4",
    }]);
    assert_eq!(serde_json::to_value(&problems).unwrap(), json);
}

#[test]
fn colours_are_only_colours() {
    let problems = problems(&with("clearance = 0.5", "clearance = 40"));
    let coloured = problems.render(true);
    assert!(coloured.contains("\u{1b}["));
    let mut plain = String::new();
    let mut rest = coloured.as_str();
    while let Some(start) = rest.find("\u{1b}[") {
        plain.push_str(&rest[..start]);
        rest = rest[start..].split_once('m').unwrap().1;
    }
    assert_eq!(plain + rest, problems.render(false));
}

#[test]
fn a_file_that_is_not_text() {
    let mut sources = orienteer_runtime::config::Sources::embedded([("m.toml".to_owned(), b"a = 1\nb = \xff\n".to_vec())]);
    let id = sources.read("m.toml").unwrap();
    let problems = Mission::load(&mut sources, id, &Fake::default()).unwrap_err();
    assert!(problems.to_string().starts_with("m.toml:2:5: error: this file is not text: byte 0xff is not UTF-8"), "{problems}");
}

#[test]
fn long_lines_and_deep_nesting_are_refused_calmly() {
    let deep = [
        format!("a = {}{}", "[".repeat(100_000), "]".repeat(100_000)),
        format!("{} = 1", vec!["a"; 100_000].join(".")),
        format!("[{}]", vec!["a"; 100_000].join(".")),
        format!("a = {}1{}", "{ a = ".repeat(100_000), "}".repeat(100_000)),
        format!("x = \"{}\"", "y".repeat(1_000_000)),
    ];
    for text in deep {
        let problems = problems(&text);
        assert!(problems.render(false).len() < 5_000, "{}", problems.render(false).len());
        assert!(problems.list().iter().all(|problem| problem.location().is_some() && !problem.hint().is_empty()));
    }
    let ten_deep = format!("[mission]\nname = {}1{}", "[".repeat(40), "]".repeat(40));
    assert_eq!(problems(&ten_deep).list().len(), 2);
}

#[test]
fn problems_in_a_template_are_told_once_for_all_robots() {
    assert_eq!(problems(&with("clearance = 0.5", "clearance = 40")).list().len(), 1);
    let mut sources = sources(&with("clearance = 0.5", "clearance = 40"));
    let id = sources.read("mission.toml").unwrap();
    assert!(Mission::load(&mut sources, id, &Fake::default()).is_err());
}
