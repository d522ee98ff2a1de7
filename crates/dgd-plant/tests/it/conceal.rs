//! What a concealed effect does to the plant, and that the truth says so.

use dgd_plant::{
    Case, Cause, EFFECTS, FOREIGN, Foreign, Kind, Level, Order, Plan, Recording, Severity, Spans,
    conceal, record,
};

const G: f64 = 9.80665;

pub(crate) fn order(kind: Kind, effect: Option<&'static str>) -> Order {
    Order {
        seed: 11,
        level: Level::One,
        kind,
        severity: Some(Severity::Moderate),
        effect,
        hours: None,
        viscosity: 1.0,
    }
}

/// The moderate case of an effect that is busy enough to show it, with the same plan without the effect.
fn pair(effect: &'static str) -> (Case, Recording, Recording) {
    let case = conceal(&order(Kind::Single, Some(effect)), 0);
    let clean = Plan {
        causes: Vec::new(),
        ..case.plan.clone()
    };
    let with = record(&case.plan).unwrap();
    let without = record(&clean).unwrap();
    (case, with, without)
}

pub(crate) fn param(case: &Case, name: &str) -> f64 {
    let hidden = &case.hidden[0];
    let mut all = hidden.params.iter().chain(&hidden.extra);
    all.find(|(n, _)| *n == name).unwrap().1
}

pub(crate) fn close(found: f64, expected: f64, relative: f64) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "{found}, expected {expected}"
    );
}

fn mean(x: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut n) = (0.0, 0.0);
    for v in x.filter(|v| v.is_finite()) {
        sum += v;
        n += 1.0;
    }
    sum / n
}

/// Samples at which the subsea pump has run for a while.
fn running(r: &Recording) -> impl Iterator<Item = usize> + '_ {
    (60..r.truth.len()).filter(|&i| r.truth[i - 60..=i].iter().all(|s| s.pump_flow_m3_s > 5e-3))
}

/// Head the pump gives over head its curve says, with the open valve's loss put back.
fn head_share(case: &Case, r: &Recording, i: usize) -> f64 {
    let s = &r.truth[i];
    let p = &case.plan.physics.pump;
    let area = case.plan.well.return_line_area_m2();
    let valve = 3.0 * case.plan.well.mud_density_kg_m3 / (2.0 * area * area);
    let rise = s.pump_outlet_pa - s.pump_inlet_pa + valve * s.pump_flow_m3_s.powi(2);
    let given = rise / (s.suction_density_kg_m3 * G);
    given / p.head_m(p.shaft(s.pump_speed_pct), s.pump_flow_m3_s)
}

/// Wall friction of the line from the true states, Pa, where the flow hardly changes.
fn line_loss_pa(case: &Case, r: &Recording, i: usize) -> f64 {
    let s = &r.truth[i];
    let well = &case.plan.well;
    let inertia = well.mud_density_kg_m3 * well.pump_outlet_depth_m / well.return_line_area_m2()
        * 0.5
        * (r.truth[i + 1].pump_flow_m3_s - r.truth[i - 1].pump_flow_m3_s);
    s.pump_outlet_pa - 101_325.0 - s.suction_density_kg_m3 * G * well.pump_outlet_depth_m - inertia
}

#[test]
fn every_effect_changes_the_recording_and_its_absence_does_not() {
    for effect in EFFECTS {
        let (case, with, without) = pair(effect);
        assert_eq!(case.hidden.len(), 1);
        assert_eq!(case.hidden[0].effect, effect);
        let first = (0..with.time_s.len()).find(|&i| {
            (0..10).any(|c| with.channels[c][i].to_bits() != without.channels[c][i].to_bits())
        });
        let first = first.unwrap_or_else(|| panic!("{effect} left no trace"));
        if let Some((from, _)) = case.hidden[0].interval_s {
            assert!(with.time_s[first] >= from, "{effect} shows at {first}");
        }
    }
}

