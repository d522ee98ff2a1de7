//! Claims about what a round comes to, on contenders and corrections made for it.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod gas;

use super::beside::{Beside, Second, left_of, owed_to_timing};
use super::form::{Bent, MOSTLY, ROUGH};
use super::hurdles::{HURDLES_BESIDE_UNNAMED, timed};
use super::suction::Unmeasured;
use super::{Footprint, Round, Ruling};
use crate::ablation::Step;
use crate::contest::{Contender, contest, put_on_one_scale, sets_in};
use crate::empirical::{Correction, hurdle};
use crate::layout::Section;
use crate::record::Record;
use crate::relations::Applied;
use crate::scan::{Candidate, weigh};
use crate::selection::Named;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, INFLUX_S, drilled, one, parabolas};
use dgd_effects::{Curve, Place, Quantity, find};
use dgd_lsq::dot;
use dgd_units::STANDARD_ATMOSPHERE_PA;

/// Signatures of four rows: the same, and of nothing in common.
const HERE: [f64; 4] = [3.0, 4.0, 0.0, 0.0];
const THERE: [f64; 4] = [0.0, 0.0, 5.0, 1.0];

/// An effect whose strength comes out as given; its form is as good as any.
fn contender(id: &str, parameters: &[f64], evidence: f64, signature: [f64; 4]) -> Contender {
    let applied = one(id, parameters);
    let energy = dot(&signature, &signature);
    let best = Candidate {
        score: parameters[0] * energy,
        applied,
        signature: signature.to_vec(),
        energy,
        evidence,
    };
    Contender {
        effect: best.applied.effect,
        evidence,
        formed: evidence,
        lost: 0.0,
        evened: 0.0,
        once: 0.0,
        strengths: Vec::new(),
        plainest: best.clone(),
        best,
    }
}

fn influx(evidence: f64) -> Contender {
    contender("influx", &[3e-3, 1500.0, 1300.0, 0.15], evidence, HERE)
}

fn gain(evidence: f64) -> Contender {
    contender("return_flow_gain", &[0.03], evidence, HERE)
}

/// A correction of one of the places along time.
fn correction(place: Place, evidence: f64) -> Correction {
    Correction {
        curve: Curve::new(place, Quantity::Time, (0.0, 0.0), Vec::new()),
        signature: HERE.to_vec(),
        evidence,
        choice: 0.0,
        owed: 0.0,
        freedom: 3.0,
        borne: evidence,
        size: 2.0 * place.least(),
        least: place.least(),
        seen: None,
        times: 1.0,
    }
}

/// The same along another quantity.
fn along(quantity: Quantity, mut one: Correction) -> Correction {
    one.curve.quantity = quantity;
    one
}

/// A curve along time that the catalogue does not hold.
fn always(place: Place) -> Curve {
    correction(place, 0.0).curve
}

/// What contenders and corrections that are made up would leave over is not to be asked of it.
fn sound() -> Record {
    let mut record = drilled(Hidden::default());
    record.without = vec![Step::TwoDo, Step::Corrections];
    record
}

/// A restriction of the line from half an hour on, for which the pump turns faster.
fn restricted(hidden: Hidden) -> Record {
    let mut record = drilled(hidden);
    let curves = parabolas(4e5, 45e5, 5e5);
    for i in 0..record.t_s.len() {
        if record.t_s[i] < RESTRICTED_S {
            continue;
        }
        let head = |w: f64, q: f64| curves.head_pa(w, q);
        let (w, q) = (record.speed[i], record.flow[i]);
        let lift = head(w, q) + RESTRICTION * record.velocity_head_pa(q);
        record.outlet[i] += lift - head(w, q);
        record.speed[i] = w * ((lift - head(0.0, q)) / (head(w, q) - head(0.0, q))).sqrt();
    }
    record.outlets = vec![record.outlet.clone()];
    record.filled.speed.clone_from(&record.speed);
    record.filled.outlet.clone_from(&record.outlet);
    record
}

/// Its loss coefficient, and its onset, s.
const RESTRICTION: f64 = 12.0;
const RESTRICTED_S: f64 = 1800.0;

fn round(record: &Record, contenders: Vec<Contender>, rivals: Vec<Correction>) -> Round<'_> {
    Round {
        held: 0,
        record,
        state: Vec::new(),
        gate: Tangent::at(record, &[], &[], Bend::Lean).unwrap(),
        contenders,
        known: 0,
        footprints: Vec::new(),
        suction: None,
        rivals,
        unnamed: Vec::new(),
    }
}

/// The finding that a correction through knots is told as.
fn ended(ruling: Ruling) -> Named {
    match ruling {
        Ruling::Unnamed(named) => named,
        _ => panic!("something else is told"),
    }
}

/// Name of the effect, or the place of the correction.
fn told(ruling: Ruling) -> String {
    match ruling {
        Ruling::Named(n) | Ruling::Promised { named: n, .. } => n.applied.id().to_owned(),
        Ruling::Unnamed(n) | Ruling::Seen(n) => n.applied.curve().unwrap().place.name().to_owned(),
        Ruling::Nothing => "nothing".to_owned(),
    }
}

fn logit(p: f64) -> f64 {
    (p / (1.0 - p)).ln()
}

#[test]
fn an_effect_that_leaves_much_over_only_resembles_the_cause() {
    let record = swinging();
    let balance = Place::Balance;
    let told_of = |evidence: f64, rival: f64| {
        let rivals = vec![correction(balance, rival)];
        told(round(&record, vec![influx(evidence)], rivals).ruling())
    };
    assert_eq!(told_of(100.0, 60.0), balance.name());
    // Of much that either explains it is little, and where sound recordings show as much it is not asked.
    assert_eq!(told_of(1e4, 6e3), "influx");
    assert_eq!(told_of(6e3, 1e4), "influx");
    assert_eq!(told_of(100.0, 10.0), "influx");
    // In rows that the rival does not enter nothing is left over.
    let head = vec![correction(Place::Head, 300.0)];
    assert_eq!(
        told(round(&record, vec![influx(100.0)], head).ruling()),
        "influx"
    );
}

/// Drilling in which what is pumped in swings about its reading, as no influx does.
fn swinging() -> Record {
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        record.mud_pump[i] += 1.5e-3 * (record.t_s[i] / 500.0).sin();
    }
    record.filled.mud_pump.clone_from(&record.mud_pump);
    record.without = vec![Step::TwoDo];
    record
}

