//! Claims about the conditions on what stands out.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{
    Contender, again, alike, at_bound, contest, doubtful, hurdle, keep_within_bounds, material,
    solved, stands, sustained, times,
};
use crate::ablation::Step;
use crate::record::Record;
use crate::relations::{Applied, Blocks};
use crate::scan::{Candidate, weigh};
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{
    BLOCK_S, FLOW_M3_S, Hidden, INFLUX_S, SPEED_PCT, drilled, one, steady, tangent_at,
};
use dgd_effects::find;
use dgd_lsq::dot;

/// A candidate whose strength solves to `solved`.
fn candidate(applied: Applied, signature: &[f64], solved: f64) -> Candidate {
    let energy = dot(signature, signature);
    Candidate {
        applied,
        signature: signature.to_vec(),
        energy,
        score: solved * energy,
        evidence: 10.0,
    }
}

/// Middles of the blocks that are left out, s from the start.
fn left_out(record: &Record, applied: &Applied) -> Option<Vec<f64>> {
    let out = doubtful(record, &candidate(applied.clone(), &[1.0], 1.0))?;
    let blocks = (0..record.blocks).filter(|b| out[*b]);
    Some(blocks.map(|b| (b as f64 + 0.5) * BLOCK_S).collect())
}

/// Middles of the blocks within some stretches.
fn within(record: &Record, stretches: &[(f64, f64)]) -> Vec<f64> {
    (0..record.blocks)
        .map(|b| (b as f64 + 0.5) * BLOCK_S)
        .filter(|t| stretches.iter().any(|(from, to)| (*from..*to).contains(t)))
        .collect()
}

#[test]
fn only_what_comes_and_goes_is_sought_again_and_only_at_other_times() {
    let kick = |from: f64| one("influx", &[3e-3, from, 600.0, 0.15]);
    let state = [kick(1000.0)];
    for (from, acts) in [
        (500.0, true),
        (1500.0, true),
        (300.0, false),
        (1700.0, false),
    ] {
        assert_eq!(again(&state, &kick(from), (0.0, 5400.0)), acts, "{from}");
    }
    assert!(!again(
        &state,
        &one("line_leak", &[1e-3, 1200.0]),
        (0.0, 5400.0)
    ));
    let (from, lasts, rise) = INFLUX_S;
    let again_s = 2200.0;
    let record = drilled(Hidden {
        influx_m3_s: 3e-3,
        again_s,
        ..Hidden::default()
    });
    let state = [one("influx", &[3e-3, from, lasts, rise])];
    let contenders = contest(&record, &tangent_at(&record, &state), &state);
    let second = &contenders[0];
    assert_eq!(second.id(), "influx");
    assert!(
        second.evidence > hurdle(&record, &second.best.applied),
        "{}",
        second.evidence
    );
    let onset = second.best.applied.parameters[1];
    assert!((onset - from - again_s).abs() < 0.2 * lasts, "{onset}");
}

#[test]
fn a_form_may_claim_what_it_lacks_by_no_more_than_its_error_accounts_for() {
    let claim = |id: &str, evidence: f64, formed: f64| {
        let applied = one(id, &[1e-3, 1000.0, 900.0, 0.15]);
        let contender = Contender {
            effect: applied.effect,
            best: candidate(applied.clone(), &[1.0], 1.0),
            plainest: candidate(applied, &[1.0], 1.0),
            evidence,
            formed,
            lost: 0.0,
            evened: 0.0,
            once: 0.0,
            strengths: Vec::new(),
        };
        contender.claim()
    };
    // Four times its error as a share; once where each stand has another strength, which bends at will.
    for (id, errors) in [
        ("influx", 4.0),
        ("line_restriction", 4.0),
        ("viscosity_drift", 4.0),
        ("cuttings_loading", 1.0),
    ] {
        let error = find(id).unwrap().about().search.form_error;
        assert_eq!(claim(id, 100.0, 101.0), 101.0);
        // However much its form gains: five e-folds, and that share.
        let most = |evidence: f64| claim(id, evidence, 1e9);
        assert_eq!(most(0.0), 5.0);
        assert!(((most(300.0) - most(100.0)) / 200.0 - 1.0 - errors * error).abs() < 1e-12);
    }
}