#[test]
fn effects_of_no_size_leave_the_same_bytes() {
    let case = conceal(&order(Kind::Clean, None), 0);
    let clean = record(&case.plan).unwrap();
    let p = &case.plan.physics;
    let none = [
        Cause::ReturnFlowDelay { delay_s: 0.0 },
        Cause::ReturnFlowGain { gain: 1.0 },
        Cause::InflowGain { gain: 1.0 },
        Cause::OutletPressureBias { bias_pa: 0.0 },
        Cause::OutletPressureBiasStep {
            bias_pa: 0.0,
            sensor: 1,
            acts: Spans::since(100.0),
        },
        Cause::MudDensityChange {
            delta_rho_kg_m3: 0.0,
            acts: Spans::since(100.0),
        },
        Cause::CuttingsLoading {
            delta_rho_kg_m3: 0.0,
        },
        Cause::YieldStress {
            tau_pa: 0.0,
            turbulent_share: 1.0,
        },
        Cause::GelStrength {
            tau_gel_pa: 0.0,
            build_s: 300.0,
            break_m3: 3.0,
        },
        Cause::LineDrainage { rate_m_s: 0.0 },
        Cause::PumpWear {
            leak_growth_m3_s2: 0.0,
        },
        Cause::GasInPump {
            head_loss_fraction: 0.0,
            acts: Spans::once((100.0, 5000.0)),
        },
        Cause::PumpSpeedLag { tau_s: 0.0 },
        Cause::Influx {
            rate_m3_s: 0.0,
            acts: Spans::once((100.0, 5000.0)),
        },
        Cause::LostCirculation {
            j_m3_s_pa: 0.0,
            fracture_pa: 0.0,
            acts: Spans::since(0.0),
        },
        Cause::UTube {
            tau_s: p.string_lag_s,
            drains_s: p.string_lag_s,
        },
        Cause::BoosterLineStorage {
            tau_s: p.booster_lag_s,
        },
        Cause::AnnulusArea {
            area_m2: case.plan.well.annulus_area_m2(),
        },
        Cause::PipeDisplacement {
            volume_m3: 0.0,
            before_start: false,
        },
        Cause::Heave {
            period_s: 10.0,
            amplitude_m: 0.0,
        },
        Cause::ViscosityDrift {
            relative_mu_change: 0.0,
            length_s: 1e4,
        },
        Cause::LineRestriction {
            k: 0.0,
            acts: Spans::since(0.0),
        },
        Cause::LineLeak {
            c: 0.0,
            acts: Spans::since(0.0),
        },
        Cause::LineGasStorage {
            cushions_s: [0.0; 2],
        },
    ];
    assert_eq!(none.len(), EFFECTS.len());
    for cause in none {
        let plan = Plan {
            causes: vec![cause.clone()],
            ..case.plan.clone()
        };
        let quiet = record(&plan).unwrap();
        assert!(quiet.truth == clean.truth, "{cause:?}");
        for (a, b) in quiet.channels.iter().zip(&clean.channels) {
            assert!(
                a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits()),
                "{cause:?}"
            );
        }
    }
}

#[test]
fn mud_is_neither_made_nor_lost_whatever_is_concealed() {
    let foreign = FOREIGN.map(|f| (Kind::Foreign, f));
    let cases = EFFECTS.map(|e| (Kind::Single, e));
    for (kind, effect) in cases.into_iter().chain(foreign) {
        let case = conceal(&order(kind, Some(effect)), 0);
        let r = record(&case.plan).unwrap();
        let area = match case.plan.causes[0] {
            Cause::AnnulusArea { area_m2 } => area_m2,
            _ => case.plan.well.annulus_area_m2(),
        };
        let first = r.truth[0];
        for s in &r.truth {
            let riser = (first.riser_level_m - s.riser_level_m) * area;
            let line = s.line_volume_m3 - first.line_volume_m3;
            let passed = (s.came_in_m3 - first.came_in_m3) - (s.went_out_m3 - first.went_out_m3);
            assert!(
                (riser + line - passed).abs() < 1e-6,
                "{effect}: {riser} {line} {passed}"
            );
        }
    }
}

