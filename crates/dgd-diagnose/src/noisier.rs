//! What noise of the return flow's meter brings an effect by itself: fitted again to the recording with more of it.

use crate::cores::each;
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::tangent::Tangent;
use dgd_effects::STANDING_M3_S;
use dgd_lsq::dot;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// Draws of noise whose mean counts, each as it is and turned round, which cancels some of what it has in common with the recording by chance. Set by
/// hand: of fewer the mean depends on the draws.
const DRAWS: u64 = 4;

/// Evidence that each of some effects owes to the meter's noise, e-folds.
///
/// What a cause explains is explained less well the noisier the meter is. An effect that explains more then lives on the noise: it moves the reading
/// in time and so takes the mean of more of it, or leans on slopes that noise has flattened. As much as the same noise again adds, the meter's
/// own has added (simulation-extrapolation; Cook and Stefanski, J. Am. Stat. Assoc. 89, 1994, its straight line).
pub(crate) fn owed_to_meter_noise(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    effects: &[Applied],
) -> Vec<f64> {
    let explained = |draw: Option<(u64, f64)>| -> Vec<f64> {
        let noisier = draw.map(|(draw, times)| with_noise_again(record, draw, times));
        let of = noisier.as_ref().unwrap_or(record);
        let misfit = |applied: &[Applied]| {
            let off = gate.left_over_of(of, applied);
            0.5 * dot(&off, &off)
        };
        let without = misfit(state);
        let with = effects.iter().map(|one| misfit(&joined(state, one)));
        with.map(|with| without - with).collect()
    };
    let pairs = (0..DRAWS).flat_map(|draw| [Some((draw, 1.0)), Some((draw, -1.0))]);
    let draws = std::iter::once(None).chain(pairs);
    let mut all = each(draws.collect(), explained).into_iter();
    let as_read = all.next().unwrap_or_default();
    let noisier: Vec<Vec<f64>> = all.collect();
    let owed = as_read.iter().enumerate().map(|(k, now)| {
        let mean = noisier.iter().map(|of| of[k]).sum::<f64>() / noisier.len() as f64;
        (mean - now).max(0.0)
    });
    owed.collect()
}

/// The record with the noise of its flow meter once more, so many times as large, drawn anew where mud flows.
fn with_noise_again(record: &Record, draw: u64, times: f64) -> Record {
    let mut draws = ChaCha8Rng::seed_from_u64(draw);
    let mut unit = || (draws.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let size = times * record.setting.noise.flow_m3_s;
    let mut noisier = record.clone();
    let (read, filled) = (&mut noisier.flow, &mut noisier.filled.flow);
    for (read, filled) in read.iter_mut().zip(filled) {
        // Box and Muller.
        let error = size * (-2.0 * (1.0 - unit()).ln()).sqrt() * (TAU * unit()).cos();
        // Whether it flows is not for the noise to say.
        for flow in [read, filled] {
            if *flow > STANDING_M3_S {
                *flow += error;
            }
        }
    }
    noisier
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{owed_to_meter_noise, with_noise_again};
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, drilled, one};
    use dgd_effects::STANDING_M3_S;

    #[test]
    fn noise_comes_once_more_where_mud_flows_and_nowhere_else() {
        let mut record = drilled(Hidden::default());
        record.flow[3] = f64::NAN;
        (record.flow[5], record.filled.flow[5]) = (0.0, 0.0);
        let size = 2e-4;
        record.setting.noise.flow_m3_s = size;
        let noisier = with_noise_again(&record, 1, 1.0);
        assert!(noisier.flow[3].is_nan() && noisier.flow[5] == 0.0);
        let errors: Vec<f64> = (noisier.filled.flow.iter().zip(&record.filled.flow))
            .filter(|(_, was)| **was > STANDING_M3_S)
            .map(|(is, was)| is - was)
            .collect();
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let spread = (errors.iter().map(|v| v * v).sum::<f64>() / n).sqrt();
        assert!(mean.abs() < 4.0 * size / n.sqrt(), "{mean}");
        assert!(
            (spread / size - 1.0).abs() < 4.0 / (2.0 * n).sqrt(),
            "{spread}"
        );
        // The bridged reading errs as the reading does.
        assert_eq!(
            noisier.flow[7] - record.flow[7],
            noisier.filled.flow[7] - record.filled.flow[7]
        );
        assert_eq!(noisier.speed.len(), record.speed.len());
        // The same draw is the same noise, another is another.
        assert_eq!(
            noisier.filled.flow,
            with_noise_again(&record, 1, 1.0).filled.flow
        );
        assert_ne!(
            noisier.filled.flow,
            with_noise_again(&record, 2, 1.0).filled.flow
        );
    }

    #[test]
    fn a_meter_that_is_late_owes_nothing_and_one_that_only_seems_so_owes_what_noise_brings() {
        let owed = |late_s: f64, noise: f64| {
            let record = drilled(Hidden {
                late_s,
                ..Hidden::default()
            });
            let mut record = with_noise_again(&record, 9, noise / record.setting.noise.flow_m3_s);
            record.setting.noise.flow_m3_s = noise;
            let gate = Tangent::beside(&record, &[], &[], Bend::Lean).unwrap();
            owed_to_meter_noise(&record, &gate, &[], &[one("return_flow_delay", &[9.0])])[0]
        };
        assert_eq!(owed(9.0, 1e-4), 0.0);
        // More noise brings more, and far more where nothing is late.
        assert!(owed(0.0, 5e-4) > 100.0);
        assert!(owed(9.0, 5e-4) < 50.0);
    }
}
