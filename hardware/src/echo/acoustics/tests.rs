#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::*;
use crate::echo::{DetectionPoint, IncidencePoint};

const GATE: RangeGate = RangeGate { min: 0.2, max: 7.77 };

fn limits(points: &[(f64, f64)]) -> SonarModel {
    let incidence_limit = points.iter().map(|&(range, limit_deg)| IncidencePoint { range, limit_deg }).collect();
    SonarModel { incidence_limit, ..SonarModel::default() }
}

fn readings(model: &SonarModel, distance: Option<f64>, count: usize) -> Vec<Echo> {
    let (acoustics, mut rng) = (Acoustics::new(model).unwrap(), Pcg64::seed_from_u64(1));
    (0..count).map(|_| acoustics.measure(distance, GATE, &mut rng)).collect()
}

fn reading(model: &SonarModel, distance: f64) -> Echo {
    readings(model, Some(distance), 1)[0]
}

#[test]
fn the_incidence_limit_follows_its_curve() {
    // The curve of Yamabico: 15° to 1 m, 10° at 2 m, 5° at 4 m
    let acoustics = Acoustics::new(&limits(&[(1.0, 15.0), (2.0, 10.0), (4.0, 5.0)])).unwrap();
    for (range, limit) in [(0.1, 15.0), (1.0, 15.0), (1.5, 12.5), (2.0, 10.0), (3.0, 7.5), (4.0, 5.0), (9.0, 5.0)] {
        let answers = |degrees: f64| acoustics.answers(range, degrees.to_radians().cos(), 1.0);
        assert!(answers(limit - 0.01) && !answers(limit + 0.01), "at {range} m");
    }
}

#[test]
fn without_a_limit_every_angle_is_heard() {
    for model in [limits(&[]), limits(&[(0.0, 90.0)])] {
        assert!(Acoustics::new(&model).unwrap().answers(1.0, 0.0, 1.0));
    }
}

#[test]
fn weak_surfaces_are_heard_from_near_only() {
    let detection = vec![DetectionPoint::default(), DetectionPoint { range: 4.0, reflectance: 1.0 }];
    let acoustics = Acoustics::new(&SonarModel { detection, ..SonarModel::default() }).unwrap();
    assert!(acoustics.answers(1.9, 1.0, 0.5) && !acoustics.answers(2.1, 1.0, 0.5));
    assert!(!acoustics.answers(0.0, 1.0, 0.0), "what reflects nothing is never heard");
}

#[test]
fn senseless_models_are_refused() {
    let default = SonarModel::default;
    assert_eq!(Acoustics::new(&limits(&[(2.0, 10.0), (1.0, 5.0)])), Err(ModelError::Unordered("incidence_limit")));
    assert_eq!(Acoustics::new(&limits(&[(1.0, 10.0), (2.0, 15.0)])), Err(ModelError::EasierFarAway("incidence_limit")));
    assert_eq!(Acoustics::new(&limits(&[(1.0, f64::NAN)])), Err(ModelError::OutOfRange("incidence_limit")));
    assert_eq!(Acoustics::new(&SonarModel { noise: f64::NAN, ..default() }), Err(ModelError::OutOfRange("noise")));
    assert_eq!(Acoustics::new(&SonarModel { dropout: 1.1, ..default() }), Err(ModelError::OutOfRange("dropout")));
}

#[test]
fn a_model_survives_toml() {
    let model = limits(&[(1.0, 15.0), (2.0, 10.0)]);
    let text = toml::to_string(&model).unwrap();
    assert_eq!(toml::from_str::<SonarModel>(&text).unwrap(), model);
    assert!(toml::from_str::<SonarModel>("nosie = 0.1").unwrap_err().to_string().contains("nosie"));
}

#[test]
fn ranges_are_cut_to_tenths_of_a_foot() {
    let model = SonarModel { quantum: 0.03048, ..SonarModel::default().noiseless() };
    assert_eq!(reading(&model, 1.0), Echo::Range((32.0 * 0.03048) as f32));
    // A whole number of quanta is not cut to one less.
    assert_eq!(reading(&model, 100.0 * 0.03048), Echo::Range((100.0 * 0.03048) as f32));
    assert_eq!(reading(&model, 7.769), Echo::Range((254.0 * 0.03048) as f32));
}

#[test]
fn the_gate_bounds_what_is_reported() {
    let model = SonarModel::default().noiseless();
    assert_eq!(reading(&model, 0.199), Echo::TooNear);
    assert_eq!(reading(&model, 0.0), Echo::TooNear);
    assert_eq!(reading(&model, 0.25), Echo::Range(0.25));
    assert_eq!(reading(&model, 7.77), Echo::Nothing);
    assert_eq!(readings(&model, None, 1)[0], Echo::Nothing);
}

#[test]
fn noise_has_the_configured_moments() {
    let model = SonarModel { noise: 0.01, noise_per_metre: 0.005, range_scale: 0.98, ..SonarModel::default().noiseless() };
    let ranges: Vec<f64> = readings(&model, Some(2.0), 20_000)
        .iter()
        .map(|echo| if let Echo::Range(range) = echo { f64::from(*range) } else { f64::NAN })
        .collect();
    let mean = ranges.iter().sum::<f64>() / 20_000.0;
    let sigma = (ranges.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / 20_000.0).sqrt();
    assert!((mean - 1.96).abs() < 6e-4, "{mean}");
    assert!((sigma - 0.02).abs() < 5e-4, "{sigma}");
}

#[test]
fn dropouts_and_spurious_readings_are_as_frequent_as_configured() {
    let model = SonarModel { dropout: 0.1, spurious: 0.2, ..SonarModel::default().noiseless() };
    let echoes = readings(&model, Some(2.0), 20_000);
    let share = |matches: fn(&Echo) -> bool| echoes.iter().filter(|e| matches(e)).count() as f64 / 20_000.0;
    assert!((share(|e| *e == Echo::Nothing) - 0.1).abs() < 0.01);
    assert!((share(|e| *e == Echo::Range(2.0)) - 0.7).abs() < 0.015);
    // Uniform between the limits of the gate
    let below_middle = share(|e| matches!(e, Echo::Range(range) if *range != 2.0 && *range < 3.985));
    assert!((below_middle - 0.1).abs() < 0.01, "{below_middle}");
    assert!(readings(&model, None, 1000).iter().any(|e| matches!(e, Echo::Range(_))), "spurious echoes come from nowhere");
}

proptest! {
    #[test]
    fn a_reading_is_never_outside_the_gate(distance in 0.0..20.0f64, noise in 0.0..1.0f64, seed in any::<u64>()) {
        let model = SonarModel { noise, spurious: 0.3, dropout: 0.1, quantum: 0.03048, ..SonarModel::default() };
        let (acoustics, mut rng) = (Acoustics::new(&model).unwrap(), Pcg64::seed_from_u64(seed));
        if let Echo::Range(range) = acoustics.measure(Some(distance), GATE, &mut rng) {
            prop_assert!(f64::from(range) > GATE.min - 0.03048 && f64::from(range) < GATE.max);
        }
    }
}
