//! What the operator does: straight lines between knots at moments of samples, so that samples joined by straight lines are exact.

use super::SAMPLING_S;
use crate::noise::Noise;

/// The whole number of samples nearest to a time, at least one; in s.
fn samples(time_s: f64) -> f64 {
    (time_s / SAMPLING_S).round().max(1.0) * SAMPLING_S
}

/// A signal that goes in straight lines from knot to knot.
#[derive(Debug, Clone, PartialEq)]
pub struct Programme {
    /// Time in s and value, in order of time; before the first and after the last the value stands.
    pub knots: Vec<(f64, f64)>,
}

impl Programme {
    /// Always the same.
    pub fn steady(value: f64) -> Programme {
        Programme {
            knots: vec![(0.0, value)],
        }
    }

    /// The value at a time in s.
    pub fn at(&self, time_s: f64) -> f64 {
        let next = self.knots.partition_point(|k| k.0 <= time_s);
        match (
            next.checked_sub(1).map(|i| self.knots[i]),
            self.knots.get(next),
        ) {
            (Some((t0, a)), Some(&(t1, b))) => a + (b - a) * (time_s - t0) / (t1 - t0),
            (Some((_, a)), None) => a,
            (None, Some(&(_, b))) => b,
            (None, None) => 0.0,
        }
    }

    /// Moves to a new value every `hold` seconds, in `ramp` seconds; between two moves, and now and then, by little.
    pub(crate) fn moves(
        length_s: f64,
        range: (f64, f64),
        hold_s: (f64, f64),
        ramp_s: (f64, f64),
        noise: &mut Noise,
    ) -> Programme {
        let span = range.1 - range.0;
        let mut value = noise.between(range.0 + 0.3 * span, range.1 - 0.3 * span);
        let mut knots = vec![(0.0, value)];
        let mut time_s = samples(20.0);
        while time_s < length_s {
            knots.push((time_s, value));
            let ramp = samples(noise.between(ramp_s.0, ramp_s.1));
            // Every third move or so is a trim, which a sticking valve does not follow.
            value = if noise.unit() < 0.35 {
                let trim = 0.08 * span * noise.sign();
                (value + trim).clamp(range.0, range.1)
            } else {
                noise.between(range.0, range.1)
            };
            time_s += ramp;
            knots.push((time_s, value));
            time_s += samples(noise.between(hold_s.0, hold_s.1));
        }
        Programme { knots }
    }

    /// Wanders slowly around a value.
    pub(crate) fn wander(length_s: f64, mean: f64, sd: f64, noise: &mut Noise) -> Programme {
        let (mut knots, mut time_s) = (Vec::new(), 0.0);
        let every_s = samples(12.0);
        let mut wander = crate::noise::Wander::new(sd, 600.0, noise);
        while time_s < length_s {
            knots.push((time_s, mean + wander.step(every_s, noise)));
            time_s += every_s;
        }
        Programme { knots }
    }
}
