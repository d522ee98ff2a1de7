//! What the traces show that no finding says: what is left, and transmitters that are apart throughout.

use crate::diagnosis::{Check, NOISE_IS_LEFT, Trace};
use crate::relations::Applied;
use crate::twins::Pair;
use dgd_effects::Relation;
use dgd_recording::Well;

/// The check that channels share one clock.
pub(super) const ONE_CLOCK: &str = "the channels share one clock";

/// Transmitters of one pressure that differ by more than this, Pa, are not both right. Offsets are fitted, whatever they are.
const APART_PA: f64 = 1e5;

/// Whether what is left of every relation, and between every two transmitters, is what noise and instruments within their accuracy make.
pub(super) fn left(traces: &[Trace]) -> Check {
    let name = |t: &Trace| {
        t.pair
            .map_or_else(|| t.relation.name().replace('_', " "), str::to_owned)
    };
    let more: Vec<String> = (traces.iter())
        .filter(|t| t.exceeds_noise())
        .map(|t| format!("{} {:.1} times", name(t), t.excess()))
        .collect();
    let detail = if more.is_empty() {
        let each: Vec<String> = (traces.iter())
            .filter(|t| t.pair.is_none() && t.excess().is_finite())
            .map(|t| format!("{} {:.1}", name(t), t.excess()))
            .collect();
        match each.join(", ") {
            none if none.is_empty() => "no relation has rows".to_owned(),
            each => format!(
                "{each} times what noise and instrument accuracy explain (at most 2, in the pump head 2.4)"
            ),
        }
    } else {
        format!(
            "root mean square residual over what noise and instrument accuracy explain (limit 2, pump head 2.4): {}",
            more.join(", ")
        )
    };
    Check {
        name: NOISE_IS_LEFT.into(),
        passed: more.is_empty(),
        detail,
    }
}

/// Whether a relation keeps more than that.
pub(super) fn is_left_in(traces: &[Trace], relation: Relation) -> bool {
    let of = |t: &&Trace| t.pair.is_none() && t.relation == relation;
    traces.iter().filter(of).any(Trace::exceeds_noise)
}

/// Whether two transmitters of one pressure read the same but for what instruments may be off by; `None` where no pressure has two.
pub(super) fn apart(well: &Well, traces: &[Trace]) -> Option<Check> {
    let below_m = well
        .geometry
        .riser_pressure_sensor_depth_m
        .map(|depth_m| well.geometry.pump_inlet_depth_m - depth_m);
    let metre_pa = well.weight_pa_m();
    let weight_pa = metre_pa * below_m.unwrap_or(0.0);
    let pairs: Vec<(&str, f64)> = (traces.iter())
        .filter_map(|t| {
            let pair = t.pair?;
            let due = if pair == Pair::InletAndRiser.name() {
                weight_pa
            } else {
                0.0
            };
            Some((pair, t.offset - due))
        })
        .filter(|(_, off)| off.is_finite())
        .collect();
    if pairs.is_empty() {
        return None;
    }
    let told: Vec<String> = (pairs.iter())
        // Without the sign of a zero that was rounded.
        .map(|(pair, off)| {
            let bar = (1e-3 * off).round() / 100.0 + 0.0;
            let depths = *pair == Pair::InletAndRiser.name() && off.abs() > APART_PA;
            let metres = depths.then(|| {
                let metres = off.abs() / metre_pa;
                format!(" (as much as {metres:.1} m of the mud: are `pump_inlet_depth` and `riser_pressure_sensor_depth` right?)")
            });
            format!("{pair} {bar:+.2} bar{}", metres.unwrap_or_default())
        })
        .collect();
    Some(Check {
        name: "transmitters of one pressure agree".into(),
        passed: pairs.iter().all(|(_, off)| off.abs() <= APART_PA),
        detail: format!(
            "{}, with the weight of the mud between them deducted; the offsets are fitted, not explained",
            told.join(", ")
        ),
    })
}

/// Whether it allows for something that is early.
pub(super) fn is_early(applied: &Applied) -> bool {
    let times = applied.effect.about().search.timing.is_some();
    applied.allowance && times && applied.parameters[0] < 0.0
}