#[test]
fn meters_read_the_gain_the_truth_states() {
    for (effect, channel) in [("return_flow_gain", 3), ("inflow_gain", 0)] {
        let (case, with, without) = pair(effect);
        let ratio = mean(
            running(&without)
                .filter(|&i| without.channels[channel][i] > 200.0)
                .map(|i| with.channels[channel][i] / without.channels[channel][i])
                // Spikes and zeros are not the meter.
                .filter(|r| (r - 1.0).abs() < 0.2),
        );
        close(ratio - 1.0, param(&case, "gain") - 1.0, 0.02);
        assert!(with.truth == without.truth);
    }
}

#[test]
fn outlet_transmitters_are_off_by_the_bias_the_truth_states() {
    const PSI: f64 = 6_894.757_29;
    let shift = |with: &Recording, without: &Recording, c: usize, from: usize, to: usize| {
        let pairs = with.channels[c][from..to]
            .iter()
            .zip(&without.channels[c][from..to]);
        PSI * mean(pairs.map(|(a, b)| a - b).filter(|d| d.abs() < 40.0))
    };
    let (case, with, without) = pair("outlet_pressure_bias");
    let n = with.time_s.len();
    for c in [6, 7] {
        close(
            shift(&with, &without, c, 0, n),
            param(&case, "bias_pa"),
            0.02,
        );
    }
    let (case, with, without) = pair("outlet_pressure_bias_step");
    let sensor = if param(&case, "sensor") < 1.5 { 6 } else { 7 };
    let onset = without
        .time_s
        .iter()
        .position(|&t| t >= case.hidden[0].interval_s.unwrap().0)
        .unwrap();
    close(
        shift(&with, &without, sensor, onset, n),
        param(&case, "bias_pa"),
        0.03,
    );
    assert_eq!(shift(&with, &without, 13 - sensor, 0, n), 0.0);
    assert_eq!(shift(&with, &without, sensor, 0, onset), 0.0);
}

#[test]
fn return_flow_is_metered_late_by_the_stated_delay() {
    let (case, with, _) = pair("return_flow_delay");
    let delay = param(&case, "delay_s");
    let error =
        |d: usize| {
            mean(running(&with).filter(|&i| i >= 60 + d).map(|i| {
                (with.truth[i].metered_flow_m3_s - with.truth[i - d].line_outflow_m3_s).abs()
            }))
        };
    let best = (0..40).min_by(|&a, &b| error(a).total_cmp(&error(b)));
    assert_eq!(best.map(|d| d as f64), Some(delay));
}

#[test]
fn new_mud_fills_riser_and_line_within_half_an_hour_of_pumping() {
    let (case, with, _) = pair("mud_density_change");
    let delta = param(&case, "delta_rho_kg_m3");
    let base = case.plan.well.mud_density_kg_m3;
    let (from, _) = case.hidden[0].interval_s.unwrap();
    for (t, s) in with.time_s.iter().zip(&with.truth) {
        if *t < from {
            assert_eq!(s.line_top_density_kg_m3, base);
        }
    }
    let last = with.truth.last().unwrap();
    close(last.suction_density_kg_m3 - base, delta, 0.02);
    close(last.line_top_density_kg_m3 - base, delta, 0.02);
}

#[test]
fn cuttings_come_with_drilling_and_go_with_the_volume_pumped() {
    let (case, with, _) = pair("cuttings_loading");
    let base = case.plan.well.mud_density_kg_m3;
    let excess: Vec<f64> = with
        .truth
        .iter()
        .map(|s| s.line_top_density_kg_m3 - base)
        .collect();
    let most = excess.iter().copied().fold(0.0, f64::max);
    let least = excess[1800..].iter().copied().fold(f64::INFINITY, f64::min);
    close(most, param(&case, "delta_rho_kg_m3"), 0.05);
    assert!(least < 0.6 * most, "{least} of {most}");
}

