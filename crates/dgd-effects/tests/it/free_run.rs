//! The two-state model with effects.

use crate::{AIR_PA, G, RHO, close, model, moments, setting, usual};
use dgd_effects::{AugmentedModel, FreeRun, Inputs, Moment, Setting, UnknownEffect, catalogue};

/// Inputs on an even clock: mud pump and speed as functions of time, booster and topfill shut.
#[derive(Clone)]
struct Drive {
    step_s: f64,
    time: Vec<f64>,
    mud: Vec<f64>,
    none: Vec<f64>,
    speed: Vec<f64>,
}

impl Drive {
    fn new(n: usize, step_s: f64, mud: impl Fn(f64) -> f64, speed: impl Fn(f64) -> f64) -> Self {
        let time: Vec<f64> = (0..n).map(|i| i as f64 * step_s).collect();
        Self {
            step_s,
            mud: time.iter().map(|t| mud(*t)).collect(),
            speed: time.iter().map(|t| speed(*t)).collect(),
            none: vec![0.0; n],
            time,
        }
    }

    fn inputs(&self) -> Inputs<'_> {
        Inputs {
            time_s: &self.time,
            step_s: self.step_s,
            mud_pump_m3_s: &self.mud,
            booster_m3_s: &self.none,
            topfill_m3_s: &self.none,
            speed_pct: &self.speed,
        }
    }

    fn run(&self, model: &AugmentedModel, start: (f64, f64)) -> FreeRun {
        model
            .free_run(&setting(), self.inputs(), 0..self.time.len(), start)
            .unwrap()
    }
}

const Q: f64 = 0.04;
const W: f64 = 80.0;

fn column_pa() -> f64 {
    AIR_PA + RHO * G * setting().line_length_m
}

/// Inlet pressure at which flow `Q` at speed `W` is steady.
fn balanced() -> (f64, f64) {
    let model = model(&[]);
    (
        column_pa() + model.curves.friction_pa(Q) - model.head_pa(W, Q),
        Q,
    )
}

fn steady(n: usize) -> Drive {
    Drive::new(n, 1.0, |_| Q, |_| W)
}

#[test]
fn a_balanced_state_stays() {
    let start = balanced();
    let run = steady(2000).run(&model(&[]), start);
    for i in [0, 1, 500, 1999] {
        close(run.return_flow_m3_s[i], Q, 1e-6);
        close(run.inlet_pa[i], start.0, 1e-7);
        close(
            run.outlet_pa[i],
            column_pa() + model(&[]).curves.friction_pa(Q),
            1e-6,
        );
    }
}

#[test]
fn a_disturbed_level_returns_to_the_balance() {
    let start = balanced();
    let run = steady(20_000).run(&model(&[]), (start.0 + 1e5, Q));
    close(run.inlet_pa[19_999], start.0, 1e-5);
    close(run.return_flow_m3_s[19_999], Q, 1e-4);
}

#[test]
fn a_step_of_the_only_outlet_transmitter_is_read_whole_and_of_one_of_two_by_half() {
    let drive = Drive::new(60, 1.0, |_| Q, |_| W);
    let read = |outlets: usize, effects: &[(&str, &[f64])]| {
        let setting = Setting {
            outlets,
            ..setting()
        };
        let run = model(effects).free_run(&setting, drive.inputs(), 0..60, balanced());
        run.unwrap().outlet_pa[59]
    };
    for (outlets, share) in [(1, 1.0), (2, 0.5)] {
        let step = [("outlet_pressure_bias_step", &[4e4, 0.0, 1.0][..])];
        close(read(outlets, &step) - read(outlets, &[]), share * 4e4, 1e-6);
    }
}

