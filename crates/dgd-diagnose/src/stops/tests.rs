#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{ENOUGH, Fade, MOST, Readings, Stop, left_over, stops};
use crate::numbers::whole;
use crate::test_rig::normals;
use dgd_effects::MeterPath;
use dgd_lsq::dot;

const FLOW_M3_S: f64 = 0.04;
const NOISE_M3_S: f64 = 2e-4;
/// What the meter's noise alone leaves of three stops: 270 readings, a tenth of what they may be off by each, is 2.7.
const NOISE_LEAVES: f64 = 3.5;
/// A stop every ten minutes, of three.
const EVERY_S: f64 = 600.0;
const STANDS_S: f64 = 180.0;

/// A pump that stops at once, a line that follows, and a meter behind a path.
struct Rig {
    step_s: f64,
    count: usize,
    path: MeterPath,
    speed_pct: Vec<f64>,
    flow_m3_s: Vec<f64>,
    outlet_pa: Vec<f64>,
}

impl Rig {
    fn behind(delay_s: f64, lag_s: f64) -> Self {
        Self::reading_every(1.0, 3, MeterPath { delay_s, lag_s })
    }

    /// The samples of such a rig, its meter run at a tenth of a second.
    fn reading_every(step_s: f64, count: usize, path: MeterPath) -> Self {
        const FINE_S: f64 = 0.1;
        let n = whole((count as f64 * EVERY_S / FINE_S).round());
        let stands = |k: usize| (k as f64 * FINE_S).rem_euclid(EVERY_S) > EVERY_S - STANDS_S;
        let line: Vec<f64> = (0..n)
            .map(|k| if stands(k) { 0.0 } else { FLOW_M3_S })
            .collect();
        let late = whole((path.delay_s / FINE_S).round());
        let mut metered = FLOW_M3_S;
        let metered: Vec<f64> = (0..n)
            .map(|k| {
                let arrives = line[k.saturating_sub(late)];
                metered = if path.lag_s > 0.0 {
                    arrives + (metered - arrives) * (-FINE_S / path.lag_s).exp()
                } else {
                    arrives
                };
                metered
            })
            .collect();
        // Just after the edge of a sample.
        let every = whole((step_s / FINE_S).round());
        let at: Vec<usize> = (0..n / every).map(|i| i * every).collect();
        let noise = normals(5, at.len());
        Self {
            step_s,
            count,
            path,
            speed_pct: at
                .iter()
                .map(|k| if stands(*k) { 0.0 } else { 70.0 })
                .collect(),
            flow_m3_s: (at.iter().zip(noise))
                .map(|(k, noise)| metered[*k] + NOISE_M3_S * noise)
                .collect(),
            outlet_pa: at.iter().map(|k| 180e5 + 1e8 * line[*k]).collect(),
        }
    }

    fn stops(&self) -> Vec<Stop> {
        stops(&Readings {
            step_s: self.step_s,
            speed_pct: &self.speed_pct,
            flow_m3_s: &self.flow_m3_s,
            outlet_pa: &self.outlet_pa,
            noise_m3_s: NOISE_M3_S,
            per_block: 10,
        })
    }

    /// Squares that a path leaves of all its stops.
    fn leaves(&self, delay_s: f64, lag_s: f64) -> f64 {
        let stops = self.stops();
        assert_eq!(stops.len(), self.count);
        let off = left_over(
            &stops,
            &vec![true; stops.len()],
            MeterPath { delay_s, lag_s },
        );
        dot(&off, &off)
    }

    /// Those of its own.
    fn left(&self) -> f64 {
        self.leaves(self.path.delay_s, self.path.lag_s)
    }

