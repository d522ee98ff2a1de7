//! What comes back of each inflow, told apart by their changes.

use super::Suspicion;
use super::WellLine;
use super::causes::{Cause, readings};
use super::checks::{RETURNED, faults};
use super::state::State;
use super::words;
use dgd_lsq::Accumulator;
use dgd_units::{Dimension, Unit};

/// What comes back of an inflow by its changes, beyond what gains of meters, stores and losses make of it. Set by hand: of another unit it is 2.6 or more,
/// or the inverse.
const OF_ONE: (f64, f64) = (0.4, 2.5);
/// Standard errors that it must lie beyond them: those of blocks that hang together are too small.
const ERRORS: f64 = 6.0;
/// Standard deviation of an inflow, as a share of the most that it reaches, from which on it changes: noise alone is related to nothing.
const CHANGES: f64 = 0.1;
/// How near to 1 another unit must bring it.
const NEAR: f64 = 1.4;

/// The inflow of which so much more or less comes back than it puts in that its unit, or its tag, must be another, while of the others about as much
/// comes back: where it does not, they are not told apart.
pub(super) fn ill_fed(state: &State<'_>) -> Option<Suspicion> {
    let mut odd = shares(state);
    odd.retain(|(_, share)| !share.may_be_in(RETURNED));
    match odd.as_slice() {
        [(told, share)] if !share.may_be_in(OF_ONE) => {
            Some(suspicion(state, *told, share.estimate))
        }
        _ => None,
    }
}

fn suspicion(state: &State<'_>, told: usize, share: f64) -> Suspicion {
    let read_as = state.units[told];
    let advice = if read_as.counts_turns() {
        "check tag, unit and `stroke`".to_owned()
    } else if let Some(unit) = mended(state, told, share) {
        format!("as {unit} they would change as much as it does")
    } else {
        "check tag and unit".to_owned()
    };
    Suspicion {
        place: WellLine::of(state.facts.told[told].channel),
        message: format!(
            "when {}, read as {read_as}, changes, return flow and riser level change by {} times as much; {advice}",
            words::named(state, told),
            words::number(share),
        ),
    }
}

/// The unit with which as much comes back as is pumped in.
fn mended(state: &State<'_>, told: usize, share: f64) -> Option<Unit> {
    let now = state.units[told];
    let off = |unit: &Unit| (share * now.factor / unit.factor).ln().abs();
    let mut others = readings(Dimension::FlowRate, state.units.iter().copied());
    others.retain(|unit| unit.factor != now.factor && off(unit) < NEAR.ln());
    others.sort_by(|a, b| off(a).total_cmp(&off(b)));
    others.into_iter().find(|unit| {
        let read_so = Cause::Unit(vec![told], *unit).undone(state);
        read_so.is_some_and(|after| faults(&after).is_empty())
    })
}

/// An estimate with its standard error.
#[derive(Debug, Clone, Copy)]
struct Share {
    estimate: f64,
    error: f64,
}

impl Share {
    fn may_be_in(self, (low, high): (f64, f64)) -> bool {
        let far = ERRORS * self.error;
        self.estimate + far >= low && self.estimate - far <= high
    }
}

/// What return flow and level (Eq. 3.45) show of each inflow that changes; nothing where they cannot be told apart.
///
/// A constant beside them takes what flows in or out all along.
fn shares(state: &State<'_>) -> Vec<(usize, Share)> {
    let inlets = state.inlets();
    let changing: Vec<usize> = state
        .inflows()
        .into_iter()
        .filter(|i| state.facts.told[*i].tag.is_some() && changes(state, *i))
        .collect();
    let names = changing.iter().map(|i| i.to_string());
    let Ok(mut rows) = Accumulator::new(names.chain(["constant".to_owned()])) else {
        return Vec::new();
    };
    let rise_m3_s_pa =
        state.geometry.riser_area_m2() / (2.0 * state.block_s() * state.weight_pa_m());
    let mut row = Vec::with_capacity(changing.len() + 1);
    for k in 1..state.blocks().saturating_sub(1) {
        let rise_pa = state.mean_of(&inlets, k + 1) - state.mean_of(&inlets, k - 1);
        row.clear();
        row.extend(changing.iter().map(|i| state.value(*i, k)));
        row.push(1.0);
        // A block in which a channel has no value is refused, and that is right.
        let _ = rows.push(&row, state.return_flow(k) + rise_m3_s_pa * rise_pa);
    }
    let Ok(fit) = rows.finish() else {
        return Vec::new();
    };
    let shares = fit.coefficients.iter().zip(&fit.standard_errors);
    let shares = shares.map(|(estimate, error)| Share {
        estimate: *estimate,
        error: *error,
    });
    changing.into_iter().zip(shares).collect()
}

fn changes(state: &State<'_>, told: usize) -> bool {
    let values = || state.values(told).filter(|v| v.is_finite());
    let (count, sum, most) = values().fold((0.0, 0.0, 0.0_f64), |(count, sum, most), v| {
        (count + 1.0, sum + v, most.max(v.abs()))
    });
    let mean = sum / count;
    let square: f64 = values().map(|v| (v - mean).powi(2)).sum();
    (square / count).sqrt() > CHANGES * most
}
