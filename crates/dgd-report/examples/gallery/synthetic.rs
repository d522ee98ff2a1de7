//! Data that look like the thesis's, made from a few lines of arithmetic.

pub(crate) struct Noise(u64);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Even in [0, 1).
    pub(crate) fn even(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let bits = u32::try_from(self.0 >> 33).expect("31 bits");
        f64::from(bits) / f64::from(1_u32 << 31)
    }

    /// Nearly normal, unit spread.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.even()).sum::<f64>() - 6.0
    }
}

/// Flow and friction of `n` samples in percent: (all, kept).
pub(crate) fn friction(n: usize) -> ([Vec<f64>; 2], [Vec<f64>; 2]) {
    let mut noise = Noise::new(7);
    let (mut all, mut kept) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    let mut walk = 60.0_f64;
    for i in 0..n {
        walk = (walk + 0.8 * noise.normal()).clamp(0.0, 104.0);
        let truth = 0.004 * walk * walk + 0.000_04 * walk.powi(3) + 1.0;
        let (mut q, mut f) = (walk, truth + 2.5 * noise.normal());
        let good = i % 6 == 0;
        if !good && noise.even() < 0.12 {
            // The pump stops and the line drains.
            q = 20.0 * noise.even() * noise.even();
            f = -60.0 * noise.even() + 8.0 * noise.normal();
        } else if !good && noise.even() < 0.1 {
            // A frozen flow meter.
            q = (q / 8.0).floor() * 8.0;
            f = 45.0 * noise.even() + 10.0 * noise.normal();
        }
        if i % 20_011 == 5 {
            f = 900.0;
        }
        all[0].push(q);
        all[1].push(f);
        if good {
            kept[0].push(q);
            kept[1].push(f);
        }
    }
    (all, kept)
}

pub(crate) fn ramp(n: u32, to: f64) -> Vec<f64> {
    (0..=n).map(|i| to * f64::from(i) / f64::from(n)).collect()
}

/// Pump head in percent.
pub(crate) fn head(speed: f64, flow: f64) -> f64 {
    0.022 * speed.powf(1.95) - 0.000_9 * speed * flow - 0.000_6 * flow.powf(2.1)
}

pub(crate) struct Speed {
    pub(crate) speed_pct: f64,
    pub(crate) flow: Vec<f64>,
    pub(crate) head: Vec<f64>,
    pub(crate) model: [Vec<f64>; 2],
}

pub(crate) fn speeds() -> Vec<Speed> {
    let mut noise = Noise::new(3);
    (0..9)
        .map(|i| {
            let speed = 30.0 + 5.0 * f64::from(i);
            let centre = 1.3 * (speed - 20.0);
            let flow: Vec<f64> = (0..400 + 200 * (i % 3))
                .map(|_| (centre + 9.0 * noise.normal()).max(0.0))
                .collect();
            let heads = flow
                .iter()
                .map(|&q| head(speed, q) + 0.6 * noise.normal())
                .collect();
            let x: Vec<f64> = ramp(100, 110.0);
            let y = x.iter().map(|&q| head(speed, q)).collect();
            Speed {
                speed_pct: speed,
                flow,
                head: heads,
                model: [x, y],
            }
        })
        .collect()
}

pub(crate) struct Run {
    pub(crate) time_s: Vec<f64>,
    pub(crate) level: [Vec<f64>; 2],
    pub(crate) flow: [Vec<f64>; 3],
    pub(crate) inflow: Vec<f64>,
    pub(crate) speed: Vec<f64>,
}

/// 6,000 s from 14,000 s on, as in chapter 4; measured, simulated (and static).
pub(crate) fn run(n: u32) -> Run {
    let mut noise = Noise::new(11);
    let mut out = Run {
        time_s: Vec::new(),
        level: [Vec::new(), Vec::new()],
        flow: [Vec::new(), Vec::new(), Vec::new()],
        inflow: Vec::new(),
        speed: Vec::new(),
    };
    let (mut speed, mut drift) = (55.0_f64, 0.0);
    for i in 0..n {
        let t = 14_000.0 + 6000.0 * f64::from(i) / f64::from(n);
        let stopped = (15_400.0..15_900.0).contains(&t) || (18_200.0..18_500.0).contains(&t);
        let goal = if stopped {
            8.0
        } else {
            58.0 + 6.0 * (t / 700.0).sin()
        };
        speed += 0.02 * (goal - speed);
        let flow = 1.35 * speed - 3.0;
        drift += 0.002 * noise.normal() + 0.0006;
        let level = 1250.0 + 25.0 * (t / 900.0).sin() - 0.4 * (speed - 55.0);
        out.time_s.push(t);
        out.level[0].push(level + 0.6 * noise.normal());
        out.level[1].push(level - 8.0 * drift);
        out.flow[0].push((flow + 1.3 * noise.normal()).max(0.0));
        out.flow[1].push(flow * 0.985 + 1.0);
        out.flow[2].push(flow * 0.985 + 1.05);
        out.inflow
            .push(flow + 2.0 * (t / 300.0).sin() + 0.8 * noise.normal());
        out.speed.push(speed);
    }
    out
}
