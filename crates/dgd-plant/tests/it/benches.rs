//! The two benches: physics against closed forms, cases, files.

use dgd_plant::bench::{
    Bench, Case, HELD_OUT, Hidden, Kind, Order, Programme, Record, SAMPLES, SAMPLING_S, Severity,
    Surge, draw, friction_factor, rk4, simulate, simulate_for, write_csv, write_truth,
};
use std::f64::consts::{PI, TAU};

const G: f64 = 9.80665;
const AIR_PA: f64 = 101_325.0;

fn order(bench: Bench, kind: Kind) -> Order {
    Order {
        bench,
        seed: 7,
        kind,
        severity: None,
        thing: None,
    }
}

fn clean(bench: Bench) -> Case {
    draw(&order(bench, Kind::Clean), 0)
}

fn thing(bench: Bench, name: &'static str, severity: Severity) -> Case {
    let kind = match bench.foreign().contains(&name) {
        true => Kind::Foreign,
        false => Kind::Single,
    };
    let order = Order {
        severity: Some(severity),
        thing: Some(name),
        ..order(bench, kind)
    };
    draw(&order, 0)
}

fn value(case: &Case, path: &str) -> f64 {
    case.values.iter().find(|v| v.0 == path).unwrap().1
}

/// The case with inputs that stand still.
fn steady(mut case: Case, inputs: [f64; 2]) -> Case {
    case.programmes = inputs.map(Programme::steady).into();
    case
}

fn assert_near(found: f64, expected: f64, relative: f64) {
    let off = (found - expected).abs() / expected.abs();
    assert!(
        off < relative,
        "{found}, expected {expected} within {relative}"
    );
}

#[test]
fn the_integrator_is_of_fourth_order() {
    // A quarter of an oscillation from (1, 0).
    let miss = |n: u32| {
        let step = TAU / 4.0 / f64::from(n);
        let mut y = [1.0, 0.0];
        for k in 0..n {
            y = rk4(&y, f64::from(k) * step, step, |_, y| [y[1], -y[0]]);
        }
        y[0].hypot(y[1] + 1.0)
    };
    let order = (miss(10) / miss(20)).log2();
    assert!((order - 4.0).abs() < 0.1, "{order}");
    // With time in the rates: y' = 4 t^3, which the method has exactly.
    let y = rk4(&[0.0], 1.0, 1.0, |t, _| [4.0 * t.powi(3)]);
    assert_near(y[0], 15.0, 1e-14);
}

#[test]
fn friction_is_laminar_then_obeys_colebrook_and_does_not_jump() {
    assert_near(friction_factor(800.0, 1e-3), 0.08, 1e-12);
    for (reynolds, roughness) in [(4e3, 0.0), (7e4, 2e-3), (1e6, 5e-2)] {
        let x = friction_factor(reynolds, roughness).sqrt().recip();
        let right = -2.0 * (roughness / 3.7 + 2.51 * x / reynolds).log10();
        assert_near(x, right, 1e-12);
    }
    for edge in [2000.0, 4000.0] {
        let (below, above) = (
            friction_factor(edge - 1e-6, 1e-3),
            friction_factor(edge + 1e-6, 1e-3),
        );
        assert_near(below, above, 1e-6);
    }
}

#[test]
fn a_still_surge_shaft_stands_where_bernoulli_puts_it() {
    let case = steady(clean(Bench::SurgeShaft), [136_000.0, 0.5]);
    let [level, tunnel, penstock, pressure] = last(&simulate_for(&case, 2));
    assert_near(tunnel, penstock, 1e-6);
    let q = tunnel;
    let heads = |length: f64, bore: f64, roughness: f64, minor: f64| {
        let v = q / (PI / 4.0 * bore * bore);
        let reynolds = 998.2 * v * bore / 1.002e-3;
        let factor = friction_factor(reynolds, roughness / bore);
        (factor * length / bore + minor) * v * v / (2.0 * G)
    };
    let over_air = (136_000.0 - AIR_PA) / (998.2 * G);
    let tunnel_m = heads(60.0, 0.1, value(&case, "tunnel.roughness"), 1.5);
    assert_near(level, over_air - tunnel_m, 1e-6);
    let valve_pa = (q / (value(&case, "valve.flow_coefficient") * 0.5)).powi(2);
    assert_near(pressure - AIR_PA, valve_pa, 1e-6);
    let valve_m = level + 2.0 - heads(8.0, 0.08, 5e-5, 0.5);
    assert_near(valve_pa / (998.2 * G), valve_m, 1e-5);
}

#[test]
fn the_mass_swings_with_the_period_of_the_textbook() {
    // A valve that is all but shut leaves reservoir, tunnel and shaft: T = 2 pi sqrt(L A_s / (g A_t)).
    let mut case = clean(Bench::SurgeShaft);
    let shuts = vec![(0.0, 0.4), (30.0, 0.4), (36.0, 0.05)];
    case.programmes = vec![Programme::steady(136_000.0), Programme { knots: shuts }];
    let record = simulate_for(&case, 600);
    let level = &record.quiet_si[0];
    let rest = *level.last().unwrap();
    // Upward crossings of the level of rest, by straight lines between samples.
    let mut crossings = Vec::new();
    for i in 20..150 {
        let (a, b) = (level[i] - rest, level[i + 1] - rest);
        if a < 0.0 && b >= 0.0 {
            crossings.push((i as f64 + a / (a - b)) * SAMPLING_S);
        }
    }
    let found = (crossings[3] - crossings[0]) / 3.0;
    let expected = TAU * (60.0 * 0.05 / (G * PI / 4.0 * 0.01)).sqrt();
    assert_near(found, expected, 0.03);
}

