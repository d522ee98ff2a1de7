//! Claims about the places at which an effect is tried: on its grid, at peaks of its score, and where its ends are moved to.

use crate::numbers::{product, whole};
use crate::record::Record;
use crate::relations::Applied;
use crate::scan::switches::{Energies, highest};
use crate::scan::{
    Candidate, grids, likeliest, more_places, points, scan, sharpen, softened, switches, weigh,
};
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{BLOCK_S, FLOW_M3_S, Hidden, SPEED_PCT, cut, drilled, normals, one};
use dgd_effects::find;

fn about(record: &Record) -> Tangent {
    Tangent::at(record, &[], &[], Bend::Stiff).unwrap()
}

/// The same recording by a clock that starts at another time.
fn late_by(mut record: Record, by_s: f64) -> Record {
    record.t_s.iter_mut().for_each(|t| *t += by_s);
    let (from, to) = record.setting.span_s;
    record.setting.span_s = (from + by_s, to + by_s);
    record
}

/// Drilling with two outlet transmitters, each with noise of its own, of which the first reads too much by `bias_pa` from some
/// time on.
fn shifted(bias_pa: f64, onset_s: f64) -> Record {
    let mut record = drilled(Hidden::default());
    let mut first = record.outlet.clone();
    let noise = normals(9, first.len());
    for ((p, t), noise) in first.iter_mut().zip(&record.t_s).zip(noise) {
        *p += 900.0 * noise + if *t >= onset_s { bias_pa } else { 0.0 };
    }
    record.outlets.insert(0, first);
    for (mean, first) in record.outlet.iter_mut().zip(&record.outlets[0]) {
        *mean = 0.5 * (*mean + first);
    }
    record.filled.outlet.clone_from(&record.outlet);
    record
}

/// The first blocks of it.
fn first(record: Record, blocks: usize) -> Record {
    let n = blocks * record.per_block;
    let mut record = cut(record, n);
    let filled = &mut record.filled;
    filled.pumping.truncate(n);
    for values in [
        &mut filled.mud_pump,
        &mut filled.booster,
        &mut filled.topfill,
        &mut filled.flow,
        &mut filled.speed,
        &mut filled.inlet,
        &mut filled.outlet,
    ] {
        values.truncate(n);
    }
    record.blocks = blocks;
    record.setting.span_s.1 = record.setting.span_s.0 + BLOCK_S * blocks as f64;
    record
}

/// Share of the head that gas takes, and when it comes and for how long.
const GAS: f64 = 0.03;
const GAS_S: (f64, f64) = (1800.0, 1700.0);

/// Drilling in which gas takes a thirtieth of the head, and the pump turns faster for it; it comes and goes within `edge_s`.
fn gassy(edge_s: f64) -> Record {
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        let t = record.t_s[i];
        let inside = (t - GAS_S.0).min(GAS_S.0 + GAS_S.1 - t);
        let loss = GAS * (inside / edge_s).clamp(0.0, 1.0);
        // The head is `45e5·(w/70)² − 5e5·(q/0.04)²`, here of the speed and flow that were measured.
        let flow = 5e5 * (record.flow[i] / FLOW_M3_S).powi(2);
        let head = 45e5 * (record.speed[i] / SPEED_PCT).powi(2) - flow;
        record.speed[i] = SPEED_PCT * ((head / (1.0 - loss) + flow) / 45e5).sqrt();
    }
    record.filled.speed.clone_from(&record.speed);
    record
}

/// A candidate that is nothing but its place and an energy.
fn coarse(applied: Applied, energy: f64) -> Candidate {
    Candidate {
        applied,
        signature: Vec::new(),
        energy,
        score: 0.0,
        evidence: 0.0,
    }
}

