//! What each effect changes: where, in which direction, how much.

use crate::{AIR_PA, G, RHO, close, drive, moments, setting};
use dgd_effects::{
    Changes, Connection, Curve, MeterPath, Moment, Place, Quantity, Setting, find, shrunk,
};

fn at(t_s: f64) -> Moment {
    moments().into_iter().find(|m| m.t_s >= t_s).unwrap()
}

fn run(id: &str, p: &[f64]) -> Vec<Changes> {
    drive(id, p, &setting(), &moments())
}

fn sum(changes: &[Changes], of: impl Fn(&Changes) -> f64) -> f64 {
    changes.iter().map(of).sum()
}

#[test]
fn return_flow_delay_puts_its_seconds_before_the_meter() {
    let path = find("return_flow_delay").unwrap().meter_path(&[7.0]);
    assert_eq!(
        path,
        MeterPath {
            delay_s: 7.0,
            lag_s: 0.0
        }
    );
}

#[test]
fn line_gas_storage_puts_a_lag_before_the_meter() {
    let path = |spread: f64| {
        find("line_gas_storage")
            .unwrap()
            .meter_path(&[15.0, spread])
    };
    assert_eq!(
        path(0.0),
        MeterPath {
            delay_s: 0.0,
            lag_s: 15.0
        }
    );
    // Two alike in a row answer with the same mean time and half its square as variance, ever so many with none.
    for (spread, variance) in [(0.5, 0.5 * 15.0 * 15.0), (1.0, 0.0)] {
        let MeterPath { delay_s, lag_s } = path(spread);
        close(delay_s + lag_s, 15.0, 1e-12);
        close(lag_s * lag_s, variance, 1e-9);
    }
}

#[test]
fn return_flow_gain_multiplies_the_reading() {
    assert!(
        run("return_flow_gain", &[0.03])
            .iter()
            .all(|c| c.meter_gain == 1.03)
    );
}

#[test]
fn inflow_gain_takes_back_what_the_meter_reads_too_much() {
    for (m, c) in moments().iter().zip(run("inflow_gain", &[0.25])) {
        close(
            m.mud_pump_m3_s + c.inflow_m3_s,
            m.mud_pump_m3_s / 1.25,
            1e-12,
        );
    }
}

#[test]
fn outlet_pressure_bias_moves_both_transmitters_flowing_or_not() {
    assert!(
        run("outlet_pressure_bias", &[-2e4])
            .iter()
            .all(|c| c.outlet_bias_pa == [-2e4; 2])
    );
}

#[test]
fn outlet_pressure_bias_step_moves_one_transmitter_from_its_onset() {
    for (sensor, expected) in [(1.0, [3e4, 0.0]), (2.0, [0.0, 3e4])] {
        let c = run("outlet_pressure_bias_step", &[3e4, 1500.0, sensor]);
        assert_eq!(c[1499].outlet_bias_pa, [0.0; 2]);
        assert_eq!(c[1500].outlet_bias_pa, expected);
    }
}

#[test]
fn mud_density_change_fills_the_riser_as_a_stirred_tank_then_the_line() {
    let setting = setting();
    let c = run("mud_density_change", &[40.0, 1500.0, 0.25, 0.25]);
    assert_eq!(c[1499], Changes::default());
    close(c[1500].entering_kg_m3, 40.0, 1e-9);
    // 500 samples at 0.036 m³/s and one at 0.043 m³/s into a quarter of the riser.
    let turned = (500.0 * 0.036 + 0.043) / (0.25 * setting.riser_volume_m3);
    close(c[2000].riser_kg_m3, 40.0 * (1.0 - (-turned).exp()), 1e-9);
    assert!(
        c[1501..2900]
            .iter()
            .all(|c| 0.0 < c.line_kg_m3 && c.line_kg_m3 < c.riser_kg_m3)
    );
    close(c[6000].line_kg_m3, 40.0, 0.2);
}

#[test]
fn mud_of_another_density_that_was_there_before_the_first_sample_has_mixed_in() {
    let (begins_s, _) = setting().span_s;
    for onset_s in [begins_s, begins_s - 1e4] {
        let c = run("mud_density_change", &[40.0, onset_s, 0.25, 0.25]);
        for changes in [&c[0], &c[500]] {
            close(changes.riser_kg_m3, 40.0, 1e-9);
            close(changes.line_kg_m3, 40.0, 1e-9);
        }
    }
}

