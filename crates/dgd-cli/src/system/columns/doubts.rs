//! What a recording leaves in doubt before a system is held against it.

use super::Files;
use crate::say::{counted, number};
use crate::system::{Gauge, at_default, gauges, property};
use dgd_assembly::{Portion, Window};
use dgd_units::Dimension;

/// A step of the clock this many times the usual one is a gap.
const GAP: f64 = 5.0;

/// Samples from which on one value throughout is no chance, and a step is a usual one.
const FEWEST: usize = 20;

/// What is wrong with the samples of the windows, and lived with: each in a sentence.
pub(super) fn of(files: &Files<'_>, train: &[Window], test: &[Window]) -> Vec<String> {
    let mut doubts = Vec::new();
    let layout = &files.assembly.system().record;
    if layout.time.is_some() && layout.step.is_some() {
        doubts.push("`step` under [record] is ignored: the samples have times".to_owned());
    }
    if files.assembly.system().independent == "time" {
        doubts.extend(gaps(files, "record.train", train));
        doubts.extend(gaps(files, "record.test", test));
    }
    doubts.extend(missing(files));
    doubts.extend(beyond(files, train, test));
    doubts.extend(unused(files));
    doubts.extend(dead(files, train));
    doubts.extend(silent(files, train));
    doubts.extend(frozen(files, train));
    doubts.extend(overlap(files, train, test));
    doubts
}

/// Inputs without a value in some samples after their first; one that has none in most is logged now and then, as it should be.
fn missing(files: &Files<'_>) -> Vec<String> {
    /// Share of the samples beyond which an input is taken for one that is logged now and then.
    const SELDOM: f64 = 0.5;
    let mut told: Vec<&str> = Vec::new();
    let mut doubts = Vec::new();
    for portion in [Portion::Train, Portion::Test] {
        for (path, input) in &files.assembly.system().inputs {
            let tag = files.stands_for(portion, &input.channel);
            let Some(column) = files.table.column(tag).filter(|_| !told.contains(&tag)) else {
                continue;
            };
            told.push(tag);
            let late = column.values.iter().take_while(|v| !v.is_finite()).count();
            let after = column.values.iter().skip_while(|v| !v.is_finite());
            let missing = after.filter(|v| !v.is_finite()).count();
            #[expect(clippy::cast_precision_loss, reason = "sample counts")]
            let share = missing as f64 / column.values.len() as f64;
            // Windows begin where they say.
            let anywhere = files.assembly.system().record.train.windows.is_empty();
            if anywhere && late > 0 && share < SELDOM && late < column.values.len() {
                doubts.push(format!(
                    "`{tag}`, the input `{path}`, has no value in the first {}: runs begin after",
                    counted(late, "sample")
                ));
            }
            if missing > 0 && share < SELDOM {
                doubts.push(format!(
                    "`{tag}`, the input `{path}`, has no value in {} of the recording: the last one is held",
                    counted(missing, "sample")
                ));
            }
        }
    }
    doubts
}

/// Inputs that leave what their property may be: per cent that were read as shares, above all.
fn beyond(files: &Files<'_>, train: &[Window], test: &[Window]) -> Vec<String> {
    /// Share of the range by which a transmitter may be off at its ends.
    const SLACK: f64 = 0.05;
    let assembly = files.assembly;
    let one = |(k, path): (usize, &String)| {
        let property = property(assembly.system(), path)?;
        let slack = SLACK * (property.high - property.low);
        if !slack.is_finite() {
            return None;
        }
        let windows = train.iter().chain(test);
        let values = windows.filter_map(|w| w.inputs.get(k)).flatten();
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(*v), high.max(*v))
        });
        let input = assembly.system().inputs.get(path)?;
        let tag = files.stands_for(Portion::Train, &input.channel);
        let bare = input.unit.as_deref().is_none_or(|unit| unit == "1");
        let share = property.dimension == Some(Dimension::Number) && property.high == 1.0;
        if high > property.high + slack {
            let mend = if share && bare {
                "did you mean `unit = \"%\"`?".to_owned()
            } else {
                format!("expected {}", property.range())
            };
            let (high, most) = (number(high), number(property.high));
            return Some(format!(
                "`{tag}`, the input `{path}`, reaches {high}, above {most}: {mend}"
            ));
        }
        (low < property.low - slack).then(|| {
            let (low, range) = (number(low), property.range());
            format!("`{tag}`, the input `{path}`, falls to {low}, expected {range}")
        })
    };
    assembly
        .inputs()
        .iter()
        .enumerate()
        .filter_map(one)
        .collect()
}

