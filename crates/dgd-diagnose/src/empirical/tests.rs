//! Claims about corrections: that they draw what is left over, where it is, and nothing where nothing is.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod crosstalk;
mod episodes;
mod flow_errors;
mod periods;
mod ranges;

use super::drawn::range;
use super::{
    Correction, DRAWN, again, busiest, correction, corrections, excess, hold_to, hurdle, plausible,
    size, without,
};
use crate::ablation::Step;
use crate::layout::{BALANCE_BLOCKS, Section};
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{BLOCK_S, FLOW_M3_S, Hidden, SPEED_PCT, drilled, normals};
use dgd_effects::{Curve, KNOTS, Place, Quantity, Relation};
use dgd_lsq::dot;

pub(super) const LENGTH_S: f64 = 5400.0;

const ALONG_INLET: (Place, Quantity) = (Place::Friction, Quantity::InletPressure);
const INLET_DRIFT: (Place, Quantity) = (Place::InletReading, Quantity::Time);

/// A wave and a half over the recording.
fn wave(t: f64) -> f64 {
    (1.5 * std::f64::consts::TAU * t / LENGTH_S).sin()
}

/// How large it is in each place: some times the accuracy of instruments.
pub(super) fn size_in(place: Place) -> f64 {
    match place {
        Place::Head => 4e4,
        Place::Balance => 1.5e-3,
        Place::MeterFactor => 0.03,
        _ => 3e4,
    }
}

/// Drilling in which one place is off by a curve of the sample.
pub(super) fn off_by(place: Place, size: f64, curve: impl Fn(&Record, usize) -> f64) -> Record {
    let mut record = drilled(Hidden::default());
    let sound = record.clone();
    for i in 0..record.t_s.len() {
        let by = size * curve(&sound, i);
        // The head is `45e5·(w/70)² − 5e5·(q/0.04)²`, here of the speed and flow that were measured.
        let loss = 5e5 * (sound.flow[i] / FLOW_M3_S).powi(2);
        let head = 45e5 * (sound.speed[i] / SPEED_PCT).powi(2) - loss;
        let turned = |by: f64| SPEED_PCT * ((head + by + loss) / 45e5).sqrt();
        match place {
            // The line resists more and the pump lifts as much more.
            Place::Friction => {
                (record.outlet[i], record.speed[i]) = (sound.outlet[i] + by, turned(by))
            }
            // The pump lifts the same at a lower speed.
            Place::Head => record.speed[i] = turned(-by),
            Place::Balance => record.mud_pump[i] -= by,
            Place::InletReading => record.inlet[i] += by,
            Place::MeterFactor => record.flow[i] /= 1.0 + by,
            _ => record.outlet[i] += by,
        }
    }
    record.outlets = vec![record.outlet.clone()];
    record.filled.mud_pump.clone_from(&record.mud_pump);
    record.filled.speed.clone_from(&record.speed);
    record.filled.flow.clone_from(&record.flow);
    record.filled.inlet.clone_from(&record.inlet);
    record.filled.outlet.clone_from(&record.outlet);
    record
}

fn waving(place: Place) -> Record {
    off_by(place, size_in(place), |record, i| wave(record.t_s[i]))
}

pub(super) fn loose(record: &Record) -> Tangent {
    Tangent::at(record, &[], &[], Bend::Loose).unwrap()
}

/// A correction that is nothing but its place, knots and evidence.
pub(super) fn made(place: Place, quantity: Quantity, knots: &[f64], evidence: f64) -> Correction {
    Correction {
        size: size(place, knots),
        curve: Curve::new(place, quantity, (0.0, LENGTH_S), knots.to_vec()),
        signature: Vec::new(),
        evidence,
        choice: 0.0,
        owed: 0.0,
        freedom: 3.0,
        borne: evidence,
        least: place.least(),
        seen: None,
        times: 1.0,
    }
}

/// Its knots less their mean; in the balance, which holds no constant of its own, as they are.
fn centred(place: Place, knots: &[f64]) -> Vec<f64> {
    let mean = if place == Place::Balance {
        0.0
    } else {
        knots.iter().sum::<f64>() / knots.len() as f64
    };
    knots.iter().map(|k| k - mean).collect()
}

