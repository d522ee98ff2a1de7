//! Claims about what a finding says, in words and numbers.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{finding, heaving, region, separating_test, told_curve};
use crate::diagnosis::Finding;
use crate::estimates::Estimator;
use crate::heave::Swell;
use crate::relations::Applied;
use crate::selection::Named;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, INFLUX_S, drilled, named, steady};
use dgd_effects::{About, Curve, KNOTS, Place, Quantity, Relation, catalogue, find, told_apart_by};

/// What the clock says at the first sample, s.
const START_S: f64 = 100.0;

fn influx() -> Named {
    let (from, lasts, rise) = INFLUX_S;
    Named {
        probability: 0.97,
        ..named("influx", &[3e-3, from, lasts, rise])
    }
}

/// What is told of one cause on the drilling that conceals an influx.
fn told(named: &Named) -> Finding {
    let mut record = drilled(Hidden {
        influx_m3_s: 3e-3,
        ..Hidden::default()
    });
    record.setting.span_s = (START_S, START_S + 5400.0);
    record.t_s.iter_mut().for_each(|t| *t += START_S);
    let full = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    let state = [named.applied.clone()];
    finding(&record, named, &Estimator::of(&record, &state, &full), None)
}

#[test]
fn an_effect_is_told_as_the_catalogue_has_it_and_in_times_of_the_clock() {
    let mut named = influx();
    named.applied.parameters[1] += START_S;
    let told_one = told(&named);
    let about = named.applied.effect.about();
    assert_eq!(
        (told_one.effect.as_str(), told_one.title.as_str()),
        ("influx", about.title)
    );
    assert_eq!(told_one.relation, Relation::RiserMassBalance);
    assert_eq!(told_one.shows_in, [Relation::RiserMassBalance]);
    assert_eq!(told_one.pair, None);
    let (from, to) = told_one.intervals_s[0];
    let starts = START_S + INFLUX_S.0;
    assert!((from - starts).abs() < 1e-9 && (to - starts - INFLUX_S.1).abs() < 1e-9);
    assert_eq!(told_one.equation_before, "A dh/dt = q_in - q");
    assert_eq!(told_one.equation_after, about.equation);
    assert_eq!((told_one.evidence, told_one.hurdle), (40.0, 3.5));
    assert_eq!(told_one.probability, 0.97);
    assert_eq!(told_one.parameters.len(), 4);
    assert_eq!(told_one.held_out, None);
    assert_eq!(told_one.separating_test, None);
}

#[test]
fn the_test_is_that_of_the_likeliest_serious_alternative_which_the_catalogue_knows_one_for() {
    let mut named = influx();
    let test = |other: &str| told_apart_by("influx", other).unwrap();
    let alternatives = [("heave", 0.4), ("line_leak", 0.06), ("unknown", 0.05)];
    named.alternatives = alternatives.map(|(id, p)| (id.to_owned(), p)).to_vec();
    named.probability = 1.0;
    let sure = told(&named);
    assert_eq!(sure.probability, 0.99);
    assert_eq!(sure.separating_test.as_deref(), Some(test("line_leak")));
    named.alternatives[1].1 = 0.049;
    assert_eq!(
        told(&named).separating_test.as_deref(),
        Some(test("unknown"))
    );
    named.alternatives[2].1 = 0.049;
    assert_eq!(told(&named).separating_test, None);
    named.alternatives.truncate(2);
    named.probability = 0.0;
    assert_eq!(told(&named).probability, 0.01);
}

#[test]
fn a_test_is_told_of_a_pair_that_the_catalogue_confuses_and_of_no_other() {
    let told = |one: &str, other: &str| separating_test(one, &[(other.to_owned(), 0.5)]);
    let effects: Vec<&About> = catalogue().iter().map(|e| e.about()).collect();
    let lists = |a: &About, b: &About| a.confusable.iter().any(|(id, _)| *id == b.id);
    let mut pairs = 0;
    for a in &effects {
        for b in &effects {
            let known = lists(a, b) || lists(b, a);
            assert_eq!(told(a.id, b.id).is_some(), known, "{} {}", a.id, b.id);
            pairs += usize::from(known);
        }
        for (other, test) in a.confusable {
            assert_eq!(told(a.id, other).as_deref(), Some(*test));
        }
        assert!(told(a.id, "unknown").is_some() && told("unknown", a.id).is_some());
    }
    assert!(pairs > 50, "{pairs}");
}