#[test]
fn five_minutes_about_either_edge_are_not_looked_at_or_a_fifth_of_what_is_short() {
    let mut record = steady(360);
    let start = 640.0;
    record.setting.span_s = (start, start + 3600.0);
    record.t_s.iter_mut().for_each(|t| *t += start);
    let passing = |from: f64, lasts: f64| one("influx", &[1e-3, start + from, lasts, 0.15]);
    let long = [(700.0, 1300.0), (2300.0, 2900.0)];
    let short = [(900.0, 1100.0), (1400.0, 1600.0)];
    for (applied, stretches) in [
        (passing(1000.0, 1600.0), &long[..]),
        (passing(1000.0, 500.0), &short),
        // What sets in and stays ends with the recording, whose end is an edge too.
        (
            one("line_leak", &[1e-3, start + 1000.0]),
            &[(700.0, 1300.0), (3300.0, 3600.0)],
        ),
    ] {
        assert_eq!(
            left_out(&record, &applied),
            Some(within(&record, stretches))
        );
    }
    assert_eq!(left_out(&record, &one("yield_stress", &[1.0])), None);
    record.without = vec![Step::Edges];
    assert_eq!(left_out(&record, &passing(1000.0, 1600.0)), None);
}

#[test]
fn an_influx_is_there_without_its_edges_and_what_is_only_edges_is_not() {
    let (from, lasts, rise) = INFLUX_S;
    let influx = one("influx", &[3e-3, from, lasts, rise]);
    let evidence = |record: &Record| {
        let gate = Tangent::at(record, &[], &[], Bend::Lean).unwrap();
        let c = weigh(record, &gate, &[], influx.clone());
        (c.evidence, sustained(record, &[], &c, &gate.rows.still))
    };
    let record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    let (whole, without) = evidence(&record);
    assert!(whole > 100.0 && without.unwrap() > 0.5 * whole);
    // A pump that is read too low for four minutes at the beginning and at the end.
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        let t = record.t_s[i];
        if (t - from - 120.0).abs() < 120.0 || (t - from - lasts + 120.0).abs() < 120.0 {
            record.mud_pump[i] -= 5e-3;
            record.filled.mud_pump[i] -= 5e-3;
        }
    }
    let (whole, without) = evidence(&record);
    assert!(
        whole > 10.0 && without.unwrap() < 0.0,
        "{whole} {without:?}"
    );
}

#[test]
fn what_comes_upon_flowing_mud_is_asked_without_the_stops() {
    let mut record = drilled(Hidden::default());
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let mut still = vec![false; record.blocks];
    let viscosity = weigh(&record, &gate, &[], one("viscosity_drift", &[0.5, 0.0]));
    // It acts from the start: without stops there is nothing to leave out.
    assert_eq!(sustained(&record, &[], &viscosity, &still), None);
    still[100..300].fill(true);
    let found = sustained(&record, &[], &viscosity, &still).unwrap();
    let without = Tangent::beside(&record, &[], &still, Bend::Lean).unwrap();
    let expected = weigh(&record, &without, &[], viscosity.applied.clone());
    assert_eq!(found, expected.evidence);
    // A gain is there at rest too.
    let gain = weigh(&record, &gate, &[], one("return_flow_gain", &[0.03]));
    assert_eq!(sustained(&record, &[], &gain, &still), None);
    record.without = vec![Step::Flowing];
    assert_eq!(sustained(&record, &[], &viscosity, &still), None);
}

