//! Arbitration of the sonar: who wins, and that the safety floor holds.
#![allow(clippy::unwrap_used)]

use orienteer_runtime::{
    arbitration::{
        Clients,
        sonar::{FloorError, SafetyFloor, SonarArbiter},
    },
    geometry::Pose,
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{ArbitrationRule, ClientId, FiringProgram, FixedVec, SonarClaim},
};
use proptest::prelude::*;

fn program(slots: &[u32], period: f32) -> FiringProgram {
    let mut list = FixedVec::default();
    slots.iter().for_each(|slot| assert!(list.push(*slot)));
    FiringProgram { slots: list, period, rings: 1 }
}

fn ring(transducers: usize, slot_time: f64, program: FiringProgram) -> Ring {
    let transducer = Transducer { mount: Pose::default(), half_beam: 0.2 };
    Ring { name: "test".into(), transducers: vec![transducer; transducers], min_range: 0.2, max_range: 7.0, slot_time, program }
}

/// A ring of 16, fired one by one.
fn round_robin() -> Ring {
    ring(16, 0.025, program(&(0..16).map(|i| 1 << i).collect::<Vec<_>>(), 0.0))
}

/// Runs a program and returns the longest time between two firings of each transducer.
fn simulate(program: &FiringProgram, slot_time: f64) -> [f64; 32] {
    let mut last = [None; 32];
    let mut longest = [0.0f64; 32];
    let mut now = 0.0;
    for _pass in 0..5 {
        let start = now;
        for slot in program.slots.iter() {
            for i in (0..32).filter(|i| slot & (1 << i) != 0) {
                if let Some(last) = last[i] {
                    longest[i] = longest[i].max(now - last);
                }
                last[i] = Some(now);
            }
            now += slot_time;
        }
        now = now.max(start + f64::from(program.period));
    }
    std::array::from_fn(|i| if last[i].is_some() { longest[i] } else { f64::INFINITY })
}

fn masks(ring: u32) -> impl Strategy<Value = Vec<u32>> {
    // Single transducers, groups, and a few whole rings.
    let slot =
        prop_oneof![4 => (0..ring).prop_map(|i| 1u32 << i), 2 => any::<u32>().prop_map(|a| a & 0x1111_1111), 1 => any::<u32>()];
    let members = u32::MAX >> (32 - ring);
    prop::collection::vec(slot.prop_map(move |slot| slot & members), 0..=32)
        .prop_map(|slots| slots.into_iter().filter(|s| *s != 0).collect())
}

prop_compose! {
    fn cases()(size in 1u32..=32)(
        own in masks(size),
        wanted in masks(size),
        floor in prop_oneof![Just(1u32), any::<u32>(), any::<u32>().prop_map(|a| a & 0x8421_0421)],
        slot_time in prop_oneof![Just(0.025), Just(0.05), 0.003..0.2],
        budget in prop_oneof![1.0..8.0, 1.0..40.0],
        whole in any::<bool>(),
        period in prop_oneof![3 => Just(0.0), 2 => 0.0..2.0f32, 1 => Just(1e9)],
        size in Just(size),
    ) -> (Ring, u32, f64, FiringProgram) {
        let budget: f64 = if whole { f64::round(budget) } else { budget };
        let ring = ring(size as usize, slot_time, program(&own, 0.0));
        (ring, floor & (u32::MAX >> (32 - size)), budget * slot_time, program(&wanted, period))
    }
}

/// True if `part` can be made of `whole` by leaving out slots, and of those that stay, transducers of the floor.
fn contains(whole: &[u32], part: &[u32], floor: u32) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|own| rest.any(|slot| slot & own == *own && slot & !own & !floor == 0))
}

