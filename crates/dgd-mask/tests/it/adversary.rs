//! Somebody looks for a transmitter's step in the masked data: 0.5 gpm or 0.1 psi as a
//! percentage is the reference.

use crate::rig::{Rig, SAMPLES};
use dgd_identify::{Prepared, Series};
use dgd_mask::mask_recording;
use dgd_units::MaskReferences;
use std::f64::consts::TAU;

/// The comb that would stand out: |mean of exp(2 pi i v/s)|, 1 if every v is a multiple of s.
fn comb(values: &[f64], step: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for value in values {
        let (sin, cos) = (TAU * value / step).sin_cos();
        re += cos;
        im += sin;
    }
    f64::hypot(re, im) / values.len() as f64
}

fn differences(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|w| w[1] - w[0]).collect()
}

/// The largest comb of values and of neighbours' differences, over steps from a third of
/// the true one to twice, the true one and its simple fractions among them.
fn strongest(values: &[f64], true_step: f64) -> f64 {
    const CANDIDATES: usize = 300;
    let grid =
        (0..=CANDIDATES).map(|i| true_step * (0.3333 + 1.6667 * i as f64 / CANDIDATES as f64));
    let exact = [1.0, 0.5, 1.0 / 3.0, 2.0, 1.5].map(|f| f * true_step);
    let neighbours = differences(values);
    grid.chain(exact)
        .map(|s| comb(values, s).max(comb(&neighbours, s)))
        .fold(0.0, f64::max)
}

/// What noise alone reaches: the mean of n random phases exceeds r with the chance
/// exp(-n r²); 1e-9 for each of the candidates. Neighbours' differences share values,
/// which doubles the variance at most.
fn noise_bound() -> f64 {
    (2.0 * 1e9f64.ln() / SAMPLES as f64).sqrt()
}