#[test]
fn what_a_rival_tells_beside_an_effect_as_well_is_another_cause_and_the_larger_is_named_first() {
    // The meter reads too much and too little in turn.
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        record.flow[i] *= 1.0 + 0.03 * (record.t_s[i] / 500.0).sin();
    }
    record.filled.flow.clone_from(&record.flow);
    record.without = vec![Step::TwoDo];
    // It acts in the line, and takes nothing of that.
    let step = |evidence: f64| {
        let parameters = [1e4, 1500.0, 1.0];
        contender("outlet_pressure_bias_step", &parameters, evidence, HERE)
    };
    let rival = correction(Place::MeterFactor, 20.0);
    let told_of = |evidence: f64, of_the_meter: f64| {
        let rivals = vec![correction(Place::MeterFactor, of_the_meter)];
        told(round(&record, vec![step(evidence)], rivals).ruling())
    };
    // A correction claims three less than its evidence.
    assert_eq!(told_of(58.0, 60.0), "outlet_pressure_bias_step");
    assert_eq!(told_of(56.0, 60.0), Place::MeterFactor.name());
    // The larger, the likelier it is a cause of its own.
    for evidence in [40.0, 60.0] {
        let best = step(evidence);
        let round = round(&record, Vec::new(), Vec::new());
        let holds = Bent {
            odds: -1.0,
            sharpened: None,
        };
        let (odds, _) = Beside::of(&round, &best, &holds).resembles(&rival);
        let expected = (rival.claim() - best.claim()) / best.temperature();
        assert!((odds - expected).abs() < 1e-12, "{odds} {expected}");
    }
}

#[test]
fn what_is_left_is_told_where_the_effect_acts_or_the_rival_does() {
    let [of_the_line_itself, of_the_riser, of_the_pump] =
        ["line_restriction", "influx", "pump_wear"].map(|id| find(id).unwrap().about());
    let (line, balance) = (Place::Friction, Place::Balance);
    let of_the_line = correction(line, 100.0);
    for (place, above, about, left) in [
        // In the rival's place whatever it tells, and in another place of the effect's relation what no sound recording shows.
        (line, false, of_the_line_itself, true),
        (Place::MeterFactor, true, of_the_line_itself, true),
        (Place::MeterFactor, false, of_the_line_itself, false),
        (balance, true, of_the_line_itself, false),
        // A rival of another relation is told by what acts there, too.
        (line, false, of_the_riser, true),
        (balance, true, of_the_riser, true),
        (balance, false, of_the_riser, false),
        (Place::OutletReading, true, of_the_riser, true),
        (Place::OutletReading, false, of_the_riser, false),
        (balance, true, of_the_pump, false),
    ] {
        let hurdle = hurdle(&correction(place, 0.0));
        let one = correction(place, if above { hurdle + 5.0 } else { 3.5 });
        let said = format!("{} {above} beside {}", place.name(), about.id);
        // Of that what it claims in the rival's place, and what it claims beyond a sound recording's in another.
        let expected = match (left, place == of_the_line.curve.place) {
            (false, _) => 0.0,
            (true, true) => one.claim(),
            (true, false) => 2.0,
        };
        let told = left_of(&one, &of_the_line, about);
        assert!((told - expected).abs() < 1e-12, "{said}: {told}");
    }
}

#[test]
fn friction_along_the_speed_is_left_beside_another_rival_only_beyond_what_sound_recordings_show() {
    let [yields, late] = ["yield_stress", "return_flow_delay"].map(|id| find(id).unwrap().about());
    let [time, speed] = [Quantity::Time, Quantity::PumpSpeed];
    let usual = hurdle(&along(speed, correction(Place::Friction, 0.0)));
    for (about, of, quantity, evidence, left) in [
        (yields, time, speed, usual, 0.0),
        (yields, time, speed, usual + 8.0, 5.0),
        (yields, speed, speed, 20.0, 17.0),
        (yields, speed, time, 20.0, 17.0),
        (yields, time, Quantity::FlowRate, 20.0, 17.0),
        // Of what makes a meter late it is a part.
        (late, speed, speed, usual, 0.0),
        (late, speed, speed, usual + 8.0, 5.0),
        (late, speed, time, 20.0, 17.0),
    ] {
        let rival = along(of, correction(Place::Friction, 100.0));
        let one = along(quantity, correction(Place::Friction, evidence));
        let told = left_of(&one, &rival, about);
        assert!((told - left).abs() < 1e-9, "{evidence}: {told}");
    }
}

#[test]
fn what_tells_as_much_without_an_effect_is_not_left_over_by_it() {
    let record = sound();
    let rivals = vec![correction(Place::MeterFactor, 100.0)];
    let round = round(&record, Vec::new(), rivals);
    let best = influx(50.0);
    let holds = Bent {
        odds: -1.0,
        sharpened: None,
    };
    let beside = Beside::of(&round, &best, &holds);
    for (beside_it, before) in [(89.0, false), (91.0, true), (199.0, true), (201.0, false)] {
        let one = correction(Place::MeterFactor, beside_it);
        assert_eq!(beside.told_before(&one), before, "{beside_it}");
    }
    // Of another place nothing was told before.
    assert!(!beside.told_before(&correction(Place::Balance, 100.0)));
}

#[test]
fn an_effect_that_leaves_nothing_over_is_the_cause_whatever_knots_explain() {
    let mut record = restricted(Hidden::default());
    record.without = vec![Step::TwoDo];
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let told_of = |id: &str, parameters: &[f64], evidence: f64| {
        let mut c = contender(id, parameters, evidence, HERE);
        c.best = weigh(&record, &gate, &[], one(id, parameters));
        told(
            round(
                &record,
                vec![c],
                vec![correction(Place::MeterFactor, 100.0)],
            )
            .ruling(),
        )
    };
    for evidence in [50.0, 20.0] {
        let parameters = [RESTRICTION, RESTRICTED_S];
        assert_eq!(
            told_of("line_restriction", &parameters, evidence),
            "line_restriction"
        );
    }
    // One that leaves the restriction over is not.
    assert_eq!(
        told_of("influx", &[1e-5, 1500.0, 1300.0, 0.15], 50.0),
        Place::MeterFactor.name()
    );
}

