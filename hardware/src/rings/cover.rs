//! How much of the way ahead a ring has in view.

use nalgebra::{Point2, Rotation2};
use orienteer_runtime::robot_model::{Ring, Transducer};

/// Places across the width that are looked at.
const PLACES: usize = 400;

/// The width, m, of the widest part of a round body's front that is in no beam, once the body has gone straight on by `ahead` m.
/// Somebody who steps in from the side can stand there unheard. The front is the half circle of `radius` m that leads.
///
/// ```
/// use orienteer_hardware::rings::{find, widest_gap};
///
/// let ring = |name| find(name).expect("a known name").ring;
/// assert!(widest_gap(&ring("denning-16"), 0.3, 0.5) < 0.02);
/// assert!(widest_gap(&ring("luey-8-square"), 0.3, 0.2) > 0.1);
/// ```
#[must_use]
pub fn widest_gap(ring: &Ring, radius: f64, ahead: f64) -> f64 {
    let step = 2.0 * radius / PLACES as f64;
    let (mut widest, mut run) = (0, 0);
    for place in 0..PLACES {
        let y = (place as f64 + 0.5) * step - radius;
        let front = Point2::new((radius * radius - y * y).sqrt() + ahead, y);
        run = if ring.transducers.iter().any(|transducer| looks_at(transducer, front)) { 0 } else { run + 1 };
        widest = widest.max(run);
    }
    step * f64::from(widest)
}

fn looks_at(transducer: &Transducer, place: Point2<f64>) -> bool {
    let mount = &transducer.mount;
    let seen = Rotation2::new(-mount.heading) * (place - mount.point());
    seen.y.abs() <= seen.x * transducer.half_beam.tan()
}