/// Columns that nothing uses, where an opening stands at its default: it may be among them.
fn unused(files: &Files<'_>) -> Option<String> {
    const SHOWN: usize = 8;
    let system = files.assembly.system();
    let open = at_default(system);
    let layout = &system.record;
    let channels = system.inputs.values().map(|i| i.channel.clone());
    let channels = channels.chain(gauges(files.assembly).into_iter().map(|g| g.channel));
    let mut used: Vec<&str> = layout.time.iter().map(String::as_str).collect();
    let channels: Vec<String> = channels.collect();
    for portion in [Portion::Train, Portion::Test] {
        used.extend(channels.iter().map(|c| files.stands_for(portion, c)));
    }
    let found: Vec<usize> = (used.iter())
        .filter_map(|tag| files.table.column(tag))
        .filter_map(|c| files.table.columns.iter().position(|d| d.tag == c.tag))
        .collect();
    let rest = (files.table.columns.iter().enumerate())
        .filter(|(k, _)| !found.contains(k) && files.table.clock != Some(*k));
    let mut rest: Vec<&str> = rest.map(|(_, c)| c.tag.as_str()).collect();
    if open.is_empty() || rest.is_empty() {
        return None;
    }
    let more = rest.len().saturating_sub(SHOWN);
    rest.truncate(SHOWN);
    let more = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    let stand = if open.len() == 1 { "stands" } else { "stand" };
    Some(format!(
        "{} {stand} fully open, as by default, and nothing uses the columns {}{more}: what was recorded belongs under [inputs]",
        open.iter()
            .map(|path| format!("`{path}`"))
            .collect::<Vec<_>>()
            .join(", "),
        rest.join(", ")
    ))
}

/// The unit of the record's clock.
fn unit<'a>(files: &'a Files<'_>) -> &'a str {
    let layout = &files.assembly.system().record;
    layout.unit.as_deref().unwrap_or("s")
}

/// A time of a window in that unit, to the thousandth.
fn told_time(files: &Files<'_>, t: f64) -> f64 {
    (t / files.assembly.tick_s() * 1e3).round() / 1e3
}

/// Where the clock of a window skips: the longest of its gaps, in the unit of the record.
fn gaps(files: &Files<'_>, part: &str, windows: &[Window]) -> Vec<String> {
    let unit = unit(files);
    let one = |window: &Window| {
        let mut steps: Vec<f64> = window.time.windows(2).map(|w| w[1] - w[0]).collect();
        // Nearly the longest: clocks that jitter or are merged have short steps in between.
        let usual = steps.len() * 19 / 20;
        let usual = *steps.select_nth_unstable_by(usual, f64::total_cmp).1;
        let wide = |w: &&[f64]| w[1] - w[0] > GAP * usual;
        let gaps = window.time.windows(2).filter(wide);
        let number = gaps.clone().count();
        let longest = gaps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
        let more = match number - 1 {
            0 => String::new(),
            n => format!(", and {}", counted(n, "shorter gap")),
        };
        let [from, to] = [longest[0], longest[1]].map(|t| told_time(files, t));
        Some(format!(
            "{part} has no samples from {from} to {to} {unit}{more}: the inputs are unknown there; give it windows before and after"
        ))
    };
    let long = windows.iter().filter(|w| w.time.len() > FEWEST);
    long.filter_map(one).collect()
}

/// Whether there are instruments, and none of them moves in what is fitted.
pub(super) fn all_dead(files: &Files<'_>, train: &[Window]) -> bool {
    let all = gauges(files.assembly).len();
    let read = |o: usize| {
        let mut readings = train.iter().filter_map(|w| w.readings.get(o)).flatten();
        readings.any(|v| v.is_finite())
    };
    let read = (0..all).filter(|o| read(*o)).count();
    read > 0 && dead(files, train).len() == read
}

