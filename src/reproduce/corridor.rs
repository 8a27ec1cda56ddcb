//! Corridor following: how well the robot keeps to the middle, and where it stops.
//!
//! Each run is a mission of its own: a Huey with where-am-i, avoidance and the corridor follower, all noise on, starts up to
//! 20 cm and 10° off. Its true course is measured, not what it believes.
//!
//! * *Branch*: a corridor as wide as Randazza's (1989) or MacPherson's (1993) hallways, with an opening 1.12 m wide on the
//!   left, the right, or both sides. The robot shall stop at the start pose: its centre in the middle of the corridor, the
//!   front sonar level with the near corner (Randazza 1989, §3.1).
//! * *Hallway*: 20 m without openings, 2.46 m wide, which MacPherson (1993) reports that Yamabico left by up to 40 cm.

mod course;

use course::{Branches, Course, Run};

use super::{Effort, Row, Suite, SuiteError, in_parallel};

pub(super) const SUITE: Suite =
    Suite { name: "corridor", help: "follows corridors of three widths to their openings, and a hallway of 20 m", run };

/// Widths of corridors, m: Randazza's place, an office's, MacPherson's hallway.
const WIDTHS: [f64; 3] = [1.12, 1.5, 2.46];
/// Kinds of openings that each seed meets.
const BRANCHES: [Branches; 3] = [Branches::Left, Branches::Right, Branches::Both];

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let seeds = effort.seeds(50);
    let mut rows = Vec::new();
    for width in WIDTHS {
        let count = seeds * BRANCHES.len() as u64;
        let what = format!("corridors of {width} m");
        let runs = in_parallel(effort, &what, count, |number| {
            let branches = BRANCHES[(number % BRANCHES.len() as u64) as usize];
            Course::with_branches(width, branches, 1 + number / BRANCHES.len() as u64).run()
        })?;
        rows.extend(branch_rows(width, &runs));
    }
    let halls = in_parallel(effort, "hallways", seeds, |number| Course::hallway(1 + number).run())?;
    let deviation = worst(&halls, |run| 100.0 * run.deviation);
    let completed = halls.iter().all(|run| run.length >= course::HALLWAY);
    let deviation = if completed { deviation } else { f64::INFINITY };
    rows.push(Row::at_most("hallway of 20 m, 2.46 m wide: largest deviation", 10.0, deviation, "cm").reported("40"));
    Ok(rows)
}

fn branch_rows(width: f64, runs: &[Run]) -> Vec<Row> {
    let label = |what: &str| format!("{width:.2} m: {what}");
    let mut rms: Vec<f64> = runs.iter().map(|run| 100.0 * run.rms).collect();
    rms.sort_by(f64::total_cmp);
    let median = rms.get(rms.len() / 2).copied().unwrap_or(f64::NAN);
    let collisions: u32 = runs.iter().map(|run| run.collisions).sum();
    let share = |good: &dyn Fn(&Run) -> bool| 100.0 * runs.iter().filter(|run| good(run)).count() as f64 / runs.len() as f64;
    // How exactly it faces along the corridor is asked of those that found the place.
    let placed: Vec<Run> = runs.iter().filter(|run| run.is_placed()).cloned().collect();
    vec![
        Row::at_most(label("lateral RMS after the first 2 m, median"), 5.0, median, "cm"),
        Row::at_most(label("lateral RMS after the first 2 m, worst run"), 5.0, worst(runs, |run| 100.0 * run.rms), "cm"),
        Row::exactly(label("collisions"), 0.0, f64::from(collisions), ""),
        Row::at_least(label("stops within 10 cm of the start pose"), 95.0, share(&Run::is_placed), "%"),
        Row::at_most(label("heading error at those stops, worst"), 5.0, worst(&placed, |run| run.heading.to_degrees()), "°"),
        Row::at_least(label("sides of the opening told right"), 95.0, share(&|run| run.sides_right), "%"),
    ]
}

fn worst(runs: &[Run], figure: impl Fn(&Run) -> f64) -> f64 {
    runs.iter().map(figure).fold(0.0, |worst, figure| if figure.is_finite() { f64::max(worst, figure) } else { f64::INFINITY })
}
