//! Three benches as plain differential equations, and their recordings as CSV.

use std::fmt::Write as _;

const GRAVITY: f64 = 9.806_65;
const ATMOSPHERE_PA: f64 = 101_325.0;

/// Name, description, recording.
pub(crate) fn all() -> [(&'static str, &'static str, String); 3] {
    [
        ("two_tanks", include_str!("two_tanks.toml"), two_tanks()),
        ("pump_loop", include_str!("pump_loop.toml"), pump_loop()),
        (
            "return_line",
            include_str!("return_line.toml"),
            return_line(),
        ),
    ]
}

/// Uniform in ±1, the same on every machine (Knuth's multiplier).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let high = u32::try_from(self.0 >> 32).unwrap_or(u32::MAX);
        2.0 * f64::from(high) / f64::from(u32::MAX) - 1.0
    }
}

/// One step of the classical Runge-Kutta method.
fn step<const N: usize>(x: [f64; N], h: f64, f: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let moved = |k: [f64; N], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
    let a = f(x);
    let b = f(moved(a, 0.5 * h));
    let c = f(moved(b, 0.5 * h));
    let d = f(moved(c, h));
    std::array::from_fn(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
}

/// Levels that hold for a while, in `low..high`.
fn steps(n: usize, hold: usize, low: f64, high: f64, seed: u64) -> Vec<f64> {
    let mut noise = Noise(seed);
    let mut value = low;
    (0..n)
        .map(|i| {
            if i % hold == 0 {
                value = low + (high - low) * (0.5 + 0.5 * noise.next());
            }
            value
        })
        .collect()
}

/// Straight lines between levels of [`steps`].
fn ramps(n: usize, over: usize, low: f64, high: f64, seed: u64) -> Vec<f64> {
    let knots = steps(n / over + 2, 1, low, high, seed);
    (0..n)
        .map(|i| {
            let share = (i % over) as f64 / over as f64;
            knots[i / over] * (1.0 - share) + knots[i / over + 1] * share
        })
        .collect()
}

/// Discharge coefficients of the upper and the lower outlet, levels at the start, m.
pub(crate) const TWO_TANKS: [f64; 4] = [0.62, 0.58, 0.12, 0.09];

/// 2,400 s every 4 s; the level is read to 1 mm with 1 mm of noise.
pub(crate) fn two_tanks() -> String {
    let [upper, lower, mut x0, mut x1] = TWO_TANKS;
    let u = steps(601, 25, 3.0, 7.0, 5);
    let mut noise = Noise(17);
    let mut text = String::from("t,u,h2\ns,V,cm\n");
    for (i, u) in u.iter().enumerate() {
        let level = (1000.0 * (x1 + 1e-3 * noise.next())).round() / 10.0;
        let _ = writeln!(text, "{},{u:.3},{level:.1}", 4 * i);
        // What the recording says is what drove it.
        let u = (u * 1000.0).round() / 1000.0;
        for _ in 0..40 {
            let out = |c: f64, area: f64, h: f64| c * area * (2.0 * GRAVITY * h.max(0.0)).sqrt();
            [x0, x1] = step([x0, x1], 0.1, |[a, b]| {
                let between = out(upper, 1e-4, a);
                [
                    (2e-5 * u - between) / 0.02,
                    (between - out(lower, 1.2e-4, b)) / 0.02,
                ]
            });
        }
    }
    text
}

/// Head coefficient of the pump, m/%²; roughness of the line, m; flow coefficient of the throttle, m³/(s √Pa).
pub(crate) const PUMP_LOOP: [f64; 3] = [0.004, 2e-4, 1.5e-5];

/// Darcy's friction factor after Haaland, for turbulent flow.
fn haaland(reynolds: f64, relative: f64) -> f64 {
    let inner = 6.9 / reynolds + (relative / 3.7).powf(1.11);
    (-1.8 * inner.log10()).powi(-2)
}

/// 600 s every second; flow with 0.2 l/min and pressure with 2 mbar of noise.
pub(crate) fn pump_loop() -> String {
    let [c0, roughness, valve] = PUMP_LOOP;
    let (length, bore, density): (f64, f64, f64) = (30.0, 0.05, 1000.0);
    let area = std::f64::consts::PI / 4.0 * bore * bore;
    let n = 601;
    let (w, z) = (
        ramps(n + 1, 40, 60.0, 100.0, 3),
        ramps(n + 1, 25, 0.4, 1.0, 8),
    );
    let rounded = |v: f64| (v * 1e4).round() / 1e4;
    let friction = |q: f64| {
        let velocity = q / area;
        let factor = haaland(
            (density * velocity * bore / 1e-3).max(4000.0),
            roughness / bore,
        );
        factor * length / bore * density * velocity * velocity / 2.0
    };
    // The tank gives back what it gets; its level stands.
    let pushed = |w: f64, q: f64| density * GRAVITY * (c0 * w * w - 150_000.0 * q * q);
    let needed =
        |z: f64, q: f64| friction(q) + (q / (valve * z)).powi(2) + density * GRAVITY * (2.0 - 1.5);
    let mut q: f64 = 0.0;
    let mut noise = Noise(23);
    let mut text = String::from("t,SPM,ZT1,FT1,PT1\ns,%,,l/min,bar\n");
    for i in 0..n {
        let between = |values: &[f64], share: f64| {
            rounded(values[i]) * (1.0 - share) + rounded(values[i + 1]) * share
        };
        if i == 0 {
            // At rest with its surroundings: the steady flow of the first sample.
            let (w, z) = (between(&w, 0.0), between(&z, 0.0));
            let (mut low, mut high) = (0.0, 0.1);
            for _ in 0..80 {
                q = 0.5 * (low + high);
                // The suction side has 1.5 m of water, which `needed` takes off.
                if pushed(w, q) > needed(z, q) {
                    low = q
                } else {
                    high = q
                }
            }
        }
        let suction = ATMOSPHERE_PA + density * GRAVITY * 1.5;
        let discharge = suction + pushed(between(&w, 0.0), q);
        let _ = writeln!(
            text,
            "{i},{:.4},{:.4},{:.2},{:.4}",
            w[i],
            z[i],
            q * 6e4 + 0.2 * noise.next(),
            discharge * 1e-5 + 2e-3 * noise.next()
        );
        for k in 0..100 {
            let share = |d: f64| (f64::from(k) + d) / 100.0;
            let rate = |d: f64, q: f64| {
                let (w, z) = (between(&w, share(d)), between(&z, share(d)));
                (pushed(w, q) - needed(z, q)) / (density * length / area)
            };
            // Inputs bend between the stages, so the midpoint rule with small steps.
            let half = q + 0.005 * rate(0.0, q);
            q = (q + 0.01 * rate(0.5, half)).max(1e-6);
        }
    }
    text
}

/// Head coefficient of the pump, m/%^n0; quadratic friction of the line, Pa s²/m⁶; level at the start, m above the pump inlet.
pub(crate) const RETURN_LINE: [f64; 3] = [0.068_78, 1.28e8, 210.3];

/// 3,000 s every second; flow to 0.5 gpm, pressures to 0.1 psi, with noise of the same size.
pub(crate) fn return_line() -> String {
    const GPM: f64 = 6.3090e-5;
    const PSI: f64 = 6_894.757_29;
    let [c0, quadratic, mut level] = RETURN_LINE;
    let (density, riser, line, depth): (f64, f64, f64, f64) = (1080.0, 0.170_44, 0.018_241, 350.3);
    let weight = density * GRAVITY;
    let friction = |q: f64| 12_650.0 + quadratic * q * q.abs();
    let n = 3001;
    let inflow = steps(n, 150, 700.0, 900.0, 41);
    let speed = ramps(n + 1, 60, 58.0, 66.0, 29);
    let mut noise = Noise(31);
    let mut text = String::from("t,FT1,SPM,FT4,PT1,PT3\ns,gpm,%,gpm,psia,psia\n");
    // What the recording says is what drove it.
    let at = |values: &[f64], scale: f64, i: usize, share: f64| {
        let round = |v: f64| (v * scale).round() / scale;
        let last = values.len() - 1;
        round(values[i]) * (1.0 - share) + round(values[(i + 1).min(last)]) * share
    };
    let head = |w: f64, q: f64| c0 * w.powf(1.9546) - 0.05 * w * q - 8926.0 * q.abs().powf(1.6243);
    let rates = |level: f64, q: f64, w: f64, into: f64| {
        let drive = weight * (level + head(w, q) - depth) - friction(q);
        let inertia = density * (depth / line + level / riser);
        [(into - q) / riser, drive / inertia]
    };
    // At rest with its surroundings: the steady flow of the first sample.
    let (mut low, mut q, mut high) = (0.0, 0.05, 0.2);
    for _ in 0..80 {
        if rates(level, q, at(&speed, 1e3, 0, 0.0), 0.0)[1] > 0.0 {
            low = q;
        } else {
            high = q;
        }
        q = 0.5 * (low + high);
    }
    let to = |value: f64, resolution: f64| (value / resolution).round() * resolution;
    for i in 0..n {
        let mut next = || noise.next();
        let flow = to(q / GPM + 0.5 * next(), 0.5);
        let inlet = to((ATMOSPHERE_PA + weight * level) / PSI + 0.1 * next(), 0.1);
        let outlet = ATMOSPHERE_PA + weight * (level + head(at(&speed, 1e3, i, 0.0), q));
        let outlet = to(outlet / PSI + 0.1 * next(), 0.1);
        let _ = writeln!(
            text,
            "{i},{:.1},{:.3},{flow:.1},{inlet:.1},{outlet:.1}",
            inflow[i], speed[i]
        );
        for k in 0..20 {
            let share = (f64::from(k) + 0.5) / 20.0;
            let (w, into) = (at(&speed, 1e3, i, share), at(&inflow, 10.0, i, share) * GPM);
            [level, q] = step([level, q], 0.05, |[level, q]| rates(level, q, w, into));
        }
    }
    text
}
