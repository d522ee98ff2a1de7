//! How many samples tell as much as one: residuals of rigs hang together for seconds to minutes.

/// Samples of a block, whose mean says what is left where noise would have averaged out.
const BLOCK: usize = 256;
/// Blocks that are looked at, evenly spread; a block is shorter where the recording has not so many.
const BLOCKS: usize = 64;
/// Shortest block.
const SHORTEST: usize = 8;

/// Samples that tell as much as one independent sample, at least 1: the variance of the mean of a block of residuals over what it would be
/// were they independent.
///
/// `residual` gives that of a sample, `None` where none was used. What hangs together for longer than a block (256 samples, or a 64th of
/// the recording) counts as a block at the most.
pub(crate) fn correlation_samples(samples: usize, residual: impl Fn(usize) -> Option<f64>) -> f64 {
    let block = (samples / BLOCKS).clamp(SHORTEST, BLOCK);
    let stride = (samples / BLOCKS).max(block);
    // Sums of a block: how many, their sum, the sum of their squares.
    let sums: Vec<(f64, f64, f64)> = (0..samples)
        .step_by(stride)
        .map(|from| {
            let there = (from..(from + block).min(samples)).filter_map(&residual);
            let finite = there.filter(|r| r.is_finite());
            finite.fold((0.0, 0.0, 0.0), |(n, s, ss), r| {
                (n + 1.0, s + r, ss + r * r)
            })
        })
        // Of a block that is mostly missing the mean says little.
        .filter(|(n, ..)| *n >= 0.5 * block as f64)
        .collect();
    if sums.len() < SHORTEST {
        return 1.0;
    }
    let total = sums.iter().fold((0.0, 0.0, 0.0), |all, one| {
        (all.0 + one.0, all.1 + one.1, all.2 + one.2)
    });
    let mean = total.1 / total.0;
    let variance = total.2 / total.0 - mean * mean;
    let between: f64 = (sums.iter())
        .map(|(n, s, _)| n * (s / n - mean).powi(2))
        .sum::<f64>()
        / (sums.len() - 1) as f64;
    let times = between / variance;
    if times > 1.0 { times } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, correlation_samples};

    /// Noise of which each sample keeps a share of the one before.
    fn noise(share: f64, samples: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut uniform = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut last = 0.0;
        (0..samples)
            .map(|_| {
                last = share * last + uniform();
                last
            })
            .collect()
    }

    #[test]
    fn as_many_samples_tell_as_much_as_one_as_their_noise_hangs_together() {
        for (share, expected) in [(0.0, 1.0), (0.5, 3.0), (0.9, 19.0), (0.97, 65.7)] {
            let found: Vec<f64> = (1..=40)
                .map(|seed| {
                    let noise = noise(share, 40_000, 77 * seed);
                    correlation_samples(noise.len(), |i| Some(noise[i]))
                })
                .collect();
            let mean = found.iter().sum::<f64>() / found.len() as f64;
            // What is left of the memory at the ends of a block is not seen.
            let seen = expected * (1.0 - expected / BLOCK as f64);
            assert!(
                (0.9 * seen..1.15 * expected.max(1.05)).contains(&mean),
                "{share}: {mean}"
            );
        }
    }

    #[test]
    fn what_says_nothing_of_a_memory_is_taken_for_independent() {
        assert_eq!(correlation_samples(0, |_| None), 1.0);
        assert_eq!(correlation_samples(10_000, |_| None), 1.0);
        assert_eq!(correlation_samples(10_000, |_| Some(3.0)), 1.0);
        assert_eq!(correlation_samples(40, |i| Some(i as f64)), 1.0);
        assert_eq!(correlation_samples(10_000, |_| Some(f64::NAN)), 1.0);
    }
}
