//! What is missing for a while leaves no trace.

use crate::{drive, members, moments, setting, usual};
use dgd_effects::{Curve, KNOTS, Moment, Place, Quantity, catalogue};

fn missing(m: &Moment) -> Moment {
    Moment {
        mud_pump_m3_s: f64::NAN,
        booster_m3_s: f64::NAN,
        topfill_m3_s: f64::NAN,
        flow_m3_s: f64::NAN,
        outflow_m3_s: f64::NAN,
        speed_pct: f64::NAN,
        inlet_pa: f64::NAN,
        outlet_pa: f64::NAN,
        ..*m
    }
}

/// Ids with parameters: the catalogue, and a correction along every quantity.
fn all() -> Vec<(&'static str, Vec<f64>)> {
    let mut all: Vec<_> = catalogue()
        .iter()
        .map(|e| (e.about().id, usual(e.about())))
        .collect();
    for quantity in Quantity::ALL {
        let curve = Curve::new(
            Place::Balance,
            quantity,
            (-1.0, 1.0),
            (0..KNOTS).map(|k| 1e-4 * k as f64).collect(),
        );
        all.push(("unknown", curve.parameters()));
    }
    all
}

#[test]
fn effects_recover_from_missing_values_at_the_start_and_amid() {
    let (setting, clean) = (setting(), moments());
    for gap in [0..10, 1600..1610, 3050..3060, 3150..3160] {
        let mut holed = clean.clone();
        for i in gap.clone() {
            holed[i] = missing(&clean[i]);
        }
        for (id, p) in all() {
            let with = drive(id, &p, &setting, &holed);
            let without = drive(id, &p, &setting, &clean);
            for (i, c) in with.iter().enumerate().skip(gap.end) {
                assert!(
                    members(c).iter().all(|m| m.1.is_finite()),
                    "{id} at {i} after {gap:?}: {c:?}"
                );
            }
            for ((name, a, size), (_, b, _)) in
                members(&with[6000]).iter().zip(members(&without[6000]))
            {
                assert!(
                    (a - b).abs() < 0.02 * size,
                    "{id} {name} after {gap:?}: {a}, without gap {b}"
                );
            }
        }
    }
}