/// Of what wanders only the minutes about its ends tell: a length that is off by one in twenty may tell nothing.
#[test]
fn what_otherwise_stays_is_proposed_at_its_very_ends_however_long_it_is() {
    let (bias_pa, from, to) = (6000.0, 1430.0, 4190.0);
    let mut record = shifted(bias_pa, from);
    for i in 0..record.t_s.len() {
        if record.t_s[i] >= to {
            record.outlets[0][i] -= bias_pa;
            record.outlet[i] -= 0.5 * bias_pa;
        }
    }
    record.filled.outlet.clone_from(&record.outlet);
    let tangent = about(&record);
    let form = find("outlet_pressure_bias_step").unwrap();
    let form = form.passing().unwrap();
    let coarse: Vec<Candidate> = (points(form, &record).into_iter())
        .map(|one| weigh(&record, &tangent, &[], one).bare())
        .collect();
    let found = switches(&record, &tangent, &tangent.pull(), &[], form, &coarse);
    let apart = |p: &Vec<f64>| (p[1] - from).abs().max((p[1] + p[3] - to).abs());
    assert!(found.iter().any(|p| apart(p) <= BLOCK_S), "{found:?}");
}

#[test]
fn onsets_are_tried_evenly_within_the_recording_whatever_its_clock() {
    // Every ten minutes, a switch every twenty; ten at least, and 32 where they would be more than sixty.
    for (id, hours, count) in [
        ("line_leak", 10.0, 30),
        ("line_leak", 1.5, 10),
        ("line_leak", 20.0, 60),
        ("line_leak", 40.0, 32),
        ("influx", 4.0, 24),
        ("influx", 1.0, 10),
        ("influx", 10.0, 60),
        ("influx", 30.0, 32),
    ] {
        let effect = find(id).unwrap();
        let mut record = drilled(Hidden::default());
        let span = 3600.0 * hours;
        record.setting.span_s = (0.0, span);
        let onset = effect.about().onset().unwrap();
        let early = grids(effect, &record);
        let onsets = &early[onset];
        assert_eq!(onsets.len(), count, "{id} {hours} h");
        let step = onsets[1] - onsets[0];
        let stays = effect.about().duration().is_none();
        let left = span - onsets[count - 1];
        assert!(onsets[0] >= 0.009 * span && onsets[0] < 0.07 * span);
        assert!(left > 0.016 * span && left < 0.1 * span);
        // Days leave out no more than half an hour at the beginning and 40 min at the end of what stays.
        assert!(!stays || (onsets[0] <= 1800.0 && left < 2400.5), "{id}");
        for pair in onsets.windows(2) {
            assert!(step > 0.0 && ((pair[1] - pair[0]) / step - 1.0).abs() < 1e-9);
        }
        record.setting.span_s = (7e4, 7e4 + span);
        let late = grids(effect, &record);
        for (k, (early, late)) in early.iter().zip(&late).enumerate() {
            let by = if k == onset { 7e4 } else { 0.0 };
            assert_eq!(early.len(), late.len());
            for (early, late) in early.iter().zip(late) {
                assert!((late - early - by).abs() < 1e-6, "{id} {k}");
            }
        }
    }
}

#[test]
fn what_passes_is_tried_as_long_as_it_leaves_three_tenths_of_the_recording() {
    let influx = find("influx").unwrap();
    for (span, expected) in [
        (1800.0, &[][..]),
        (3000.0, &[1300.0]),
        (3300.0, &[1300.0, 2300.0]),
        (6000.0, &[1300.0, 2300.0, 3600.0]),
        (4.0 * 3600.0, &[1300.0, 2300.0, 3600.0, 6000.0, 10_000.0]),
    ] {
        let mut record = drilled(Hidden::default());
        record.setting.span_s = (100.0, 100.0 + span);
        let found = grids(influx, &record);
        assert_eq!(found[influx.about().duration().unwrap()], expected);
        // A proportional strength is tried once, at a third of what is usual.
        let usual = influx.about().parameters[0].usual;
        assert!(found[0].len() == 1 && (3.0 * found[0][0] / usual - 1.0).abs() < 1e-12);
    }
}

#[test]
fn what_lasts_for_hours_is_tried_at_fewer_places_and_all_else_everywhere() {
    let mut record = drilled(Hidden::default());
    record.setting.span_s = (0.0, 6.0 * 3600.0);
    let tried = |id: &str| {
        let effect = find(id).unwrap();
        let all = product(&grids(effect, &record)).len();
        (points(effect, &record), all)
    };
    let (influxes, _) = tried("influx");
    let duration = find("influx").unwrap().about().duration().unwrap();
    let of = |lasts_s: f64| {
        influxes
            .iter()
            .filter(|p| p.parameters[duration] == lasts_s)
            .count()
    };
    let everywhere = of(1300.0);
    assert_eq!((of(2300.0), of(3600.0)), (everywhere, everywhere));
    assert_eq!((of(6000.0), of(10_000.0)), (everywhere / 2, everywhere / 3));
    let (leaks, all) = tried("line_leak");
    assert_eq!(leaks.len(), all);
}

