//! The blows that fall.

use std::process::Child;

use rustix::process::{Pid, Signal, kill_process};

use super::{
    Crew,
    robot::{Watched, Wire},
};

/// A blow, and how it heals.
pub struct Axe {
    /// What happens, for people.
    pub words: &'static str,
    what: What,
}

enum What {
    Mission(Signal),
    Hardware(Signal),
    Wire(Wire),
}

/// All blows.
pub const BLOWS: [Axe; 10] = [
    Axe { words: "mission, kill -9", what: What::Mission(Signal::KILL) },
    Axe { words: "mission, held up", what: What::Mission(Signal::STOP) },
    Axe { words: "mission, ends", what: What::Mission(Signal::TERM) },
    Axe { words: "hardware, kill -9", what: What::Hardware(Signal::KILL) },
    Axe { words: "hardware, held up", what: What::Hardware(Signal::STOP) },
    Axe { words: "hardware, ends", what: What::Hardware(Signal::TERM) },
    Axe { words: "wire, silence", what: What::Wire(Wire::Silent) },
    Axe { words: "wire, garbage", what: What::Wire(Wire::Garbage) },
    Axe { words: "wire, half packets", what: What::Wire(Wire::Half) },
    Axe { words: "robot, switched off", what: What::Wire(Wire::Off) },
];

impl Axe {
    /// True if the base's hardware lives and is heard: it must not run into anything, then.
    pub fn base_still_sees(&self) -> bool {
        matches!(self.what, What::Mission(_))
    }

    /// Takes something away.
    pub fn strike(&self, crew: &mut Crew<'_>, robot: &Watched) {
        match self.what {
            What::Mission(with) => hit(&mut crew.mission, with),
            What::Hardware(with) => hit(&mut crew.hardware, with),
            What::Wire(wire) => robot.wire(wire),
        }
    }

    /// Gives it back, if it was not a process that has ended.
    pub fn heal(&self, crew: &mut Crew<'_>, robot: &Watched) {
        match self.what {
            What::Mission(Signal::STOP) => crew.mission.iter().for_each(|child| signal(child, Signal::CONT)),
            What::Hardware(Signal::STOP) => crew.hardware.iter().for_each(|child| signal(child, Signal::CONT)),
            What::Mission(_) | What::Hardware(_) => {}
            What::Wire(_) => robot.wire(Wire::Whole),
        }
    }
}

/// Sends a signal; whoever ends of it is gone from the crew.
fn hit(child: &mut Option<Child>, with: Signal) {
    let Some(mut victim) = child.take() else { return };
    signal(&victim, with);
    if with == Signal::STOP {
        *child = Some(victim);
    } else {
        let _ = victim.wait();
    }
}

/// Sends a signal.
pub fn signal(child: &Child, with: Signal) {
    // One that is gone already needs none.
    let _ = kill_process(Pid::from_child(child), with);
}
