//! Two rigs of different size that look alike in percent: the scale is not in the data.

use crate::rig::Rig;
use dgd_identify::{DataUsed, Estimate, FrictionModel, FrictionTerm, Model, PumpModel};
use dgd_mask::{mask_model, mask_recording};

/// Longer, wider, heavier: no length, flow, density or pressure is the first rig's.
fn other() -> Rig {
    Rig {
        length: 1.7,
        flow: 2.3,
        density_kg_m3: 1640.0,
        ..Rig::default()
    }
}

fn model(rig: &Rig) -> Model {
    let (l, q) = (rig.length, rig.flow);
    let pressure = l * rig.density_kg_m3 / Rig::default().density_kg_m3;
    let estimate = |value: f64| Estimate {
        value,
        standard_error: Some(value / 50.0),
    };
    let term = |power: u8, c: f64| FrictionTerm {
        power,
        coefficient: estimate(c * pressure / q.powi(power.into())),
    };
    Model {
        density_kg_m3: rig.density_kg_m3,
        geometry: rig.well().geometry,
        friction: FrictionModel {
            terms: vec![term(0, 4.1e3), term(2, 1.9e8), term(3, 2.7e8)],
            mse_pa2: (8.1e3 * pressure).powi(2),
            r2: 0.99,
            samples: 5000,
            condition: 11.0,
        },
        pump: PumpModel {
            c0: estimate(0.061 * l),
            c1: estimate(7.3 * l / q),
            c2: estimate(5.3e3 * l / q.powf(1.9)),
            n0: 2.1,
            n2: 1.9,
            mse_m2: (2.3 * l).powi(2),
            r2: 0.98,
            samples: 5000,
            condition: 40.0,
            active_constraints: Vec::new(),
        },
        delay_s: 7.0,
        data: DataUsed {
            recordings: vec!["rig.mat".into()],
            samples: 6000,
            kept: 5000,
            step_s: 1.0,
            rejected: Vec::new(),
        },
    }
}

#[test]
fn recordings_of_two_rig_sizes_agree_in_percent_to_their_noise() {
    let (a, b) = (Rig::default(), other());
    let masked = [&a, &b].map(|rig| {
        let (prepared, series) = rig.voyage();
        mask_recording(&prepared, &series, &rig.references()).unwrap()
    });
    // The noise of either, which is the same share of their references, and their rounding, which is less.
    let references = a.references();
    let [_, _, _, level_m] = references.disclose();
    let noise = 5e-4 * 7f64.sqrt() * 2f64.sqrt();
    let flow = 100.0 * noise;
    let friction = references.mask_friction(noise * level_m * a.well().weight_pa_m());
    let head = references.mask_head(2f64.sqrt() * noise * level_m);
    let [a, b] = &masked;
    let within = [0.0, flow, flow, friction, head, 100.0 * noise, 0.0];
    for (((name, a), (_, b)), within) in a.columns().iter().zip(b.columns()).zip(within) {
        let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
        let apart = (squares.sum::<f64>() / a.len() as f64).sqrt();
        assert!(apart <= 1.4 * within, "{name}: {apart} of {within}");
    }
}

#[test]
fn who_has_the_catalogue_of_the_pump_has_the_scale() {
    // No leak that could be mended: the limit that the README states.
    let rig = other();
    let (model, references) = (model(&rig), rig.references());
    let masked = mask_model(&model, &references);
    let catalogue = &model.pump;
    let head_m = 100.0 * catalogue.c0.value / masked.pump[0].value;
    let by_flow = masked.pump[1].value / masked.pump[0].value;
    let flow_m3_s = 100.0 * by_flow / (catalogue.c1.value / catalogue.c0.value);
    let [flow, _, head, _] = references.disclose();
    assert!((head_m / head - 1.0).abs() < 1e-9);
    assert!((flow_m3_s / flow - 1.0).abs() < 1e-9);
}

