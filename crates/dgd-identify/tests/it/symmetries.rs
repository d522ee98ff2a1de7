//! What must not matter to a model, and what must turn with the recording.

use super::rig::{Rig, fit, normal, well};
use dgd_identify::{
    Identification, IdentifyOptions, Model, Prepared, ScreenOptions, identify, prepare,
};
use dgd_recording::{ChannelMap, ChannelSource, Column, Recording, Table, TimeSource, Well};
use dgd_units::{Dimension, Unit};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Other roundings of the same numbers: 1e-16 of pressures that are ten to forty times the friction,
/// times the condition of the fits, some hundred; the rest is room.
const ROUNDING: f64 = 1e-10;

/// Holds a model against another one of the same data, `scale` times its friction.
///
/// The friction is least squares, so it may differ by rounding alone. The exponents are searched for
/// until the squares fall by no more than 1e-9 of themselves: two searches that end so differ in
/// head by some √1e-9 of the noise, and 1e-3 of it leaves them ten such steps each.
fn same_laws(found: &Model, expected: &Model, scale: f64) {
    let (a, b) = (&found.friction, &expected.friction);
    assert_eq!(a.terms.len(), b.terms.len());
    for (a, b) in a.terms.iter().zip(&b.terms) {
        let (value, truth) = (a.coefficient.value, scale * b.coefficient.value);
        let power = a.power;
        assert_eq!(power, b.power);
        let size = a.coefficient.standard_error.unwrap().max(truth.abs());
        let off = (value - truth).abs() / size;
        assert!(off < ROUNDING, "power {power}: {value} {truth}");
    }
    assert!((a.mse_pa2 / b.mse_pa2 / scale.powi(2) - 1.0).abs() < ROUNDING);
    assert_eq!(a.samples, b.samples);
    let (a, b) = (found.return_line().pump, expected.return_line().pump);
    let mut squares = 0.0;
    let rig = Rig::default();
    for i in 0..rig.samples {
        let t = f64::from(i);
        let (w, q) = (rig.speed_pct(t), rig.flow_m3_s(t));
        squares += (a.head_m(w, q) - b.head_m(w, q)).powi(2);
    }
    let apart_m = (squares / f64::from(rig.samples)).sqrt();
    let noise_m = expected.pump.mse_m2.sqrt();
    assert!(apart_m < 1e-3 * noise_m, "{apart_m} m of {noise_m} m");
    assert_eq!(found.pump.samples, expected.pump.samples);
}

/// The recording as a file in these units, with the well that describes it.
fn file_in(recording: &Recording, [time, flow, pressure]: [&str; 3]) -> (Table, Well) {
    let [time, flow, pressure] = [
        (time, Dimension::Time),
        (flow, Dimension::FlowRate),
        (pressure, Dimension::Pressure),
    ]
    .map(|(text, dimension)| Unit::parse_as(text, dimension).unwrap());
    let mut table = Table::default();
    let mut column = |tag: &str, unit: Unit, values: &[f64]| {
        table.columns.push(Column {
            tag: tag.to_owned(),
            unit: None,
            values: values.iter().map(|v| unit.from_si(*v)).collect(),
        });
        ChannelSource::column(tag, unit)
    };
    let percent = Unit::si(Dimension::Percent);
    column("time", time, &recording.time_s);
    let channels = ChannelMap {
        time: TimeSource::Column {
            tag: "time".to_owned(),
            unit: time,
        },
        mud_pump_flow: column("FT1", flow, &recording.mud_pump_flow_m3_s),
        booster_flow: column("FT2", flow, &recording.booster_flow_m3_s),
        topfill_flow: column("FT3", flow, &recording.topfill_flow_m3_s),
        return_flow: column("FT4", flow, &recording.return_flow_m3_s),
        pump_inlet_pressure: vec![
            column("PT1", pressure, &recording.pump_inlet_pressure_pa[0]),
            column("PT2", pressure, &recording.pump_inlet_pressure_pa[1]),
        ],
        pump_outlet_pressure: vec![
            column("PT3", pressure, &recording.pump_outlet_pressure_pa[0]),
            column("PT4", pressure, &recording.pump_outlet_pressure_pa[1]),
        ],
        riser_pressure: None,
        pump_speed: column("SPM", percent, &recording.pump_speed_pct),
    };
    (table, Well { channels, ..well() })
}