#[test]
fn what_resembles_a_passing_effect_but_for_its_end_is_told_as_such() {
    for (lasts_s, stays) in [(2400.0, false), (21_600.0, true)] {
        let told = told(&Named {
            probability: 0.1,
            alternatives: vec![("unknown".to_owned(), 0.88)],
            ..named("gas_in_pump", &[0.05, 1800.0, lasts_s, 60.0])
        });
        assert_eq!(told.resembles, Some("gas_in_pump"));
        assert_eq!(
            told.title.ends_with("temporarily, but stays"),
            stays,
            "{}",
            told.title
        );
    }
}

#[test]
fn what_is_likelier_to_resemble_an_effect_is_told_as_unknown() {
    let mut named = influx();
    named.probability = 0.3;
    for (unknown, resembled) in [(0.29, false), (0.31, true)] {
        let alternatives = [("line_leak", 0.1), ("unknown", unknown)];
        named.alternatives = alternatives.map(|(id, p)| (id.to_owned(), p)).to_vec();
        let told = told(&named);
        let about = named.applied.effect.about();
        assert_eq!(told.effect == "unknown", resembled);
        assert_eq!(told.probability, if resembled { 0.31 } else { 0.3 });
        assert_eq!(told.resembles, resembled.then_some("influx"));
        assert_eq!(told.parameters.is_empty(), resembled);
        if resembled {
            let title = format!(
                "something outside the catalogue, which looks as if {}",
                about.title
            );
            assert_eq!(told.title, title);
            let others = [("influx".to_owned(), 0.3), ("line_leak".to_owned(), 0.1)];
            assert_eq!(told.alternatives, others);
            assert_eq!(told.equation_after, about.equation);
            assert_eq!(
                told.separating_test.as_deref(),
                told_apart_by("unknown", "influx")
            );
        }
    }
}

#[test]
fn a_correction_is_told_by_its_place_and_its_quantity() {
    for (place, quantity) in [
        (Place::InletReading, Quantity::Time),
        (Place::Suction, Quantity::Time),
        (Place::SecondOutlet, Quantity::Time),
        (Place::MeterFactor, Quantity::ReturnFlow),
        (Place::Friction, Quantity::InletPressure),
        (Place::Friction, Quantity::Period),
    ] {
        let told = told(&corrected(place, quantity, vec![0.0; KNOTS]));
        let (name, along) = (place.name(), quantity.name());
        let title = match quantity {
            Quantity::Time => format!("{name} drifts over time"),
            Quantity::Period => format!("{name} swings with a period of 42 min"),
            _ => format!("{name} depends on {along}"),
        };
        let before = match place {
            Place::InletReading => "p_meter = p_in",
            Place::Suction => "p_riser - p_in - k rho v^2 / 2 = constant",
            Place::MeterFactor => "q / q_meter = 1",
            Place::SecondOutlet => "p_meter = p_out",
            _ => "p_out = p_0 + rho g L + phi(q) + rho L/A dq/dt",
        };
        let after = format!("{before} + f({along})");
        assert_eq!(
            told.title,
            format!("something outside the catalogue: {title}")
        );
        assert_eq!(
            (told.equation_before.as_str(), told.equation_after),
            (before, after)
        );
        assert_eq!(told.relation, place.relation());
        assert_eq!(told.shows_in, place.shows_in());
        let pair = match place {
            Place::InletReading | Place::Suction => Some("pump inlet less riser pressure"),
            Place::SecondOutlet => Some("outlet transmitters, first less second"),
            _ => None,
        };
        assert_eq!(told.pair, pair);
        assert!(told.parameters.is_empty());
        let curve = told.curve.unwrap();
        let (from, to) = (curve.knots[0].0, curve.knots[KNOTS - 1].0);
        assert_eq!((from, to, curve.knots.len()), (100.0, 2620.0, KNOTS));
        assert_eq!(
            curve.adds,
            if place == Place::MeterFactor {
                "correction_fraction"
            } else {
                "correction_pa"
            }
        );
        let stem = along.replace(' ', "_");
        assert!(
            curve
                .along
                .replace("_its_", "_")
                .starts_with(&stem.replace("_its_", "_")),
            "{}",
            curve.along
        );
    }
}

