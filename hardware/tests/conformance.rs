//! The drivers that come with Orienteer, put through what every driver has to do.
#![allow(clippy::unwrap_used)]

use std::{
    collections::VecDeque,
    io::{self, Read, Write},
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Mutex},
    time::Duration,
};

use orienteer_hardware::{
    arcos::{ArcosBase, Client, Profile},
    base::{odometry::OdometryConfig, presets},
    conformance::{Bench, RULES},
    driver::{BaseDriver, DriverError},
    emulator::{ArcosEmulator, CreateEmulator, Make, Rig},
    line::{Minder, Minding},
    log::{self, LogBase, SonarLog},
    oi::{self, CreateBase},
    rings,
    sim::{Arena, SimBase, SimBody, SimBodyConfig, SimSonar},
    wire::{
        arcos::units::Units,
        oi::{STOP_ANYHOW, units::Model},
    },
    world::World,
};
use orienteer_runtime::{
    geometry::{Pose, Twist},
    random::Streams,
    robot_model::Platform,
    time::Time,
    topics::Odometry,
};

/// A floor on which nobody meets anything.
fn floor() -> Arc<Arena> {
    let plan = toml::from_str("[[room]]\ncorners = [[-80, -80], [80, 80]]").unwrap();
    Arena::new(World::from_plan(&plan, &|_| unreachable!()).unwrap(), Streams::new(1)).unwrap()
}

fn body(arena: &Arc<Arena>, platform: &str, odometry: OdometryConfig) -> (Arc<Mutex<SimBody>>, SimBase) {
    let base = presets::by_name(platform).unwrap();
    let described = base.platform();
    let body = arena.add("r", Pose::new(-20.0, 0.0, 0.0), SimBodyConfig { base, odometry }).unwrap();
    (body.clone(), SimBase::new(body, described))
}

/// A simulated base.
struct Simulated {
    driver: SimBase,
    _arena: Arc<Arena>,
    now: Time,
}

impl Simulated {
    fn of(platform: &str) -> Self {
        let arena = floor();
        Self { driver: body(&arena, platform, OdometryConfig::exact()).1, _arena: arena, now: Time::START }
    }
}

macro_rules! simulated {
    ($($name:ident: $platform:literal),+) => {
        $(mod $name {
            use super::*;

            struct This(Simulated);

            impl Bench for This {
                fn new() -> Self {
                    Self(Simulated::of($platform))
                }

                fn base(&mut self) -> &mut dyn BaseDriver {
                    &mut self.0.driver
                }

                fn pass(&mut self, span: Duration) {
                    self.0.now = self.0.now + span;
                }

                fn now(&self) -> Time {
                    self.0.now
                }

                fn moves(&self) -> Twist {
                    self.0.driver.truth().unwrap().twist
                }
            }

            orienteer_hardware::conformance!(This);
        })+
    };
}

simulated!(synchro: "b12-huey", differential: "p3dx", bicycle: "wheelchair");

/// A log that is played, and obeys nobody.
struct Played {
    driver: LogBase,
    now: Time,
}

impl Bench for Played {
    fn new() -> Self {
        let poses: String = (0..100).map(|n| format!("{} {} 0 0\n", n * 300, n * 50)).collect();
        let measurements: String = (0..100).map(|n| format!("{} 1000 1000 1000 1000 1000 1000 1000 1000\n", n * 300)).collect();
        let log = SonarLog::parse(("poses", &poses), ("measurements", &measurements)).unwrap();
        Self { driver: log::players(Arc::new(log)).0, now: Time::START }
    }

    fn base(&mut self) -> &mut dyn BaseDriver {
        &mut self.driver
    }

    fn pass(&mut self, span: Duration) {
        self.now = self.now + span;
    }

    fn now(&self) -> Time {
        self.now
    }

    fn moves(&self) -> Twist {
        Twist::STOP
    }

    fn obeys(&self) -> bool {
        false
    }
}

mod played {
    orienteer_hardware::conformance!(super::Played);
}

/// Bytes under way, to the base and back.
#[derive(Clone, Default)]
struct Wire(Arc<Mutex<[VecDeque<u8>; 2]>>);

