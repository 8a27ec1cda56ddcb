//! What one control period of a robot costs, and how that grows with the number of robots.
//!
//! Every figure comes from whole missions: actors, links, arbitration, base protection and the simulated world, exactly as
//! `orienteer run` does it. Each robot has 16 cone sonars, where-am-i, avoidance and a corridor follower, and a corridor of its
//! own, one beside the other, so that all robots have the same to do and as many within earshot however many there are. The
//! world has 500 walls at least.
//!
//! What is measured begins when the mission is warm: buffers have grown, every topic has been seen. On one thread it is the
//! processor's time, so that whatever else the machine does counts little; on two it is the wall's.
//!
//! * `robot step`: one robot, by link and with or without a recording (the thread that writes is not counted), with two passes of
//!   its ring in a step, as usual, and with one;
//! * `fleet`: the same divided by robots, for 1 to 1000 robots on 1 and 2 threads;
//! * before these, a table of allocations in a warm step: all of them, those of the agents, and what actix takes for its
//!   messages.
//!
//! ```sh
//! cargo bench --bench robot_step
//! ```

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::{Cell, RefCell},
    fmt::Write,
    ops::ControlFlow,
    rc::Rc,
    sync::atomic::{AtomicU64, Ordering},
    time::Duration,
};

use actix::{Actor, Addr, Context, Handler, Message};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group};
use orienteer::{
    Registry,
    agents::{Avoidance, CorridorFollower, WhereAmI},
    hardware::sim::Arena,
    mission::{self, Loaded, Recording, RunOptions},
    runtime::{
        agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Phase, RobotContext, Wiring},
        time::Time,
    },
};

/// Counts what is asked of the system's allocator.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call goes to `System` as it came; counting touches nothing but an atomic.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the promises that `System` asks for; they are the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: `pointer` came from `System` with this layout, and the caller vouches for the size.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations() -> u64 {
    ALLOCATIONS.load(Ordering::Relaxed)
}

/// Control periods per second. The ring takes 25 ms for a pass, so that a step has two passes of 16 sonars.
const USUAL_RATE: f64 = 20.0;
/// The same with one pass in a step.
const RATE_OF_RING: f64 = 40.0;