#[test]
fn of_all_candidates_the_likeliest_comes_with_its_signature() {
    let record = shifted(0.0, 3e4);
    let tangent = Tangent::at(&record, &[], &[], Bend::Lean).unwrap();
    let evidences = [f64::NAN, 1.0, 3.0, f64::INFINITY, 2.0, 3.0, f64::NAN, -1.0];
    let candidates = |signature: &[f64]| -> Vec<Candidate> {
        let of = |(k, evidence): (usize, &f64)| {
            let leak = one("line_leak", &[1e-3, 100.0 * k as f64]);
            let mut c = coarse(leak, 1.0);
            (c.signature, c.evidence) = (signature.to_vec(), *evidence);
            c
        };
        evidences.iter().enumerate().map(of).collect()
    };
    let best = |found: &[Candidate]| likeliest(&record, &tangent, &[], found);
    // Of two alike the later one, as `Iterator::max_by` has it.
    let kept = best(&candidates(&[1.0])).unwrap();
    assert_eq!(kept.applied.parameters[1], 500.0);
    assert_eq!(kept.signature, [1.0]);
    // What was not kept is worked out.
    let anew = best(&candidates(&[])).unwrap();
    let weighed = weigh(&record, &tangent, &[], kept.applied);
    assert_eq!(anew.signature, weighed.signature);
    assert_eq!(anew.evidence, weighed.evidence);
    assert!(anew.energy > 0.0);
    assert!(best(&candidates(&[])[..1]).is_none());
}

#[test]
fn between_its_points_a_grid_has_the_energy_of_the_nearest_onset_and_duration() {
    let at = |onset: f64, lasts: f64, energy: f64| {
        coarse(one("influx", &[1e-3, onset, lasts, 0.15]), energy)
    };
    let grid = [
        at(500.0, 1300.0, 1.0),
        at(500.0, 3600.0, 2.0),
        at(100.0, 1300.0, 3.0),
        at(100.0, 3600.0, 4.0),
    ];
    let energies = Energies::of(grid.iter(), 1, Some(2));
    for (onset, lasts, energy) in [
        (0.0, 0.0, 3.0),
        (290.0, 2400.0, 3.0),
        (310.0, 2400.0, 1.0),
        (290.0, 2500.0, 4.0),
        (1e6, 1e6, 2.0),
    ] {
        assert_eq!(energies.nearest(onset, lasts), energy, "{onset} {lasts}");
    }
    let none = Energies::of(std::iter::empty(), 1, None);
    assert_eq!(none.nearest(0.0, 0.0), f64::INFINITY);
    // Of what stays the onset alone.
    let stays = [coarse(one("line_leak", &[1e-3, 7.0]), 5.0)];
    assert_eq!(Energies::of(stays.iter(), 1, None).nearest(9.0, 0.0), 5.0);
}

#[test]
fn places_that_a_grid_steps_over_are_paid_for() {
    let more = |id: &str, hours: f64| {
        let mut record = drilled(Hidden::default());
        record.setting.span_s = (640.0, 640.0 + 3600.0 * hours);
        more_places(find(id).unwrap(), &record)
    };
    assert_eq!(more("influx", 10.0), 0.0);
    assert!((more("influx", 80.0) - 15.0_f64.ln()).abs() < 1e-12);
    assert_eq!(more("line_leak", 20.0), 0.0);
    assert!((more("line_leak", 80.0) - 7.5_f64.ln()).abs() < 1e-12);
    assert_eq!(more("return_flow_gain", 2400.0), 0.0);
}

