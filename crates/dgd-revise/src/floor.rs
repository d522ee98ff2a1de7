//! How far a residual lies above the noise of its instrument, told by differences of neighbours: what is left out moves slowly along
//! time or along some quantity of the system, noise does not.
//!
//! Differences: von Neumann, J., *Annals of Mathematical Statistics* 12 (1941); clipped, as steps are no noise (Huber).

use crate::context::{Context, Trial};
use crate::empirical;
use crate::noise::{self, Noise};
use crate::stack::Data;

/// Values of a quantity by window and sample, under its name.
pub(crate) type Quantities = [(String, Vec<Vec<f64>>)];

/// One instrument's residual beside its noise, in the units of the residual given.
#[derive(Debug, Clone)]
pub(crate) struct Level {
    pub output: usize,
    pub rms: f64,
    /// Noise by differences; at least what the reading's steps make.
    pub floor: f64,
    pub readings: usize,
    /// Probability of the residual's memory (Ljung-Box) if it were white, times the number of instruments.
    pub memory: f64,
    /// Whether its memory may be the instrument's own: a short autoregression leaves it white, and no other instrument shares
    /// what it leaves.
    pub own: bool,
    /// No more than rounding and the solver leave, beside what the reading does.
    pub rounding: bool,
}

/// Not looked into: root mean square over noise, all instruments together.
pub(crate) const NOTHING: f64 = 1.03;
/// Too small to matter unless it has a name. Clean recordings come to 1.055, as the least of many measures of the noise is taken.
pub(crate) const SMALL: f64 = 1.1;
/// Left by a set beside which no further effect is looked for: what clean recordings come to.
pub(crate) const SETTLED: f64 = 1.06;
/// Never consistent: root mean square over noise, and the probability of its memory.
const FAR: (f64, f64) = (1.5, 1e-6);
/// A model that leaves more than this times the noise explains in part.
const POOR: f64 = 2.0;
/// Probability below which two instruments share what autoregressions leave.
const SHARED: f64 = 1e-3;
/// Samples by which one instrument may be behind another.
const BEHIND: usize = 10;
/// Share of a reading's deviation that solver and rounding may take.
const ROUNDING: f64 = 1e-4;

impl Level {
    pub(crate) fn ratio(&self) -> f64 {
        if self.rms > 0.0 {
            self.rms / self.floor.max(1e-300)
        } else {
            1.0
        }
    }

    /// Far above the noise, and remembering itself.
    pub(crate) fn far(&self) -> bool {
        self.ratio() > FAR.0 && self.memory < FAR.1 && !self.rounding
    }

    /// The same, and not as an instrument alone does.
    pub(crate) fn unexcused(&self) -> bool {
        self.far() && !self.own
    }

    pub(crate) fn poor(&self) -> bool {
        self.ratio() > POOR && !self.rounding
    }
}

/// Whether what is left of all instruments together is at most `share` of the noise, of each that to chance, and remembers
/// nothing.
pub(crate) fn too_small(levels: &[&Level], share: f64) -> bool {
    let square = |l: &&Level| l.ratio().powi(2);
    let pooled = levels.iter().map(square).sum::<f64>() / levels.len().max(1) as f64;
    let each = |l: &&Level| {
        // The ratio of white noise has a standard deviation of a half over the root of the readings.
        let chance = 2.5 * 0.5 / (l.readings as f64).sqrt();
        l.ratio() <= share + chance && l.memory >= FAR.1
    };
    pooled.sqrt() <= share && levels.iter().all(each)
}

/// Share of the squares of all instruments together that is no noise, a few per cent let pass.
pub(crate) fn unexplained(levels: &[Level]) -> f64 {
    let (mut all, mut noise) = (0.0, 0.0);
    for l in levels.iter().filter(|l| !l.rounding) {
        let readings = l.readings as f64;
        all += readings * l.rms.powi(2);
        noise += readings * (SMALL * l.floor).min(l.rms).powi(2);
    }
    if all > 0.0 { 1.0 - noise / all } else { 0.0 }
}

