//! How errors of the return flow meter show in friction and head: through the slopes of their curves.

use super::Tangent;
use crate::layout::Section;
use crate::numbers::{mean, whole};
use crate::record::Record;
use crate::relations::Blocks;
use dgd_effects::Quantity;
use dgd_lsq::Accumulator;

/// Terms of the flow that speed and inlet pressure tell: powers of both to the third.
const TERMS: usize = 10;

impl Tangent {
    /// What errors of the flow meter make of the rows of friction or head, stacked; `None` of other rows, and where speed and inlet pressure do not
    /// tell the flow.
    ///
    /// The errors are what the meter reads beside the flow that goes with each speed and level: a pump and its line have one at each. They come
    /// through the slope of the curve, whose argument they are in, so that whatever stands for the flow without that noise, as level and speed do,
    /// explains them (errors in variables; Fuller 1987, chapter 1) and is no cause. What is a law of that very quantity, `along`, is none of them.
    pub(crate) fn flow_errors(
        &self,
        record: &Record,
        section: Section,
        along: Quantity,
    ) -> Option<Vec<f64>> {
        let ground = self.ground(record);
        let (b, curves) = (ground.blocks(), &self.curves);
        let slope = |f: &dyn Fn(f64) -> f64, q: f64| (f(1.01 * q) - f(0.99 * q)) / (0.02 * q);
        let answer = |k: usize| match section {
            Section::Friction => {
                Some(b.friction_factor[k] * slope(&|q| curves.friction_pa(q), b.flow[k]))
            }
            Section::Head => {
                let of_flow = |q: f64| curves.head_pa(b.speed[k], q);
                Some(b.head_factor[k] * slope(&of_flow, b.through[k]))
            }
            _ => None,
        };
        let errors = beside_the_usual(record, b, &self.rows.head, along)?;
        let mut out = vec![0.0; self.layout.len()];
        let rows = &mut out[self.layout.rows(section)];
        for (k, (row, error)) in rows.iter_mut().zip(errors).enumerate() {
            if error != 0.0 {
                *row = -error * answer(k)?;
            }
        }
        Some(out)
    }
}

/// By how much the meter reads beside the flow that goes with each block's speed and inlet pressure, m³/s; 0 where that is not known.
fn beside_the_usual(
    record: &Record,
    blocks: &Blocks,
    valid: &[bool],
    along: Quantity,
) -> Option<Vec<f64>> {
    let inlet: Vec<f64> = (record.filled.inlet.chunks(record.per_block))
        .map(mean)
        .collect();
    let rows: Vec<usize> = (0..blocks.flow.len())
        .filter(|k| valid[*k] && blocks.flow[*k] > 0.0 && blocks.through[*k] > 0.0)
        .collect();
    let middle = |values: &[f64]| {
        let sum: f64 = rows.iter().map(|k| values[*k]).sum();
        sum / rows.len() as f64
    };
    let (speed, level) = (middle(&blocks.speed), middle(&inlet));
    let terms = |k: usize| {
        let x = blocks.speed[k] / speed - 1.0;
        let p = inlet[k] / level - 1.0;
        [
            1.0,
            x,
            p,
            x * x,
            x * p,
            p * p,
            x * x * x,
            x * x * p,
            x * p * p,
            p * p * p,
        ]
    };
    let names = (0..TERMS).map(|k| k.to_string());
    let mut told = Accumulator::new(names).ok()?;
    for k in &rows {
        // A row without a value is refused, and left out.
        let _ = told.push(&terms(*k), blocks.flow[*k]);
    }
    let fit = told.finish().ok()?;
    let errors = rows
        .into_iter()
        .map(|k| (k, blocks.flow[k] - fit.predict(&terms(k))));
    let errors: Vec<(usize, f64)> = errors.filter(|(_, error)| error.is_finite()).collect();
    let along = match along {
        Quantity::PumpSpeed => &blocks.speed,
        _ => &inlet,
    };
    let mut out = vec![0.0; blocks.flow.len()];
    for (k, error) in off_bins(errors, along) {
        out[k] = error;
    }
    Some(out)
}

/// Errors less their means within equal parts of a quantity: what polynomials do not follow of a law of it.
fn off_bins(mut errors: Vec<(usize, f64)>, along: &[f64]) -> Vec<(usize, f64)> {
    /// Finer than the knots of any curve.
    const BINS: usize = 40;
    errors.retain(|(k, _)| along[*k].is_finite());
    let ends = errors.iter().map(|(k, _)| along[*k]);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let bin = |k: usize| {
        let share = (along[k] - low) / (high - low);
        whole(share.max(0.0) * BINS as f64).min(BINS - 1)
    };
    let mut bins = [(0.0, 0.0); BINS];
    for (k, error) in &errors {
        let (sum, count) = &mut bins[bin(*k)];
        (*sum, *count) = (*sum + error, *count + 1.0);
    }
    for (k, error) in &mut errors {
        let (sum, count) = bins[bin(*k)];
        *error -= sum / count;
    }
    errors
}
