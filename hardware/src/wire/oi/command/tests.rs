use proptest::{collection::vec, prelude::*};

use super::*;
use crate::wire::oi::{STOP, STOP_ANYHOW};

/// The commands in some bytes, as text.
fn heard(listener: &mut Listener, bytes: &[u8]) -> Vec<String> {
    let mut commands = Vec::new();
    listener.push(bytes, |command| commands.push(format!("{command:?}")));
    commands
}

fn emitted(command: Command<'_>) -> Vec<u8> {
    let mut bytes = Vec::new();
    command.emit(&mut bytes);
    bytes
}

/// From the examples of both specifications.
#[test]
fn commands_are_those_of_the_specifications() {
    for (command, bytes) in [
        (Command::Drive { velocity: -200, radius: 500 }, &[137, 255, 56, 1, 244][..]),
        (Command::Stream(&[29, 13]), &[148, 2, 29, 13]),
        (Command::QueryList(&[9, 13]), &[149, 2, 9, 13]),
        (Command::Leds { lights: 4, colour: 0, intensity: 128 }, &[139, 4, 0, 128]),
        (Command::Song { number: 0, notes: &[[62, 12], [66, 12]] }, &[140, 0, 2, 62, 12, 66, 12]),
        (Command::DriveDirect { right: 0, left: 0 }, &STOP),
    ] {
        assert_eq!(emitted(command), bytes);
    }
}

#[test]
fn the_older_name_of_safe_is_understood() {
    assert_eq!(Command::parse(&[130]), Ok(Command::Safe));
}

#[test]
fn songs_that_cannot_be_swallow_nothing() {
    let mut listener = Listener::default();
    assert_eq!(heard(&mut listener, &[140, 1, 17, 131]), ["Safe"]);
    assert_eq!(listener.counts(), Counts { frames: 1, broken: 0, noise: 3, unknown: 0 });
    assert_eq!(heard(&mut listener, &[150, 9, 132]), ["Full"]);
    assert_eq!(listener.counts(), Counts { frames: 2, broken: 1, noise: 3, unknown: 0 });
}

/// A command and the memory that it borrows.
fn command() -> impl Strategy<Value = (u8, [i16; 2], [u8; 3], Vec<u8>)> {
    (0u8..23, any::<[i16; 2]>(), any::<[u8; 3]>(), vec(any::<u8>(), 0..=255))
}

fn build<'a>((which, [a, b], [x, y, z], list): &'a (u8, [i16; 2], [u8; 3], Vec<u8>)) -> Command<'a> {
    let (a, b, x, y, z) = (*a, *b, *x, *y, *z);
    let notes = list.as_chunks::<2>().0;
    match which {
        0 => Command::Reset,
        1 => Command::Start,
        2 => Command::Baud(x),
        3 => Command::Safe,
        4 => Command::Full,
        5 => Command::Power,
        6 => Command::Spot,
        7 => Command::Clean,
        8 => Command::Max,
        9 => Command::Drive { velocity: a, radius: b },
        10 => Command::Leds { lights: x, colour: y, intensity: z },
        11 => Command::Song { number: x, notes: &notes[..notes.len().min(LONGEST_SONG)] },
        12 => Command::Play(x),
        13 => Command::Sensors(x),
        14 => Command::SeekDock,
        15 => Command::DriveDirect { right: a, left: b },
        16 => Command::DrivePwm { right: a, left: b },
        17 => Command::Stream(list),
        18 => Command::QueryList(list),
        19 => Command::StreamRuns(x % 2 == 1),
        20 => Command::Stop,
        21 => Command::Other { opcode: 164, arguments: list.get(..4).unwrap_or(&[32; 4]) },
        _ => Command::Other { opcode: 167, arguments: list.get(..15).unwrap_or(&[7; 15]) },
    }
}

proptest! {
    #[test]
    fn commands_come_back_in_whatever_pieces(made in vec(command(), 1..6), piece in 1usize..300) {
        let commands: Vec<_> = made.iter().map(build).collect();
        let stream: Vec<u8> = commands.iter().flat_map(|command| emitted(*command)).collect();
        let mut listener = Listener::default();
        let back: Vec<String> = stream.chunks(piece).flat_map(|bytes| heard(&mut listener, bytes)).collect();
        prop_assert_eq!(back, commands.iter().map(|command| format!("{command:?}")).collect::<Vec<_>>());
        prop_assert_eq!(listener.counts(), Counts { frames: commands.len() as u64, broken: 0, noise: 0, unknown: 0 });
    }

    #[test]
    fn nonsense_is_refused_and_not_feared(bytes in vec(any::<u8>(), 0..600)) {
        let _ = Command::parse(&bytes);
        let mut listener = Listener::default();
        let commands = heard(&mut listener, &bytes).len() as u64;
        let counts = listener.counts();
        prop_assert_eq!(counts.frames, commands);
        prop_assert!(counts.frames + counts.broken + counts.noise + listener.len as u64 <= bytes.len() as u64);
    }

    /// Of all that a driver here sends: whatever was cut off, wherever.
    #[test]
    fn the_stop_that_suits_everything_stops(made in command(), cut: prop::sample::Index) {
        let bytes = emitted(build(&made));
        let longest = STOP_ANYHOW.len() - STOP.len();
        let missing = 1 + cut.index(bytes.len().min(longest));
        let cut = &bytes[..bytes.len() - missing];
        let mut listener = Listener::default();
        heard(&mut listener, cut);
        let last = heard(&mut listener, &STOP_ANYHOW).pop();
        prop_assert_eq!(last.as_deref(), Some("DriveDirect { right: 0, left: 0 }"));
    }
}