#[test]
fn cuttings_loading_washes_out_before_the_connection_and_keeps_the_mass_balance() {
    let setting = setting();
    let c = run("cuttings_loading", &[30.0, 0.8, 0.15, 0.0, 1.0, 0.0]);
    assert_eq!(c[0].riser_kg_m3, 30.0);
    assert_eq!(c[2399].riser_kg_m3, 30.0);
    // From the end of drilling to that of the stand: 600 s at 0.043 m³/s.
    let turned = 600.0 * 0.043 / (0.15 * setting.riser_volume_m3);
    close(c[2999].riser_kg_m3, 30.0 * (-turned).exp(), 1e-9);
    assert!(c[2999].line_kg_m3 > c[2999].riser_kg_m3);
    // The next stand loads it again: 88 m³ by the end of drilling.
    assert!(c[5479].riser_kg_m3 > 28.0);
    assert!(c.iter().all(|c| c.entering_kg_m3 == c.riser_kg_m3));
}

#[test]
fn the_pump_inlet_feels_the_share_of_the_column_that_takes_on_the_weight() {
    let setting = setting();
    for share in [0.0, 0.4, 1.0] {
        let mud = run("mud_density_change", &[40.0, 1500.0, 0.25, share]);
        let cuttings = run("cuttings_loading", &[40.0, 1.0, 0.25, 0.0, 0.0, share]);
        for c in [mud, cuttings] {
            // As the balance has it: with the mud that flows in, with the mud that leaves, and with what the level stores of that.
            let mut mass_kg = 0.0;
            for (m, c) in moments().iter().zip(&c) {
                let inflow = m.mud_pump_m3_s + m.booster_m3_s + m.topfill_m3_s;
                let (enters, leaves) = (inflow * c.entering_kg_m3, m.flow_m3_s * c.riser_kg_m3);
                let stored = (inflow - m.flow_m3_s) * c.riser_kg_m3;
                mass_kg += m.dt_s * (enters - leaves - stored);
            }
            // A step of a second turns less than a thousandth of what is stirred.
            let stands = share * setting.riser_volume_m3 * c[c.len() - 1].riser_kg_m3;
            assert!(stands > 0.0 || share == 0.0);
            assert!(
                (mass_kg - stands).abs() <= 1e-3 * stands + 1e-9,
                "{mass_kg} {stands}"
            );
        }
    }
}

#[test]
fn cuttings_load_the_riser_but_not_the_line_while_the_subsea_pump_stands() {
    let mut moments = moments();
    for m in &mut moments[1000..2000] {
        (m.flow_m3_s, m.outflow_m3_s, m.pumping) = (0.0, 0.0, false);
    }
    let p = [30.0, 1.0, 0.3, 0.0, 0.0, 0.5];
    let setting = setting();
    let c = drive("cuttings_loading", &p, &setting, &moments);
    let turned = 1000.0 * 0.036 / (0.3 * setting.riser_volume_m3);
    let missing = |i: usize| 30.0 - c[i].riser_kg_m3;
    close(missing(1999), missing(999) * (-turned).exp(), 1e-9);
    assert_eq!(c[1999].line_kg_m3, c[999].line_kg_m3);
}

#[test]
fn yield_stress_is_there_at_slow_flow_fades_and_is_gone_at_rest() {
    let setting = setting();
    let drop = |q: f64| {
        let m = Moment {
            flow_m3_s: q,
            ..at(100.0)
        };
        drive("yield_stress", &[3e4, 1.0], &setting, &[m])[0].line_drop_pa
    };
    assert_eq!(drop(0.0), 0.0);
    close(drop(1e-3), 3e4, 0.02);
    close(drop(3.5 * setting.line_area_m2), 1.5e4, 1e-9);
    assert!(drop(0.02) > drop(0.04));
}

