//! What a real base does when things around it die: three processes, one robot, and somebody with an axe.
//!
//! The robot, a Pioneer or a Create, is emulated in this process, so that what it does is seen from the world's side, a hundred times a
//! second. Its hardware and its mission are processes of the very program that runs this suite. Each is killed, held up and ended in good order, and
//! the wire falls silent, carries garbage, and loses half of each packet, at random instants while the robot drives. The robot must stand
//! in time, whatever it was; and all must go on by themselves when what was taken away is back.

mod axe;
mod family;
mod robot;

use std::{
    fmt::Write as _,
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{Effort, Row, Suite, SuiteError};
use axe::Axe;
use family::{CREATE, Family, PIONEER};
use robot::Watched;

pub(super) const SUITE: Suite = Suite {
    name: "kill",
    help: "a real base's processes and wire are killed, held up and disturbed, in wall time: how soon it stands, and goes on",
    run,
};

/// How often each blow falls in a full run.
const INSTANTS: u64 = 100;
/// Robots of each family at once: they wait most of the time.
const ROBOTS: u64 = 3;
static FAMILIES: [&Family; 2] = [&PIONEER, &CREATE];
/// The control period and 10 ms, s.
const PERIOD: f64 = 0.05 + 0.01;
/// The longest that any base here may go on, s.
const LONGEST_STOP: f64 = 2.0;
/// Who neither drives nor turns for so long has not gone on.
const PATIENCE: Duration = Duration::from_secs(40);
/// Who does not drive for so long is stuck.
const STUCK: Duration = Duration::from_secs(120);
/// How long what was taken away stays away, beyond the time in which the base must stand.
const AWAY: Duration = Duration::from_millis(500);

/// Processes whose suite was killed do not live for ever, s.
const LONGEST: &str = "7200";
/// How many lines of each log are shown when something goes wrong.
const LAST_WORDS: usize = 12;

/// What came of one blow.
#[derive(Debug, Clone, Copy)]
struct Felt {
    blow: usize,
    /// Time until the base stood, less that which its brakes need from the speed that it had, s.
    stood: f64,
    /// Time from when all was back until it drove again, s; infinite if it did not.
    went_on: f64,
    /// What it ran into meanwhile.
    collisions: u32,
}

/// What is done to the robots of one family.
struct Work {
    family: &'static Family,
    /// All blows, and how many of them have been dealt out.
    all: u64,
    next: AtomicU64,
    felt: Mutex<Vec<Felt>>,
}

impl Work {
    fn new(family: &'static Family, instants: u64) -> Self {
        let all = instants * family.blows.len() as u64;
        Self { family, all, next: AtomicU64::new(0), felt: Mutex::default() }
    }

    /// The next blow, by its place among the family's.
    fn next(&self) -> Option<usize> {
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        (number < self.all).then_some((number % self.family.blows.len() as u64) as usize)
    }

    fn is_left(&self) -> bool {
        self.next.load(Ordering::Relaxed) < self.all
    }

    fn felt(&self) -> MutexGuard<'_, Vec<Felt>> {
        self.felt.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn rows(&self) -> Vec<Row> {
        let (felt, name) = (self.felt(), self.family.name);
        let of = |blow: usize| felt.iter().filter(move |felt| felt.blow == blow);
        let blows = self.family.blows.iter().enumerate();
        let mut rows: Vec<Row> = blows.flat_map(|(blow, axe)| rows_of(name, axe, of(blow))).collect();
        let went_on = format!("{name}: blows that were felt, and after which all went on");
        let all_went_on = felt.iter().filter(|felt| felt.went_on.is_finite()).count();
        rows.push(Row::exactly(went_on, self.all as f64, all_went_on as f64, ""));
        if self.family.touches {
            return rows;
        }
        let collisions = |sees: bool| {
            let of = felt.iter().filter(|felt| self.family.blows[felt.blow].base_still_sees() == sees);
            of.map(|felt| f64::from(felt.collisions)).sum()
        };
        rows.push(Row::exactly(format!("{name}: ran into something while its hardware lived"), 0.0, collisions(true), ""));
        let before = format!("{name}: ran into something before its watchdog stopped it");
        rows.push(Row::information(before, collisions(false), ""));
        rows
    }
}

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let before = left_in_shared_memory();
    let works = FAMILIES.map(|family| Work::new(family, effort.seeds(INSTANTS)));
    let failure: Mutex<Option<SuiteError>> = Mutex::default();
    let tell = || {
        let done: usize = works.iter().map(|work| work.felt().len()).sum();
        (effort.progress)("kill", done as u64, works.iter().map(|work| work.all).sum());
    };
    thread::scope(|scope| {
        for (number, work) in (0..ROBOTS).flat_map(|_| &works).enumerate() {
            let (failure, works, tell) = (&failure, &works, &tell);
            scope.spawn(move || {
                if let Err(error) = robots(number as u64, work, tell) {
                    failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    works.iter().for_each(|work| work.next.store(work.all, Ordering::Relaxed));
                }
            });
        }
    });
    if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let mut rows: Vec<Row> = works.iter().flat_map(Work::rows).collect();
    let left = left_in_shared_memory().saturating_sub(before);
    rows.push(Row::exactly("files left in shared memory", 0.0, left as f64, ""));
    Ok(rows)
}