#[test]
fn half_the_usual_flow_of_mud_that_is_six_times_as_viscous_is_laminar_in_nearly_half_of_the_wells()
{
    let case = |viscosity: f64, index: usize| {
        let order = Order {
            viscosity,
            ..order(Kind::Clean, None)
        };
        conceal(&order, index)
    };
    // Whether friction about half of the usual 2.5 m/s goes with the power of the flow that it goes with in laminar flow.
    let is_laminar = |case: &Case| {
        let (well, physics) = (&case.plan.well, &case.plan.physics);
        let at = |velocity_m_s: f64| {
            physics.rheology.friction_gradient_pa_m(
                velocity_m_s,
                well.return_line_id_m,
                physics.line.roughness_m,
                well.mud_density_kg_m3,
            )
        };
        let power = (at(1.3) / at(1.2)).ln() / (1.3_f64 / 1.2).ln();
        (power - physics.rheology.index).abs() < 0.1
    };
    let laminar = |viscosity| (0..30).filter(|i| is_laminar(&case(viscosity, *i))).count();
    assert_eq!(laminar(1.0), 0);
    assert!((10..=15).contains(&laminar(6.0)), "{}", laminar(6.0));
    // The pump is sized for it; nothing else differs.
    let (usual, mut viscous) = (case(1.0, 0).plan, case(6.0, 0).plan);
    assert!(viscous.physics.pump.tip_speed_m_s > usual.physics.pump.tip_speed_m_s);
    viscous.physics.rheology.consistency_pa_sn = usual.physics.rheology.consistency_pa_sn;
    viscous.physics.pump.tip_speed_m_s = usual.physics.pump.tip_speed_m_s;
    assert_eq!(viscous, usual);
}

#[test]
fn yield_stress_costs_tens_of_kilopascals_at_low_flow_and_nothing_standing() {
    let (case, with, without) = pair("yield_stress");
    let extra = |i: usize, q: f64| {
        let same = running(&without)
            .filter(|&j| j + 1 < without.truth.len())
            .min_by(|&a, &b| {
                let d = |j: usize| (without.truth[j].pump_flow_m3_s - q).abs();
                d(a).total_cmp(&d(b))
            });
        line_loss_pa(&case, &with, i) - line_loss_pa(&case, &without, same.unwrap())
    };
    let slow = running(&with)
        .filter(|&i| i + 1 < with.truth.len())
        .min_by(|&a, &b| {
            with.truth[a]
                .pump_flow_m3_s
                .total_cmp(&with.truth[b].pump_flow_m3_s)
        })
        .unwrap();
    let found = extra(slow, with.truth[slow].pump_flow_m3_s);
    assert!((2.5e4..7e4).contains(&found), "{found}");
    let standing = |r: &Recording| {
        (60..r.truth.len())
            .find(|&i| {
                r.truth[i - 60..=i]
                    .iter()
                    .all(|s| s.pump_flow_m3_s.abs() < 1e-5)
            })
            .map(|i| r.truth[i].pump_outlet_pa)
    };
    let (a, b) = (standing(&with).unwrap(), standing(&without).unwrap());
    assert!((a - b).abs() < 500.0, "{a} {b}");
}