#[test]
fn a_strength_that_a_straight_line_carries_beyond_its_bound_is_looked_for_within() {
    let record = drilled(Hidden::default());
    let mut gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let p = &find("viscosity_drift").unwrap().about().parameters[0];
    let at = |strength: f64| one("viscosity_drift", &[strength, 0.0]);
    for (truth, beyond) in [
        (0.5 * p.high, 10.0),
        (0.8 * p.high, 5.0),
        (0.5 * p.low, -3.0),
    ] {
        // What is left over is what the effect does, and no multiple of what a little of it does.
        gate.off = gate.signature(&record, &[at(truth)]);
        let mut c = weigh(&record, &gate, &[], at(0.1));
        c.score = beyond * c.energy;
        keep_within_bounds(&record, &gate, &[], &mut c);
        assert!((c.score / c.energy - truth).abs() < 1e-9, "{truth}");
        assert_eq!(solved(&c).parameters, [c.score / c.energy, 0.0]);
        for (s, off) in c.signature.iter().zip(&gate.off) {
            assert!((truth * s - off).abs() < 1e-9);
        }
        assert!((c.energy - dot(&c.signature, &c.signature)).abs() < 1e-9 * c.energy);
    }
    // Where no less than the bound would do, and where the straight line ends within, all stays as it is.
    for (truth, straight) in [(p.high, 10.0), (p.low, -3.0), (2.0, 3.9), (-0.4, -0.8)] {
        gate.off = gate.signature(&record, &[at(truth)]);
        let mut c = weigh(&record, &gate, &[], at(0.1));
        let energy = c.energy;
        c.score = straight * energy;
        keep_within_bounds(&record, &gate, &[], &mut c);
        assert_eq!((c.score, c.energy), (straight * energy, energy));
        let clamped = straight.clamp(p.low, p.high);
        assert!((solved(&c).parameters[0] - clamped).abs() < 1e-12);
    }
    // So does what does nothing, or has no strength of its own to be solved for.
    for (applied, energy) in [
        (at(0.1), 0.0),
        (one("pump_speed_lag", &[3.0]), 1.0),
        (one("booster_line_storage", &[100.0]), 1.0),
    ] {
        let mut c = candidate(applied.clone(), &[0.0], 0.0);
        (c.energy, c.score) = (energy, 1e9);
        keep_within_bounds(&record, &gate, &[], &mut c);
        assert_eq!((c.energy, c.score), (energy, 1e9));
        assert_eq!(solved(&c).parameters, applied.parameters);
    }
}

/// The line's friction falls to what it is with a fifth of the viscosity, evenly; of mud that thins at first, no plausible change does as much.
#[test]
fn a_strength_at_its_bound_is_looked_for_with_another_shape() {
    let mut record = drilled(Hidden::default());
    let thins = one("viscosity_drift", &[-0.8, 0.0]);
    let factor = Blocks::under(&record, &[thins]).friction_factor;
    for i in 0..record.flow.len() {
        let block = (i / record.per_block).min(factor.len() - 1);
        let friction_pa = 4e5 * (record.filled.flow[i] / FLOW_M3_S).powi(2);
        let less_pa = (1.0 - factor[block]) * friction_pa;
        // The pump turns as much more slowly.
        let square = (record.filled.speed[i] / SPEED_PCT).powi(2) - less_pa / 45e5;
        let speed = SPEED_PCT * square.sqrt();
        for outlet in [&mut record.outlet[i], &mut record.filled.outlet[i]] {
            *outlet -= less_pa;
        }
        (record.speed[i], record.filled.speed[i]) = (speed, speed);
    }
    record.outlets = vec![record.outlet.clone()];
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let mut c = weigh(&record, &gate, &[], one("viscosity_drift", &[0.1, -0.5]));
    assert!(at_bound(&solved(&c)));
    keep_within_bounds(&record, &gate, &[], &mut c);
    let [strength, bend] = solved(&c).parameters[..] else {
        panic!("two parameters");
    };
    assert!((strength + 0.8).abs() < 0.1, "{strength}");
    assert!(bend.abs() < 0.3, "{bend}");
}

#[test]
fn within_an_instruments_accuracy_nothing_is_material() {
    let least = find("return_flow_gain")
        .unwrap()
        .about()
        .search
        .least
        .unwrap();
    for (share, expected) in [
        (1.01, true),
        (0.99, false),
        (-0.99, false),
        (-1.01, true),
        (1.0, false),
    ] {
        let gain = one("return_flow_gain", &[share * least]);
        assert_eq!(material(&gain), expected, "{share}");
    }
    assert!(material(&one("influx", &[1e-9, 0.0, 900.0, 0.15])));
}

#[test]
fn a_bound_is_one_of_what_is_plausible_and_nothing_at_all_is_none() {
    for (id, at, expected) in [
        ("return_flow_gain", 1.0, true),
        ("return_flow_gain", -0.8, true),
        ("return_flow_gain", 0.99, false),
        ("return_flow_gain", -0.79, false),
        ("line_restriction", 500.0, true),
        ("line_restriction", 499.0, false),
        // Of one sign: at 0 there is none of it.
        ("line_restriction", 0.0, false),
    ] {
        assert_eq!(at_bound(&one(id, &[at, 100.0])), expected, "{id} {at}");
    }
}