fn rows_of<'a>(name: &str, axe: &Axe, felt: impl Iterator<Item = &'a Felt>) -> [Row; 2] {
    let (mut stood, mut went_on) = (0.0_f64, Vec::new());
    for felt in felt {
        stood = stood.max(felt.stood);
        went_on.push(felt.went_on);
    }
    went_on.sort_by(f64::total_cmp);
    let median = went_on.get(went_on.len() / 2).copied().unwrap_or_default();
    [
        Row::at_most(
            format!("{name}: {}: stands within, beside braking, worst", axe.words),
            1000.0 * (PERIOD + axe.within),
            1000.0 * stood,
            "ms",
        ),
        Row::information(format!("{name}: {}: goes on after, median", axe.words), median, "s"),
    ]
}

/// Files and directories of this user's runs.
fn left_in_shared_memory() -> usize {
    let names = fs::read_dir("/dev/shm").into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.filter(|name| name.to_string_lossy().starts_with("or")).count()
}

/// Two processes that drive a robot.
struct Crew<'a> {
    folder: &'a Path,
    mission: Option<Child>,
    hardware: Option<Child>,
}

impl<'a> Crew<'a> {
    fn new(folder: &'a Path) -> Self {
        Self { folder, mission: None, hardware: None }
    }

    /// Starts whoever is not there.
    fn muster(&mut self) -> Result<(), SuiteError> {
        if self.hardware.is_none() {
            self.hardware = Some(self.start("hardware", &["hardware", "mission.toml", "-v", "--for", LONGEST])?);
        }
        if self.mission.is_none() {
            self.mission = Some(self.start("mission", &["run", "mission.toml", "-v", "--no-record", "--out", "out"])?);
        }
        Ok(())
    }

    fn start(&self, name: &str, arguments: &[&str]) -> Result<Child, SuiteError> {
        let program = std::env::current_exe().map_err(SuiteError::from_display)?;
        let log = File::options().create(true).append(true).open(self.log(name)).map_err(SuiteError::from_display)?;
        let mut command = Command::new(program);
        command.args(arguments).current_dir(self.folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
        command.spawn().map_err(SuiteError::from_display)
    }

    fn log(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.log"))
    }

    /// What both said last.
    fn last_words(&self) -> String {
        let mut words = String::new();
        for name in ["hardware", "mission"] {
            let log = fs::read_to_string(self.log(name)).unwrap_or_default();
            let lines: Vec<_> = log.lines().collect();
            for line in &lines[lines.len().saturating_sub(LAST_WORDS)..] {
                let _ = writeln!(words, "  {name}: {line}");
            }
        }
        words
    }
}

impl Drop for Crew<'_> {
    fn drop(&mut self) {
        for child in [&mut self.mission, &mut self.hardware].into_iter().flatten() {
            // In good order, so that nothing is left; a process that is held up would not hear it.
            axe::signal(child, rustix::process::Signal::CONT);
            axe::signal(child, rustix::process::Signal::TERM);
            let _ = child.wait();
        }
    }
}

/// One robot after the other, until all blows have fallen: whoever does not go on after one has another in its place.
fn robots(number: u64, work: &Work, tell: &(dyn Fn() + Sync)) -> Result<(), SuiteError> {
    let mut random = Pcg64::seed_from_u64(number);
    let mut life = 0;
    while work.is_left() {
        one_robot(&format!("{number}-{life}"), random.random(), work, tell, &mut random)?;
        life += 1;
    }
    Ok(())
}

/// One robot with its two processes, and one blow after the other, until there is none or it does not go on.
fn one_robot(name: &str, seed: u64, work: &Work, tell: &(dyn Fn() + Sync), random: &mut Pcg64) -> Result<(), SuiteError> {
    let folder = tempfile::tempdir().map_err(SuiteError::from_display)?;
    let robot = Watched::start(work.family, seed)?;
    let run = format!("kill-{}-{name}", std::process::id());
    let mission = work.family.mission(&run, &robot.port, LONGEST);
    fs::write(folder.path().join("mission.toml"), mission).map_err(SuiteError::from_display)?;
    let mut crew = Crew::new(folder.path());
    crew.muster()?;
    or_last_words(robot.drives(STUCK), &robot, &crew, "drive at the start")?;
    while let Some(blow) = work.next() {
        tell();
        let axe = &work.family.blows[blow];
        or_last_words(robot.drives(STUCK), &robot, &crew, &format!("drive before: {}", axe.words))?;
        thread::sleep(Duration::from_secs_f64(random.random_range(0.0..1.0)));
        let (began, before) = (Instant::now(), robot.collisions());
        axe.strike(&mut crew, &robot);
        thread::sleep(Duration::from_secs_f64(PERIOD + LONGEST_STOP) + robot::BRAKING + AWAY);
        let brakes = if axe.stops_abruptly() { work.family.wheels } else { work.family.brakes };
        let stood = robot.stood_after(began, brakes, axe.heals_itself()).unwrap_or(f64::INFINITY);
        axe.heal(&mut crew, &robot);
        crew.muster()?;
        let back = Instant::now();
        let drove = or_last_words(robot.goes_on(PATIENCE), &robot, &crew, &format!("go on after: {}", axe.words));
        let went_on = drove.as_ref().map_or(f64::INFINITY, |when| when.saturating_duration_since(back).as_secs_f64());
        let collisions = robot.collisions() - before;
        work.felt().push(Felt { blow, stood, went_on, collisions });
        if let Err(error) = drove {
            tracing::warn!("{}", error.0);
            return Ok(());
        }
    }
    Ok(())
}

/// When the robot did what was waited for; what is known of it if it did not.
fn or_last_words(when: Option<Instant>, robot: &Watched, crew: &Crew<'_>, what: &str) -> Result<Instant, SuiteError> {
    when.ok_or_else(|| {
        SuiteError(format!("a robot did not {what}; it is {}, and they said last:\n{}", robot.describe(), crew.last_words()))
    })
}
