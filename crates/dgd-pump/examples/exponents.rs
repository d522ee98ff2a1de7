//! A pump that is not quite quadratic: its exponents out of made samples.
//!
//! `cargo run -p dgd-pump --example exponents`
#![expect(clippy::print_stdout, reason = "an example prints")]

use dgd_pump::{
    HeadCurve, PumpError, Samples, SearchOptions, SearchStatus, check_shape, search_exponents,
};

const TRUTH: HeadCurve = HeadCurve {
    c0: 0.0688,
    c1: 3.0,
    c2: 2.4e3,
    n0: 1.95,
    n2: 1.62,
};

fn main() -> Result<(), PumpError> {
    // Speeds of 40 to 80 % and flows up to 0.07 m³/s, not in step with one another.
    let of = |i: u32, period: u32| f64::from(i % period) / f64::from(period - 1);
    let speed_pct: Vec<f64> = (0..4000).map(|i| 40.0 + 40.0 * of(i, 101)).collect();
    let flow_m3_s: Vec<f64> = (0..4000).map(|i| 0.07 * of(i, 71)).collect();
    // Off by up to 0.2 m.
    let noise = |i: u32| f64::from(i * 7919 % 41) / 20.0 - 1.0;
    let measured = speed_pct.iter().zip(&flow_m3_s).zip(0..);
    let head_m: Vec<f64> = measured
        .map(|((w, q), i)| TRUTH.head_m(*w, *q) + 0.2 * noise(i))
        .collect();
    let samples = Samples {
        speed_pct: &speed_pct,
        flow_m3_s: &flow_m3_s,
        head_m: &head_m,
        keep: &vec![true; head_m.len()],
    };
    let found = search_exponents(&samples, &SearchOptions::default())?;
    let curve = &found.fit.curve;
    let how = match found.status {
        SearchStatus::Converged if found.limits.is_empty() => "converged, on no limit",
        SearchStatus::Converged => "converged on a limit of the model",
        _ => "did not converge",
    };
    println!(
        "the search {how}: n0 = {:.3}, n2 = {:.2} (made with {} and {})",
        curve.n0, curve.n2, TRUTH.n0, TRUTH.n2
    );
    let shape = check_shape(curve, 40.0..=80.0, 0.0..=0.07)?;
    println!(
        "it lifts {:.0} m at 60 % and 0.05 m³/s, to {:.2} m; over the range it {}",
        curve.head_m(60.0, 0.05),
        found.fit.mse_m2.sqrt(),
        if shape.falls_with_flow && shape.concave {
            "falls with the flow and curves downwards"
        } else {
            "has not the shape of a pump's"
        }
    );
    Ok(())
}
