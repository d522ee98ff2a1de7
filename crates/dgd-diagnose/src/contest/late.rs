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