#[test]
fn a_late_pump_coasts_when_its_set_point_stops() {
    const TAU_S: f64 = 12.0;
    let mud = |t: f64| if t < 600.0 { Q } else { 0.0 };
    let set = Drive::new(900, 1.0, mud, |t| if t < 600.0 { W } else { 0.0 });
    // What the lag makes of a set-point that falls evenly to 0 in the step to 600 s.
    let falls = |t: f64| W * (1.0 - (t - 599.0) + TAU_S * (1.0 - (-(t - 599.0) / TAU_S).exp()));
    let coasting = |t: f64| match t {
        t if t < 599.0 => W,
        t if t < 600.0 => falls(t),
        t => falls(600.0) * (-(t - 600.0) / TAU_S).exp(),
    };
    let felt = Drive::new(900, 1.0, mud, coasting);
    let (late, expected) = (
        set.run(&model(&[("pump_speed_lag", &[TAU_S])]), balanced()),
        felt.run(&model(&[]), balanced()),
    );
    let stiff = set.run(&model(&[]), balanced());
    for i in 0..900 {
        close(late.return_flow_m3_s[i], expected.return_flow_m3_s[i], 1e-9);
        close(late.inlet_pa[i], expected.inlet_pa[i], 1e-9);
        close(late.outlet_pa[i], expected.outlet_pa[i], 1e-9);
    }
    assert!(stiff.inlet_pa[899] > late.inlet_pa[899] + 5e3);
}

#[test]
fn the_riser_keeps_what_flows_in_and_not_out() {
    let start = balanced();
    let drive = Drive::new(
        1200,
        1.0,
        |t| if t < 300.0 { Q } else { 0.02 },
        |t| if t < 600.0 { W } else { 84.0 },
    );
    let run = drive.run(&model(&[]), start);
    let mut volume = 0.0;
    for i in 1..1200 {
        volume += drive.mud[i] - 0.5 * (run.return_flow_m3_s[i] + run.return_flow_m3_s[i - 1]);
    }
    let gained = (run.inlet_pa[1199] - start.0) * setting().riser_area_m2 / (RHO * G);
    close(gained, volume, 1e-6);
}

#[test]
fn with_the_pump_at_rest_the_riser_fills_in_proportion() {
    let drive = Drive::new(101, 1.0, |_| 0.02, |_| 0.0);
    let rise = |m: &AugmentedModel| drive.run(m, (150e5, 0.0)).inlet_pa[100] - 150e5;
    let plain = rise(&model(&[]));
    close(
        plain,
        RHO * G / setting().riser_area_m2 * 0.02 * 100.0,
        1e-9,
    );
    close(rise(&model(&[("annulus_area", &[0.5])])), plain / 1.5, 1e-9);
}

#[test]
fn momentum_converges_with_first_order() {
    let start = (balanced().0, 0.5 * Q);
    let at = |step_s: f64, n: usize| {
        let drive = Drive::new(n + 1, step_s, |_| Q, |_| W);
        drive.run(&model(&[]), start).return_flow_m3_s[n]
    };
    let fine = at(1.0 / 256.0, 1024);
    let (a, b) = ((at(0.25, 16) - fine).abs(), (at(0.125, 32) - fine).abs());
    assert!((1.8..2.25).contains(&(a / b)), "errors {a:e} and {b:e}");
}

#[test]
fn a_coarse_clock_is_divided_into_steps_of_a_second() {
    let start = (balanced().0, 0.5 * Q);
    let fine = Drive::new(21, 1.0, |_| Q, |_| W).run(&model(&[]), start);
    let coarse = Drive::new(5, 5.0, |_| Q, |_| W).run(&model(&[]), start);
    for i in 1..5 {
        close(
            coarse.return_flow_m3_s[i],
            fine.return_flow_m3_s[5 * i],
            1e-9,
        );
    }
}

#[test]
fn a_delay_shifts_the_meter_by_its_seconds() {
    let drive = Drive::new(400, 1.0, |_| Q, |t| if t < 100.0 { W } else { 90.0 });
    let plain = drive.run(&model(&[]), balanced());
    let late = drive.run(&model(&[("return_flow_delay", &[7.0])]), balanced());
    for i in 7..400 {
        close(
            late.return_flow_m3_s[i],
            plain.return_flow_m3_s[i - 7],
            1e-12,
        );
    }
    assert_eq!(
        (&late.inlet_pa, &late.outlet_pa),
        (&plain.inlet_pa, &plain.outlet_pa)
    );
    // Half a sample lies between its neighbours.
    let half = drive.run(&model(&[("return_flow_delay", &[2.5])]), balanced());
    let between = 0.5 * (plain.return_flow_m3_s[107] + plain.return_flow_m3_s[108]);
    close(half.return_flow_m3_s[110], between, 1e-12);
}