#[test]
fn beside_what_the_catalogue_does_not_hold_only_another_relation_tells() {
    let record = sound();
    let sections = round(&record, Vec::new(), Vec::new())
        .gate
        .layout
        .sections();
    let rows = sections[3].end;
    let shows = |mut one: Contender, in_balance: f64, in_line: f64| {
        let mut signature = vec![0.0; rows];
        signature[sections[3].clone()].fill(in_balance);
        signature[sections[0].start] = in_line;
        one.best.energy = dot(&signature, &signature);
        one.best.signature = signature;
        one
    };
    let found = |unnamed: Option<Place>, in_line: f64| {
        // What the line holds more of is the likelier.
        let line = shows(
            contender("line_restriction", &[10.0, 2700.0], 300.0, HERE),
            0.0,
            1.0,
        );
        let influx = shows(influx(100.0), 1.0, in_line);
        let mut round = round(&record, vec![line, influx], Vec::new());
        round.unnamed.extend(unnamed.map(always));
        told(round.ruling())
    };
    // A tenth of what shows, and a little less or more.
    let tenth = |more: f64| (more * sections[3].len() as f64 / 9.0).sqrt();
    assert_eq!(found(None, 0.0), "line_restriction");
    let line = Some(Place::Friction);
    assert_eq!(found(line, tenth(0.99)), "influx");
    assert_eq!(found(line, tenth(1.01)), "nothing");
    let balance = Some(Place::Balance);
    assert_eq!(found(balance, 0.0), "line_restriction");
    assert_eq!(found(Some(Place::Head), 0.0), "line_restriction");
    // It must stand out by more than elsewhere.
    let at = |evidence: f64| {
        let one = shows(influx(evidence), 1.0, 0.0);
        let mut round = round(&record, vec![one], Vec::new());
        round.known = 1;
        round.unnamed.push(always(Place::Head));
        told(round.ruling())
    };
    let asked = HURDLES_BESIDE_UNNAMED * (influx(0.0).effect.about().search.belief.hurdle + 8.0);
    assert_eq!(at(asked + 0.1), "influx");
    assert_eq!(at(asked), "nothing");
}

#[test]
fn what_happens_once_may_happen_again() {
    let record = sound();
    let balance = Place::Balance;
    let episode = |from_s: f64, to_s: Option<f64>| Curve::episode(balance, (from_s, to_s), -3e-3);
    let beside = |held: Curve, found: Curve| {
        let rival = Correction {
            curve: found,
            ..correction(balance, 1e3)
        };
        let mut round = round(&record, Vec::new(), vec![rival]);
        round.unnamed.push(held);
        told(round.ruling())
    };
    let first = || episode(600.0, Some(1500.0));
    assert_eq!(
        beside(first(), episode(1500.0, Some(2400.0))),
        balance.name()
    );
    assert_eq!(beside(episode(1500.0, None), first()), balance.name());
    assert_eq!(beside(first(), episode(1499.0, Some(2400.0))), "nothing");
    assert_eq!(beside(first(), always(balance)), "nothing");
    assert_eq!(beside(always(balance), first()), "nothing");
}

#[test]
fn what_the_suction_may_lose_unseen_is_asked_beyond_the_hurdle() {
    let record = sound();
    let (effect, other) = (influx(50.0), correction(Place::Balance, 50.0));
    let mut round = round(&record, Vec::new(), Vec::new());
    let (own, of_correction) = (round.hurdle(&effect), round.unknown_hurdle(&other));
    // Of a signature of 3 and 4 a loss that goes the other way by 6 and 8 makes half of 100; one elsewhere nothing.
    for (lost, more) in [([-6.0, -8.0, 1.0, 2.0], 50.0), (THERE, 0.0)] {
        round.suction = Some(Unmeasured {
            signature: lost.to_vec(),
        });
        assert_eq!(round.hurdle(&effect), own + more);
        assert_eq!(round.unknown_hurdle(&other), of_correction + more);
        assert_eq!(round.rival_hurdle(&other), hurdle(&other) + more);
        // It is no more beside what the catalogue does not hold.
        round.unnamed = vec![always(Place::Friction)];
        assert_eq!(round.asked(&effect), HURDLES_BESIDE_UNNAMED * own + more);
        round.unnamed.clear();
        assert_eq!(round.asked(&effect), own + more);
    }
}

#[test]
fn each_further_cause_must_show_more() {
    let record = sound();
    let (effect, other) = (influx(50.0), correction(Place::Friction, 50.0));
    let own = effect.effect.about().search.belief.hurdle;
    let mut round = round(&record, Vec::new(), Vec::new());
    let mut before = 0.0;
    for (known, more) in [0.0, 8.0, 16.0, 32.0, 64.0, 128.0, 128.0]
        .into_iter()
        .enumerate()
    {
        round.known = known;
        assert_eq!(round.hurdle(&effect), own + more);
        // A correction beside what has been named, twice that and a half of its own.
        let of_correction = round.unknown_hurdle(&other) - hurdle(&other);
        let half = if known == 0 {
            0.0
        } else {
            0.5 * hurdle(&other)
        };
        assert_eq!(of_correction, half + 2.0 * more);
        assert!(of_correction >= before);
        before = of_correction;
        // What is left over of those before adds to both.
        let footprint = |evidence: f64| Footprint {
            rows: vec![true; 4],
            evidence,
            bent: 0.0,
            knots: false,
        };
        round.footprints = vec![footprint(100.0), footprint(400.0)];
        assert_eq!(round.hurdle(&effect), own + more + 15.0);
        let left = round.unknown_hurdle(&other) - hurdle(&other) - of_correction;
        assert!((left - 5.0 * 15.0).abs() < 1e-9);
        // Where one of the two is knots, or both are, it is five times as much.
        round.footprints.iter_mut().for_each(|f| f.knots = true);
        assert_eq!(round.hurdle(&effect), own + more + 75.0);
        let left = round.unknown_hurdle(&other) - hurdle(&other) - of_correction;
        assert!((left - 5.0 * 15.0).abs() < 1e-9);
        round.footprints.clear();
    }
}

#[test]
fn belief_in_an_effect_grows_by_e_in_the_odds_over_its_scale() {
    let record = sound();
    let round = round(&record, Vec::new(), Vec::new());
    let about = influx(0.0).effect.about();
    let belief = about.search.belief;
    let at = |evidence: f64| logit(round.real(&influx(evidence)));
    for evidence in [belief.hurdle, belief.hurdle + 4.0, 2.0] {
        let grown = at(evidence + belief.scale) - at(evidence);
        assert!((grown - 1.0).abs() < 1e-6, "{grown}");
    }
    // At its hurdle it is likelier than not.
    assert!(at(belief.hurdle) > 0.0 && at(0.0) < 0.0);
}