#[test]
fn gel_resists_a_restart_with_4_tau_l_over_d_and_then_breaks() {
    let (case, with, without) = pair("gel_strength");
    let well = &case.plan.well;
    let full = 4.0 * param(&case, "tau_gel_pa") * well.pump_outlet_depth_m / well.return_line_id_m;
    // At a restart, while so little flows that the wall costs next to nothing.
    let restart = |i: &usize| {
        let q = |i: usize| with.truth[i].pump_flow_m3_s;
        (2e-3..8e-3).contains(&q(*i)) && q(*i) > q(*i - 1)
    };
    let most = (60..with.truth.len() - 1)
        .filter(restart)
        .map(|i| line_loss_pa(&case, &with, i))
        .fold(0.0, f64::max);
    assert!((0.4..1.02).contains(&(most / full)), "{most} of {full}");
    // Where the line has flowed for twenty minutes the loss is the clean plant's again.
    let late = (1300..with.truth.len() - 1).rfind(|&i| {
        with.truth[i - 1200..=i]
            .iter()
            .all(|s| s.pump_flow_m3_s > 0.02)
    });
    let i = late.unwrap();
    let difference = line_loss_pa(&case, &with, i) - line_loss_pa(&case, &without, i);
    assert!(difference.abs() < 0.05 * full, "{difference} of {full}");
}

#[test]
fn line_surface_falls_at_the_stated_rate_and_the_riser_takes_the_mud() {
    let (case, with, _) = pair("line_drainage");
    let rate = param(&case, "rate_m_s");
    let truth = &with.truth;
    let falling: Vec<usize> = (1..truth.len() - 1)
        .filter(|&i| truth[i + 1].line_filled_m < truth[i - 1].line_filled_m - 1e-3)
        .collect();
    assert!(falling.len() > 100, "{}", falling.len());
    let found = mean(
        falling
            .iter()
            .map(|&i| 0.5 * (truth[i - 1].line_filled_m - truth[i + 1].line_filled_m)),
    );
    close(found, rate, 0.03);
    assert_eq!(
        truth.last().unwrap().line_filled_m,
        case.plan.well.pump_outlet_depth_m
    );
}

#[test]
fn gas_takes_the_stated_share_of_the_head_for_the_stated_time() {
    let (case, with, _) = pair("gas_in_pump");
    let (from, to) = case.hidden[0].interval_s.unwrap();
    let loss = param(&case, "head_loss_fraction");
    let share = |a: f64, b: f64| {
        mean(
            running(&with)
                .filter(|&i| (a..b).contains(&with.time_s[i]))
                .map(|i| head_share(&case, &with, i)),
        )
    };
    let inner = 0.15 * (to - from);
    close(1.0 - share(from + inner, to - inner), loss, 0.02);
    assert!((share(0.0, from) - 1.0).abs() < 1e-3);
    assert!((share(to, 1e6) - 1.0).abs() < 1e-3);
}

#[test]
fn worn_pump_loses_two_to_three_percent_of_its_head_by_the_end() {
    let (case, with, _) = pair("pump_wear");
    let n = with.truth.len();
    let late = mean(
        running(&with)
            .filter(|&i| i > n - 3600)
            .map(|i| head_share(&case, &with, i)),
    );
    let early = mean(
        running(&with)
            .filter(|&i| i < 1200)
            .map(|i| head_share(&case, &with, i)),
    );
    assert!((0.012..0.04).contains(&(1.0 - late)), "{late}");
    assert!((1.0 - early).abs() < 0.003, "{early}");
}

#[test]
fn lags_have_the_stated_time_constant() {
    // First order: the step a lagged flow makes in a second, over the way it still had to go.
    let constant = |flow: &[f64], target: &[f64], fastest: f64| {
        let (mut moved, mut wanted) = (0.0, 0.0);
        for i in 1..flow.len() {
            let way = target[i] - flow[i - 1];
            if way.abs() > fastest {
                moved += (flow[i] - flow[i - 1]) * way;
                wanted += way * way;
            }
        }
        -1.0 / (1.0 - moved / wanted).ln()
    };
    const GPM: f64 = 6.3090e-5;
    for (effect, channel) in [("u_tube", 0), ("booster_line_storage", 1)] {
        let (case, with, _) = pair(effect);
        let flow: Vec<f64> = with
            .truth
            .iter()
            .map(|s| {
                if channel == 0 {
                    s.bit_flow_m3_s
                } else {
                    s.booster_flow_m3_s
                }
            })
            .collect();
        // A missing reading is no target; a stuck or wild one is too rare to matter.
        let mut last = 0.0;
        let target: Vec<f64> = with.channels[channel]
            .iter()
            .map(|v| {
                if v.is_finite() {
                    last = v * GPM;
                }
                last
            })
            .collect();
        close(constant(&flow, &target, 2e-3), param(&case, "tau_s"), 0.1);
    }
    let (case, with, _) = pair("line_gas_storage");
    let flow: Vec<f64> = with.truth.iter().map(|s| s.metered_flow_m3_s).collect();
    let target: Vec<f64> = with.truth.iter().map(|s| s.line_outflow_m3_s).collect();
    close(constant(&flow, &target, 2e-3), param(&case, "tau_s"), 0.1);
    let (case, with, _) = pair("pump_speed_lag");
    let flow: Vec<f64> = with.truth.iter().map(|s| s.pump_speed_pct).collect();
    close(
        constant(&flow, &with.channels[9], 2.0),
        param(&case, "tau_s"),
        0.15,
    );
}