/// Robots that each have a corridor of their own, 60 m long and 2.46 m wide.
fn mission(robots: usize, links: &str, rate: f64, registry: &Registry) -> Loaded {
    // A world may reach from -500 to 500 m.
    const ROWS: usize = 63;
    /// Four walls each.
    const FEWEST_CORRIDORS: usize = 125;
    let mut world = String::from("name = \"corridors\"\n");
    let mut robot_tables = String::new();
    for i in 0..robots.max(FEWEST_CORRIDORS) {
        let (x, y) = ((i / ROWS) as f64 * 62.0 - 498.0, (i % ROWS) as f64 * 5.0);
        // Writing to a string can't fail.
        let _ = writeln!(world, "[[corridor]]\nalong = [[{x:.1}, {y:.1}], [{:.1}, {y:.1}]]\nwidth = 2.46", x + 60.0);
        if i < robots {
            let start = x + 15.0;
            let table = format!("name = \"r{i}\"\ntemplate = \"huey\"\nstart = {{ x = {start:.1}, y = {y:.1} }}");
            let _ = writeln!(robot_tables, "[[robot]]\n{table}");
        }
    }
    let text = format!(
        r#"
        [mission]
        links = "{links}"
        control_rate_hz = {rate:.1}
        [world]
        file = "corridors.toml"
        [template.huey]
        base = {{ driver = "sim", platform = "b12-huey" }}
        sonar = {{ driver = "sim", ring = "denning-16" }}
        [template.huey.agent.where-am-i]
        [template.huey.agent.avoidance]
        priority = 10
        [template.huey.agent.corridor-follower]
        priority = 5
        autostart = true
        cruise_speed = 0.4
        {robot_tables}"#
    );
    let files = [("bench.toml".to_owned(), text.into_bytes()), ("corridors.toml".to_owned(), world.into_bytes())];
    mission::load_files(files, "bench.toml", registry).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Steps before the first that is measured: the longest firing programs have come round, all buffers have grown.
const WARM_UP: u64 = 100;

/// Time spent so far: of the calling thread's processor, or of the wall.
fn spent(threads: usize) -> Duration {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    let clock = if threads == 1 { libc::CLOCK_THREAD_CPUTIME_ID } else { libc::CLOCK_MONOTONIC };
    // SAFETY: both clocks exist, and `time` is where the answer may go.
    let result = unsafe { libc::clock_gettime(clock, &mut time) };
    assert_eq!(result, 0, "the system has no such clock");
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// A mission that is measured.
#[derive(Clone)]
struct Case {
    robots: usize,
    links: &'static str,
    threads: usize,
    /// Control periods per second.
    rate: f64,
    record: Recording,
    /// Steps that are measured.
    steps: u64,
}

/// So few that nobody comes within earshot of a corridor's end.
const MOST_STEPS: u64 = 1000;

impl Case {
    /// One robot on one thread.
    fn alone(links: &'static str, rate: f64, record: Recording) -> Self {
        Self { robots: 1, links, threads: 1, rate, record, steps: MOST_STEPS }
    }

    fn fleet(robots: usize, links: &'static str, threads: usize) -> Self {
        let steps = (20_000 / robots as u64).clamp(100, MOST_STEPS);
        Self { robots, links, threads, rate: USUAL_RATE, record: Recording::Off, steps }
    }

    /// Time that the warm mission takes for one step of one robot, mean over its steps.
    fn run(&self) -> Duration {
        let registry = Registry::standard();
        let loaded = mission(self.robots, self.links, self.rate, &registry);
        let marks: Rc<RefCell<Vec<Duration>>> = Rc::default();
        let (kept, mut step, steps, threads) = (marks.clone(), 0, self.steps, self.threads);
        let observer = move |_: Time, _: Option<&Arena>| {
            step += 1;
            if step == WARM_UP || step == WARM_UP + steps {
                kept.borrow_mut().push(spent(threads));
            }
            ControlFlow::Continue(())
        };
        let options = RunOptions {
            // The first step is at 0.
            duration: Some(Duration::from_secs_f64((WARM_UP + steps - 1) as f64 / self.rate)),
            threads: Some(threads),
            record: self.record.clone(),
            observer: Some(Box::new(observer)),
            ..RunOptions::default()
        };
        mission::run(loaded, &registry, options).unwrap_or_else(|error| panic!("{error}"));
        let marks = marks.borrow();
        (marks[1] - marks[0]).div_f64(steps as f64 * self.robots as f64)
    }

    /// Criterion asks for more iterations than there is time for missions: a mission of thousands of robot steps stands for many.
    fn measure(&self, iterations: u64) -> Duration {
        let missions = iterations.div_ceil(self.steps * self.robots as u64).max(1);
        let sum: Duration = (0..missions).map(|_| self.run()).sum();
        sum.div_f64(missions as f64).mul_f64(iterations as f64)
    }
}

fn robot_step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("robot step");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(2));
    let directory = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let file = Recording::File(directory.path().join("bench.mcap"));
    for (links, rate) in [("direct", USUAL_RATE), ("direct", RATE_OF_RING), ("local", USUAL_RATE), ("shared", USUAL_RATE)] {
        for (name, record) in [("plain", Recording::Off), ("recorded", file.clone())] {
            let case = Case::alone(links, rate, record);
            group.bench_function(BenchmarkId::new(format!("{links}, {rate} Hz"), name), |bencher| {
                bencher.iter_custom(|iterations| case.measure(iterations));
            });
        }
    }
    group.finish();
}

fn fleet(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("fleet");
    group.sample_size(10).warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_millis(500));
    group.throughput(Throughput::Elements(1));
    for (links, most) in [("direct", 1000), ("shared", 10)] {
        for threads in [1, 2] {
            for robots in [1, 10, 100, 1000].into_iter().filter(|robots| *robots <= most && *robots >= threads) {
                let case = Case::fleet(robots, links, threads);
                group.bench_function(BenchmarkId::new(format!("{links}, {threads} threads"), robots), |bencher| {
                    bencher.iter_custom(|iterations| case.measure(iterations));
                });
            }
        }
    }
    group.finish();
}

thread_local! {
    /// Allocations made within the steps of agents.
    static IN_AGENTS: Cell<u64> = const { Cell::new(0) };
}

/// An agent whose allocations are counted apart.
struct Counted<A>(A);

impl<A: Behaviour> Behaviour for Counted<A> {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        let before = allocations();
        self.0.step(now, inputs, out);
        IN_AGENTS.set(IN_AGENTS.get() + allocations() - before);
    }

    fn finish(&mut self, now: Time, last_words: &mut Finish) {
        self.0.finish(now, last_words);
    }
}

impl<A: Agent> Agent for Counted<A> {
    const KIND: &'static str = A::KIND;
    const HELP: &'static str = A::HELP;
    const PHASE: Phase = A::PHASE;
    const CLAIMS: bool = A::CLAIMS;
    const PRIORITY: u8 = A::PRIORITY;
    type Config = A::Config;

    fn topics(wiring: &mut Wiring) {
        A::topics(wiring);
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        A::build(config, robot).map(Self)
    }
}