#[test]
fn a_shift_of_a_transmitter_is_a_step_of_about_that_size_between_the_two() {
    let (onset, shift) = (1500.0, 4e4);
    // The first of two reads too much from some time on.
    let shifted = |first_pa: f64, until: f64| {
        let mut record = steady(360);
        // Both follow the pressure, which rises when it sets in.
        let rise = |t: &f64| if *t >= onset { 2e5 } else { 0.0 };
        let second: Vec<f64> = (record.t_s.iter().zip(&record.outlet))
            .map(|(t, p)| p + rise(t))
            .collect();
        let first = (record.t_s.iter().zip(&second))
            .map(|(t, p)| {
                p + 7e3
                    + if *t >= onset && *t < until {
                        first_pa
                    } else {
                        0.0
                    }
            })
            .collect();
        record.outlets = vec![first, second];
        record
    };
    let step = |sensor: f64, bias: f64| one("outlet_pressure_bias_step", &[bias, onset, sensor]);
    for share in [-1.0, 0.3, 0.45, 0.55, 1.0, 1.55, 1.65] {
        let seen = share > 0.5 && share < 1.6;
        let record = shifted(share * shift, f64::INFINITY);
        assert_eq!(stands(&record, &step(1.0, shift)), seen, "{share}");
        // Read too little by the second it is the same.
        assert_eq!(stands(&record, &step(2.0, -shift)), seen, "{share}");
        assert!(!stands(&record, &step(2.0, shift)) || share < 0.0);
    }
    // It must stand for most of twenty minutes.
    assert!(stands(&shifted(shift, onset + 700.0), &step(1.0, shift)));
    assert!(!stands(&shifted(shift, onset + 500.0), &step(1.0, shift)));
    // Twenty samples on either side tell it, fewer do not.
    for (gap, seen) in [(580, true), (581, false)] {
        for after in [false, true] {
            let mut record = shifted(shift, f64::INFINITY);
            let at = 750;
            let range = if after { at..at + gap } else { at - gap..at };
            record.outlets[1][range].fill(f64::NAN);
            assert_eq!(stands(&record, &step(1.0, shift)), seen, "{gap} {after}");
        }
    }
    // Of a single transmitter, and of what is no transmitter's, nobody asks.
    let mut record = shifted(0.0, f64::INFINITY);
    assert!(stands(&record, &one("line_leak", &[1e-3, onset])));
    record.outlets.truncate(1);
    assert!(stands(&record, &step(1.0, shift)));
}

#[test]
fn alike_is_what_has_more_than_a_third_in_common() {
    let applied = || one("influx", &[1e-3, 1000.0, 900.0, 0.15]);
    let first = candidate(applied(), &[3.0, 0.0], 1.0);
    for (cosine, expected) in [
        (1.0, true),
        (0.4, true),
        (0.3, false),
        (-0.3, false),
        (-0.4, true),
    ] {
        let other = [2.0 * cosine, 2.0 * (1.0_f64 - cosine * cosine).sqrt()];
        let other = candidate(applied(), &other, 1.0);
        assert_eq!(alike(&first, &other), expected, "{cosine}");
    }
    assert!(!alike(&first, &candidate(applied(), &[0.0, 0.0], 1.0)));
}

#[test]
fn contenders_are_all_that_are_not_held_each_once_and_best_first() {
    let (from, lasts, rise) = INFLUX_S;
    let record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let found = contest(&record, &gate, &[]);
    assert_eq!(found[0].id(), "influx");
    let truth = one("influx", &[3e-3, from, lasts, rise]);
    let truth = weigh(&record, &gate, &[], truth).evidence;
    // Of a grid's onsets none is its own, and it pays for all of them; nothing else comes near it.
    assert!(found[0].evidence > 2.0 * found[1].evidence && found[0].evidence < truth);
    for pair in found.windows(2) {
        assert!(pair[0].evidence >= pair[1].evidence);
    }
    for c in &found {
        assert!(c.evidence <= c.best.evidence + 1e-9, "{}", c.id());
        let hurdle = c.effect.about().search.belief.hurdle;
        let sustained = sustained(&record, &[], &c.best, &gate.rows.still);
        assert!(c.evidence <= hurdle || sustained.is_none_or(|s| c.evidence <= s));
        // The form is freed of those alone that come near the best.
        assert!(c.formed >= c.evidence);
        assert!(c.formed == c.evidence || c.evidence > 0.3 * found[0].evidence);
    }
    // What it gains by its form is what the best gains, wherever that could have been.
    let formed = gate.formed(&record, &[], &solved(&found[0].best));
    let (gain, own) = (
        formed - found[0].best.evidence,
        found[0].formed - found[0].evidence,
    );
    assert!(own > 3.0 && (own - gain).abs() < 1e-9, "{own} {gain}");
    let ids = |found: &[Contender]| {
        let mut ids: Vec<&str> = found.iter().map(|c| c.id()).collect();
        ids.sort_unstable();
        ids
    };
    let all = ids(&found);
    assert!(!all.contains(&"unknown") && !all.contains(&"heave"));
    // What is named is not sought again; what is allowed for is.
    let mut held = [one("inflow_gain", &[0.01])];
    let beside = Tangent::beside(&record, &held, &[], Bend::Lean).unwrap();
    let others: Vec<&str> = all
        .iter()
        .copied()
        .filter(|id| *id != "inflow_gain")
        .collect();
    assert_eq!(ids(&contest(&record, &beside, &held)), others);
    held[0].allowance = true;
    assert_eq!(ids(&contest(&record, &beside, &held)), all);
}

