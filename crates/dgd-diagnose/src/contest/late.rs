//! Late meters, a delay or a store: fitted to the same rows, so timed and weighed alike.

use super::{Contender, hurdle};
use crate::cores::apiece;
use crate::noisier::owed_to_meter_noise;
use crate::numbers::product;
use crate::record::Record;
use crate::relations::{Applied, blurred};
use crate::scan::{Candidate, weigh};
use crate::tangent::Tangent;
use crate::timing::{is_late_meter, retimed};
use dgd_effects::Role;
use rayon::prelude::*;
use tracing::debug;

/// Makes the claims of late meters comparable. Each was timed together with every allowance, so their evidence tells them apart once what
/// a lag loses is added back. All are credited with the most that any of them gains by bending: bending further is no evidence.
pub(crate) fn put_on_one_scale(record: &Record, contenders: &mut [Contender]) {
    let late = |c: &&mut Contender| is_late_meter(c.effect.about());
    for c in contenders.iter_mut().filter(late) {
        let path = c.effect.meter_path(&c.best.applied.parameters);
        c.lost = blurred(path, record.setting.span_s, record.told_every_s);
    }
    let mut late: Vec<&mut Contender> = (contenders.iter_mut())
        .filter(|c| stands_late(record, c))
        .collect();
    if late.len() < 2 {
        return;
    }
    let bends = |c: &Contender| c.claim() - c.evidence;
    let most = late.iter().map(|c| bends(c)).fold(0.0, f64::max);
    for c in &mut late {
        c.evened = most - bends(c) + c.lost;
    }
}

/// Whether a late meter stands out by itself.
fn stands_late(record: &Record, c: &Contender) -> bool {
    is_late_meter(c.effect.about()) && c.evidence > hurdle(record, &c.best.applied)
}

/// Whether it allows for as much as a sound meter may be late by.
fn as_late_as_is_sound(one: &Applied) -> bool {
    let about = one.effect.about();
    let latest = about.search.allowance.last();
    one.allowance
        && is_late_meter(about)
        && latest.is_some_and(|latest| one.parameters[0] >= *latest)
}

/// E-folds that another form than the usual one of what is late must explain beyond it: on a slow clock two cushions are as good as a delay.
const UNUSUAL: f64 = 8.0;

/// Times each late meter that stands out anew; all of them where as much lateness was allowed for as a sound meter may have: what else was
/// allowed for may then stand in for the rest.
pub(super) fn retime(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    contenders: &mut [Contender],
) {
    let at_its_latest = state.iter().any(as_late_as_is_sound);
    let mut late: Vec<&mut Contender> = (contenders.iter_mut())
        .filter(|c| is_late_meter(c.effect.about()) && (at_its_latest || stands_late(record, c)))
        .collect();
    let price = |one: &Applied| {
        let usual = one.effect.about().of_strength(one.parameters[0]);
        if one.parameters == usual {
            0.0
        } else {
            UNUSUAL
        }
    };
    // Allowances may stand in for part of either form, so each form is timed together with them.
    let forms = (late.iter()).flat_map(|c| shapes(&c.best.applied));
    let forms: Vec<Applied> = forms.collect();
    let timed = apiece(forms, |mut one| {
        let (time_s, evidence) = retimed(record, gate, state, &one)?;
        one.parameters[0] = time_s;
        Some((one, evidence))
    });
    let timed: Vec<(Applied, f64)> = timed.into_iter().flatten().collect();
    late.par_iter_mut().with_max_len(1).for_each(|c| {
        let own = price(&c.best.applied);
        // It pays for the places it could have been, as before.
        let places = (c.best.evidence - c.evidence).max(0.0);
        c.evidence -= own;
        c.formed -= own;
        let id = c.id();
        let forms = timed.iter().filter(|of| of.0.id() == id);
        let forms = forms.map(|(one, evidence)| (one, *evidence, places + price(one)));
        let best = forms.max_by(|a, b| (a.1 - a.2).total_cmp(&(b.1 - b.2)));
        let Some((one, evidence, paid)) = best else {
            return;
        };
        if evidence - paid > c.evidence {
            // The difference of these two is what it paid, as for any contender.
            c.best = Candidate {
                evidence,
                ..weigh(record, gate, state, one.clone())
            };
            c.evidence = evidence - paid;
            c.formed = c.evidence;
        }
    });
}

/// Takes from late meters that stand out what they owe to the meter's noise.
pub(super) fn take_off_what_noise_brings(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    contenders: &mut [Contender],
) {
    /// E-folds beyond which a late meter owes too little to it to matter. Set by hand.
    const BEYOND_DOUBT: f64 = 400.0;
    let mut late: Vec<&mut Contender> = (contenders.iter_mut())
        .filter(|c| stands_late(record, c) && c.evidence < BEYOND_DOUBT)
        .collect();
    if late.is_empty() {
        return;
    }
    let effects: Vec<Applied> = late.iter().map(|c| c.best.applied.clone()).collect();
    let owed = owed_to_meter_noise(record, gate, state, &effects);
    for (c, owed) in late.iter_mut().zip(owed) {
        debug!("{} owes {owed:.1} to the meter's noise", c.id());
        c.evidence -= owed;
        c.formed -= owed;
    }
}

