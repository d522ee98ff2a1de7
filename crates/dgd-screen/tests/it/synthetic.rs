//! A recording with noise and quantisation, and nothing wrong with it.

use dgd_recording::Recording;

pub(crate) const GPM: f64 = 6.3090e-5;
pub(crate) const PSI: f64 = 6894.75729;

/// Repeatable noise between -1 and 1, roughly bell-shaped.
pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1u32 << 24)
    }

    pub(crate) fn next(&mut self) -> f64 {
        (self.uniform() + self.uniform() + self.uniform()) / 1.5 - 1.0
    }
}

fn rounded(value: f64, quantum: f64) -> f64 {
    (value / quantum).round() * quantum
}

/// Speed swings slowly around 60 %; flow and pressures follow it without delay.
pub(crate) fn steady(n: usize, step_s: f64) -> Recording {
    with_speed(n, step_s, |t| {
        60.0 + 4.0 * (t / 90.0).sin() + 2.0 * (t / 37.0).sin()
    })
}

/// A mud pump of which strokes a minute are counted, and the flow of one of them, m³/s.
pub(crate) fn counted() -> (Recording, f64) {
    let mut recording = steady(6000, 1.0);
    let stroke = 4.0 * GPM;
    for (i, flow) in recording.mud_pump_flow_m3_s.iter_mut().enumerate() {
        // It dwells on the middle of a count, where noise does not show, and on the edge between two.
        let drift = (3.0 * (i as f64 / 520.0).sin()).round() / 2.0;
        let noise = *flow / GPM - 500.0;
        *flow = (125.0 + drift + 0.05 * noise).round() * stroke;
    }
    (recording, stroke)
}

/// The same samples, so many seconds apart.
pub(crate) fn every(step_s: f64, recording: Recording) -> Recording {
    Recording {
        time_s: (0..recording.len()).map(|i| i as f64 * step_s).collect(),
        ..recording
    }
}

/// The pump runs at `speed_pct`; off where that is not positive.
pub(crate) fn with_speed(n: usize, step_s: f64, speed_pct: impl Fn(f64) -> f64) -> Recording {
    let mut noise = Noise::new(7);
    let mut series = |quantum: f64, sigma: f64, truth: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (0..n)
            .map(|i| rounded(truth(i as f64 * step_s) + sigma * noise.next(), quantum))
            .collect()
    };
    let flow = |t: f64| 12.0 * speed_pct(t).max(0.0);
    let outlet = |t: f64| {
        if speed_pct(t) > 0.0 {
            550.0 + 4.0 * (speed_pct(t) - 50.0)
        } else {
            545.0
        }
    };
    let mut recording = Recording {
        time_s: (0..n).map(|i| i as f64 * step_s).collect(),
        mud_pump_flow_m3_s: series(1.0, 3.0, &|_| 500.0),
        booster_flow_m3_s: series(1.0, 2.0, &|_| 200.0),
        topfill_flow_m3_s: vec![0.0; n],
        return_flow_m3_s: series(0.5, 6.0, &flow).iter().map(|q| q.max(0.0)).collect(),
        pump_inlet_pressure_pa: vec![
            series(0.2, 0.5, &|t| 350.0 + 5.0 * (t / 400.0).sin()),
            series(0.2, 0.5, &|t| 350.6 + 5.0 * (t / 400.0).sin()),
        ],
        pump_outlet_pressure_pa: vec![series(0.2, 1.0, &outlet), series(0.2, 1.0, &outlet)],
        riser_pressure_pa: Some(series(0.2, 0.5, &|t| 353.0 + 5.0 * (t / 400.0).sin())),
        pump_speed_pct: series(0.1, 0.0, &speed_pct),
    };
    for flow in [
        &mut recording.mud_pump_flow_m3_s,
        &mut recording.booster_flow_m3_s,
        &mut recording.return_flow_m3_s,
    ] {
        flow.iter_mut().for_each(|q| *q *= GPM);
    }
    let pressures = recording
        .pump_inlet_pressure_pa
        .iter_mut()
        .chain(&mut recording.pump_outlet_pressure_pa)
        .chain(&mut recording.riser_pressure_pa);
    for series in pressures {
        series.iter_mut().for_each(|p| *p *= PSI);
    }
    // A stopped meter reads zero, not noise around it.
    for (q, w) in recording
        .return_flow_m3_s
        .iter_mut()
        .zip(&recording.pump_speed_pct)
    {
        if *w <= 0.0 {
            *q = 0.0;
        }
    }
    recording
}
