//! Diagrams to try things out with: three from the literature, and two of the size that a robot deals with.

use crate::diagram::{BuildError, ChanceId, DecisionId, Diagram, Memory};

/// The umbrella (Shachter & Peot 1992; the numbers are those of Netica's example): take it or leave it, having heard the forecast. Worth 77.
///
/// # Errors
/// None.
pub fn umbrella() -> Result<Diagram, BuildError> {
    let mut build = Diagram::builder("umbrella");
    let weather = build.chance("weather", ["sunshine", "rain"]).table([0.7, 0.3]);
    let forecast = build.chance("forecast", ["sunny", "cloudy", "rainy"]).given(weather).table([0.7, 0.2, 0.1, 0.15, 0.25, 0.6]);
    let umbrella = build.decision("umbrella", ["take", "leave"]).given(forecast).id();
    build.utility("satisfaction").given(weather).given(umbrella).table([20.0, 100.0, 70.0, 0.0]);
    build.build()
}

/// The oil wildcatter (Raiffa 1968, §10): whether to pay for a seismic test, and then whether to drill. Worth 22.5 (thousand dollars): test, and drill unless there is no structure.
///
/// # Errors
/// None.
pub fn oil_wildcatter() -> Result<Diagram, BuildError> {
    let mut build = Diagram::builder("oil wildcatter");
    let oil = build.chance("oil", ["dry", "wet", "soaking"]).table([0.5, 0.3, 0.2]);
    let test = build.decision("test", ["yes", "no"]).id();
    let result = build.chance("seismic", ["none", "open", "closed", "not tested"]).given(oil).given(test).table([
        0.6, 0.3, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0, 0.3, 0.4, 0.3, 0.0, 0.0, 0.0, 0.0, 1.0, 0.1, 0.4, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0,
    ]);
    let drill = build.decision("drill", ["yes", "no"]).given(test).given(result).id();
    build.utility("cost of testing").given(test).table([-10.0, 0.0]);
    build.utility("profit").given(oil).given(drill).table([-70.0, 0.0, 50.0, 0.0, 200.0, 0.0]);
    build.build()
}

/// The pigs (Lauritzen & Nilsson 2001, §2): whether to treat, month by month, on the newest test alone. With this limited memory it is worth 726.8; who remembers the
/// earlier tests gets 729.2.
///
/// # Errors
/// None.
pub fn pigs() -> Result<Diagram, BuildError> {
    let mut build = Diagram::builder("pigs");
    build.memory(Memory::Limited);
    let states = ["ill", "well"];
    let mut health = build.chance("health 1", states).table([0.1, 0.9]);
    for month in 1..=3 {
        let test = build.chance(format!("test {month}"), ["positive", "negative"]).given(health).table([0.8, 0.2, 0.1, 0.9]);
        let treat = build.decision(format!("treat {month}"), ["yes", "no"]).given(test).id();
        build.utility(format!("cost {month}")).given(treat).table([-100.0, 0.0]);
        let next = build.chance(format!("health {}", month + 1), states).given(health).given(treat);
        health = next.table([0.5, 0.5, 0.9, 0.1, 0.1, 0.9, 0.2, 0.8]);
    }
    build.utility("price").given(health).table([300.0, 1000.0]);
    build.build()
}

/// A place to be recognised, the tests that tell about it, and what to report.
#[derive(Debug, Clone, PartialEq)]
pub struct Classifier {
    /// The diagram.
    pub diagram: Diagram,
    /// Which class the place is of; all are equally probable.
    pub class: ChanceId,
    /// The tests, independent of each other given the class.
    pub tests: Vec<ChanceId>,
    /// Which class to report, having seen all tests.
    pub report: DecisionId,
}

/// What a wrong report costs, in [`classifier`] and [`next_test`]; tests cost some hundreds.
const WRONG: f64 = -20_000.0;

