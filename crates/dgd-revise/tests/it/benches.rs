//! Benches simulated by code of their own: plain Runge-Kutta steps on the equations as written here.

use dgd_assembly::{Assembly, Record};
use dgd_revise::{Options, Revision, revise};

pub(crate) const G: f64 = 9.80665;

/// Uniform numbers, the same on every machine.
pub(crate) struct Draws(u64);

impl Draws {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Near enough to normal: twelve uniform numbers.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

/// Held steps between `low` and `high`.
pub(crate) fn steps(n: usize, hold: usize, low: f64, high: f64, seed: u64) -> Vec<f64> {
    let mut draws = Draws::new(seed);
    for _ in 0..20 {
        draws.unit();
    }
    let mut value = low;
    (0..n)
        .map(|i| {
            if i % hold == 0 {
                value = low + (high - low) * draws.unit();
            }
            value
        })
        .collect()
}

/// Classical Runge-Kutta over held inputs; states at each sample.
pub(crate) fn rk4<const N: usize>(
    mut x: [f64; N],
    u: &[f64],
    dt: f64,
    rate: impl Fn(&[f64; N], f64, f64) -> [f64; N],
) -> Vec<[f64; N]> {
    const WITHIN: usize = 20;
    let h = dt / WITHIN as f64;
    let mut all = Vec::new();
    for (i, &u) in u.iter().enumerate() {
        all.push(x);
        for k in 0..WITHIN {
            let t = i as f64 * dt + k as f64 * h;
            let moved = |k: &[f64; N], s: f64| std::array::from_fn(|j| x[j] + s * k[j]);
            let k1 = rate(&x, u, t);
            let k2 = rate(&moved(&k1, 0.5 * h), u, t + 0.5 * h);
            let k3 = rate(&moved(&k2, 0.5 * h), u, t + 0.5 * h);
            let k4 = rate(&moved(&k3, h), u, t + h);
            x = std::array::from_fn(|j| {
                x[j] + h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j])
            });
        }
    }
    all
}

pub(crate) fn noisy(values: impl Iterator<Item = f64>, sigma: f64, seed: u64) -> Vec<f64> {
    let mut draws = Draws::new(seed);
    values.map(|v| v + sigma * draws.normal()).collect()
}

pub(crate) fn run(text: &str, columns: &[(&str, &[f64])]) -> Revision {
    let assembly = Assembly::parse(text).unwrap();
    let record = Record {
        columns: columns.to_vec(),
    };
    revise(&assembly, &record, &Options::default(), &mut |_| {}).unwrap()
}

/// `component.effect` of each finding.
pub(crate) fn names(found: &Revision) -> Vec<String> {
    found
        .findings
        .iter()
        .map(|f| format!("{}.{}", f.component, f.effect))
        .collect()
}

pub(crate) fn told(found: &Revision) -> String {
    let mut text = format!("{:?}\n", found.verdict);
    for f in &found.findings {
        text += &format!(
            "  {}.{} loss {:.3} se {:.1} {:?}\n     in {:?}\n     {:?}\n     alternatives {:?} {:?} {:?}\n",
            f.component,
            f.effect,
            f.left_out_loss,
            f.standard_errors,
            f.parameters
                .iter()
                .map(|p| (&p.path, p.value, p.ci95))
                .collect::<Vec<_>>(),
            f.intervals,
            f.region,
            f.alternatives,
            f.separating_test,
            f.shape,
        );
    }
    for c in found
        .contenders
        .iter()
        .filter(|c| c.members.len() < 2 || std::env::var("ALL").is_ok())
    {
        text += &format!(
            "  train {:.3} left out {:.3} se {:.4} {:?}\n",
            c.training, c.left_out, c.standard_error, c.members
        );
    }
    for o in &found.outputs {
        text += &format!("  {o:?}\n");
    }
    for c in &found.checks {
        text += &format!(
            "  {} {}: {}\n",
            if c.passed { "ok" } else { "NO" },
            c.name,
            c.detail
        );
    }
    text += &format!("  {:?}\n  sections {:?}\n", found.classes, found.sections);
    text + &format!("  {:?}\n", found.settings)
}

/// What differs from the textbook's two tanks.
#[derive(Clone, Copy, Default)]
pub(crate) struct Tanks {
    /// Share of the overflow that the lower tank catches.
    pub caught: f64,
    /// Whether the description knows of the brim.
    pub brim_known: bool,
    /// Outflow that a siphon adds to the lower tank between two levels, m³/s: not in the catalogue.
    pub siphon: f64,
    /// Standard deviation of the reading, m.
    pub sigma: f64,
    /// How much of the reading's noise is kept from sample to sample.
    pub memory: f64,
    /// Standard deviation by which the pump's delivery wanders, as a share: not in the catalogue.
    pub wander: f64,
}