#[test]
fn a_correction_along_time_draws_what_its_place_is_off_by() {
    for place in DRAWN {
        let record = waving(place);
        let tangent = loose(&record);
        let found = correction(&record, &tangent, &[], &[], (place, Quantity::Time)).unwrap();
        assert!(
            found.evidence > hurdle(&found),
            "{place:?}: {}",
            found.evidence
        );
        assert!(found.claim() < found.evidence && found.claim() > found.evidence - 5.0);
        assert!(
            found.freedom > 3.0 && found.freedom < KNOTS as f64,
            "{}",
            found.freedom
        );
        assert!(plausible(&found));
        let curve = &found.curve;
        assert_eq!((curve.place, curve.quantity), (place, Quantity::Time));
        assert_eq!((curve.from, curve.to), (0.0, LENGTH_S));
        let truth: Vec<f64> = (0..KNOTS)
            .map(|k| size_in(place) * wave(LENGTH_S * k as f64 / (KNOTS - 1) as f64))
            .collect();
        let (drawn, truth) = (centred(place, &curve.knots), centred(place, &truth));
        let (own, true_size) = (dot(&drawn, &drawn), dot(&truth, &truth));
        let alike = dot(&drawn, &truth) / (own * true_size).sqrt();
        // Curves that are fitted to a flow which is off are too flat for it, and lean where it went with the levels.
        let (least_alike, most) = if place == Place::MeterFactor {
            (0.98, 1.2)
        } else {
            (0.99, 1.1)
        };
        assert!(alike > least_alike, "{place:?}: {drawn:?}");
        // A head that leans on the inlet pressure by itself leaves a part of it for the correction.
        let least = if place == Place::Head { 0.3 } else { 0.8 };
        let size = (own / true_size).sqrt();
        assert!(size > least && size < most, "{place:?}: {size}");
        // What it says that it takes out of the rows is what it does when it is run.
        let run = tangent.signature(&record, &[Applied::from(curve)]);
        let apart: f64 = (run.iter().zip(&found.signature))
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        assert!(
            apart < 1e-3 * dot(&run, &run),
            "{place:?}: {}",
            apart / dot(&run, &run)
        );
        // A model that holds it has it again, and a sound recording has not.
        let held = again(&record, &[], curve, &[]).unwrap();
        assert_eq!(held.curve, *curve);
        let sound = drilled(Hidden::default());
        assert!(again(&sound, &[], curve, &[]).is_none());
        // Of all corrections it is the likeliest, or one of a place that its rows are shared with.
        let all = corrections(&record, &[], false);
        let best = &all[0].curve;
        let shares = (best.place.shows_in().iter()).any(|r| place.shows_in().contains(r));
        assert!(shares, "{best:?}");
        for pair in all.windows(2) {
            assert!(pair[0].evidence >= pair[1].evidence);
        }
    }
}

#[test]
fn a_correction_along_another_quantity_is_a_law_of_it() {
    // The line resists by a bar more from the lowest inlet pressures to the highest.
    let rise = 1e5;
    let record = off_by(Place::Friction, rise, |record, i| {
        let (from, to) = range(record, Quantity::InletPressure).unwrap();
        ((record.filled.inlet[i] - from) / (to - from)).clamp(0.0, 1.0)
    });
    let tangent = loose(&record);
    let found = correction(&record, &tangent, &[], &[], ALONG_INLET).unwrap();
    assert!(found.evidence > hurdle(&found));
    let knots = &found.curve.knots;
    // What is straight is drawn so, but for what its prior takes, and costs little freedom.
    assert!(knots.windows(2).all(|pair| pair[1] > pair[0]));
    // Between the elevenths at either end.
    let tenth = (knots.len() - 1) / 11;
    let drawn = (knots[10 * tenth] - knots[tenth]) / (9.0 / 11.0 * rise);
    assert!((0.8..1.1).contains(&drawn), "{knots:?}");
    assert!(found.freedom < 4.0);
}

