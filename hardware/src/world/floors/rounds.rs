//! Where people walk: through the corridors of a floor and back to where they began.
//!
//! In a narrow corridor nobody gets past a robot. Who walks round and meets one turns, goes home the other way, and leaves the robot its
//! corridor; who walked to and fro in that corridor would be shut up behind it for ever.

use rand::{Rng, seq::SliceRandom};

/// A way round through the first of these corridors, each given by the places that it joins: the places in the order in which they are come to, none
/// twice, each with the corridor by which it is left; the last leads back to the first place. `None` if no way leads round.
pub(super) fn round(through: usize, corridors: &[[usize; 2]], random: &mut impl Rng) -> Option<Vec<(usize, usize)>> {
    let [home, next] = *corridors.get(through)?;
    let places = corridors.iter().flatten().max()? + 1;
    let mut order: Vec<usize> = (0..corridors.len()).filter(|corridor| *corridor != through).collect();
    order.shuffle(random);
    // Depth first, which strays as far as a walk can. For each place: where one came from, and by which corridor.
    let mut came: Vec<Option<(usize, usize)>> = vec![None; places];
    let mut open = vec![(next, (home, through))];
    while let Some((place, from)) = open.pop() {
        if came[place].is_some() {
            continue;
        }
        came[place] = Some(from);
        if place == home {
            break;
        }
        let leads = |corridor: &usize| {
            let ends = corridors[*corridor];
            let at = ends.iter().position(|end| *end == place)?;
            Some((ends[1 - at], (place, *corridor)))
        };
        open.extend(order.iter().filter_map(leads));
    }
    let mut way = Vec::new();
    let mut at = home;
    loop {
        let (from, corridor) = came[at]?;
        way.push((from, corridor));
        at = from;
        if at == home {
            break;
        }
    }
    way.reverse();
    Some(way)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    use super::*;

    /// A square of corridors, a diagonal, and a dead end.
    const CORRIDORS: [[usize; 2]; 6] = [[0, 1], [1, 2], [3, 2], [0, 3], [0, 2], [3, 4]];

    proptest! {
        #[test]
        fn a_way_round_comes_home_and_passes_no_place_twice(seed: u64, through in 0_usize..5) {
            let way = round(through, &CORRIDORS, &mut Pcg64::seed_from_u64(seed)).unwrap_or_default();
            prop_assert!(way.len() >= 3 && way[0] == (CORRIDORS[through][0], through), "{:?}", way);
            for (i, (place, corridor)) in way.iter().enumerate() {
                let next = way[(i + 1) % way.len()].0;
                let ends = CORRIDORS[*corridor];
                prop_assert!(ends == [*place, next] || ends == [next, *place], "{:?}", way);
                prop_assert_eq!(way.iter().filter(|(other, _)| other == place).count(), 1);
            }
        }
    }

    #[test]
    fn no_way_leads_round_through_a_dead_end() {
        let mut random = Pcg64::seed_from_u64(1);
        assert_eq!((round(5, &CORRIDORS, &mut random), round(9, &CORRIDORS, &mut random)), (None, None));
    }
}
