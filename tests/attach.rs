//! A mission with a name for it can be listened to from outside; one without can't.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{cell::Cell, ops::ControlFlow, rc::Rc};

use orienteer::{
    Registry,
    hardware::sim::Arena,
    mission::{self, RunOptions},
    runtime::{
        link::{Bus, BusOptions, LinkError},
        time::Time,
        topics::Odometry,
    },
};

const HALL: &str = "[[room]]\ncorners = [[0, 0], [8, 6]]\n";

fn loaded(run: &str, registry: &Registry) -> mission::Loaded {
    let mission = format!(
        "[mission]\nduration = 1\nrun = \"{run}\"\n\n[world]\nfile = \"hall.toml\"\n\n[[robot]]\nname = \"huey\"\n\
         start = {{ x = 2, y = 2 }}\nbase = {{ driver = \"sim\" }}\n"
    );
    let files = [("mission.toml", mission.as_str()), ("hall.toml", HALL)];
    let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    mission::load_files(files, "mission.toml", registry).unwrap()
}

#[test]
fn others_may_attach_to_a_mission_by_its_name() {
    let registry = Registry::standard();
    let run = format!("attach-{}", std::process::id());
    let heard = Rc::new(Cell::new(0));
    let (name, count) = (run.clone(), heard.clone());
    let mut listener = None;
    let watch = move |_: Time, _: Option<&Arena>| {
        let (_, odometry) = listener.get_or_insert_with(|| {
            let robot = Bus::attach(&name, &BusOptions::default()).unwrap().robot("huey").unwrap().open();
            let odometry = robot.subscriber::<Odometry>().unwrap();
            (robot, odometry)
        });
        odometry.drain(|_| count.set(count.get() + 1));
        ControlFlow::Continue(())
    };
    let options = RunOptions { observer: Some(Box::new(watch)), ..RunOptions::default() };
    let outcome = mission::run(loaded(&run, &registry), &registry, options).unwrap();
    // All but the first step, which came before it attached.
    assert_eq!(heard.get(), outcome.steps - 1);
    assert!(matches!(Bus::attach(&run, &BusOptions::default()), Err(LinkError::NoSuchRun { .. })), "it is over");
}
