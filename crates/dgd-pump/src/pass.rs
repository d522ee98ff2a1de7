//! The rows of the table, gathered by distinct speed and distinct flow.

use crate::Samples;
use crate::table::{NODES, Nodes};

/// Distinct values held before the sums are folded: bounds the memory when nothing repeats.
const DISTINCT: usize = 1 << DISTINCT_BITS;
const DISTINCT_BITS: u32 = 14;

/// Sums of the rows that share a distinct value.
#[derive(Clone, Copy, Default)]
pub(crate) struct Group {
    pub(crate) rows: f64,
    /// Of the other variable.
    pub(crate) other: f64,
    pub(crate) head: f64,
}

/// What a pass over rows gathers, per distinct speed and per distinct flow.
pub(crate) struct Pass {
    pub(crate) speeds: Distinct,
    pub(crate) flows: Distinct,
    pub(crate) groups: Groups,
    /// Per distinct flow, `Σ w^n0` of its rows at the nodes of n0.
    pub(crate) v: Vec<[f64; NODES]>,
}

impl Pass {
    pub(crate) fn new() -> Self {
        Self {
            speeds: Distinct::new(),
            flows: Distinct::new(),
            groups: Groups::default(),
            v: Vec::new(),
        }
    }

    /// Takes rows as long as there is a place for their distinct values; returns how many, kept or not.
    ///
    /// Two halves of the work go side by side, twice; every sum is in the order of the rows, so that the number of cores
    /// changes no digit.
    pub(crate) fn take(
        &mut self,
        part: &Samples,
        scale: (f64, f64),
        (n0, n2): (&Nodes, &Nodes),
    ) -> usize {
        let (speeds, flows) = (&mut self.speeds, &mut self.flows);
        let (end_w, end_q) = rayon::join(
            || speeds.take(part.speed_pct, part.keep, scale.0, n0),
            || flows.take(part.flow_m3_s, part.keep, scale.1, n2),
        );
        let part = part.to(end_w.min(end_q));
        let kept = part.keep.iter().filter(|k| **k).count();
        speeds.leave(kept);
        flows.leave(kept);
        self.v.resize(flows.values.len(), [0.0; NODES]);
        let (groups, v) = (&mut self.groups, &mut self.v);
        rayon::join(
            || groups.add(&part, scale, speeds, flows),
            || {
                for (i, j) in speeds.index.iter().zip(&flows.index) {
                    let a = &speeds.powers[usize::from(*i)];
                    for (v, a) in v[usize::from(*j)].iter_mut().zip(a) {
                        *v += a;
                    }
                }
            },
        );
        part.keep.len()
    }
}

/// The sums of a pass that take no powers.
#[derive(Default)]
pub(crate) struct Groups {
    pub(crate) at_speed: Vec<Group>,
    pub(crate) at_flow: Vec<Group>,
    pub(crate) rows: u64,
    pub(crate) bb: f64,
    pub(crate) by: f64,
    pub(crate) yy: f64,
}

impl Groups {
    fn add(&mut self, part: &Samples, scale: (f64, f64), speeds: &Distinct, flows: &Distinct) {
        self.at_speed.resize(speeds.values.len(), Group::default());
        self.at_flow.resize(flows.values.len(), Group::default());
        let places = speeds.index.iter().zip(&flows.index);
        for ((w, q, h), (i, j)) in part.rows().zip(places) {
            let (w, q) = (w / scale.0, q / scale.1);
            let at_speed = &mut self.at_speed[usize::from(*i)];
            let at_flow = &mut self.at_flow[usize::from(*j)];
            for (group, other) in [(at_speed, q), (at_flow, w)] {
                group.rows += 1.0;
                group.other += other;
                group.head += h;
            }
            self.rows += 1;
            let b = w * q;
            self.bb += b * b;
            self.by += b * h;
            self.yy += h * h;
        }
    }
}

/// Distinct values in order of appearance, found by hashing their bits.
pub(crate) struct Distinct {
    pub(crate) values: Vec<f64>,
    /// Powers of each at the nodes of its exponent.
    pub(crate) powers: Vec<[f64; NODES]>,
    /// Which of them each kept row of the last part has.
    index: Vec<u16>,
    /// How many there were before that part.
    before: usize,
    /// Index plus 1 by hash, 0 where empty; at most half full.
    slots: Vec<u16>,
}

