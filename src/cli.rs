//! The command line: what each command takes, and what its exit code means.

mod check;
mod emulate;
mod hardware;
mod list;
mod log;
mod map;
mod new_files;
mod progress;
mod refusal;
mod reproduce;
mod run;
mod stderr;
mod style;
mod summary;
mod table;
mod verify;
mod why;
mod world;

use std::{path::PathBuf, process::ExitCode};

use crate::{
    Registry,
    emulate::{Language, Start},
    hardware::{line::mind_if_asked, world::floors::Hypothesis},
    reproduce::SUITES,
    runtime::{config::mission::MOST_THREADS, fleet::before_exit},
};
use clap::{Args, Parser, Subcommand, builder::PossibleValuesParser};

use refusal::Refusal;

/// Actor-based mobile robots that find their way by sonar.
#[derive(Debug, Parser)]
#[command(name = "orienteer", version, after_help = EXIT_CODES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,

    /// Show what robots log; -vv: the details too
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,

    /// Show errors only, no warnings
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
}

const EXIT_CODES: &str = "\
Begin with:
  orienteer run                        two robots; maps and pictures in `out/`
  orienteer why out/office-floor.mcap --robot ann --at 60

Exit codes:
  0    all went well
  1    a result is not as it should be: `verify` found a difference,
       a row of `reproduce` falls short
  2    the command line or the configuration is wrong; nothing was run
  3    something failed while it ran: a link, a thread, a file
  130  stopped by Ctrl-C, SIGTERM or SIGHUP; `run` has stopped all bases,
       closed the recording and printed the summary";

const EMULATORS: &str = "\
Without --port:
  arcos   tcp://127.0.0.1:8101, where `configs/pioneer.toml` looks for it
  create  tcp://127.0.0.1:8102, where `configs/create.toml` does";

/// Missions may not last longer, s: a month, as in configurations.
const LONGEST: f64 = 2_678_400.0;

/// A row of `reproduce` has no more seeds.
const MOST_SEEDS: u64 = 1_000_000_000;

/// What a command comes to. See [`EXIT_CODES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All went well.
    Well,
    /// A result is not as it should be.
    FallsShort,
    /// The command line or the configuration is wrong.
    Misused,
    /// Something failed while it ran.
    Failed,
    /// Stopped by Ctrl-C or another signal.
    Interrupted,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        ExitCode::from(match outcome {
            Outcome::Well => 0,
            Outcome::FallsShort => 1,
            Outcome::Misused => 2,
            Outcome::Failed => 3,
            Outcome::Interrupted => 130,
        })
    }
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a mission; without CONFIG, two robots on an office floor
    Run(RunArguments),
    /// Run one robot's base and sonar, for a mission in another process
    Hardware(HardwareArguments),
    /// Check a configuration without running it
    Check(CheckArguments),
    /// Print the JSON schema of missions or worlds, for editors
    Schema(SchemaArguments),
    /// List agents, drivers, platforms, rings, worlds and suites
    List(ListArguments),
    /// Say why a robot did what it did at a time of a recording
    Why(WhyArguments),
    /// Run a recorded mission again and compare byte for byte
    Verify(VerifyArguments),
    /// Draw the map from a recording
    Map(MapArguments),
    /// Make a floor of corridors, or a single junction, as a world file
    World(WorldArguments),
    /// Emulate a real robot at a port, for drivers
    Emulate(EmulateArguments),
    /// Repeat experiments and compare their figures with their goals
    Reproduce(ReproduceArguments),
}

impl Command {
    /// How much is logged unless somebody wants more. Nothing but its log tells how hardware fares.
    fn usual_verbosity(&self) -> u8 {
        u8::from(matches!(self, Command::Hardware(_)))
    }

    /// True if what robots find out is news. Of hundreds in a suite nobody wants to hear it.
    fn has_news(&self) -> bool {
        !matches!(self, Command::Reproduce(_))
    }

    fn answers_in_json(&self) -> bool {
        match self {
            Command::Run(arguments) => arguments.json,
            Command::Check(arguments) => arguments.json,
            Command::List(arguments) => arguments.json,
            Command::Why(arguments) => arguments.json,
            Command::Reproduce(arguments) => arguments.json,
            Command::Emulate(arguments) => arguments.json.is_some(),
            Command::Hardware(_) | Command::Schema(_) | Command::Verify(_) | Command::Map(_) | Command::World(_) => false,
        }
    }
}