impl Read for Wire {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let queue = &mut self.0.lock().unwrap()[1];
        if queue.is_empty() { Err(io::ErrorKind::WouldBlock.into()) } else { queue.read(into) }
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap()[0].write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A Pioneer at the other end of a wire.
struct Pioneer {
    driver: ArcosBase,
    rig: Rig<ArcosEmulator>,
    wire: Wire,
    cut: bool,
}

impl Bench for Pioneer {
    fn new() -> Self {
        let arena = floor();
        let (robot, base) = body(&arena, "p3dx", OdometryConfig::default());
        let ring = rings::find("p3dx-16").unwrap();
        let sonar = SimSonar::new(arena.clone(), "r", robot, ring.ring, &ring.model).unwrap();
        let preset = presets::p3dx();
        let make = Make::new(Units::of("p3dx").unwrap(), &preset, 16);
        let wire = Wire::default();
        let platform = preset.platform();
        let profile = Profile {
            units: None,
            acceleration: platform.acceleration,
            angular_acceleration: platform.angular_acceleration,
            transducers: 16,
            max_range: 5.0,
        };
        let driver = ArcosBase::new(Client::over(Box::new(wire.clone()), profile), platform);
        Self { driver, rig: Rig::new(ArcosEmulator::new(make), arena, base, sonar), wire, cut: false }
    }

    fn base(&mut self) -> &mut dyn BaseDriver {
        &mut self.driver
    }

    fn pass(&mut self, span: Duration) {
        for _ in 0..span.as_millis() / Rig::<ArcosEmulator>::BEAT.as_millis() {
            let mut received: Vec<u8> = self.wire.0.lock().unwrap()[0].drain(..).collect();
            if self.cut {
                received.clear();
            }
            let mut answer = Vec::new();
            self.rig.beat(&received, &mut answer);
            if !self.cut {
                self.wire.0.lock().unwrap()[1].extend(answer);
            }
        }
    }

    fn now(&self) -> Time {
        self.rig.now()
    }

    fn moves(&self) -> Twist {
        self.rig.truth().twist
    }

    fn cut(&mut self, cut: bool) -> bool {
        self.cut = cut;
        true
    }

    fn watchdog(&self) -> Duration {
        Duration::from_secs(2)
    }
}

mod pioneer {
    orienteer_hardware::conformance!(super::Pioneer);
}

#[test]
fn a_driver_tells_how_well_its_line_carries() {
    let mut pioneer = Pioneer::new();
    let mut polls = |count: usize, cut: bool, garbage: &[u8]| {
        pioneer.cut(cut);
        pioneer.wire.0.lock().unwrap()[1].extend(garbage);
        for _ in 0..count {
            pioneer.pass(Duration::from_millis(10));
            let _ = pioneer.driver.poll(pioneer.rig.now());
        }
        pioneer.driver.line().unwrap()
    };
    let silent = polls(10, true, &[]);
    assert_eq!((silent.age, silent.packets, silent.opened), (-1.0, 0, 1));
    let well = polls(300, false, &[]);
    assert!(well.packets > 10 && (0.0..0.2).contains(&well.age) && well.broken == 0 && well.noise == 0, "{well:?}");
    // Three bytes of no packet, and a packet with a checksum that is not its own.
    let disturbed = polls(100, false, &[1, 2, 3, 0xFA, 0xFB, 3, 0x30, 0, 1]);
    assert!(disturbed.broken == 1 && disturbed.noise >= 3 && disturbed.packets > well.packets, "{disturbed:?}");
    let lost = polls(100, true, &[]);
    assert!(lost.age > 0.9, "{lost:?}");
}

/// A Create at the other end of a wire, at whose far end somebody minds the base: it has no watchdog itself.
struct Create {
    driver: CreateBase,
    rig: Rig<CreateEmulator>,
    wire: Wire,
    minder: Minder,
    cut: bool,
}

/// What the minder waits for.
const SILENCE: Duration = Duration::from_millis(500);

impl Create {
    fn of(model: &str) -> Self {
        let (arena, model) = (floor(), Model::of(model).unwrap());
        let config = SimBodyConfig { base: CreateEmulator::body(), odometry: OdometryConfig::default() };
        let body = arena.add("r", Pose::new(-20.0, 0.0, 0.0), config).unwrap();
        let base = SimBase::new(body, CreateEmulator::body().platform());
        let (wire, platform) = (Wire::default(), presets::create2().platform());
        let client = oi::Client::over(Box::new(wire.clone()), oi::Profile::new(model, &platform));
        let driver = CreateBase::new(client, platform);
        let minder = Minder::new(Minding { stop: STOP_ANYHOW.to_vec(), silence: SILENCE });
        Self { driver, rig: Rig::new(CreateEmulator::new(model), arena, base, None), wire, minder, cut: false }
    }
}

impl Bench for Create {
    fn new() -> Self {
        Self::of("create2")
    }