    /// Samples from so many seconds after the beginning of its first stop on.
    fn since_stop(
        &mut self,
        from_s: f64,
        change: impl Fn(f64, &mut f64),
        of: fn(&mut Self) -> &mut Vec<f64>,
    ) {
        let first = self.speed_pct.iter().position(|w| *w < 1.0).unwrap();
        let step_s = self.step_s;
        for (k, v) in of(self).iter_mut().enumerate() {
            let since_s = (k as f64 - first as f64) * step_s;
            if since_s >= from_s && since_s < EVERY_S - STANDS_S {
                change(since_s, v);
            }
        }
    }
}

#[test]
fn a_delay_and_a_store_of_the_same_mean_are_told_apart() {
    for late_s in [3.4, 8.0, 20.0] {
        let [delay, store] = [Rig::behind(late_s, 0.0), Rig::behind(0.0, late_s)];
        let other = |rig: &Rig, delay_s, lag_s| rig.leaves(delay_s, lag_s) - rig.left();
        assert!(
            delay.left() < NOISE_LEAVES && store.left() < NOISE_LEAVES,
            "{late_s}"
        );
        let (as_store, as_delay) = (other(&delay, 0.0, late_s), other(&store, late_s, 0.0));
        assert!(
            as_store > 40.0 && as_delay > 40.0,
            "{late_s}: {as_store} {as_delay}"
        );
        // Between the two lies what has some of each.
        let both = Rig::behind(0.5 * late_s, 0.5 * late_s);
        assert!(both.left() < NOISE_LEAVES);
        assert!(
            other(&both, late_s, 0.0) > 8.0 && other(&both, 0.0, late_s) > 8.0,
            "{late_s}"
        );
    }
}

#[test]
fn readings_of_every_five_seconds_tell_a_long_store_from_a_delay() {
    let path = |delay_s, lag_s| MeterPath { delay_s, lag_s };
    let store = Rig::reading_every(5.0, 4, path(0.0, 12.0));
    assert!(store.left() < 3.0);
    assert!(store.leaves(12.0, 0.0) > 20.0);
    // Further apart they tell nothing.
    let slow = Rig::reading_every(10.0, 4, path(0.0, 12.0));
    assert!(slow.stops().is_empty());
    assert!(left_over(&slow.stops(), &[], path(3.0, 0.0)).is_empty());
}

#[test]
fn a_sound_meter_may_be_damped() {
    let damped = Rig::behind(0.0, 1.5);
    // A damping of one and a half times its width.
    let costs = damped.leaves(0.0, 0.0) - 1.5 * 1.5;
    assert!((0.0..NOISE_LEAVES).contains(&costs), "{costs}");
    assert!(Rig::behind(0.0, 4.0).leaves(0.0, 0.0) > 30.0);
    // It may lie behind a delay as well.
    assert!(Rig::behind(9.0, 1.5).leaves(9.0, 0.0) < 1.5 * 1.5 + NOISE_LEAVES);
}

#[test]
fn a_meter_that_freezes_as_the_pump_stops_is_one_accident() {
    let mut rig = Rig::behind(6.0, 0.0);
    let sound = rig.left();
    rig.since_stop(-3.0, |_, q| *q = FLOW_M3_S, |rig| &mut rig.flow_m3_s);
    let stuck = rig.left();
    assert!(
        stuck > sound + 0.8 * MOST && stuck < sound + MOST,
        "{sound} {stuck}"
    );
}

