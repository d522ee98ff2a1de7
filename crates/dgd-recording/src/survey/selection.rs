//! The value of a rank, of values that come again and again but are not held.

use std::ops::RangeInclusive;

/// Finds the median of finite values in as many passes over them as it takes, which are two or three as a rule, in
/// memory that does not grow with them (Munro and Paterson 1980, Selection and sorting with limited storage).
///
/// The first pass takes a sample. Each later one counts what lies below a bracket around the rank that is
/// looked for, and samples what is in it, until all of that is held.
#[derive(Debug, Clone)]
pub(crate) struct Selection {
    /// Values that are held at the most.
    room: usize,
    /// Where the value is known to be, and where it is looked for.
    known: RangeInclusive<u64>,
    bracket: RangeInclusive<u64>,
    /// All values, of the first pass; `None` in it.
    all: Option<u64>,
    below: u64,
    inside: u64,
    /// Of those inside one in so many is held, drawn as if blindly: every so many would be the same ones of a wave.
    stride: u64,
    held: Vec<u64>,
    found: Option<f64>,
}

/// A number whose order is that of [`f64::total_cmp`].
fn key(value: f64) -> u64 {
    let bits = value.to_bits();
    match bits >> 63 {
        0 => bits | 1 << 63,
        _ => !bits,
    }
}

fn value(key: u64) -> f64 {
    f64::from_bits(match key >> 63 {
        0 => !key,
        _ => key & !(1 << 63),
    })
}

/// Whether a number is one of those drawn, one in so many (a power of two), the same ones always: the mixing of
/// splitmix64 (Steele, Lea and Flood 2014).
fn is_drawn(number: u64, stride: u64) -> bool {
    let mut mixed = number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed ^ (mixed >> 31)) & (stride - 1) == 0
}

impl Selection {
    /// Holds at most so many values, at least 8.
    pub(crate) fn new(room: usize) -> Self {
        let everywhere = 0..=u64::MAX;
        Self {
            room: room.max(8),
            known: everywhere.clone(),
            bracket: everywhere,
            all: None,
            below: 0,
            inside: 0,
            stride: 1,
            held: Vec::new(),
            found: None,
        }
    }

    /// Takes a finite value; the same ones, in the same order, on every pass.
    pub(crate) fn add(&mut self, value: f64) {
        let key = key(value);
        if key < *self.bracket.start() {
            self.below += 1;
        } else if key <= *self.bracket.end() {
            if is_drawn(self.inside, self.stride) {
                if self.held.len() >= self.room {
                    self.stride *= 2;
                    let mut nth = self.stride;
                    self.held.retain(|_| {
                        nth += 1;
                        is_drawn(nth, 2)
                    });
                }
                if self.held.len() < self.room && is_drawn(self.inside, self.stride) {
                    self.held.push(key);
                }
            }
            self.inside += 1;
        }
    }

    /// Ends a pass; says whether another one is needed.
    pub(crate) fn next_pass(&mut self) -> bool {
        let all = *self.all.get_or_insert(self.inside);
        if self.found.is_some() || all == 0 {
            return false;
        }
        let rank = all / 2;
        let (low, high) = (*self.bracket.start(), *self.bracket.end());
        if rank < self.below {
            self.known = *self.known.start()..=low - 1;
        } else if rank >= self.below + self.inside {
            self.known = high + 1..=*self.known.end();
        } else if low == high || self.stride == 1 {
            let nth = usize::try_from(rank - self.below).unwrap_or(0);
            let nth = if low == high { 0 } else { nth };
            self.found = Some(value(*self.held.select_nth_unstable(nth).1));
            return false;
        } else {
            self.known = low..=high;
            self.narrow(rank);
            return true;
        }
        // The sample led astray: all that is left is looked through.
        self.look(self.known.clone());
        true
    }

    /// The median: of an even number the upper one of the two in the middle. `None` without values.
    pub(crate) fn found(&self) -> Option<f64> {
        self.found
    }

    /// A bracket around the rank: four standard errors of a sample drawn blindly to either side.
    fn narrow(&mut self, rank: u64) {
        self.held.sort_unstable();
        let held = self.held.len();
        let share = (rank - self.below) as f64 / self.inside as f64;
        let margin = 4.0 * 0.5 * (held as f64).sqrt();
        let at = |place: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to the places that there are"
            )]
            let place = place.clamp(0.0, (held - 1) as f64) as usize;
            self.held[place]
        };
        let middle = share * held as f64;
        let (low, high) = (at(middle - margin), at(middle + margin));
        let bracket = low..=high;
        if bracket == self.known {
            // Two values, say, and nothing between them.
            self.look(low..=low + (high - low) / 2);
        } else {
            self.look(bracket);
        }
    }

    fn look(&mut self, bracket: RangeInclusive<u64>) {
        self.bracket = bracket;
        (self.below, self.inside, self.stride) = (0, 0, 1);
        self.held.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The median, and the passes that it took.
    fn median(values: &[f64], room: usize) -> (Option<f64>, usize) {
        let mut selection = Selection::new(room);
        let mut passes = 0;
        loop {
            passes += 1;
            values.iter().for_each(|v| selection.add(*v));
            assert!(selection.held.len() <= selection.room);
            if !selection.next_pass() {
                return (selection.found(), passes);
            }
        }
    }

    fn sorted(values: &[f64]) -> Option<f64> {
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    }

    proptest! {
        #[test]
        fn the_median_is_that_of_the_sorted_values(
            values in proptest::collection::vec(
                prop_oneof![
                    -10.0..10.0_f64,
                    any::<f64>().prop_filter("finite", |v| v.is_finite()),
                    (-3..4_i32).prop_map(f64::from),
                    Just(-0.0),
                ],
                0..400,
            ),
            room in 0..64_usize,
        ) {
            let (found, _) = median(&values, room);
            prop_assert_eq!(found.map(f64::to_bits), sorted(&values).map(f64::to_bits));
        }
    }

    #[test]
    fn long_recordings_take_few_passes() {
        let wave: Vec<f64> = (0..200_000)
            .map(|i| f64::from(i % 1009) + f64::from(i).sin())
            .collect();
        let drift: Vec<f64> = (0..200_000).map(f64::from).collect();
        let steps: Vec<f64> = (0..200_000).map(|i| f64::from(i % 3)).collect();
        // A period that is a power of two: a sample of every so many would see few of its values.
        let pattern: Vec<f64> = (0..200_000).map(|i| f64::from(i % 64 * 29 % 61)).collect();
        let vectors = [
            (&wave, 3),
            (&drift, 3),
            (&steps, 3),
            (&vec![7.0; 200_000], 3),
            (&pattern, 5),
        ];
        for (values, most) in vectors {
            let (found, passes) = median(values, 1 << 12);
            assert_eq!(found, sorted(values));
            assert!(passes <= most, "{passes} passes");
        }
    }
}
