//! Rows whose run is not known yet.

use crate::fill::Filling;
use std::ops::Range;

/// Rows of the window that wait.
#[derive(Debug, Default)]
pub(super) struct Waiting {
    /// So many of them have been given, and only the integrator still asks for them: none or one.
    pub(super) given: usize,
    pub(super) time_s: Vec<f64>,
    pub(super) inlet_pa: Vec<f64>,
    pub(super) outlet_pa: Vec<f64>,
    pub(super) level_m: Vec<f64>,
    pub(super) return_flow_m3_s: Vec<f64>,
    /// The meter's flow, read ahead: fewer than there are rows.
    pub(super) pump_flow_m3_s: Vec<f64>,
    pub(super) inflows: [Filling; 3],
    pub(super) speed_pct: Filling,
    pub(super) level_input: Filling,
    pub(super) flow_input: Filling,
}

impl Waiting {
    /// Rows of which all that is asked for is known.
    pub(super) fn known(&self) -> usize {
        let read = [&self.level_input, &self.flow_input];
        let read = read.into_iter().filter(|filling| filling.is_read());
        let all = self.inflows.iter().chain([&self.speed_pct]).chain(read);
        all.map(Filling::known)
            .fold(self.pump_flow_m3_s.len(), usize::min)
    }

    /// The sum is filled flow by flow: a gap in one must not take the others with it.
    pub(super) fn inflow(&self, rows: usize) -> Vec<f64> {
        let [mud_pump, booster, topfill] = &self.inflows;
        let rest = booster.values[..rows].iter().zip(&topfill.values[..rows]);
        let all = mud_pump.values[..rows].iter().zip(rest);
        all.map(|(p, (b, t))| p + b + t).collect()
    }

    /// A pump that turns backwards stands.
    pub(super) fn speed(&self, rows: usize) -> Vec<f64> {
        let forward = |w: &f64| if *w < 0.0 { 0.0 } else { *w };
        self.speed_pct.values[..rows].iter().map(forward).collect()
    }

    pub(super) fn filled(&self) -> usize {
        let all = self.inflows.iter();
        let all = all.chain([&self.speed_pct, &self.level_input, &self.flow_input]);
        all.map(Filling::filled).sum()
    }

    /// Forgets the first rows of the inputs; of the other series [`take`] does.
    pub(super) fn forget(&mut self, rows: usize) {
        for filling in (self.inflows.iter_mut()).chain([
            &mut self.speed_pct,
            &mut self.level_input,
            &mut self.flow_input,
        ]) {
            filling.forget(rows);
        }
    }
}

/// Takes some rows out of a series and forgets its first ones, `gone` of them.
pub(super) fn take(series: &mut Vec<f64>, rows: Range<usize>, gone: usize) -> Vec<f64> {
    // What stays is copied, if it is less than what goes.
    if rows.start == 0 && 2 * gone >= series.len() {
        let left = series[gone..].to_vec();
        let mut taken = std::mem::replace(series, left);
        taken.truncate(rows.end);
        return taken;
    }
    let taken = series[rows].to_vec();
    series.drain(..gone);
    taken
}
