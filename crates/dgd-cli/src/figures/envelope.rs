//! Runs that are too long to be held, for a drawing that is narrower than they are long.

use dgd_replay::{Pair, Replay};

/// Stretches of a drawn line, several a pixel of the widest drawing.
const STRETCHES: usize = 1 << 13;

/// What is drawn of a run whose rows come in parts: all of a short one, of a long one the mean of each stretch of time and,
/// for a moment at its start, its lowest and its highest value. In a drawing, where a line is the mean over time and a band
/// spans all values, that looks like the run itself.
pub(crate) struct Envelope {
    /// Samples of a stretch.
    stretch: usize,
    clock: Line,
    /// Level and flow measured and simulated, inflow and speed.
    lines: [Line; 6],
}

#[derive(Default)]
struct Line {
    /// Samples of the stretch that is not full.
    held: Vec<f64>,
    drawn: Vec<f64>,
}

impl Envelope {
    /// Of a run of so many samples at the most.
    pub(crate) fn new(samples: usize) -> Self {
        Self {
            stretch: samples.div_ceil(STRETCHES).max(1),
            clock: Line::default(),
            lines: Default::default(),
        }
    }

    /// Takes the next rows.
    pub(crate) fn add(&mut self, part: &Replay) {
        let (level, flow) = (&part.level_m, &part.pump_flow_m3_s);
        let series = [
            &level.measured,
            &level.simulated,
            &flow.measured,
            &flow.simulated,
            &part.inflow_m3_s,
            &part.speed_pct,
        ];
        self.clock.add(&part.time_s, self.stretch, moments);
        for (line, values) in self.lines.iter_mut().zip(series) {
            line.add(values, self.stretch, values_at);
        }
    }

    /// A run with the series that figures show, all of one length.
    pub(crate) fn finish(mut self) -> Replay {
        // A stretch that is not full, of one sample maybe.
        self.clock.end(moments);
        self.lines.iter_mut().for_each(|line| line.end(values_at));
        let time_s = self.clock.drawn;
        let [level, level_run, flow, flow_run, inflow_m3_s, speed_pct] =
            self.lines.map(|line| line.drawn);
        let pair = |measured, simulated| Pair {
            measured,
            simulated,
        };
        Replay {
            time_s,
            level_m: pair(level, level_run),
            pump_flow_m3_s: pair(flow, flow_run),
            inflow_m3_s,
            speed_pct,
            ..Replay::default()
        }
    }
}

impl Line {
    /// Takes the next values and draws the stretches that are full.
    fn add(&mut self, values: &[f64], stretch: usize, draw: fn(&[f64]) -> [f64; POINTS]) {
        if stretch == 1 {
            self.drawn.extend_from_slice(values);
            return;
        }
        self.held.extend_from_slice(values);
        let full = self.held.chunks_exact(stretch);
        let rest = full.remainder().len();
        self.drawn.extend(full.flat_map(draw));
        self.held.drain(..self.held.len() - rest);
    }

    fn end(&mut self, draw: fn(&[f64]) -> [f64; POINTS]) {
        if !self.held.is_empty() {
            self.drawn.extend(draw(&self.held));
        }
    }
}

/// Points that a stretch is drawn by: its mean, its ends, which take no time, and its mean until it ends.
const POINTS: usize = 5;

/// When the points of a stretch are.
fn moments(time_s: &[f64]) -> [f64; POINTS] {
    let (first, last) = (time_s[0], time_s[time_s.len() - 1]);
    [first, first, first, first, last]
}

/// The values of the points of a stretch; NaN if it has none.
fn values_at(stretch: &[f64]) -> [f64; POINTS] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut sum, mut count) = (0.0, 0.0);
    for v in stretch.iter().filter(|v| v.is_finite()) {
        (low, high) = (low.min(*v), high.max(*v));
        (sum, count) = (sum + v, count + 1.0);
    }
    if count == 0.0 {
        return [f64::NAN; POINTS];
    }
    let mean = sum / count;
    [mean, low, high, mean, mean]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(samples: usize, part: usize) -> Replay {
        let all: Vec<f64> = (0..samples).map(|i| i as f64).collect();
        let mut level = vec![1.0; samples];
        level[samples / 2] = 9.0;
        level[samples / 3] = -9.0;
        level[..samples / 4].fill(f64::NAN);
        let mut envelope = Envelope::new(samples);
        for from in (0..samples).step_by(part) {
            let here = from..samples.min(from + part);
            envelope.add(&Replay {
                time_s: all[here.clone()].to_vec(),
                level_m: Pair {
                    measured: level[here].to_vec(),
                    simulated: Vec::new(),
                },
                ..Replay::default()
            });
        }
        envelope.finish()
    }

    #[test]
    fn a_short_run_is_drawn_as_it_is() {
        let run = drawn(STRETCHES, 1000);
        assert_eq!(run.time_s.len(), STRETCHES);
        assert_eq!(run.level_m.measured[STRETCHES / 2], 9.0);
    }

    #[test]
    fn of_a_long_run_the_ends_are_kept_whatever_the_parts() {
        let samples = 3 * STRETCHES + 5;
        let run = drawn(samples, 700);
        assert!(run.time_s.len() <= POINTS * (STRETCHES + 1));
        assert_eq!(run.time_s.len(), run.level_m.measured.len());
        assert!(run.time_s.is_sorted());
        let kept = |v: f64| run.level_m.measured.contains(&v);
        assert!(kept(9.0) && kept(-9.0) && run.level_m.measured[0].is_nan());
        assert_eq!(run.time_s.last(), Some(&((samples - 1) as f64)));
        let other = drawn(samples, samples);
        assert_eq!(format!("{run:?}"), format!("{other:?}"));
    }

    #[test]
    fn a_stretch_is_its_mean_but_for_a_moment() {
        let stretch = [f64::NAN, 2.0, 8.0, 2.0];
        assert_eq!(values_at(&stretch), [4.0, 2.0, 8.0, 4.0, 4.0]);
        assert_eq!(moments(&[3.0, 4.0, 5.0, 6.0]), [3.0, 3.0, 3.0, 3.0, 6.0]);
        assert!(values_at(&[f64::NAN; 2]).iter().all(|v| v.is_nan()));
    }
}
