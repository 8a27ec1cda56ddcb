//! Encodes what one robot's topics carry.

use std::any::{Any, TypeId};

use foxglove::messages::{FrameTransform, Grid, LaserScan, Log, PointCloud, PoseInFrame, log::Level};

use super::{
    Entries, GridImage,
    grid::GridView,
    payload::{ChannelType, Form, form, foxglove_channel},
    views::{self, PoseView, ScanView, TransformView},
};
use crate::{
    geometry::Pose,
    robot_model::Ring,
    time::Time,
    topics::{Payload, PoseEstimate, SonarScan, Truth},
};

/// The encoder of one robot's messages. It lives beside the robot's actors; its [`Entries`] go to the recorder once a step.
///
/// Nothing is allocated once every topic has been seen and the buffers have grown to a step's size. A muted track encodes
/// nothing and holds no buffers.
#[derive(Debug)]
pub struct Track {
    name: String,
    now: Time,
    entries: Entries,
    channels: Vec<Channel>,
    scan: Option<ScanView>,
    pose: PoseView,
    transform: TransformView,
    grid: GridView,
    log: Log,
    unrecorded: u64,
    muted: bool,
}

#[derive(Debug)]
struct Channel {
    key: Key,
    form: Form,
    sequence: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Key {
    Payload(TypeId),
    /// One of Foxglove's messages, on this topic below the robot's.
    View(&'static str),
}

impl Track {
    /// The track of robot `number` (its place in [`Mission::robots`](super::Mission::robots)), named `name`, whose scans are
    /// drawn as those of `ring`, or not at all. There must be one track for each number.
    #[must_use]
    pub fn new(number: usize, name: &str, ring: Option<&Ring>) -> Self {
        Self {
            name: name.to_owned(),
            now: Time::START,
            entries: Entries::of(number),
            channels: Vec::with_capacity(32),
            scan: ring.map(|ring| ScanView::new(name, ring)),
            pose: PoseView::new(),
            transform: TransformView::new(name),
            grid: GridView::new(),
            log: Log::default(),
            unrecorded: 0,
            muted: false,
        }
    }

    /// Encodes nothing from here on, and gives its buffers back: nobody wants a recording.
    pub fn mute(&mut self) {
        self.muted = true;
        self.channels = Vec::new();
        self.entries = Entries::default();
        self.scan = None;
    }

    /// True if nothing is encoded.
    #[must_use]
    pub fn is_muted(&self) -> bool {
        self.muted
    }

    /// Begins a step: what is recorded from here on bears this time.
    pub fn begin(&mut self, now: Time) {
        self.now = now;
        self.entries.time = now;
    }

    /// Records a sample under its payload's topic, and what viewers can draw of it.
    pub fn record<P: Payload>(&mut self, sample: &P) {
        if self.muted {
            return;
        }
        let channel = self.channel(Key::Payload(TypeId::of::<P>()), P::TOPIC, || form(sample));
        let form = self.channels[channel].form;
        let done = self.write(channel, |bytes| form.encode(sample, bytes));
        self.unrecorded += u64::from(done.is_err());

        let any: &dyn Any = sample;
        if let Some(scan) = any.downcast_ref::<SonarScan>() {
            self.draw_scan(scan);
        } else if let Some(estimate) = any.downcast_ref::<PoseEstimate>() {
            self.draw_pose("pose/view", estimate.stamp, estimate.pose);
            self.draw_transform(estimate.stamp, estimate.pose);
        } else if let Some(truth) = any.downcast_ref::<Truth>() {
            self.draw_pose("truth/view", truth.stamp, truth.pose);
        }
    }

    /// Records a map of the robot's under the topic `/<robot>/<name>`. A grid that is not sound is not recorded.
    pub fn record_grid(&mut self, name: &'static str, image: &GridImage) {
        if self.muted {
            return;
        }
        if !image.is_sound() {
            self.unrecorded += 1;
            return;
        }
        let channel = self.view::<Grid>(name);
        let (now, Self { grid, entries, channels, .. }) = (self.now, self);
        write(entries, &mut channels[channel], channel, now, |bytes| grid.encode(now, image, bytes));
    }

    /// Records a line of a node's log.
    pub fn log(&mut self, level: tracing::Level, node: &str, text: &str) {
        if self.muted {
            return;
        }
        let channel = self.view::<Log>("log");
        let level = match level {
            tracing::Level::ERROR => Level::Error,
            tracing::Level::WARN => Level::Warning,
            tracing::Level::INFO => Level::Info,
            _ => Level::Debug,
        };
        let (now, Self { log, entries, channels, .. }) = (self.now, self);
        log.timestamp = Some(views::timestamp(now));
        log.level = level as i32;
        log.name.clear();
        log.name.push_str(node);
        log.message.clear();
        log.message.push_str(text);
        write(entries, &mut channels[channel], channel, now, |bytes| views::encode(log, bytes));
    }

    /// What has been recorded since the entries were last taken: give it to [`Recorder::append`](super::Recorder::append),
    /// which empties it.
    pub fn entries(&mut self) -> &mut Entries {
        &mut self.entries
    }

    /// Exchanges the entries for an empty buffer, so that they can be sent to whoever holds the recorder. What `empty` holds
    /// is lost; give back what came from here.
    pub fn swap_entries(&mut self, empty: &mut Entries) {
        let number = self.entries.robot();
        std::mem::swap(&mut self.entries, empty);
        self.entries.reset(number, self.now);
    }

    /// How many samples could not be recorded, because they had no encoded form.
    #[must_use]
    pub fn unrecorded(&self) -> u64 {
        self.unrecorded
    }

    fn draw_scan(&mut self, scan: &SonarScan) {
        let channel = match &self.scan {
            Some(ScanView::Laser(_)) => self.view::<LaserScan>("sonar/laser"),
            Some(ScanView::Points(_)) => self.view::<PointCloud>("sonar/points"),
            None => return,
        };
        let (now, Self { scan: Some(view), entries, channels, .. }) = (self.now, self) else { return };
        write(entries, &mut channels[channel], channel, now, |bytes| view.encode(scan, bytes));
    }

    fn draw_pose(&mut self, topic: &'static str, stamp: Time, pose: Pose) {
        let channel = self.view::<PoseInFrame>(topic);
        let (now, Self { pose: view, entries, channels, .. }) = (self.now, self);
        write(entries, &mut channels[channel], channel, now, |bytes| view.encode(stamp, pose, bytes));
    }

    fn draw_transform(&mut self, stamp: Time, pose: Pose) {
        let channel = self.view::<FrameTransform>("pose/transform");
        let (now, Self { transform: view, entries, channels, .. }) = (self.now, self);
        write(entries, &mut channels[channel], channel, now, |bytes| view.encode(stamp, pose, bytes));
    }

    fn view<M: foxglove::Encode>(&mut self, topic: &'static str) -> usize {
        self.channel(Key::View(topic), topic, || (Form::Packed, foxglove_channel::<M>()))
    }

    /// The channel with this key; the first time it is declared.
    fn channel(&mut self, key: Key, topic: &str, kind: impl FnOnce() -> (Form, ChannelType)) -> usize {
        if let Some(known) = self.channels.iter().position(|channel| channel.key == key) {
            return known;
        }
        let (form, kind) = kind();
        let channel = self.channels.len();
        self.entries.declare(channel as u16, &format!("/{}/{topic}", self.name), &kind);
        self.channels.push(Channel { key, form, sequence: 0 });
        channel
    }

    fn write<E>(&mut self, channel: usize, encode: impl FnOnce(&mut Vec<u8>) -> Result<(), E>) -> Result<(), E> {
        try_write(&mut self.entries, &mut self.channels[channel], channel, self.now, encode)
    }
}

fn try_write<E>(
    entries: &mut Entries,
    channel: &mut Channel,
    number: usize,
    now: Time,
    encode: impl FnOnce(&mut Vec<u8>) -> Result<(), E>,
) -> Result<(), E> {
    entries.message(number as u16, channel.sequence + 1, now.as_nanos(), encode)?;
    channel.sequence += 1;
    Ok(())
}

fn write(entries: &mut Entries, channel: &mut Channel, number: usize, now: Time, encode: impl FnOnce(&mut Vec<u8>)) {
    let encode = |bytes: &mut Vec<u8>| {
        encode(bytes);
        Ok::<_, std::convert::Infallible>(())
    };
    let Ok(()) = try_write(entries, channel, number, now, encode);
}