#[test]
fn a_still_loop_runs_as_its_laws_say() {
    let case = steady(clean(Bench::GlycolLoop), [1400.0, 0.6]);
    let [pressure, flow, header, _] = last(&simulate_for(&case, 2));
    assert_near(flow, value(&case, "pump.coefficient") * 1400.0, 1e-6);
    let needle = (flow / (value(&case, "needle.flow_coefficient") * 0.6)).powi(2);
    let hose = value(&case, "hose.linear") * flow;
    assert_near(pressure - AIR_PA, needle + hose + 1090.0 * G * 1.5, 1e-6);
    let drain = flow / (value(&case, "drain.discharge_coefficient") * 1.6e-4);
    assert_near(header, drain * drain / (2.0 * G), 1e-5);
}

#[test]
fn the_loop_keeps_its_fluid_whatever_is_concealed_but_steam() {
    let volume = |record: &Record, i: usize| {
        let q = &record.quiet_si;
        0.03 * q[2][i] + 0.12 * q[3][i] + 4e-9 * q[0][i]
    };
    // Gas stores fluid too, so it has a balance of its own.
    let names = [
        "pump_slip",
        "relief_cracking",
        "warming_fluid",
        "early_transition",
        "needle_stiction",
        "meter_lag",
        "travelling_rag",
        "float_switch",
    ];
    for name in names {
        let record = simulate(&thing(Bench::GlycolLoop, name, Severity::Strong));
        let gone = volume(&record, SAMPLES - 1) - volume(&record, 0);
        assert!(gone.abs() < 1e-10, "{name}: {gone}");
    }
    let case = thing(Bench::GlycolLoop, "sump_evaporation", Severity::Strong);
    let Some(Hidden::SumpEvaporation { per_hour_m }) = case.hidden() else {
        panic!("{:?}", case.hidden());
    };
    let record = simulate(&case);
    let gone = volume(&record, 0) - volume(&record, SAMPLES - 1);
    let hours = (SAMPLES - 1) as f64 * SAMPLING_S / 3600.0;
    assert_near(gone, 0.12 * per_hour_m * hours, 1e-6);
}

#[test]
fn what_the_tunnel_brings_the_penstock_takes_or_the_shaft_keeps() {
    let case = clean(Bench::SurgeShaft);
    let record = simulate(&case);
    let [level, tunnel, penstock] = [0, 1, 2].map(|i| &record.quiet_si[i]);
    // Simpson's rule over pairs of samples; the operator's ramps leave it a kink here and there.
    let net = |i: usize| tunnel[i] - penstock[i];
    let last = SAMPLES - 2;
    let mut brought = 0.0;
    let mut moved = 0.0;
    for i in (0..last).step_by(2) {
        brought += SAMPLING_S / 3.0 * (net(i) + 4.0 * net(i + 1) + net(i + 2));
        moved += 0.05 * (level[i + 2] - level[i]).abs();
    }
    let kept = 0.05 * (level[last] - level[0]);
    assert!(
        (brought - kept).abs() < 0.01 * moved,
        "{brought}, kept {kept}, moved {moved}"
    );
}

#[test]
fn crest_hole_and_chamber_have_their_textbook_sizes() {
    let bench = |hidden| Surge {
        roughness_m: 1e-4,
        flow_coefficient: 7e-5,
        hidden: Some(hidden),
    };
    let crest = bench(Hidden::CrestOverflow {
        crest_m: 3.0,
        width_m: 0.1,
    });
    // Poleni, a head of 0.1 m over 0.1 m: 2/3 0.62 sqrt(2 g) 0.1 0.1^1.5.
    assert_near(crest.lost_m3_s(3.1), 5.789e-3, 1e-3);
    assert_eq!(crest.lost_m3_s(2.9), 0.0);
    let hole = bench(Hidden::ShaftLeak { area_m2: 1e-5 });
    assert_near(hole.lost_m3_s(4.0), 1e-5 * (8.0 * G).sqrt(), 1e-12);
    let chamber = bench(Hidden::ShaftWidening {
        from_m: 2.0,
        share: 0.4,
    });
    assert_near(chamber.shaft_area_m2(1.5), 0.05, 1e-12);
    assert_near(chamber.shaft_area_m2(2.5), 0.07, 1e-12);
}

