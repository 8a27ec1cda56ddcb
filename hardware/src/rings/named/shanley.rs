//! The reference scans of the wheelchair in its maze (Shanley 1994): an independent simulation of the same geometry, by rays
//! over a bitmap of 25 mm.

#![allow(clippy::unwrap_used)]

use std::f64::consts::FRAC_PI_2;

use nalgebra::Point2;
use orienteer_runtime::geometry::Pose;

use super::*;
use crate::echo::{Acoustics, Beam, Scratch, SegmentGrid, Wall, cone};

/// Boxes as x from, x to, y from, y to, in m; the outer wall's inner faces first.
const MAZE: [[f64; 4]; 16] = [
    [0.275, 15.725, 0.25, 11.10],
    [1.900, 3.275, 8.100, 9.475],
    [2.150, 3.525, 4.100, 5.475],
    [3.650, 5.025, 5.600, 6.975],
    [3.650, 5.025, 2.350, 3.725],
    [3.275, 5.025, 0.250, 2.500],
    [6.275, 6.775, 1.500, 9.850],
    [8.025, 8.525, 6.250, 11.350],
    [8.025, 8.525, 0.000, 5.100],
    [6.775, 8.025, 6.250, 6.750],
    [9.775, 11.275, 4.500, 7.500],
    [9.775, 10.275, 1.500, 4.000],
    [9.775, 12.775, 1.500, 2.000],
    [8.525, 13.275, 8.850, 9.350],
    [12.775, 13.275, 4.350, 8.850],
    [13.775, 14.275, 1.350, 3.100],
];

/// x, y in m, compass heading in rad; then the six ranges.
const SCANS: [([f64; 3], [f64; 6]); 5] = [
    ([1.0, 4.0, 0.0], [4.100, 3.275, 1.325, 0.875, 0.425, 2.375]),
    ([1.6, 4.0, 0.0], [4.100, 3.275, 0.725, 1.475, 1.025, 1.775]),
    ([5.5, 8.0, 0.0], [3.050, 3.800, 0.950, 2.375, 2.975, 0.500]),
    ([7.4, 2.0, 0.0], [3.425, 1.250, 0.800, 0.725, 0.275, 0.350]),
    ([8.0, 5.7, FRAC_PI_2], [1.775, 0.650, 0.725, 0.650, 0.200, 2.675]),
];

#[test]
fn the_wheelchair_hears_its_maze_as_in_the_source() {
    let corners = |[x0, x1, y0, y1]: [f64; 4]| [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(x, y));
    let walls: Vec<_> =
        MAZE.iter().map(|b| corners(*b)).flat_map(|c| (0..4).map(move |i| Wall::new(c[i], c[(i + 1) % 4]))).collect();
    let world = SegmentGrid::new(&walls, &[], &[]).unwrap();
    // The source knows no specular loss.
    let acoustics = Acoustics::new(&SonarModel::default().with_incidence_limit(90.0)).unwrap();
    let ring = find("wheelchair-6").unwrap().ring;
    let mut sum = 0.0;
    for ([x, y, compass], ranges) in SCANS {
        // The source's poses are those of the front axle, half a metre ahead of the robot frame.
        let robot = Pose::new(x, y, FRAC_PI_2 - compass).then(Pose::new(-0.5, 0.0, 0.0));
        for (i, (transducer, reference)) in ring.transducers.iter().zip(ranges).enumerate() {
            let beam = Beam::new(robot.then(transducer.mount), transducer.half_beam, ring.max_range);
            let range = cone(&world, &[], &beam, &acoustics, &mut Scratch::default()).unwrap().range;
            // A step of 75 mm less 100 mm is built into the source's ranges, on top of pixels of 25 mm, which a surface met
            // at the edge of the beam (80° off its normal) stretches to 144 mm.
            let excess = range - reference;
            assert!((-0.03..0.20).contains(&excess), "sonar {i} at ({x}, {y}): {range} instead of {reference}");
            sum += excess;
        }
    }
    assert!((sum / 30.0 - 0.0625).abs() < 0.025, "{}", sum / 30.0);
}