#[test]
fn what_stands_above_its_hurdle_is_named_and_nothing_below() {
    let record = sound();
    let own = influx(0.0).effect.about().search.belief.hurdle;
    for (known, over) in [(0, 0.0), (1, 8.0), (2, 16.0)] {
        let told_at = |evidence: f64| {
            let mut round = round(&record, vec![influx(evidence)], Vec::new());
            round.known = known;
            told(round.ruling())
        };
        assert_eq!(told_at(own + over + 0.1), "influx");
        assert_eq!(told_at(own + over), "nothing");
    }
    let balance = Place::Balance;
    let least = hurdle(&correction(balance, 0.0));
    let told_at = |evidence: f64| {
        let rivals = vec![correction(balance, evidence)];
        told(round(&record, Vec::new(), rivals).ruling())
    };
    assert_eq!(told_at(least + 0.1), "riser mass balance");
    assert_eq!(told_at(least), "nothing");
}

#[test]
fn the_odds_that_an_effect_only_resembles_decide_between_it_and_a_correction() {
    let record = sound();
    let balance = Place::Balance;
    let contenders = vec![
        influx(100.0),
        gain(100.0),
        contender("line_leak", &[1e-3, 2000.0], 90.0, THERE),
    ];
    let round = round(&record, contenders, Vec::new());
    let best = &round.contenders[0];
    let rival = correction(balance, 80.0);
    let second = || Second {
        applied: one("line_leak", &[1e-3, 2000.0]),
        evidence: 50.0,
    };
    let ruled =
        |odds: f64, second: Option<Second>| round.by_what_is_left(best, &rival, odds, second);
    let of = |named: &Named, id: &str| {
        let of = named.alternatives.iter().find(|a| a.0 == id);
        of.map_or(0.0, |a| a.1 / named.probability)
    };
    // What looks like the effect shares its fate.
    let Ruling::Named(named) = ruled(-1.0, None) else {
        panic!("it is not named")
    };
    assert_eq!(named.applied.id(), "influx");
    assert!((of(&named, "return_flow_gain") - 1.0).abs() < 1e-9);
    assert!((of(&named, "unknown") - 2.0 * (-1.0_f64).exp()).abs() < 1e-9);
    let unnamed = ended(ruled(1.0, None));
    assert_eq!(unnamed.applied.curve(), Some(rival.curve.clone()));
    for id in ["influx", "return_flow_gain"] {
        assert!((of(&unnamed, id) - 0.5 * (-1.0_f64).exp()).abs() < 1e-9);
    }
    // Where a second effect tells what is left over, the two are the cause if it is named, and the first is whatever comes if it leaves little.
    let Ruling::Promised {
        named,
        second: id,
        otherwise,
    } = ruled(1.0, Some(second()))
    else {
        panic!("no promise")
    };
    assert_eq!((id, of(&named, "unknown")), ("line_leak", 0.0));
    assert_eq!(otherwise.alternatives, unnamed.alternatives);
    let Ruling::Named(named) = ruled(-1.0, Some(second())) else {
        panic!("it is not named")
    };
    assert_eq!(of(&named, "unknown"), 0.0);
}

#[test]
fn in_another_relation_a_correction_must_explain_twice_as_much() {
    let record = sound();
    let friction = Place::Friction;
    for evidence in [30.0, 100.0, 1000.0] {
        let rival = |times: f64| {
            let round = round(
                &record,
                Vec::new(),
                vec![correction(friction, times * evidence)],
            );
            round.rival(&influx(evidence), -1.0).is_some()
        };
        assert!(!rival(1.9) && rival(2.5));
    }
}

#[test]
fn what_a_form_gains_is_its_own_as_long_as_it_holds() {
    let record = sound();
    let likeliest = |formed: f64| {
        let bent = Contender {
            formed,
            ..gain(103.0)
        };
        let round = round(&record, vec![influx(110.0), bent], Vec::new());
        let (best, bent) = round.best(&[]).unwrap();
        assert!(bent.odds <= 0.0, "{}", bent.odds);
        best.id()
    };
    assert_eq!(likeliest(103.0), "influx");
    // A gain is exact: what it bends by beyond a share of its evidence it owes to something else.
    assert_eq!(likeliest(111.0), "return_flow_gain");
    assert_eq!(likeliest(300.0), "influx");
}

#[test]
fn what_sound_recordings_show_too_is_no_rival_to_a_form_that_holds() {
    let record = sound();
    let wear = |evidence: f64| contender("pump_wear", &[2e-3], evidence, HERE);
    let along_pressure = Quantity::InletPressure;
    let lean = |evidence: f64| along(along_pressure, correction(Place::Head, evidence));
    let reached = hurdle(&lean(0.0));
    let rival = |evidence: f64, rivals: Vec<Correction>| {
        let round = round(&record, Vec::new(), rivals);
        let rival = round.rival(&wear(evidence), -1.0);
        rival.map(|r| (r.curve.place, r.curve.quantity))
    };
    assert_eq!(rival(40.0, vec![lean(0.9 * reached)]), None);
    let leans = Some((Place::Head, along_pressure));
    assert_eq!(rival(40.0, vec![lean(1.1 * reached)]), leans);
    // One that it hides behind, of which sound recordings show less, is one all the same.
    let both = vec![lean(0.8 * reached), correction(Place::Head, 60.0)];
    assert_eq!(rival(20.0, both), Some((Place::Head, Quantity::Time)));
}

#[test]
fn an_effect_at_the_bound_is_not_it_but_something_that_does_what_it_would() {
    let record = sound();
    let balance = Place::Balance;
    let high = influx(0.0).effect.about().parameters[0].high;
    let beyond = |evidence: f64| {
        contender(
            "influx",
            &[2.0 * high, 1500.0, 1300.0, 0.15],
            evidence,
            HERE,
        )
    };
    let rivals = || vec![correction(balance, 4.0)];
    let told_of = |contenders: Vec<Contender>, rivals: Vec<Correction>, known: usize| {
        let mut round = round(&record, contenders, rivals);
        round.known = known;
        told(round.ruling())
    };
    assert_eq!(
        told_of(vec![beyond(100.0)], rivals(), 0),
        "riser mass balance"
    );
    // Where nothing enters its relation, or something has been named before, it is nothing.
    assert_eq!(told_of(vec![beyond(100.0)], Vec::new(), 0), "nothing");
    assert_eq!(told_of(vec![beyond(100.0)], rivals(), 1), "nothing");
    assert_eq!(told_of(vec![beyond(2.0)], rivals(), 0), "nothing");
    // One that is plausible may stand for it unless it explains far less.
    let both = |evidence: f64| vec![beyond(200.0), gain(evidence)];
    assert_eq!(told_of(both(97.0), rivals(), 0), "return_flow_gain");
    assert_eq!(told_of(both(60.0), rivals(), 0), "riser mass balance");
}

