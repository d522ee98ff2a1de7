//! What a recording leaves in doubt before a system is held against it.

use super::{Files, stands_for};
use crate::say::{counted, number};
use crate::system::gauges;
use dgd_assembly::Window;

/// A step of the clock this many times the usual one is a gap.
const GAP: f64 = 5.0;

/// What is wrong with the samples of the windows, and lived with: each in a sentence.
pub(super) fn of(files: &Files<'_>, train: &[Window], test: &[Window]) -> Vec<String> {
    let mut doubts = Vec::new();
    let layout = &files.assembly.system().record;
    if layout.time.is_some() && layout.step.is_some() {
        doubts.push("`step` under [record] does not count: the samples have times".to_owned());
    }
    if files.assembly.system().independent == "time" {
        doubts.extend(gaps("record.train", train));
        doubts.extend(gaps("record.test", test));
    }
    let mut told: Vec<&str> = Vec::new();
    for part in std::iter::once(&layout.train).chain(&layout.test) {
        for (path, input) in &files.assembly.system().inputs {
            let tag = stands_for(part, &input.channel);
            let missing = files.table.column(tag).map_or(0, |column| {
                column.values.iter().filter(|v| !v.is_finite()).count()
            });
            if missing > 0 && !told.contains(&tag) {
                told.push(tag);
                doubts.push(format!(
                    "`{tag}`, the input `{path}`, has no value in {} of the recording: the last one is held",
                    counted(missing, "sample")
                ));
            }
        }
    }
    doubts.extend(dead(files, train));
    doubts.extend(overlap(files, train, test));
    doubts
}

/// Where the clock of a window skips: inputs are held over it.
fn gaps(part: &str, windows: &[Window]) -> Vec<String> {
    let one = |window: &Window| {
        let mut steps: Vec<f64> = window.time.windows(2).map(|w| w[1] - w[0]).collect();
        let middle = steps.len() / 2;
        let usual = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        let wide = |w: &&[f64]| w[1] - w[0] > GAP * usual;
        let mut gaps = window.time.windows(2).filter(wide);
        let first = gaps.next()?;
        let more = match gaps.count() {
            0 => String::new(),
            n => format!(", and {n} times more"),
        };
        Some(format!(
            "{part} has no samples from {} to {} s{more}: inputs are held over that; give it windows before and after",
            number(first[0]),
            number(first[1])
        ))
    };
    windows
        .iter()
        .filter(|w| w.time.len() > 2)
        .filter_map(one)
        .collect()
}

/// Whether there are instruments, and none of them moves in what is fitted.
pub(super) fn all_dead(files: &Files<'_>, train: &[Window]) -> bool {
    let all = gauges(files.assembly).len();
    let read = |o: usize| {
        train
            .iter()
            .any(|w| w.readings.get(o).is_some_and(|r| !r.is_empty()))
    };
    let read = (0..all).filter(|o| read(*o)).count();
    read > 0 && dead(files, train).len() == read
}

/// Instruments that never move in what is fitted.
fn dead(files: &Files<'_>, train: &[Window]) -> Vec<String> {
    /// Readings from which on one value throughout is no chance.
    const FEWEST: usize = 20;
    let one = |(o, gauge): (usize, &crate::system::Gauge)| {
        let mut read = train
            .iter()
            .filter_map(|w| w.readings.get(o))
            .flatten()
            .filter(|v| v.is_finite());
        let first = *read.next()?;
        let mut all = 1;
        for value in read {
            if *value != first {
                return None;
            }
            all += 1;
        }
        (all >= FEWEST).then(|| {
            format!(
                "`{}` reads {} in all {all} samples that are fitted: what it says of the system is that it does not move",
                gauge.name,
                gauge.with_unit(&number(gauge.shown(first)))
            )
        })
    };
    gauges(files.assembly)
        .iter()
        .enumerate()
        .filter_map(one)
        .collect()
}

/// Held-out samples that are fitted too.
fn overlap(files: &Files<'_>, train: &[Window], test: &[Window]) -> Option<String> {
    let layout = &files.assembly.system().record;
    let same = |part: &dgd_assembly::PartLayout| {
        part.channels.is_empty() || part.channels == layout.train.channels
    };
    if !layout.test.as_ref().is_some_and(same) {
        return None;
    }
    let fitted = |t: &f64| {
        train.iter().any(|w| {
            w.time.first().is_some_and(|a| a <= t) && w.time.last().is_some_and(|b| t <= b)
        })
    };
    let both = test
        .iter()
        .flat_map(|w| &w.time)
        .filter(|t| fitted(t))
        .count();
    (both > 0).then(|| {
        format!(
            "record.test holds {} that record.train holds too: those are not held out",
            counted(both, "sample")
        )
    })
}
