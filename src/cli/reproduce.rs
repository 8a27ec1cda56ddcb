//! `orienteer reproduce`: every figure that is claimed, measured again.

use std::{
    io,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use crate::{
    reproduce::{Effort, Row, SUITES, Suite},
    runtime::{
        descriptors::check_room_for,
        fleet::{Ear, FleetControl, Signals},
    },
};
use serde::Serialize;

use super::{
    Outcome, Refusal, ReproduceArguments,
    progress::{self, Bar},
    stderr,
    style::{self, Paint},
    table::{Align, Table},
};

/// The rows of one suite, as `--json` prints them.
#[derive(Debug, Serialize)]
struct Report {
    suite: &'static str,
    rows: Vec<Row>,
}

/// Runs experiments and compares their figures with their goals.
pub fn reproduce(arguments: &ReproduceArguments) -> Result<Outcome, Refusal> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    check_room_for(threads + 2).map_err(|error| Refusal::failed(error.to_string(), error.hint()))?;
    let wanted = |suite: &&Suite| arguments.suite.as_deref().is_none_or(|name| name == suite.name);
    let interruption = Interruption::listen();
    let mut reports = Vec::new();
    let mut refusal = None;
    for suite in SUITES.iter().filter(wanted) {
        match measure(suite, arguments, &interruption) {
            Ok(report) => {
                if !arguments.json {
                    style::print(&text(&report, !reports.is_empty()))?;
                }
                reports.push(report);
            }
            // The other suites may still have something to say.
            Err(error) => refusal = Some(error.tell(false)),
        }
    }
    if arguments.json {
        match reports.as_slice() {
            [only] if arguments.suite.is_some() => style::print_json(only)?,
            all => style::print_json(&all)?,
        }
    }
    let short = reports.iter().flat_map(|report| &report.rows).any(|row| !row.holds);
    Ok(refusal.unwrap_or(if short { Outcome::FallsShort } else { Outcome::Well }))
}

fn measure(suite: &'static Suite, arguments: &ReproduceArguments, interruption: &Interruption) -> Result<Report, Refusal> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let bar = Bar::new(0, "{prefix:.bold} {bar:24.cyan/dim} {pos}/{len} {wide_msg}");
    let handle = bar.handle();
    handle.set_prefix(suite.name);
    handle.enable_steady_tick(Duration::from_millis(200));
    let interruption = interruption.clone();
    let effort = Effort {
        seeds: arguments.seeds,
        quick: arguments.quick,
        threads,
        progress: Box::new(move |what, done, all| {
            handle.set_length(all);
            handle.set_position(done);
            handle.set_message(what.to_owned());
            interruption.park();
        }),
    };
    let rows = (suite.run)(&effort);
    drop(bar);
    match rows {
        Ok(rows) => Ok(Report { suite: suite.name, rows }),
        Err(error) => Err(Refusal::failed(
            format!("the suite `{}` could not be carried out: {error}", suite.name),
            "`-v` shows more of what led to it",
        )),
    }
}

fn text(report: &Report, later: bool) -> String {
    let paint = Paint::stdout();
    let columns = [
        (report.suite, Align::Wrap),
        ("reported", Align::Wrap),
        ("goal", Align::Left),
        ("measured", Align::Right),
        ("holds", Align::Left),
    ];
    let mut table = Table::new(columns);
    for row in &report.rows {
        let reported = if row.reported.is_empty() { "-" } else { &row.reported };
        let measured = format!("{} {}", figure(row.measured), row.unit);
        let holds = match (row.goal.is_empty(), row.holds) {
            (true, _) => "",
            (false, true) => "yes",
            (false, false) => "NO",
        };
        table.row([row.row.clone(), reported.to_owned(), row.goal.clone(), measured.trim().to_owned(), holds.to_owned()]);
    }
    let body = table.render(paint, |_, column, cell| match (column, cell) {
        (4, "yes") => paint.good(cell),
        (4, _) => paint.bad(cell),
        (_, "-") => paint.dim(cell),
        _ => cell.to_owned(),
    });
    let gap = if later { "\n" } else { "" };
    format!("{gap}{body}")
}

/// Four digits that count, or whole numbers as they are.
fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() || (value.fract() == 0.0 && value.abs() < 1e15) {
        return format!("{value}");
    }
    let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Ends the program on Ctrl-C, but lets missions that are running end first, so that their links are taken down.
///
/// Each mission listens for signals itself and ends; the thread that ran it then waits here for ever.
#[derive(Debug, Clone)]
struct Interruption {
    happened: Arc<AtomicBool>,
    parked: Arc<AtomicUsize>,
}

impl Interruption {
    /// How long to wait for missions to end.
    const PATIENCE: Duration = Duration::from_secs(2);

    fn listen() -> Self {
        let this = Self { happened: Arc::default(), parked: Arc::default() };
        let watcher = this.clone();
        // Without this thread Ctrl-C still ends the program before the first mission, and missions after that.
        let spawned = thread::Builder::new().name("ctrl-c".to_owned()).spawn(move || watcher.watch());
        if let Err(error) = spawned {
            tracing::warn!("can't listen for Ctrl-C: {error}");
        }
        this
    }

    fn watch(&self) {
        let Ok(runtime) = tokio::runtime::Builder::new_current_thread().enable_all().build() else { return };
        // Nobody else ends the program before this thread has told of it.
        let _ear = Ear::open(FleetControl::default());
        let heard = runtime.block_on(async { io::Result::Ok(Signals::listen()?.asked_to_end().await) });
        let Ok(signal) = heard else { return };
        self.happened.store(true, Ordering::Relaxed);
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let since = Instant::now();
        while self.parked.load(Ordering::Relaxed) < threads && since.elapsed() < Self::PATIENCE {
            thread::sleep(Duration::from_millis(20));
        }
        stderr::instruct(progress::clear);
        style::complain_of(&format!("stopped: {signal}"));
        stderr::settle_within(Self::PATIENCE);
        std::process::exit(130);
    }

    /// Waits for the end of the program, if that has been asked for.
    fn park(&self) {
        if self.happened.load(Ordering::Relaxed) {
            self.parked.fetch_add(1, Ordering::Relaxed);
            loop {
                thread::park();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short() {
        let figures = [0.0, 50.0, 1_000_000.0, 0.123_456, 12.345_6, 99.96, 1234.56, 1e-5].map(figure);
        assert_eq!(figures, ["0", "50", "1000000", "0.1235", "12.35", "99.96", "1235", "0.00001"]);
    }
}