#[test]
fn influx_brings_the_stated_plateau_within_its_time() {
    let (case, with, without) = pair("influx");
    let rate = param(&case, "rate_m3_s");
    let (from, to) = case.hidden[0].interval_s.unwrap();
    let gained = |t: f64| {
        let i = with.time_s.iter().position(|&s| s >= t).unwrap();
        with.truth[i].came_in_m3 - without.truth[i].came_in_m3
    };
    let span = to - from;
    assert_eq!(gained(from - 2.0), 0.0);
    let plateau = gained(from + 0.6 * span) - gained(from + 0.3 * span);
    close(plateau, rate * 0.3 * span, 0.01);
    let all = gained(to + 10.0);
    close(all, rate * span * (1.0 - 0.5 * (0.2 + 0.33)), 0.01);
}

#[test]
fn losses_follow_the_pressure_above_the_fracture_pressure() {
    let (case, with, _) = pair("lost_circulation");
    let (j, fracture) = (param(&case, "J_m3_s_pa"), param(&case, "p_frac_pa"));
    let (from, _) = case.hidden[0].interval_s.unwrap();
    let first = with.time_s.iter().position(|&t| t >= from).unwrap();
    let well = &case.plan.well;
    let (mut expected, mut found) = (0.0, 0.0);
    for i in first + 1..with.truth.len() {
        let (a, b) = (&with.truth[i - 1], &with.truth[i]);
        let head = well.pump_inlet_depth_m - 0.5 * (a.riser_level_m + b.riser_level_m);
        let pressure = 101_325.0 + well.mud_density_kg_m3 * G * head;
        expected += j * (pressure - fracture).max(0.0);
        // What went out less what the line gave.
        let line = b.line_volume_m3 - a.line_volume_m3;
        let riser = (a.riser_level_m - b.riser_level_m) * well.annulus_area_m2();
        let outflow = 0.5 * (a.line_outflow_m3_s + b.line_outflow_m3_s);
        found += (b.came_in_m3 - a.came_in_m3) - line - riser - outflow;
    }
    close(found, expected, 0.03);
}

#[test]
fn every_standing_of_the_mud_pump_displaces_the_stated_volume_early_or_late() {
    let case = conceal(&order(Kind::Single, Some("pipe_displacement")), 0);
    let volume_m3 = param(&case, "volume_m3");
    let moved = |before_start: bool| {
        let with = Plan {
            causes: vec![Cause::PipeDisplacement {
                volume_m3,
                before_start,
            }],
            ..case.plan.clone()
        };
        let clean = Plan {
            causes: Vec::new(),
            ..case.plan.clone()
        };
        let (with, without) = (record(&with).unwrap(), record(&clean).unwrap());
        let came_in = |i: usize| with.truth[i].came_in_m3 - without.truth[i].came_in_m3;
        let stands = |i: usize| with.truth[i].bit_flow_m3_s < 1e-5;
        let mut moves = Vec::new();
        let mut from = None;
        for i in 1..with.truth.len() {
            match (stands(i), from) {
                (true, None) => from = Some(i),
                (false, Some(first)) => {
                    // By the middle of the connection it has all come in, or nothing has.
                    let middle = came_in((first + i) / 2) - came_in(first);
                    moves.push((middle, came_in(i) - came_in(first)));
                    from = None;
                }
                _ => {}
            }
        }
        assert!(moves.len() >= 2);
        moves
    };
    for (middle, all) in moved(false) {
        close(middle, volume_m3, 1e-6);
        close(all, volume_m3, 1e-6);
    }
    for (middle, all) in moved(true) {
        assert!(middle.abs() < 1e-9, "{middle}");
        close(all, volume_m3, 1e-6);
    }
}

