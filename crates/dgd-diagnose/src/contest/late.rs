//! Late meters, a delay or a store: fitted to the same rows, so timed and weighed alike.

use super::{Contender, hurdle};
use crate::numbers::product;
use crate::record::Record;
use crate::relations::{Applied, blurred};
use crate::scan::{Candidate, weigh};
use crate::tangent::Tangent;
use crate::timing::{is_late_meter, retimed};
use dgd_effects::Role;
use rayon::prelude::*;

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

/// E-folds that another form than the usual one of what is late must explain beyond it: on a slow clock two cushions are as good as a delay.
const UNUSUAL: f64 = 8.0;

/// Times each late meter anew where more than one stands out.
pub(super) fn retime(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    contenders: &mut [Contender],
) {
    let mut late: Vec<&mut Contender> = (contenders.iter_mut())
        .filter(|c| stands_late(record, c))
        .collect();
    if late.len() < 2 {
        return;
    }
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
    let timed = forms.into_par_iter().map(|mut one| {
        let (time_s, evidence) = retimed(record, gate, state, &one)?;
        one.parameters[0] = time_s;
        Some((one, evidence))
    });
    let timed: Vec<(Applied, f64)> = timed.flatten().collect();
    late.par_iter_mut().for_each(|c| {
        let own = price(&c.best.applied);
        // It pays for the places it could have been, as before.
        let places = (c.best.evidence - c.evidence).max(0.0);
        c.evidence -= own;
        c.formed -= own;
        let id = c.effect.about().id;
        let forms = timed.iter().filter(|of| of.0.effect.about().id == id);
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

    use super::{retime, shapes};
    use crate::contest::{Contender, contest};
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, drilled, one};

    fn of<'c>(contenders: &'c mut [Contender], id: &str) -> &'c mut Contender {
        let it = |c: &&mut Contender| c.effect.about().id == id;
        contenders.iter_mut().find(it).unwrap()
    }

    #[test]
    fn a_store_is_tried_in_each_of_its_forms_and_a_delay_has_one() {
        let delay = one("return_flow_delay", &[9.0]);
        let tried: Vec<Vec<f64>> = (shapes(&delay).into_iter()).map(|a| a.parameters).collect();
        assert_eq!(tried, [[9.0]]);
        let store = one("line_gas_storage", &[9.0, 0.5]);
        let tried: Vec<Vec<f64>> = (shapes(&store).into_iter()).map(|a| a.parameters).collect();
        assert_eq!(tried, [[9.0, 0.0], [9.0, 0.5]]);
    }

    #[test]
    fn late_meters_are_timed_again_only_where_two_of_them_stand_out() {
        let record = drilled(Hidden {
            late_s: 9.0,
            ..Hidden::default()
        });
        let gate = Tangent::beside(&record, &[], &[], Bend::Lean).unwrap();
        let known = contest(&record, &gate, &[]);
        let disturbed = |second: bool| {
            let mut now = known.clone();
            let delay = of(&mut now, "return_flow_delay");
            let places = delay.best.evidence - delay.evidence;
            delay.best.applied.parameters[0] = 5.0;
            (delay.best.evidence, delay.evidence) = (40.0 + places, 40.0);
            if !second {
                of(&mut now, "line_gas_storage").evidence = 0.0;
            }
            retime(&record, &gate, &[], &mut now);
            of(&mut now, "return_flow_delay").clone()
        };
        let alone = disturbed(false);
        assert_eq!(
            (alone.best.applied.parameters[0], alone.evidence),
            (5.0, 40.0)
        );
        let again = disturbed(true);
        let time_s = again.best.applied.parameters[0];
        assert!((time_s - 9.0).abs() < 1.0, "{time_s}");
        let before = known
            .iter()
            .find(|c| c.effect.about().id == "return_flow_delay");
        let before = before.unwrap();
        let paid = |c: &Contender| c.best.evidence - c.evidence;
        assert!((paid(&again) - paid(before)).abs() < 1e-9);
        // From another start its time ends a step beside, which costs an e-fold or two.
        let (now, then) = (again.evidence, before.evidence);
        assert!((0.99 * then..1.01 * then).contains(&now), "{now} {then}");
        assert_eq!(again.formed, again.evidence);
    }

    #[test]
    fn an_unusual_form_pays_for_itself() {
        let record = drilled(Hidden {
            late_s: 9.0,
            ..Hidden::default()
        });
        let gate = Tangent::beside(&record, &[], &[], Bend::Lean).unwrap();
        let mut now = contest(&record, &gate, &[]);
        // More than any form shows: what is known stays, and pays for its form.
        let paid = |now: &mut [Contender], id: &str, parameters: &[f64]| {
            let c = of(now, id);
            c.best.applied.parameters = parameters.to_vec();
            (c.best.evidence, c.evidence, c.formed) = (1e9, 1e9, 1e9);
            retime(&record, &gate, &[], now);
            let c = of(now, id);
            (1e9 - c.evidence, 1e9 - c.formed)
        };
        let usual = one("line_gas_storage", &[]).effect.about().of_strength(4.0);
        assert_eq!(paid(&mut now, "line_gas_storage", &usual), (0.0, 0.0));
        let mut other = usual;
        other[1] = if other[1] == 0.5 { 1.0 } else { 0.5 };
        assert_eq!(paid(&mut now, "line_gas_storage", &other), (8.0, 8.0));
    }
}