/// So many classes, told apart by so many tests that are found or not: the reference for figures of speed, with 6 and 8.
///
/// The features are dealt out so that each test finds about half of the classes, with a sensitivity between 0.9 and 0.98, and false alarms between 0.01 and 0.05. A wrong report costs 20000.
///
/// # Errors
/// A [`Fault`](crate::Fault) if there are no classes.
pub fn classifier(classes: usize, tests: usize) -> Result<Classifier, BuildError> {
    let mut build = Diagram::builder("classifier");
    let names = (0..classes).map(|class| format!("class {class}"));
    let class = build.chance("class", names.clone()).table(uniform(classes));
    let test = |test| {
        let table: Vec<f64> = (0..classes).flat_map(|class| found(class, test)).collect();
        build.chance(format!("test {test}"), ["found", "not found"]).given(class).table(table)
    };
    let tests: Vec<ChanceId> = (0..tests).map(test).collect();
    let report = build.decision("report", names).given_all(tests.iter().copied()).id();
    build.utility("wrong").given(class).given(report).table(wrong(classes));
    Ok(Classifier { diagram: build.build()?, class, tests, report })
}

/// The tests of a [`classifier`] from the side of whoever has to choose the next one: run one of them or none, see what comes of it, report.
///
/// This looks one step ahead. What was found out before enters as likelihood of the class, with `class` in [`NextTest`].
#[derive(Debug, Clone, PartialEq)]
pub struct NextTest {
    /// The diagram.
    pub diagram: Diagram,
    /// Which class the place is of.
    pub class: ChanceId,
    /// Which test to run; the last alternative is none.
    pub test: DecisionId,
    /// What came of it: found, not found, not run.
    pub result: ChanceId,
    /// Which class to report.
    pub report: DecisionId,
}

/// The choice of the next test among those of a [`classifier`]; each costs 700, and 100 more than the one before.
///
/// # Errors
/// A [`Fault`](crate::Fault) if there are no classes.
pub fn next_test(classes: usize, tests: usize) -> Result<NextTest, BuildError> {
    let mut build = Diagram::builder("next test");
    let names = (0..classes).map(|class| format!("class {class}"));
    let class = build.chance("class", names.clone()).table(uniform(classes));
    let test = build.decision("test", (0..tests).map(|test| format!("test {test}")).chain(["none".to_owned()])).id();
    let row = |class, test| if test < tests { [found(class, test)[0], found(class, test)[1], 0.0] } else { [0.0, 0.0, 1.0] };
    let table: Vec<f64> = (0..classes).flat_map(|class| (0..=tests).flat_map(move |test| row(class, test))).collect();
    let result = build.chance("result", ["found", "not found", "not run"]).given(class).given(test).table(table);
    let report = build.decision("report", names).given(test).given(result).id();
    let cost = |test| if test < tests { -700.0 - 100.0 * test as f64 } else { 0.0 };
    build.utility("cost").given(test).table((0..=tests).map(cost).collect::<Vec<_>>());
    build.utility("wrong").given(class).given(report).table(wrong(classes));
    Ok(NextTest { diagram: build.build()?, class, test, result, report })
}

fn uniform(states: usize) -> Vec<f64> {
    vec![1.0 / states as f64; states]
}

/// How probable it is that a test finds something in a class, and that it does not.
fn found(class: usize, test: usize) -> [f64; 2] {
    // Any pattern will do that tells the classes apart.
    let pattern = (class + 1).wrapping_mul(0x5b5);
    let feature = (pattern >> (test % 11)) & 1 == 1;
    let found = if feature { 0.98 - 0.01 * (test % 9) as f64 } else { 0.01 + 0.005 * (test % 9) as f64 };
    [found, 1.0 - found]
}

fn wrong(classes: usize) -> Vec<f64> {
    (0..classes).flat_map(|class| (0..classes).map(move |report| if class == report { 0.0 } else { WRONG })).collect()
}