#[test]
fn heave_swings_the_pressures_with_the_stated_period() {
    let (case, with, without) = pair("heave");
    let d: Vec<f64> = with
        .truth
        .iter()
        .zip(&without.truth)
        .map(|(a, b)| a.pump_outlet_pa - b.pump_outlet_pa)
        .collect();
    let part = &d[1200..2400];
    let crossings = part
        .windows(2)
        .filter(|w| w[0] <= 0.0 && w[1] > 0.0)
        .count() as f64;
    close(1200.0 / crossings, param(&case, "period_s"), 0.03);
    let most = part.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(most > 300.0, "{most}");
}

#[test]
fn restriction_costs_k_velocity_heads_and_drifted_mud_changes_friction_its_way() {
    let (case, with, without) = pair("line_restriction");
    let well = &case.plan.well;
    let k = param(&case, "K");
    let end = with.truth.len() - 1;
    let i = running(&with)
        .filter(|&i| i < end && i > end - 4000)
        .max_by(|&a, &b| {
            let steady = |i: usize| {
                -(with.truth[i + 1].pump_flow_m3_s - with.truth[i - 30].pump_flow_m3_s).abs()
            };
            steady(a).total_cmp(&steady(b))
        })
        .unwrap();
    let q = with.truth[i].pump_flow_m3_s;
    let j = running(&without)
        .filter(|&j| j < end)
        .min_by(|&a, &b| {
            let off = |j: usize| {
                (without.truth[j].pump_flow_m3_s - q).abs()
                    + (without.truth[j].pump_flow_m3_s - without.truth[j - 30].pump_flow_m3_s).abs()
            };
            off(a).total_cmp(&off(b))
        })
        .unwrap();
    let extra = line_loss_pa(&case, &with, i) - line_loss_pa(&case, &without, j);
    let area = well.return_line_area_m2();
    close(
        extra,
        k * well.mud_density_kg_m3 * (q / area).powi(2) / 2.0,
        0.15,
    );

    let (case, with, without) = pair("viscosity_drift");
    let change = param(&case, "relative_mu_change");
    let end = with.truth.len() - 1;
    let ratio = |from: usize| {
        mean(
            running(&with)
                .filter(|&i| (from..from + 3000).contains(&i) && i < end)
                .map(|i| {
                    let loss = |r: &Recording| {
                        line_loss_pa(&case, r, i) / r.truth[i].pump_flow_m3_s.powf(1.8)
                    };
                    loss(&with) / loss(&without)
                })
                .filter(|r| (0.5..1.5).contains(r)),
        ) - 1.0
    };
    assert!((ratio(0)).abs() < 0.02, "{}", ratio(0));
    let late = ratio(end - 3000);
    assert!(late * change > 0.0 && late.abs() > 0.04, "{late} {change}");
}