/// Scores of a switch, strength first and onset second, at every block; the others of its parameters after them.
fn scores(record: &Record, tangent: &Tangent, id: &str, strength: f64, others: &[f64]) -> Vec<f64> {
    (0..record.blocks)
        .map(|b| {
            let onset = record.setting.span_s.0 + BLOCK_S * b as f64;
            let parameters = [&[strength, onset], others].concat();
            weigh(record, tangent, &[], one(id, &parameters)).score
        })
        .collect()
}

#[test]
fn running_sums_peak_at_the_block_where_a_switch_by_itself_scores_most() {
    // Noise alone: friction, head and difference of the outlets, then the balance, which has a row for three blocks.
    for (id, strength, others, within) in [
        ("outlet_pressure_bias_step", 1e4, &[1.0][..], 0),
        ("outlet_pressure_bias_step", 1e4, &[2.0], 0),
        ("line_restriction", 5.0, &[], 0),
        ("lost_circulation", 1e-9, &[0.3], 3),
        ("line_leak", 1e-3, &[], 3),
    ] {
        // The last block has no whole row of the balance.
        let early = first(shifted(0.0, 0.0), 538);
        let onset_s = early.setting.span_s.1 / 2.0;
        for by_s in [0.0, 640.0] {
            let record = late_by(early.clone(), by_s);
            let tangent = about(&record);
            let pull = tangent.pull();
            let scores = scores(&record, &tangent, id, strength, others);
            let effect = find(id).unwrap();
            let signed = effect.about().parameters[0].low < 0.0;
            let size = |b: usize| {
                if signed { scores[b].abs() } else { scores[b] }
            };
            // Two hundredths of the recording at either end are left out.
            let most = |range: std::ops::Range<usize>| {
                range.max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap()
            };
            let at = |onset: f64, energy: f64| {
                let parameters = [&[strength, onset + by_s], others].concat();
                coarse(one(id, &parameters), energy)
            };
            // Where energy is the same everywhere the score decides; where it is much greater, nothing stands out.
            let (first, last) = (at(onset_s - 1000.0, 1.0), at(onset_s + 1000.0, 1e9));
            let second = at(onset_s - 1000.0, 1e9);
            let third = at(onset_s + 1000.0, 1.0);
            for (coarse, range) in [
                (vec![first.clone()], 11..527),
                (vec![first, last], 11..270),
                (vec![second, third], 271..527),
            ] {
                let found = switches(&record, &tangent, &pull, &[], effect, &coarse);
                if size(most(range.clone())) <= 0.0 {
                    continue;
                }
                assert!((1..=3).contains(&found.len()));
                let best = whole((found[0][1] - by_s) / BLOCK_S);
                let expected = most(range);
                assert!(
                    best.abs_diff(expected) <= within,
                    "{id}: {best}, {expected}"
                );
                assert_eq!(found[0][0], strength);
                assert_eq!(found[0][2..], *others);
                // Peaks stand apart, best first.
                let blocks: Vec<usize> = (found.iter())
                    .map(|p| whole((p[1] - by_s) / BLOCK_S))
                    .collect();
                for (k, b) in blocks.iter().enumerate().skip(1) {
                    assert!(blocks[..k].iter().all(|a| a.abs_diff(*b) >= 30));
                }
            }
        }
    }
}

#[test]
fn gas_is_proposed_from_its_beginning_to_its_end() {
    let record = late_by(gassy(20.0), 640.0);
    let tangent = about(&record);
    let pull = tangent.pull();
    let gas = find("gas_in_pump").unwrap();
    let tried: Vec<Candidate> = [600.0, 1800.0, 3000.0]
        .map(|t| one("gas_in_pump", &[0.02, 640.0 + t, 1300.0, 20.0]))
        .map(|a| weigh(&record, &tangent, &[], a))
        .to_vec();
    let found = switches(&record, &tangent, &pull, &[], gas, &tried);
    assert!((3..=6).contains(&found.len()), "{found:?}");
    let [_, from, lasts, edge] = found[0][..] else {
        panic!("{found:?}");
    };
    assert!((from - 640.0 - GAS_S.0).abs() <= 20.0, "{found:?}");
    assert!(
        (from + lasts - 640.0 - GAS_S.0 - GAS_S.1).abs() <= 20.0,
        "{found:?}"
    );
    assert_eq!(edge, 20.0);
    // Another proposal begins or ends five minutes from it.
    for other in &found[1..] {
        let ends = |p: &[f64]| (p[1], p[1] + p[2]);
        let (a, b) = (ends(&found[0]), ends(other));
        assert!((a.0 - b.0).abs() > 290.0 || (a.1 - b.1).abs() > 290.0);
    }
}

