//! Random numbers: one ChaCha stream for every purpose, so that switching one effect
//! off leaves the noise of all the others as it was.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of uniform and normal numbers.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    rng: ChaCha8Rng,
    spare: Option<f64>,
}

impl Noise {
    /// Stream number `stream` of `seed`.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        Self { rng, spare: None }
    }

    /// A whole number, all of which are as likely.
    pub(crate) fn whole(&mut self) -> u64 {
        self.rng.next_u64()
    }

    /// Uniform in `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in `[low, high)`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// -1 or 1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }

    /// Standard normal (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        if let Some(z) = self.spare.take() {
            return z;
        }
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }
}

/// A slow wander around zero: an Ornstein-Uhlenbeck process, exact at any step.
#[derive(Debug, Clone)]
pub(crate) struct Wander {
    value: f64,
    sd: f64,
    time_constant_s: f64,
}

impl Wander {
    /// Starts from its stationary distribution.
    pub(crate) fn new(sd: f64, time_constant_s: f64, noise: &mut Noise) -> Self {
        Self {
            value: sd * noise.normal(),
            sd,
            time_constant_s,
        }
    }

    pub(crate) fn step(&mut self, dt_s: f64, noise: &mut Noise) -> f64 {
        let keep = (-dt_s / self.time_constant_s).exp();
        self.value = keep * self.value + self.sd * (1.0 - keep * keep).sqrt() * noise.normal();
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_mean_zero_and_unit_spread() {
        let mut noise = Noise::new(1, 2);
        let n = 100_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..n {
            let z = noise.normal();
            sum += z;
            squares += z * z;
        }
        assert!((sum / f64::from(n)).abs() < 0.02);
        assert!((squares / f64::from(n) - 1.0).abs() < 0.02);
    }

    #[test]
    fn streams_of_one_seed_differ() {
        assert_ne!(
            Noise::new(1, 1).unit().to_bits(),
            Noise::new(1, 2).unit().to_bits()
        );
    }
}