#[test]
fn gel_strength_grows_at_rest_and_breaks_with_the_volume_pumped() {
    let setting = setting();
    let c = run("gel_strength", &[8.0, 0.2, 100.0]);
    assert!(c[..3300].iter().all(|c| c.line_drop_pa == 0.0));
    let full = 4.0 * 8.0 * setting.line_length_m / setting.line_diameter_m;
    close(c[3300].line_drop_pa, full * (1.0 - (-2.0_f64).exp()), 1e-9);
    // 0.2 of the line, 6 m³, takes 150 s at 0.04 m³/s.
    close(
        c[3450].line_drop_pa / c[3300].line_drop_pa,
        (-1.0_f64).exp(),
        1e-9,
    );
    // A second rest makes it grow again.
    let mut again = moments();
    for m in &mut again[4000..5000] {
        m.flow_m3_s = 0.0;
    }
    let c = drive("gel_strength", &[8.0, 0.2, 100.0], &setting, &again);
    close(c[5000].line_drop_pa, full, 1e-4);
}

#[test]
fn line_drainage_lowers_the_column_at_rest_into_the_riser_and_refills_at_restart() {
    let setting = setting();
    let c = run("line_drainage", &[0.1, 0.0, 0.0]);
    close(c[3199].line_fall_m, 10.0, 1e-9);
    close(c[3199].inflow_m3_s, 0.1 * setting.line_area_m2, 1e-9);
    assert_eq!(c[3300], Changes::default());
}

#[test]
fn a_drained_line_is_full_when_the_pump_has_made_up_for_what_fell_or_mud_returns() {
    let setting = setting();
    let mut slow = moments();
    for m in &mut slow[3300..3400] {
        (m.flow_m3_s, m.outflow_m3_s) = (0.011, 0.0);
    }
    let c = drive("line_drainage", &[0.1, 0.0, 0.0], &setting, &slow);
    let fall = c[3299].line_fall_m;
    close(fall, 20.0, 1e-9);
    close(
        c[3319].line_fall_m,
        fall - 20.0 * 0.011 / setting.line_area_m2,
        1e-9,
    );
    // 20 m of it at 0.011 m³/s.
    let full = 3300.0 + (20.0 * setting.line_area_m2 / 0.011).ceil();
    let found = c[3300..].iter().position(|c| c.line_fall_m <= 0.0).unwrap();
    close(3301.0 + found as f64, full, 1e-9);
    // Where nothing is known of what fills it, it is full when mud returns.
    for m in &mut slow[3300..3310] {
        m.flow_m3_s = 0.0;
    }
    slow[3310].outflow_m3_s = 0.01;
    let c = drive("line_drainage", &[0.1, 0.0, 0.0], &setting, &slow);
    assert_eq!((c[3309].line_fall_m, c[3310].line_fall_m), (fall, 0.0));
}

/// The same course at an even riser level, and how far the line's surface is above balance with it, m.
fn even() -> (Vec<Moment>, f64) {
    let inlet_pa = 164e5;
    let mut even = moments();
    for m in &mut even {
        m.inlet_pa = inlet_pa;
    }
    let balance = setting().line_length_m - (inlet_pa - AIR_PA) / (RHO * G);
    (even, balance)
}

#[test]
fn line_drainage_ends_in_balance_with_the_riser_whatever_its_law() {
    let setting = setting();
    let (even, balance) = even();
    for parameters in [
        [20.0, 0.0, 0.0],
        [20.0, 0.5, 0.0],
        [20.0, 1.0, 0.0],
        [1.0, 0.0, 1e4],
    ] {
        let c = drive("line_drainage", &parameters, &setting, &even);
        close(c[3299].line_fall_m, balance, 1e-6);
        close(
            sum(&c, |c| c.inflow_m3_s),
            setting.line_area_m2 * c[3299].line_fall_m,
            1e-9,
        );
    }
}

#[test]
fn line_drainage_through_an_orifice_falls_with_the_square_of_the_time_left() {
    // Torricelli: the root of what is left falls evenly.
    let (even, balance) = even();
    let c = drive("line_drainage", &[0.4, 0.5, 0.0], &setting(), &even);
    let left = |i: usize| (balance - c[i].line_fall_m).sqrt();
    let (first, second) = (left(3100) - left(3200), left(3200) - left(3299));
    assert!(c[3299].line_fall_m > 0.4 * balance, "hardly drained");
    // Explicit steps of a second: the square leaves a share of rate dt over what is left, below a hundredth.
    close(second / first, 0.99, 0.01);
}