#[test]
fn a_meter_cannot_show_what_is_to_come() {
    let drive = Drive::new(200, 1.0, |_| Q, |t| if t < 100.0 { W } else { 90.0 });
    let plain = drive.run(&model(&[]), balanced());
    assert_eq!(
        drive.run(&model(&[("return_flow_delay", &[-5.0])]), balanced()),
        plain
    );
}

#[test]
fn gas_in_the_line_rounds_the_meter_and_keeps_the_volume() {
    let drive = Drive::new(900, 1.0, |_| Q, |t| if t < 100.0 { W } else { 90.0 });
    let plain = drive.run(&model(&[]), balanced()).return_flow_m3_s;
    let round = drive
        .run(&model(&[("line_gas_storage", &[15.0, 0.0])]), balanced())
        .return_flow_m3_s;
    let highest = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
    assert!(highest(&round) < highest(&plain));
    // What it holds back is flow times time constant.
    let held: f64 = plain.iter().zip(&round).map(|(a, b)| a - b).sum();
    close(held, 15.0 * (plain[899] - plain[0]), 0.05);
}

#[test]
fn a_run_starts_from_the_flow_that_a_leak_and_a_gain_make_of_the_reading() {
    let over = column_pa() + model(&[]).friction_pa(Q) - AIR_PA;
    // A leak loses by all the pressure over the air.
    let leak = 0.002 * (over / 1e6).sqrt();
    for (effect, parameters, flow) in [
        ("line_leak", &[0.002, 0.0][..], Q + leak),
        ("return_flow_gain", &[0.25][..], Q / 1.25),
    ] {
        let run = steady(1).run(&model(&[(effect, parameters)]), balanced());
        close(run.return_flow_m3_s[0], Q, 1e-12);
        let outlet_pa = column_pa() + model(&[]).friction_pa(flow);
        close(run.outlet_pa[0], outlet_pa, 1e-6);
    }
}

#[test]
fn a_leak_lowers_the_meter_and_not_the_pump() {
    let drive = steady(300);
    let plain = drive.run(&model(&[]), balanced());
    let leaky = drive.run(&model(&[("line_leak", &[0.002, 100.0])]), balanced());
    assert_eq!(leaky.inlet_pa, plain.inlet_pa);
    assert_eq!(leaky.return_flow_m3_s[99], plain.return_flow_m3_s[99]);
    let expected = 0.002 * ((plain.outlet_pa[200] - AIR_PA) / 1e6).sqrt();
    close(
        plain.return_flow_m3_s[200] - leaky.return_flow_m3_s[200],
        expected,
        1e-6,
    );
}

#[test]
fn a_draining_line_loses_its_column_to_the_riser() {
    let s = setting();
    let drive = Drive::new(101, 1.0, |_| 0.0, |_| 0.0);
    let run = drive.run(&model(&[("line_drainage", &[0.1, 0.0, 0.0])]), (150e5, 0.0));
    // The first sample drains as well, its inflow lies before the start.
    close(column_pa() - run.outlet_pa[100], RHO * G * 10.1, 1e-6);
    close(
        run.inlet_pa[100] - 150e5,
        RHO * G / s.riser_area_m2 * s.line_area_m2 * 10.0,
        1e-6,
    );
}

#[test]
fn a_drained_line_fills_before_any_mud_returns() {
    let s = setting();
    let drive = Drive::new(600, 1.0, |_| 0.0, |t| if t < 200.0 { 0.0 } else { W });
    let run = drive.run(&model(&[("line_drainage", &[0.1, 0.0, 0.0])]), (164e5, 0.0));
    let back = run.return_flow_m3_s.iter().position(|q| *q > 0.0).unwrap();
    assert!(back > 205, "{back}");
    // The riser gives what fills the line: 20 m, but for the second in which it becomes full.
    let filled = (run.inlet_pa[199] - run.inlet_pa[back - 1]) * s.riser_area_m2 / (RHO * G);
    let passing = run.return_flow_m3_s[back];
    assert!(
        filled <= 20.0 * s.line_area_m2 + 1e-3 && filled >= 20.0 * s.line_area_m2 - 2.0 * passing,
        "{filled}, of {}",
        20.0 * s.line_area_m2
    );
    // Until then the pump has less to lift, and passes more than it can once it is full.
    let plain = drive.run(&model(&[]), (164e5, 0.0));
    let lost = |run: &FreeRun| run.inlet_pa[199] - run.inlet_pa[back - 1];
    assert!(lost(&run) > lost(&plain));
}