#[test]
fn models_of_two_rig_sizes_are_the_same_in_percent() {
    let numbers = |rig: &Rig| {
        let m = mask_model(&model(rig), &rig.references());
        let estimates = m.friction.iter().map(|t| t.coefficient).chain(m.pump);
        let mut all: Vec<f64> = estimates
            .flat_map(|e| [e.value, e.standard_error.unwrap()])
            .collect();
        all.extend([m.friction_rmse_pct, m.head_rmse_pct, m.n0, m.n2, m.delay_s]);
        all.extend([m.level_rate_per_s, m.level_in_head, m.friction_in_head]);
        all.push(m.depth_in_head_pct);
        all
    };
    for (a, b) in numbers(&Rig::default()).iter().zip(numbers(&other())) {
        assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}");
    }
}

#[test]
fn a_masked_model_predicts_what_the_model_does() {
    let rig = Rig::default();
    let (model, references) = (model(&rig), rig.references());
    let masked = mask_model(&model, &references);
    let (flow_m3_s, speed): (f64, f64) = (0.047, 63.0);
    let flow_pct = references.mask_flow(flow_m3_s);
    let friction: f64 = model
        .friction
        .terms
        .iter()
        .map(|t| t.coefficient.value * flow_m3_s.powi(t.power.into()))
        .sum();
    let friction_pct: f64 = masked
        .friction
        .iter()
        .map(|t| t.coefficient.value * flow_pct.powi(t.power.into()))
        .sum();
    assert!((friction_pct - references.mask_friction(friction)).abs() < 1e-9);
    let pump = &model.pump;
    let head = pump.c0.value * speed.powf(pump.n0)
        - pump.c1.value * speed * flow_m3_s
        - pump.c2.value * flow_m3_s.powf(pump.n2);
    let [c0, c1, c2] = masked.pump.map(|c| c.value);
    let head_pct =
        c0 * speed.powf(masked.n0) - c1 * speed * flow_pct - c2 * flow_pct.powf(masked.n2);
    assert!((head_pct - references.mask_head(head)).abs() < 1e-9);
    // Steady flow (Eq. 4.2): H = h + F/(rho g), the level being the lift of a full line.
    let level_m = 120.0;
    let steady = references.mask_head(level_m + friction / rig.well().weight_pa_m());
    let by_mask = masked.level_in_head * references.mask_level(level_m)
        + masked.friction_in_head * friction_pct;
    assert!((steady - by_mask).abs() < 1e-9);
    assert_eq!(masked.depth_in_head_pct, 0.0);
    // Net outflow of 1 % raises h by this much a second.
    let rate =
        references.mask_level(references.unmask_flow(1.0) / rig.well().geometry.riser_area_m2());
    assert!((masked.level_rate_per_s - rate).abs() < 1e-15);
}

#[test]
fn the_balance_holds_for_a_pump_whose_outlet_is_not_at_the_depth_of_its_inlet() {
    let rig = Rig::default();
    let references = rig.references();
    for deeper_m in [-2.5, 0.0, 7.25] {
        let mut well = rig.well();
        well.geometry.pump_outlet_depth_m += deeper_m;
        let mut model = model(&rig);
        model.geometry = well.geometry.clone();
        let masked = mask_model(&model, &references);
        // Two pressures in steady flow, seen three ways by the well itself.
        let (inlet_pa, outlet_pa) = (2.6e6, 4.3e6);
        let level = references.mask_level(well.level_m(inlet_pa));
        let friction = references.mask_friction(well.line_friction_pa(outlet_pa));
        let head = references.mask_head(well.head_m(inlet_pa, outlet_pa));
        let by_mask = masked.level_in_head * level
            + masked.friction_in_head * friction
            + masked.depth_in_head_pct;
        assert!(
            (head - by_mask).abs() < 1e-9,
            "{deeper_m}: {head} {by_mask}"
        );
    }
}