#[test]
fn alternatives_are_what_explains_the_same_rows_and_no_likelier_than_the_best() {
    let record = sound();
    let with = |evidence: f64, other: Contender| {
        let contenders = vec![influx(evidence), other];
        let round = round(&record, contenders, Vec::new());
        round.alike(&round.contenders[0])
    };
    // As much evidence, as likely; more, no likelier; less, less likely.
    assert_eq!(
        with(50.0, gain(50.0)),
        [("return_flow_gain".to_owned(), 1.0)]
    );
    assert_eq!(with(50.0, gain(90.0))[0].1, 1.0);
    let less = with(50.0, gain(45.0))[0].1;
    assert!(less < 1.0 && with(50.0, gain(40.0))[0].1 < less && less > 0.05);
    // Far above the noise the same difference tells less.
    assert!(with(500.0, gain(495.0))[0].1 > less);
    assert!(with(50.0, gain(0.0)).is_empty());
    let apart = contender("return_flow_gain", &[0.03], 50.0, THERE);
    assert!(with(50.0, apart).is_empty());
    // Near the noise, a Bayes factor in full but for an e-fold and a half.
    let ratio = with(20.0, gain(17.0))[0].1.ln();
    assert!((-2.0..-1.0).contains(&ratio), "{ratio}");
}

#[test]
fn a_form_that_must_bend_only_lends_its_name_unless_earlier_ones_leave_that_over() {
    let record = sound();
    let broken = |c: Contender, gain: f64, footprints: Vec<Footprint>| {
        let mut round = round(&record, Vec::new(), Vec::new());
        round.footprints = footprints;
        round.form_broken(&c, gain)
    };
    // An influx rises as it likes, within a quarter of its evidence, and a line drains as each stop has it.
    assert!(broken(influx(100.0), 3.0 + 100.0 * ROUGH, Vec::new()).abs() < 1e-9);
    assert!(broken(influx(100.0), 20.0, Vec::new()) < 0.0);
    assert!(broken(influx(100.0), 80.0, Vec::new()) > 0.0);
    // However far a form can be off: what it may gain is a share of what there is.
    let wear = || contender("pump_wear", &[1e-3], 100.0, HERE);
    assert!(broken(wear(), 20.0, Vec::new()) < 0.0 && broken(wear(), 40.0, Vec::new()) > 0.0);
    assert!(broken(wear(), f64::NAN, Vec::new()).is_nan());
    let drains = contender("line_drainage", &[0.1, 1.0, 0.0], 100.0, HERE);
    assert_eq!(broken(drains, 1e3, Vec::new()), f64::NEG_INFINITY);
    // A gain is exact.
    assert!(broken(gain(100.0), 0.0, Vec::new()) < 0.0);
    let bent = broken(gain(100.0), 40.0, Vec::new());
    assert!(bent > 0.0 && bent < broken(gain(100.0), 80.0, Vec::new()));
    // The more there is of it the more its form may lack.
    assert!(broken(gain(400.0), 40.0, Vec::new()) < bent);
    assert!(broken(gain(1.0), 1e4, Vec::new()) <= 50.0);
    // The error of its form and three e-folds are what it may bend by at even odds.
    let error = gain(0.0).effect.about().search.form_error;
    assert!(broken(gain(100.0), 3.0 + 100.0 * error, Vec::new()).abs() < 1e-9);
    // What an effect named before leaves over is not its own.
    let left = Footprint {
        rows: vec![true; 4],
        evidence: 400.0,
        bent: 0.0,
        knots: false,
    };
    let own = left.left_over(&HERE, false);
    let beside = broken(gain(100.0), 40.0 + own, vec![left]);
    assert!((beside - bent).abs() < 1e-9);
}

#[test]
fn an_effect_that_stands_out_tells_that_there_is_what_it_resembles() {
    let record = sound();
    let weak = correction(Place::Balance, 1.0);
    let whole = |known: usize, best: bool| {
        let mut round = round(&record, vec![influx(60.0)], Vec::new());
        round.known = known;
        let best = best.then(|| (&round.contenders[0], 2.0));
        let named = ended(round.unnamed(&weak, 1.0, best));
        let others: f64 = named.alternatives.iter().map(|a| a.1).sum();
        named.probability + others
    };
    // Alone the correction is less than sound recordings show.
    assert!(whole(0, false) < 0.5);
    assert!(whole(0, true) > 0.9);
    // Beside what has been named both may be what that lacks.
    assert!(whole(1, true) < 0.5);
}

#[test]
fn beside_a_correction_stand_the_effects_of_its_relation_that_might_be_it() {
    let record = sound();
    let balance = Place::Balance;
    let high = influx(0.0).effect.about().parameters[0].high;
    let lists = |contenders: Vec<Contender>, place: Place, evidence: f64| {
        let round = round(&record, contenders, Vec::new());
        ended(round.unnamed(&correction(place, evidence), evidence, None))
    };
    let odds = |n: &Named| {
        n.alternatives
            .iter()
            .map(|a| a.1 / n.probability)
            .sum::<f64>()
    };
    // As much evidence: as likely as the correction, and no likelier however much.
    let even = lists(vec![influx(60.0)], balance, 60.0);
    assert_eq!(even.alternatives[0].0, "influx");
    assert!((odds(&even) - 1.0).abs() < 1e-9);
    assert!((odds(&lists(vec![influx(90.0)], balance, 60.0)) - 1.0).abs() < 1e-9);
    // Less is less likely, the less so the more there is to explain.
    let less = odds(&lists(vec![influx(45.0)], balance, 60.0));
    assert!(less > 0.1 && less < 1.0);
    assert!(odds(&lists(vec![influx(40.0)], balance, 60.0)) < less);
    let large = odds(&lists(vec![influx(465.0)], balance, 600.0));
    assert!(large > odds(&lists(vec![influx(15.0)], balance, 150.0)));
    // One that may not be named as it is pays for it: a thousandth is within the meter's accuracy.
    let barred = contender("return_flow_gain", &[1e-3], 60.0, HERE);
    let barred = odds(&lists(vec![barred], balance, 60.0));
    assert!(barred > 0.1 && barred < 0.5, "{barred}");
    // So does one of exact form that must bend.
    let mut bent = gain(60.0);
    bent.formed = 100.0;
    assert!(odds(&lists(vec![bent], balance, 60.0)) < 0.5);
    // Of the best it is known how far its form is broken, of others that are not exact nothing is.
    let mut rough = influx(60.0);
    rough.formed = 600.0;
    let round = round(&record, vec![rough], Vec::new());
    for (best, expected) in [
        (None, 1.0),
        (Some((&round.contenders[0], 2.0)), (-2.0_f64).exp()),
    ] {
        let named = ended(round.unnamed(&correction(balance, 60.0), 60.0, best));
        assert!((odds(&named) - expected).abs() < 1e-9);
    }
    // Another relation, no evidence, the bound: none of these.
    let beyond = contender("influx", &[2.0 * high, 1500.0, 1300.0, 0.15], 60.0, HERE);
    for (contenders, place) in [
        (vec![influx(60.0)], Place::Friction),
        (vec![influx(0.0)], balance),
        (vec![beyond], balance),
    ] {
        let alone = lists(contenders, place, 60.0);
        assert!(alone.alternatives.is_empty());
        assert_eq!(alone.applied.curve().unwrap().place, place);
        assert_eq!(
            (alone.evidence, alone.hurdle),
            (60.0, hurdle(&correction(place, 0.0)))
        );
    }
    // Alone it is likelier than not at its hurdle, and by e in the odds over two fifths of it.
    let least = hurdle(&correction(balance, 0.0));
    let at = |evidence: f64| logit(lists(Vec::new(), balance, evidence).probability);
    assert!(at(least) > 0.0 && at(0.0) < 0.0);
    assert!((at(1.4 * least) - at(least) - 1.0).abs() < 1e-9);
}

