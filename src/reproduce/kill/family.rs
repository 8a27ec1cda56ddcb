//! The robots that are struck: what they are driven by, what befalls them, and in what time they must stand.

use super::axe::{Axe, Signal, Victim, Wire};

/// Robots of one make.
pub struct Family {
    /// What people call it.
    pub name: &'static str,
    /// The robot as [`emulate`](crate::emulate) knows it.
    pub robot: &'static str,
    /// How its base's node brakes it, m/s² and rad/s².
    pub brakes: (f64, f64),
    /// How it stops when somebody tells it to stand at once.
    pub wheels: (f64, f64),
    /// It finds its way by touching things, so that it counts for nothing that it does.
    pub touches: bool,
    /// What befalls it.
    pub blows: &'static [Axe],
    /// Its part of the mission's configuration, with `PORT` for the port.
    robot_text: &'static str,
}

impl Family {
    /// The configuration of a mission with this run, and its robot at this port, for no longer than so many seconds.
    pub fn mission(&self, run: &str, port: &str, longest: &str) -> String {
        let robot = self.robot_text.replace("PORT", port);
        format!(
            "[mission]\nclock = \"wall\"\nduration = {longest}\nrun = \"{run}\"\n\n[[robot]]\nhardware = \"elsewhere\"\n{robot}"
        )
    }
}

/// A Pioneer's own watchdog, s.
const WATCHDOG: f64 = 2.0;
/// What stands in for it on the line to a Create, s: the minder's patience with a silent client.
const MINDER: f64 = 0.25;
/// If the minder itself dies, the line breaks, and is opened again after half a second; whoever is greeted then stands. One that is held
/// up is found out sooner.
const GREETED: f64 = 1.0;

const fn axe(words: &'static str, victim: Victim, within: f64) -> Axe {
    Axe { words, victim, within }
}

/// A Pioneer, which stops by itself when nothing it understands comes over its wire.
pub static PIONEER: Family = Family {
    name: "Pioneer",
    robot: "p3dx",
    brakes: (0.3, 1.745),
    wheels: (0.3, 1.745),
    touches: false,
    blows: &[
        axe("mission, kill -9", Victim::Mission(Signal::KILL), WATCHDOG),
        axe("mission, held up", Victim::Mission(Signal::STOP), WATCHDOG),
        axe("mission, ends", Victim::Mission(Signal::TERM), WATCHDOG),
        axe("hardware, kill -9", Victim::Hardware(Signal::KILL), WATCHDOG),
        axe("hardware, held up", Victim::Hardware(Signal::STOP), WATCHDOG),
        axe("hardware, ends", Victim::Hardware(Signal::TERM), WATCHDOG),
        axe("wire, silence", Victim::Wire(Wire::Silent), WATCHDOG),
        axe("wire, garbage", Victim::Wire(Wire::Garbage), WATCHDOG),
        axe("wire, half packets", Victim::Wire(Wire::Half), WATCHDOG),
        axe("robot, switched off", Victim::Wire(Wire::Off), WATCHDOG),
    ],
    robot_text: r#"name = "pioneer"
base = { driver = "arcos", port = "PORT" }
sonar = { driver = "arcos" }

[robot.agent.where-am-i]

[robot.agent.avoidance]

[robot.agent.corridor-follower]
cruise_speed = 0.3

[robot.agent.patrol]
least_width = 1.4
"#,
};

/// A Create, which has no watchdog. Nothing on this side of a wire that is cut can stop it, so its wire is left alone.
pub static CREATE: Family = Family {
    name: "Create",
    robot: "create2",
    brakes: (0.5, 4.0),
    wheels: (2.5, 21.0),
    touches: true,
    blows: &[
        axe("mission, kill -9", Victim::Mission(Signal::KILL), MINDER),
        axe("mission, held up", Victim::Mission(Signal::STOP), MINDER),
        axe("mission, ends", Victim::Mission(Signal::TERM), MINDER),
        axe("hardware, kill -9", Victim::Hardware(Signal::KILL), MINDER),
        axe("hardware, held up", Victim::Hardware(Signal::STOP), MINDER),
        axe("hardware, ends", Victim::Hardware(Signal::TERM), MINDER),
        axe("minder, kill -9", Victim::Minder(Signal::KILL), GREETED),
        axe("minder, held up", Victim::Minder(Signal::STOP), GREETED),
        axe("hardware and minder, end", Victim::Both(Signal::TERM), MINDER),
    ],
    robot_text: r#"name = "create"
base = { driver = "create", port = "PORT", protection = { sonar_required = false } }

[robot.agent.where-am-i]

[robot.agent.wander]
"#,
};