const AREA: f64 = 0.02;
const BRIM: f64 = 0.3;

/// A tank above a tank, only the lower one measured; estimation and validation columns.
pub(crate) fn two_tanks(case: Tanks, n: usize) -> Revision {
    let dt = 4.0;
    let simulate = |u: &[f64], seed: u64| {
        let wander = wandering(n, 0.9, seed + 20);
        let fed: Vec<f64> = u
            .iter()
            .zip(wander)
            .map(|(u, w)| u * (1.0 + case.wander * w))
            .collect();
        let rate = |x: &[f64; 2], u: f64, _: f64| {
            let inflow = 2e-5 * u;
            let between = 0.62 * 1e-4 * (2.0 * G * x[0].max(0.0)).sqrt();
            let out = 0.62 * 1.2e-4 * (2.0 * G * x[1].max(0.0)).sqrt();
            // A brim so steep that the level hardly rises above it.
            let over = if x[0] > BRIM {
                0.5 * (x[0] - BRIM)
            } else {
                0.0
            };
            let hidden = case.siphon * (-((x[1] - 0.12) / 0.02).powi(2)).exp();
            [
                (inflow - between - over) / AREA,
                (between + case.caught * over - out - hidden) / AREA,
            ]
        };
        let x = rk4([0.1, 0.08], &fed, dt, rate);
        let mut draws = Draws::new(seed);
        let mut noise = 0.0;
        x.iter()
            .map(|x| {
                noise = case.memory * noise
                    + (1.0 - case.memory * case.memory).sqrt() * case.sigma * draws.normal();
                x[1] + noise
            })
            .collect::<Vec<f64>>()
    };
    let (ue, uv) = (steps(n, 12, 2.0, 12.0, 3), steps(n, 12, 2.0, 12.0, 4));
    let (ye, yv) = (simulate(&ue, 5), simulate(&uv, 6));
    let brim = if case.brim_known { ", brim = 0.3" } else { "" };
    let text = format!(
        r#"
connections = ["atmosphere -> pump -> upper -> upper_outlet -> lower -> lower_outlet -> atmosphere"]
[components]
pump = {{ kind = "displacement_pump" }}
upper = {{ kind = "tank", area = 0.02{brim} }}
upper_outlet = {{ kind = "orifice", area = 1e-4 }}
lower = {{ kind = "tank", area = 0.02, brim = 0.5 }}
lower_outlet = {{ kind = "orifice", area = 1.2e-4 }}
level = {{ kind = "instrument", measures = "level", of = "lower", channel = "y" }}
[inputs]
"pump.input" = {{ channel = "u", between = "held" }}
[initial]
"upper.level" = {{ start = 0.15, low = 0.0, high = 0.3 }}
"lower.level" = {{ start = 0.15, low = 0.0, high = 0.4 }}
[free]
"upper_outlet.discharge_coefficient" = {{ start = 0.6, low = 0.3, high = 1.0 }}
"lower_outlet.discharge_coefficient" = {{ start = 0.6, low = 0.3, high = 1.0 }}
"pump.coefficient" = {{ start = 1e-5, low = 5e-6, high = 5e-5 }}
[record]
step = 4.0
train.channels = {{ u = "ue", y = "ye" }}
test.channels = {{ u = "uv", y = "yv" }}
"#
    );
    run(&text, &[("ue", &ue), ("ye", &ye), ("uv", &uv), ("yv", &yv)])
}