#[test]
fn leak_takes_c_root_p_before_the_meter_and_only_while_the_line_flows() {
    let (case, with, _) = pair("line_leak");
    let c = param(&case, "C");
    let (from, _) = case.hidden[0].interval_s.unwrap();
    let leaked = |s: &dgd_plant::TrueState| s.line_outflow_m3_s - s.metered_flow_m3_s;
    let quiet: Vec<usize> = running(&with)
        .filter(|&i| {
            (with.truth[i].pump_flow_m3_s - with.truth[i - 20].pump_flow_m3_s).abs() < 2e-5
        })
        .collect();
    let late = quiet.iter().filter(|&&i| with.time_s[i] > from + 20.0);
    let ratio = mean(late.map(|&i| {
        let s = &with.truth[i];
        leaked(s) / (c * (s.pump_outlet_pa - 101_325.0).sqrt())
    }));
    close(ratio, 1.0, 0.02);
    let early = quiet.iter().filter(|&&i| with.time_s[i] < from);
    assert!(mean(early.map(|&i| leaked(&with.truth[i]))).abs() < 1e-5);
}

#[test]
fn riser_of_another_area_rises_and_falls_otherwise() {
    // The balance with the stated area closes in `mud_is_neither_made_nor_lost_whatever_is_concealed`;
    // with the well file's it does not.
    let (case, with, _) = pair("annulus_area");
    assert!((param(&case, "area_m2") / case.plan.well.annulus_area_m2() - 1.0).abs() > 0.05);
    let worst = |area: f64| {
        let first = with.truth[0];
        with.truth
            .iter()
            .map(|s| {
                let passed =
                    (s.came_in_m3 - first.came_in_m3) - (s.went_out_m3 - first.went_out_m3);
                let line = s.line_volume_m3 - first.line_volume_m3;
                ((first.riser_level_m - s.riser_level_m) * area + line - passed).abs()
            })
            .fold(0.0, f64::max)
    };
    assert!(worst(case.plan.well.annulus_area_m2()) > 0.05);
    assert!(worst(param(&case, "area_m2")) < 1e-6);
}

#[test]
fn every_foreign_effect_changes_the_recording_and_is_called_unknown() {
    for kind in FOREIGN {
        let case = conceal(&order(Kind::Foreign, Some(kind)), 0);
        assert_eq!(case.hidden[0].effect, "unknown");
        assert_eq!(case.hidden[0].kind, Some(kind));
        assert!(matches!(case.plan.causes[0], Cause::Foreign(f) if f.kind() == kind));
        let clean = Plan {
            causes: Vec::new(),
            ..case.plan.clone()
        };
        let (with, without) = (record(&case.plan).unwrap(), record(&clean).unwrap());
        // Some channel moves by more than its noise for a good part of the time.
        let moved = (0..10).any(|c| {
            let (a, b) = (&with.channels[c], &without.channels[c]);
            let limit = [6.0, 6.0, 2.0, 9.0, 0.8, 0.8, 2.0, 2.0, 0.8, 0.2][c];
            let n = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > limit);
            n.count() > a.len() / 50
        });
        assert!(moved, "{kind} hardly shows");
    }
    assert_eq!(Foreign::TopfillOffset(0.0).kind(), "topfill_offset");
}

#[test]
fn beside_a_foreign_effect_stands_one_of_the_catalogue_in_another_relation() {
    let apart = |case: &Case| {
        let [foreign, known] = &case.hidden[..] else {
            panic!("{}: {:?}", case.id, case.hidden);
        };
        assert_eq!(foreign.effect, "unknown");
        assert!(EFFECTS.contains(&known.effect));
        assert!(known.relation.iter().all(|r| !foreign.relation.contains(r)));
        assert_eq!(case.plan.causes.len(), 2);
        (foreign.kind.unwrap(), known.effect)
    };
    let drawn: Vec<_> = (0..40)
        .map(|index| apart(&conceal(&order(Kind::Beside, None), index)))
        .collect();
    for kind in FOREIGN {
        assert_eq!(drawn.iter().filter(|d| d.0 == kind).count(), 4, "{kind}");
    }
    for effect in EFFECTS {
        let chosen = conceal(&order(Kind::Beside, Some(effect)), 0);
        assert_eq!(apart(&chosen).1, effect);
    }
}
