//! How much weight the sets that were fitted deserve beside each other.
//!
//! Pseudo-Bayesian model averaging with the Bayesian bootstrap: Yao, Y., Vehtari, A., Simpson, D. and Gelman, A., *Bayesian
//! Analysis* 13 (2018), there pseudo-BMA+, with the logarithmic score of left-out blocks and the readings counted by the residual's
//! memory. It knows the sets that were fitted and no others: that the truth is among them is what [`tempered`] doubts, by what
//! the best of them leaves unexplained.

use crate::choice::{independent, stand_ins};
use crate::draws::Draws;
use crate::noise;
use crate::sets::Scored;
use std::collections::BTreeSet;

/// Weight below which an effect, what does as well in its place included, is not claimed.
pub(crate) const LIKELY: f64 = 0.5;
/// Draws of the bootstrap.
const DRAWS: usize = 500;

/// Weight of each set that is no larger than the chosen one and was not `refused`; they sum to one, the others have none.
pub(crate) fn weights(scored: &[Scored], chosen: usize, refused: &BTreeSet<usize>) -> Vec<f64> {
    let mut weights = vec![0.0; scored.len()];
    let Some(set) = scored.get(chosen) else {
        return weights;
    };
    let most = set.trial.members.len();
    // What is larger did not clear its hurdle.
    let rivals: Vec<usize> = (0..scored.len())
        .filter(|i| scored[*i].trial.members.len() <= most && !refused.contains(i))
        .collect();
    let of = |&i: &usize| scored[i].left.blocks.as_slice();
    let blocks: Vec<&[f64]> = rivals.iter().map(of).collect();
    let freedom = rivals.iter().map(|&i| scored[i].trial.paths.len() as f64);
    let readings = independent(&set.trial).max(2.0);
    let found = average(&blocks, &freedom.collect::<Vec<_>>(), readings);
    for (i, w) in rivals.into_iter().zip(found) {
        weights[i] = w;
    }
    weights
}

/// Weight of each member of the chosen set, what does as well in its place included.
pub(crate) fn of_members(
    scored: &[Scored],
    chosen: usize,
    refused: &BTreeSet<usize>,
) -> Vec<(usize, f64)> {
    let weights = weights(scored, chosen, refused);
    let members = &scored[chosen].trial.members;
    let of = |&member: &usize| {
        let mut names = stand_ins(scored, chosen, member);
        names.push(member);
        let holds = |s: &Scored| s.trial.members.iter().any(|m| names.contains(m));
        let weight: f64 = scored
            .iter()
            .zip(&weights)
            .filter(|(s, _)| holds(s))
            .map(|(_, w)| w)
            .sum();
        (member, weight.min(1.0))
    };
    members.iter().map(of).collect()
}

/// Surest that anything is said to be.
const SUREST: f64 = 0.98;

/// A weight among the fitted sets, less what speaks against all of them: that the gain is chance, and that the truth is none of
/// them. The latter by squares: what the effect takes, beside that and what stays unexplained.
///
/// - `loss`: square that comes back without it, and its standard error, as shares of what is left.
/// - `unexplained`: share of what is left that is no noise.
pub(crate) fn tempered(weight: f64, loss: (f64, f64), unexplained: f64) -> f64 {
    let (loss, error) = loss;
    if !(loss > 0.0) {
        return 0.0;
    }
    let surely = 1.0 - noise::upper_tail(loss / error.max(1e-12 * loss));
    let share = loss / (loss + unexplained.max(0.0));
    (weight * surely * share).min(SUREST)
}

/// Line from the logit of a tempered weight to that of a probability: logistic regression on 24 findings in recordings for building
/// alone, and one right and one wrong more at either end. Those four are a uniform prior for how often what stands there is right
/// (Bedrick, E. J., Christensen, R. and Johnson, W., *J. Am. Stat. Assoc.* 91, 1996): with a dozen findings at an end, a share that is
/// told from fewer must be less bold. The findings and the regression stand in this module's tests.
const LINE: (f64, f64) = (-0.87, 0.58);
/// Logits are those of weights within a hundredth of 0 and 1.
const END: f64 = 0.01;

/// How often what has such a weight was right.
pub(crate) fn calibrated(weight: f64) -> f64 {
    let w = weight.clamp(END, 1.0 - END);
    let logit = LINE.0 + LINE.1 * (w / (1.0 - w)).ln();
    1.0 / (1.0 + (-logit).exp())
}

/// Share of the squares left below which what an effect takes is little.
const LITTLE: f64 = 0.1;

