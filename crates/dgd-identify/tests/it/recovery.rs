//! The truth is recovered, and what must not matter does not.

use super::rig::{self, Rig, fit, well};
use dgd_identify::{IdentifyOptions, Loss, Minimum, Model, RobustOptions};
use dgd_recording::Recording;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Root mean square error of a model's friction, Pa, and head, m, over the truth's swings.
fn errors(model: &Model, rig: &Rig) -> (f64, f64) {
    let line = model.return_line();
    let (mut friction, mut head) = (0.0, 0.0);
    for i in 0..rig.samples {
        let t = f64::from(i) * rig.step_s;
        let (w, q) = (rig.speed_pct(t), rig.flow_m3_s(t));
        friction += (line.friction.loss_pa(q) - rig::friction_pa(q)).powi(2);
        head += (line.pump.head_m(w, q) - rig::head_m(w, q)).powi(2);
    }
    let n = f64::from(rig.samples);
    ((friction / n).sqrt(), (head / n).sqrt())
}

#[test]
fn known_friction_delay_and_head_curve_are_recovered_within_their_standard_errors() {
    for seed in 1..=4 {
        let rig = Rig {
            seed,
            ..Rig::default()
        };
        let found = rig.identify();
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        let model = &found.model;
        assert_eq!(model.delay_s, 12.0);
        assert_eq!(found.sweep.minimum, Minimum::Interior);
        for (term, truth) in model.friction.terms.iter().zip([rig::B, rig::D, rig::E]) {
            let error = term.coefficient.standard_error.unwrap();
            let off = (term.coefficient.value - truth).abs();
            assert!(
                off < 4.0 * error,
                "seed {seed}: power {} off by {off}, standard error {error}",
                term.power
            );
            assert!(
                error < 0.1 * truth,
                "seed {seed}: the fit says little: {error}"
            );
        }
        let pump = &model.pump;
        for (found, truth) in [(pump.c0, rig::C0), (pump.c1, rig::C1), (pump.c2, rig::C2)] {
            let error = found.standard_error.unwrap();
            let off = (found.value - truth).abs();
            assert!(
                off < 4.0 * error,
                "seed {seed}: off by {off}, standard error {error}"
            );
            assert!(
                error < 0.2 * truth,
                "seed {seed}: the fit says little: {error}"
            );
        }
        // A least-squares fit of p parameters misses the truth by √(p·mse/n) in root mean square.
        let n = model.friction.samples as f64;
        let (friction, head) = errors(model, &rig);
        assert!(friction < 2.0 * (3.0 * model.friction.mse_pa2 / n).sqrt());
        assert!(head < 2.0 * (5.0 * model.pump.mse_m2 / n).sqrt(), "{head}");
        assert!((model.pump.n0 - rig::N0).abs() < 0.02, "{}", model.pump.n0);
        assert!((model.pump.n2 - rig::N2).abs() < 0.1, "{}", model.pump.n2);
        // The mean of two transmitters has 1 kPa of noise; that of the meter adds a little.
        assert!((model.friction.mse_pa2.sqrt() / 1.05e3 - 1.0).abs() < 0.1);
    }
}

#[test]
fn every_rung_is_better_than_the_one_below() {
    let found = Rig::default().identify();
    let undelayed = found.undelayed.unwrap().mse_pa2;
    let delayed = found.sweep.fit.mse_pa2;
    let cubic = found.cubic.unwrap().mse_pa2;
    assert!(
        cubic < 0.5 * delayed && delayed < 0.5 * undelayed,
        "{cubic} {delayed} {undelayed}"
    );
    let plain = found.pump.plain.unwrap().mse_m2;
    let constrained = found.pump.constrained.unwrap().fit.mse_m2;
    let search = found.pump.search.unwrap().unwrap().fit.mse_m2;
    assert!(search < plain && plain <= constrained);
    assert!(found.pump.shape.unwrap().concave);
}

#[test]
fn a_recording_at_two_hertz_gives_the_delay_in_seconds() {
    let rig = Rig {
        step_s: 0.5,
        delay_s: 6.5,
        ..Rig::default()
    };
    let found = rig.identify();
    assert_eq!(found.sweep.best_delay_samples, 13);
    assert_eq!(found.model.delay_s, 6.5);
    assert_eq!(found.model.data.step_s, 0.5);
}