#[test]
fn the_units_of_the_file_do_not_matter() {
    let recording = Rig::default().recording();
    let options = IdentifyOptions::default();
    let expected = fit(recording.clone(), 1.0, &options).model;
    for units in [
        ["min", "gpm", "psia"],
        ["h", "l/min", "barg"],
        ["ms", "bbl/h", "kPa"],
    ] {
        let (table, well) = file_in(&recording, units);
        let (read, _) = Recording::from_table(table, &well).unwrap();
        let (read, step_s, issues) = read.onto_grid().unwrap();
        assert!(issues.is_empty(), "{issues:?}");
        assert!((step_s - 1.0).abs() < 1e-9, "{units:?}: {step_s} s");
        let prepared = prepare(read, step_s, &ScreenOptions::default()).unwrap();
        let found = identify(&prepared, &well, &options).unwrap();
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
        assert!((found.model.delay_s - 12.0).abs() < 1e-9, "{units:?}");
        assert_eq!(found.model.data.kept, expected.data.kept, "{units:?}");
        same_laws(&found.model, &expected, 1.0);
    }
}

/// The samples of a recording in another order.
fn in_order(prepared: &Prepared, order: &[usize]) -> Prepared {
    let one = |values: &[f64]| -> Vec<f64> { order.iter().map(|&i| values[i]).collect() };
    let recording = &prepared.recording;
    Prepared {
        recording: recording.map_channels(recording.time_s.clone(), one),
        step_s: prepared.step_s,
        keep: order.iter().map(|&i| prepared.keep[i]).collect(),
        inlet_pressure_pa: one(&prepared.inlet_pressure_pa),
        outlet_pressure_pa: one(&prepared.outlet_pressure_pa),
        tally: prepared.tally.clone(),
        stuck: prepared.stuck.clone(),
        dropouts: prepared.dropouts.clone(),
    }
}

/// A recording with gaps and a pump that stops once, screened.
fn screened(rig: &Rig) -> Prepared {
    let mut recording = rig.recording();
    recording.pump_speed_pct[2000..2100].fill(0.0);
    recording.return_flow_m3_s[5000..5040].fill(f64::NAN);
    recording.pump_outlet_pressure_pa[0][7000..7100].fill(f64::NAN);
    prepare(recording, 1.0, &ScreenOptions::default()).unwrap()
}

fn with_delays(prepared: &Prepared, delays: std::ops::RangeInclusive<i64>) -> Identification {
    let options = IdentifyOptions {
        delays,
        ..IdentifyOptions::default()
    };
    identify(prepared, &well(), &options).unwrap()
}

#[test]
fn without_a_delay_the_order_of_the_samples_does_not_matter() {
    let rig = Rig {
        delay_s: 0.0,
        ..Rig::default()
    };
    let prepared = screened(&rig);
    let expected = with_delays(&prepared, 0..=0).model;
    for seed in 1..=3 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut order: Vec<usize> = (0..prepared.keep.len()).collect();
        // Fisher and Yates.
        for i in (1..order.len()).rev() {
            order.swap(i, random.next_u32() as usize % (i + 1));
        }
        let found = with_delays(&in_order(&prepared, &order), 0..=0);
        same_laws(&found.model, &expected, 1.0);
    }
}