#[test]
fn an_episode_is_told_with_its_times_and_by_its_one_value() {
    let (begin, end) =
        told(&corrected(Place::Balance, Quantity::Time, vec![1e-3; 6])).intervals_s[0];
    let value = -6e-3;
    for ((from_s, to_s), title, acts) in [
        ((2000.0, None), "shifts at 2000 s", (2000.0, end)),
        (
            (begin, Some(2000.0)),
            "is off until 2000 s",
            (begin, 2000.0),
        ),
        (
            (2000.0, Some(3000.0)),
            "is off from 2000 s to 3000 s",
            (2000.0, 3000.0),
        ),
    ] {
        let curve = Curve::episode(Place::Balance, (from_s, to_s), value);
        let told = told(&Named {
            applied: Applied::from(&curve),
            ..influx()
        });
        assert!(
            told.title.ends_with(&format!("riser mass balance {title}")),
            "{}",
            told.title
        );
        assert_eq!(told.intervals_s, [acts]);
        // A flow that is off for a while is under its own tag.
        assert_eq!(told.same_as, None);
        let curve = told.curve.unwrap();
        assert_eq!((curve.along, curve.adds), ("time_s", "correction_m3_s"));
        assert_eq!(curve.level, Some(value));
        // No edge is drawn where the recording begins or ends.
        let before = [(begin, 0.0), (acts.0, 0.0)];
        let after = [(acts.1, 0.0), (end, 0.0)];
        let mut drawn = vec![(acts.0, value), (acts.1, value)];
        if acts.0 > begin {
            drawn.splice(0..0, before);
        }
        if acts.1 < end {
            drawn.extend(after);
        }
        assert_eq!(curve.knots, drawn);
    }
    let drifts = told(&corrected(Place::Balance, Quantity::Time, vec![1e-3; 6]));
    assert_eq!(drifts.curve.unwrap().level, None);
}

/// What is told of a correction along time whose knots go to and fro between two values.
fn zigzag(place: Place, knots: [f64; 2]) -> Finding {
    let knots = (0..KNOTS).map(|k| knots[k % 2]).collect();
    told(&corrected(place, Quantity::Time, knots))
}

/// A correction, as it is named.
fn corrected(place: Place, quantity: Quantity, knots: Vec<f64>) -> Named {
    Named {
        applied: Applied::from(&Curve::new(place, quantity, (100.0, 2620.0), knots)),
        ..influx()
    }
}

#[test]
fn a_correction_that_is_nearly_level_is_told_as_the_offset_that_it_nearly_is() {
    let with = |place: Place, knots: [f64; 2]| zigzag(place, knots).same_as;
    let mut offset = influx();
    offset.applied = Applied::new(find("outlet_pressure_bias").unwrap(), vec![-7e4]);
    let as_offset = told(&offset).same_as.unwrap();
    for place in [Place::Friction, Place::OutletReading] {
        let level = with(place, [-6e4, -8e4]);
        assert_eq!(level, Some(format!("mostly {as_offset}")));
        // One that varies by more than half of its mean is none, and one about nothing has none.
        assert_eq!(with(place, [-4e4, -8e4]), None);
        assert_eq!(with(place, [-1e4, 1e4]), None);
    }
    for place in [
        Place::Head,
        Place::MeterFactor,
        Place::InletReading,
        Place::FirstOutlet,
    ] {
        assert_eq!(with(place, [-6e4, -8e4]), None);
    }
    assert_eq!(told(&influx()).same_as, None);
}

#[test]
fn a_curve_that_is_the_same_all_along_does_not_drift() {
    let (balance, friction) = (Place::Balance, Place::Friction);
    let same = zigzag(balance, [1.5e-3, 1.6e-3]);
    let says = "something outside the catalogue: riser mass balance is offset by a constant amount";
    assert_eq!(same.title, says);
    assert!(
        same.same_as
            .unwrap()
            .contains("a flow meter with a zero error")
    );
    let drifts = zigzag(balance, [1.5e-3, 1.7e-3]);
    assert!(
        drifts
            .title
            .ends_with("riser mass balance drifts over time")
    );
    assert_eq!(drifts.same_as, None);
    let offset = zigzag(friction, [-7e4, -7e4]);
    assert!(
        offset
            .title
            .ends_with("return line friction is offset by a constant amount")
    );
    assert!(
        zigzag(friction, [0.0, 0.0])
            .title
            .ends_with("drifts over time")
    );
}

#[test]
fn knots_along_the_time_since_a_start_are_told_in_seconds() {
    // Half an hour at the last of three.
    let told = told_curve(
        &Curve::new(
            Place::Balance,
            Quantity::SinceStart,
            (0.0, 30.0_f64.ln_1p()),
            vec![3e-4, -1e-4, f64::NAN],
        ),
        (0.0, 5400.0),
    );
    assert_eq!(
        (told.along, told.adds),
        ("time_since_start_s", "correction_m3_s")
    );
    // Eight to a stretch, for straight lines between knots would not be what the model adds.
    assert_eq!(told.knots.len(), 17);
    let time_s = |k: usize| told.knots[k].0.round();
    let middle_s = (60.0 * (31.0_f64.sqrt() - 1.0)).round();
    assert_eq!([time_s(0), time_s(8), time_s(16)], [0.0, middle_s, 1800.0]);
    let (at_s, added) = told.knots[4];
    assert!((at_s - 60.0 * (31.0_f64.powf(0.25) - 1.0)).abs() < 1e-9);
    assert!((added - 1e-4).abs() < 1e-12);
    assert_eq!(told.range(), Some((-1e-4, 3e-4)));
}