#[test]
fn a_meter_without_a_delay_is_no_edge_of_the_range() {
    let rig = Rig {
        delay_s: 0.0,
        ..Rig::default()
    };
    let found = rig.identify();
    assert_eq!(found.model.delay_s, 0.0);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
}

#[test]
fn a_delay_beyond_the_range_is_told() {
    let rig = Rig::default();
    let short = IdentifyOptions {
        delays: 0..=8,
        ..IdentifyOptions::default()
    };
    let found = fit(rig.recording(), 1.0, &short);
    assert_eq!(found.model.delay_s, 8.0);
    assert!(
        found
            .warnings
            .iter()
            .any(|w| w.contains("sweep further up")),
        "{:?}",
        found.warnings
    );
    let late = IdentifyOptions {
        delays: 15..=20,
        ..IdentifyOptions::default()
    };
    let found = fit(rig.recording(), 1.0, &late);
    assert!(
        found
            .warnings
            .iter()
            .any(|w| w.contains("sweep further down")),
        "{:?}",
        found.warnings
    );
}

#[test]
fn a_delay_that_is_given_is_not_doubted() {
    let given = IdentifyOptions {
        delays: 12..=12,
        ..IdentifyOptions::default()
    };
    let found = fit(Rig::default().recording(), 1.0, &given);
    assert_eq!(found.model.delay_s, 12.0);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
}

#[test]
fn exchanging_the_transmitters_of_a_side_changes_no_bit() {
    let recording = Rig::default().recording();
    let mut exchanged = recording.clone();
    exchanged.pump_inlet_pressure_pa.reverse();
    exchanged.pump_outlet_pressure_pa.reverse();
    let options = IdentifyOptions::default();
    let model = fit(recording, 1.0, &options).model;
    assert_eq!(fit(exchanged, 1.0, &options).model, model);
}

#[test]
fn when_the_recording_was_taken_does_not_matter() {
    let recording = Rig::default().recording();
    let later = Recording {
        time_s: recording.time_s.iter().map(|t| t + 1.7e9).collect(),
        ..recording.clone()
    };
    let options = IdentifyOptions::default();
    let model = fit(recording, 1.0, &options).model;
    assert_eq!(fit(later, 1.0, &options).model, model);
}

#[test]
fn a_missing_transmitter_leaves_the_side_to_the_other() {
    let rig = Rig::default();
    let mut recording = rig.recording();
    recording.pump_inlet_pressure_pa.pop();
    recording.pump_outlet_pressure_pa[0].fill(f64::NAN);
    let model = fit(recording, 1.0, &IdentifyOptions::default()).model;
    assert_eq!(model.delay_s, 12.0);
    let n = model.friction.samples as f64;
    let (friction, head) = errors(&model, &rig);
    assert!(friction < 2.0 * (3.0 * model.friction.mse_pa2 / n).sqrt());
    assert!(head < 2.0 * (5.0 * model.pump.mse_m2 / n).sqrt());
}

#[test]
fn a_robust_fit_resists_outliers_that_the_screening_leaves() {
    let rig = Rig::default();
    let mut recording = rig.recording();
    // A tenth of the time both outlet transmitters read 2 bar too much for two minutes.
    for i in (0..recording.len()).filter(|i| i % 1200 < 120) {
        for outlet in &mut recording.pump_outlet_pressure_pa {
            outlet[i] += 2e5;
        }
    }
    // The sweep is least squares whatever the loss, so the delay is given.
    let with = |loss| IdentifyOptions {
        delays: 12..=12,
        loss,
        ..IdentifyOptions::default()
    };
    let plain = fit(recording.clone(), 1.0, &with(Loss::Squared));
    let robust = fit(recording, 1.0, &with(Loss::Huber(RobustOptions::default())));
    let [(plain, _), (robust, _)] = [plain, robust].map(|found| errors(&found.model, &rig));
    assert!(plain > 1.5e4, "the outliers must matter: {plain}");
    assert!(robust < 0.02 * plain, "{robust} Pa against {plain} Pa");
}