/// The weight of a member that is not to be claimed: less than a half, or of little worth and less than a half once what stays
/// unexplained is counted. Whatever is wrong with the rest can be bent to take a little.
pub(crate) fn unlikely(weight: f64, loss: (f64, f64), unexplained: f64) -> Option<f64> {
    if weight < LIKELY {
        return Some(weight);
    }
    let counted = tempered(weight, loss, unexplained);
    (loss.0 < LITTLE && counted < LIKELY).then_some(counted)
}

/// - `blocks`: squares of each set by block, of equal lengths.
/// - `freedom`: parameters of each.
fn average(blocks: &[&[f64]], freedom: &[f64], readings: f64) -> Vec<f64> {
    let count = blocks.first().map_or(0, |b| b.len());
    let mut sum = vec![0.0; blocks.len()];
    let mut draws = Draws::new(13, 0);
    for _ in 0..DRAWS {
        let share: Vec<f64> = (0..count).map(|_| draws.exponential()).collect();
        let price: Vec<f64> = blocks
            .iter()
            .zip(freedom)
            .map(|(b, p)| {
                let square: f64 = b.iter().zip(&share).map(|(b, s)| b * s).sum();
                0.5 * readings * square.max(1e-300).ln() + p
            })
            .collect();
        let least = price.iter().copied().fold(f64::INFINITY, f64::min);
        let likely: Vec<f64> = price.iter().map(|p| (least - p).exp()).collect();
        let total: f64 = likely.iter().sum();
        for (s, l) in sum.iter_mut().zip(&likely) {
            *s += l / total / DRAWS as f64;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_that_is_better_everywhere_has_all_the_weight_and_twins_share_it() {
        let (good, bad) = (vec![1.0; 24], vec![4.0; 24]);
        let found = average(&[&good, &bad], &[2.0, 2.0], 100.0);
        assert!(found[0] > 0.999 && (found.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        let twins = average(&[&good, &good], &[2.0, 2.0], 100.0);
        assert!((twins[0] - 0.5).abs() < 1e-9);
    }

    /// A set with the same square in each of 24 blocks.
    fn set(members: &[usize], square: f64) -> Scored {
        use crate::validate::LeftOut;
        use dgd_lsq::lm::{Bounds, Ending, Minimum};
        let residuals: Vec<f64> = (0..480u32).map(|i| f64::from(i * i % 7) - 3.0).collect();
        Scored {
            trial: crate::context::Trial {
                members: members.to_vec(),
                paths: vec![String::new(); members.len()],
                bounds: Bounds::default(),
                minimum: Minimum {
                    theta: Vec::new(),
                    residuals,
                    cost: square,
                    jacobian: nalgebra::DMatrix::zeros(0, 0),
                    steps: 0,
                    ending: Ending::Converged,
                },
            },
            left: LeftOut {
                blocks: vec![square; 24],
                count: 480.0,
                by_output: Vec::new(),
                thetas: Vec::new(),
            },
        }
    }

    #[test]
    fn what_does_as_well_in_a_members_place_lends_it_its_weight_and_what_does_better_takes_it() {
        let weight = |scored: &[Scored], chosen: usize, member: usize| {
            let all = of_members(scored, chosen, &BTreeSet::new());
            all.into_iter()
                .find(|m| m.0 == member)
                .map_or(f64::NAN, |m| m.1)
        };
        let twins = [set(&[], 4.0), set(&[1], 1.0), set(&[2], 1.0)];
        assert!(weight(&twins, 1, 1) > 0.99);
        // Another that does clearly better without 2, beside something else.
        let beaten = [
            set(&[], 4.0),
            set(&[1], 1.0),
            set(&[1, 2], 0.9),
            set(&[1, 3], 0.95),
            set(&[3, 4], 0.6),
        ];
        assert!(weight(&beaten, 2, 2) < LIKELY);
        // Where it is at best a tie with the smaller set.
        let idle = [set(&[], 4.0), set(&[1], 1.0), set(&[1, 2], 1.0)];
        assert!(weight(&idle, 2, 1) > 0.99);
        assert!(weight(&idle, 2, 2) < LIKELY);
    }

    #[test]
    fn what_does_worse_than_an_empty_place_is_no_stand_in_though_few_blocks_decide() {
        use crate::choice::{stand_ins, untold};
        // All the squares sit in one block: their standard error is as large as they are.
        let crowded = |members: &[usize], square: f64| {
            let mut one = set(members, 1.0);
            one.left.blocks[3] += square;
            one
        };
        let scored = [
            crowded(&[], 100.0),
            crowded(&[1], 0.0),
            crowded(&[2], 500.0),
            crowded(&[3], 30.0),
            crowded(&[4], 60.0),
        ];
        assert!(scored.iter().all(|s| untold(s, &scored[1])));
        assert_eq!(stand_ins(&scored, 1, 1), [3]);
    }

    #[test]
    fn what_is_outweighed_by_what_stays_unexplained_is_not_sure_however_it_beats_the_other_sets() {
        assert_eq!(tempered(1.0, (2.0, 0.2), 0.0), SUREST);
        assert!((tempered(1.0, (2.0, 0.2), 0.5) - 0.8).abs() < 1e-9);
        assert!(tempered(1.0, (0.1, 0.01), 0.9) < 0.2);
        // Its gain is one standard error.
        assert!((tempered(1.0, (1.0, 1.0), 0.0) - 0.841_345).abs() < 1e-5);
        assert_eq!(tempered(1.0, (-0.1, 1.0), 0.0), 0.0);
    }

    #[test]
    fn a_greater_weight_is_a_greater_probability_and_none_is_certain() {
        let weights = [0.0, 0.02, 0.3, 0.6, 0.9, SUREST];
        let found = weights.map(calibrated);
        assert!(found.windows(2).all(|p| p[0] < p[1]), "{found:?}");
        assert!(found[0] > 0.0 && found[5] < SUREST, "{found:?}");
    }

    /// Tempered weight of each finding, and whether it was right: 16 of seed 4201, 8 of seed 4202 of the benches.
    const FOUND: [(f64, bool); 24] = [
        (0.98, true),
        (0.85, false),
        (0.47, false),
        (0.98, false),
        (0.28, false),
        (0.98, true),
        (0.55, false),
        (0.98, true),
        (0.98, true),
        (0.76, true),
        (0.75, true),
        (0.96, true),
        (0.98, true),
        (0.98, true),
        (0.61, false),
        (0.98, true),
        (0.98, true),
        (0.60, false),
        (0.36, false),
        (0.32, false),
        (0.77, false),
        (0.18, false),
        (0.93, true),
        (0.98, true),
    ];

    /// Newton's steps to the line of greatest likelihood.
    fn regression(found: &[(f64, bool)]) -> (f64, f64) {
        let (mut a, mut b) = (0.0, 0.0);
        for _ in 0..200 {
            let mut slope = [0.0; 2];
            let mut bend = [0.0; 3];
            for (weight, right) in found {
                let x = (weight / (1.0 - weight)).ln();
                let p = 1.0 / (1.0 + (-(a + b * x)).exp());
                let off = f64::from(u8::from(*right)) - p;
                slope = [slope[0] + off, slope[1] + off * x];
                let w = p * (1.0 - p);
                bend = [bend[0] + w, bend[1] + w * x, bend[2] + w * x * x];
            }
            let det = bend[0] * bend[2] - bend[1] * bend[1];
            a += 0.5 * (bend[2] * slope[0] - bend[1] * slope[1]) / det;
            b += 0.5 * (bend[0] * slope[1] - bend[1] * slope[0]) / det;
        }
        (a, b)
    }

    #[test]
    fn the_line_is_that_of_the_findings_with_one_right_and_one_wrong_more_at_either_end() {
        let mut found = FOUND.to_vec();
        let bold = regression(&found);
        for end in [SUREST, 1.0 - SUREST] {
            found.extend([(end, true), (end, false)]);
        }
        let (a, b) = regression(&found);
        assert!(
            (a - LINE.0).abs() < 0.01 && (b - LINE.1).abs() < 0.01,
            "{a} {b}"
        );
        // Of twelve at the upper end eleven were right.
        let surest = FOUND.iter().filter(|f| f.0 > 0.9);
        let right = surest.clone().filter(|f| f.1).count() as f64 / surest.count() as f64;
        let top = (SUREST / (1.0 - SUREST)).ln();
        let without = 1.0 / (1.0 + (-(bold.0 + bold.1 * top)).exp());
        assert!(
            calibrated(SUREST) < right && right < without,
            "{right} {without}"
        );
    }

    #[test]
    fn a_little_beside_much_that_stays_unexplained_is_not_claimed() {
        assert_eq!(unlikely(0.4, (2.0, 0.1), 0.0), Some(0.4));
        assert!(unlikely(0.9, (0.05, 0.01), 0.3).is_some_and(|w| w < 0.2));
        // The same where all is explained, and what is worth much.
        assert_eq!(unlikely(0.9, (0.05, 0.01), 0.0), None);
        assert_eq!(unlikely(0.9, (0.2, 0.05), 0.9), None);
    }

    #[test]
    fn a_set_that_is_better_in_one_block_only_is_not_sure() {
        let plain = vec![1.0; 24];
        let mut lucky = vec![1.01; 24];
        lucky[7] = 0.2;
        let found = average(&[&lucky, &plain], &[2.0, 2.0], 200.0);
        assert!(found[0] > 0.5 && found[0] < 0.95, "{found:?}");
    }
}