#[test]
fn sound_drilling_has_no_correction_and_none_is_tried_that_is_the_relation_itself() {
    let record = drilled(Hidden::default());
    let found = corrections(&record, &[], false);
    for c in &found {
        assert!(c.evidence < hurdle(c), "{:?}: {}", c.curve, c.evidence);
    }
    let tried = |place: Place| {
        let there = found.iter().filter(|c| c.curve.place == place);
        let mut of: Vec<Quantity> = there.map(|c| c.curve.quantity).collect();
        of.sort_unstable();
        of
    };
    // The booster stands still here, and so does what has no topfill. A curve of the flow is the friction, one of flow or
    // speed the head; a balance along the flow's rate is timing; a reading of the inlets drifts in time alone, and the outlets'
    // moves with what else is pumped.
    use Quantity::{FlowRate, InletPressure, MudPumpFlow, PumpSpeed, ReturnFlow, SinceStart, Time};
    let of_all = [Time, InletPressure, MudPumpFlow];
    let with = |more: &[Quantity]| [&of_all[..], more].concat();
    assert_eq!(
        tried(Place::Friction),
        with(&[PumpSpeed, SinceStart, FlowRate])
    );
    assert_eq!(tried(Place::Head), with(&[SinceStart, FlowRate]));
    assert_eq!(
        tried(Place::Balance),
        with(&[ReturnFlow, PumpSpeed, SinceStart])
    );
    assert_eq!(tried(Place::InletReading), [Time]);
    assert_eq!(tried(Place::OutletReading), [MudPumpFlow]);
    // The factor of a meter drifts, or depends on what it measures.
    assert_eq!(tried(Place::MeterFactor), [Time, ReturnFlow]);
    assert!(found.iter().all(|c| DRAWN.contains(&c.curve.place)));
}

#[test]
fn a_drift_of_the_inlets_is_none_that_the_risers_transmitter_has_too() {
    let mut record = waving(Place::InletReading);
    let tangent = loose(&record);
    let alone = correction(&record, &tangent, &[], &[], INLET_DRIFT).unwrap();
    let noise = normals(7, record.inlet.len());
    let riser = |drift: f64, record: &Record| -> Vec<f64> {
        (record.inlet.iter().zip(&record.t_s).zip(&noise))
            .map(|((p, t), noise)| {
                p - drift * size_in(Place::InletReading) * wave(*t) - 3e5 + 500.0 * noise
            })
            .collect()
    };
    // It knows of none: it bears the drift out.
    record.riser = Some(riser(1.0, &record));
    let borne = correction(&record, &tangent, &[], &[], INLET_DRIFT).unwrap();
    assert!(borne.evidence > alone.evidence + 20.0);
    // And it is drawn better than without.
    let knots = |c: &Correction| centred(Place::InletReading, &c.curve.knots);
    let truth: Vec<f64> = (0..KNOTS)
        .map(|k| size_in(Place::InletReading) * wave(LENGTH_S * k as f64 / (KNOTS - 1) as f64))
        .collect();
    let truth = centred(Place::InletReading, &truth);
    let off = |c: &Correction| -> f64 {
        knots(c)
            .iter()
            .zip(&truth)
            .map(|(a, b)| (a - b).powi(2))
            .sum()
    };
    assert!(off(&borne) < off(&alone) && off(&borne) < 0.02 * dot(&truth, &truth));
    record.riser = Some(riser(0.0, &record));
    assert!(correction(&record, &tangent, &[], &[], INLET_DRIFT).is_none());
    // Of another place it is no witness.
    assert!(correction(&record, &tangent, &[], &[], (Place::Head, Quantity::Time)).is_some());
}

#[test]
fn a_constant_is_a_correction_of_the_balance_alone() {
    for place in DRAWN.into_iter().filter(|p| *p != Place::MeterFactor) {
        let balance = place == Place::Balance;
        let size = if balance { 3e-3 } else { 2e4 };
        let record = off_by(place, size, |_, _| 1.0);
        let found =
            correction(&record, &loose(&record), &[], &[], (place, Quantity::Time)).unwrap();
        assert_eq!(
            found.evidence > hurdle(&found),
            balance,
            "{place:?}: {}",
            found.evidence
        );
        if !balance {
            // Elsewhere the relation holds it already, and a curve that explains nothing pays for its freedom.
            assert!(found.evidence < -3.0);
            continue;
        }
        assert!(found.freedom < 1.1);
        for knot in &found.curve.knots {
            assert!((knot / size - 1.0).abs() < 0.1, "{knot}");
        }
    }
}