#[test]
fn the_region_is_where_all_but_a_tenth_of_the_samples_lie_while_it_acts() {
    let mut record = steady(90);
    for i in 0..450 {
        record.flow[i] = if i < 200 {
            0.01
        } else {
            0.02 + 1e-4 * ((i - 200) % 20) as f64
        };
        record.speed[i] = if i < 200 {
            90.0
        } else {
            60.0 + ((i - 200) % 20) as f64
        };
    }
    let wear = find("pump_wear").unwrap().about();
    // Twenty levels: the lowest and the highest are the twentieth part at either end.
    assert_eq!(
        region(&record, wear, (400.0, 798.0)),
        "return flow 1206 to 1308 L/min, pump speed 61 to 78 %"
    );
    // One sample alone, in which it begins and ends.
    assert_eq!(
        region(&record, wear, (20.0, 20.0)),
        "return flow 600 to 600 L/min, pump speed 90 to 90 %"
    );
    assert_eq!(region(&record, wear, (20.5, 21.5)), "pump at rest");
    record.speed[..100].fill(4.0);
    record.flow[100..200].fill(9e-4);
    assert_eq!(
        region(&record, wear, (0.0, 100.0)),
        "no reading of return flow and pump speed together"
    );
    record.filled.pumping[..200].fill(false);
    assert_eq!(region(&record, wear, (0.0, 100.0)), "pump at rest");
    assert_eq!(region(&record, wear, (200.0, 390.0)), "pump at rest");
}

#[test]
fn the_region_of_what_acts_at_rest_is_the_stops_while_it_acts() {
    let mut record = steady(90);
    let gel = find("gel_strength").unwrap().about();
    for rest in [20..80, 200..260, 300..330] {
        record.filled.pumping[rest].fill(false);
    }
    let minutes = |samples: f64| format!("{:.0} min", samples * record.dt_s / 60.0);
    let of = |from: usize, to: usize| region(&record, gel, (record.t_s[from], record.t_s[to]));
    assert_eq!(
        of(0, 449),
        format!("3 stops of the pump, {} at rest", minutes(150.0))
    );
    assert_eq!(
        of(0, 100),
        format!("1 stop of the pump, {} at rest", minutes(60.0))
    );
}

#[test]
fn swell_is_told_with_its_period_and_amplitude_from_the_start_to_the_end() {
    let mut record = steady(90);
    record.setting.span_s = (100.0, 1000.0);
    let about = find("heave").unwrap().about();
    for (ratio, period_sd_s, half, probability) in [
        (5.0, 0.2, 0.392, 0.8),
        (2.5, 0.01, 0.098, 0.6),
        (1e3, 0.2, 0.392, 0.98),
    ] {
        let swell = Swell {
            period_s: 10.0,
            period_sd_s,
            amplitude_m: 0.5,
            amplitude_sd_m: 0.05,
            ratio,
            believed: 2.5,
            evidence: 40.0,
            hurdle: 12.0,
            limit_m: 0.04,
            folded_s: (ratio > 4.0).then_some(8.0),
        };
        let told = heaving(&record, about, swell, None);
        let folded = told.same_as.as_ref().map(|same| same.contains("8.0 s"));
        assert_eq!(folded, (ratio > 4.0).then_some(true));
        assert!((told.probability - probability).abs() < 1e-12);
        assert_eq!(told.intervals_s, [record.setting.span_s]);
        assert_eq!((told.evidence, told.hurdle), (40.0, 12.0));
        let [period, amplitude] = &told.parameters[..] else {
            panic!("{:?}", told.parameters);
        };
        assert_eq!((period.estimate, amplitude.estimate), (10.0, 0.5));
        assert!(
            (period.ci95.0 - 10.0 + half).abs() < 1e-9,
            "{:?}",
            period.ci95
        );
        assert!(
            (period.ci95.1 - 10.0 - half).abs() < 1e-9,
            "{:?}",
            period.ci95
        );
        assert!((amplitude.ci95.0 - 0.402).abs() < 1e-9 && (amplitude.ci95.1 - 0.598).abs() < 1e-9);
        assert_eq!(told.shows_in, [about.relation]);
        assert_eq!(told.equation_after, about.equation);
    }
}