#[test]
fn what_fell_before_a_window_was_refilled_while_the_pump_turned() {
    let drive = Drive::new(
        4000,
        1.0,
        |_| Q,
        |t| {
            if (1000.0..1300.0).contains(&t) || t >= 3900.0 {
                0.0
            } else {
                W
            }
        },
    );
    let run = model(&[("line_drainage", &[0.1, 0.0, 0.0])])
        .free_run(&setting(), drive.inputs(), 3950..4000, (164e5, 0.0))
        .unwrap();
    // The second rest's fall alone, though the window starts at rest.
    close(column_pa() - run.outlet_pa[0], RHO * G * 5.1, 1e-6);
}

#[test]
fn a_window_that_starts_with_flow_starts_with_a_full_line() {
    // Nothing flows into the riser, which the pump empties: of what filled the line again nothing is known.
    let drive = Drive::new(
        4000,
        1.0,
        |_| 0.0,
        |t| {
            if (1000.0..1300.0).contains(&t) {
                0.0
            } else {
                W
            }
        },
    );
    let model = model(&[("line_drainage", &[0.1, 0.0, 0.0])]);
    let run = |flow: f64| {
        let start = (164e5, flow);
        model
            .free_run(&setting(), drive.inputs(), 1400..1500, start)
            .unwrap()
    };
    assert!(run(Q).return_flow_m3_s.iter().all(|q| *q > 0.0));
    // Where it starts without, it is filled first.
    let filling = run(0.0).return_flow_m3_s;
    assert!(filling[..3].iter().all(|q| *q == 0.0) && filling[99] > 0.0);
}

#[test]
fn a_heavier_line_weighs_on_the_outlet_at_rest() {
    let drive = Drive::new(8000, 1.0, |_| Q, |t| if t < 7990.0 { W } else { 0.0 });
    let run = drive.run(
        &model(&[("mud_density_change", &[30.0, 0.0, 0.1, 0.1])]),
        balanced(),
    );
    close(
        run.outlet_pa[7999] - column_pa(),
        30.0 * G * setting().line_length_m,
        0.01,
    );
}

#[test]
fn effects_with_an_onset_before_the_window_are_in_force_in_it() {
    let drive = steady(3000);
    let model = model(&[("mud_density_change", &[30.0, 0.0, 0.1, 0.1])]);
    let run = model
        .free_run(&setting(), drive.inputs(), 2900..3000, balanced())
        .unwrap();
    assert_eq!(run.outlet_pa.len(), 100);
    assert!(run.outlet_pa[0] - column_pa() > 0.9 * 30.0 * G * setting().line_length_m);
}

/// A window later than the first remembers what ran before it, not what its start alone tells.
#[test]
fn effects_live_on_from_window_to_window() {
    // Pumped fast, then slowly: by its start alone, the second window would take the first for as slow.
    let fast = |t: f64| if t < 1500.0 { 1.0 } else { 0.6 };
    let drive = Drive::new(3000, 1.0, |t| Q * fast(t), |t| W * fast(t).sqrt());
    let model = model(&[("mud_density_change", &[30.0, 1.0, 1.0, 0.3])]);
    let whole = drive.run(&model, balanced());
    let state = (whole.inlet_pa[1600], whole.return_flow_m3_s[1600]);
    let windows = [(0..1600, balanced()), (1600..3000, state)];
    let setting = setting();
    let runs = model.free_runs(&setting, drive.inputs(), &windows).unwrap();
    let [first, second] = &runs.collect::<Vec<_>>()[..] else {
        panic!("two windows");
    };
    assert_eq!(first.outlet_pa, whole.outlet_pa[..1600]);
    let alone = model.free_run(&setting, drive.inputs(), 1600..3000, state);
    let alone = alone.unwrap();
    let off = |run: &FreeRun| (run.outlet_pa[100] - whole.outlet_pa[1700]).abs();
    assert!(off(second) < 100.0, "{} Pa", off(second));
    assert!(off(&alone) > 10.0 * off(second), "{} Pa", off(&alone));
}

