//! The README must not promise what the program does not do: its missions load, its behaviour is the example's, its files exist.
#![allow(clippy::unwrap_used)]

use orienteer::{Registry, mission};

const README: &str = include_str!("../README.md");
const EXAMPLE: &str = include_str!("../examples/custom_behaviour.rs");

/// The blocks of code in this language.
fn blocks(language: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut lines = README.lines();
    while let Some(line) = lines.next() {
        if let Some(tag) = line.strip_prefix("```").filter(|tag| !tag.is_empty()) {
            let block: String = lines.by_ref().take_while(|line| *line != "```").map(|line| format!("{line}\n")).collect();
            if tag == language {
                found.push(block);
            }
        }
    }
    found
}

#[test]
fn the_missions_load() {
    let missions = blocks("toml");
    assert!(!missions.is_empty());
    for text in missions {
        let files = mission::embedded_files().chain([("readme.toml".to_owned(), text.clone().into_bytes())]);
        if let Err(problems) = mission::load_files(files, "readme.toml", &Registry::standard()) {
            panic!("{text}\n{problems}");
        }
    }
}

#[test]
fn the_kinds_of_places_are_those_of_the_shipped_file() {
    use orienteer::agents::place_classifier::Catalogue;
    let read = |text: &str| toml::from_str::<Catalogue>(text).unwrap().hypothesis;
    let shipped = read(include_str!("../configs/places/more.toml"));
    let shown: Vec<_> = blocks("toml places").iter().flat_map(|text| read(text)).collect();
    assert_eq!(shown.len(), 1);
    // What can't be looked for there is left out for brevity.
    let brief = |mut kind: orienteer::agents::place_classifier::Hypothesis| {
        kind.blocked.clear();
        kind
    };
    assert!(shipped.into_iter().map(brief).any(|kind| kind == shown[0]));
}

#[test]
fn the_behaviour_is_that_of_the_example() {
    let example = EXAMPLE.split("// README: the behaviour begins\n").nth(1).unwrap();
    let example = example.split("// README: the behaviour ends\n").next().unwrap();
    assert_eq!(blocks("rust"), [example], "copy the behaviour from examples/custom_behaviour.rs into the README");
}

#[test]
fn the_mistake_is_told_as_shown() {
    let mission = &blocks("toml")[0];
    let wrong = mission.replace("cruise_speed = 0.4", "cruise_sped = 0.4");
    assert_ne!(*mission, wrong);
    let files = mission::embedded_files().chain([("my.toml".to_owned(), wrong.into_bytes())]);
    let problems = mission::load_files(files, "my.toml", &Registry::standard()).unwrap_err();
    let trimmed = |text: &str| text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim().to_owned();
    assert_eq!(trimmed(&blocks("text")[0]), trimmed(&problems.render(false)));
}

#[test]
fn every_file_that_it_links_to_is_there() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut count = 0;
    for link in README.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()) {
        if !link.starts_with("http") {
            assert!(root.join(link).exists(), "{link}");
            count += 1;
        }
    }
    assert!(count >= 5, "{count} links found");
}
