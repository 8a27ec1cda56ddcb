#![allow(clippy::unwrap_used)]

use std::f64::consts::FRAC_PI_2;

use super::*;

fn two() -> RingConfig {
    let left = TransducerConfig { y: 0.1, bearing_deg: 90.0, half_beam_deg: Some(7.5), ..TransducerConfig::default() };
    RingConfig { transducer: vec![TransducerConfig::default(), left], ..RingConfig::default() }
}

#[test]
fn degrees_become_radians_and_a_transducer_may_differ() {
    let ring = two().ring("two").unwrap();
    assert_eq!(ring.name, "two");
    assert_eq!(ring.transducers[1].mount, Pose::new(0.0, 0.1, FRAC_PI_2));
    assert_eq!(ring.transducers.iter().map(|t| t.half_beam).collect::<Vec<_>>(), [15f64, 7.5].map(f64::to_radians));
}

#[test]
fn slots_become_masks() {
    let slots = vec![vec![1], vec![], vec![0, 1]];
    let ring = RingConfig { slots, period: 0.5, ..two() }.ring("two").unwrap();
    assert_eq!(ring.program.slots[..], [0b10, 0, 0b11]);
    assert_eq!(ring.program.period, 0.5);
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let refused = |config: RingConfig| config.ring("two").unwrap_err().to_string();
    assert_eq!(refused(RingConfig::default()), "ring `two` has no transducer");
    assert_eq!(
        refused(RingConfig { slots: vec![vec![0], vec![1, 2]], ..two() }),
        "slot 1 of ring `two` fires transducer 2, but the ring has only 0 to 1"
    );
    assert_eq!(
        refused(RingConfig { transducer: vec![TransducerConfig::default(); 33], ..two() }),
        "ring `two` has 33 transducers, at most 32 are possible"
    );
    assert_eq!(refused(RingConfig { slots: vec![vec![0]; 33], ..two() }), "ring `two` has 33 slots, at most 32 are possible");
    assert_eq!(refused(RingConfig { half_beam_deg: 60.0, ..two() }), "`half_beam_deg` of ring `two` is out of range");
    assert_eq!(refused(RingConfig { min_range: 4.0, max_range: 3.0, ..two() }), "`max_range` of ring `two` is out of range");
    assert_eq!(refused(RingConfig { slot_time: f64::NAN, ..two() }), "`slot_time` of ring `two` is out of range");
}

#[test]
fn a_misspelt_key_is_refused() {
    let error = toml::from_str::<RingConfig>("[[transducer]]\nbearing = 90.0").unwrap_err().to_string();
    assert!(error.contains("bearing"), "{error}");
}