/// What `run` takes.
#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// The mission; without it, the built-in office floor
    pub config: Option<PathBuf>,
    /// Times real time, if not as fast as it can
    #[arg(long, value_name = "FACTOR", value_parser = factor, allow_negative_numbers = true)]
    pub speed: Option<f64>,
    /// End after this many simulated seconds
    #[arg(long = "for", value_name = "SECONDS", value_parser = duration, allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// Use this seed instead of the configuration's
    #[arg(long, value_parser = seed, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Spread the robots over this many threads
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_THREADS)), allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Write the recording to this file
    #[arg(long, value_name = "FILE", conflicts_with = "no_record")]
    pub record: Option<PathBuf>,
    /// Do not record
    #[arg(long)]
    pub no_record: bool,
    /// Where maps, pictures and recording go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// What `hardware` takes.
#[derive(Debug, Args)]
pub(crate) struct HardwareArguments {
    /// The mission, the same that `run` gets
    pub config: PathBuf,
    /// The robot; needed if the mission has several
    #[arg(long)]
    pub robot: Option<String>,
    /// End after this many seconds
    #[arg(long = "for", value_name = "SECONDS", value_parser = duration, allow_negative_numbers = true)]
    pub duration: Option<f64>,
}

/// What `check` takes.
#[derive(Debug, Args)]
pub(crate) struct CheckArguments {
    /// The mission
    pub config: PathBuf,
    /// Print the problems as JSON
    #[arg(long)]
    pub json: bool,
}

/// What `schema` takes.
#[derive(Debug, Args)]
pub(crate) struct SchemaArguments {
    /// mission or world
    #[arg(hide_possible_values = true, hide_default_value = true, default_value = "mission", value_parser = ["mission", "world"])]
    pub of: String,
}

/// What `list` takes.
#[derive(Debug, Args)]
pub(crate) struct ListArguments {
    /// agents, drivers, platforms, rings, worlds or suites; else all
    #[arg(hide_possible_values = true, value_parser = ["agents", "drivers", "platforms", "rings", "worlds", "suites"])]
    pub what: Option<String>,
    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

/// What `why` takes.
#[derive(Debug, Args)]
pub(crate) struct WhyArguments {
    /// The recording
    pub recording: PathBuf,
    /// The robot; needed if the recording has several
    #[arg(long)]
    pub robot: Option<String>,
    /// Seconds since the start of the mission
    #[arg(long, value_name = "SECONDS", value_parser = instant, allow_negative_numbers = true)]
    pub at: f64,
    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

/// What `verify` takes.
#[derive(Debug, Args)]
pub(crate) struct VerifyArguments {
    /// The recording
    pub recording: PathBuf,
    /// Spread the robots over this many threads
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_THREADS)), allow_negative_numbers = true)]
    pub threads: Option<u16>,
}