/// What grew over the recording that a model was identified on grows as fast over a longer one.
#[test]
fn wear_keeps_the_pace_of_the_recording_that_it_was_identified_on() {
    let drive = steady(2000);
    let worn = |span_s, start_s, end_s| {
        let model = AugmentedModel {
            span_s,
            ..model(&[("pump_wear", &[4e-3])])
        };
        let setting = Setting {
            span_s: (start_s, end_s),
            ..setting()
        };
        let run = model.free_run(&setting, drive.inputs(), 0..2000, balanced());
        run.unwrap().return_flow_m3_s
    };
    let own = worn(None, 0.0, 1000.0);
    assert_eq!(worn(Some((0.0, 1000.0)), 0.0, 2000.0), own);
    let slower = worn(None, 0.0, 2000.0);
    // Twice as fast, it has lost by half of the time what the other loses by the end.
    assert!(
        own[900] < slower[900] - 1e-4,
        "{} {}",
        own[900],
        slower[900]
    );
}

/// A model that was identified on a later, or on a shorter recording.
#[test]
fn before_it_was_identified_wear_takes_nothing_from_the_leak() {
    let drive = steady(2000);
    let run = |leak_m3_s: f64| {
        let model = AugmentedModel {
            span_s: Some((1500.0, 2500.0)),
            ..model(&[("pump_wear", &[leak_m3_s])])
        };
        drive.run(&model, balanced()).return_flow_m3_s
    };
    let (worn, sound) = (run(4e-3), run(0.0));
    assert_eq!(worn[..1500], sound[..1500]);
    assert!(worn[1999] < sound[1999] - 1e-4);
}

#[test]
fn stands_are_those_of_the_recording_that_runs_whatever_the_model_was_identified_on() {
    let drive = steady(6000);
    let run = |span_s| {
        let model = AugmentedModel {
            span_s,
            ..model(&[("cuttings_loading", &[30.0, 0.8, 0.15, 0.0, 0.0, 0.5])])
        };
        drive.run(&model, balanced())
    };
    let own = run(None);
    // The second stand lies beyond the end of the first of these, and is a small part of it by that of the second.
    for span_s in [(0.0, 2500.0), (0.0, 9e4), (-3e3, 1e3)] {
        assert_eq!(run(Some(span_s)), own, "{span_s:?}");
    }
}

#[test]
fn what_grows_is_as_strong_at_every_time_by_its_rate_over_another_length() {
    let setting = setting();
    let longer = Setting {
        span_s: (0.0, 3.0 * setting.span_s.1),
        ..setting.clone()
    };
    let mut grow = Vec::new();
    for effect in catalogue() {
        let about = effect.about();
        let p = usual(about);
        let Some(grown) = effect.grown(&p, 3.0) else {
            continue;
        };
        grow.push(about.id);
        assert_eq!(effect.grown(&p, 1.0), Some(p.clone()));
        let here = crate::drive(about.id, &p, &setting, &crate::moments());
        let there = crate::drive(about.id, &grown, &longer, &crate::moments());
        for (here, there) in here.iter().zip(&there) {
            for ((name, a, size), (_, b, _)) in
                crate::members(here).into_iter().zip(crate::members(there))
            {
                assert!((a - b).abs() < 1e-9 * size, "{} {name}: {a} {b}", about.id);
            }
        }
    }
    assert_eq!(grow, ["pump_wear", "viscosity_drift"]);
}

#[test]
fn a_formation_breaks_at_the_same_pressure_on_another_recording() {
    let there = (160e5, 168e5);
    let mut model = AugmentedModel {
        inlet_range_pa: Some(there),
        ..model(&[("lost_circulation", &[1.5e-9, 0.0, 0.25])])
    };
    let lost = |model: &AugmentedModel, inlet_range_pa| {
        let setting = Setting {
            inlet_range_pa,
            ..setting()
        };
        let p = &model.effects[0].parameters;
        let moment = Moment {
            inlet_pa: 166e5,
            ..moments()[500]
        };
        crate::drive("lost_circulation", p, &setting, &[moment])[0].inflow_m3_s
    };
    let own = lost(&model, there);
    // Above 162 bar.
    close(own, -1.5e-9 * 4e5, 1e-15);
    for here in [(140e5, 150e5), (165e5, 165.5e5), there] {
        let told = model.carry_over(&Setting {
            inlet_range_pa: here,
            ..setting()
        });
        assert_eq!(told.ongoing, ["lost_circulation"]);
        close(lost(&model, here), own, 1e-12);
    }
}

