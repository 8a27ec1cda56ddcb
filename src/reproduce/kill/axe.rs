//! The blows that fall.

use std::{fs, process::Child};

use rustix::process::{Pid, kill_process};

use super::{Crew, robot::Watched};

pub use super::robot::Wire;
pub use rustix::process::Signal;

/// A blow, and how it heals.
pub struct Axe {
    /// What happens, for people.
    pub words: &'static str,
    /// Whom it befalls.
    pub victim: Victim,
    /// The base must have been told to stand within this, s, beside a control period.
    pub within: f64,
}

/// Whom a blow befalls, and how.
pub enum Victim {
    /// The mission's process gets a signal.
    Mission(Signal),
    /// The hardware's process gets one.
    Hardware(Signal),
    /// The process that minds the hardware's line gets one.
    Minder(Signal),
    /// Both get one, as when a service is stopped.
    Both(Signal),
    /// The wire between hardware and robot is spoiled.
    Wire(Wire),
}

impl Axe {
    /// True if the base's hardware lives and is heard: it must not run into anything, then.
    pub fn base_still_sees(&self) -> bool {
        matches!(self.victim, Victim::Mission(_))
    }

    /// True if nobody has to give back what it takes: the base stands for a moment, and then goes on by itself.
    pub fn heals_itself(&self) -> bool {
        matches!(self.victim, Victim::Minder(_))
    }

    /// True if it is not the base's own node that stops the base, gently, but whoever speaks to it in its stead.
    pub fn stops_abruptly(&self) -> bool {
        !matches!(self.victim, Victim::Mission(_))
    }

    /// Takes something away.
    pub fn strike(&self, crew: &mut Crew<'_>, robot: &Watched) {
        match self.victim {
            Victim::Mission(with) => hit(&mut crew.mission, with),
            Victim::Hardware(with) => hit(&mut crew.hardware, with),
            Victim::Minder(with) => crew.hardware.iter().flat_map(children).for_each(|child| _ = kill_process(child, with)),
            Victim::Both(with) => {
                crew.hardware.iter().flat_map(children).for_each(|child| _ = kill_process(child, with));
                hit(&mut crew.hardware, with);
            }
            Victim::Wire(wire) => robot.wire(wire),
        }
    }

    /// Gives it back, if it was not a process that has ended.
    pub fn heal(&self, crew: &mut Crew<'_>, robot: &Watched) {
        match self.victim {
            Victim::Mission(Signal::STOP) => crew.mission.iter().for_each(|child| signal(child, Signal::CONT)),
            Victim::Hardware(Signal::STOP) => crew.hardware.iter().for_each(|child| signal(child, Signal::CONT)),
            Victim::Mission(_) | Victim::Hardware(_) | Victim::Minder(_) | Victim::Both(_) => {}
            Victim::Wire(_) => robot.wire(Wire::Whole),
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

/// The processes that a process has started.
fn children(parent: &Child) -> Vec<Pid> {
    let started_by = |pid: &str| -> Option<u32> {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        // The name, in parentheses, may hold anything.
        stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()
    };
    let names = fs::read_dir("/proc").into_iter().flatten().flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let ours = names.filter(|name| started_by(name) == Some(parent.id()));
    ours.filter_map(|name| Pid::from_raw(name.parse().ok()?)).collect()
}
