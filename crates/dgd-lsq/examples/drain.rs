//! A tank that drains: its first level and its time constant out of noisy readings, by `lm`.
//!
//! `cargo run -p dgd-lsq --example drain`
#![expect(clippy::print_stdout, reason = "an example prints")]

use dgd_lsq::LsqError;
use dgd_lsq::lm::{Bounds, Effort, Ending, minimise};

/// First level, m, and time constant, min.
const TRUTH: [f64; 2] = [2.0, 10.0];

fn level_m(x: &[f64], minutes: f64) -> f64 {
    x[0] * (-minutes / x[1]).exp()
}

fn main() -> Result<(), LsqError> {
    let readings: Vec<(f64, f64)> = (0..60_u32)
        .map(|i| {
            let minutes = 0.5 * f64::from(i);
            // Off by up to 2 cm.
            let noise = f64::from(i * 7919 % 41) / 20.0 - 1.0;
            (minutes, level_m(&TRUTH, minutes) + 0.02 * noise)
        })
        .collect();
    let mut off = |x: &[f64]| Some(readings.iter().map(|(t, h)| level_m(x, *t) - h).collect());
    let bounds = Bounds::new(vec![0.1, 1.0], vec![10.0, 100.0])?;
    let start = [1.0, 50.0];
    let found = minimise(&mut off, &start, &bounds, None, None, Effort::default());
    let how = match found.ending {
        Ending::Converged => "a minimum",
        _ => "no minimum",
    };
    println!(
        "{how} after {} steps: the tank began at {:.2} m and loses nearly two thirds of it every {:.1} min (made with {} m and {} min)",
        found.steps, found.theta[0], found.theta[1], TRUTH[0], TRUTH[1]
    );
    Ok(())
}