#[test]
fn line_drainage_may_lose_mud_at_once_while_the_valve_closes() {
    let (at_once, after) = (
        run("line_drainage", &[0.01, 0.0, 300.0]),
        run("line_drainage", &[0.01, 0.0, 0.0]),
    );
    close(
        at_once[3150].line_fall_m - after[3150].line_fall_m,
        3.0,
        1e-9,
    );
}

#[test]
fn pump_wear_grows_evenly_goes_with_the_root_of_the_lift_and_rests_with_the_pump() {
    let c = run("pump_wear", &[0.004]);
    for (i, m) in moments().iter().enumerate().filter(|(i, _)| i % 97 == 0) {
        let lift = (m.outlet_pa - m.inlet_pa) / 1e6;
        let expected = if m.pumping {
            0.004 * m.t_s / 6000.0 * lift.sqrt()
        } else {
            0.0
        };
        close(c[i].recirculation_m3_s, expected, 1e-12);
    }
    assert!(c[3200].recirculation_m3_s == 0.0 && c[6000].recirculation_m3_s > 0.003);
}

#[test]
fn gas_in_pump_takes_its_share_of_the_head_for_its_time() {
    let c = run("gas_in_pump", &[0.1, 1500.0, 2000.0, 200.0]);
    for (t, factor) in [
        (1499, 1.0),
        (1600, 0.95),
        (1700, 0.9),
        (3300, 0.9),
        (3450, 0.975),
        (3500, 1.0),
    ] {
        close(c[t].head_factor, factor, 1e-12);
    }
    // An event too short for its edges is a triangle.
    let short = run("gas_in_pump", &[0.1, 1500.0, 300.0, 200.0]);
    close(short[1650].head_factor, 0.9, 1e-12);
}

#[test]
fn pump_speed_lag_follows_a_step_exponentially() {
    let c = run("pump_speed_lag", &[12.0]);
    assert_eq!(c[999].speed_pct, 0.0);
    // The set-point rises by 4 % in the step to 1000 s, evenly; what is left of it is behind by a share that falls by the time constant.
    let behind = -4.0 * 12.0 * (1.0 - (-1.0_f64 / 12.0).exp());
    close(c[1000].speed_pct, behind, 1e-9);
    close(c[1024].speed_pct, behind * (-2.0_f64).exp(), 1e-9);
}

#[test]
fn influx_brings_its_volume_and_its_plateau() {
    let c = run("influx", &[0.002, 1500.0, 1000.0, 0.2]);
    assert_eq!(c[2000].inflow_m3_s, 0.002);
    close(c[1600].inflow_m3_s, 0.001, 1e-9);
    close(sum(&c, |c| c.inflow_m3_s), 0.002 * 1000.0 * 0.8, 1e-3);
}

#[test]
fn lost_circulation_goes_with_the_pressure_above_the_fracture_pressure() {
    let setting = setting();
    let (low, high) = setting.inlet_range_pa;
    let loss = |inlet_pa: f64| {
        let m = Moment {
            inlet_pa,
            ..at(2000.0)
        };
        drive("lost_circulation", &[2e-8, 1500.0, 0.5], &setting, &[m])[0].inflow_m3_s
    };
    assert_eq!(loss(0.5 * (low + high)), 0.0);
    close(loss(high), -2e-8 * 0.5 * (high - low), 1e-12);
    assert_eq!(
        run("lost_circulation", &[2e-8, 1500.0, -1.0])[1499],
        Changes::default()
    );
}

#[test]
fn u_tube_gives_after_a_stop_what_it_takes_after_a_start() {
    let c = run("u_tube", &[40.0, 1.0, 0.0]);
    // Each holds flow times time constant.
    close(sum(&c[3000..3400], |c| c.inflow_m3_s), 0.03 * 40.0, 1e-3);
    close(sum(&c[3400..], |c| c.inflow_m3_s), -0.03 * 40.0, 1e-3);
    assert!(c[..3000].iter().all(|c| c.inflow_m3_s == 0.0));
}