#[test]
fn what_grows_is_told_of_another_recording_by_its_rate_and_within_its_bounds() {
    let leak: &[f64] = &[2e-3, 10.0];
    let mut model = AugmentedModel {
        span_s: Some((100.0, 1100.0)),
        ..model(&[
            ("pump_wear", &[4e-3]),
            ("line_leak", leak),
            ("viscosity_drift", &[0.2, 1.0]),
        ])
    };
    let told = |model: &AugmentedModel, span_s| -> Vec<Vec<f64>> {
        let effects = model.effects_over(span_s).into_iter();
        effects.map(|one| one.parameters).collect()
    };
    let [wear, other, drift] = &told(&model, (0.0, 3000.0))[..] else {
        panic!("three effects");
    };
    close(wear[0], 1.2e-2, 1e-12);
    assert_eq!(other, leak);
    close(drift[0], 1.8, 1e-12);
    assert_eq!(told(&model, (0.0, 1e6))[0], [0.05]);
    assert_eq!(
        model.carry_over(&setting()).growing,
        ["pump_wear", "viscosity_drift"]
    );
    // Of a model that was identified on nothing no rate is known.
    model.span_s = None;
    assert_eq!(model.effects_over((0.0, 1e6)), model.effects);
}

#[test]
fn the_future_of_the_inputs_changes_nothing_before() {
    let drive = Drive::new(
        4000,
        1.0,
        |t| if t < 1800.0 { Q } else { 0.0 },
        |t| if t < 2100.0 { W } else { 0.0 },
    );
    let mut other = drive.clone();
    for i in 2500..4000 {
        other.mud[i] = 0.06;
        other.none[i] = 0.01;
        other.speed[i] = 95.0;
    }
    for effect in catalogue() {
        let about = effect.about();
        let p = usual(about);
        let model = model(&[(about.id, p.as_slice())]);
        let (a, b) = (drive.run(&model, balanced()), other.run(&model, balanced()));
        assert_eq!(
            a.return_flow_m3_s[..2500],
            b.return_flow_m3_s[..2500],
            "{}",
            about.id
        );
        assert_eq!(a.inlet_pa[..2500], b.inlet_pa[..2500], "{}", about.id);
        assert_eq!(a.outlet_pa[..2500], b.outlet_pa[..2500], "{}", about.id);
        assert_ne!(a.inlet_pa[3999], b.inlet_pa[3999], "{}", about.id);
    }
}

#[test]
fn an_unknown_effect_is_refused_with_its_name() {
    let drive = steady(10);
    let run = |id: &str, p: &[f64]| {
        model(&[(id, p)]).free_run(&setting(), drive.inputs(), 0..10, balanced())
    };
    let refused = UnknownEffect {
        id: "leprechaun".into(),
        given: 1,
    };
    assert_eq!(run("leprechaun", &[1.0]), Err(refused.clone()));
    assert_eq!(
        refused.to_string(),
        "effect `leprechaun` is not in the catalogue, or does not take 1 parameters"
    );
    assert_eq!(
        run("influx", &[1e-3]),
        Err(UnknownEffect {
            id: "influx".into(),
            given: 1
        })
    );
}

#[test]
fn a_window_beyond_the_inputs_ends_with_the_shortest_of_them() {
    let mut drive = steady(10);
    let model = model(&[]);
    let samples = |drive: &Drive, window| {
        model
            .free_run(&setting(), drive.inputs(), window, balanced())
            .unwrap()
            .inlet_pa
            .len()
    };
    assert_eq!(samples(&drive, 4..usize::MAX), 6);
    assert_eq!(samples(&drive, 20..30), 0);
    drive.none.truncate(7);
    assert_eq!(samples(&drive, 0..10), 7);
}