    fn base(&mut self) -> &mut dyn BaseDriver {
        &mut self.driver
    }

    fn pass(&mut self, span: Duration) {
        for _ in 0..span.as_millis() / Rig::<CreateEmulator>::BEAT.as_millis() {
            let mut received: Vec<u8> = self.wire.0.lock().unwrap()[0].drain(..).collect();
            if self.cut {
                received.clear();
            }
            self.minder.hear(self.rig.now(), &received);
            received.extend(self.minder.due(self.rig.now()).unwrap_or_default());
            let mut answer = Vec::new();
            self.rig.beat(&received, &mut answer);
            if !self.cut {
                self.wire.0.lock().unwrap()[1].extend(answer);
            }
        }
    }

    fn now(&self) -> Time {
        self.rig.now()
    }

    fn moves(&self) -> Twist {
        self.rig.truth().twist
    }

    fn cut(&mut self, cut: bool) -> bool {
        self.cut = cut;
        true
    }

    fn watchdog(&self) -> Duration {
        SILENCE
    }
}

mod create {
    orienteer_hardware::conformance!(super::Create);
}

#[test]
fn a_create_s_line_is_told_of_too() {
    let mut create = Create::new();
    let mut polls = |count: usize, garbage: &[u8]| {
        create.wire.0.lock().unwrap()[1].extend(garbage);
        for _ in 0..count {
            create.pass(Duration::from_millis(10));
            let _ = create.driver.poll(create.rig.now());
        }
        create.driver.line().unwrap()
    };
    let well = polls(300, &[]);
    assert!(well.packets > 150 && (0.0..0.03).contains(&well.age) && (well.broken, well.noise) == (0, 0), "{well:?}");
    // Two bytes of no frame, and the beginning of one that goes on as another stream would.
    let disturbed = polls(100, &[1, 2, 19, 25, 8]);
    assert_eq!((disturbed.broken, disturbed.noise, disturbed.opened), (1, 5, 1));
}

/// One that counts its way in whole millimetres and degrees.
struct Create1(Create);

impl Bench for Create1 {
    fn new() -> Self {
        Self(Create::of("create1"))
    }

    fn base(&mut self) -> &mut dyn BaseDriver {
        self.0.base()
    }

    fn pass(&mut self, span: Duration) {
        self.0.pass(span);
    }

    fn now(&self) -> Time {
        self.0.now()
    }

    fn moves(&self) -> Twist {
        self.0.moves()
    }

    fn cut(&mut self, cut: bool) -> bool {
        self.0.cut(cut)
    }

    fn watchdog(&self) -> Duration {
        self.0.watchdog()
    }
}

mod create1 {
    orienteer_hardware::conformance!(super::Create1);
}

/// What a driver may do wrong, and the rule that finds it out.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Slip {
    Eager,
    Backward,
    TakesNanForSomething,
    DoesNotStop,
    OdometryJumps,
    CountsTooLittle,
    FromTheFuture,
    NeverComes,
    Waits,
    PromisesLessThanItDoes,
    PromisesNonsense,
    MissesTheCut,
    GoesOnWhenCut,
    ForgetsItsWay,
    /// For comparison.
    None,
}

