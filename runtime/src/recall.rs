//! The last few answers to a question that is asked again and again.

/// Remembers what a costly function gave for the last `N` different keys: transducers that fire together ask for the same pose.
///
/// ```
/// use orienteer_runtime::recall::Recall;
/// let (mut roots, mut asked) = (Recall::<u32, f64, 2>::default(), 0);
/// for key in [4, 9, 4, 9] {
///     let root = roots.get(key, || {
///         asked += 1;
///         f64::from(key).sqrt()
///     });
///     assert_eq!(root * root, f64::from(key));
/// }
/// assert_eq!(asked, 2);
/// ```
#[derive(Debug, Clone)]
pub struct Recall<K, V, const N: usize> {
    known: [Option<(K, V)>; N],
    /// The place of the oldest.
    next: usize,
}

impl<K: Copy, V: Copy, const N: usize> Default for Recall<K, V, N> {
    fn default() -> Self {
        Self { known: [None; N], next: 0 }
    }
}

impl<K: Copy + PartialEq, V: Copy, const N: usize> Recall<K, V, N> {
    /// What `work` gave for an equal key, or gives now.
    pub fn get(&mut self, key: K, work: impl FnOnce() -> V) -> V {
        let known = self.known.iter().flatten().find(|(other, _)| *other == key);
        if let Some((_, value)) = known {
            return *value;
        }
        let value = work();
        if let Some(place) = self.known.get_mut(self.next) {
            *place = Some((key, value));
            self.next = (self.next + 1) % N;
        }
        value
    }
}