#[test]
fn what_is_no_sharp_stop_tells_nothing() {
    let two_left = |change: &dyn Fn(&mut Rig)| {
        let mut rig = Rig::behind(6.0, 0.0);
        assert_eq!(rig.stops().len(), 3);
        change(&mut rig);
        assert_eq!(rig.stops().len(), 2);
    };
    // A pump that runs down: its outlet says so.
    two_left(&|rig| {
        rig.since_stop(
            0.0,
            |s, p| *p = 180e5 + 4e6 * (-s / 5.0).exp(),
            |rig| &mut rig.outlet_pa,
        )
    });
    // One that turns again at once, and one that has only begun to turn.
    two_left(&|rig| rig.since_stop(12.0, |_, w| *w = 70.0, |rig| &mut rig.speed_pct));
    two_left(&|rig| {
        rig.since_stop(
            -12.0,
            |s, w| *w = if (-6.0..0.0).contains(&s) { 70.0 } else { 0.0 },
            |rig| &mut rig.speed_pct,
        )
    });
    // Readings that are not there, before and after.
    two_left(&|rig| {
        rig.since_stop(
            0.0,
            |s, q| *q = if s < 10.0 { f64::NAN } else { *q },
            |rig| &mut rig.flow_m3_s,
        )
    });
    two_left(&|rig| {
        rig.since_stop(
            -15.0,
            |s, q| *q = if s < 0.0 { f64::NAN } else { *q },
            |rig| &mut rig.flow_m3_s,
        )
    });
    two_left(&|rig| rig.since_stop(0.0, |_, p| *p = f64::NAN, |rig| &mut rig.outlet_pa));
    // Mud that hardly flows.
    two_left(&|rig| rig.since_stop(-60.0, |_, q| *q = 1e-4, |rig| &mut rig.flow_m3_s));
}

#[test]
fn an_outlet_that_swings_below_where_it_stays_has_fallen_at_once() {
    let mut rig = Rig::behind(6.0, 0.0);
    rig.since_stop(
        0.0,
        |s, p| *p -= 2e6 * (-s / 3.0).exp(),
        |rig| &mut rig.outlet_pa,
    );
    assert_eq!(rig.stops().len(), 3);
}

#[test]
fn a_stop_that_is_not_used_leaves_nothing_and_keeps_its_rows() {
    let rig = Rig::behind(6.0, 0.0);
    let stops = rig.stops();
    let path = MeterPath::default();
    let all = left_over(&stops, &[true; 3], path);
    let some = left_over(&stops, &[true, false, true], path);
    let rows = |k: usize| 90 * k..90 * (k + 1);
    assert_eq!(all.len(), 3 * 90 + 1);
    assert_eq!(some.len(), all.len());
    assert!(some[rows(1)].iter().all(|v| *v == 0.0));
    assert_eq!(some[rows(0)], all[rows(0)]);
    assert_eq!(some[rows(2)], all[rows(2)]);
    // From twenty seconds before to a minute and a half after, in blocks of ten samples.
    assert_eq!(stops[0].blocks, 40..52);
}

#[test]
fn of_many_stops_some_are_taken_all_along() {
    let path = MeterPath::default();
    let rig = Rig::reading_every(1.0, 3 * ENOUGH, path);
    let stops = rig.stops();
    assert_eq!(stops.len(), ENOUGH);
    let blocks_apart = 3.0 * EVERY_S / 10.0;
    for (k, stop) in stops.iter().enumerate() {
        let expected = 40.0 + k as f64 * blocks_apart;
        assert!((stop.blocks.start as f64 - expected).abs() < 1.5, "{k}");
    }
}

#[test]
fn two_lags_fade_as_their_equation_says() {
    let share = |lag_s, damping_s, since_s| Fade::behind(lag_s, damping_s, 1.0).share_left(since_s);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-3, "{a} {b}");
    close(share(4.0, 0.0, 4.0), (-1.0_f64).exp());
    close(share(0.0, 2.0, 4.0), (-2.0_f64).exp());
    let expected = (4.0 * (-0.5_f64).exp() - (-2.0_f64).exp()) / 3.0;
    close(share(4.0, 1.0, 2.0), expected);
    // Two alike: (1 + t/tau) exp(-t/tau).
    close(share(2.0, 2.0, 3.0), 2.5 * (-1.5_f64).exp());
    close(share(0.0, 0.0, 0.5), 0.0);
    close(share(5.0, 1.0, -1.0), 1.0);
    // Asked step by step it is the same.
    let mut fade = Fade::behind(4.0, 1.0, 1.0);
    for k in 0..9 {
        let since_s = k as f64 - 2.5;
        close(fade.share_left(since_s), share(4.0, 1.0, since_s));
    }
}
