//! Whether the line's flow is laminar below some flow, as that of viscous mud is: its friction then follows two laws, and is no finding.

use crate::ablation::Step;
use crate::numbers::tails;
use crate::record::Record;
use crate::selection::Selection;
use crate::tangent::{Bend, Tangent};
use dgd_effects::{Laminar, Relation, STANDING_M3_S};
use tracing::debug;

/// Flows at which laminar flow may turn turbulent, over the upper one of the recording, and from one to the next that is tried; then half and a quarter
/// as far about the best.
const LOWEST: f64 = 0.1;
const HIGHEST: f64 = 1.7;
const APART: f64 = 1.12;

/// Flow indices that are tried: of a Newtonian mud, and of such as thin under shear.
const INDICES: [f64; 3] = [1.0, 0.8, 0.6];

/// E-folds from which on what laminar flow explains is looked into, and by which what is found so must explain more: lines are made for turbulent
/// flow. Set by hand.
const STANDS_OUT: f64 = 10.0;
const SELDOM: f64 = 3.0;

/// The flow above which it is for a tenth of the time, over that below which it is for another: of a flow that changes less the few rows in which it
/// does decide, and those tell of starts, of which so much is looked into. Set by hand.
const RANGE: f64 = 1.6;
const STANDS_OUT_OF_LITTLE: f64 = 200.0;

/// A search of a line whose flow is laminar below some flow, and what it found, where that explains more than what was found without.
///
/// Friction of viscous mud is straight in the flow up to a Reynolds number of about 2300, and nearly square in it above 4000. A curve of
/// turbulent flow cannot bend so; what it leaves over looks like a yield stress, a restriction or whatever the flow goes with.
///
/// - `found`: what was found of `record`, all of whose flow is turbulent.
/// - `search`: searches another record.
pub(crate) fn laminar(
    record: &Record,
    found: &Selection,
    search: impl FnOnce(&Record) -> Option<Selection>,
) -> Option<(Record, Selection)> {
    if !record.takes(Step::Laminar) {
        return None;
    }
    let least = if ranges(record) {
        STANDS_OUT
    } else {
        STANDS_OUT_OF_LITTLE
    };
    let beside = Tangent::at(record, &found.state(), &[], Bend::Lean)?;
    let mut best = likeliest(record, &beside)?;
    if !found.named.is_empty() {
        // What was found of the friction may be what laminar flow leaves over of it.
        let alone = Tangent::at(record, &found.allowances, &[], Bend::Lean)?;
        let own = (found.named.iter())
            .filter(|n| n.shows_in(Relation::ReturnLineFriction))
            .map(|n| n.evidence)
            .sum::<f64>();
        if let Some((laminar, evidence)) = likeliest(record, &alone)
            && evidence - own > best.1
        {
            best = (laminar, evidence - own);
        }
    }
    let (laminar, more) = best;
    debug!("{laminar:?} explains {more:.1} more");
    if more < least {
        return None;
    }
    let other = record.with_laminar(laminar);
    let search = search(&other)?;
    let price = |of: &Selection| of.named.iter().map(|n| n.hurdle).sum::<f64>();
    let saved = (beside.misfit_of(record, &found.state()) + price(found))
        - (beside.misfit_of(&other, &search.state()) + price(&search));
    debug!("what is found so saves {saved:.1}");
    (saved > SELDOM).then_some((other, search))
}

/// Whether the flow changes enough to tell one law of friction from another.
fn ranges(record: &Record) -> bool {
    let flowing: Vec<f64> = (record.flow.iter().copied())
        .filter(|q| *q > STANDING_M3_S)
        .collect();
    tails(&flowing, 10).is_some_and(|(low, high)| high > RANGE * low)
}

