//! Where something that sets in, or passes, would explain most.

use super::Candidate;
use crate::layout::{BALANCE_BLOCKS, Section};
use crate::numbers::whole;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::tangent::Tangent;
use dgd_effects::Effect;
use std::ops::Range;

/// Switching times, to the block, at which a switch would explain most: peaks of the running sum of its score. Of what rises and falls, or
/// mixes, they are where a switch in its place would.
///
/// The wander of instruments leaves a step's evidence in the minutes about it, which a coarse grid passes over.
pub(crate) fn switches(
    record: &Record,
    tangent: &Tangent,
    pull: &[f64],
    state: &[Applied],
    effect: &'static dyn Effect,
    coarse: &[Candidate],
) -> Vec<Vec<f64>> {
    let about = effect.about();
    let (Some(onset), duration) = (about.onset(), about.duration()) else {
        return Vec::new();
    };
    let n = tangent.layout.blocks;
    let seconds = record.block_s();
    let blocks = |time_s: f64| whole(time_s / seconds).max(1);
    let time = |b: usize| record.setting.span_s.0 + b as f64 * seconds;
    let edge = whole(0.02 * n as f64).min(blocks(EDGE_S));
    let mut out = Vec::new();
    for shape in everlasting(record, coarse, onset, duration) {
        let one = Applied::new(effect, shape.clone());
        let change = tangent.change(record, &joined(state, &one));
        let tail = running_score(tangent, &change, pull, shape[0]);
        let same = |c: &&Candidate| {
            c.applied
                .parameters
                .iter()
                .enumerate()
                .all(|(k, v)| k == onset || Some(k) == duration || *v == shape[k])
        };
        let energies = Energies::of(coarse.iter().filter(same), onset, duration);
        let one_sided = about.parameters[0].low >= 0.0;
        let mut peaks = Peaks::new(blocks(APART_S));
        let mut offer = |score: f64, energy: f64, from: usize, to: usize| {
            if !(one_sided && score * shape[0] <= 0.0) && energy > 0.0 {
                peaks.offer(score * score / energy, from, to);
            }
        };
        if duration.is_some() {
            // What otherwise stays may last for as long.
            let longest = if effect.lasting().is_some() {
                n
            } else {
                blocks(PASSES_S.end)
            };
            let lasts = blocks(PASSES_S.start)..longest;
            let cell = 2 * (n / 600).clamp(1, blocks(HALF_S));
            for (from, to) in spans(&tail[..n], edge..n - edge, cell, &lasts) {
                let energy = energies.nearest(time(from), (to - from) as f64 * seconds);
                offer(tail[from] - tail[to], energy, from, to);
            }
        } else {
            for from in edge..n - edge {
                offer(tail[from], energies.nearest(time(from), 0.0), from, n);
            }
        }
        for (from, to) in peaks.highest() {
            let mut p = shape.clone();
            p[onset] = time(from);
            if let Some(d) = duration {
                p[d] = (to - from) as f64 * seconds;
            }
            out.push(p);
        }
    }
    out
}

/// What passes as two that are over for `over_s` and more in between, where that would explain more; each on its own. `None` if nowhere.
pub(crate) fn gap(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    one: &Applied,
    over_s: f64,
) -> Option<[Applied; 2]> {
    let about = one.effect.about();
    let (onset, duration) = (about.onset()?, about.duration()?);
    let seconds = record.block_s();
    let (from, to) = about.interval_s(&one.parameters, record.setting.span_s);
    let block = |time_s: f64| {
        let after = (time_s - record.setting.span_s.0) / seconds;
        whole(after.round()).min(tangent.layout.blocks)
    };
    let change = tangent.change(record, &joined(state, one));
    let tail = running_score(tangent, &change, &tangent.pull(), 1.0);
    let (first, last) = (block(from), block(to));
    // At its best strength half of its score is its energy, which is taken to be spread evenly.
    let cost = 0.5 * (tail[first] - tail[last]) / (last - first).max(1) as f64;
    let least = whole(about.parameters[duration].low / seconds).max(1);
    // The stretch without which most is explained, by Kadane's algorithm.
    let (mut sum, mut begins) = (0.0, first + least);
    let mut best = (0.0, 0, 0);
    for b in first + least..last.saturating_sub(least) {
        if sum <= 0.0 {
            (sum, begins) = (0.0, b);
        }
        sum += cost - (tail[b] - tail[b + 1]);
        if sum > best.0 {
            best = (sum, begins, b + 1);
        }
    }
    let (_, over, again) = best;
    let time = |b: usize| record.setting.span_s.0 + b as f64 * seconds;
    let part = |from: f64, to: f64| {
        let mut part = one.clone();
        part.parameters[onset] = from;
        part.parameters[duration] = to - from;
        part
    };
    (time(again) - time(over) >= over_s).then(|| [part(from, time(over)), part(time(again), to)])
}