#[test]
fn what_a_second_effect_tells_bends_no_first_one_and_is_not_left_over() {
    let mut record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    let (from, lasts, rise) = INFLUX_S;
    let first = one("influx", &[3e-3, from, lasts, rise]);
    let with = |record: &Record, asked: &dyn Fn(&Round, &Contender)| {
        let gate = Tangent::at(record, &[], &[], Bend::Lean).unwrap();
        let best = weigh(record, &gate, &[], first.clone());
        let round = round(record, Vec::new(), Vec::new());
        let best = Contender {
            effect: first.effect,
            evidence: best.evidence,
            formed: best.evidence,
            lost: 0.0,
            evened: 0.0,
            once: 0.0,
            strengths: Vec::new(),
            plainest: best.clone(),
            best,
        };
        asked(&round, &best);
    };
    let holds = Bent {
        odds: -1.0,
        sharpened: None,
    };
    let friction = correction(Place::Friction, 100.0);
    with(&record, &|round, best| {
        let beside = Beside::of(round, best, &holds);
        assert!(beside.second(|_| true).is_none());
        let (odds, second) = beside.resembles(&friction);
        assert!(odds < 0.0 && second.is_none(), "{odds}");
    });
    record = restricted(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    let state = [first.clone()];
    let gate = Tangent::beside(&record, &state, &[], Bend::Lean).unwrap();
    let alone = contest(&record, &gate, &state)[0].evidence;
    assert!(alone > 100.0);
    let record_of_two = record.clone();
    with(&record, &|round, best| {
        // A second one must show 8 more than it does by itself.
        let beside = Beside::of(round, best, &holds);
        let shows = beside.second(|_| true).unwrap().evidence;
        assert!(
            (shows + 8.0 - alone).abs() < 0.02 * alone,
            "{shows} {alone}"
        );
        assert!(beside.second(|about| about.id == "influx").is_none());
        // Beside many, it must show as much more as beside the last that is written down.
        let mut many = self::round(&record_of_two, Vec::new(), Vec::new());
        for known in [4, 5, 9] {
            many.known = known;
            let beside = Beside::of(&many, best, &holds);
            let shows = beside
                .second(|_| true)
                .map_or(0.0, |second| second.evidence);
            assert!(
                (shows + 128.0 - alone).abs() < 0.02 * alone,
                "{known}: {shows}"
            );
        }
        // The restriction is left over in the friction, and told by it.
        let (odds, second) = beside.resembles(&friction);
        assert!(odds > 0.0 && second.is_some(), "{odds}");
        // Of a form that does not hold, it is what bends it, unless it shows much less than that bends by.
        let broken = |odds: f64, gain: f64| {
            let bent = Bent {
                odds,
                sharpened: Some((round.sharpened(best), gain)),
            };
            bent.unless_told(&Beside::of(round, best, &bent))
        };
        assert_eq!(broken(2.0, 0.99 * shows / MOSTLY), f64::NEG_INFINITY);
        assert_eq!(broken(2.0, 1.01 * shows / MOSTLY), 2.0);
        for odds in [0.0, -1.0] {
            assert_eq!(broken(odds, 1.0), odds);
        }
    });
    record.without = vec![Step::TwoDo];
    with(&record, &|round, best| {
        let beside = Beside::of(round, best, &holds);
        let (odds, second) = beside.resembles(&friction);
        assert!(odds > 0.0 && second.is_none(), "{odds}");
    });
}

#[test]
fn what_a_grid_and_a_straight_line_leave_over_breaks_no_form() {
    let record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let contenders = contest(&record, &gate, &[]);
    let influx = (contenders.iter()).find(|c| c.id() == "influx").unwrap();
    let round = round(&record, Vec::new(), Vec::new());
    let rough = round.form_broken(influx, influx.formed - influx.evidence);
    assert!(round.bent(influx).odds < rough.min(0.0));
}

#[test]
fn a_form_that_is_exact_or_holds_by_far_is_asked_as_it_stands() {
    let record = sound();
    let round_of = |record| round(record, Vec::new(), Vec::new());
    let bent_gain = || Contender {
        formed: 200.0,
        ..gain(100.0)
    };
    for c in [bent_gain(), influx(1000.0)] {
        let round = round_of(&record);
        let bent = round.bent(&c);
        assert_eq!(bent.odds, round.form_broken(&c, c.formed - c.evidence));
        assert!(bent.sharpened.is_none());
    }
    let mut unasked = record.clone();
    unasked.without.push(Step::Form);
    assert_eq!(
        round_of(&unasked).bent(&bent_gain()).odds,
        f64::NEG_INFINITY
    );
}

#[test]
fn a_form_is_asked_about_the_effect_and_not_about_curves_without_it() {
    // A third of the flow and more is lost before the meter from half an hour on: without it the curves lie far off.
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        if record.t_s[i] >= 1800.0 {
            let over = (record.outlet[i] - STANDARD_ATMOSPHERE_PA) / 1e6;
            let leak = 4e-3 * over.sqrt();
            record.flow[i] -= leak;
            record.filled.flow[i] -= leak;
        }
    }
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let contenders = contest(&record, &gate, &[]);
    let leak = (contenders.iter()).find(|c| c.id() == "line_leak").unwrap();
    let round = round(&record, Vec::new(), Vec::new());
    // Held against the evidence that it has beside those curves it would not hold.
    let state = round.sharpened(leak);
    let one = state.last().unwrap();
    let formed = round.gate.formed(&record, &[], one);
    let beside = weigh(&record, &round.gate, &[], one.clone()).evidence;
    assert!(round.form_broken(leak, formed - beside) > 0.0);
    assert!(round.bent(leak).odds < 0.0);
}

