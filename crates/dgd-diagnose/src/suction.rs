//! What the suction between riser and pump inlet loses with the flow.

use crate::numbers::{mean, whole};
use dgd_recording::{Rank, quantile};

/// Most that a suction is taken to lose, in velocity heads of the return line.
const MOST_HEADS: f64 = 5.0;
/// Stretches whose means are compared, s: longer than anything answers late, shorter than transmitters wander.
const STRETCH_S: f64 = 60.0;
/// Stretches that part by more than so many median absolute deviations tell of something else.
const FAR: f64 = 4.0;
/// Steps from stretch to stretch that tell a loss.
const FEWEST: usize = 10;
/// Standard error of the loss above which it is not known, in velocity heads.
const KNOWN_HEADS: f64 = 0.3;
/// What a suction may lose unseen, in velocity heads: somewhat more than an entrance, two bends and a valve that is open (1.0 to 1.4 by the
/// resistance coefficients of Crane TP-410), and as much as simulated rigs lose at the most.
pub(crate) const ALLOWED_HEADS: f64 = 1.5;

/// Loss in velocity heads of the return line, by what inlet and riser part by as the flow goes from one minute to the next.
///
/// The level is read from the inlet's pressure: where that falls as the flow grows, the level seems to fall, which looks like another
/// area, or like a gain of one of the flows. `None` where the flow hardly changes while both are read, so that its noise tells no loss.
pub(crate) fn heads_lost(
    inlet: &[f64],
    riser: &[f64],
    velocity_head_pa: impl Fn(usize) -> f64,
    dt_s: f64,
) -> Option<f64> {
    let per = whole(STRETCH_S / dt_s).max(1);
    let stretches = inlet.len().min(riser.len()) / per;
    let of = |k: usize| {
        let samples = k * per..(k + 1) * per;
        let apart: Vec<f64> = (samples.clone()).map(|i| riser[i] - inlet[i]).collect();
        let heads: Vec<f64> = samples.map(&velocity_head_pa).collect();
        (mean(&heads), mean(&apart))
    };
    let means: Vec<(f64, f64)> = (0..stretches).map(of).collect();
    let mut steps: Vec<(f64, f64)> = (means.windows(2))
        .map(|w| (w[1].0 - w[0].0, w[1].1 - w[0].1))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    // What is far from the others is left out, and the rest asked again.
    let mut heads = 0.0;
    let mut error = f64::INFINITY;
    for _ in 0..3 {
        let moment = |f: fn(&(f64, f64)) -> f64| steps.iter().map(f).sum::<f64>();
        let (xy, xx) = (moment(|(x, y)| x * y), moment(|(x, _)| x * x));
        if steps.len() < FEWEST || xx <= 0.0 {
            return None;
        }
        heads = xy / xx;
        let off = |(x, y): &(f64, f64)| (y - heads * x).abs();
        let squares: f64 = steps.iter().map(|step| off(step).powi(2)).sum();
        error = (squares / (steps.len() - 1) as f64 / xx).sqrt();
        let typical = quantile(steps.iter().map(off), Rank::MEDIAN).unwrap_or(0.0);
        let near: Vec<(f64, f64)> = (steps.iter().copied())
            .filter(|step| off(step) <= FAR * typical)
            .collect();
        steps = near;
    }
    (error <= KNOWN_HEADS).then_some(heads.clamp(0.0, MOST_HEADS))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::heads_lost;
    use crate::test_rig::normals;

    const DT_S: f64 = 2.0;
    const SAMPLES: usize = 7200;

    /// Velocity heads of a flow that stops every half hour, Pa.
    fn head_pa(i: usize) -> f64 {
        if i % 900 < 120 {
            0.0
        } else {
            3000.0 + 500.0 * (0.01 * i as f64).sin()
        }
    }

    /// What the transmitters read: `lost` velocity heads between them, noise of 1.6 kPa, and a wander of 2 kPa over hours.
    fn read(lost: f64) -> (Vec<f64>, Vec<f64>) {
        let (noise, other) = (normals(1, SAMPLES), normals(2, SAMPLES));
        let level = |i: usize| 24e5 + 4e4 * (0.002 * i as f64).cos();
        let wander = |i: usize| 2e3 * (0.0007 * i as f64).sin();
        let inlet = (0..SAMPLES).map(|i| level(i) - lost * head_pa(i) + 1.6e3 * noise[i]);
        let riser = (0..SAMPLES).map(|i| level(i) + 1e5 + wander(i) + 1.6e3 * other[i]);
        (inlet.collect(), riser.collect())
    }

    #[test]
    fn the_heads_lost_are_those_by_which_inlet_and_riser_part_with_the_flow() {
        for lost in [0.0, 0.4, 1.5] {
            let (inlet, riser) = read(lost);
            let told = heads_lost(&inlet, &riser, head_pa, DT_S).unwrap();
            assert!((told - lost).abs() < 0.1, "{told} for {lost}");
        }
        // A suction that gains pressure there is none.
        let (inlet, riser) = read(-0.5);
        let told = heads_lost(&inlet, &riser, head_pa, DT_S).unwrap();
        assert!(told.abs() < f64::EPSILON);
    }

    #[test]
    fn a_loss_that_is_read_late_is_told_by_the_minute() {
        let (mut inlet, riser) = read(0.0);
        // It follows the flow within some seconds.
        let mut lost = head_pa(0);
        for (i, p) in inlet.iter_mut().enumerate() {
            lost += 0.3 * (head_pa(i) - lost);
            *p -= 0.8 * lost;
        }
        let told = heads_lost(&inlet, &riser, head_pa, DT_S).unwrap();
        assert!((told - 0.8).abs() < 0.2, "{told}");
    }

    #[test]
    fn readings_that_jump_or_are_not_there_tell_of_something_else() {
        let (mut inlet, mut riser) = read(0.8);
        inlet[1000..1400].fill(f64::NAN);
        inlet[5000..].iter_mut().for_each(|p| *p += 3e5);
        riser[3000..3020].fill(1e5);
        let told = heads_lost(&inlet, &riser, head_pa, DT_S).unwrap();
        assert!((told - 0.8).abs() < 0.1, "{told}");
    }

    #[test]
    fn of_a_flow_that_hardly_changes_no_loss_is_told() {
        let (inlet, riser) = read(0.8);
        let noise = normals(3, SAMPLES);
        let nothing = [
            heads_lost(&inlet, &riser, |_| 3000.0, DT_S),
            // Of a flow that only its meter's noise moves.
            heads_lost(&inlet, &riser, |i| 3000.0 + 30.0 * noise[i], DT_S),
            heads_lost(&inlet[..300], &riser[..300], head_pa, DT_S),
            heads_lost(&[], &[], head_pa, DT_S),
            heads_lost(&inlet, &riser, |_| f64::NAN, DT_S),
        ];
        assert!(nothing.iter().all(Option::is_none), "{nothing:?}");
    }
}