/// Levels of a fitted base, of each instrument that was recorded.
pub(crate) fn levels(
    context: &Context<'_>,
    trial: &Trial,
    noise: &Noise,
    residual: &[f64],
) -> Vec<Level> {
    let data = context.data;
    let quantities = empirical::quantities(context, data, &trial.members, &trial.minimum.theta)
        .unwrap_or_default();
    let mut levels = plain(
        data,
        residual,
        context.scale.len(),
        &context.scale,
        &quantities,
    );
    let white = noise.whiten(data, residual);
    let innovations: Vec<Vec<Option<f64>>> = levels
        .iter()
        .map(|l| by_position(data, &white, l.output))
        .collect();
    let count = levels.len() as f64;
    for k in 0..levels.len() {
        let rows: Vec<f64> = innovations[k].iter().flatten().copied().collect();
        let (_, deviate) = noise::portmanteau(&rows, noise::lags(rows.len()));
        let alone = |other: usize| {
            other == k || shared(&innovations[k], &innovations[other]) * (count - 1.0) >= SHARED
        };
        levels[k].own = count * noise::upper_tail(deviate) >= FAR.1 && (0..levels.len()).all(alone);
    }
    levels
}

/// Levels of any residual, each memory taken for its instrument's own.
///
/// - `scale`: by which each output's residual is divided.
pub(crate) fn plain(
    data: &Data,
    residual: &[f64],
    outputs: usize,
    scale: &[f64],
    quantities: &Quantities,
) -> Vec<Level> {
    let of = |output: usize| {
        let rows = data.of_output(output);
        if rows.len() < 3 {
            return None;
        }
        let values: Vec<f64> = rows.iter().map(|&i| residual[i]).collect();
        let mut floor = by_differences(&values);
        // What changes with a quantity from sample to sample looks like noise along time.
        for (_, quantity) in quantities {
            let mut order: Vec<(f64, f64)> = rows
                .iter()
                .map(|&i| {
                    let row = &data.rows[i];
                    (quantity[row.window][row.sample], residual[i])
                })
                .collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0));
            let values: Vec<f64> = order.into_iter().map(|o| o.1).collect();
            floor = floor.min(by_differences(&values));
        }
        let (_, deviate) = noise::portmanteau(&values, noise::lags(values.len()));
        let measured: Vec<f64> = rows.iter().map(|&i| data.measured[i]).collect();
        let rms = root_mean_square(&values);
        Some(Level {
            output,
            rms,
            floor: floor.max(step(&measured) / 12.0_f64.sqrt() / scale[output]),
            readings: rows.len(),
            memory: outputs as f64 * noise::upper_tail(deviate),
            own: true,
            rounding: rms * scale[output] <= ROUNDING * deviation(&measured),
        })
    };
    (0..outputs).filter_map(of).collect()
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    root_mean_square(&values.iter().map(|v| v - mean).collect::<Vec<_>>())
}

/// Standard deviation of noise on something that hardly moves from one value to the next.
fn by_differences(values: &[f64]) -> f64 {
    let d: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    let most = CLIP * noise::robust(&d);
    let clipped: Vec<f64> = d.iter().map(|d| d.clamp(-most, most)).collect();
    root_mean_square(&clipped) / (2.0 * CLIPPED).sqrt()
}

/// Differences count up to so many of their standard deviations, and the mean square of a standard normal number that is
/// clipped there.
const CLIP: f64 = 3.0;
const CLIPPED: f64 = 0.995_016;

/// Step of a reading that takes few values, 0 if it takes many.
fn step(measured: &[f64]) -> f64 {
    let mut values = measured.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    if 2 * values.len() > measured.len() {
        return 0.0;
    }
    let mut gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    gaps.get(gaps.len() / 2).copied().unwrap_or(0.0)
}

/// An output's values by position over all windows; `None` where nothing was read.
fn by_position(data: &Data, values: &[f64], output: usize) -> Vec<Option<f64>> {
    let mut all = vec![None; data.samples()];
    for (row, v) in data.rows.iter().zip(values) {
        if row.output == output {
            all[data.position(row)] = Some(*v);
        }
    }
    all
}