/// A tank whose level stands above a crest, below its brim, over which it spills as over a weir.
pub(crate) fn tank_with_crest(n: usize) -> Revision {
    let simulate = |u: &[f64], seed: u64| {
        let rate = |x: &[f64; 1], u: f64, _: f64| {
            let out = 0.62 * 1e-4 * (2.0 * G * x[0].max(0.0)).sqrt();
            let over = 4e-3 * (x[0] - 0.3).max(0.0).powf(1.5);
            [(2e-5 * u - out - over) / AREA]
        };
        let x = rk4([0.15], u, 4.0, rate);
        noisy(x.iter().map(|x| x[0]), 5e-4, seed)
    };
    let (ue, uv) = (steps(n, 12, 2.0, 12.0, 13), steps(n, 12, 2.0, 12.0, 14));
    let (ye, yv) = (simulate(&ue, 15), simulate(&uv, 16));
    let text = r#"
connections = ["atmosphere -> pump -> tank -> outlet -> atmosphere"]
[components]
pump = { kind = "displacement_pump" }
tank = { kind = "tank", area = 0.02, brim = 1.2 }
outlet = { kind = "orifice", area = 1e-4 }
level = { kind = "instrument", measures = "level", of = "tank", channel = "y" }
[inputs]
"pump.input" = { channel = "u", between = "held" }
[initial]
"tank.level" = { start = 0.2, low = 0.0, high = 0.4 }
[free]
"outlet.discharge_coefficient" = { start = 0.6, low = 0.3, high = 1.0 }
"pump.coefficient" = { start = 1e-5, low = 5e-6, high = 5e-5 }
[record]
step = 4.0
train.channels = { u = "ue", y = "ye" }
test.channels = { u = "uv", y = "yv" }
"#;
    run(text, &[("ue", &ue), ("ye", &ye), ("uv", &uv), ("yv", &yv)])
}

/// What differs from the textbook's loop.
#[derive(Clone, Copy, Default)]
pub(crate) struct Loop {
    /// Laminar slip of the pump, m³/s/Pa.
    pub slip: f64,
    /// Share of its opening, as a logarithm, that the valve loses.
    pub clogging: f64,
    /// Standard deviation by which the pump's delivery wanders, as a share: not in the catalogue.
    pub wander: f64,
    /// How much of each gauge's noise is kept from sample to sample.
    pub memory: f64,
}

/// Wanders about nought with a standard deviation of one, forgetting `1 - kept` at each step.
pub(crate) fn wandering(n: usize, kept: f64, seed: u64) -> Vec<f64> {
    let mut draws = Draws::new(seed);
    let mut x = draws.normal();
    (0..n)
        .map(|_| {
            x = kept * x + (1.0 - kept * kept).sqrt() * draws.normal();
            x
        })
        .collect()
}

/// A pump with laminar slip, a line and a valve that clogs; pressure and flow measured; two runs from a clean valve.
pub(crate) fn pump_loop(case: Loop, n: usize) -> Revision {
    let Loop { slip, clogging, .. } = case;
    let (c, k, r) = (2e-5, 4e-6, 2.5e10);
    let simulate = |seed: u64| {
        let u = steps(n, 7, 60.0, 160.0, seed);
        let z = steps(n, 11, 0.4, 1.0, seed + 1);
        let wander = wandering(n, 0.9, seed + 4);
        let (mut flow, mut pressure) = (Vec::new(), Vec::new());
        for i in 0..n {
            let c = c * (1.0 + case.wander * wander[i]);
            let coefficient = k * z[i] * (-clogging * i as f64 / n as f64).exp();
            let drop = |q: f64| r * q * q + q * q / (coefficient * coefficient);
            // A metre of water helps the pump.
            let rise = |q: f64| drop(q) - 1000.0 * G;
            // q + slip·rise(q) = c u, rising in q: bisection.
            let (mut low, mut high) = (0.0, c * u[i]);
            for _ in 0..80 {
                let q = 0.5 * (low + high);
                if q + slip * rise(q) > c * u[i] {
                    high = q
                } else {
                    low = q
                }
            }
            flow.push(low);
            pressure.push(101_325.0 + drop(low));
        }
        let noise = |values: Vec<f64>, sigma: f64, seed: u64| -> Vec<f64> {
            let noise = wandering(n, case.memory, seed);
            values
                .iter()
                .zip(noise)
                .map(|(v, e)| v + sigma * e)
                .collect()
        };
        let q = noise(flow, 5e-6, seed + 2);
        let p = noise(pressure, 2e3, seed + 3);
        [u, z, q, p]
    };
    let ([ue, ze, qe, pe], [uv, zv, qv, pv]) = (simulate(11), simulate(31));
    let text = r#"
connections = ["tank -> pump -> line -> valve -> tank"]
[components]
tank = { kind = "tank", area = 1.0 }
pump = { kind = "displacement_pump" }
line = { kind = "line", quadratic = 2.5e10 }
valve = { kind = "valve" }
flow = { kind = "instrument", measures = "flow", of = "line", channel = "q" }
discharge = { kind = "instrument", measures = "pressure", of = "pump.outlet", channel = "p" }
[inputs]
"pump.input" = { channel = "u", between = "held" }
"valve.opening" = { channel = "z", between = "held" }
[initial]
"tank.level" = 1.0
[free]
"pump.coefficient" = { start = 1e-5, low = 5e-6, high = 5e-5 }
"valve.flow_coefficient" = { start = 2e-6, low = 1e-6, high = 2e-5 }
[record]
step = 1.0
train.channels = { u = "ue", z = "ze", q = "qe", p = "pe" }
test.channels = { u = "uv", z = "zv", q = "qv", p = "pv" }
"#;
    let columns: [(&str, &[f64]); 8] = [
        ("ue", &ue),
        ("ze", &ze),
        ("qe", &qe),
        ("pe", &pe),
        ("uv", &uv),
        ("zv", &zv),
        ("qv", &qv),
        ("pv", &pv),
    ];
    run(text, &columns)
}