#[test]
fn what_is_as_good_from_the_start_on_does_not_set_in() {
    let leaking = |onset_s: f64| {
        let mut record = sound();
        for (q, t) in record.flow.iter_mut().zip(&record.t_s) {
            *q -= if *t >= onset_s { 1e-3 } else { 0.0 };
        }
        record.filled.flow.clone_from(&record.flow);
        record
    };
    // What is there from the start on passes for the wander of the meter.
    for (hidden, tried, expected) in [(2000.0, 2000.0, true), (0.0, 300.0, false)] {
        let record = leaking(hidden);
        let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
        let c = weigh(&record, &gate, &[], one("line_leak", &[1e-3, tried]));
        assert_eq!(
            sets_in(&record, &gate, &[], &c),
            expected,
            "{hidden} {tried}"
        );
    }
}

#[test]
fn what_could_not_have_shown_before_need_not_have_set_in() {
    let mut record = sound();
    let (from, to) = record.setting.span_s;
    let (low, high) = record.setting.inlet_range_pa;
    // Above the middle of its range in the second half alone.
    for (p, t) in record.inlet.iter_mut().zip(&record.t_s) {
        let share = if *t < 0.5 * (from + to) { 0.1 } else { 0.9 };
        *p = low + share * (high - low);
    }
    record.filled.inlet.clone_from(&record.inlet);
    let gate = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    for (fracture, expected) in [(0.5, true), (-1.0, false)] {
        let one = one("lost_circulation", &[1e-9, from + 300.0, fracture]);
        let c = weigh(&record, &gate, &[], one);
        assert_eq!(sets_in(&record, &gate, &[], &c), expected, "{fracture}");
    }
}

#[test]
fn of_late_meters_one_is_named_and_all_else_may_still_be() {
    let record = sound();
    let storage = || contender("line_gas_storage", &[8.0, 0.0], 100.0, HERE);
    let told_after = |state: Vec<Applied>, contenders: Vec<Contender>| {
        let mut round = round(&record, contenders, Vec::new());
        round.state = state;
        told(round.ruling())
    };
    let late = || vec![one("return_flow_delay", &[6.0])];
    assert_eq!(told_after(Vec::new(), vec![storage()]), "line_gas_storage");
    assert_eq!(told_after(late(), vec![storage()]), "nothing");
    assert_eq!(told_after(late(), vec![storage(), influx(50.0)]), "influx");
}

/// A delay, and below a store that loses 18 e-folds as it is turned round.
fn delay(evidence: f64) -> Contender {
    contender("return_flow_delay", &[8.0], evidence, HERE)
}

fn storage(evidence: f64) -> Contender {
    Contender {
        lost: 18.0,
        ..contender("line_gas_storage", &[8.0, 0.5], evidence, HERE)
    }
}

#[test]
fn how_far_a_delay_and_a_store_are_apart_bounds_how_likely_either_is() {
    let record = sound();
    let most = |contenders: Vec<Contender>| {
        let Ruling::Named(named) = round(&record, contenders, Vec::new()).ruling() else {
            panic!("nothing is named");
        };
        named.most
    };
    let even = |apart: f64| (apart / 6.3).exp() / (1.0 + (apart / 6.3).exp());
    for apart in [-17.0, 0.0, 6.3, 18.9] {
        let (found, other) = most(vec![delay(100.0), storage(82.0 - apart)]).unwrap();
        let claims = even(f64::max(apart, 0.0));
        assert!((found - claims).abs() < 1e-9, "{apart}: {found}");
        assert_eq!(other, "line_gas_storage");
    }
    // A store that stands out nowhere is what a weak delay may be.
    assert_eq!(most(vec![delay(12.0), storage(-3.0)]).unwrap().0, 0.5);
    let (found, other) = most(vec![delay(70.0), storage(90.0)]).unwrap();
    assert!((found - even(38.0)).abs() < 1e-9 && other == "return_flow_delay");
    // Alone it is bounded by nothing, and what is late for no meter is by no meter.
    assert!(most(vec![delay(100.0)]).is_none());
    assert!(most(vec![influx(100.0), storage(99.0)]).is_none());
}

#[test]
fn of_late_meters_that_are_suspected_the_likelier_is_taken() {
    let record = sound();
    let suspects = ["return_flow_delay", "line_gas_storage"].map(str::to_owned);
    for (store, taken) in [(83.0, 1), (81.0, 0)] {
        let round = round(&record, vec![delay(100.0), storage(store)], Vec::new());
        let given = round.given(&suspects).unwrap();
        assert_eq!(given.applied.id(), suspects[taken]);
    }
}

#[test]
fn late_meters_claim_what_they_are_apart_and_no_form_more() {
    let record = sound();
    let claims = |delay_of: (f64, f64), store_of: (f64, f64)| {
        let mut late = vec![delay(delay_of.0), storage(store_of.0), influx(50.0)];
        (late[0].formed, late[1].formed) = (delay_of.1, store_of.1);
        put_on_one_scale(&record, &mut late);
        assert_eq!(late[2].claim(), 50.0);
        (late[0].claim(), late[1].claim())
    };
    // The recording lasts so many hours.
    let lost = 3.4 * (record.setting.span_s.1 - record.setting.span_s.0) / 3600.0;
    assert!(lost > 1.0);
    let apart = |(delay, store): (f64, f64)| delay - store;
    assert_eq!(claims((100.0, 104.0), (90.0, 120.0)), (130.0, 120.0 + lost));
    // However far a form bends, and however little a store explains by itself.
    for delay_of in [(25.0, 25.0), (25.0, 30.0), (25.0, 90.0)] {
        for store_of in [(15.0, 15.0), (15.0, 16.0), (15.0, 90.0)] {
            let found = apart(claims(delay_of, store_of));
            assert!((found - (10.0 - lost)).abs() < 1e-9, "{found}");
        }
    }
    // What does not stand out by itself is no rival.
    assert_eq!(claims((100.0, 104.0), (5.0, 6.0)), (104.0, 6.0));
}