#[test]
fn the_busiest_ten_minutes_are_those_in_which_most_is_explained() {
    let record = drilled(Hidden::default());
    let mut tangent = loose(&record);
    let layout = tangent.layout;
    let owed = |tangent: &Tangent, signature: &[f64]| busiest(&record, tangent, signature);
    // A row of residual 2 that is explained whole is worth 2, by one that does half of it 1.5.
    tangent.off.fill(2.0);
    let rows = |blocks: &[(usize, usize)], value: f64| {
        let mut signature = vec![0.0; layout.len()];
        for (from, to) in blocks {
            signature[*from..*to].fill(value);
        }
        signature
    };
    assert_eq!(600.0 / BLOCK_S, 60.0);
    for (blocks, expected) in [
        (&[(100, 110)][..], 20.0),
        (&[(100, 160)], 120.0),
        (&[(100, 161)], 120.0),
        (&[(100, 300)], 120.0),
        (&[(0, 30)], 60.0),
        (&[(520, 540)], 40.0),
        // Two bursts ten minutes apart are not one; within ten minutes they are.
        (&[(100, 110), (170, 190)], 40.0),
        (&[(100, 110), (140, 160)], 60.0),
    ] {
        assert!(
            (owed(&tangent, &rows(blocks, 2.0)) - expected).abs() < 1e-9,
            "{blocks:?}"
        );
        assert!((owed(&tangent, &rows(blocks, 1.0)) - 0.75 * expected).abs() < 1e-9);
    }
    // What makes it worse is worth nothing.
    assert_eq!(owed(&tangent, &rows(&[(100, 110)], -1.0)), 0.0);
    assert_eq!(owed(&tangent, &rows(&[(100, 110)], 5.0)), 0.0);
    // Rows of the head at the same time add to those of the friction, and a row of the balance counts at its time.
    let (head, mass) = (
        layout.rows(Section::Head).start,
        layout.rows(Section::Balance).start,
    );
    let k = 100 / BALANCE_BLOCKS;
    let at_once = rows(
        &[
            (100, 110),
            (head + 100, head + 110),
            (mass + k, mass + k + 4),
        ],
        2.0,
    );
    assert!((owed(&tangent, &at_once) - 48.0).abs() < 1e-9);
    let apart = rows(
        &[
            (100, 110),
            (head + 200, head + 210),
            (mass + 100, mass + 104),
        ],
        2.0,
    );
    assert!((owed(&tangent, &apart) - 20.0).abs() < 1e-9);
}

#[test]
fn a_correction_pays_for_its_busiest_ten_minutes() {
    // The line resists more once, for some minutes, or again and again.
    let once = |record: &Record, i: usize| {
        if (record.t_s[i] - 2700.0).abs() < 200.0 {
            1.0
        } else {
            0.0
        }
    };
    for (mut record, steady) in [
        (off_by(Place::Friction, 6e4, once), false),
        (waving(Place::Friction), true),
    ] {
        let tangent = loose(&record);
        let drawn = |record: &Record| {
            let along = (Place::Friction, Quantity::Time);
            correction(record, &tangent, &[], &[], along).unwrap()
        };
        let paid = drawn(&record);
        record.without = vec![Step::Busiest];
        let free = drawn(&record);
        assert!(
            (free.evidence - busiest(&record, &tangent, &free.signature) - paid.evidence).abs()
                < 1e-9
        );
        assert!(free.evidence > hurdle(&free));
        assert_eq!(
            paid.evidence > hurdle(&paid),
            steady,
            "{} {}",
            free.evidence,
            paid.evidence
        );
    }
}

