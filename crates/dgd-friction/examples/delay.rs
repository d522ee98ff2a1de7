//! A flow meter that is late: its delay, and the friction law beneath it, out of a made recording.
//!
//! `cargo run -p dgd-friction --example delay`
#![expect(clippy::print_stdout, reason = "an example prints")]

use dgd_friction::{FrictionError, Minimum, Samples, SweepOptions, Terms, delay_sweep};

/// What the meter is late by, s.
const LATE_S: u32 = 12;

/// Flow in the line, m³/s, at a second.
fn flow_m3_s(t: f64) -> f64 {
    0.045 + 0.014 * (t / 97.0).sin() + 0.006 * (t / 29.0).cos()
}

/// Friction of the line, Pa.
fn friction_pa(q: f64) -> f64 {
    1e6 * q + 9e7 * q * q
}

fn main() -> Result<(), FrictionError> {
    let seconds = || (0..3600_u32).map(f64::from);
    let metered: Vec<f64> = seconds()
        .map(|t| flow_m3_s(t - f64::from(LATE_S)))
        .collect();
    // Off by up to 2 kPa.
    let noise = |t: f64| (t * 7919.0).rem_euclid(41.0) / 20.0 - 1.0;
    let observed: Vec<f64> = seconds()
        .map(|t| friction_pa(flow_m3_s(t)) + 2e3 * noise(t))
        .collect();
    let samples = Samples {
        flow_m3_s: &metered,
        friction_pa: &observed,
        keep: &vec![true; metered.len()],
        keep_delayed: false,
    };
    let sweep = delay_sweep(&samples, &Terms::Quadratic, &SweepOptions::default())?;
    let where_ = match sweep.minimum {
        Minimum::Interior => "with delays on both sides that fit worse",
        _ => "at an edge of what was tried",
    };
    println!(
        "the meter is {:.1} s late, {where_} (made with {LATE_S} s)",
        sweep.refined_delay_s
    );
    let law = &sweep.fit.law;
    println!(
        "friction is {:.2e} q + {:.2e} q² Pa to {:.1} kPa, of {} samples (made with 1e6 and 9e7)",
        law.coefficient(1.0).unwrap_or(0.0),
        law.coefficient(2.0).unwrap_or(0.0),
        1e-3 * sweep.fit.mse_pa2.sqrt(),
        sweep.fit.n
    );
    Ok(())
}
