//! Blocks of samples whose signs are drawn in the gate's null, fine for whitened residuals and coarse for plain ones.

use crate::draws::Draws;
use crate::stack::Data;
use crate::tangent::dot;

pub(crate) struct Blocks {
    fine: Vec<usize>,
    coarse: Vec<usize>,
    fine_count: usize,
    coarse_count: usize,
}

/// Draws of the null.
const DRAWS: usize = 999;

impl Blocks {
    /// `memory`: samples over which the residual remembers itself.
    pub(crate) fn new(data: &Data, memory: usize) -> Self {
        let n = data.samples().max(1);
        let fine_length = 5.max(n.div_ceil(200));
        // Not so long that fewer than 12 signs are drawn.
        let coarse_length = (3 * memory).max(n.div_ceil(60)).min(n.div_ceil(12)).max(1);
        let number = |length: usize| -> Vec<usize> {
            data.rows
                .iter()
                .map(|r| data.position(r) / length)
                .collect()
        };
        Self {
            fine: number(fine_length),
            coarse: number(coarse_length),
            fine_count: n.div_ceil(fine_length),
            coarse_count: n.div_ceil(coarse_length),
        }
    }

    pub(crate) fn fine(&self, a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
        sums(&self.fine, self.fine_count, a, b, factor)
    }

    pub(crate) fn coarse(&self, a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
        sums(&self.coarse, self.coarse_count, a, b, factor)
    }
}

fn sums(number: &[usize], count: usize, a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
    let mut out = vec![0.0; count];
    for (i, &k) in number.iter().enumerate() {
        out[k] += factor * a[i] * b[i];
    }
    out
}

/// Probability that the greatest score of all directions is as great when the residual has nothing to do with any of
/// them: signs of blocks drawn anew, 999 times.
///
/// - `groups`: for each hypothesis, block sums of unit directions times residual; the squares of its directions add up.
pub(crate) fn null_probability<'a>(
    groups: impl Iterator<Item = Vec<&'a [f64]>> + Clone,
    stream: u64,
) -> f64 {
    let statistic = |signs: Option<&[f64]>| -> f64 {
        let mut greatest = 0.0_f64;
        for group in groups.clone() {
            let score: f64 = group
                .iter()
                .map(|sums| match signs {
                    Some(signs) => dot(sums, signs).powi(2),
                    None => sums.iter().sum::<f64>().powi(2),
                })
                .sum();
            greatest = greatest.max(score);
        }
        greatest
    };
    let Some(count) = groups.clone().flatten().map(<[f64]>::len).max() else {
        return 1.0;
    };
    let observed = statistic(None);
    let mut draws = Draws::new(7, stream);
    let mut reached = 1;
    for _ in 0..DRAWS {
        let signs: Vec<f64> = (0..count).map(|_| draws.sign()).collect();
        if statistic(Some(&signs)) >= observed {
            reached += 1;
        }
    }
    f64::from(reached) / (DRAWS + 1) as f64
}