/// Probability of the greatest correlation of two white sequences, either up to ten samples behind the other.
fn shared(a: &[Option<f64>], b: &[Option<f64>]) -> f64 {
    let tail = |x: &[Option<f64>], y: &[Option<f64>]| -> f64 {
        let (mut xy, mut xx, mut yy, mut n) = (0.0, 0.0, 0.0, 0.0);
        for (x, y) in x.iter().zip(y) {
            if let (Some(x), Some(y)) = (x, y) {
                (xy, xx, yy, n) = (xy + x * y, xx + x * x, yy + y * y, n + 1.0);
            }
        }
        let r = xy / (xx * yy).sqrt().max(1e-300);
        2.0 * noise::upper_tail(r.abs() * f64::sqrt(n))
    };
    let mut least = 1.0_f64;
    for k in 0..=BEHIND.min(a.len().saturating_sub(3)) {
        least = least.min(tail(&a[k..], b));
        least = least.min(tail(a, &b[k..]));
    }
    (2 * BEHIND + 1) as f64 * least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::Draws;

    /// Near enough to normal.
    fn normal(draws: &mut Draws) -> f64 {
        let unit = |d: &mut Draws| d.below(1 << 20) as f64 / f64::from(1 << 20);
        (0..12).map(|_| unit(draws)).sum::<f64>() - 6.0
    }

    #[test]
    fn differences_see_the_noise_beneath_a_swing_and_a_step() {
        let mut draws = Draws::new(3, 0);
        let swing: Vec<f64> = (0..2000)
            .map(|i| {
                let t = f64::from(i);
                normal(&mut draws) + 5.0 * (0.02 * t).sin() + if i > 900 { 40.0 } else { 0.0 }
            })
            .collect();
        let found = by_differences(&swing);
        assert!((found - 1.0).abs() < 0.05, "{found}");
        assert!(root_mean_square(&swing) > 20.0);
    }

    #[test]
    fn an_instrument_of_four_readings_keeps_nothing_from_being_small() {
        let mut draws = Draws::new(4, 0);
        let many: Vec<f64> = (0..400).map(|_| normal(&mut draws)).collect();
        let mut few = vec![f64::NAN; 400];
        for (k, v) in [0.5, -0.6, 0.4, -0.3].into_iter().enumerate() {
            few[100 * k] = v;
        }
        let data = Data::training(vec![dgd_assembly::Window {
            time: (0..400).map(f64::from).collect(),
            readings: vec![many, few],
            ..dgd_assembly::Window::default()
        }]);
        let levels = plain(&data, &data.measured, 2, &[1.0, 1.0], &Vec::new());
        assert_eq!(levels[1].readings, 4);
        assert!(too_small(&[&levels[0], &levels[1]], SMALL), "{levels:?}");
    }

    #[test]
    fn a_reading_of_few_values_is_no_better_than_its_step() {
        let coarse: Vec<f64> = (0..100).map(|i| 0.5 * f64::from(i / 20)).collect();
        assert_eq!(step(&coarse), 0.5);
        let fine: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(step(&fine), 0.0);
    }

    #[test]
    fn what_two_instruments_share_is_seen_though_one_is_behind() {
        let mut draws = Draws::new(5, 0);
        let a: Vec<f64> = (0..400).map(|_| normal(&mut draws)).collect();
        let alone: Vec<Option<f64>> = (0..400).map(|_| Some(normal(&mut draws))).collect();
        let behind: Vec<Option<f64>> = (0..400)
            .map(|i| Some(normal(&mut draws) + if i < 3 { 0.0 } else { 0.4 * a[i - 3] }))
            .collect();
        let a: Vec<Option<f64>> = a.into_iter().map(Some).collect();
        assert!(shared(&a, &behind) < SHARED && shared(&behind, &a) < SHARED);
        assert!(shared(&a, &alone) > SHARED);
    }
}
