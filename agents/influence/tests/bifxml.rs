//! What is saved loads back equal, and nothing that is loaded makes the library stumble.
#![allow(clippy::unwrap_used)]

use orienteer_influence::{
    Diagram, Fault, Memory,
    bifxml::{LoadFault, Problem, load, save},
    check::{Shape, random_diagram},
    samples,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// The only problem of a text: line, column, fault.
#[track_caller]
fn refused(text: &str) -> (u32, u32, LoadFault) {
    let error = load(text.as_bytes()).unwrap_err();
    let [Problem { line, column, fault }] = &error.problems[..] else { panic!("{error}") };
    (*line, *column, fault.clone())
}

/// A file with this in its network.
fn network(inside: &str) -> String {
    format!("<BIF VERSION=\"0.3\"><NETWORK>\n{inside}\n</NETWORK></BIF>")
}

const COIN: &str = "<VARIABLE TYPE=\"nature\"><NAME>coin</NAME><OUTCOME>heads</OUTCOME><OUTCOME>tails</OUTCOME></VARIABLE>";

proptest! {
    #[test]
    fn what_is_saved_loads_back_equal(seed: u64, chances in 0..7usize, decisions in 0..4usize, limited: bool) {
        let memory = if limited { Memory::Limited } else { Memory::Perfect };
        let shape = Shape { chances, decisions, memory, ..Shape::default() };
        let diagram = random_diagram(&mut Pcg64::seed_from_u64(seed), &shape);
        prop_assert_eq!(load(save(&diagram).as_bytes()).unwrap(), diagram);
    }

    #[test]
    fn any_name_that_is_taken_survives(name in ".{0,8}", state in "[ -~é∀]{1,6}", value: f64) {
        let mut build = Diagram::builder(name.clone());
        build.chance(name, [state, "other".to_owned()]).table([0.25, 0.75]);
        build.utility("u").table([value]);
        if let Ok(diagram) = build.build() {
            prop_assert_eq!(load(save(&diagram).as_bytes()).unwrap(), diagram);
        }
    }

    #[test]
    fn no_bytes_make_it_stumble(bytes: Vec<u8>) {
        let error = load(&bytes).unwrap_err();
        prop_assert!(error.problems.iter().all(|problem| problem.line >= 1 && problem.column >= 1));
    }

    /// Nearly sound files get further than noise does.
    #[test]
    fn no_damage_to_a_file_makes_it_stumble(cuts in prop::collection::vec((0.0..1.0f64, 0..12usize, ".{0,6}"), 1..4), sample in 0..3usize) {
        let sample = [samples::umbrella, samples::oil_wildcatter, samples::pigs][sample]().unwrap();
        let mut text: Vec<char> = save(&sample).chars().collect();
        for (at, length, with) in cuts {
            let at = (at * text.len() as f64) as usize;
            let to = (at + length).min(text.len());
            text.splice(at..to, with.chars());
        }
        let text: String = text.into_iter().collect();
        if let Ok(diagram) = load(text.as_bytes()) {
            prop_assert_eq!(load(save(&diagram).as_bytes()).unwrap(), diagram);
        }
    }
}

#[test]
fn files_of_other_programs_are_read() {
    let text = r#"<?xml version="1.0"?>
<!DOCTYPE BIF [ <!ELEMENT BIF ( NETWORK )*> <!ATTLIST BIF VERSION CDATA #REQUIRED> ]>
<BIF VERSION="0.3"><NETWORK>
<VARIABLE><NAME> coin </NAME><PROPERTY>fast = coin{a|b|c}</PROPERTY><!-- three sides --><OUTCOME>a</OUTCOME><OUTCOME>b &amp; d</OUTCOME><OUTCOME>c</OUTCOME></VARIABLE>
<VARIABLE TYPE="utility"><NAME>u</NAME><OUTCOME>0</OUTCOME></VARIABLE>
<DEFINITION><FOR>coin</FOR><!--coin | --><TABLE>0.333 <!-- a --> 0.333
 3.33e-1 </TABLE></DEFINITION>
<DEFINITION><FOR>u</FOR><GIVEN>coin</GIVEN><TABLE>1 -2 .5</TABLE></DEFINITION>
</NETWORK></BIF>"#;
    let diagram = load(text.as_bytes()).unwrap();
    let coin = diagram.variable("coin").unwrap();
    assert_eq!(diagram.states(coin), ["a", "b & d", "c"]);
    assert!(diagram.table(coin).iter().all(|p| (p - 1.0 / 3.0).abs() < 1e-15), "rounded rows are scaled");
    assert_eq!(diagram.table(diagram.node("u").unwrap()), [1.0, -2.0, 0.5]);
}

#[test]
fn refusals_name_the_place() {
    let at = |inside: &str| refused(&network(inside));
    let unknown = |name: &str| LoadFault::UnknownVariable { name: name.to_owned() };
    let coin = |definition: &str| at(&format!("{COIN}\n<DEFINITION><FOR>coin</FOR>{definition}</DEFINITION>"));
    assert_eq!(coin("<TABLE>0.5 half</TABLE>"), (3, 39, LoadFault::Number { text: "half".to_owned() }));
    assert_eq!(coin("<GIVEN>toss</GIVEN><TABLE>0.5 0.5</TABLE>"), (3, 28, unknown("toss")));
    assert!(matches!(coin("<TABLE>0.5 0.6</TABLE>"), (3, 1, LoadFault::Diagram(Fault::RowSum { .. }))));
    assert!(matches!(coin("<TABLE>0.5 NaN</TABLE>"), (3, 1, LoadFault::Diagram(Fault::Probability { .. }))));
    assert!(matches!(coin("<GIVEN>coin</GIVEN><TABLE>1 0 0 1</TABLE>"), (3, 1, LoadFault::Diagram(Fault::Cycle { .. }))));
    assert!(matches!(at(COIN), (2, 1, LoadFault::Diagram(Fault::MissingTable { .. }))));
    assert_eq!(at("<DEFINITION><FOR>x</FOR></DEFINITION>"), (2, 13, unknown("x")));
    assert_eq!(at("<DEFINITION/>"), (2, 1, LoadFault::Missing { element: "DEFINITION", missing: "FOR" }));
    assert_eq!(at("  <VARIABLE/>"), (2, 3, LoadFault::Missing { element: "VARIABLE", missing: "NAME" }));
    let odd = |found: &str| LoadFault::UnknownType { found: found.to_owned() };
    assert_eq!(at("<VARIABLE TYPE='dream'><NAME>d</NAME></VARIABLE>"), (2, 1, odd("dream")));
    assert!(matches!(at("<PROPERTY>memory = short</PROPERTY>"), (2, 1, LoadFault::UnknownMemory { .. })));
    let decision = "<VARIABLE TYPE='decision'><NAME>d</NAME><OUTCOME>a</OUTCOME></VARIABLE>\n";
    let table = format!("{decision}<DEFINITION><FOR>d</FOR><TABLE>1</TABLE></DEFINITION>");
    assert_eq!(at(&table), (3, 25, LoadFault::TableOfDecision { name: "d".to_owned() }));
    let twice = format!("{decision}{0}\n{0}", "<DEFINITION><FOR>d</FOR></DEFINITION>");
    assert_eq!(at(&twice), (4, 1, LoadFault::DefinedTwice { name: "d".to_owned() }));
    let utility = "<VARIABLE TYPE='utility'><NAME>u</NAME></VARIABLE><DEFINITION><FOR>u</FOR><TABLE>1</TABLE></DEFINITION>\n";
    let child = format!("{utility}{decision}<DEFINITION><FOR>d</FOR><GIVEN>u</GIVEN></DEFINITION>");
    assert!(matches!(at(&child), (4, 1, LoadFault::Diagram(Fault::UtilityWithChildren { .. }))));
    let many = "<VARIABLE TYPE='utility'><NAME>u</NAME><OUTCOME>a</OUTCOME><OUTCOME>b</OUTCOME></VARIABLE>";
    assert_eq!(at(many), (2, 1, LoadFault::OutcomesOfUtility { name: "u".to_owned(), count: 2 }));
    assert_eq!(refused("<BIF/>"), (1, 1, LoadFault::Networks { count: 0 }));
    assert_eq!(refused("<BIF>\n<NETWORK/><NETWORK/></BIF>"), (2, 11, LoadFault::Networks { count: 2 }));
    assert_eq!(refused("<HTML/>"), (1, 1, LoadFault::NotBif { found: "HTML".to_owned() }));
    assert!(matches!(refused("<BIF>\n</BUF>"), (2, _, LoadFault::Xml(_))));
    let error = load(b"<BIF>\n\xff").unwrap_err();
    assert_eq!((error.problems[0].line, error.problems[0].column, &error.problems[0].fault), (2, 1, &LoadFault::NotUtf8));
}

#[test]
fn entities_are_refused_however_they_are_meant() {
    let bomb = "<!DOCTYPE BIF [\n<!ENTITY a 'aaaaaaaaaa'> <!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;'>]><BIF>&b;</BIF>";
    assert_eq!(refused(bomb), (2, 1, LoadFault::Entity));
    let file = "<!DOCTYPE BIF [<!ENTITY secret SYSTEM 'file:///etc/passwd'>]><BIF><NETWORK><NAME>&secret;</NAME></NETWORK></BIF>";
    assert_eq!(refused(file).2, LoadFault::Entity);
    assert_eq!(refused("<!DOCTYPE BIF [<!ENTITY % all SYSTEM 'all.dtd'> %all;]><BIF/>").2, LoadFault::Entity);
    assert!(matches!(refused("<BIF><NETWORK><NAME>&undeclared;</NAME></NETWORK></BIF>").2, LoadFault::Xml(_)));
    // An external definition of the document type is passed over, not fetched.
    assert!(load(b"<!DOCTYPE BIF SYSTEM 'file:///nowhere/bif.dtd'><BIF><NETWORK/></BIF>").is_ok());
}

#[test]
fn depth_and_length_are_no_trouble() {
    let deep = "<BIF>".repeat(200_000);
    assert!(load(deep.as_bytes()).is_err());
    let chain: String = (0..3000).map(|i| format!("<VARIABLE><NAME>v{i}</NAME><OUTCOME>x</OUTCOME></VARIABLE>")).collect();
    let arc =
        |i: usize| format!("<DEFINITION><FOR>v{i}</FOR><GIVEN>v{}</GIVEN><TABLE>1</TABLE></DEFINITION>", i.saturating_sub(1));
    let arcs: String = (1..3000).map(arc).collect();
    let first = "<DEFINITION><FOR>v0</FOR><TABLE>1</TABLE></DEFINITION>";
    assert_eq!(load(network(&format!("{chain}{first}{arcs}")).as_bytes()).unwrap().variables().len(), 3000);
    // A table nobody could hold is refused by its shape, not by running out of memory.
    let wide: String =
        (0..80).map(|i| format!("<VARIABLE><NAME>v{i}</NAME><OUTCOME>a</OUTCOME><OUTCOME>b</OUTCOME></VARIABLE>")).collect();
    let tables: String = (0..80).map(|i| format!("<DEFINITION><FOR>v{i}</FOR><TABLE>1 0</TABLE></DEFINITION>")).collect();
    let all: String = (0..80).map(|i| format!("<GIVEN>v{i}</GIVEN>")).collect();
    let vast = format!(
        "{wide}{tables}<VARIABLE TYPE='utility'><NAME>u</NAME></VARIABLE><DEFINITION><FOR>u</FOR>{all}<TABLE>1</TABLE></DEFINITION>"
    );
    assert!(matches!(refused(&network(&vast)).2, LoadFault::Diagram(Fault::TableTooLarge { .. })));
}