#[test]
fn three_of_the_highest_are_proposed_and_three_that_share_no_end() {
    // Heights by place: the first four begin or end with one of the first two.
    let peaks = [
        (9.0, 811, 1099),
        (8.0, 813, 969),
        (7.0, 811, 935),
        (6.0, 761, 969),
        (5.0, 757, 941),
        (4.0, 671, 935),
        (3.0, 500, 640),
    ];
    let three = [(811, 1099), (813, 969), (811, 935)];
    let unlike = [(761, 969), (671, 935)];
    assert_eq!(
        highest(peaks.to_vec(), 30),
        [&three[..], &unlike[..]].concat()
    );
    assert_eq!(highest(peaks[..1].to_vec(), 30), three[..1]);
    // What sets in and stays has one end.
    let stays = [
        (9.0, 100, 600),
        (8.0, 300, 600),
        (7.0, 400, 600),
        (6.0, 500, 600),
    ];
    assert_eq!(
        highest(stays.to_vec(), 30),
        [(100, 600), (300, 600), (400, 600)]
    );
    assert!(highest(Vec::new(), 30).is_empty());
}

#[test]
fn what_passes_is_proposed_for_as_long_as_its_energy_lets_it_stand_out() {
    let record = gassy(20.0);
    let tangent = about(&record);
    let pull = tangent.pull();
    let gas = find("gas_in_pump").unwrap();
    let tried =
        |lasts: f64, energy: f64| coarse(one("gas_in_pump", &[0.02, 1500.0, lasts, 20.0]), energy);
    // Of two lengths the nearer one tells the energy: where it is great nothing stands out.
    for (short, long) in [(1.0, 1e9), (1e9, 1.0)] {
        let coarse = [tried(1300.0, short), tried(3600.0, long)];
        let found = switches(&record, &tangent, &pull, &[], gas, &coarse);
        assert!(!found.is_empty());
        for p in found {
            assert_eq!(p[2] < 2450.0, short < long, "{p:?}");
        }
    }
    // The same end with another beginning is another proposal.
    let found = switches(&record, &tangent, &pull, &[], gas, &[tried(1300.0, 1.0)]);
    let ends: Vec<(f64, f64)> = found.iter().map(|p| (p[1], p[1] + p[2])).collect();
    let shared =
        |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).abs() < 300.0 || (a.1 - b.1).abs() < 300.0;
    assert!(
        shared(&ends[0], &ends[1]) || shared(&ends[0], &ends[2]),
        "{ends:?}"
    );
}

#[test]
fn what_is_sharpened_explains_no_less_than_before() {
    let record = shifted(3e4, 2000.0);
    let tangent = about(&record);
    for onset in (1..26).map(|k| 200.0 * f64::from(k)) {
        let start = one("outlet_pressure_bias_step", &[1e4, onset, 1.0]);
        let start = weigh(&record, &tangent, &[], start);
        let before = start.evidence;
        assert!(
            sharpen(&record, &tangent, &[], start).evidence >= before,
            "{onset}"
        );
    }
}

#[test]
fn a_switch_minutes_off_is_sharpened_to_the_block() {
    let onset = 2000.0;
    let record = shifted(3e4, onset);
    let tangent = about(&record);
    for off in [-110.0, -40.0, 30.0, 90.0] {
        let start = one("outlet_pressure_bias_step", &[1e4, onset + off, 1.0]);
        let start = weigh(&record, &tangent, &[], start);
        let sharp = sharpen(&record, &tangent, &[], start);
        let p = &sharp.applied.parameters;
        assert!((p[1] - onset).abs() <= BLOCK_S, "{off}: {p:?}");
        assert!((sharp.score / sharp.energy / 3e4 - 1.0).abs() < 0.05);
    }
}

