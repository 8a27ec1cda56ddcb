//! Foxglove's own messages, made from payloads so that viewers can draw them.
//!
//! Each view keeps one message and writes it again and again, so that nothing is allocated once it is warm.

use std::f64::consts::TAU;

use foxglove::{
    Encode,
    messages::{
        self, FrameTransform, LaserScan, PackedElementField, PointCloud, PoseInFrame, Quaternion, Timestamp, Vector3,
        packed_element_field::NumericType,
    },
};
use nalgebra::Point2;

use crate::{
    geometry::{Pose, angle},
    robot_model::Ring,
    time::Time,
    topics::{Echo, SonarScan},
};

/// Name of the map frame, in which all robots are drawn.
pub(super) const MAP: &str = "map";
/// How far transducers may stand off an even circle, rad and m, for the ring to count as even.
const EVEN: f64 = 1e-6;

/// A time as Foxglove has it; seconds beyond 32 bits stay at the largest.
pub(super) fn timestamp(time: Time) -> Timestamp {
    const SECOND: u64 = 1_000_000_000;
    match u32::try_from(time.as_nanos() / SECOND) {
        Ok(seconds) => Timestamp::new(seconds, (time.as_nanos() % SECOND) as u32),
        Err(_) => Timestamp::MAX,
    }
}

fn rotation(heading: f64) -> Quaternion {
    let (sin, cos) = (0.5 * heading).sin_cos();
    Quaternion { x: 0.0, y: 0.0, z: sin, w: cos }
}

fn position(pose: Pose) -> Vector3 {
    Vector3 { x: pose.x, y: pose.y, z: 0.0 }
}

/// A pose in the plane as Foxglove has it.
pub(super) fn from_pose(pose: Pose) -> messages::Pose {
    messages::Pose { position: Some(position(pose)), orientation: Some(rotation(pose.heading)) }
}

/// A pose of Foxglove's, if it lies in the plane.
pub(super) fn to_pose(pose: &messages::Pose) -> Option<Pose> {
    let (at, q) = (pose.position?, pose.orientation?);
    let pose = Pose::new(at.x, at.y, 2.0 * q.z.atan2(q.w));
    (q.x == 0.0 && q.y == 0.0 && pose.is_sound()).then_some(pose)
}

/// Appends a message. Room in a vector never runs out, so encoding cannot fail.
pub(super) fn encode<M: Encode>(message: &M, bytes: &mut Vec<u8>) {
    let _ = message.encode(bytes);
}

/// Appends a field of bytes to a protobuf message, whose fields may come in any order. The messages' own type would have to
/// take the bytes over, one allocation each time.
pub(super) fn append_bytes_field(number: u8, data: &[u8], bytes: &mut Vec<u8>) {
    bytes.push(number << 3 | 2);
    let mut length = data.len();
    while length >= 0x80 {
        bytes.push(length as u8 | 0x80);
        length >>= 7;
    }
    bytes.push(length as u8);
    bytes.extend_from_slice(data);
}

/// Poses in the map.
#[derive(Debug)]
pub(super) struct PoseView(PoseInFrame);

impl PoseView {
    pub(super) fn new() -> Self {
        Self(PoseInFrame { frame_id: MAP.into(), ..PoseInFrame::default() })
    }

    pub(super) fn encode(&mut self, stamp: Time, pose: Pose, bytes: &mut Vec<u8>) {
        self.0.timestamp = Some(timestamp(stamp));
        self.0.pose = Some(from_pose(pose));
        encode(&self.0, bytes);
    }
}

/// Where the robot's frame is in the map.
#[derive(Debug)]
pub(super) struct TransformView(FrameTransform);

impl TransformView {
    pub(super) fn new(robot: &str) -> Self {
        let (parent_frame_id, child_frame_id) = (MAP.into(), base_frame(robot));
        Self(FrameTransform { parent_frame_id, child_frame_id, ..FrameTransform::default() })
    }

    pub(super) fn encode(&mut self, stamp: Time, pose: Pose, bytes: &mut Vec<u8>) {
        self.0.timestamp = Some(timestamp(stamp));
        self.0.translation = Some(position(pose));
        self.0.rotation = Some(rotation(pose.heading));
        encode(&self.0, bytes);
    }
}

fn base_frame(robot: &str) -> String {
    format!("{robot}/base")
}