/// What `map` takes.
#[derive(Debug, Args)]
pub(crate) struct MapArguments {
    /// The recording
    pub recording: PathBuf,
    /// The robot; without it, all with poses and scans
    #[arg(long)]
    pub robot: Option<String>,
    /// Write the maps into this directory
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

/// What `world` takes.
#[derive(Debug, Args)]
pub(crate) struct WorldArguments {
    /// Another seed, another world
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Write the world to this file, not to standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write what is true of it to this file, as JSON
    #[arg(long, value_name = "FILE")]
    pub truth: Option<PathBuf>,
    /// Draw it into this file, as PNG
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// Write over files that are there
    #[arg(long)]
    pub force: bool,
    /// One place only: H1 to H12 (Randazza 1989) or dead-end
    #[arg(long, value_name = "KIND", conflicts_with = "FloorArguments")]
    pub junction: Option<Hypothesis>,
    /// Its measures may be this share off, up to 0.1
    #[arg(long, value_name = "SHARE", requires = "junction", value_parser = world::perturbation)]
    pub perturb: Option<f64>,
    #[command(flatten)]
    pub floor: world::FloorArguments,
}

/// What `emulate` takes.
#[derive(Debug, Args)]
#[command(after_help = EMULATORS)]
pub(crate) struct EmulateArguments {
    /// What it speaks: arcos (Pioneer, AmigoBot) or create (Roomba, too)
    #[arg(hide_possible_values = true, value_parser = emulate::language)]
    pub language: Language,
    /// The world's file, if not the built-in office floor
    #[arg(long, value_name = "FILE")]
    pub world: Option<PathBuf>,
    /// Where it is found: tcp://HOST:PORT, pty or pty:/PATH
    #[arg(long)]
    pub port: Option<String>,
    /// arcos: p3dx (the default) or amigobot; create: create2
    #[arg(long)]
    pub robot: Option<String>,
    /// arcos: p3dx-sh, p2dx, amigo ...; or create2, create1
    #[arg(long)]
    pub model: Option<String>,
    /// A place of the world, or metres and degrees: 2,1.5,90
    #[arg(long, value_name = "WHERE", value_parser = emulate::start, allow_hyphen_values = true)]
    pub start: Option<Start>,
    /// Seed of noise and people
    #[arg(long, default_value = "1", value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// End after this many seconds
    #[arg(long = "for", value_name = "SECONDS", value_parser = duration, allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// Print how it stands as a line of JSON this often
    #[arg(long, value_name = "SECONDS", value_parser = duration, allow_negative_numbers = true)]
    #[arg(num_args = 0..=1, default_missing_value = "1")]
    pub json: Option<f64>,
}

/// What `reproduce` takes.
#[derive(Debug, Args)]
pub(crate) struct ReproduceArguments {
    /// The suite, see `orienteer list suites`; without it, all
    #[arg(hide_possible_values = true, value_parser = PossibleValuesParser::new(SUITES.iter().map(|suite| suite.name)))]
    pub suite: Option<String>,
    /// Number of seeds per row
    #[arg(long, value_name = "N", value_parser = seeds, allow_negative_numbers = true)]
    pub seeds: Option<u64>,
    /// A tenth of the seeds: a quick look, not a proof
    #[arg(long)]
    pub quick: bool,
    /// Print as JSON
    #[arg(long)]
    pub json: bool,
}

/// The whole program: reads the command line, does what it says with what this registry has, and gives the exit code.
///
/// A program of your own, with agents and drivers of your own, has all commands with it:
///
/// ```no_run
/// use std::process::ExitCode;
///
/// fn main() -> ExitCode {
///     // .with_agent::<MyAgent>()
///     orienteer::cli::main(&orienteer::Registry::standard())
/// }
/// ```
pub fn main(registry: &Registry) -> ExitCode {
    mind_if_asked();
    let Arguments { command, verbose, quiet } = Arguments::parse();
    let _settled = stderr::Settled;
    log::start(verbose.max(command.usual_verbosity()), quiet, command.has_news());
    before_exit(stderr::settle_within);
    let json = command.answers_in_json();
    let outcome = match command {
        Command::Run(arguments) => run::run(&arguments, registry),
        Command::Hardware(arguments) => hardware::hardware(&arguments, registry),
        Command::Check(arguments) => check::check(&arguments, registry),
        Command::Schema(arguments) => check::schema(&arguments, registry),
        Command::List(arguments) => list::list(&arguments, registry),
        Command::Why(arguments) => why::why(&arguments, registry),
        Command::Verify(arguments) => verify::verify(&arguments, registry),
        Command::Map(arguments) => map::map(&arguments, registry),
        Command::World(arguments) => world::world(&arguments),
        Command::Emulate(arguments) => emulate::emulate(&arguments),
        Command::Reproduce(arguments) => reproduce::reproduce(&arguments),
    };
    outcome.unwrap_or_else(|refusal| refusal.tell(json)).into()
}

fn factor(text: &str) -> Result<f64, String> {
    within(text, 0.001, 1e6, "a factor from 0.001 to 1000000 is needed: 1 for real time, 10 for ten times as fast")
}

fn duration(text: &str) -> Result<f64, String> {
    within(text, 0.001, LONGEST, "a number of seconds is needed, from 0.001 to 2678400 (a month)")
}

fn instant(text: &str) -> Result<f64, String> {
    within(text, 0.0, LONGEST, "a number of seconds since the start of the mission is needed, from 0 to 2678400 (a month)")
}

fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("a whole number is needed, from 0 to {}", u64::MAX))
}

fn seeds(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|number| (1..=MOST_SEEDS).contains(number));
    number.ok_or_else(|| format!("a whole number is needed, from 1 to {MOST_SEEDS}"))
}

fn within(text: &str, least: f64, most: f64, hint: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(hint.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_makes_sense() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn numbers_have_bounds() {
        assert_eq!(duration("600"), Ok(600.0));
        for absurd in ["", "x", "-1", "0", "nan", "inf", "1e300"] {
            assert!(duration(absurd).is_err() && factor(absurd).is_err(), "{absurd}");
        }
        assert_eq!(instant("0"), Ok(0.0));
        assert_eq!((seed("0"), seed("18446744073709551615")), (Ok(0), Ok(u64::MAX)));
        assert_eq!((seeds("1"), seeds("1000000000")), (Ok(1), Ok(MOST_SEEDS)));
        for absurd in ["", "x", "-1", "1.5", "1e3", "18446744073709551616"] {
            assert!(seed(absurd).is_err() && seeds(absurd).is_err(), "{absurd}");
        }
        assert!(seeds("0").is_err());
    }
}
