//! A tank whose level starts where its gauge reads: the reading is noisy, and the level may be another when the held-out part begins.

use crate::benches::{names, noisy, rk4, run, told};
use dgd_revise::Verdict;

/// A tank that a pump keeps emptying; without `[initial]`, so that the gauge says where the level starts.
fn fed_tank(instruments: &str, windows: &str) -> String {
    format!(
        r#"
        connections = ["feed -> tank", "tank -> pump -> atmosphere"]
        [components]
        feed = {{ kind = "boundary", flow = 0.01 }}
        tank = {{ kind = "tank", area = 1.0 }}
        pump = {{ kind = "displacement_pump" }}
        level = {{ kind = "instrument", measures = "level", of = "tank", channel = "h" }}
        {instruments}
        [inputs]
        "pump.input" = {{ channel = "u", between = "held" }}
        [free]
        "pump.coefficient" = {{ start = 0.009, low = 0.005, high = 0.02 }}
        [record]
        step = 1.0
        {windows}
    "#
    )
}

/// Strokes of the pump, in turns of 50 s.
fn strokes(n: usize) -> Vec<f64> {
    let held = |i: usize| if (i / 50).is_multiple_of(2) { 0.5 } else { 1.5 };
    (0..n).map(held).collect()
}

#[test]
fn the_error_of_the_first_reading_is_laid_to_nothing() {
    let windows = "train.windows = [[0.0, 599.0]]\ntest.windows = [[700.0, 999.0]]";
    let text = fed_tank("", windows);
    let u = strokes(1000);
    let levels = rk4([3.0], &u, 1.0, |_, u, _| [0.01 - 0.01 * u]);
    for seed in 1..=8 {
        let mut h = noisy(levels.iter().map(|x| x[0]), 1e-3, 77 * seed);
        // Two standard deviations off, as one reading in twenty is.
        h[0] = levels[0][0] + if seed.is_multiple_of(2) { 2e-3 } else { -2e-3 };
        let found = run(&text, &[("u", &u), ("h", &h)]);
        assert_eq!(
            found.verdict,
            Verdict::Consistent,
            "{seed}: {}",
            told(&found)
        );
        // The answer starts where the gauge reads, as the description says.
        let of_start = |p: &dgd_revise::Estimate| p.path.starts_with("tank.level");
        assert!(!found.before.parameters.iter().any(of_start));
        assert!(found.after.assembly.starts_measured());
        assert_eq!(found.after.theta.len(), 1);
    }
}

#[test]
fn a_late_pump_is_named_though_the_tank_was_topped_up_between_the_parts() {
    let windows = "train.windows = [[0.0, 599.0]]\ntest.windows = [[1049.0, 1299.0]]";
    let flow =
        "pumped = { kind = \"instrument\", measures = \"flow\", of = \"pump\", channel = \"m\" }";
    let text = fed_tank(flow, windows);
    let u = strokes(1300);
    // Both parts begin where the pump has come to its strokes, as a model takes it that does not see what was before.
    let states = rk4([3.0, 0.5], &u, 1.0, |x, u, _| {
        [0.01 - 0.01 * x[1], (u - x[1]) / 8.0]
    });
    let pumped = noisy(states.iter().map(|x| 0.01 * x[1]), 1e-4, 6);
    for topped in [0.0, 0.5] {
        let level = states.iter().enumerate();
        let level = level.map(|(i, x)| x[0] + if i > 800 { topped } else { 0.0 });
        let h = noisy(level, 1e-3, 5);
        let found = run(&text, &[("u", &u), ("h", &h), ("m", &pumped)]);
        assert_eq!(
            names(&found),
            ["pump.pump_lag"],
            "{topped}: {}",
            told(&found)
        );
    }
}