/// Whether nothing had to be allowed for that is early, which no rotor, edge or filter makes; `None` if nothing had.
pub(super) fn early(allowances: &[Applied]) -> Option<Check> {
    let early: Vec<String> = (allowances.iter())
        .filter(|a| is_early(a))
        .map(|a| format!("{} {} s", a.id(), a.parameters[0]))
        .collect();
    (!early.is_empty()).then(|| Check {
        name: ONE_CLOCK.into(),
        passed: false,
        detail: format!(
            "{}: the meter leads the pressures, which no meter can; this was corrected",
            early.join(", ")
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::{apart, early, left};
    use crate::diagnosis::Trace;
    use crate::relations::Applied;
    use crate::test_rig::{recorded, steady};
    use crate::twins::Pair;
    use dgd_effects::{Relation, catalogue};

    fn trace(pair: Option<&'static str>, after: f64, offset: f64) -> Trace {
        Trace {
            relation: Relation::PumpHead,
            pair,
            unit: "Pa",
            t_s: vec![0.0; 3],
            before: vec![9e9; 3],
            after: vec![after, -after, f64::NAN],
            offset,
            noise: 3e3,
            wander: 4e3,
        }
    }

    #[test]
    fn what_stands_twice_as_far_off_as_it_may_is_told_and_of_the_head_a_little_further() {
        let friction = |after: f64| Trace {
            relation: Relation::ReturnLineFriction,
            ..trace(None, after, 0.0)
        };
        assert!(left(&[friction(9.9e3)]).passed);
        assert!(!left(&[friction(1.01e4)]).passed);
        assert!(!left(&[trace(Some(Pair::Outlets.name()), 1.01e4, 0.0)]).passed);
        assert!(left(&[trace(None, 1.19e4, 0.0)]).passed);
        assert!(left(&[trace(None, f64::NAN, 0.0)]).passed);
        let told = left(&[trace(None, 9.9e3, 0.0), trace(None, 1.25e4, 0.0)]);
        assert!(!told.passed);
        assert!(
            told.detail.ends_with(": pump head 2.5 times"),
            "{}",
            told.detail
        );
    }

    #[test]
    fn two_of_one_pressure_are_a_bar_apart_at_the_most_beyond_the_mud_between() {
        let (well, _) = recorded(&steady(10), 0.0);
        let of = |pair: Pair, offset: f64| apart(&well, &[trace(Some(pair.name()), 0.0, offset)]);
        assert_eq!(apart(&well, &[trace(None, 0.0, 0.0)]), None);
        for (pair, offset, passed) in [
            (Pair::Inlets, 9.9e4, true),
            (Pair::Inlets, -1.01e5, false),
            (Pair::Outlets, 3e5, false),
        ] {
            let check = of(pair, offset).unwrap_or_else(|| unreachable!("there are two"));
            assert_eq!(check.passed, passed, "{}", check.detail);
        }
        // A riser transmitter that sits ten metres lower reads a bar more, and that is right.
        let mut lower = well.clone();
        lower.geometry.riser_pressure_sensor_depth_m =
            Some(lower.geometry.pump_inlet_depth_m + 10.0);
        let weight = 10.0 * 9.806_65 * lower.mud_density_kg_m3;
        for (offset, passed) in [
            (-weight, true),
            (-weight - 1.01e5, false),
            (0.0, weight <= 1e5),
        ] {
            let check = apart(
                &lower,
                &[trace(Some(Pair::InletAndRiser.name()), 0.0, offset)],
            );
            let check = check.unwrap_or_else(|| unreachable!("there are two"));
            assert_eq!(check.passed, passed, "{offset}");
            let asks = check
                .detail
                .contains("m of the mud: are `pump_inlet_depth`");
            assert_eq!(asks, !passed, "{}", check.detail);
        }
    }

    #[test]
    fn a_meter_that_is_early_is_told_and_a_late_one_is_not() {
        let meter = |time_s: f64, allowance: bool| {
            let delay = catalogue()
                .iter()
                .find(|e| e.about().id == "return_flow_delay");
            Applied {
                allowance,
                ..Applied::new(*delay.expect("of the catalogue"), vec![time_s])
            }
        };
        assert_eq!(early(&[meter(2.0, true), meter(-2.0, false)]), None);
        let told = early(&[meter(-3.0, true)]).expect("it is early");
        assert!(!told.passed && told.detail.starts_with("return_flow_delay -3 s"));
    }
}
