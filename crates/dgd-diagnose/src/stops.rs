//! Stops of the pump, after which the meter of the return flow shows what lies between the line and it.
//!
//! The check valve shuts the line within a second or two: from then on the meter's reading is the answer of its path to that one step, whatever the
//! curves are. Behind a delay it stays up and drops at once, behind a store it fades. In rows of blocks the two hardly differ.

use crate::numbers::{mean, whole};
use dgd_effects::{MeterPath, STANDING_M3_S, STANDING_PCT};
use std::ops::Range;

/// How long the pump turns before, and stands after a stop that tells, s.
const TURNS_S: f64 = 20.0;
const STANDS_S: f64 = 20.0;
/// How long a stop is looked at, s.
const LOOK_S: f64 = 90.0;
/// Readings further apart than this, s, tell no edge.
const SLOWEST_STEP_S: f64 = 5.0;
/// Share of the outlet's fall that may be left after [`SOON_S`]: where more is, the pump runs down or the line flows on.
const LEFT: f64 = 0.2;
/// When the outlet must have fallen, from and to s after the first sample at rest; it may swing below where it stays.
const SOON_S: (f64, f64) = (1.5, 4.5);
/// Time before the stop, and after it, over which the outlet's fall is measured, s.
const BEFORE_S: f64 = 5.0;
const AFTER_S: (f64, f64) = (10.0, 20.0);
/// How many times [`STANDING_M3_S`] flows at the least.
const FLOWS: f64 = 5.0;
/// What the flow before may be off by where it is taken for a straight line, as a share of it. Set by hand.
const OFF: f64 = 0.05;
/// Squares that one stop adds at the most: a reading that freezes as the pump stops is one accident, and no path. Set by hand.
const MOST: f64 = 120.0;
/// Dampings of a sound meter, s, and the width that is expected of them.
const DAMPINGS_S: [f64; 5] = [0.0, 0.5, 1.0, 1.5, 2.0];
const DAMPING_S: f64 = 1.0;
/// Shares of a step by which the pump had stopped before the first sample at rest.
const SOONER: [f64; 3] = [0.0, 0.5, 1.0];
/// Stops that are looked at, spread over a recording that has more.
const ENOUGH: usize = 40;

/// Readings of a recording at every step.
pub(crate) struct Readings<'a> {
    pub step_s: f64,
    pub speed_pct: &'a [f64],
    pub flow_m3_s: &'a [f64],
    pub outlet_pa: &'a [f64],
    /// Deviation of the flow's noise, m³/s.
    pub noise_m3_s: f64,
    /// Samples in a block.
    pub per_block: usize,
}

/// One stop: what its meter read, in standard deviations of what is known of it.
#[derive(Debug, Clone)]
pub(crate) struct Stop {
    /// The blocks that it is about.
    pub blocks: Range<usize>,
    step_s: f64,
    /// From the first sample at rest on; NaN where none is told.
    read: Vec<f64>,
    /// The straight line of the readings before: where it is at that sample, and what it rises by a second.
    level: f64,
    rise: f64,
}

/// The stops of a recording that tell the path of the meter.
pub(crate) fn stops(readings: &Readings<'_>) -> Vec<Stop> {
    let speed = readings.speed_pct;
    if !(readings.step_s > 0.0 && readings.step_s <= SLOWEST_STEP_S) {
        return Vec::new();
    }
    let edges = (1..speed.len()).filter(|&i| speed[i] <= STANDING_PCT && turns(speed[i - 1]));
    let all: Vec<Stop> = edges.filter_map(|i| Stop::at(readings, i)).collect();
    let n = all.len();
    if n <= ENOUGH {
        return all;
    }
    (0..ENOUGH).map(|k| all[k * n / ENOUGH].clone()).collect()
}

fn turns(speed_pct: f64) -> bool {
    speed_pct > STANDING_PCT
}

impl Stop {
    /// The stop whose first sample at rest is `i`; `None` where it does not tell.
    fn at(r: &Readings<'_>, i: usize) -> Option<Self> {
        let samples = |seconds: f64| whole((seconds / r.step_s).round()).max(3);
        let stands = |k: &usize| r.speed_pct.get(*k).is_some_and(|w| *w <= STANDING_PCT);
        let turned = i.checked_sub(samples(TURNS_S))?..i;
        let stood = i..i + (i..i + samples(LOOK_S)).take_while(stands).count();
        let lasts = stood.len() >= samples(STANDS_S);
        if !lasts || !r.speed_pct[turned.clone()].iter().all(|w| turns(*w)) || !falls_at_once(r, i)
        {
            return None;
        }
        let (before, after) = (&r.flow_m3_s[turned.clone()], &r.flow_m3_s[stood.clone()]);
        if !is_told(before) || !is_told(&after[..samples(STANDS_S)]) {
            return None;
        }
        let (level, rise) = line(before, r.step_s)?;
        if level < FLOWS * STANDING_M3_S {
            return None;
        }
        let sd = r.noise_m3_s.hypot(OFF * level);
        Some(Self {
            blocks: turned.start / r.per_block..(stood.end - 1) / r.per_block + 1,
            step_s: r.step_s,
            read: after.iter().map(|q| q / sd).collect(),
            level: level / sd,
            rise: rise / sd,
        })
    }

    /// What a path leaves over of each reading, the pump having stopped so long before the first sample at rest.
    fn left(&self, path: MeterPath, damping_s: f64, sooner_s: f64) -> impl Iterator<Item = f64> {
        let mut fade = Fade::behind(path.lag_s, damping_s, self.step_s);
        self.read.iter().enumerate().map(move |(k, read)| {
            let since_s = k as f64 * self.step_s + sooner_s;
            let still_up = self.level + self.rise * since_s.min(path.delay_s);
            let left = read - still_up * fade.share_left(since_s - path.delay_s);
            if left.is_finite() { left } else { 0.0 }
        })
    }