#[test]
fn what_two_transmitters_show_is_told_first_unless_an_effect_is_what_one_of_them_does() {
    let record = sound();
    let first = |effect: Contender, place: Place, evidence: f64, seen: bool| {
        let mut rival = correction(place, evidence);
        rival.seen = seen.then(|| rival.curve.clone());
        // Half of it is what the two tell by themselves.
        rival.borne = 0.5 * evidence;
        told(round(&record, vec![effect], vec![rival]).ruling())
    };
    let drift: fn(f64) -> Contender =
        |evidence| contender("viscosity_drift", &[0.1, 0.0], evidence, HERE);
    let step = |evidence: f64| {
        let parameters = [4e4, 1500.0, 1.0];
        contender("outlet_pressure_bias_step", &parameters, evidence, HERE)
    };
    // However much effects explain, in its relations or in others; not below its hurdle, and nothing that is drawn.
    for place in [Place::RiserReading, Place::FirstOutlet] {
        for effect in [influx as fn(f64) -> Contender, drift] {
            let id = effect(0.0).id();
            assert_eq!(first(effect(500.0), place, 100.0, true), place.name());
            assert_eq!(first(effect(500.0), place, 5.0, true), id);
            assert_eq!(first(effect(500.0), place, 100.0, false), id);
        }
    }
    // A transmitter that steps may be what parts two outlets, from seven tenths of what they show on, but no two inlets.
    let (outlet, inlet) = (Place::FirstOutlet, Place::FirstInlet);
    assert_eq!(first(step(80.0), outlet, 100.0, true), step(0.0).id());
    assert_eq!(first(step(60.0), outlet, 100.0, true), outlet.name());
    assert_eq!(first(step(500.0), inlet, 100.0, true), inlet.name());
    // What they explain of the relations as well is then held against what it claims.
    let beside = |evidence: f64, borne: f64| {
        let mut rival = correction(outlet, 100.0);
        rival.seen = Some(rival.curve.clone());
        rival.borne = borne;
        told(round(&record, vec![step(evidence)], vec![rival]).ruling())
    };
    for (evidence, borne, named) in [
        (80.0, 82.0, step(0.0).id()),
        (80.0, 84.0, outlet.name()),
        (100.0, 100.0, step(0.0).id()),
        (100.0, 130.0, outlet.name()),
    ] {
        assert_eq!(beside(evidence, borne), named, "{evidence} {borne}");
    }
}

#[test]
fn the_rival_is_of_the_effects_relation_unless_another_explains_more() {
    let record = sound();
    let (balance, friction) = (Place::Balance, Place::Friction);
    // Along the speed of the pump, sound recordings reach 110.
    let along_speed = along(Quantity::PumpSpeed, correction(friction, 120.0));
    let drag = || contender("line_restriction", &[5.0, 2000.0], 20.0, HERE);
    let rival = |best: &Contender, rivals: Vec<Correction>| {
        let round = round(&record, Vec::new(), rivals);
        let broken = round.form_broken(best, best.formed - best.evidence);
        round.rival(best, broken).map(|r| r.curve.place)
    };
    let own = || along_speed.clone();
    assert_eq!(
        rival(&drag(), vec![own(), correction(balance, 90.0)]),
        Some(friction)
    );
    assert_eq!(
        rival(&drag(), vec![correction(balance, 150.0), own()]),
        Some(balance)
    );
    // Of a form that must bend its own, though sound recordings reach as much, unless the other explains more.
    let bent = |mut c: Contender| {
        c.formed = c.evidence + 80.0;
        c
    };
    let less = || Correction {
        borne: 108.0,
        ..own()
    };
    assert_eq!(
        rival(&bent(drag()), vec![less(), correction(balance, 105.0)]),
        Some(friction)
    );
    assert_eq!(
        rival(&bent(drag()), vec![correction(balance, 150.0), less()]),
        Some(balance)
    );
    // What sound recordings do not reach is enough in its own relation, anything at all where a form must bend.
    let least = hurdle(&correction(balance, 0.0));
    let with = |share: f64| vec![correction(balance, share * least)];
    assert_eq!(rival(&influx(100.0), with(1.05)), Some(balance));
    assert_eq!(rival(&influx(100.0), with(0.95)), None);
    assert_eq!(rival(&bent(influx(100.0)), with(0.95)), Some(balance));
    assert_eq!(rival(&gain(100.0), with(0.95)), None);
    assert_eq!(rival(&bent(gain(100.0)), with(0.95)), Some(balance));
    assert_eq!(rival(&bent(gain(100.0)), with(-0.1)), None);
}

#[test]
fn what_a_broken_form_stands_for_may_sit_in_another_relation_that_it_shows_in() {
    let record = sound();
    let told_of = |formed: f64, in_head: f64, evidence: f64| {
        let head = correction(Place::Head, evidence);
        let mut round = round(&record, Vec::new(), vec![head]);
        let layout = round.gate.layout;
        let mut signature = vec![0.0; layout.len()];
        signature[layout.rows(Section::Head).start] = in_head.sqrt();
        signature[layout.rows(Section::Balance).start] = (1.0 - in_head).sqrt();
        let mut best = gain(100.0);
        best.formed = formed;
        best.best.signature = signature;
        (best.best.energy, best.best.score) = (1.0, 0.03);
        round.contenders = vec![best];
        told(round.ruling())
    };
    let least = hurdle(&correction(Place::Head, 0.0));
    assert_eq!(told_of(200.0, 0.2, 1.1 * least), "pump head");
    // Where it does not show there, where no correction stands there, and where its form holds, it is named.
    for (formed, in_head, evidence) in [
        (200.0, 0.05, 1.1 * least),
        (200.0, 0.2, 0.9 * least),
        (100.0, 0.2, 1.1 * least),
    ] {
        assert_eq!(told_of(formed, in_head, evidence), "return_flow_gain");
    }
}

#[test]
fn only_a_late_meter_that_was_named_makes_it_late() {
    let late = one("return_flow_delay", &[6.0]);
    let allowed = Applied {
        allowance: true,
        ..late.clone()
    };
    assert!(timed(&[one("pump_speed_lag", &[6.0]), late]));
    assert!(!timed(&[one("pump_speed_lag", &[6.0]), allowed]));
}

#[test]
fn a_late_meter_leaves_laws_of_the_rate_over() {
    let owed: Vec<(Place, Quantity)> = (Place::ALL.into_iter())
        .flat_map(|place| Quantity::ALL.map(|quantity| (place, quantity)))
        .filter(|(place, quantity)| owed_to_timing(&along(*quantity, correction(*place, 50.0))))
        .collect();
    let of_the_rate = Place::ALL.map(|place| (place, Quantity::FlowRate));
    assert_eq!(owed, of_the_rate);
}
