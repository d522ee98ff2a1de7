//! Claims about corrections: that they draw what is left over, where it is, and nothing where nothing is.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

mod periods;
mod ranges;

use super::{
    Correction, DRAWN, again, busiest, correction, corrections, hold_without, hurdle, plausible,
    range, size,
};
use crate::ablation::Step;
use crate::layout::Section;
use crate::record::{BALANCE_BLOCKS, Record};
use crate::relations::Applied;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{BLOCK_S, FLOW_M3_S, Hidden, SPEED_PCT, drilled, normals};
use dgd_effects::{
    INLET_READING, KNOTS, METER_FACTOR, OUTLET_READING, PLACES, QUANTITIES, Relation, unknown,
};
use dgd_lsq::dot;

pub(super) const LENGTH_S: f64 = 5400.0;

/// A wave and a half over the recording.
fn wave(t: f64) -> f64 {
    (1.5 * std::f64::consts::TAU * t / LENGTH_S).sin()
}

/// How large it is in each place: some times the accuracy of instruments.
pub(super) const SIZES: [f64; DRAWN] = [3e4, 4e4, 1.5e-3, 3e4, 3e4, 0.03];

/// Drilling in which one place is off by a curve of the sample.
pub(super) fn off_by(place: usize, size: f64, curve: impl Fn(&Record, usize) -> f64) -> Record {
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
            0 => (record.outlet[i], record.speed[i]) = (sound.outlet[i] + by, turned(by)),
            // The pump lifts the same at a lower speed.
            1 => record.speed[i] = turned(-by),
            2 => record.mud_pump[i] -= by,
            INLET_READING => record.inlet[i] += by,
            METER_FACTOR => record.flow[i] /= 1.0 + by,
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

fn waving(place: usize) -> Record {
    off_by(place, SIZES[place], |record, i| wave(record.t_s[i]))
}

pub(super) fn loose(record: &Record) -> Tangent {
    Tangent::at(record, &[], &[], Bend::Loose).unwrap()
}

/// A correction that is nothing but its place, knots and evidence.
pub(super) fn made(place: usize, quantity: usize, knots: &[f64], evidence: f64) -> Correction {
    let mut parameters = vec![place as f64, quantity as f64, 0.0, LENGTH_S];
    parameters.extend(knots);
    Correction {
        applied: Applied::new(unknown(), parameters),
        signature: Vec::new(),
        evidence,
        freedom: 3.0,
        borne: evidence,
        size: PLACES.get(place).map_or(0.0, |_| size(place, knots)),
        least: PLACES.get(place).map_or(0.0, |p| p.least),
        seen: None,
        place,
        quantity,
        times: 1.0,
    }
}

/// Its knots less their mean; in the balance, which holds no constant of its own, as they are.
fn centred(place: usize, knots: &[f64]) -> Vec<f64> {
    let mean = if place == 2 {
        0.0
    } else {
        knots.iter().sum::<f64>() / knots.len() as f64
    };
    knots.iter().map(|k| k - mean).collect()
}

#[test]
fn a_correction_along_time_draws_what_its_place_is_off_by() {
    for place in 0..DRAWN {
        let record = waving(place);
        let tangent = loose(&record);
        let found = correction(&record, &tangent, &[], &[], (place, 0)).unwrap();
        assert!(
            found.evidence > hurdle(&found),
            "{place}: {}",
            found.evidence
        );
        assert!(found.claim() < found.evidence && found.claim() > found.evidence - 5.0);
        assert!(
            found.freedom > 3.0 && found.freedom < KNOTS as f64,
            "{}",
            found.freedom
        );
        assert!(plausible(&found));
        assert_eq!((found.place, found.quantity), (place, 0));
        let p = &found.applied.parameters;
        assert_eq!(p[..4], [place as f64, 0.0, 0.0, LENGTH_S]);
        let truth: Vec<f64> = (0..KNOTS)
            .map(|k| SIZES[place] * wave(LENGTH_S * k as f64 / (KNOTS - 1) as f64))
            .collect();
        let (drawn, truth) = (centred(place, &p[4..]), centred(place, &truth));
        let (own, true_size) = (dot(&drawn, &drawn), dot(&truth, &truth));
        let alike = dot(&drawn, &truth) / (own * true_size).sqrt();
        // Curves that are fitted to a flow which is off are too flat for it, and lean where it went with the levels.
        let (least_alike, most) = if place == METER_FACTOR {
            (0.98, 1.2)
        } else {
            (0.99, 1.1)
        };
        assert!(alike > least_alike, "{place}: {drawn:?}");
        // A head that leans on the inlet pressure by itself leaves a part of it for the correction.
        let least = if place == 1 { 0.3 } else { 0.8 };
        let size = (own / true_size).sqrt();
        assert!(size > least && size < most, "{place}: {size}");
        // What it says that it takes out of the rows is what it does when it is run.
        let run = tangent.signature(&record, std::slice::from_ref(&found.applied));
        let apart: f64 = (run.iter().zip(&found.signature))
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        assert!(
            apart < 1e-3 * dot(&run, &run),
            "{place}: {}",
            apart / dot(&run, &run)
        );
        // A model that holds it has it again, and a sound recording has not.
        let held = again(&record, &[], &found.applied, &[]).unwrap();
        assert_eq!((held.place, held.quantity), (place, 0));
        assert_eq!(held.applied.parameters, found.applied.parameters);
        let sound = drilled(Hidden::default());
        assert!(again(&sound, &[], &found.applied, &[]).is_none());
        // Of all corrections it is the likeliest, or one of a place that its rows are shared with.
        let all = corrections(&record, &[]);
        let best = &all[0];
        let shares =
            (PLACES[best.place].shows_in.iter()).any(|r| PLACES[place].shows_in.contains(r));
        assert!(shares, "{place}: {} {}", best.place, best.quantity);
        for pair in all.windows(2) {
            assert!(pair[0].evidence >= pair[1].evidence);
        }
    }
}

#[test]
fn a_place_that_there_is_not_is_not_made_anew() {
    let record = drilled(Hidden::default());
    for (place, quantity) in [(PLACES.len(), 0), (0, QUANTITIES.len())] {
        let held = made(place, quantity, &[1e4; KNOTS], 0.0);
        assert!(again(&record, &[], &held.applied, &[]).is_none());
    }
}

#[test]
fn a_correction_along_another_quantity_is_a_law_of_it() {
    // The line resists by a bar more from the lowest inlet pressures to the highest.
    let rise = 1e5;
    let record = off_by(0, rise, |record, i| {
        let (from, to) = range(record, 1);
        ((record.filled.inlet[i] - from) / (to - from)).clamp(0.0, 1.0)
    });
    let tangent = loose(&record);
    let found = correction(&record, &tangent, &[], &[], (0, 1)).unwrap();
    assert!(found.evidence > hurdle(&found));
    let knots = &found.applied.parameters[4..];
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
    let found = corrections(&record, &[]);
    for c in &found {
        assert!(
            c.evidence < hurdle(c),
            "{} {}: {}",
            c.place,
            c.quantity,
            c.evidence
        );
    }
    let tried = |place: usize| {
        let mut of: Vec<usize> = found
            .iter()
            .filter(|c| c.place == place)
            .map(|c| c.quantity)
            .collect();
        of.sort_unstable();
        of
    };
    // The booster stands still here, and so does what has no topfill. A curve of the flow is the friction, one of flow or
    // speed the head; a balance along the flow's rate is timing; a reading of the inlets drifts in time alone, and the outlets'
    // moves with what else is pumped.
    assert_eq!(tried(0), [0, 1, 2, 5, 6, 7]);
    assert_eq!(tried(1), [0, 1, 2, 6, 7]);
    assert_eq!(tried(2), [0, 1, 2, 4, 5, 6]);
    assert_eq!(tried(INLET_READING), [0]);
    assert_eq!(tried(OUTLET_READING), [2]);
    // The factor of a meter drifts, or depends on what it measures.
    assert_eq!(tried(METER_FACTOR), [0, 4]);
    assert!(found.iter().all(|c| c.place < DRAWN));
}

#[test]
fn a_drift_of_the_inlets_is_none_that_the_risers_transmitter_has_too() {
    let mut record = waving(INLET_READING);
    let tangent = loose(&record);
    let alone = correction(&record, &tangent, &[], &[], (INLET_READING, 0)).unwrap();
    let noise = normals(7, record.inlet.len());
    let riser = |drift: f64, record: &Record| -> Vec<f64> {
        (record.inlet.iter().zip(&record.t_s).zip(&noise))
            .map(|((p, t), noise)| {
                p - drift * SIZES[INLET_READING] * wave(*t) - 3e5 + 500.0 * noise
            })
            .collect()
    };
    // It knows of none: it bears the drift out.
    record.riser = Some(riser(1.0, &record));
    let borne = correction(&record, &tangent, &[], &[], (INLET_READING, 0)).unwrap();
    assert!(borne.evidence > alone.evidence + 20.0);
    // And it is drawn better than without.
    let knots = |c: &Correction| centred(INLET_READING, &c.applied.parameters[4..]);
    let truth: Vec<f64> = (0..KNOTS)
        .map(|k| SIZES[INLET_READING] * wave(LENGTH_S * k as f64 / (KNOTS - 1) as f64))
        .collect();
    let truth = centred(INLET_READING, &truth);
    let off = |c: &Correction| -> f64 {
        knots(c)
            .iter()
            .zip(&truth)
            .map(|(a, b)| (a - b).powi(2))
            .sum()
    };
    assert!(off(&borne) < off(&alone) && off(&borne) < 0.02 * dot(&truth, &truth));
    record.riser = Some(riser(0.0, &record));
    assert!(correction(&record, &tangent, &[], &[], (INLET_READING, 0)).is_none());
    // Of another place it is no witness.
    assert!(correction(&record, &tangent, &[], &[], (1, 0)).is_some());
}

#[test]
fn a_constant_is_a_correction_of_the_balance_alone() {
    let size = [2e4, 2e4, 3e-3, 2e4, 2e4];
    for place in 0..size.len() {
        let record = off_by(place, size[place], |_, _| 1.0);
        let found = correction(&record, &loose(&record), &[], &[], (place, 0)).unwrap();
        assert_eq!(
            found.evidence > hurdle(&found),
            place == 2,
            "{place}: {}",
            found.evidence
        );
        if place != 2 {
            // Elsewhere the relation holds it already, and a curve that explains nothing pays for its freedom.
            assert!(found.evidence < -3.0);
            continue;
        }
        assert!(found.freedom < 1.1);
        for knot in &found.applied.parameters[4..] {
            assert!((knot / size[2] - 1.0).abs() < 0.1, "{knot}");
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
    for (mut record, steady) in [(off_by(0, 6e4, once), false), (waving(0), true)] {
        let tangent = loose(&record);
        let paid = correction(&record, &tangent, &[], &[], (0, 0)).unwrap();
        record.without = vec![Step::Busiest];
        let free = correction(&record, &tangent, &[], &[], (0, 0)).unwrap();
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
    let waving = waving(0);
    let blocks: Vec<bool> = (0..sound.blocks).map(|b| b % 24 < 6).collect();
    let held = |record: &Record, blocks: &[bool], c: Correction| {
        let mut found = vec![c];
        hold_without(
            record,
            blocks,
            &[],
            &mut found,
            Relation::ReturnLineFriction,
        );
        found[0].evidence
    };
    let claimed = |place: usize, evidence: f64| made(place, 0, &[1e4; KNOTS], evidence);
    // Sound drilling shows none of it elsewhere.
    assert!(held(&sound, &blocks, claimed(0, 100.0)) < 5.0);
    // Elsewhere there is enough of it: it keeps all that it has.
    assert_eq!(held(&waving, &blocks, claimed(0, 1e3)), 1e3);
    // Without such blocks, of another relation, or with less than half of its hurdle it is not asked.
    assert_eq!(
        held(&sound, &vec![false; sound.blocks], claimed(0, 100.0)),
        100.0
    );
    assert_eq!(held(&sound, &blocks, claimed(1, 100.0)), 100.0);
    let least = hurdle(&claimed(0, 0.0));
    assert_eq!(
        held(&sound, &blocks, claimed(0, 0.49 * least)),
        0.49 * least
    );
    assert!(held(&sound, &blocks, claimed(0, 0.51 * least)) < 0.3 * least);
    // One that is held beside others does not take them with it.
    let mut found = vec![claimed(0, 100.0), claimed(1, 100.0), claimed(0, 1.0)];
    hold_without(
        &sound,
        &blocks,
        &[],
        &mut found,
        Relation::ReturnLineFriction,
    );
    assert!(found[0].evidence < 5.0);
    assert_eq!((found[1].evidence, found[2].evidence), (100.0, 1.0));
}

#[test]
fn what_a_late_meter_leaves_on_the_way_to_another_flow_is_no_law_of_the_friction() {
    let mut record = drilled(Hidden {
        late_s: 4.0,
        ..Hidden::default()
    });
    let friction = |record: &Record| -> Vec<(usize, f64, f64)> {
        let mut of: Vec<(usize, f64, f64)> = (corrections(record, &[]).iter())
            .filter(|c| c.place == 0)
            .map(|c| (c.quantity, c.evidence, hurdle(c)))
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
    assert!(correction(&record, &tangent, &[], &[], (0, 1)).is_some());
    for (i, p) in record.filled.inlet.iter_mut().enumerate() {
        *p = 164e5 + 1e-6 * i as f64;
    }
    assert!(correction(&record, &tangent, &[], &[], (0, 1)).is_none());
}