#[test]
fn without_that_step_no_form_is_freed() {
    let mut record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    record.without = vec![Step::Form];
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let found = contest(&record, &gate, &[]);
    assert!(found.iter().all(|c| c.formed == c.evidence));
}

#[test]
fn a_contender_is_settled_before_it_is_told() {
    let record = drilled(Hidden::default());
    let mut gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let change = 0.8 * find("viscosity_drift").unwrap().about().parameters[0].low;
    let truth = one("viscosity_drift", &[change, 0.0]);
    gate.off = gate.signature(&record, std::slice::from_ref(&truth));
    let found = contest(&record, &gate, &[]);
    let viscosity = (found.iter())
        .find(|c| c.id() == "viscosity_drift")
        .unwrap();
    assert!((solved(&viscosity.best).parameters[0] - change).abs() < 1e-9);
}

#[test]
fn what_a_pump_loses_is_told_as_it_is_where_the_head_does_not_lean() {
    // A thirtieth of the head for half an hour, for which the pump turns faster.
    let mut record = drilled(Hidden::default());
    for i in 900..1800 {
        let loss = 5e5 * (record.flow[i] / FLOW_M3_S).powi(2);
        let head = 45e5 * (record.speed[i] / SPEED_PCT).powi(2) - loss;
        record.speed[i] = SPEED_PCT * ((head / 0.97 + loss) / 45e5).sqrt();
    }
    record.filled.speed.clone_from(&record.speed);
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let free = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    let found = contest(&record, &gate, &[]);
    let gas = (found.iter()).find(|c| c.id() == "gas_in_pump").unwrap();
    let p = &gas.best.applied.parameters;
    assert!(
        (p[1] - 1800.0).abs() < 60.0 && (p[1] + p[2] - 3600.0).abs() < 60.0,
        "{p:?}"
    );
    let told = weigh(&record, &free, &[], gas.best.applied.clone());
    assert_eq!((gas.best.score, gas.best.energy), (told.score, told.energy));
    assert!(gas.evidence > 20.0 && gas.evidence < told.evidence - 4.0);
}

#[test]
fn what_acts_for_days_must_show_more_than_what_passes() {
    let mut record = drilled(Hidden::default());
    let hours = |from: f64, to: f64| (3600.0 * from, 3600.0 * to);
    let asked = |record: &Record, id: &str, parameters: &[f64]| {
        let one = one(id, parameters);
        let base = one.effect.about().search.belief.hurdle;
        assert_eq!(hurdle(record, &one), base * times(record, &one));
        times(record, &one)
    };
    record.setting.span_s = hours(0.5, 6.5);
    assert_eq!(asked(&record, "return_flow_gain", &[0.03]), 1.0);
    record.setting.span_s = hours(0.5, 80.5);
    assert_eq!(asked(&record, "return_flow_gain", &[0.03]), 10.0);
    // From its onset on, and never less than in hours.
    assert_eq!(asked(&record, "line_leak", &[1e-3, 40.5 * 3600.0]), 5.0);
    assert_eq!(asked(&record, "line_leak", &[1e-3, 79.5 * 3600.0]), 1.0);
    assert_eq!(asked(&record, "influx", &[1e-3, 7e4, 3e3, 0.15]), 1.0);
}