#[test]
fn all_that_is_concealed_moves_the_readings_and_more_of_it_moves_them_more() {
    for bench in Bench::ALL {
        let quiet = simulate(&clean(bench)).quiet_si;
        for name in bench.things().into_iter().chain(bench.foreign()) {
            // Greatest root mean square of the shift, in standard deviations of the noise.
            let shift = |severity| {
                let record = simulate(&thing(bench, name, severity));
                let of = |i: usize| {
                    let gauge = &bench.outputs()[i];
                    let pairs = record.quiet_si[i].iter().zip(&quiet[i]);
                    let squares: f64 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
                    (squares / SAMPLES as f64).sqrt() / (gauge.si * gauge.noise)
                };
                (0..4).map(of).fold(0.0, f64::max)
            };
            let (strong, subtle) = (shift(Severity::Strong), shift(Severity::Subtle));
            assert!(strong > 2.0, "{name}: {strong}");
            assert!(
                strong > subtle && subtle > 0.1,
                "{name}: {strong}, {subtle}"
            );
        }
    }
}

#[test]
fn readings_are_off_by_noise_and_steps_alone() {
    for bench in Bench::ALL {
        let case = clean(bench);
        let record = simulate(&case);
        for (i, gauge) in bench.outputs().iter().enumerate() {
            let expected = gauge.noise.hypot(gauge.quantum / 12.0_f64.sqrt());
            assert_near(record.floor(&case, i, 0..SAMPLES), expected, 0.1);
        }
    }
}

#[test]
fn forty_of_a_mix_hold_each_thing_in_each_severity_once() {
    for bench in Bench::ALL {
        let cases: Vec<Case> = (0..40).map(|i| draw(&order(bench, Kind::Mix), i)).collect();
        for name in bench.things() {
            for severity in Severity::ALL {
                let is = |c: &&Case| {
                    c.severity == severity && c.hidden().is_some_and(|h| h.name() == name)
                };
                assert_eq!(cases.iter().filter(is).count(), 1, "{name}");
            }
        }
        assert_eq!(cases.iter().filter(|c| c.hidden().is_none()).count(), 8);
        let foreign = |c: &&Case| c.hidden().is_some_and(|h| h.is_foreign());
        assert_eq!(cases.iter().filter(foreign).count(), 8);
    }
}

#[test]
fn cases_of_one_number_differ_in_what_is_concealed_and_in_nothing_else() {
    for bench in Bench::ALL {
        let single = draw(&order(bench, Kind::Single), 3);
        assert_eq!(
            single.with(None).programmes,
            draw(&order(bench, Kind::Clean), 3).programmes
        );
        assert_eq!(
            simulate(&single.with(None)),
            simulate(&draw(&order(bench, Kind::Clean), 3))
        );
        assert_eq!(draw(&order(bench, Kind::Single), 3), single);
        let other = Order {
            seed: 8,
            ..order(bench, Kind::Single)
        };
        assert_ne!(draw(&other, 3).programmes, single.programmes);
    }
}

#[test]
fn inputs_bend_at_samples_only_so_that_straight_lines_between_them_are_exact() {
    for bench in Bench::ALL {
        for index in 0..5 {
            for programme in draw(&order(bench, Kind::Clean), index).programmes {
                for (time_s, value) in programme.knots {
                    assert_eq!(time_s.rem_euclid(SAMPLING_S), 0.0);
                    assert_eq!(programme_at(time_s, value), value);
                }
            }
        }
    }
}

fn programme_at(time_s: f64, value: f64) -> f64 {
    let knots = vec![(time_s - 3.0, 0.0), (time_s, value), (time_s + 3.0, 1.0)];
    Programme { knots }.at(time_s)
}

#[test]
fn the_truth_says_what_was_simulated_and_the_recording_does_not() {
    let case = thing(Bench::SurgeShaft, "rack_clogging", Severity::Strong);
    let record = simulate(&case);
    let (mut csv, mut truth) = (Vec::new(), Vec::new());
    write_csv(&case, &record, &mut csv).unwrap();
    write_truth(&case, &record, &mut truth).unwrap();
    let (csv, truth) = (
        String::from_utf8(csv).unwrap(),
        String::from_utf8(truth).unwrap(),
    );
    assert_eq!(csv.lines().count(), SAMPLES + 2);
    assert!(csv.starts_with("t,P0,ZT1,LT1,FT1,FT2,PT1\ns,kPa,1,m,l/s,l/s,kPa\n0,"));
    assert!(csv.lines().nth(HELD_OUT + 2).unwrap().starts_with("1200,"));
    for part in [
        "\"thing\": \"rack_clogging\"",
        "\"severity\": \"strong\"",
        "\"kind\": \"line\"",
        "\"heads_per_hour\"",
        "\"valve.flow_coefficient\"",
        "\"floor_held_out\"",
    ] {
        assert!(truth.contains(part), "{part} in {truth}");
    }
    assert!(!csv.contains("rack") && !case.bench.system_toml().contains("rack"));
}

#[test]
fn the_descriptions_in_the_fixtures_are_those_that_the_plant_writes() {
    for bench in Bench::ALL {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/benches");
        let path = format!("{root}/{}/system.toml", bench.name());
        assert_eq!(std::fs::read_to_string(path).unwrap(), bench.system_toml());
    }
}

fn last(record: &Record) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| *record.quiet_si[i].last().unwrap())
}