/// Standpipe pressure over depth: bit and string. Its last table is `[record]`.
pub(crate) const WELL: &str = r#"
independent = "depth"
connections = ["pump -> string -> bit -> atmosphere"]
[components]
pump = { kind = "boundary" }
string = { kind = "line", quadratic = 0.0 }
bit = { kind = "orifice", discharge_coefficient = 0.95 }
standpipe = { kind = "instrument", measures = "pressure", of = "string.inlet", channel = "p" }
[inputs]
"pump.flow" = { channel = "q" }
"string.quadratic" = { channel = "resistance" }
[free]
"bit.area" = { start = 5e-4, low = 1e-4, high = 2e-3 }
[record]
time = "depth"
"#;

/// [`WELL`] with a loss in proportion to the flow that the description leaves out:
/// `loss` at 30 l/s above `from`, `below` beneath it. The deepest 30 % are held out.
pub(crate) fn well(loss: f64, below: f64, from: f64, n: usize) -> Revision {
    let depth: Vec<f64> = (0..n)
        .map(|i| 100.0 + 2000.0 * i as f64 / n as f64)
        .collect();
    let q = steps(n, 9, 0.01, 0.04, 21);
    let p = noisy(
        depth.iter().zip(&q).map(|(d, q)| {
            let string = 2.0e6 * d * q * q;
            let bit = 0.5 * 1000.0 * q * q / (0.95_f64 * 4e-4).powi(2);
            let left_out = if *d < from { loss } else { below };
            101_325.0 + string + bit + left_out * q / 0.03
        }),
        5e3,
        22,
    );
    let parts = "train.windows = [[0.0, 1500.0]]\ntest.windows = [[1500.5, 1e9]]";
    let resistance: Vec<f64> = depth.iter().map(|d| 2.0e6 * d).collect();
    run(
        &format!("{WELL}{parts}"),
        &[
            ("depth", &depth),
            ("q", &q),
            ("p", &p),
            ("resistance", &resistance),
        ],
    )
}

/// Standpipe pressure while the string grows with the depth and the flow is taken back, so that a fit of B + D q² ends at D = 0: what
/// grows with the string's length is left out. `accuracy` (Pa) is what the gauge is said to be good for.
pub(crate) fn growing_string(accuracy: Option<f64>, n: usize) -> Revision {
    let depth: Vec<f64> = (0..n)
        .map(|i| 100.0 + 2000.0 * i as f64 / n as f64)
        .collect();
    let mut draws = Draws::new(31);
    let q: Vec<f64> = depth
        .iter()
        .map(|d| 0.06 - 0.012 * d / 1000.0 + 0.004 * (draws.unit() - 0.5))
        .collect();
    let p = noisy(
        depth
            .iter()
            .zip(&q)
            .map(|(d, q)| 1e6 + 1e8 * q * q + 3e6 * d / 1000.0 * (q / 0.05).powi(2)),
        2e4,
        32,
    );
    let accuracy = accuracy.map_or_else(String::new, |a| format!(", accuracy = {a:.1}"));
    let text = r#"
independent = "depth"
connections = ["pump -> string -> atmosphere"]
[components]
pump = { kind = "boundary" }
string = { kind = "line", friction = "polynomial" }
standpipe = { kind = "instrument", measures = "pressure", of = "string.inlet", channel = "p"ACCURACY }
[inputs]
"pump.flow" = { channel = "q" }
"string.length" = { channel = "depth" }
[free]
"string.constant" = { start = 0.0, low = -1e7, high = 1e7 }
"string.quadratic" = { start = 2e9, low = 0.0, high = 2e10 }
[scale]
flow = 0.05
pressure = 5e6
time = 2.0
[record]
time = "depth"
train.windows = [[0.0, 1500.0]]
test.windows = [[1500.5, 1e9]]
"#
    .replace("ACCURACY", &accuracy);
    run(&text, &[("depth", &depth), ("q", &q), ("p", &p)])
}
