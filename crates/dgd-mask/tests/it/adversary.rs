//! Somebody looks for a transmitter's step in the masked data: 0.5 gpm or 0.1 psi as a
//! percentage is the reference.

use crate::rig::{Rig, SAMPLES};
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
    let masked = mask_recording(&prepared, &series, references);
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
    let masked = mask_recording(&prepared, &series, &references);
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