/// Scans, drawn about the robot. Only what was fired in a scan's own pass is drawn; older readings belong to where the robot
/// was then.
#[derive(Debug)]
pub(super) enum ScanView {
    /// Of an even ring: bearings follow from the order.
    Laser(LaserView),
    /// Of any ring: a point for each echo.
    Points(PointsView),
}

impl ScanView {
    /// The view that suits a ring.
    pub(super) fn new(robot: &str, ring: &Ring) -> Self {
        match LaserView::new(robot, ring) {
            Some(laser) => Self::Laser(laser),
            None => Self::Points(PointsView::new(robot, ring)),
        }
    }

    pub(super) fn encode(&mut self, scan: &SonarScan, bytes: &mut Vec<u8>) {
        match self {
            Self::Laser(view) => view.encode(scan, bytes),
            Self::Points(view) => view.encode(scan, bytes),
        }
    }
}

#[derive(Debug)]
pub(super) struct LaserView {
    message: LaserScan,
    /// From the robot's centre to the faces, m.
    radius: f64,
    min_range: f64,
}

impl LaserView {
    /// `None` if the ring is not an even circle of beams that point straight away from the robot's centre.
    fn new(robot: &str, ring: &Ring) -> Option<Self> {
        let mounts = || ring.transducers.iter().map(|transducer| transducer.mount);
        let (first, second, count) = (mounts().next()?, mounts().nth(1)?, ring.transducers.len() as f64);
        let step = (TAU / count).copysign(angle::turn(first.heading, second.heading));
        let radius = first.point().coords.norm();
        let even = mounts().enumerate().all(|(i, mount)| {
            let heading = first.heading + step * i as f64;
            let face = Point2::new(radius * mount.heading.cos(), radius * mount.heading.sin());
            angle::turn(heading, mount.heading).abs() < EVEN && (face - mount.point()).norm() < EVEN
        });
        let message = LaserScan {
            frame_id: base_frame(robot),
            pose: Some(from_pose(Pose::default())),
            start_angle: first.heading,
            end_angle: first.heading + step * (count - 1.0),
            ..LaserScan::default()
        };
        (even && count > 2.0).then_some(Self { message, radius, min_range: ring.min_range })
    }

    fn encode(&mut self, scan: &SonarScan, bytes: &mut Vec<u8>) {
        self.message.timestamp = Some(timestamp(scan.stamp));
        self.message.ranges.clear();
        let ranges = scan.echoes().enumerate().map(|(i, echo)| match echo {
            _ if !scan.is_fresh(i) => f64::NAN,
            Echo::Range(range) => self.radius + f64::from(range),
            Echo::TooNear => self.radius + self.min_range,
            Echo::Nothing => f64::INFINITY,
            Echo::NotFired => f64::NAN,
        });
        self.message.ranges.extend(ranges);
        encode(&self.message, bytes);
    }
}

#[derive(Debug)]
pub(super) struct PointsView {
    message: PointCloud,
    mounts: Vec<Pose>,
    min_range: f64,
    points: Vec<u8>,
}

impl PointsView {
    /// Field number of the data in `foxglove.PointCloud`.
    const DATA: u8 = 6;

