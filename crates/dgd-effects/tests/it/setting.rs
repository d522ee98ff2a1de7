//! What is read off a well and its recording.

use crate::{AIR_PA, G, close};
use dgd_effects::{Connection, Setting};
use dgd_recording::{ChannelMap, ChannelSource, Geometry, Recording, TimeSource, Well};

fn well() -> Well {
    let none = || ChannelSource::Constant { si: 0.0 };
    Well {
        mud_density_kg_m3: 1300.0,
        geometry: Geometry {
            riser_id_m: 0.5,
            drillpipe_od_m: 0.15,
            casing_od_m: None,
            return_line_id_m: 0.15,
            booster_line_id_m: None,
            pump_inlet_depth_m: 1400.0,
            pump_outlet_depth_m: 1395.0,
            riser_pressure_sensor_depth_m: None,
        },
        channels: ChannelMap {
            time: TimeSource::Interval { step_s: 1.0 },
            mud_pump_flow: none(),
            booster_flow: none(),
            topfill_flow: none(),
            return_flow: none(),
            pump_inlet_pressure: vec![none()],
            pump_outlet_pressure: vec![none()],
            riser_pressure: None,
            pump_speed: none(),
        },
    }
}

/// Mud pump off for 30 s, for 90 s and at the end; every fifth value missing or not, as told.
fn recording(n: usize, holes: bool) -> (Recording, Vec<f64>) {
    let hole = |i: usize, v: f64| {
        if holes && i.is_multiple_of(5) {
            f64::NAN
        } else {
            v
        }
    };
    let off = |i: usize| (500..530).contains(&i) || (1000..1090).contains(&i) || i >= n - 100;
    // Noise of a known size.
    let noise = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let series = |f: &dyn Fn(usize) -> f64| (0..n).map(|i| hole(i, f(i))).collect::<Vec<f64>>();
    let inlet = series(&|i| AIR_PA + 1300.0 * G * 1200.0 + 1e3 * noise(i));
    let recording = Recording {
        time_s: (0..n).map(|i| i as f64).collect(),
        mud_pump_flow_m3_s: series(&|i| if off(i) { 0.0 } else { 0.03 }),
        booster_flow_m3_s: series(&|i| 0.01 + 1e-4 * noise(i)),
        topfill_flow_m3_s: vec![0.0; n],
        return_flow_m3_s: series(&|_| 0.04),
        pump_inlet_pressure_pa: vec![inlet.clone()],
        pump_outlet_pressure_pa: vec![inlet.clone()],
        riser_pressure_pa: None,
        pump_speed_pct: series(&|_| 80.0),
    };
    (recording, inlet)
}

#[test]
fn connections_of_a_minute_or_more_are_found_with_and_without_missing_values() {
    for holes in [false, true] {
        let (recording, inlet) = recording(3000, holes);
        let found = Setting::of(&well(), &recording, &inlet).connections;
        assert_eq!(found.len(), 2, "{found:?}");
        for (c, (from, to)) in found.iter().zip([(1000.0, 1090.0), (2900.0, 2999.0)]) {
            assert!(
                (c.from_s - from).abs() <= 1.0 && (c.to_s - to).abs() <= 1.0,
                "{c:?}"
            );
        }
    }
    let (recording, inlet) = recording(3000, false);
    assert_eq!(
        Setting::of(&well(), &recording, &inlet).connections[0],
        Connection {
            from_s: 1000.0,
            to_s: 1090.0
        }
    );
}

#[test]
fn volume_range_and_span_follow_from_the_recording() {
    let (recording, inlet) = recording(3000, false);
    let s = Setting::of(&well(), &recording, &inlet);
    close(s.riser_volume_m3, 1200.0 * s.riser_area_m2, 1e-3);
    assert_eq!(s.span_s, (0.0, 2999.0));
    close(s.inlet_range_pa.1 - s.inlet_range_pa.0, 2e3, 1e-9);
    assert_eq!(s.line_length_m, 1395.0);
    close(s.line_volume_m3(), 1395.0 * s.line_area_m2, 1e-12);
}

#[test]
fn noise_is_that_of_the_channel_and_none_of_a_still_one() {
    let (recording, inlet) = recording(3000, false);
    let noise = Setting::of(&well(), &recording, &inlet).noise;
    // Second differences of the pattern are all 4 in size: 4 / 0.6745 / sqrt 6.
    let expected = 1e-4 * 4.0 / 0.6745 / 6.0_f64.sqrt();
    close(noise.booster_m3_s, expected, 1e-6);
    assert_eq!(noise.speed_pct, 0.0);
    // The same where every reading is held for three samples, or is followed by two that are missing.
    for held in [true, false] {
        let mut slow = recording.clone();
        let every = |i: usize| held || i.is_multiple_of(3);
        let read = |i: usize| {
            if every(i) {
                recording.booster_flow_m3_s[i / 3]
            } else {
                f64::NAN
            }
        };
        slow.booster_flow_m3_s = (0..3000).map(read).collect();
        let noise = Setting::of(&well(), &slow, &inlet).noise;
        close(noise.booster_m3_s, expected, 1e-6);
    }
}

#[test]
fn connections_are_found_where_the_mud_pump_stands_for_most_of_a_recording() {
    let (mut recording, inlet) = recording(3000, false);
    for (i, q) in recording.mud_pump_flow_m3_s.iter_mut().enumerate() {
        *q = if i % 1000 < 100 { 0.03 } else { 0.0 };
    }
    let found = Setting::of(&well(), &recording, &inlet).connections;
    let from: Vec<f64> = found.iter().map(|c| c.from_s).collect();
    assert_eq!(from, [100.0, 1100.0, 2100.0]);
    recording.mud_pump_flow_m3_s.fill(0.0);
    assert!(
        Setting::of(&well(), &recording, &inlet)
            .connections
            .is_empty()
    );
}

#[test]
fn an_empty_or_missing_recording_gives_a_finite_setting() {
    for n in [100, 101] {
        let (mut recording, mut inlet) = recording(n, false);
        for v in recording.mud_pump_flow_m3_s.iter_mut().chain(&mut inlet) {
            *v = f64::NAN;
        }
        let s = Setting::of(&well(), &recording, &inlet);
        assert!(s.riser_volume_m3.is_finite() && s.connections.is_empty());
    }
    let (mut recording, _) = recording(100, false);
    recording.time_s.clear();
    let s = Setting::of(&well(), &recording, &[]);
    assert_eq!(s.span_s, (0.0, 0.0));
}