/// All allocations, and those in agents, between two warm steps of a mission on one thread.
fn count(robots: usize, links: &str) -> (f64, f64) {
    const FROM: f64 = 20.0;
    const STEPS: u64 = 1000;
    let registry = Registry::standard()
        .with_agent::<Counted<WhereAmI>>()
        .with_agent::<Counted<Avoidance>>()
        .with_agent::<Counted<CorridorFollower>>();
    let loaded = mission(robots, links, USUAL_RATE, &registry);
    let marks: Rc<RefCell<Vec<(u64, u64)>>> = Rc::new(RefCell::new(Vec::with_capacity(4)));
    let kept = marks.clone();
    let mut left = 0;
    let observer = move |now: Time, _: Option<&Arena>| {
        if now.as_secs_f64() >= FROM {
            if left == 0 || left == STEPS {
                kept.borrow_mut().push((allocations(), IN_AGENTS.get()));
            }
            left += 1;
        }
        if left > STEPS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let options = RunOptions {
        duration: Some(Duration::from_secs(3600)),
        threads: Some(1),
        record: Recording::Off,
        observer: Some(Box::new(observer)),
        ..RunOptions::default()
    };
    if let Err(error) = mission::run(loaded, &registry, options) {
        panic!("{error}");
    }
    let marks = marks.borrow();
    let per_step = |count: fn(&(u64, u64)) -> u64| (count(&marks[1]) - count(&marks[0])) as f64 / STEPS as f64;
    (per_step(|mark| mark.0), per_step(|mark| mark.1))
}

/// A message to a bare actor, as large as those that lead a robot through its step.
#[derive(Message)]
#[rtype(result = "()")]
struct Ball(u64);

/// One of two actors that throw a ball to each other.
struct Player {
    partner: Option<Addr<Player>>,
    done: Rc<Cell<bool>>,
}

/// Play with this partner.
#[derive(Message)]
#[rtype(result = "()")]
struct Meet(Addr<Player>);

impl Handler<Meet> for Player {
    type Result = ();

    fn handle(&mut self, meet: Meet, _: &mut Context<Self>) {
        self.partner = Some(meet.0);
    }
}

impl Actor for Player {
    type Context = Context<Self>;
}

impl Handler<Ball> for Player {
    type Result = ();

    fn handle(&mut self, ball: Ball, _: &mut Context<Self>) {
        match (ball.0.checked_sub(1), &self.partner) {
            (Some(left), Some(partner)) => partner.do_send(Ball(left)),
            _ => self.done.set(true),
        }
    }
}

/// Allocations that actix makes for one `do_send` between two actors on one arbiter.
fn count_message() -> f64 {
    const MESSAGES: u64 = 10_000;
    let count = Rc::new(Cell::new(0.0));
    let result = count.clone();
    actix::System::new().block_on(async move {
        let done: Rc<Cell<bool>> = Rc::default();
        let left = Player { partner: None, done: done.clone() }.start();
        let right = Player { partner: Some(left.clone()), done: done.clone() }.start();
        left.do_send(Meet(right.clone()));
        // Once to warm up, once to count.
        for _ in 0..2 {
            done.set(false);
            let before = allocations();
            right.do_send(Ball(MESSAGES));
            while !done.get() {
                actix::clock::sleep(Duration::from_millis(1)).await;
            }
            result.set((allocations() - before) as f64 / MESSAGES as f64);
        }
    });
    count.get()
}

/// Prints what a warm robot step allocates: the difference between 16 robots and 9, so that the fleet's own share is apart.
/// (Lists that the fleet makes anew in each step grow as often for 9 as for 16.)
fn report_allocations() {
    /// Step and answer of each turn (base twice, sonar, three agents, arbitration), and of the robot itself.
    const MESSAGES: f64 = 2.0 * 7.0 + 2.0;
    let message = count_message();
    println!("allocations per warm step, recording off, one thread");
    println!("  one actix message (two actors, one arbiter): {message:.3}; a robot step is {MESSAGES} messages");
    for links in ["direct", "local", "shared"] {
        let (nine, _) = count(9, links);
        let (sixteen, in_agents) = count(16, links);
        let robot = (sixteen - nine) / 7.0;
        println!(
            "  {links:<7} {robot:>7.3} per robot; in its agents {:.3}; less actix messages {:.3}; fleet {:.3} per step",
            in_agents / 16.0,
            robot - MESSAGES * message,
            nine - 9.0 * robot,
        );
    }
    println!();
}

criterion_group!(benches, robot_step, fleet);

fn main() {
    // `cargo bench -- <filter>` looks for some benchmark; the table stands before all of them.
    report_allocations();
    benches();
    Criterion::default().configure_from_args().final_summary();
}