/// The model with other terms of friction.
fn rubbing(terms: &[(usize, f64)]) -> AugmentedModel {
    let mut model = model(&[]);
    for (k, value) in terms {
        model.curves.friction[*k] = *value;
    }
    model
}

#[test]
fn friction_that_falls_with_the_flow_speeds_no_run_up() {
    let usual = steady(2000).run(&model(&[]), balanced());
    // Identified up to 0.08 m³/s. The one falls beyond 0.096, the other from 0.053 on.
    for falling in [
        rubbing(&[(3, 9e5), (4, -3.1e5)]),
        rubbing(&[(3, 1.6e6), (4, -1e6)]),
    ] {
        let most = falling.ratio_range.1 * falling.speed_range_pct.1;
        let (inlet, flow) = balanced();
        let run = steady(2000).run(&falling, (inlet + 5e5, 1.5 * flow));
        let fastest = run.return_flow_m3_s.iter().fold(0.0_f64, |m, q| m.max(*q));
        assert!(fastest < 1.1 * most, "{fastest}");
        // What flows in flows out in the end.
        close(
            run.return_flow_m3_s[1999],
            usual.return_flow_m3_s[1999],
            0.05,
        );
    }
}

#[test]
fn friction_beyond_the_flows_goes_straight_on() {
    // A loss on the velocity head; of some ranges the greatest flow is no whole number of looks.
    for (ratio, speed) in [(8e-4, 72.0), (8e-4, 64.0), (7e-4, 85.0), (6e-4, 100.0)] {
        let mut model = rubbing(&[]);
        (model.ratio_range.1, model.speed_range_pct.1) = (ratio, speed);
        let most = ratio * speed;
        let c = model.curves.friction[3] / 0.05_f64.powi(2);
        for q in [1e-4, 2e-3, 0.5 * most, most] {
            close(model.friction_pa(q), model.curves.friction_pa(q), 1e-9);
        }
        // The slope of the last tenth of the flows.
        let slope = c * (2.0 * most - 0.1 * (most - 1e-3));
        let beyond = 0.7 * most;
        close(
            model.friction_pa(most + beyond),
            c * most * most + slope * beyond,
            1e-9,
        );
        let run = steady(1).run(&model, (balanced().0, most + beyond));
        close(
            run.outlet_pa[0],
            column_pa() + model.friction_pa(most + beyond),
            1e-12,
        );
    }
}

#[test]
fn friction_is_level_from_its_greatest_value_on_whatever_its_sign() {
    let falling = rubbing(&[(3, 1.6e6), (4, -1e6)]);
    let greatest = (1..800)
        .map(|k| falling.curves.friction_pa(1e-4 * f64::from(k)))
        .fold(0.0, f64::max);
    for q in [0.054, 0.07, 0.2] {
        close(falling.friction_pa(q), greatest, 1e-4);
    }
    // However it goes on from there: it falls and rises again.
    let wavy = rubbing(&[(3, 1e5), (6, 8e5)]);
    let greatest = (1..800)
        .map(|k| wavy.curves.friction_pa(1e-4 * f64::from(k)))
        .fold(0.0, f64::max);
    assert!(wavy.curves.friction_pa(0.07) < wavy.curves.friction_pa(0.08));
    for q in [0.03, 0.05, 0.08, 0.2] {
        close(wavy.friction_pa(q), greatest, 1e-3);
    }
    // An offset that holds more than the friction, as beside a transmitter that reads too little.
    let below = rubbing(&[(0, -4e6), (3, 1e5)]);
    for q in [0.01, 0.05, 0.08] {
        close(below.friction_pa(q), below.curves.friction_pa(q), 1e-9);
    }
}

#[test]
fn of_a_range_that_is_none_the_curve_is_taken_as_it_is() {
    for (ratio, speed) in [
        (f64::NAN, 100.0),
        (0.0, 100.0),
        (-1e-3, 100.0),
        (1e-5, 50.0),
    ] {
        let mut model = rubbing(&[(0, -4e6), (4, -1e6)]);
        (model.ratio_range.1, model.speed_range_pct.1) = (ratio, speed);
        for q in [1e-4, 0.01, 0.05, 0.2] {
            assert_eq!(model.friction_pa(q), model.curves.friction_pa(q));
        }
    }
}