#[test]
fn both_ends_of_an_interval_are_sharpened_and_no_end_moved_by_a_block_explains_more() {
    let record = gassy(20.0);
    let tangent = about(&record);
    let (from, to) = (GAS_S.0, GAS_S.0 + GAS_S.1);
    for (early, late) in [(-210.0, -90.0), (150.0, 170.0), (40.0, -190.0), (0.0, 0.0)] {
        let (a, b) = (from + early, to + late);
        let start = one("gas_in_pump", &[0.02, a, b - a, 20.0]);
        let start = weigh(&record, &tangent, &[], start);
        let sharp = sharpen(&record, &tangent, &[], start);
        let p = &sharp.applied.parameters;
        assert!(
            (p[1] - from).abs() <= 2.0 * BLOCK_S,
            "{early} {late}: {p:?}"
        );
        assert!(
            (p[1] + p[2] - to).abs() <= 2.0 * BLOCK_S,
            "{early} {late}: {p:?}"
        );
        for (by, longer) in [(10.0, -10.0), (-10.0, 10.0), (0.0, 10.0), (0.0, -10.0)] {
            let moved = one("gas_in_pump", &[p[0], p[1] + by, p[2] + longer, p[3]]);
            let moved = weigh(&record, &tangent, &[], moved);
            assert!(moved.evidence <= sharp.evidence + 0.1);
        }
    }
}

#[test]
fn a_slow_edge_is_found_about_the_middle_of_a_sharp_one() {
    for edge in [150.0, 400.0] {
        let record = gassy(edge);
        let tangent = about(&record);
        // From the middle of one edge to that of the other.
        let start = [0.02, GAS_S.0 + 0.5 * edge, GAS_S.1 - edge, 20.0];
        let start = weigh(&record, &tangent, &[], one("gas_in_pump", &start));
        let sharp = sharpen(&record, &tangent, &[], start);
        let soft = softened(&record, &tangent, &[], &sharp);
        let edges: Vec<f64> = soft.iter().map(|c| c.applied.parameters[3]).collect();
        assert_eq!(edges, [150.0, 400.0]);
        let best = soft
            .iter()
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
            .unwrap();
        let p = &best.applied.parameters;
        assert!(best.evidence > sharp.evidence + 10.0, "{edge}");
        assert_eq!(p[3], edge);
        assert!((p[1] - GAS_S.0).abs() <= 30.0, "{p:?}");
        assert!((p[1] + p[2] - GAS_S.0 - GAS_S.1).abs() <= 30.0, "{p:?}");
    }
    // What sets in at once has no edge to lengthen.
    let record = shifted(3e4, 2000.0);
    let tangent = about(&record);
    let step = one("outlet_pressure_bias_step", &[1e4, 2000.0, 1.0]);
    let step = weigh(&record, &tangent, &[], step);
    assert!(softened(&record, &tangent, &[], &step).is_empty());
}

#[test]
fn a_scan_finds_a_switch_to_the_block_with_its_edge() {
    let record = gassy(150.0);
    let tangent = about(&record);
    let best = scan(&record, &tangent, &[], find("gas_in_pump").unwrap()).unwrap();
    let p = &best.applied.parameters;
    assert!((p[1] - GAS_S.0).abs() <= 30.0 && p[3] == 150.0, "{p:?}");
    assert!((p[1] + p[2] - GAS_S.0 - GAS_S.1).abs() <= 30.0, "{p:?}");
}

#[test]
fn a_meter_that_is_late_by_a_minute_is_found_beyond_the_grid() {
    let delay = find("return_flow_delay").unwrap();
    let best = |late_s: f64| {
        let record = drilled(Hidden {
            late_s,
            ..Hidden::default()
        });
        let tangent = about(&record);
        let before = record.tally.work().hypotheses;
        let found = scan(&record, &tangent, &[], delay).unwrap();
        let weighed = record.tally.work().hypotheses - before;
        (found.applied.parameters[0], weighed)
    };
    // The steps of a third go on from 30 s.
    let (found_s, further) = best(60.0);
    assert!((50.0..70.0).contains(&found_s), "{found_s}");
    // Of one that is on the grid none is tried beyond it.
    let (found_s, on_it) = best(12.0);
    assert!((found_s - 12.0).abs() <= 1.0, "{found_s}");
    assert!((4..9).contains(&(further - on_it)), "{further} {on_it}");
}