#[test]
fn a_recording_played_backwards_turns_the_delay_round_and_leaves_the_laws() {
    let prepared = screened(&Rig::default());
    let backwards: Vec<usize> = (0..prepared.keep.len()).rev().collect();
    let forth = with_delays(&prepared, -30..=30);
    let back = with_delays(&in_order(&prepared, &backwards), -30..=30);
    assert_eq!((forth.model.delay_s, back.model.delay_s), (12.0, -12.0));
    same_laws(&back.model, &forth.model, 1.0);
    let turned: Vec<f64> = back.sweep.mse_pa2.iter().rev().copied().collect();
    for (a, b) in turned.iter().zip(&forth.sweep.mse_pa2) {
        // The sweep's sums agree with those of QR to 1e-9 of the error (dgd-friction's tests).
        assert!((a / b - 1.0).abs() < 2e-9, "{a} {b}");
    }
}

#[test]
fn a_heavier_mud_at_the_same_heads_has_more_friction_and_the_same_pump() {
    const HEAVIER: f64 = 1.375;
    let recording = Rig::default().recording();
    let mut heavy = recording.clone();
    for side in [
        &mut heavy.pump_inlet_pressure_pa,
        &mut heavy.pump_outlet_pressure_pa,
    ] {
        for p in side.iter_mut().flatten() {
            *p = HEAVIER * (*p - 101_325.0) + 101_325.0;
        }
    }
    let mut mud = well();
    mud.mud_density_kg_m3 *= HEAVIER;
    let options = IdentifyOptions::default();
    let expected = fit(recording, 1.0, &options).model;
    let prepared = prepare(heavy, 1.0, &ScreenOptions::default()).unwrap();
    let found = identify(&prepared, &mud, &options).unwrap();
    assert_eq!(found.model.delay_s, 12.0);
    same_laws(&found.model, &expected, HEAVIER);
}

#[test]
fn an_offset_of_the_outlet_transmitters_is_all_of_it_in_b() {
    let recording = Rig::default().recording();
    let options = IdentifyOptions::default();
    let plain = fit(recording.clone(), 1.0, &options).model.friction;
    for offset_pa in [-1.5e4, 2e4] {
        let mut off = recording.clone();
        for p in off.pump_outlet_pressure_pa.iter_mut().flatten() {
            *p += offset_pa;
        }
        let found = fit(off, 1.0, &options).model;
        assert_eq!(found.delay_s, 12.0);
        let found = found.friction;
        assert!((found.coefficient(0) - plain.coefficient(0) - offset_pa).abs() < 1e-3);
        for power in [2, 3] {
            let (a, b) = (found.coefficient(power), plain.coefficient(power));
            assert!((a / b - 1.0).abs() < ROUNDING, "{a} {b}");
        }
    }
}

#[test]
fn seconds_added_to_the_clock_change_no_bit_whatever_they_are() {
    let recording = Rig {
        samples: 3000,
        ..Rig::default()
    }
    .recording();
    let found = |recording: Recording| {
        let (even, step_s, issues) = recording.onto_grid().unwrap();
        assert!(issues.is_empty(), "{issues:?}");
        fit(even, step_s, &IdentifyOptions::default())
    };
    let expected = found(recording.clone());
    // All of them leave the seconds' differences exact.
    for seconds in [-86_400.0, 0.25, 1e3, 1.7e9] {
        let later = Recording {
            time_s: recording.time_s.iter().map(|t| t + seconds).collect(),
            ..recording.clone()
        };
        let found = found(later);
        assert_eq!(found.model, expected.model, "{seconds} s");
        assert_eq!(found.warnings, expected.warnings, "{seconds} s");
    }
}

/// A law of friction and a pump drawn at random, and the recording they make.
struct Drawn {
    friction: [f64; 3],
    pump: [f64; 5],
    delay_s: f64,
    recording: Recording,
}