/// An effect in each of the forms that are tried of it, its strength as it is.
fn shapes(one: &Applied) -> Vec<Applied> {
    let forms =
        (one.effect.about().parameters.iter().zip(&one.parameters)).map(|(p, v)| match p.role {
            Role::Shape(values) => values.to_vec(),
            _ => vec![*v],
        });
    let forms: Vec<Vec<f64>> = forms.collect();
    product(&forms)
        .into_iter()
        .map(|parameters| Applied::new(one.effect, parameters))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{UNUSUAL, retime, shapes};
    use crate::contest::{Contender, contest};
    use crate::record::Record;
    use crate::relations::Applied;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, drilled, one};
    use crate::timing::retimed;
    use dgd_effects::find;

    fn of<'c>(contenders: &'c mut [Contender], id: &str) -> &'c mut Contender {
        let it = |c: &&mut Contender| c.id() == id;
        contenders.iter_mut().find(it).unwrap()
    }

    /// Drilling in which the return flow's meter is 9 s late, and what is weighed about nothing else.
    fn late() -> (Record, Tangent, Vec<Contender>) {
        let record = drilled(Hidden {
            late_s: 9.0,
            ..Hidden::default()
        });
        let gate = Tangent::beside(&record, &[], &[], Bend::Lean).unwrap();
        let contenders = contest(&record, &gate, &[]);
        (record, gate, contenders)
    }

    #[test]
    fn a_store_is_tried_in_each_of_its_forms_and_a_delay_has_one() {
        let tried = |id: &str, parameters: &[f64]| -> Vec<Vec<f64>> {
            let shapes = shapes(&one(id, parameters));
            shapes.into_iter().map(|a| a.parameters).collect()
        };
        assert_eq!(tried("return_flow_delay", &[9.0]), [[9.0]]);
        let store = tried("line_gas_storage", &[9.0, 0.5]);
        assert_eq!(store, [[9.0, 0.0], [9.0, 0.5]]);
    }

    #[test]
    fn late_meters_that_stand_out_are_timed_again() {
        let (record, gate, known) = late();
        let wrong = one("return_flow_delay", &[5.0]);
        let disturbed = |evidence: f64| {
            let mut now = known.clone();
            let delay = of(&mut now, "return_flow_delay");
            delay.best.applied = wrong.clone();
            (delay.best.evidence, delay.evidence) = (evidence + 2.0, evidence);
            of(&mut now, "line_gas_storage").evidence = 0.0;
            retime(&record, &gate, &[], &mut now);
            of(&mut now, "return_flow_delay").clone()
        };
        let hidden = disturbed(4.0);
        assert_eq!(hidden.best.applied.parameters, wrong.parameters);
        assert_eq!(hidden.evidence, 4.0);
        let again = disturbed(40.0);
        let time_s = again.best.applied.parameters[0];
        assert!((time_s - 9.0).abs() < 1.0, "{time_s}");
        let best = (time_s, again.best.evidence);
        assert_eq!(Some(best), retimed(&record, &gate, &[], &wrong));
        // It pays for the places that it could have been, as before.
        assert_eq!(again.evidence, best.1 - 2.0);
        assert_eq!(again.formed, again.evidence);
    }

    #[test]
    fn beside_a_meter_as_late_as_is_sound_all_that_is_late_is_timed_again() {
        let record = drilled(Hidden {
            late_s: 9.0,
            ..Hidden::default()
        });
        let effect = find("return_flow_delay").unwrap();
        let timed = |allowed_s: f64| {
            let state = [Applied::allowed(effect, allowed_s)];
            let gate = Tangent::beside(&record, &state, &[], Bend::Lean).unwrap();
            let mut now = contest(&record, &gate, &state);
            for id in ["return_flow_delay", "line_gas_storage"] {
                let c = of(&mut now, id);
                c.best.applied.parameters[0] = 3.0;
                (c.evidence, c.formed) = (0.0, 0.0);
            }
            retime(&record, &gate, &state, &mut now);
            ["return_flow_delay", "line_gas_storage"]
                .map(|id| of(&mut now, id).best.applied.parameters[0])
        };
        let latest = *effect.about().search.allowance.last().unwrap();
        assert!(timed(latest).into_iter().all(|time_s| time_s > 5.0));
        assert_eq!(timed(latest - 0.5), [3.0, 3.0]);
    }

    #[test]
    fn an_unusual_form_pays_for_itself() {
        let (record, gate, mut now) = late();
        // More than any form shows: what is known stays, and pays for its form.
        let mut paid = |spread: f64| {
            let c = of(&mut now, "line_gas_storage");
            c.best.applied.parameters = vec![4.0, spread];
            (c.best.evidence, c.evidence, c.formed) = (1e9, 1e9, 1e9);
            retime(&record, &gate, &[], &mut now);
            let c = of(&mut now, "line_gas_storage");
            (1e9 - c.evidence, 1e9 - c.formed)
        };
        let store = find("line_gas_storage").unwrap().about();
        let usual = store.of_strength(4.0)[1];
        assert_eq!(paid(usual), (0.0, 0.0));
        assert_eq!(paid(0.5 - usual), (UNUSUAL, UNUSUAL));
    }
}
