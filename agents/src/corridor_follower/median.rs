//! The median of the last few readings of a transducer.

use orienteer_runtime::topics::Echo;

/// Median of the last few readings of a transducer. A median rather than a mean: one spurious echo must not show.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Median {
    values: [f64; Median::SIZE],
    count: usize,
}

impl Median {
    const SIZE: usize = 5;

    pub(super) fn push(&mut self, echo: Echo, max_range: f64) {
        if let Some(free) = echo.free_distance(max_range as f32) {
            self.values[self.count % Self::SIZE] = f64::from(free);
            self.count += 1;
        }
    }

    pub(super) fn is_full(&self) -> bool {
        self.count >= Self::SIZE
    }

    pub(super) fn value(&self) -> f64 {
        let mut sorted = self.values;
        sorted.sort_unstable_by(f64::total_cmp);
        sorted[Self::SIZE / 2]
    }
}