impl Distinct {
    fn new() -> Self {
        Self {
            values: Vec::new(),
            powers: Vec::new(),
            index: Vec::new(),
            before: 0,
            slots: vec![0; 2 * DISTINCT],
        }
    }

    /// Takes the kept values of a part, over `largest`, up to the row before which there is no place left; returns that
    /// row.
    fn take(&mut self, values: &[f64], keep: &[bool], largest: f64, nodes: &Nodes) -> usize {
        self.before = self.values.len();
        self.index.clear();
        for (row, (value, keep)) in values.iter().zip(keep).enumerate() {
            if self.values.len() == DISTINCT {
                return row;
            }
            if *keep {
                let place = self.place(value / largest);
                if usize::from(place) == self.powers.len() {
                    self.powers.push(nodes.powers(value / largest));
                }
                self.index.push(place);
            }
        }
        values.len()
    }

    /// Leaves the first kept rows of the part and what is distinct up to them; nothing is taken after that.
    fn leave(&mut self, rows: usize) {
        if rows < self.index.len() {
            self.index.truncate(rows);
            let last = self.index.iter().max();
            let distinct = last.map_or(0, |last| usize::from(*last) + 1);
            self.values.truncate(distinct.max(self.before));
            self.powers.truncate(distinct.max(self.before));
        }
    }

    #[inline]
    fn place(&mut self, value: f64) -> u16 {
        let mask = self.slots.len() - 1;
        let mut slot = hash(value, DISTINCT_BITS + 1);
        loop {
            let found = self.slots[slot];
            if found == 0 {
                self.values.push(value);
                let count = u16::try_from(self.values.len()).unwrap_or(u16::MAX);
                self.slots[slot] = count;
                return count - 1;
            }
            if self.values[usize::from(found) - 1] == value {
                return found - 1;
            }
            slot = (slot + 1) & mask;
        }
    }
}

/// Fibonacci hashing to `2^bits` places: the high bits of the product mix all bits of the value.
#[inline]
pub(crate) fn hash(value: f64, bits: u32) -> usize {
    let mixed = value.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15);
    usize::try_from(mixed >> (64 - bits)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_distinct_value_has_one_place_up_to_the_last() {
        let mut distinct = Distinct::new();
        let value = |i: usize| (i as f64).sqrt() * 1e-3;
        for i in 0..DISTINCT {
            assert_eq!(usize::from(distinct.place(value(i))), i);
        }
        for i in (0..DISTINCT).rev() {
            assert_eq!(usize::from(distinct.place(value(i))), i);
        }
        assert_eq!(distinct.values.len(), DISTINCT);
    }

    #[test]
    fn what_lies_behind_the_last_place_of_either_is_left() {
        const ROWS: usize = DISTINCT + 50;
        let all: Vec<f64> = (0..ROWS).map(|i| 1.0 + i as f64).collect();
        let halves: Vec<f64> = (0..ROWS).map(|i| 1.0 + (i / 2) as f64).collect();
        let (head_m, keep) = (vec![1.0; ROWS], vec![true; ROWS]);
        let nodes = Nodes::over(&(1.0..=3.0));
        for (speed_pct, flow_m3_s) in [(&all, &halves), (&halves, &all)] {
            let part = Samples {
                speed_pct,
                flow_m3_s,
                head_m: &head_m,
                keep: &keep,
            };
            let mut pass = Pass::new();
            let largest = (speed_pct[ROWS - 1], flow_m3_s[ROWS - 1]);
            assert_eq!(pass.take(&part, largest, (&nodes, &nodes)), DISTINCT);
            let mut distinct =
                [&pass.speeds, &pass.flows].map(|d| (d.values.len(), d.powers.len()));
            distinct.sort_unstable();
            assert_eq!(distinct, [DISTINCT / 2, DISTINCT].map(|n| (n, n)));
            for groups in [&pass.groups.at_speed, &pass.groups.at_flow] {
                assert!(groups.iter().all(|group| group.rows > 0.0));
            }
        }
    }
}
