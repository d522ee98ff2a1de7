//! What a free run gives closes the relations, with the changes that the effects make of it.

use crate::{AIR_PA, G, RHO, SPAN_S, drive, model, setting, usual};
use dgd_effects::{Changes, Curve, Inputs, Moment, Place, Quantity, catalogue, find};

/// Two hours of slow swings, pump running throughout, from near the balance.
struct Course {
    moments: Vec<Moment>,
    changes: Vec<Changes>,
}

fn course(id: &str, p: &[f64]) -> Course {
    let s = setting();
    let swing = |t: f64, period: f64| (std::f64::consts::TAU * t / period).sin();
    let time: Vec<f64> = (0..=6000).map(f64::from).collect();
    let mud: Vec<f64> = time
        .iter()
        .map(|t| 0.03 + 0.003 * swing(*t, 900.0))
        .collect();
    let booster: Vec<f64> = time
        .iter()
        .map(|t| 0.01 + 0.002 * swing(*t, 700.0))
        .collect();
    let none = vec![0.0; time.len()];
    let speed: Vec<f64> = time.iter().map(|t| 80.0 + 4.0 * swing(*t, 400.0)).collect();
    let inputs = Inputs {
        time_s: &time,
        step_s: 1.0,
        mud_pump_m3_s: &mud,
        booster_m3_s: &booster,
        topfill_m3_s: &none,
        speed_pct: &speed,
    };
    let run = model(&[(id, p)])
        .free_run(&s, inputs, 0..time.len(), (164e5, 0.04))
        .unwrap();
    let moments: Vec<Moment> = (0..time.len())
        .map(|i| Moment {
            index: i,
            t_s: time[i],
            dt_s: 1.0,
            mud_pump_m3_s: mud[i],
            booster_m3_s: booster[i],
            topfill_m3_s: 0.0,
            flow_m3_s: run.return_flow_m3_s[i],
            outflow_m3_s: run.return_flow_m3_s[i],
            speed_pct: speed[i],
            inlet_pa: run.inlet_pa[i],
            outlet_pa: run.outlet_pa[i],
            pumping: true,
        })
        .collect();
    Course {
        changes: drive(id, p, &s, &moments),
        moments,
    }
}

/// Effects whose flow meter and transmitters tell the truth, and corrections of each relation.
fn plain() -> Vec<(&'static str, Vec<f64>)> {
    let instruments = [
        "return_flow_delay",
        "return_flow_gain",
        "line_gas_storage",
        "line_leak",
    ];
    let mut all: Vec<(&str, Vec<f64>)> = catalogue()
        .iter()
        .map(|e| e.about())
        .filter(|a| !instruments.contains(&a.id) && !a.id.starts_with("outlet_"))
        .map(|a| (a.id, usual(a)))
        .collect();
    for (place, size) in [
        (Place::Friction, 4e4),
        (Place::Head, 4e4),
        (Place::Balance, 1e-3),
    ] {
        let knots = [0.0, 0.5, 1.0, 1.5, 2.0, 2.0, 2.0, 0.5, -1.0, -0.5, 0.0, 0.0];
        let curve = Curve::new(
            place,
            Quantity::Time,
            (0.0, SPAN_S),
            knots.map(|k: f64| k * size).to_vec(),
        );
        all.push(("unknown", curve.parameters()));
    }
    all
}

/// Samples after the start's swing.
fn settled(c: &Course) -> impl Iterator<Item = (&Moment, &Moment, &Changes)> {
    let pairs = c.moments.windows(2).zip(&c.changes[1..]);
    // A sample beside a jump holds the changes of the sample before.
    let calm = |id: f64| [1500.0, 3500.0].iter().all(|jump| (id - jump).abs() > 60.0);
    pairs
        .map(|(pair, change)| (&pair[0], &pair[1], change))
        .filter(move |(_, m, _)| m.t_s > 100.0 && calm(m.t_s))
}

#[test]
fn the_rise_over_the_pump_is_the_head_as_changed() {
    let base = model(&[]);
    for (id, p) in plain() {
        let c = course(id, &p);
        for (_, m, change) in settled(&c) {
            let lift = change.head_factor * (1.0 + change.riser_kg_m3 / RHO);
            let through = m.flow_m3_s + change.recirculation_m3_s;
            let head =
                lift * base.head_pa(m.speed_pct + change.speed_pct, through) + change.head_pa;
            let rise = m.outlet_pa - m.inlet_pa;
            assert!(
                (rise - head).abs() < 2e3,
                "{id} at {}: {rise}, head {head}",
                m.t_s
            );
        }
    }
}

#[test]
fn the_outlet_is_column_friction_and_inertia_as_changed() {
    let (base, s) = (model(&[]), setting());
    for (id, p) in plain() {
        let c = course(id, &p);
        for (before, m, change) in settled(&c) {
            let column = AIR_PA + (RHO + change.line_kg_m3) * G * s.line_length_m;
            let factor = change.friction_factor * (1.0 + change.line_kg_m3 / RHO);
            let inertia = RHO * s.line_length_m / s.line_area_m2 * (m.flow_m3_s - before.flow_m3_s);
            let outlet = column
                + factor * base.curves.friction_pa(m.flow_m3_s)
                + change.line_drop_pa
                + inertia;
            assert!(
                (m.outlet_pa - outlet).abs() < 1e3,
                "{id} at {}: {} {outlet}",
                m.t_s,
                m.outlet_pa
            );
        }
    }
}

#[test]
fn the_level_is_the_mass_that_came_and_did_not_leave() {
    let s = setting();
    for (id, p) in plain() {
        let c = course(id, &p);
        let (first, last) = (&c.moments[0], &c.moments[6000]);
        let mut mass = 0.0;
        for (pair, change) in c.moments.windows(2).zip(&c.changes[1..]) {
            let entering = pair[1].mud_pump_m3_s + pair[1].booster_m3_s;
            let leaving = 0.5 * (pair[0].flow_m3_s + pair[1].flow_m3_s);
            let net = entering * (1.0 + change.entering_kg_m3 / RHO) + change.inflow_m3_s
                - leaving * (1.0 + change.riser_kg_m3 / RHO);
            mass += net / change.area_factor;
        }
        let gained = (last.inlet_pa - first.inlet_pa) * s.riser_area_m2 / (RHO * G);
        // A thousandth of a litre a second.
        assert!(
            (gained - mass).abs() < 1e-6 * SPAN_S,
            "{id}: {gained} m³, expected {mass}"
        );
    }
}

#[test]
fn each_effect_of_pump_and_line_is_larger_than_what_the_relations_leave_open() {
    let base = model(&[]);
    for id in [
        "gas_in_pump",
        "pump_wear",
        "pump_speed_lag",
        "mud_density_change",
        "viscosity_drift",
    ] {
        let p = usual(find(id).unwrap().about());
        let c = course(id, &p);
        let most = settled(&c)
            .map(|(_, m, _)| {
                (m.outlet_pa - m.inlet_pa - base.head_pa(m.speed_pct, m.flow_m3_s)).abs()
            })
            .fold(0.0, f64::max);
        assert_eq!(most > 1e4, id != "viscosity_drift", "{id}: {most} Pa");
    }
}