impl Drawn {
    fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
        let mut between = |low: f64, high: f64| {
            low + (high - low) * f64::from(random.next_u32()) / f64::from(u32::MAX)
        };
        let friction = [between(-3e4, 5e4), between(8e7, 2e8), between(-3e8, 6e8)];
        // At 55 % and 0.045 m3/s the three terms are 150 to 200, 2.5 to 12 and 5 to 25 m.
        let (n0, n2) = (between(1.8, 2.1), between(1.4, 2.4));
        let pump = [
            between(150.0, 200.0) / 55_f64.powf(n0),
            between(1.0, 5.0),
            between(5.0, 25.0) / 0.045_f64.powf(n2),
            n0,
            n2,
        ];
        let delay_s = between(0.0, 25.0).round();
        let rig = Rig {
            delay_s,
            seed,
            ..Rig::default()
        };
        let mut recording = rig.recording();
        let mut drawn = Self {
            friction,
            pump,
            delay_s,
            recording: Recording::default(),
        };
        let weight = well().weight_pa_m();
        let mut noise = ChaCha8Rng::seed_from_u64(2000 + seed);
        for i in 0..recording.len() {
            let (w, q) = (
                recording.pump_speed_pct[i],
                rig.flow_m3_s(recording.time_s[i]),
            );
            let column = weight * well().geometry.pump_outlet_depth_m + 101_325.0;
            let outlet = column + drawn.friction_pa(q);
            let inlet = outlet - weight * drawn.head_m(w, q);
            for (side, pressure) in [
                (&mut recording.pump_inlet_pressure_pa, inlet),
                (&mut recording.pump_outlet_pressure_pa, outlet),
            ] {
                for transmitter in side {
                    transmitter[i] = pressure + 1414.0 * normal(&mut noise);
                }
            }
        }
        drawn.recording = recording;
        drawn
    }

    fn friction_pa(&self, q: f64) -> f64 {
        let [b, d, e] = self.friction;
        b + d * q * q + e * q * q * q
    }

    fn head_m(&self, w: f64, q: f64) -> f64 {
        let [c0, c1, c2, n0, n2] = self.pump;
        c0 * w.powf(n0) - c1 * w * q - c2 * q.powf(n2)
    }
}

#[test]
fn any_truth_of_the_models_form_is_recovered_within_its_doubt() {
    for seed in 1..=12 {
        let truth = Drawn::new(seed);
        let rig = Rig::default();
        let found = fit(truth.recording.clone(), 1.0, &IdentifyOptions::default());
        let model = &found.model;
        assert_eq!(model.delay_s, truth.delay_s, "seed {seed}");
        assert!(model.data.kept > 8900, "seed {seed}: {:?}", model.data);
        for (term, truth) in model.friction.terms.iter().zip(truth.friction) {
            let error = term.coefficient.standard_error.unwrap();
            let off = (term.coefficient.value - truth).abs() / error;
            // Of 36 normal errors one beyond 4.5 comes once in 4,000 such tests.
            assert!(off < 4.5, "seed {seed}: power {} off {off}", term.power);
        }
        let line = model.return_line();
        let (mut friction, mut head) = (0.0, 0.0);
        for i in 0..rig.samples {
            let t = f64::from(i);
            let (w, q) = (rig.speed_pct(t), rig.flow_m3_s(t));
            friction += (line.friction.loss_pa(q) - truth.friction_pa(q)).powi(2);
            head += (line.pump.head_m(w, q) - truth.head_m(w, q)).powi(2);
        }
        // The squares missed are the noise's times χ² of as many degrees as parameters, which is
        // beyond nine times its mean once in 200,000 for three and rarer for five.
        let n = f64::from(rig.samples);
        let noise = |mse: f64, parameters: f64| 9.0 * parameters * mse / n;
        let (friction, head) = (friction / n, head / n);
        assert!(friction < noise(model.friction.mse_pa2, 3.0), "seed {seed}");
        assert!(head < noise(model.pump.mse_m2, 5.0), "seed {seed}: {head}");
        // Of two means of two transmitters; the mean square of 9000 samples is known to 1.5 %.
        let noise_m = 1414.0 / well().weight_pa_m();
        let said = model.pump.mse_m2.sqrt() / noise_m;
        assert!((said - 1.0).abs() < 0.05, "seed {seed}: {said}");
    }
}