#[test]
fn what_some_blocks_alone_show_is_taken_from_corrections_of_their_relation() {
    let sound = drilled(Hidden::default());
    let waving = waving(Place::Friction);
    let blocks: Vec<bool> = (0..sound.blocks).map(|b| b % 24 < 6).collect();
    let hold = |record: &Record, blocks: &[bool], found: &mut [Correction]| {
        for (k, alone) in without(record, blocks, &[], found, Relation::ReturnLineFriction) {
            hold_to(&mut found[k], alone);
        }
    };
    let held = |record: &Record, blocks: &[bool], c: Correction| {
        let mut found = vec![c];
        hold(record, blocks, &mut found);
        found[0].evidence
    };
    let claimed =
        |place: Place, evidence: f64| made(place, Quantity::Time, &[1e4; KNOTS], evidence);
    // Sound drilling shows none of it elsewhere.
    assert!(held(&sound, &blocks, claimed(Place::Friction, 100.0)) < 5.0);
    // Elsewhere there is enough of it: it keeps all that it has.
    assert_eq!(held(&waving, &blocks, claimed(Place::Friction, 1e3)), 1e3);
    // Without such blocks, of another relation, or with less than half of its hurdle it is not asked.
    assert_eq!(
        held(
            &sound,
            &vec![false; sound.blocks],
            claimed(Place::Friction, 100.0)
        ),
        100.0
    );
    assert_eq!(held(&sound, &blocks, claimed(Place::Head, 100.0)), 100.0);
    let least = hurdle(&claimed(Place::Friction, 0.0));
    assert_eq!(
        held(&sound, &blocks, claimed(Place::Friction, 0.49 * least)),
        0.49 * least
    );
    assert!(held(&sound, &blocks, claimed(Place::Friction, 0.51 * least)) < 0.3 * least);
    // One that is held beside others does not take them with it.
    let mut found = vec![
        claimed(Place::Friction, 100.0),
        claimed(Place::Head, 100.0),
        claimed(Place::Friction, 1.0),
    ];
    hold(&sound, &blocks, &mut found);
    assert!(found[0].evidence < 5.0);
    assert_eq!((found[1].evidence, found[2].evidence), (100.0, 1.0));
}

#[test]
fn what_a_late_meter_leaves_on_the_way_to_another_flow_is_no_law_of_the_friction() {
    let mut record = drilled(Hidden {
        late_s: 4.0,
        ..Hidden::default()
    });
    let friction = |record: &Record| -> Vec<(Quantity, f64, f64)> {
        let mut of: Vec<(Quantity, f64, f64)> = (corrections(record, &[], false).iter())
            .filter(|c| c.curve.place == Place::Friction)
            .map(|c| (c.curve.quantity, c.evidence, hurdle(c)))
            .collect();
        of.sort_by_key(|c| c.0);
        of
    };
    let held = friction(&record);
    record.without = vec![Step::Flowing];
    let free = friction(&record);
    assert_eq!(held.len(), free.len());
    assert!(free.iter().any(|c| c.1 > c.2), "{free:?} {held:?}");
    for (free, held) in free.iter().zip(&held) {
        assert!(held.1 <= free.1);
        assert!(held.1 < held.2, "{free:?} {held:?}");
    }
}

#[test]
fn along_what_moves_by_a_last_digit_there_is_no_correction() {
    let mut record = drilled(Hidden::default());
    let tangent = loose(&record);
    assert!(correction(&record, &tangent, &[], &[], ALONG_INLET).is_some());
    for (i, p) in record.filled.inlet.iter_mut().enumerate() {
        *p = 164e5 + 1e-6 * i as f64;
    }
    assert!(correction(&record, &tangent, &[], &[], ALONG_INLET).is_none());
}

#[test]
fn ten_minutes_count_for_no_more_than_what_would_show_there() {
    let record = drilled(Hidden::default());
    let mut tangent = loose(&record);
    let layout = tangent.layout;
    let rows = layout.rows(Section::Friction);
    let owed = |tangent: &Tangent, of: f64| {
        let mut signature = vec![0.0; layout.len()];
        signature[rows.clone()].fill(1.0);
        excess(&record, tangent, &signature, of)
    };
    // What is there all the time, as it is expected or half as large again, owes nothing to any ten minutes.
    for off in [1.0, 1.5] {
        tangent.off.fill(0.0);
        tangent.off[rows.clone()].fill(off);
        assert_eq!(owed(&tangent, 1.0), 0.0);
    }
    // Of 60 blocks that hold 9 in place of 1, in a window with an energy of 60: 60 (9 - 1/2) - 60 - 3 sqrt(60).
    tangent.off[rows.start + 100..rows.start + 160].fill(9.0);
    assert!((owed(&tangent, 1.0) - (60.0 * 7.5 - 3.0 * 60.0_f64.sqrt())).abs() < 1e-9);
    // Of half the strength, a quarter of the energy.
    let half = 60.0 * (4.5 - 0.125) - 15.0 - 3.0 * 15.0_f64.sqrt();
    assert!((owed(&tangent, 0.5) - half).abs() < 1e-9);
}