/// Instruments that never move in what is fitted.
fn dead(files: &Files<'_>, train: &[Window]) -> Vec<String> {
    let one = |(o, gauge): (usize, &Gauge)| {
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
                "`{}` reads {} in all {all} fitted samples: it says only that the system does not move",
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

/// Instruments whose column has next to no reading in what is fitted.
fn silent(files: &Files<'_>, train: &[Window]) -> Vec<String> {
    /// Share of the samples below which it may as well not have been recorded.
    const HARDLY: f64 = 0.1;
    let all: usize = train.iter().map(|w| w.time.len()).sum();
    let one = |(o, gauge): (usize, &Gauge)| {
        let tag = files.stands_for(Portion::Train, &gauge.channel);
        files.table.column(tag)?;
        let readings = train.iter().filter_map(|w| w.readings.get(o)).flatten();
        let read = readings.filter(|v| v.is_finite()).count();
        #[expect(clippy::cast_precision_loss, reason = "sample counts")]
        let hardly = (read as f64) < HARDLY * all as f64;
        hardly.then(|| match read {
            0 => format!(
                "`{tag}` has no reading in the fitted part: `{}` says nothing there",
                gauge.name
            ),
            _ => format!(
                "`{tag}` has {} in {} of the fitted part",
                counted(read, "reading"),
                counted(all, "sample")
            ),
        })
    };
    (gauges(files.assembly).iter().enumerate())
        .filter_map(one)
        .collect()
}

/// Instruments that repeat one value far longer than they usually do: the longest run of each.
fn frozen(files: &Files<'_>, train: &[Window]) -> Vec<String> {
    /// Samples that a value is repeated for at the least, and how many times as often as usual.
    const LONG: usize = 60;
    const TIMES: usize = 20;
    let unit = unit(files);
    let one = |(o, gauge): (usize, &Gauge)| {
        let mut runs: Vec<(usize, f64, f64, f64)> = Vec::new();
        for window in train {
            let mut last = f64::NAN;
            let readings = window.readings.get(o).into_iter().flatten();
            for (v, t) in readings.zip(&window.time).filter(|(v, _)| v.is_finite()) {
                match runs.last_mut().filter(|_| *v == last) {
                    Some((length, _, to, _)) => (*length, *to) = (*length + 1, *t),
                    None => runs.push((1, *t, *t, *v)),
                }
                last = *v;
            }
        }
        let longest = runs.iter().copied().max_by_key(|run| run.0)?;
        let mut lengths: Vec<usize> = runs.iter().map(|run| run.0).collect();
        let usual = *lengths.select_nth_unstable(runs.len() * 9 / 10).1;
        let (length, from, to, value) = longest;
        // One that never moves is told apart.
        (runs.len() > 1 && length >= LONG.max(TIMES * usual)).then(|| {
            let [from, to] = [from, to].map(|t| told_time(files, t));
            let value = gauge.with_unit(&number(gauge.shown(value)));
            format!(
                "`{}` repeats {value} from {from} to {to} {unit}: if it was stuck, give record.train windows without that",
                gauge.name
            )
        })
    };
    (gauges(files.assembly).iter().enumerate())
        .filter_map(one)
        .collect()
}

/// Held-out samples that are fitted too; a shared end is none.
fn overlap(files: &Files<'_>, train: &[Window], test: &[Window]) -> Option<String> {
    let assembly = files.assembly;
    assembly.system().record.test.as_ref()?;
    let inputs = assembly.system().inputs.values().map(|i| i.channel.clone());
    let mut channels = inputs.chain(gauges(assembly).into_iter().map(|g| g.channel));
    // Other columns are another run.
    if channels.any(|c| files.stands_for(Portion::Train, &c) != files.stands_for(Portion::Test, &c))
    {
        return None;
    }
    let ends = |w: &Window| {
        let low = w.time.iter().copied().fold(f64::INFINITY, f64::min);
        let high = w.time.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low, high)
    };
    let fitted: Vec<(f64, f64)> = train.iter().map(ends).collect();
    let both = (test.iter().flat_map(|w| &w.time))
        .filter(|t| fitted.iter().any(|(low, high)| low <= t && *t <= high))
        .count();
    (both > train.len() + test.len()).then(|| {
        format!(
            "record.test contains {} that record.train also contains: those are not held out",
            counted(both, "sample")
        )
    })
}
