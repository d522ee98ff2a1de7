//! Public behaviour of `dgd-effects`, as claims.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod catalogue;
mod claims;
mod corrections;
mod free_run;
mod gaps;
mod head;
mod hostile;
mod memory;
mod passing;
mod relations;
mod setting;

use dgd_effects::{
    About, AppliedEffect, AugmentedModel, Changes, Connection, Curves, FRICTION_TERMS, HEAD_TERMS,
    Moment, Noise, Role, Scale, Setting, find_taking,
};

pub(crate) const G: f64 = 9.80665;
pub(crate) const AIR_PA: f64 = 101_325.0;
pub(crate) const RHO: f64 = 1200.0;
pub(crate) const SPAN_S: f64 = 6000.0;
pub(crate) const SAMPLES: usize = 6001;

/// A well without noise, with one connection.
pub(crate) fn setting() -> Setting {
    Setting {
        density_kg_m3: RHO,
        riser_area_m2: 0.16,
        line_area_m2: 0.02,
        line_diameter_m: 0.16,
        line_length_m: 1500.0,
        riser_volume_m3: 200.0,
        span_s: (0.0, SPAN_S),
        inlet_range_pa: (160e5, 168e5),
        outlets: 2,
        connections: vec![Connection {
            from_s: 3000.0,
            to_s: 3400.0,
        }],
        noise: Noise::default(),
    }
}

/// The rig's course: speed and booster step, one connection, in it one stop of the subsea pump.
pub(crate) fn moments() -> Vec<Moment> {
    (0..SAMPLES)
        .map(|i| {
            let t = i as f64;
            let pumping = !(3100.0..3300.0).contains(&t);
            Moment {
                index: i,
                t_s: t,
                dt_s: 1.0,
                mud_pump_m3_s: if (3000.0..3400.0).contains(&t) {
                    0.0
                } else {
                    0.03
                },
                booster_m3_s: if t < 2000.0 { 0.005 } else { 0.012 },
                topfill_m3_s: 0.001,
                flow_m3_s: if pumping { 0.04 } else { 0.0 },
                outflow_m3_s: if pumping { 0.04 } else { 0.0 },
                speed_pct: match () {
                    () if !pumping => 0.0,
                    () if t < 1000.0 => 80.0,
                    () => 84.0,
                },
                inlet_pa: 164e5 + 2e5 * (t / 700.0).sin(),
                outlet_pa: 184e5 + 1e5 * (t / 500.0).sin(),
                pumping,
            }
        })
        .collect()
}

/// Parameters of usual size, with the onset amid the recording.
pub(crate) fn usual(about: &About) -> Vec<f64> {
    about
        .parameters
        .iter()
        .map(|p| match p.role {
            Role::Onset => 1500.0,
            Role::Duration(_) => 2000.0,
            _ => p.usual,
        })
        .collect()
}

/// What an effect changes, moment by moment.
pub(crate) fn drive(
    id: &str,
    parameters: &[f64],
    setting: &Setting,
    moments: &[Moment],
) -> Vec<Changes> {
    let effect = find_taking(id, parameters.len()).unwrap();
    let mut action = effect.begin(parameters, setting);
    moments
        .iter()
        .map(|moment| {
            let mut changes = Changes::default();
            action(moment, &mut changes);
            changes
        })
        .collect()
}

/// Every member of the changes, with the size that is usual for it.
pub(crate) fn members(c: &Changes) -> [(&'static str, f64, f64); 16] {
    [
        ("inflow", c.inflow_m3_s, 1e-3),
        ("area", c.area_factor, 1.0),
        ("entering", c.entering_kg_m3, 10.0),
        ("riser", c.riser_kg_m3, 10.0),
        ("line", c.line_kg_m3, 10.0),
        ("drop", c.line_drop_pa, 1e5),
        ("friction", c.friction_factor, 1.0),
        ("fall", c.line_fall_m, 10.0),
        ("head factor", c.head_factor, 1.0),
        ("head", c.head_pa, 1e5),
        ("speed", c.speed_pct, 1.0),
        ("recirculation", c.recirculation_m3_s, 1e-3),
        ("leak", c.leak_m3_s, 1e-3),
        ("gain", c.meter_gain, 1.0),
        ("bias 1", c.outlet_bias_pa[0], 1e4),
        ("bias 2", c.outlet_bias_pa[1], 1e4),
    ]
}

/// A model with quadratic friction and head, and effects.
pub(crate) fn model(effects: &[(&str, &[f64])]) -> AugmentedModel {
    let mut friction = [0.0; FRICTION_TERMS];
    friction[3] = 6e5;
    let mut head = [0.0; HEAD_TERMS];
    head[1] = 3e6;
    head[3] = -5.6e5;
    AugmentedModel {
        curves: Curves {
            scale: Scale {
                flow_m3_s: 0.05,
                speed_pct: 100.0,
                laminar: None,
            },
            friction,
            head,
        },
        speed_range_pct: (40.0, 100.0),
        ratio_range: (1e-4, 8e-4),
        span_s: None,
        inlet_range_pa: None,
        effects: effects
            .iter()
            .map(|(id, parameters)| AppliedEffect {
                id: (*id).to_owned(),
                parameters: parameters.to_vec(),
            })
            .collect(),
    }
}

/// Whether two numbers agree within a share of the second.
pub(crate) fn close(found: f64, expected: f64, share: f64) {
    assert!(
        (found - expected).abs() <= share * expected.abs(),
        "found {found}, expected {expected} within {share}"
    );
}