    /// The squares that it adds, and how much sooner the pump had stopped, s.
    fn squares(&self, path: MeterPath, damping_s: f64) -> (f64, f64) {
        let tried = SOONER.map(|share| {
            let sooner_s = share * self.step_s;
            let left = self.left(path, damping_s, sooner_s);
            (left.map(|v| v * v).sum::<f64>(), sooner_s)
        });
        (tried.into_iter())
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((0.0, 0.0))
    }
}

/// Whether most of some readings are there.
fn is_told(readings: &[f64]) -> bool {
    /// Set by hand.
    const SHARE: f64 = 0.7;
    let told = readings.iter().filter(|v| v.is_finite()).count();
    told as f64 >= SHARE * readings.len() as f64
}

/// Whether the outlet has fallen soon after a stop to where it stays.
fn falls_at_once(r: &Readings<'_>, i: usize) -> bool {
    let samples = |seconds: f64| whole((seconds / r.step_s).ceil());
    // NaN, which is less than nothing, where none is told.
    let outlet = |(from, to): (usize, usize)| {
        let within = r.outlet_pa.get(from..to.min(r.outlet_pa.len()));
        mean(within.unwrap_or_default())
    };
    let since = |(from, to): (f64, f64)| (i + samples(from), i + samples(to) + 1);
    let before = outlet((i.saturating_sub(samples(BEFORE_S)), i));
    let [soon, after] = [SOON_S, AFTER_S].map(|times| outlet(since(times)));
    before > after && soon - after < LEFT * (before - after)
}

/// The straight line through readings: where it is one step behind the last of them, and what it rises by a second.
fn line(readings: &[f64], step_s: f64) -> Option<(f64, f64)> {
    let n = readings.len();
    let told = || {
        let told = readings.iter().enumerate().filter(|(_, q)| q.is_finite());
        told.map(|(k, q)| ((k as f64 - n as f64) * step_s, *q))
    };
    let count = told().count() as f64;
    let (t, q) = told().fold((0.0, 0.0), |(t, q), one| (t + one.0, q + one.1));
    let (t, q) = (t / count, q / count);
    let (tt, tq) = told().fold((0.0, 0.0), |(tt, tq), one| {
        let (dt, dq) = (one.0 - t, one.1 - q);
        (tt + dt * dt, tq + dt * dq)
    });
    let rise = tq / tt;
    let at_end = q - rise * t;
    (at_end.is_finite() && rise.is_finite()).then_some((at_end, rise))
}

/// How what was let go fades behind two lags in a row, asked at even steps.
struct Fade {
    lags_s: [f64; 2],
    /// What each lag keeps over a step.
    keeps: [f64; 2],
    /// What each has left, s; `None` before anything fades.
    left_s: Option<[f64; 2]>,
}

impl Fade {
    fn behind(lag_s: f64, damping_s: f64, step_s: f64) -> Self {
        /// Lags nearer to each other than this, s, are as good as this far apart.
        const APART_S: f64 = 1e-3;
        let lag_s = lag_s.max(0.0);
        let near = (lag_s - damping_s).abs() < APART_S;
        let lags_s = [lag_s, if near { lag_s + APART_S } else { damping_s }];
        Self {
            lags_s,
            keeps: lags_s.map(|lag_s| kept(lag_s, step_s)),
            left_s: None,
        }
    }

    /// The share that is left so long, s, after it began, a step after the time before.
    fn share_left(&mut self, since_s: f64) -> f64 {
        if since_s <= 0.0 {
            return 1.0;
        }
        let [a, b] = self.lags_s;
        let [left_a, left_b] = match self.left_s {
            Some(left) => [left[0] * self.keeps[0], left[1] * self.keeps[1]],
            None => [a * kept(a, since_s), b * kept(b, since_s)],
        };
        self.left_s = Some([left_a, left_b]);
        (left_a - left_b) / (a - b)
    }
}

/// What a lag keeps over a time.
fn kept(lag_s: f64, over_s: f64) -> f64 {
    if lag_s > 0.0 {
        (-over_s / lag_s).exp()
    } else {
        0.0
    }
}

/// What a path of the meter leaves over of the stops that may be used, in standard deviations, those of the others being 0; behind them the damping that a
/// sound meter may have, which is fitted.
pub(crate) fn left_over(stops: &[Stop], used: &[bool], path: MeterPath) -> Vec<f64> {
    if stops.is_empty() {
        return Vec::new();
    }
    let tried = DAMPINGS_S.map(|damping_s| {
        let told: Vec<(f64, f64)> = (stops.iter().zip(used))
            .map(|(stop, used)| {
                if *used {
                    stop.squares(path, damping_s)
                } else {
                    (0.0, 0.0)
                }
            })
            .collect();
        let squares: f64 = told.iter().map(|(squares, _)| bounded(*squares)).sum();
        (squares + (damping_s / DAMPING_S).powi(2), damping_s, told)
    });
    let best = (tried.into_iter()).min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, damping_s, told) = best.unwrap_or_default();
    let mut out = Vec::new();
    for (stop, (squares, sooner_s)) in stops.iter().zip(told) {
        // One that is not used has none.
        let share = if squares > 0.0 {
            (bounded(squares) / squares).sqrt()
        } else {
            0.0
        };
        out.extend(
            stop.left(path, damping_s, sooner_s)
                .map(|left| share * left),
        );
    }
    out.push(damping_s / DAMPING_S);
    out
}

/// Squares of one stop, which grow ever slower towards [`MOST`].
fn bounded(squares: f64) -> f64 {
    MOST * squares / (MOST + squares)
}

#[cfg(test)]
mod tests;
