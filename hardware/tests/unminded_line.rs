//! A program that wants a line minded and does not begin as it should. Such as this test, which starts itself as a minder.
#![allow(clippy::unwrap_used)]

use std::{
    thread,
    time::{Duration, Instant},
};

use orienteer_hardware::line::{Line, Minding};
use orienteer_runtime::time::Time;

#[test]
fn a_program_that_does_not_mind_lines_is_told_how_to() {
    let minding = Minding { stop: vec![0], silence: Duration::from_millis(250) };
    let (mut line, began) = (Line::new("tcp://127.0.0.1:9".parse().unwrap(), 0).minded(minding), Instant::now());
    while line.trouble().contains("being opened") {
        line.receive(Time::START + began.elapsed(), &mut Vec::new());
        assert!(began.elapsed() < Duration::from_secs(60), "{}", line.trouble());
        thread::sleep(Duration::from_millis(5));
    }
    // In the one that it starts, which does the same, minding is refused.
    assert!(line.trouble().contains("mind_if_asked") || line.trouble().contains("was started to mind"), "{}", line.trouble());
}