/// By how much the ends of two intervals differ at least, s, or they are the same end.
const APART_S: f64 = 300.0;

/// How near to the ends of the recording nothing begins, s: two hundredths of it, if that is less.
const EDGE_S: f64 = 600.0;

/// How long what passes may last, s, where it is proposed.
const PASSES_S: Range<f64> = 1200.0..6000.0;

/// Half of how long stretches are at the most, s, within which something that passes begins or ends.
const HALF_S: f64 = 240.0;

/// Where a running sum is lowest and highest within a stretch: whatever passes, and explains most of what begins in one stretch and ends in another,
/// begins and ends there.
struct Extremes {
    lowest: usize,
    highest: usize,
}

impl Extremes {
    /// Those of stretches of so many blocks, from some block on.
    fn of(sum: &[f64], from: usize, blocks: usize) -> Vec<Self> {
        let higher = |a: &usize, b: &usize| sum[*a].total_cmp(&sum[*b]);
        let stretch = |start: usize| {
            let all = start..(start + blocks).min(sum.len());
            Self {
                lowest: all.clone().min_by(higher).unwrap_or(start),
                highest: all.max_by(higher).unwrap_or(start),
            }
        };
        (from..sum.len()).step_by(blocks).map(stretch).collect()
    }
}

/// Beginnings within some blocks, and ends, between which a running sum differs most for the stretches they lie in; in the order of the beginnings.
fn spans(
    sum: &[f64],
    begins: Range<usize>,
    blocks: usize,
    lasts: &Range<usize>,
) -> Vec<(usize, usize)> {
    let cells = Extremes::of(sum, begins.start, blocks);
    let mut out = Vec::new();
    for (k, cell) in cells.iter().enumerate() {
        let mut froms = [(cell.lowest, false), (cell.highest, true)];
        froms.sort_unstable();
        for (from, falls) in froms.into_iter().filter(|(from, _)| begins.contains(from)) {
            let to = |cell: &Extremes| if falls { cell.lowest } else { cell.highest };
            let as_long = |to: &usize| *to > from && lasts.contains(&(to - from));
            let ends = cells[k..].iter().map(to).filter(as_long);
            out.extend(ends.map(|to| (from, to)));
        }
    }
    out
}

/// Energies of a unit of strength on a grid of onsets and durations, in the order of onsets.
pub(super) struct Energies(Vec<(f64, Vec<(f64, f64)>)>);

impl Energies {
    pub(super) fn of<'c>(
        coarse: impl Iterator<Item = &'c Candidate>,
        onset: usize,
        duration: Option<usize>,
    ) -> Self {
        let mut out: Vec<(f64, Vec<(f64, f64)>)> = Vec::new();
        for c in coarse {
            let p = &c.applied.parameters;
            let lasts = (duration.map_or(0.0, |k| p[k]), c.energy);
            match out.iter_mut().find(|(at, _)| *at == p[onset]) {
                Some((_, of)) => of.push(lasts),
                None => out.push((p[onset], vec![lasts])),
            }
        }
        out.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(out)
    }

    /// That of the nearest onset, and of its durations the nearest; infinite where there is none.
    pub(super) fn nearest(&self, onset_s: f64, lasts_s: f64) -> f64 {
        let after = self.0.partition_point(|(at, _)| *at < onset_s);
        let beside = &self.0[after.saturating_sub(1)..(after + 1).min(self.0.len())];
        let onset =
            (beside.iter()).min_by(|a, b| (a.0 - onset_s).abs().total_cmp(&(b.0 - onset_s).abs()));
        let durations = onset.map_or(&[][..], |(_, durations)| durations);
        (durations.iter())
            .min_by(|a, b| (a.0 - lasts_s).abs().total_cmp(&(b.0 - lasts_s).abs()))
            .map_or(f64::INFINITY, |(_, energy)| *energy)
    }
}

