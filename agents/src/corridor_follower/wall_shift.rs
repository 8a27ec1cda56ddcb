//! Walls that step in or out by less than an opening.

/// Notices that a wall stands elsewhere than thought: a cupboard along it, a recess, a wrong guess at the start.
///
/// A filter that passes over what does not fit would for ever keep to a wall that is no longer there. Readings that are off by
/// the same amount over half a metre of the way are a surface.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WallShift {
    from: f64,
    mean: f64,
    count: u32,
    strays: u32,
}

/// Less than this the filter mends by itself, m.
const SLIGHT: f64 = 0.12;
/// Readings of one surface differ by no more than this, m.
const ALIKE: f64 = 0.08;
/// The length of a surface that counts, m.
const LONG: f64 = 0.4;
/// So many readings in a row that do not belong to a surface are the end of it.
const STRAYS: u32 = 3;
/// A surface has been heard at least so often.
const OFTEN: u32 = 10;

impl WallShift {
    /// Takes a reading of the wall at path length `at`: how much longer it was than expected. Returns how far the wall has
    /// shifted once that is sure.
    pub(super) fn hear(&mut self, at: f64, surplus: f64) -> Option<f64> {
        if self.count > 0 && (surplus - self.mean).abs() < ALIKE {
            self.count += 1;
            self.strays = 0;
            self.mean += (surplus - self.mean) / f64::from(self.count);
        } else {
            self.strays += 1;
            if self.count == 0 || self.strays >= STRAYS {
                let off = surplus.is_finite() && surplus.abs() > SLIGHT;
                *self = Self { from: at, mean: surplus, count: u32::from(off), strays: 0 };
            }
            return None;
        }
        if self.count < OFTEN || (at - self.from).abs() < LONG || self.mean.abs() < SLIGHT {
            return None;
        }
        let shift = self.mean;
        *self = Self::default();
        Some(shift)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hear(surplus: impl Fn(u32) -> f64) -> Option<f64> {
        let mut shift = WallShift::default();
        (0..100).find_map(|n| shift.hear(0.01 * f64::from(n), surplus(n)))
    }

    #[test]
    fn a_cupboard_is_a_wall_in_spite_of_stray_echoes() {
        let shift = hear(|n| if n % 17 == 3 { 1.0 } else { -0.4 });
        assert!(shift.is_some_and(|shift| (shift + 0.4).abs() < 0.01), "{shift:?}");
    }

    #[test]
    fn neither_the_wall_nor_silence_nor_clutter_is() {
        assert_eq!(hear(|n| if n % 2 == 0 { 0.03 } else { -0.03 }), None);
        assert_eq!(hear(|_| f64::INFINITY), None);
        assert_eq!(hear(|n| -0.2 * f64::from(n % 5)), None);
    }
}