/// Tries to do without each slot that only the floor can have put in, and without each transducer that has joined a slot.
fn nothing_is_superfluous(merged: &FiringProgram, wanted: &FiringProgram, floor: u32, period: f64, slot_time: f64) -> bool {
    let kept = |slots: &[u32]| {
        let gaps = simulate(&program(slots, merged.period), slot_time);
        (0..32).filter(|i| floor & (1 << i) != 0).all(|i| gaps[i] < period - 1e-5)
    };
    let joined = merged.slots.len() == wanted.slots.len();
    (0..merged.slots.len()).all(|i| {
        let mut slots = merged.slots.to_vec();
        if joined {
            return (0..32).filter(|bit| merged.slots[i] & !wanted.slots[i] & (1 << bit) != 0).all(|bit| {
                slots[i] = merged.slots[i] & !(1 << bit);
                !kept(&slots)
            });
        }
        let slot = slots.remove(i);
        slot & !floor != 0 || wanted.slots.contains(&slot) || !kept(&slots)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn every_floor_transducer_is_fired_in_time((ring, mask, period, wanted) in cases()) {
        match SafetyFloor::new(&ring, mask, period) {
            Ok(mut floor) => {
                let (merged, added) = floor.merge(&wanted);
                let gaps = simulate(&merged, ring.slot_time);
                for i in (0..32).filter(|i| mask & (1 << i) != 0) {
                    prop_assert!(gaps[i] <= period + 2e-6, "transducer {} waits {} s, {:?}", i, gaps[i], merged);
                }
                prop_assert!(contains(&merged.slots, &wanted.slots, mask), "{:?}", merged);
                prop_assert_eq!(merged.transducers() & !wanted.transducers() & !mask, 0);
                prop_assert_eq!(added & !mask, 0);
                prop_assert!(merged.period <= wanted.period);
                prop_assert_eq!(floor.merge(&merged), (merged, 0), "what keeps the floor is left alone");
                prop_assert!(nothing_is_superfluous(&merged, &wanted, mask, period, ring.slot_time), "{:?}", merged);
            }
            Err(FloorError::TooOften { least, .. }) => {
                prop_assert!(least > period);
                prop_assert!(SafetyFloor::new(&ring, mask, least * 1.001).is_ok());
            }
            Err(other) => prop_assert!(false, "{}", other),
        }
    }

    #[test]
    fn a_program_that_keeps_the_floor_is_left_alone((ring, mask, period, wanted) in cases()) {
        let gaps = simulate(&wanted, ring.slot_time);
        let kept = (0..32).filter(|i| mask & (1 << i) != 0).all(|i| gaps[i] < period - 1e-5);
        if kept && let Ok(mut floor) = SafetyFloor::new(&ring, mask, period) {
            prop_assert_eq!(floor.merge(&wanted), (wanted, 0));
        }
    }

    /// Against a list of askers in order of arrival.
    #[test]
    fn the_first_of_the_highest_priority_wins(
        priorities in prop::collection::vec(0u8..4, 1..6),
        steps in prop::collection::vec(prop::collection::vec((0u16..7, 0u64..4, 0u32..4), 0..6), 1..40),
    ) {
        let clients: Clients = priorities.iter().map(|priority| ("somebody", *priority)).collect();
        let mut arbiter = SonarArbiter::new(&clients, &round_robin(), SafetyFloor::none());
        let mut askers: Vec<usize> = Vec::new();
        let mut wishes = vec![(Time::START, 0); priorities.len()];
        for (step, claims) in steps.iter().enumerate() {
            let now = Time::from_nanos(step as u64 + 1);
            for (client, lease, slot) in claims {
                let valid_until = Time::from_nanos(now.as_nanos() + lease);
                let (client_id, program) = (ClientId(*client), program(&[*slot], 0.0));
                arbiter.claim(&SonarClaim { client: client_id, stamp: now, valid_until, program });
                if let Some(wish) = wishes.get_mut(usize::from(*client)) {
                    *wish = (valid_until, *slot);
                }
            }
            let wants = |i: &usize| wishes[*i].0 > now && wishes[*i].1 != 0;
            askers.retain(wants);
            let new: Vec<usize> = (0..priorities.len()).filter(wants).filter(|i| !askers.contains(i)).collect();
            askers.extend(new);
            let highest = askers.iter().map(|i| priorities[*i]).max();
            let winner = askers.iter().find(|i| Some(priorities[**i]) == highest);

            let decision = arbiter.decide(now);
            prop_assert_eq!(decision.holder.known().map(|holder| usize::from(holder.0)), winner.copied());
            let runs = winner.map_or(round_robin().program, |winner| program(&[wishes[*winner].1], 0.0));
            prop_assert_eq!(decision.program, runs);
            prop_assert_eq!(decision.held_back().len(), askers.len().saturating_sub(1));
        }
    }
}

#[test]
fn the_floor_doubles_the_front_of_a_round_robin() {
    // Front three every 0.2 s, in a ring that needs 0.4 s for a round.
    let ring = round_robin();
    let mut floor = SafetyFloor::new(&ring, 0b1000_0000_0000_0011, 0.2).unwrap();
    let (merged, added) = floor.merge(&ring.program);
    assert_eq!(added, 0b1000_0000_0000_0011);
    // Eight slots from one to the next; of these, five for the others.
    let places: Vec<usize> = (0..merged.slots.len()).filter(|i| merged.slots[*i] & 1 != 0).collect();
    assert!(places.windows(2).all(|pair| pair[1] - pair[0] <= 8), "{places:?}");
    assert!(merged.slots.len() <= 16 + 3 * 3, "more than needed: {merged:?}");
}

#[test]
fn a_full_program_is_joined_by_the_floor() {
    let ring = ring(32, 0.01, program(&(0..32).map(|i| 1 << i).collect::<Vec<_>>(), 0.0));
    let mut floor = SafetyFloor::new(&ring, 0b11, 0.1).unwrap();
    let (merged, added) = floor.merge(&ring.program);
    assert_eq!((merged.slots.len(), added), (32, 0b11));
    assert!(simulate(&merged, 0.01)[..2].iter().all(|gap| *gap <= 0.1 + 1e-6));
}

#[test]
fn those_who_join_are_spread() {
    let ring = ring(32, 0.01, program(&(0..32).map(|i| 1 << i).collect::<Vec<_>>(), 0.0));
    let mut floor = SafetyFloor::new(&ring, 0b11 << 20, 0.1).unwrap();
    let (merged, _) = floor.merge(&ring.program);
    assert!(merged.slots.iter().all(|slot| slot.count_ones() <= 2), "{merged:?}");
}

#[test]
fn late_claims_do_not_count() {
    let clients: Clients = [("a", 1)].into_iter().collect();
    let mut arbiter = SonarArbiter::new(&clients, &round_robin(), SafetyFloor::none());
    let valid_until = Time::FAR;
    for (stamp, slot) in [(5, 0b1), (4, 0b10)] {
        arbiter.claim(&SonarClaim {
            client: ClientId(0),
            stamp: Time::from_nanos(stamp),
            valid_until,
            program: program(&[slot], 0.0),
        });
    }
    assert_eq!(arbiter.decide(Time::from_nanos(6)).program.slots[..], [0b1]);
}

#[test]
fn a_slow_program_is_run_more_often() {
    let ring = round_robin();
    let mut floor = SafetyFloor::new(&ring, 1, 0.2).unwrap();
    let (merged, _) = floor.merge(&program(&[0b1], 3.0));
    assert_eq!(merged, program(&[0b1], 0.2));
}

#[test]
fn what_is_fired_together_may_stay_together() {
    let ring = ring(16, 0.05, program(&[0x0101, 0x0202, 0x0404, 0x0808], 0.0));
    let mut floor = SafetyFloor::new(&ring, 0x0303, 0.15).unwrap();
    let (merged, _) = floor.merge(&program(&[0x1000], 0.0));
    assert_eq!(merged.slots[..], [0x0101, 0x0202, 0x1000]);
}

#[test]
fn impossible_floors_are_refused() {
    let ring = round_robin();
    assert_eq!(SafetyFloor::new(&ring, 1 << 16, 1.0).unwrap_err(), FloorError::NoSuchTransducers(vec![16]));
    assert!(matches!(SafetyFloor::new(&ring, 1, f64::NAN), Err(FloorError::BadPeriod(_))));
    assert!(matches!(SafetyFloor::new(&ring, 0xff, 0.2), Err(FloorError::TooOften { .. })));
    assert!(SafetyFloor::new(&ring, 0x7f, 0.2).is_ok());
    let still = Ring { slot_time: 0.0, ..round_robin() };
    assert!(matches!(SafetyFloor::new(&still, 1, 0.2), Err(FloorError::BadSlotTime(_))));
    assert!(SafetyFloor::new(&still, 0, 0.0).is_ok(), "nothing is asked");
}

#[test]
fn a_floor_under_all_is_kept_by_a_ring_whose_own_program_leaves_transducers_out() {
    // Each of the 14 others needs a slot of its own: 16 slots of 50 ms do not fit into half a second.
    let ring = ring(16, 0.05, program(&[1, 2], 0.0));
    let mut floor = SafetyFloor::under_all(&ring, 0.5).unwrap();
    assert_eq!((floor.transducers(), floor.period()), (0xffff, 1.6));
    let (merged, added) = floor.merge(&ring.program);
    assert_eq!(added, 0xfffc);
    assert!(simulate(&merged, ring.slot_time)[..16].iter().all(|gap| *gap <= 1.6 + 1e-6));
    assert_eq!(SafetyFloor::under_all(&round_robin(), 1.0).unwrap().period(), 1.0, "a fast ring does as it is asked");
}

#[test]
fn a_floor_under_all_refuses_rings_without_a_slot_time() {
    for slot_time in [0.0, -0.05, f64::NAN, f64::INFINITY] {
        let ring = ring(4, slot_time, program(&[1, 2, 4, 8], 0.0));
        assert!(matches!(SafetyFloor::under_all(&ring, 0.5), Err(FloorError::BadSlotTime(_))), "{slot_time}");
    }
    let none = ring(0, 0.0, program(&[], 0.0));
    assert_eq!(SafetyFloor::under_all(&none, 0.5).unwrap().transducers(), 0);
}

#[test]
fn programs_are_made_valid() {
    let clients: Clients = [("a", 1)].into_iter().collect();
    let small = ring(4, 0.025, program(&[0b1111], 0.0));
    let mut arbiter = SonarArbiter::new(&clients, &small, SafetyFloor::none());
    let mut ask = |slots: &[u32], period| {
        let claim =
            SonarClaim { client: ClientId(0), valid_until: Time::FAR, program: program(slots, period), ..SonarClaim::default() };
        arbiter.claim(&claim);
        arbiter.decide(Time::START)
    };
    let decision = ask(&[0b1_0001, 0, 0b10_0000, 0b1000], f32::NAN);
    assert_eq!(decision.program, program(&[0b0001, 0b1000], 0.0));
    let decision = ask(&[0b1_0000], 0.0);
    assert_eq!((decision.holder, decision.rule()), (ClientId::NONE, ArbitrationRule::NobodyAsked));
    assert_eq!(decision.program, small.program);
}

#[test]
fn the_floor_stands_whoever_has_the_sonar() {
    let clients: Clients = [("mapper", 3), ("avoidance", 10)].into_iter().collect();
    let ring = round_robin();
    let floor = SafetyFloor::new(&ring, 0b1, 0.1).unwrap();
    let mut arbiter = SonarArbiter::new(&clients, &ring, floor);
    let ask =
        |client, slots: &[u32], now| SonarClaim { client, stamp: now, valid_until: Time::FAR, program: program(slots, 0.0) };
    let at = Time::from_secs_f64;

    let nobody = arbiter.decide(at(0.0));
    assert_eq!((nobody.holder, nobody.floor, nobody.reserved), (ClientId::NONE, 0b1, 0b1));
    arbiter.claim(&ask(ClientId(0), &[0b100], at(1.0)));
    let mapper = arbiter.decide(at(1.0));
    assert_eq!(
        (mapper.holder, mapper.rule(), mapper.program.slots[..].to_vec()),
        (ClientId(0), ArbitrationRule::OnlyClaim, vec![0b1, 0b100])
    );
    arbiter.claim(&ask(ClientId(1), &[0b1], at(2.0)));
    let avoidance = arbiter.decide(at(2.0));
    assert_eq!((avoidance.holder, avoidance.rule(), avoidance.floor), (ClientId(1), ArbitrationRule::HigherPriority, 0));
    assert_eq!(avoidance.held_back()[0].rule(), ArbitrationRule::HangingOn);
    arbiter.claim(&ask(ClientId(1), &[], at(3.0)));
    let again = arbiter.decide(at(3.0));
    assert_eq!((again.holder, again.since, again.floor, again.reserved), (ClientId(0), at(3.0), 0b1, 0b1));
}