    fn new(robot: &str, ring: &Ring) -> Self {
        let coordinate =
            |name: &str, offset| PackedElementField { name: name.into(), offset, r#type: NumericType::Float32 as i32 };
        let message = PointCloud {
            frame_id: base_frame(robot),
            pose: Some(from_pose(Pose::default())),
            point_stride: 8,
            fields: vec![coordinate("x", 0), coordinate("y", 4)],
            ..PointCloud::default()
        };
        let mounts = ring.transducers.iter().map(|transducer| transducer.mount).collect();
        Self { message, mounts, min_range: ring.min_range, points: Vec::new() }
    }

    fn encode(&mut self, scan: &SonarScan, bytes: &mut Vec<u8>) {
        self.message.timestamp = Some(timestamp(scan.stamp));
        self.points.clear();
        for (i, mount) in self.mounts.iter().enumerate().filter(|(i, _)| scan.is_fresh(*i)) {
            let range = match scan.echo(i) {
                Echo::Range(range) => f64::from(range),
                Echo::TooNear => self.min_range,
                Echo::Nothing | Echo::NotFired => continue,
            };
            let point = mount.transform(Point2::new(range, 0.0));
            self.points.extend_from_slice(&(point.x as f32).to_le_bytes());
            self.points.extend_from_slice(&(point.y as f32).to_le_bytes());
        }
        encode(&self.message, bytes);
        append_bytes_field(Self::DATA, &self.points, bytes);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use foxglove::Decode;

    use super::*;
    use crate::robot_model::Transducer;
    use crate::topics::FiringProgram;

    fn ring(headings_deg: &[f64], radius: f64) -> Ring {
        let mount = |deg: &f64| {
            let heading = deg.to_radians();
            Pose::new(radius * heading.cos(), radius * heading.sin(), heading)
        };
        Ring {
            name: "test".into(),
            transducers: headings_deg.iter().map(|deg| Transducer { mount: mount(deg), half_beam: 0.2 }).collect(),
            min_range: 0.1,
            max_range: 5.0,
            slot_time: 0.0,
            program: FiringProgram::default(),
        }
    }

    #[test]
    fn an_even_ring_becomes_a_laser_scan_about_the_centre() {
        for direction in [1.0, -1.0] {
            let headings: Vec<f64> = (0..16).map(|i| 11.25 + direction * 22.5 * f64::from(i)).collect();
            let mut view = ScanView::new("ann", &ring(&headings, 0.25));
            let mut echoes = vec![Echo::Range(1.5); 16];
            (echoes[1], echoes[2]) = (Echo::Nothing, Echo::TooNear);
            let mut scan = SonarScan::from_echoes(Time::from_nanos(2_000_000_001), 1, &echoes);
            scan.fired &= !(1 << 15);
            let mut bytes = Vec::new();
            view.encode(&scan, &mut bytes);
            let laser = LaserScan::decode(&bytes[..]).unwrap();
            assert_eq!((laser.frame_id.as_str(), laser.timestamp), ("ann/base", Some(Timestamp::new(2, 1))));
            assert_eq!((laser.ranges[0], laser.ranges[1], laser.ranges[2]), (1.75, f64::INFINITY, 0.35));
            assert!(laser.ranges[15].is_nan() && laser.ranges.len() == 16);
            let step = (laser.end_angle - laser.start_angle) / 15.0;
            assert!((laser.start_angle - 11.25f64.to_radians()).abs() < 1e-12);
            assert!((step - direction * 22.5f64.to_radians()).abs() < 1e-12);
        }
    }

    #[test]
    fn an_uneven_ring_becomes_points() {
        let mut view = ScanView::new("ann", &ring(&[-90.0, -37.5, -7.5, 7.5, 37.5, 90.0], 0.2));
        let echoes = [Echo::Range(1.0), Echo::Nothing, Echo::NotFired, Echo::NotFired, Echo::TooNear, Echo::Range(2.0)];
        let mut bytes = Vec::new();
        view.encode(&SonarScan::from_echoes(Time::START, 1, &echoes), &mut bytes);
        let cloud = PointCloud::decode(&bytes[..]).unwrap();
        let numbers: Vec<f32> = cloud.data.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        let near = 37.5f32.to_radians();
        let expected = [0.0, -1.2, 0.3 * near.cos(), 0.3 * near.sin(), 0.0, 2.2];
        assert_eq!(numbers.len(), expected.len());
        assert!(numbers.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{numbers:?}");
        assert_eq!(cloud.point_stride, 8);
    }

    #[test]
    fn a_full_circle_that_points_askew_is_not_a_laser() {
        let mut askew = ring(&[0.0, 90.0, 180.0, 270.0], 0.2);
        askew.transducers[1].mount.x += 0.01;
        assert!(matches!(ScanView::new("ann", &askew), ScanView::Points(_)));
        assert!(matches!(ScanView::new("ann", &ring(&[], 0.2)), ScanView::Points(_)));
        assert!(matches!(ScanView::new("ann", &ring(&[0.0], 0.2)), ScanView::Points(_)));
    }

    #[test]
    fn poses_come_back() {
        for heading in [-3.0, -1.0, 0.0, 0.5, 3.1] {
            let pose = to_pose(&from_pose(Pose::new(1.0, -2.0, heading))).unwrap();
            assert!((pose.heading - heading).abs() < 1e-12 && (pose.x, pose.y) == (1.0, -2.0));
        }
        assert_eq!(timestamp(Time::FAR), Timestamp::MAX);
    }
}