/// Each channel's name, masked values, plain percentages, and true step in percent.
type Case = (&'static str, Vec<f64>, Vec<f64>, f64);

fn cases(rig: &Rig, references: &MaskReferences) -> Vec<Case> {
    let (prepared, series) = rig.voyage();
    let masked = mask_recording(&prepared, &series, references).unwrap();
    let plain = |values: &[f64], f: &dyn Fn(f64) -> f64| values.iter().map(|v| f(*v)).collect();
    let flow = |v| references.mask_flow(v);
    let flow_step = references.mask_flow(rig.flow_step_m3_s);
    let r = &prepared.recording;
    let weight_pa_m = rig.well().weight_pa_m();
    let (inlet, outlet) = (rig.inlet_steps_pa[0], rig.outlet_steps_pa[0]);
    vec![
        (
            "inflow",
            masked.inflow_pct,
            plain(&r.inflow_m3_s(), &flow),
            flow_step,
        ),
        (
            "return",
            masked.return_flow_pct,
            plain(&r.return_flow_m3_s, &flow),
            flow_step,
        ),
        (
            "friction",
            masked.friction_pct,
            plain(&series.friction_pa, &|v| references.mask_friction(v)),
            references.mask_friction(outlet),
        ),
        (
            "level",
            masked.level_pct,
            plain(&series.level_m, &|v| references.mask_level(v)),
            references.mask_level(inlet / weight_pa_m),
        ),
        (
            "head",
            masked.head_pct,
            plain(&series.head_m, &|v| references.mask_head(v)),
            references.mask_head(inlet / weight_pa_m),
        ),
    ]
}

#[test]
fn without_dither_every_step_stands_out() {
    let rig = Rig::default();
    for (name, _, plain, step) in cases(&rig, &rig.references()) {
        assert!(comb(&plain, step) > 0.999, "{name}");
        assert!(strongest(&plain, step) > 0.999, "{name}");
    }
}

#[test]
fn with_dither_no_step_stands_out_of_the_noise() {
    let rig = Rig::default();
    for (name, masked, _, step) in cases(&rig, &rig.references()) {
        let found = strongest(&masked, step);
        assert!(found < noise_bound(), "{name}: {found}");
    }
}

#[test]
fn a_coarser_transmitter_at_the_other_side_leaves_no_step_bare() {
    // Noise 1.5 steps wide would leave a fifth of the comb.
    let rig = Rig {
        inlet_steps_pa: vec![690.0],
        outlet_steps_pa: vec![1035.0],
        ..Rig::default()
    };
    for (name, masked, _, step) in cases(&rig, &rig.references()) {
        let found = strongest(&masked, step);
        assert!(found < noise_bound(), "{name}: {found}");
    }
}

#[test]
fn redundant_transmitters_of_unequal_steps_leave_no_step_bare() {
    let rig = Rig {
        inlet_steps_pa: vec![690.0, 1000.0],
        outlet_steps_pa: vec![500.0, 690.0],
        ..Rig::default()
    };
    for (name, masked, _, step) in cases(&rig, &rig.references()) {
        let found = strongest(&masked, step);
        assert!(found < noise_bound(), "{name}: {found}");
    }
}

#[test]
fn combining_level_friction_and_head_wins_nothing() {
    // The three are two pressures: level is also friction less head. A reader finds the
    // factors by regression; here the true ones are given away.
    let rig = Rig::default();
    let references = rig.references();
    let (prepared, series) = rig.voyage();
    let masked = mask_recording(&prepared, &series, &references).unwrap();
    let weight_pa_m = rig.well().weight_pa_m();
    let level_again: Vec<f64> = masked
        .head_pct
        .iter()
        .zip(&masked.friction_pct)
        .map(|(head, friction)| {
            let head_m = references.unmask_head(*head);
            let friction_m = references.unmask_friction(*friction) / weight_pa_m;
            references.mask_level(head_m - friction_m)
        })
        .collect();
    let step = references.mask_level(rig.inlet_steps_pa[0] / weight_pa_m);
    for share in [0.25, 0.5, 0.75] {
        let both = masked.level_pct.iter().zip(&level_again);
        let mixed: Vec<f64> = both.map(|(a, b)| share * a + (1.0 - share) * b).collect();
        let found = strongest(&mixed, step);
        assert!(found < noise_bound(), "{share}: {found}");
    }
}

/// The part of a recording from a sample on.
fn cut(prepared: &Prepared, series: &Series, from: usize) -> (Prepared, Series) {
    let (mut prepared, mut series) = (prepared.clone(), series.clone());
    let r = &mut prepared.recording;
    let mut all: Vec<&mut Vec<f64>> = vec![
        &mut r.time_s,
        &mut r.mud_pump_flow_m3_s,
        &mut r.booster_flow_m3_s,
        &mut r.topfill_flow_m3_s,
        &mut r.return_flow_m3_s,
        &mut r.pump_speed_pct,
        &mut prepared.inlet_pressure_pa,
        &mut prepared.outlet_pressure_pa,
        &mut series.friction_pa,
        &mut series.head_m,
        &mut series.level_m,
    ];
    all.extend(&mut r.pump_inlet_pressure_pa);
    all.extend(&mut r.pump_outlet_pressure_pa);
    all.into_iter().for_each(|v| drop(v.drain(..from)));
    prepared.keep.drain(..from);
    (prepared, series)
}

#[test]
fn the_mean_of_maskings_of_many_cuts_has_no_less_noise() {
    let rig = Rig::default();
    let references = rig.references();
    let (prepared, series) = rig.voyage();
    let flows: Vec<Vec<f64>> = (0..16)
        .map(|n| {
            let from = 17 * n;
            let (prepared, series) = cut(&prepared, &series, from);
            let masked = mask_recording(&prepared, &series, &references).unwrap();
            masked.return_flow_pct[16 * 17 - from..].to_vec()
        })
        .collect();
    let mean: Vec<f64> = (0..flows[0].len())
        .map(|i| flows.iter().map(|f| f[i]).sum::<f64>() / flows.len() as f64)
        .collect();
    let step = references.mask_flow(rig.flow_step_m3_s);
    let found = strongest(&mean, step);
    // Slightly fewer samples than the bound counts with.
    assert!(found < 1.1 * noise_bound(), "{found}");
}

/// Root mean square of neighbours' differences.
fn unrest(values: &[f64]) -> f64 {
    let steps = differences(values);
    (steps.iter().map(|d| d * d).sum::<f64>() / steps.len() as f64).sqrt()
}

#[test]
fn a_meter_at_rest_does_not_tell_its_step_by_its_noise() {
    // With noise one step wide, as it once was, the range of 300 values at rest gave the step to 0.1 %.
    let rest = 1000..3000;
    let noise_at_rest = |step_gpm: f64| {
        let rig = Rig {
            flow_step_m3_s: step_gpm * 6.309e-5,
            ..Rig::default()
        };
        let (mut prepared, series) = rig.voyage();
        prepared.recording.return_flow_m3_s[rest.clone()].fill(0.0);
        let masked = mask_recording(&prepared, &series, &rig.references()).unwrap();
        unrest(&masked.return_flow_pct[rest.clone()])
    };
    let found = [0.1, 0.25, 0.5, 1.0].map(noise_at_rest);
    let (least, most) = found
        .iter()
        .fold((f64::MAX, 0.0f64), |(l, m), v| (l.min(*v), m.max(*v)));
    assert!(most < 1.1 * least, "{found:?}");
}

/// A pump that is held at round strokes for some seconds each, and what its masked set-points are in the mean.
struct Held {
    seconds: usize,
    /// Between so many strokes and as many more.
    strokes: (i64, i64),
    seed: i64,
}

impl Held {
    const MINUTES: Self = Self {
        seconds: 60,
        strokes: (600, 400),
        seed: 1,
    };

    fn means(&self, rig: &Rig, masked: bool) -> (Vec<f64>, f64) {
        let references = rig.references();
        let (mut prepared, series) = rig.voyage();
        let mut strokes = self.seed;
        for (i, flow) in prepared.recording.mud_pump_flow_m3_s.iter_mut().enumerate() {
            if i % self.seconds == 0 {
                strokes = (strokes * 48_271) % 2_147_483_647;
            }
            let (least, more) = self.strokes;
            *flow = (least + strokes % more) as f64 * rig.flow_step_m3_s;
        }
        prepared.recording.booster_flow_m3_s.fill(0.0);
        prepared.recording.topfill_flow_m3_s.fill(0.0);
        let inflow = if masked {
            mask_recording(&prepared, &series, &references)
                .unwrap()
                .inflow_pct
        } else {
            let plain = prepared.recording.inflow_m3_s();
            plain.iter().map(|q| references.mask_flow(*q)).collect()
        };
        let means = inflow
            .chunks_exact(self.seconds)
            .map(|c| c.iter().sum::<f64>() / c.len() as f64);
        (means.collect(), references.mask_flow(rig.flow_step_m3_s))
    }
}

#[test]
fn a_pump_held_at_set_points_shows_no_step_in_their_means() {
    let rig = Rig::default();
    let (plain, step) = Held::MINUTES.means(&rig, false);
    assert!(comb(&plain, step) > 0.999 && comb(&differences(&plain), step) > 0.999);
    let (means, step) = Held::MINUTES.means(&rig, true);
    // As in `noise_bound`, of a hundred minutes; one candidate, the true one.
    let bound = (2.0 * 1e4f64.ln() / means.len() as f64).sqrt();
    for values in [differences(&means), means] {
        let found = comb(&values, step);
        assert!(found < bound, "{found} of {bound}");
    }
}

#[test]
fn ten_set_points_of_a_coarse_transmitter_show_no_step_in_their_means() {
    // 0.4 % of the reference, as of 8 bits; too few changes to tell a quantum from.
    let rig = Rig {
        flow_step_m3_s: 0.004 * 0.0731,
        ..Rig::default()
    };
    // One recording has too few means to judge: a reader has forty of one rig.
    let means_of = |masked: bool| {
        let mut all = Vec::new();
        let mut percent = 0.0;
        for seed in 1..=40 {
            let held = Held {
                seconds: SAMPLES / 10,
                strokes: (150, 80),
                seed: 7919 * seed,
            };
            let (means, step) = held.means(&rig, masked);
            assert_eq!(means.len(), 10);
            all.extend(means);
            percent = step;
        }
        (all, percent)
    };
    let (plain, step) = means_of(false);
    assert!(comb(&plain, step) > 0.999);
    let (means, step) = means_of(true);
    let bound = (2.0 * 1e4f64.ln() / means.len() as f64).sqrt();
    let found = comb(&means, step);
    assert!(found < bound, "{found} of {bound}");
}

#[test]
fn who_knows_one_set_point_knows_the_scale() {
    // No leak that could be mended: the limit that the README states.
    let rig = Rig::default();
    let (mut prepared, series) = rig.voyage();
    let known_m3_s = 0.05;
    prepared.recording.return_flow_m3_s[1000..1300].fill(known_m3_s);
    let masked = mask_recording(&prepared, &series, &rig.references()).unwrap();
    let mean_pct = masked.return_flow_pct[1000..1300].iter().sum::<f64>() / 300.0;
    let found = 100.0 * known_m3_s / mean_pct;
    assert!((found / rig.references().disclose()[0] - 1.0).abs() < 0.005);
}