/// The shapes that were tried, each from before the recording to beyond it.
fn everlasting(
    record: &Record,
    coarse: &[Candidate],
    onset: usize,
    duration: Option<usize>,
) -> Vec<Vec<f64>> {
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for c in coarse {
        let mut p = c.applied.parameters.clone();
        p[onset] = record.setting.span_s.0 - 1e6;
        if let Some(d) = duration {
            // In the middle of what lasts for ever.
            p[d] = 1e9;
            p[onset] -= 0.5 * p[d];
        }
        if !shapes.contains(&p) {
            shapes.push(p);
        }
    }
    shapes
}

/// The score of what a strength changes, by its unit, from each block to the end.
fn running_score(tangent: &Tangent, change: &[f64], pull: &[f64], strength: f64) -> Vec<f64> {
    let layout = tangent.layout;
    let n = layout.blocks;
    let product = |row: usize| {
        let v = change[row] * pull[row];
        if v.is_finite() { v } else { 0.0 }
    };
    let [outlets, balance] = [Section::Outlets, Section::Balance].map(|s| layout.rows(s));
    let mut tail = vec![0.0; n + 1];
    for b in (0..n).rev() {
        let mut here = product(b) + product(n + b);
        if !outlets.is_empty() {
            here += product(outlets.start + b);
        }
        let k = b / BALANCE_BLOCKS;
        if k < balance.len() {
            here += product(balance.start + k) / BALANCE_BLOCKS as f64;
        }
        tail[b] = tail[b + 1] + here / strength;
    }
    tail
}

/// The highest of what is offered, of those with both ends near each other.
struct Peaks {
    /// What each explains, and its first and last block.
    found: Vec<(f64, usize, usize)>,
    /// How many of them lie so far back that no other is near.
    passed: usize,
    /// Blocks between ends that are not near.
    apart: usize,
}

impl Peaks {
    fn new(apart: usize) -> Self {
        Self {
            found: Vec::new(),
            passed: 0,
            apart,
        }
    }

    /// Offered in the order of their beginnings.
    fn offer(&mut self, explains: f64, from: usize, to: usize) {
        let apart = self.apart;
        while (self.found.get(self.passed)).is_some_and(|p| p.1 + apart <= from) {
            self.passed += 1;
        }
        let near =
            |p: &&mut (f64, usize, usize)| p.1.abs_diff(from) < apart && p.2.abs_diff(to) < apart;
        match self.found[self.passed..].iter_mut().find(near) {
            Some(p) if p.0 < explains => *p = (explains, from, to),
            Some(_) => {}
            None => self.found.push((explains, from, to)),
        }
    }

    fn highest(self) -> Vec<(usize, usize)> {
        highest(self.found, self.apart)
    }
}

/// Beginnings and ends of the highest peaks, and of the highest of which no two have an end in common: on rough sums what explains most may
/// stand behind several that begin or end alike.
pub(super) fn highest(mut peaks: Vec<(f64, usize, usize)>, apart: usize) -> Vec<(usize, usize)> {
    const MOST: usize = 3;
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let near = |a: usize, b: usize| a.abs_diff(b) < apart;
    let mut unlike: Vec<(usize, usize)> = Vec::new();
    for (_, from, to) in &peaks {
        // What never ends shares its end with all.
        let alike = |o: &(usize, usize)| near(o.0, *from) || near(o.1, *to);
        if unlike.len() < MOST && !unlike.iter().any(alike) {
            unlike.push((*from, *to));
        }
    }
    peaks.truncate(MOST);
    let mut out: Vec<(usize, usize)> = peaks.iter().map(|p| (p.1, p.2)).collect();
    unlike.retain(|one| !out.contains(one));
    out.extend(unlike);
    out
}