#[test]
fn the_model_says_what_it_was_made_from() {
    let mut recording = Rig::default().recording();
    recording.pump_speed_pct[100..400].fill(0.0);
    let model = fit(recording, 1.0, &IdentifyOptions::default()).model;
    assert_eq!(model.data.samples, 9000);
    let off = ("pump off".to_owned(), 300);
    assert!(
        model.data.rejected.contains(&off),
        "{:?}",
        model.data.rejected
    );
    assert!(model.data.rejected.iter().all(|(_, count)| *count > 0));
    // 300 s off and the 120 s of settling thereafter.
    assert!(
        (8500..=8580).contains(&model.data.kept),
        "{}",
        model.data.kept
    );
    assert!(model.fits_well(&well()));
    let mut heavier = well();
    heavier.mud_density_kg_m3 += 1.0;
    assert!(!model.fits_well(&heavier));
    model.return_line().check().unwrap();
}

/// Of a line that moves as it must: the outlet pressure accelerates the mud before it flows, so the meter seems later by inertia over the slope
/// of the friction.
#[test]
fn the_delay_found_holds_the_lag_of_the_line() {
    use dgd_dynamics::inputs::{Interpolation, Signal};
    use dgd_dynamics::return_line::{
        Friction, LineState, PumpHead, ReturnLine, SimulationOptions, derive_outputs,
        measured_flow, simulate_coupled,
    };
    let line = ReturnLine {
        density_kg_m3: 1080.0,
        riser_area_m2: 0.170_44,
        line_area_m2: 0.018_241,
        inlet_depth_m: 350.3,
        outlet_depth_m: 348.0,
        friction: Friction {
            b_pa: rig::B,
            c_pa_s_m3: 0.0,
            d_pa_s2_m6: rig::D,
            e_pa_s3_m9: rig::E,
        },
        pump: PumpHead {
            c0: rig::C0,
            c1: rig::C1,
            c2: rig::C2,
            n0: rig::N0,
            n2: rig::N2,
        },
        non_return_valve: true,
        b_is_offset: false,
    };
    let time: Vec<f64> = (0..9000).map(f64::from).collect();
    let of = |value: &dyn Fn(f64) -> f64| time.iter().map(|t| value(*t)).collect::<Vec<f64>>();
    let inflow = of(&|t| 0.045 + 0.01 * (t / 397.0).sin());
    let speed = of(&|t| 65.0 + 6.0 * (t / 173.0).sin() + 4.0 * (t / 31.0 + 1.0).sin());
    let signal = |values| Signal::new("input", &time, values, Interpolation::Linear).unwrap();
    let start = LineState {
        level_m: 170.0,
        flow_m3_s: 0.045,
    };
    let (u, w) = (signal(&inflow), signal(&speed));
    let options = SimulationOptions::default();
    let run = simulate_coupled(&line, start, &u, &w, &time, &options).unwrap();
    let (level, flow) = (&run.level_m, &run.flow_m3_s);
    let pressures = derive_outputs(&line, level, flow, &speed, true).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut noisy = |values: &[f64], sigma: f64| -> Vec<f64> {
        values
            .iter()
            .map(|v| v + sigma * rig::normal(&mut random))
            .collect()
    };
    let recording = Recording {
        mud_pump_flow_m3_s: noisy(&inflow, 1e-5),
        booster_flow_m3_s: vec![0.0; 9000],
        topfill_flow_m3_s: vec![0.0; 9000],
        return_flow_m3_s: noisy(&measured_flow(&time, flow, 9.0).unwrap(), 2e-5),
        pump_inlet_pressure_pa: vec![noisy(&pressures.inlet_pa, 1e3)],
        pump_outlet_pressure_pa: vec![noisy(&pressures.outlet_pa, 1e3)],
        riser_pressure_pa: None,
        pump_speed_pct: noisy(&speed, 1e-3),
        time_s: time.clone(),
    };
    let found = fit(recording, 1.0, &IdentifyOptions::default());
    let lag_s = line.density_kg_m3 * line.outlet_depth_m
        / line.line_area_m2
        / line.friction.slope_pa_s_m3(0.045);
    assert!((1.0..2.0).contains(&lag_s), "{lag_s}");
    assert!(
        (10.0..=11.0).contains(&found.model.delay_s),
        "{}",
        found.model.delay_s
    );
}
