//! The emulated Create, driven by somebody else's client: pycreate2, which was written for the real one.
//!
//! It needs a Python with that package: `pip install pycreate2`, and `ORIENTEER_PYTHON` if that is not `python3`. Where `python3` has not
//! got it there is nothing to be tested, and the test says so; a Python that was named must have it.
#![allow(clippy::unwrap_used)]

use std::{
    collections::HashMap,
    env,
    ffi::OsString,
    ops::ControlFlow,
    process::{Command, Output},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
};

use orienteer_hardware::{
    base::odometry::OdometryConfig,
    emulator::{CreateEmulator, Port, Rig, live},
    sim::{Arena, SimBase, SimBodyConfig},
    wire::oi::units::Model,
    world::World,
};
use orienteer_runtime::{geometry::Pose, random::Streams, topics::Truth};

/// Drives ahead, turns to the left and back again, and ends at the wall. What it reads it prints as `@name value`.
const SCRIPT: &str = "
import sys, time
from pycreate2 import Create2

def tell(name, value):
    print('@' + name, int(value))

bot = Create2(sys.argv[1])
bot.start()
tell('mode_after_start', bot.get_sensors().open_interface_mode)
bot.safe()
first = bot.get_sensors()
tell('mode_after_safe', first.open_interface_mode)
tell('voltage', first.voltage)
tell('charge', first.battery_charge)
bot.drive_direct(200, 200)
time.sleep(1.0)
running = bot.get_sensors()
tell('requested_right', running.velocity_right)
tell('requested_left', running.velocity_left)
tell('stasis', running.statis.toggling)
tell('bumps_on_the_way', any(running.bumps_wheeldrops))
bot.drive_stop()
then = bot.get_sensors()
tell('left_counts', (then.encoder_counts_left - first.encoder_counts_left) % 65536)
tell('right_counts', (then.encoder_counts_right - first.encoder_counts_right) % 65536)
tell('way', running.distance + then.distance)
bot.led(8, 255, 255)
bot.digit_led_ascii('OI')
bot.drive_direct(100, -100)
time.sleep(1.0)
bot.drive_stop()
turned = bot.get_sensors()
tell('angle', turned.angle)
bot.drive_direct(-100, 100)
time.sleep(1.0)
bot.drive_stop()
bot.drive_direct(500, 500)
time.sleep(3.0)
at_wall = bot.get_sensors()
tell('bumps_at_the_wall', any(at_wall.bumps_wheeldrops[:2]))
tell('drops_at_the_wall', any(at_wall.bumps_wheeldrops[2:]))
bot.drive_stop()
bot.full()
tell('mode_after_full', bot.get_sensors().open_interface_mode)
";

/// A Create in front of a wall, 1.5 m from its own front.
fn rig() -> Rig<CreateEmulator> {
    let plan = toml::from_str("[[room]]\ncorners = [[0, 0], [3, 4]]").unwrap();
    let arena = Arena::new(World::from_plan(&plan, &|_| unreachable!()).unwrap(), Streams::new(1)).unwrap();
    let base = CreateEmulator::body();
    let config = SimBodyConfig { base: base.clone(), odometry: OdometryConfig::exact() };
    let body = arena.add("create", Pose::new(1.33, 2.0, 0.0), config).unwrap();
    Rig::new(CreateEmulator::new(Model::CREATE_2), arena, SimBase::new(body, base.platform()), None)
}

/// Lets the robot live at this port until it is told to quit. Returns where it is then.
fn run(mut port: Port, quit: &AtomicBool) -> Truth {
    let mut rig = rig();
    live(
        &mut rig,
        &mut port,
        |_, _| {
            if quit.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        },
    );
    rig.truth()
}

/// The Python that somebody has named.
fn named() -> Option<OsString> {
    env::var_os("ORIENTEER_PYTHON")
}

fn python(arguments: &[&str]) -> Option<Output> {
    Command::new(named().unwrap_or_else(|| "python3".into())).args(arguments).output().ok()
}

#[test]
fn a_client_for_the_real_robot_drives_the_emulated_one() {
    if !python(&["-c", "import pycreate2"]).is_some_and(|asked| asked.status.success()) {
        assert_eq!(named(), None, "there is no such Python, or it has no pycreate2");
        eprintln!("skipped: there is no Python with pycreate2");
        return;
    }
    let port = Port::open("pty").unwrap();
    let (name, quit) = (port.name().to_owned(), Arc::new(AtomicBool::new(false)));
    let quits = quit.clone();
    let robot = thread::spawn(move || run(port, &quits));
    let output = python(&["-c", SCRIPT, &name]).unwrap();
    quit.store(true, Ordering::Relaxed);
    let truth = robot.join().unwrap();
    let told = String::from_utf8_lossy(&output.stdout);
    println!("{told}{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success());
    let values: HashMap<&str, i64> = told
        .lines()
        .filter_map(|line| line.strip_prefix('@')?.split_once(' '))
        .map(|(name, value)| (name, value.parse().unwrap()))
        .collect();
    let value = |name: &str| values[name];
    assert_eq!(["mode_after_start", "mode_after_safe", "mode_after_full"].map(value), [1, 2, 3]);
    assert_eq!(["voltage", "charge", "requested_right", "requested_left"].map(value), [14_400, 1800, 200, 200]);
    assert_eq!(["stasis", "bumps_on_the_way", "bumps_at_the_wall", "drops_at_the_wall"].map(value), [1, 0, 1, 0]);
    // A second and what Python takes besides, at 200 mm/s: 450 counts. Its own drive_stop waits until the wheels stand.
    let (left, right, way) = (value("left_counts"), value("right_counts"), value("way"));
    assert!((400..700).contains(&left) && (left - right).abs() <= 1, "{left} {right}");
    assert!((way as f64 - left as f64 * 0.44457).abs() < 3.0, "{way} mm, {left} counts");
    assert!((43..80).contains(&value("angle")), "to the left: {}°", value("angle"));
    assert!(truth.collisions == 1 && truth.twist.is_stop() && truth.pose.x > 2.8, "{truth:?}");
}