#[test]
fn a_string_holds_back_what_does_not_drain_and_drains_evenly_or_in_proportion() {
    let drained = |c: &[Changes]| sum(&c[3000..3400], |c| c.inflow_m3_s);
    let filled = |c: &[Changes]| -sum(&c[3400..], |c| c.inflow_m3_s);
    for evenly in [0.0, 0.5, 1.0] {
        let c = run("u_tube", &[40.0, 0.25, evenly]);
        close(filled(&c), 0.03 * 40.0, 1e-3);
        // A quarter; a tenth less of what drains half evenly, and half a second less of what drains evenly from the moment that the pump slows.
        let least = if evenly == 0.5 { 8.5 } else { 9.4 };
        let drained = drained(&c) / 0.03;
        assert!(drained > least && drained < 10.1, "{evenly}: {drained}");
    }
    // By Torricelli's law the flow falls on a straight line, and is gone.
    let c = run("u_tube", &[40.0, 1.0, 1.0]);
    close(c[3039].inflow_m3_s, 0.015, 1e-4);
    assert_eq!(c[3080].inflow_m3_s, 0.0);
    close(drained(&c), 0.03 * 39.5, 1e-3);
}

#[test]
fn booster_line_storage_takes_after_a_step_up_and_knows_only_the_booster() {
    let c = run("booster_line_storage", &[25.0]);
    close(sum(&c[2000..], |c| c.inflow_m3_s), -0.007 * 25.0, 1e-3);
    assert!(c[..2000].iter().all(|c| c.inflow_m3_s == 0.0));
    assert!(c[3000].inflow_m3_s.abs() < 1e-12);
}

#[test]
fn annulus_area_is_a_factor_on_the_area() {
    assert!(
        run("annulus_area", &[-0.2])
            .iter()
            .all(|c| c.area_factor == 0.8)
    );
}

#[test]
fn pipe_displacement_brings_its_volume_at_each_connection() {
    let c = run("pipe_displacement", &[0.3, 60.0, 120.0, 0.0]);
    close(sum(&c, |c| c.inflow_m3_s), 0.3, 1e-9);
    assert_eq!(c[3059].inflow_m3_s, 0.0);
    close(c[3060].inflow_m3_s, 0.3 / 120.0, 1e-12);
    assert_eq!(c[3180].inflow_m3_s, 0.0);
}

#[test]
fn pipe_may_be_lowered_before_the_mud_pump_starts() {
    // The connection lasts from 3000 to 3400 s.
    let c = run("pipe_displacement", &[0.3, 60.0, 120.0, 1.0]);
    close(sum(&c, |c| c.inflow_m3_s), 0.3, 1e-9);
    assert_eq!(c[3219].inflow_m3_s, 0.0);
    close(c[3220].inflow_m3_s, 0.3 / 120.0, 1e-12);
    assert_eq!(c[3340].inflow_m3_s, 0.0);
}

#[test]
fn moves_of_pipe_that_overlap_bring_each_its_volume() {
    // Four stands, two minutes apart, each on its way for five.
    let connections = [1000.0, 1120.0, 1240.0, 1360.0].map(|from_s| Connection {
        from_s,
        to_s: from_s + 60.0,
    });
    let setting = Setting {
        connections: connections.to_vec(),
        ..setting()
    };
    let c = drive(
        "pipe_displacement",
        &[1.0, 0.0, 300.0, 0.0],
        &setting,
        &moments(),
    );
    close(sum(&c, |c| c.inflow_m3_s), 4.0, 1e-9);
}

#[test]
fn a_short_move_of_pipe_brings_its_volume_however_it_falls_on_the_clock() {
    for (after, lasts) in [(60.0, 12.2), (60.7, 12.2), (60.3, 1.4), (59.9, 30.0)] {
        let c = run("pipe_displacement", &[0.3, after, lasts, 0.0]);
        close(sum(&c, |c| c.inflow_m3_s), 0.3, 1e-9);
    }
}

#[test]
fn heave_leaves_the_course_of_the_pressures_alone() {
    assert!(
        run("heave", &[10.0, 1.0])
            .iter()
            .all(|c| *c == Changes::default())
    );
}