const SLIPS: [(Slip, &str); 14] = [
    (Slip::Eager, "nothing_moves_before_it_is_meant_to"),
    (Slip::Backward, "it_goes_as_it_is_told"),
    (Slip::TakesNanForSomething, "what_is_no_number_moves_nothing"),
    (Slip::DoesNotStop, "it_stops_by_all_means"),
    (Slip::OdometryJumps, "odometry_goes_on"),
    (Slip::CountsTooLittle, "odometry_goes_on"),
    (Slip::FromTheFuture, "the_device_is_found"),
    (Slip::NeverComes, "the_device_is_found"),
    (Slip::Waits, "it_never_waits"),
    (Slip::PromisesLessThanItDoes, "no_command_exceeds_the_limits"),
    (Slip::PromisesNonsense, "the_platform_makes_sense"),
    (Slip::MissesTheCut, "a_line_that_is_cut_is_noticed_and_mended"),
    (Slip::GoesOnWhenCut, "a_line_that_is_cut_is_noticed_and_mended"),
    (Slip::ForgetsItsWay, "a_line_that_is_cut_is_noticed_and_mended"),
];

/// A simulated base whose driver slips.
struct Slipping {
    inner: Simulated,
    slip: Slip,
    platform: Platform,
    cut: bool,
    /// The way up to the last cut, m, for one who forgets it.
    forgotten: f64,
}

impl Slipping {
    fn of(slip: Slip) -> Self {
        let inner = Simulated::of("p3dx");
        let mut platform = inner.driver.platform().clone();
        match slip {
            Slip::PromisesLessThanItDoes => platform.limits.linear *= 0.5,
            Slip::PromisesNonsense => platform.limits.linear = f64::NAN,
            _ => {}
        }
        Self { inner, slip, platform, cut: false, forgotten: 0.0 }
    }
}

impl BaseDriver for Slipping {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        let twist = match self.slip {
            // The device's own watchdog.
            slip if self.cut && slip != Slip::GoesOnWhenCut => Twist::STOP,
            Slip::Eager => Twist::new(0.1, 0.0),
            Slip::Backward => Twist::new(-twist.linear, twist.angular),
            Slip::TakesNanForSomething if !twist.is_finite() => Twist::new(0.1, 0.0),
            _ => twist,
        };
        self.inner.driver.command(now, twist)
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        let mut odometry = self.inner.driver.poll(now)?;
        if self.cut && self.slip != Slip::MissesTheCut {
            return Err(DriverError::LinkLost { device: "it".into(), why: "the line is cut".into() });
        }
        odometry.travelled -= self.forgotten;
        match self.slip {
            Slip::Waits => std::thread::sleep(Duration::from_millis(6)),
            Slip::OdometryJumps if now > Time::from_secs_f64(5.0) => odometry.pose.x -= 1.0,
            Slip::CountsTooLittle => odometry.travelled *= 0.8,
            Slip::FromTheFuture => odometry.stamp = now + Duration::from_millis(50),
            Slip::NeverComes => return Err(DriverError::Waiting { device: "it".into(), why: "it is far".into() }),
            _ => {}
        }
        Ok(odometry)
    }

    fn stop(&mut self) {
        if self.slip != Slip::DoesNotStop {
            self.inner.driver.stop();
        }
    }
}

impl Bench for Slipping {
    fn new() -> Self {
        Self::of(Slip::None)
    }

    fn base(&mut self) -> &mut dyn BaseDriver {
        self
    }

    fn pass(&mut self, span: Duration) {
        self.inner.now = self.inner.now + span;
    }

    fn now(&self) -> Time {
        self.inner.now
    }

    fn moves(&self) -> Twist {
        self.inner.driver.truth().unwrap().twist
    }

    fn cut(&mut self, cut: bool) -> bool {
        if cut && self.slip == Slip::ForgetsItsWay {
            self.forgotten = self.inner.driver.poll(self.inner.now).unwrap().travelled;
        }
        self.cut = cut;
        true
    }
}

mod slipping_nowhere {
    orienteer_hardware::conformance!(super::Slipping);
}

#[test]
fn whoever_slips_is_found_out() {
    std::panic::set_hook(Box::new(|_| {}));
    for (name, rule) in RULES {
        let slips: Vec<Slip> = SLIPS.iter().filter(|(_, broken)| broken == name).map(|(slip, _)| *slip).collect();
        assert!(!slips.is_empty(), "nobody breaks {name}");
        for slip in slips {
            let mut bench = Slipping::of(slip);
            assert!(catch_unwind(AssertUnwindSafe(|| rule(&mut bench))).is_err(), "{slip:?} keeps to {name}");
        }
    }
}
