//! What a search for anything finds where only some effects are suspected.

use super::{Sought, select};
use crate::belief::less_likely;
use crate::record::Record;
use crate::relations::Applied;
use crate::round::Round;
use crate::selection::Selection;
use tracing::debug;

/// Doubts suspects that a search for anything does not name and beside whose findings they do not show: an effect explains something of
/// any cause whose signature has some of its own.
///
/// - `most`: how many effects that search fits together at most.
pub(crate) fn doubt_outdone(
    record: &Record,
    start: &[Applied],
    suspected: &mut Selection,
    most: usize,
) {
    let Some(any) = select(record, start, Sought::Any(most), |_| {}) else {
        return;
    };
    let strongest = (any.named.iter()).max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    let (Some(strongest), Some(round)) = (strongest, Round::about(record, &any)) else {
        return;
    };
    let by = strongest.applied.effect.about().id;
    for suspect in &mut suspected.named {
        let id = suspect.applied.effect.about().id;
        let named = any.named.iter().any(|n| n.applied.effect.about().id == id);
        if named || round.shows(id) {
            continue;
        }
        // It may stand for one of the findings instead of beside them.
        let alternatives = any.named.iter().flat_map(|n| &n.alternatives);
        let instead = alternatives.filter(|a| a.0 == id).map(|a| a.1);
        let probability = instead.fold(round.beside(id), f64::max);
        debug!("{id} does not show beside {by}: {probability:.3}");
        less_likely(suspect, probability, by);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::doubt_outdone;
    use crate::select::{Sought, select};
    use crate::test_rig::{Hidden, drilled};

    /// How likely a suspect is where mud flows in for a while.
    fn likely(gain: f64, suspects: &[&str]) -> Vec<(String, f64)> {
        let mut record = drilled(Hidden {
            influx_m3_s: 3e-3,
            ..Hidden::default()
        });
        for read in &mut record.filled.mud_pump {
            *read *= 1.0 + gain;
        }
        let suspects: Vec<String> = suspects.iter().map(|s| (*s).to_owned()).collect();
        let mut found = select(&record, &[], Sought::Given(&suspects), |_| {}).unwrap();
        doubt_outdone(&record, &[], &mut found, 3);
        let told =
            |n: &crate::selection::Named| (n.applied.effect.about().id.to_owned(), n.probability);
        found.named.iter().map(told).collect()
    }

    #[test]
    fn a_suspect_that_only_resembles_what_was_not_suspected_is_doubted() {
        // Fitted alone they would be 0.997 and 0.86 likely.
        for only_resembles in ["annulus_area", "lost_circulation"] {
            let doubted = likely(0.0, &[only_resembles]);
            assert!(doubted[0].1 < 0.01, "{doubted:?}");
        }
        let right = likely(0.0, &["influx"]);
        assert!(right[0].1 > 0.9, "{right:?}");
    }

    /// A wrong reading of the inflow beside an influx that explains more: too small to be named there at 2 %, named at 3 %.
    #[test]
    fn a_suspect_that_shows_beside_a_stronger_one_is_not() {
        for gain in [-0.02, -0.03] {
            let weaker = likely(gain, &["inflow_gain"]);
            assert!(weaker[0].1 > 0.7, "{weaker:?}");
        }
    }
}
