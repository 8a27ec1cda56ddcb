//! Whatever is done to a robot's ports, the three back ends answer alike.
#![allow(clippy::unwrap_used, missing_docs)]

mod link_support;

use link_support::{BACKENDS, Claim, Reading, Root, drained};
use orienteer_runtime::{
    link::{Backend, LinkError, Publisher, RobotBus, Subscriber},
    topics::Payload,
};
use proptest::prelude::*;

/// Something done to the ports of one topic. Places are taken modulo the number of ports there are.
#[derive(Debug, Clone, Copy)]
enum Deed {
    MakeWriter,
    MakeReader,
    DropWriter(usize),
    DropReader(usize),
    Publish(usize),
    Drain(usize),
    Take(usize),
    DropBus,
}

fn deed() -> impl Strategy<Value = (bool, Deed)> {
    let deed = prop_oneof![
        4 => Just(Deed::MakeWriter),
        3 => Just(Deed::MakeReader),
        2 => (0usize..8).prop_map(Deed::DropWriter),
        1 => (0usize..8).prop_map(Deed::DropReader),
        16 => (0usize..8).prop_map(Deed::Publish),
        5 => (0usize..8).prop_map(Deed::Drain),
        4 => (0usize..8).prop_map(Deed::Take),
        1 => Just(Deed::DropBus),
    ];
    (any::<bool>(), deed)
}

/// What came of it, as text to compare.
type Story = Vec<String>;

/// The ports of one topic.
struct Stage<P: Payload> {
    writers: Vec<(u32, Publisher<P>)>,
    readers: Vec<Subscriber<P>>,
    made: u32,
    published: u32,
    make: fn(u32, u32) -> P,
}

impl<P: Payload> Stage<P> {
    fn new(make: fn(u32, u32) -> P) -> Self {
        Self { writers: Vec::new(), readers: Vec::new(), made: 0, published: 0, make }
    }

    fn play(&mut self, robot: &RobotBus, deed: Deed, story: &mut Story) {
        let of = |place: usize, length: usize| (length > 0).then(|| place % length);
        let (writers, readers) = (self.writers.len(), self.readers.len());
        story.push(match deed {
            Deed::MakeWriter => match robot.publisher::<P>() {
                Ok(publisher) => {
                    self.writers.push((self.made, publisher));
                    self.made += 1;
                    "made".into()
                }
                Err(LinkError::TooManyWriters { limit, .. }) => format!("more than {limit}"),
                Err(other) => panic!("{other}"),
            },
            Deed::MakeReader => {
                self.readers.push(robot.subscriber::<P>().unwrap());
                "made".into()
            }
            Deed::DropWriter(place) => {
                of(place, writers).map_or("none".into(), |place| format!("dropped {}", self.writers.remove(place).0))
            }
            Deed::DropReader(place) => of(place, readers).map_or("none".into(), |place| {
                self.readers.remove(place);
                format!("dropped {place}")
            }),
            Deed::Publish(place) => of(place, writers).map_or("none".into(), |place| {
                let (writer, publisher) = &mut self.writers[place];
                self.published += 1;
                let heard = publisher.publish((self.make)(*writer, self.published)).unwrap();
                format!("{writer} published {} to {heard}", self.published)
            }),
            Deed::Drain(place) => {
                of(place, readers).map_or("none".into(), |place| format!("{:?}", drained(&mut self.readers[place])))
            }
            Deed::Take(place) => of(place, readers).map_or("none".into(), |place| format!("{:?}", self.readers[place].take())),
            Deed::DropBus => "not here".into(),
        });
    }

    fn finish(&mut self, story: &mut Story) {
        for reader in &mut self.readers {
            story.push(format!("{:?}", drained(reader)));
        }
    }
}

fn play(backend: Backend, deeds: &[(bool, Deed)]) -> Story {
    let root = Root::new();
    let bus = root.open(backend);
    let mut robot = bus.robot("huey").unwrap().open();
    let mut readings = Stage::new(|writer, value| Reading { writer, value });
    let mut claims = Stage::new(|writer, value| Claim { writer, value });
    let mut story = Story::new();
    for &(many, deed) in deeds {
        if let Deed::DropBus = deed {
            // Everything of the robot goes, and it starts again on the same bus.
            readings = Stage::new(readings.make);
            claims = Stage::new(claims.make);
            drop(robot);
            robot = bus.robot("huey").unwrap().open();
        } else if many {
            claims.play(&robot, deed, &mut story);
        } else {
            readings.play(&robot, deed, &mut story);
        }
    }
    readings.finish(&mut story);
    claims.finish(&mut story);
    story
}

proptest! {
    #[test]
    fn the_back_ends_agree(deeds in prop::collection::vec(deed(), 1..120)) {
        let [shared, local, direct] = BACKENDS.map(|backend| play(backend, &deeds));
        prop_assert_eq!(&shared, &direct, "shared and direct");
        prop_assert_eq!(&local, &direct, "local and direct");
    }
}
