//! Crumbs: where a robot has been, and the shortest way back along it.
//!
//! Where a robot has been it can be again. Every tenth of a metre it drops a crumb; crumbs that are so near to each other that the robot's
//! body at the one nearly covers the way to the other are joined, so that a way back cuts the loops of the way that it came.

use std::{future::poll_fn, pin::pin, time::Duration};

use nalgebra::Point2;
use orienteer_runtime::{
    agent::{Aborted, Pilot},
    geometry::Pose,
    topics::PoseEstimate,
};
use petgraph::{
    algo::astar,
    graph::{NodeIndex, UnGraph},
};

/// From one crumb to the next, m.
const STEP: f64 = 0.10;
/// Crumbs so near to each other are joined, m.
const JOINED: f64 = 0.25;
/// A way may leave the crumbs by so much, m.
const SLACK: f64 = 0.04;
/// On a line is what is so near to it, m.
const ON_LINE: f64 = 0.15;

/// So often a robot tries to get back to where it came from.
const TRIES: u32 = 12;
/// What came between is given time to go on.
const GIVE_WAY: Duration = Duration::from_secs(4);

/// Where a robot has been.
///
/// ```
/// use nalgebra::Point2;
/// use orienteer_agents::crumbs::Crumbs;
/// use orienteer_runtime::geometry::Pose;
///
/// let mut crumbs = Crumbs::default();
/// for i in 0..=20 {
///     crumbs.drop(Pose::new(0.1 * f64::from(i), 0.0, 0.0));
/// }
/// let way = crumbs.way(Point2::new(2.0, 0.0), Point2::origin());
/// assert_eq!(way, [Point2::origin()]);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Crumbs {
    graph: UnGraph<Point2<f64>, f64>,
}

impl Crumbs {
    /// The robot is there.
    pub fn drop(&mut self, pose: Pose) {
        let at = pose.point();
        if self.graph.node_weights().any(|crumb| (crumb - at).norm() < STEP) {
            return;
        }
        let near: Vec<(NodeIndex, f64)> =
            self.graph.node_indices().map(|crumb| (crumb, (self.graph[crumb] - at).norm())).collect();
        // A robot that was carried, or lost track of itself for a while, came from the nearest.
        let nearest = near.iter().map(|(_, distance)| *distance).fold(f64::INFINITY, f64::min);
        let here = self.graph.add_node(at);
        for (crumb, distance) in near.into_iter().filter(|(_, distance)| *distance <= nearest.max(JOINED)) {
            self.graph.add_edge(here, crumb, distance);
        }
    }

    /// Waits for this, and drops a crumb wherever the robot is meanwhile: somebody may drive it elsewhere, and it will have to find back.
    pub async fn along<T>(&mut self, pilot: &Pilot, motion: impl Future<Output = T>) -> T {
        let mut motion = pin!(motion);
        poll_fn(|context| {
            if let Some(estimate) = pilot.latest::<PoseEstimate>() {
                self.drop(estimate.pose);
            }
            motion.as_mut().poll(context)
        })
        .await
    }

    /// The points to drive to, one after the other, to get from one place to another where the robot has been; the goal is the last one.
    #[must_use]
    pub fn way(&self, from: Point2<f64>, to: Point2<f64>) -> Vec<Point2<f64>> {
        let (Some(first), Some(last)) = (self.nearest(from), self.nearest(to)) else { return vec![to] };
        let distance = |crumb: NodeIndex| (self.graph[crumb] - self.graph[last]).norm();
        let found = astar(&self.graph, first, |crumb| crumb == last, |edge| *edge.weight(), distance);
        let mut points = vec![from];
        points.extend(found.map(|(_, crumbs)| crumbs).unwrap_or_default().into_iter().map(|crumb| self.graph[crumb]));
        points.push(to);
        straightened(&points)
    }

    /// Drives back to a pose (map frame) where the robot has been, at up to `speed` m/s and `rate` rad/s. Where somebody comes between it tries again.
    /// The base is released at the end.
    ///
    /// # Errors
    /// If it can't get there.
    pub async fn go_back(&mut self, pilot: &Pilot, to: Pose, speed: f64, rate: f64) -> Result<(), Aborted> {
        let mut ended = Ok(());
        for _ in 0..TRIES {
            ended = self.retrace(pilot, to, speed, rate).await;
            pilot.release();
            if ended.is_ok() {
                break;
            }
            self.along(pilot, pilot.sleep(GIVE_WAY)).await.ok();
        }
        ended
    }

    async fn retrace(&mut self, pilot: &Pilot, to: Pose, speed: f64, rate: f64) -> Result<(), Aborted> {
        let here = || pilot.latest::<PoseEstimate>().map(|estimate| estimate.pose).ok_or(Aborted::TimedOut);
        self.drop(here()?);
        for point in self.way(here()?.point(), to.point()) {
            self.along(pilot, pilot.go(point, speed, rate)).await?;
        }
        self.along(pilot, pilot.face(to.heading, rate)).await
    }

