//! What was named before a correction of its relation, and may be part of what that is.

use crate::empirical::{again, again_as_it_runs};
use crate::record::Record;
use crate::relations::Applied;
use crate::selection::{Named, Selection};
use crate::tangent::{Bend, Tangent};
use dgd_effects::{Curve, Quantity};
use dgd_lsq::dot;
use tracing::debug;

/// Whether a correction of all times tells so much, where something that ended was named, that this was rather part of it: what comes and goes without
/// a rule looks like several that end.
pub(super) fn is_whole(selection: &Selection, correction: &Named) -> bool {
    /// Share of what ended that it must tell. Set by hand.
    const SHARE: f64 = 0.2;
    let of_all_times = |curve: Curve| curve.quantity != Quantity::Episode;
    if !correction.applied.curve().is_some_and(of_all_times) {
        return false;
    }
    let ended = |n: &&Named| {
        let effect = n.applied.effect;
        effect.lasting().is_some() && correction.shows_in(effect.about().relation)
    };
    let ended: Vec<f64> = (selection.named.iter().filter(ended))
        .map(|n| n.evidence)
        .collect();
    !ended.is_empty() && correction.evidence > SHARE * ended.iter().sum::<f64>()
}

/// The selection, whose last is a correction, without effects of its relation that save less beside it than they must: it was found beside them, and
/// drawn anew tells as much alone. `None` where it needs all of them.
///
/// A band of speeds in which a pump lifts less comes and goes with the speed, as gas does; that it is a law of the speed shows only at last.
pub(super) fn without_parts(record: &Record, selection: &Selection) -> Option<Selection> {
    let (last, before) = selection.named.split_last()?;
    let curve = last.applied.curve()?;
    let is_part =
        |n: &Named| !n.applied.is_correction() && last.shows_in(n.applied.effect.about().relation);
    let parts: Vec<usize> = (0..before.len()).filter(|k| is_part(&before[*k])).collect();
    if parts.is_empty() {
        return None;
    }
    let without = |parts: &[usize]| {
        let kept = (0..before.len()).filter(|k| !parts.contains(k));
        Selection {
            named: kept.map(|k| before[k].clone()).collect(),
            ..selection.clone()
        }
    };
    // A curve bends as one that runs, beside effects that have moved to where they explain most with it.
    let run = |mut others: Selection| -> Option<Selection> {
        let drawn = again_as_it_runs(record, &others.state(), &curve, &[])?;
        others.named.push(Named {
            applied: Applied::from(&drawn),
            ..last.clone()
        });
        others.refine(record);
        Some(others)
    };
    let whole = run(without(&[]))?;
    // All are judged by the same noise and on the same rows.
    let tangent = Tangent::at(record, &whole.state(), &[], Bend::Stiff)?;
    let misfit = |off: &[f64]| 0.5 * dot(off, off);
    let saves = |parts: &[usize]| -> Option<f64> {
        let rest = run(without(parts))?;
        Some(misfit(&tangent.left_over(record, &rest.state())) - misfit(&tangent.off))
    };
    // Of one alone that would ask the same again.
    let several = parts.len() > 1;
    let one_by_one = parts.iter().filter(|_| several).map(|k| vec![*k]);
    let gone = (std::iter::once(parts.clone()).chain(one_by_one)).find(|parts| {
        let hurdle: f64 = parts.iter().map(|k| before[*k].hurdle).sum();
        let saved = saves(parts);
        let ids: Vec<&str> = parts.iter().map(|k| before[*k].applied.id()).collect();
        debug!(
            "{ids:?} beside a correction of {} by {} save {saved:?} of {hurdle:.1}",
            curve.place.name(),
            curve.quantity.name()
        );
        saved.is_some_and(|saved| saved < hurdle)
    })?;
    let mut rest = without(&gone);
    let drawn = again(record, &rest.state(), &curve, &[])?;
    rest.named.push(Named {
        applied: Applied::from(&drawn.curve),
        evidence: drawn.evidence.max(last.evidence),
        ..last.clone()
    });
    rest.refine(record);
    Some(rest)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{is_whole, without_parts};
    use crate::empirical::correction;
    use crate::record::Record;
    use crate::relations::Applied;
    use crate::selection::Named;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, INFLUX_S, drilled, named, selection};
    use dgd_effects::{Curve, KNOTS, Place, Quantity, find};

    #[test]
    fn what_ended_is_part_of_a_correction_that_tells_much_beside_it() {
        let leak = find("line_leak").unwrap();
        let ends = Applied::new(leak.passing().unwrap(), vec![1e-3, 2000.0, 1800.0]);
        let stays = Applied::new(leak, vec![1e-3, 2000.0]);
        let of = |effect: &Applied, place: Place, quantity: Quantity, evidence: f64| {
            let curve = Curve::new(place, quantity, (0.0, 5400.0), vec![1e-3; KNOTS]);
            let correction = Named {
                evidence,
                ..of_size(Applied::from(&curve))
            };
            is_whole(&selection(vec![of_size(effect.clone())]), &correction)
        };
        let (meter, time) = (Place::MeterFactor, Quantity::Time);
        assert!(of(&ends, meter, time, 21.0));
        assert!(!of(&ends, meter, time, 19.0));
        assert!(!of(&ends, meter, Quantity::Episode, 21.0));
        assert!(!of(&ends, Place::Head, time, 21.0));
        assert!(!of(&stays, meter, time, 21.0));
    }

    fn of_size(applied: Applied) -> Named {
        Named {
            applied,
            evidence: 100.0,
            ..named("influx", &[1e-3, 0.0, 600.0, 0.15])
        }
    }

    /// Drilling in which the mud pump reads more than it pumps about one return flow, and which conceals an influx besides.
    fn misread(influx_m3_s: f64) -> Record {
        let mut record = drilled(Hidden {
            influx_m3_s,
            ..Hidden::default()
        });
        let more = |q: f64| 2e-3 * (-((q - 0.047) / 0.003).powi(2)).exp();
        for (reading, q) in record.mud_pump.iter_mut().zip(&record.flow) {
            *reading += more(*q);
        }
        record.filled.mud_pump.clone_from(&record.mud_pump);
        record
    }

    #[test]
    fn what_a_correction_tells_without_an_effect_needs_no_effect() {
        let (from, lasts, rise) = INFLUX_S;
        let influx = || named("influx", &[3e-3, from, lasts, rise]);
        let gain = || named("inflow_gain", &[0.01]);
        let left = |record: &Record, effects: Vec<Named>| {
            let mut found = selection(effects);
            let state = found.state();
            let loose = Tangent::beside(record, &state, &[], Bend::Loose).unwrap();
            let along = (Place::Balance, Quantity::ReturnFlow);
            let drawn = correction(record, &loose, &state, &[], along).unwrap();
            found.named.push(Named {
                evidence: drawn.evidence,
                ..of_size(Applied::from(&drawn.curve))
            });
            let rest = without_parts(record, &found)?;
            let last = rest.named.last()?;
            assert!(last.applied.is_correction() && last.evidence > drawn.evidence);
            let ids = rest.named.iter().map(|n| n.applied.id());
            Some(ids.collect::<Vec<_>>())
        };
        let (alone, beside) = (misread(0.0), misread(3e-3));
        assert_eq!(left(&alone, vec![gain()]), Some(vec!["unknown"]));
        assert_eq!(left(&beside, vec![influx()]), None);
        let one = Some(vec!["influx", "unknown"]);
        assert_eq!(left(&beside, vec![influx(), gain()]), one);
        // What acts elsewhere is no part of it.
        let elsewhere = vec![named("return_flow_delay", &[4.0])];
        assert_eq!(left(&alone, elsewhere), None);
        assert_eq!(left(&alone, Vec::new()), None);
    }
}
