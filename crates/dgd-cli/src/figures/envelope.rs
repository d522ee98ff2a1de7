//! Runs that are too long to be held, for a drawing that is narrower than they are long.

use dgd_replay::{Pair, Replay};

/// Stretches of a drawn line, several a pixel of the widest drawing.
const STRETCHES: usize = 1 << 13;

/// What is drawn of a run whose rows come in parts: all of a short one, of a long one the lowest and the highest value of each stretch
/// of time, in the order in which they come.
pub(crate) struct Envelope {
    /// Samples of a stretch.
    stretch: usize,
    /// The clock, level and flow measured and simulated, inflow and speed.
    lines: [Line; 7],
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
            lines: Default::default(),
        }
    }

    /// Takes the next rows.
    pub(crate) fn add(&mut self, part: &Replay) {
        let (level, flow) = (&part.level_m, &part.pump_flow_m3_s);
        let series = [
            &part.time_s,
            &level.measured,
            &level.simulated,
            &flow.measured,
            &flow.simulated,
            &part.inflow_m3_s,
            &part.speed_pct,
        ];
        for (line, values) in self.lines.iter_mut().zip(series) {
            line.held.extend_from_slice(values);
            line.draw(self.stretch);
        }
    }

    /// A run with the series that figures show, all of one length.
    pub(crate) fn finish(mut self) -> Replay {
        // A stretch that is not full, of one sample maybe.
        for line in self.lines.iter_mut().filter(|line| !line.held.is_empty()) {
            line.drawn.extend(ends(&line.held));
        }
        let [
            time_s,
            level,
            level_run,
            flow,
            flow_run,
            inflow_m3_s,
            speed_pct,
        ] = self.lines.map(|line| line.drawn);
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
    /// Draws the stretches that are full.
    fn draw(&mut self, stretch: usize) {
        if stretch == 1 {
            self.drawn.append(&mut self.held);
            return;
        }
        let full = self.held.chunks_exact(stretch);
        let rest = full.remainder().len();
        self.drawn.extend(full.flat_map(ends));
        self.held.drain(..self.held.len() - rest);
    }
}

/// Lowest and highest value, the earlier one first; NaN if there is none.
fn ends(stretch: &[f64]) -> [f64; 2] {
    let mut found: Option<[(usize, f64); 2]> = None;
    for (i, v) in stretch.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        let [low, high] = found.get_or_insert([(i, *v); 2]);
        if *v < low.1 {
            *low = (i, *v);
        }
        if *v > high.1 {
            *high = (i, *v);
        }
    }
    match found {
        Some([low, high]) if low.0 <= high.0 => [low.1, high.1],
        Some([low, high]) => [high.1, low.1],
        None => [f64::NAN; 2],
    }
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
        assert!(run.time_s.len() <= 2 * STRETCHES + 2);
        assert_eq!(run.time_s.len(), run.level_m.measured.len());
        assert!(run.time_s.is_sorted());
        let kept = |v: f64| run.level_m.measured.contains(&v);
        assert!(kept(9.0) && kept(-9.0) && run.level_m.measured[0].is_nan());
        assert_eq!(run.time_s.last(), Some(&((samples - 1) as f64)));
        let other = drawn(samples, samples);
        assert_eq!(format!("{run:?}"), format!("{other:?}"));
    }
}