    /// Of the crumbs on the line through `line` along its heading, the one from which `goal` is nearest, with that heading; `line` itself if there
    /// is none nearer.
    #[must_use]
    pub fn nearest_on_line(&self, line: Pose, goal: Pose) -> Pose {
        let on_line = |crumb: Point2<f64>| line.between(Pose::new(crumb.x, crumb.y, 0.0)).y.abs() < ON_LINE;
        let distance = |at: Point2<f64>| (at - goal.point()).norm();
        match self.nearest_of(goal.point(), on_line) {
            Some(crumb) if distance(crumb) < distance(line.point()) => Pose::new(crumb.x, crumb.y, line.heading),
            _ => line,
        }
    }

    /// Of the crumbs that are wanted the one from which `goal` is nearest.
    #[must_use]
    pub fn nearest_of(&self, goal: Point2<f64>, wanted: impl Fn(Point2<f64>) -> bool) -> Option<Point2<f64>> {
        let distance = |at: &Point2<f64>| (at - goal).norm();
        let wanted = self.graph.node_weights().copied().filter(|crumb| wanted(*crumb));
        wanted.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn nearest(&self, to: Point2<f64>) -> Option<NodeIndex> {
        let distance = |crumb: &NodeIndex| (self.graph[*crumb] - to).norm();
        self.graph.node_indices().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

/// Leaves out points that lie on the straight way to a later one. The first point is where the robot is, and not kept.
fn straightened(points: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let mut way = Vec::new();
    let mut at = 0;
    while at + 1 < points.len() {
        let covers = |to: &usize| points[at + 1..*to].iter().all(|point| off(*point, points[at], points[*to]) < SLACK);
        let next = (at + 1..points.len()).rev().find(covers).unwrap_or(at + 1);
        way.push(points[next]);
        at = next;
    }
    way
}

/// How far a point is off the straight way from one point to another.
fn off(point: Point2<f64>, from: Point2<f64>, to: Point2<f64>) -> f64 {
    let (along, way) = (point - from, to - from);
    let share = if way.norm_squared() > 0.0 { (along.dot(&way) / way.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
    (along - way * share).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round three sides of a square with sides of 2 m.
    fn round_a_corner() -> Crumbs {
        let mut crumbs = Crumbs::default();
        let leg = |i: i32| 0.1 * f64::from(i);
        (0..=20).for_each(|i| crumbs.drop(Pose::new(leg(i), 0.0, 0.0)));
        (0..=20).for_each(|i| crumbs.drop(Pose::new(2.0, leg(i), 0.0)));
        (0..=20).for_each(|i| crumbs.drop(Pose::new(2.0 - leg(i), 2.0, 0.0)));
        crumbs
    }

    /// From where to where, and how long the way is.
    fn length(from: Point2<f64>, way: &[Point2<f64>]) -> f64 {
        let ends = std::iter::once(&from).chain(way);
        ends.zip(way).map(|(from, to)| (to - from).norm()).sum()
    }

    #[test]
    fn a_way_back_goes_where_the_robot_has_been() {
        let from = Point2::new(0.0, 2.0);
        let way = round_a_corner().way(from, Point2::origin());
        assert!((5.5..6.1).contains(&length(from, &way)), "{way:?}");
        assert!(way.len() <= 5 && way.last() == Some(&Point2::origin()), "{way:?}");
        // Always near one of the three sides.
        let beside = |at: &Point2<f64>| at.y.abs().min((at.x - 2.0).abs()).min((at.y - 2.0).abs()) < 0.15;
        assert!(way.iter().all(beside), "{way:?}");
    }

    #[test]
    fn a_loop_is_cut() {
        let mut crumbs = round_a_corner();
        (0..=17).for_each(|i| crumbs.drop(Pose::new(0.0, 2.0 - 0.1 * f64::from(i), 0.0)));
        // The last crumb of the loop lies 0.3 m from the first one, too far; the next one closes it.
        let from = Point2::new(0.0, 0.3);
        let open = crumbs.way(from, Point2::new(0.5, 0.0));
        assert!(length(from, &open) > 5.0, "{open:?}");
        crumbs.drop(Pose::new(0.0, 0.15, 0.0));
        let cut = crumbs.way(from, Point2::new(0.5, 0.0));
        assert!(length(from, &cut) < 1.0, "{cut:?}");
    }

    #[test]
    fn who_has_been_nowhere_goes_straight() {
        assert_eq!(Crumbs::default().way(Point2::origin(), Point2::new(1.0, 0.0)), [Point2::new(1.0, 0.0)]);
    }

    #[test]
    fn the_line_may_be_nearer_than_its_beginning() {
        let mut crumbs = Crumbs::default();
        (0..=20).for_each(|i| crumbs.drop(Pose::new(0.1 * f64::from(i), 0.0, 0.0)));
        (0..=20).for_each(|i| crumbs.drop(Pose::new(2.0, 0.1 * f64::from(i), 0.0)));
        let near = crumbs.nearest_on_line(Pose::default(), Pose::new(1.78, 1.0, 1.5));
        assert!((near.x - 1.8).abs() < 0.25 && near.y.abs() < 0.15 && near.heading == 0.0, "{near:?}");
    }
}