#[test]
fn viscosity_drift_raises_friction_less_than_blasius_and_more_than_a_rough_pipe() {
    let c = run("viscosity_drift", &[0.5, 0.0]);
    assert_eq!(c[0].friction_factor, 1.0);
    // Blasius: a quarter power of the viscosity.
    let end = c[6000].friction_factor;
    assert!(1.03 < end && end < 1.5_f64.powf(0.25), "{end}");
    assert!(c[1000].friction_factor < c[2000].friction_factor);
    // Bent: late or early.
    let late = run("viscosity_drift", &[0.5, 0.7])[2000].friction_factor;
    let early = run("viscosity_drift", &[0.5, -0.5])[2000].friction_factor;
    assert!(late < c[2000].friction_factor && c[2000].friction_factor < early);
    assert!(run("viscosity_drift", &[-0.5, 0.0])[6000].friction_factor < 1.0);
}

#[test]
fn viscosity_drift_in_laminar_flow_is_in_proportion() {
    let setting = setting();
    let m = Moment {
        flow_m3_s: 2.2e-3,
        ..at(6000.0)
    };
    // Re = rho q d / (A mu) is 1056 at 0.02 Pa s.
    close(
        drive("viscosity_drift", &[0.5, 0.0], &setting, &[m])[0].friction_factor,
        1.5,
        1e-9,
    );
}

#[test]
fn line_restriction_adds_its_velocity_heads_from_its_onset() {
    let setting = setting();
    let c = run("line_restriction", &[10.0, 1500.0]);
    let v = 0.04 / setting.line_area_m2;
    assert_eq!(c[1499].line_drop_pa, 0.0);
    close(c[1500].line_drop_pa, 10.0 * RHO * v * v / 2.0, 1e-12);
    assert_eq!(c[3200].line_drop_pa, 0.0);
}

#[test]
fn line_leak_goes_with_the_root_of_the_pressure_and_stops_with_the_flow() {
    let setting = setting();
    let leak = |outlet_pa: f64| {
        let m = Moment {
            outlet_pa,
            ..at(2000.0)
        };
        drive("line_leak", &[0.002, 1500.0], &setting, &[m])[0].leak_m3_s
    };
    close(leak(AIR_PA + 1e6), 0.002, 1e-12);
    close(leak(AIR_PA + 4e6), 0.004, 1e-12);
    assert_eq!(leak(AIR_PA - 1e3), 0.0);
    let c = run("line_leak", &[0.002, 1500.0]);
    assert!(c[1499].leak_m3_s == 0.0 && c[1500].leak_m3_s > 0.0 && c[3200].leak_m3_s == 0.0);
}

#[test]
fn unknown_is_piecewise_linear_in_its_relation_and_held_beyond_its_knots() {
    let setting = setting();
    let knots = [
        1.0, 2.0, 4.0, 3.0, 0.0, -1.0, -1.0, -1.0, 0.0, 0.0, 2.0, 5.0,
    ];
    for place in [Place::Friction, Place::Head, Place::Balance] {
        let curve = Curve::new(place, Quantity::Time, (1000.0, 2100.0), knots.to_vec());
        let c = drive("unknown", &curve.parameters(), &setting, &moments());
        let value = |i: usize| match place {
            Place::Friction => c[i].line_drop_pa,
            Place::Head => c[i].head_pa,
            _ => c[i].inflow_m3_s,
        };
        for (t, expected) in [
            (0, 1.0),
            (1000, 1.0),
            (1150, 3.0),
            (1200, 4.0),
            (1500, -1.0),
            (2050, 3.5),
            (5000, 5.0),
        ] {
            assert!(
                (value(t) - expected).abs() < 1e-12,
                "{place:?} at {t}: {}",
                value(t)
            );
        }
    }
}

#[test]
fn changes_below_the_noise_vanish_and_large_ones_stay() {
    assert_eq!(shrunk(0.0, 0.0), 0.0);
    assert_eq!(shrunk(0.5, 0.0), 0.5);
    close(shrunk(3.0, 1.0), 1.5, 1e-12);
    assert!(shrunk(0.3, 1.0) < 0.01 * 0.3);
    close(shrunk(-100.0, 1.0), -100.0, 1e-3);
}