/// The likeliest laminar flow, and the evidence for it.
fn likeliest(record: &Record, tangent: &Tangent) -> Option<(Laminar, f64)> {
    let upper = tangent.curves.scale.flow_m3_s;
    let weighed = |laminar: Laminar| {
        let evidence = tangent.laminar_evidence(record, laminar)?;
        evidence.is_finite().then_some((laminar, evidence))
    };
    let more = |a: &(Laminar, f64), b: &(Laminar, f64)| a.1.total_cmp(&b.1);
    let shares = std::iter::successors(Some(LOWEST), |share| Some(share * APART));
    let coarse = shares
        .take_while(|share| *share < HIGHEST)
        .flat_map(|share| INDICES.map(|index| (share * upper, index)))
        .filter_map(|(below_m3_s, index)| weighed(Laminar { below_m3_s, index }));
    let mut best = coarse.max_by(more)?;
    for step in [APART.sqrt(), APART.sqrt().sqrt()] {
        let about = best.0;
        let near = [1.0 / step, step].map(|by| Laminar {
            below_m3_s: about.below_m3_s * by,
            ..about
        });
        let near = near.into_iter().filter_map(weighed);
        best = near.chain([best]).max_by(more)?;
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::laminar;
    use crate::ablation::Step;
    use crate::record::Record;
    use crate::select::{Sought, select};
    use crate::selection::Selection;
    use crate::test_rig::{Hidden, drilled, drilled_through, one, parabolas};
    use dgd_effects::Laminar;

    fn searched(record: &Record) -> Selection {
        select(record, &[], Sought::Any(2), |_| {}).unwrap()
    }

    /// Drilling with viscous mud, whose flow lies this much further apart than else.
    fn viscous(further: f64) -> Record {
        let mut curves = parabolas(4e5, 45e5, 5e5);
        curves.scale.laminar = Some(Laminar {
            below_m3_s: 0.044,
            index: 1.0,
        });
        curves.friction[1] = 2e5;
        let hidden = Hidden {
            further,
            ..Hidden::default()
        };
        drilled_through(hidden, &curves)
    }

    #[test]
    fn flow_that_turns_turbulent_within_the_recording_is_no_finding() {
        let record = viscous(1.5);
        let turbulent = searched(&record);
        assert!(!turbulent.named.is_empty());
        let (other, found) = laminar(&record, &turbulent, |other| Some(searched(other))).unwrap();
        let below_m3_s = other.laminar.unwrap().below_m3_s;
        assert!((below_m3_s / 0.044 - 1.0).abs() < 0.05, "{below_m3_s}");
        assert!(found.named.is_empty());
        let mut without = record;
        without.without.push(Step::Laminar);
        assert!(laminar(&without, &turbulent, |_| panic!("searched again")).is_none());
    }

    #[test]
    fn a_flow_that_hardly_changes_tells_no_law_from_another() {
        let record = viscous(0.0);
        let found = searched(&record);
        assert!(laminar(&record, &found, |_| panic!("searched again")).is_none());
    }

    #[test]
    fn turbulent_flow_is_not_searched_again_whatever_it_conceals() {
        let hidden = [
            Hidden::default(),
            Hidden {
                late_s: 9.0,
                ..Hidden::default()
            },
            Hidden {
                influx_m3_s: 3e-3,
                ..Hidden::default()
            },
        ];
        for hidden in hidden {
            let record = drilled(hidden);
            let found = searched(&record);
            let again = laminar(&record, &found, |_| panic!("searched again"));
            assert!(again.is_none());
        }
    }

    #[test]
    fn what_explains_no_more_is_not_taken() {
        let record = viscous(1.5);
        let turbulent = searched(&record);
        // A search that finds nothing but what costs more than it saves.
        let dear = |other: &Record| {
            let mut found = searched(other);
            let mut named = turbulent.named.clone();
            for n in &mut named {
                (n.hurdle, n.applied) = (1e6, one("influx", &[0.0, 1500.0, 1300.0, 0.15]));
            }
            found.named = named;
            Some(found)
        };
        assert!(laminar(&record, &turbulent, dear).is_none());
        assert!(laminar(&record, &turbulent, |_| None).is_none());
    }
}
