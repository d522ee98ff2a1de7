//! What the suction between riser and pump inlet loses with the flow, and what it might where nothing tells.

use crate::empirical::seen_curve;
use crate::layout::Section;
use crate::numbers::{mean, whole};
use crate::record::Record;
use crate::relations::{Applied, imbalance_per_head};
use crate::tangent::Tangent;
use dgd_effects::Place;
use dgd_lsq::dot;
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

/// What a loss that nothing measures may leave over of the mass balance.
pub(crate) struct Unmeasured {
    /// Of [`ALLOWED_HEADS`], whitened and off the tangent.
    pub signature: Vec<f64>,
}

impl Unmeasured {
    /// `None` where the loss is measured, unless what lies between the transmitters that measure it is at fault: it is another from hour to hour
    /// then. Where the reading of one is, it drifts, which moves little from minute to minute.
    pub(crate) fn of(record: &Record, gate: &Tangent, state: &[Applied]) -> Option<Self> {
        let at_fault =
            |one: &Applied| seen_curve(one).is_some_and(|curve| curve.place == Place::Suction);
        if record.suction_heads.is_some() && !state.iter().any(at_fault) {
            return None;
        }
        let mut change = vec![0.0; gate.layout.len()];
        let rows = imbalance_per_head(record);
        for (there, row) in change[gate.layout.rows(Section::Balance)]
            .iter_mut()
            .zip(rows)
        {
            *there = ALLOWED_HEADS * row;
        }
        let signature = gate.beyond(record, &change);
        let finite = signature.iter().all(|v| v.is_finite());
        finite.then_some(Self { signature })
    }

    /// Evidence that it leaves over for a candidate.
    pub(crate) fn left_over(&self, candidate: &[f64]) -> f64 {
        let energy = dot(candidate, candidate);
        if energy > 0.0 {
            0.5 * dot(candidate, &self.signature).powi(2) / energy
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{ALLOWED_HEADS, Unmeasured, heads_lost};
    use crate::record::Record;
    use crate::relations::{Applied, Blocks, imbalance_per_head};
    use crate::scan::weigh;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, drilled, normals};
    use dgd_effects::{Curve, Place, Quantity, find};

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

    /// Drilling whose inlet reads less by what the suction loses with the flow.
    fn losing(heads: f64) -> Record {
        let mut record = drilled(Hidden::default());
        for readings in [&mut record.inlet, &mut record.filled.inlet] {
            for (p, q) in readings.iter_mut().zip(&record.filled.flow) {
                let velocity = q / record.setting.line_area_m2;
                *p -= heads * 0.5 * record.setting.density_kg_m3 * velocity.powi(2);
            }
        }
        record
    }

    fn gate(record: &Record) -> Tangent {
        Tangent::at(record, &[], &[], Bend::Lean).unwrap()
    }

    #[test]
    fn a_loss_makes_no_more_evidence_than_is_left_over_for_it() {
        let (sound, off) = (losing(0.0), losing(ALLOWED_HEADS));
        let mut most = 0.0_f64;
        for (id, parameters) in [
            ("annulus_area", &[0.05][..]),
            ("inflow_gain", &[0.01]),
            ("return_flow_gain", &[0.01]),
            ("pipe_displacement", &[0.05, 2000.0, 60.0, 0.0]),
            ("yield_stress", &[1e4, 0.3]),
        ] {
            let effect = find(id).unwrap();
            let weighed = |record: &Record| {
                let gate = gate(record);
                let c = weigh(
                    record,
                    &gate,
                    &[],
                    Applied::new(effect, parameters.to_vec()),
                );
                let unmeasured = Unmeasured::of(record, &gate, &[]).unwrap();
                (c.evidence, unmeasured.left_over(&c.signature))
            };
            let (before, after) = (weighed(&sound), weighed(&off));
            // The loss pulls with what is there already, either way: twice the product of the roots, and what it is itself.
            let grown = after.0 - before.0;
            let may = after.1 + 2.0 * (after.1 * (before.0.max(0.0) + 4.0)).sqrt();
            assert!(grown <= may + 1.0, "{id}: {before:?} {after:?}");
            most = most.max(grown);
        }
        assert!(most > 5.0, "{most}");
        assert!(
            (Unmeasured::of(&sound, &gate(&sound), &[]).unwrap())
                .left_over(&[])
                .abs()
                < f64::EPSILON
        );
    }

    #[test]
    fn what_it_may_be_is_what_it_does_to_the_balance() {
        let (sound, off) = (losing(0.0), losing(ALLOWED_HEADS));
        let imbalance = |record: &Record| Blocks::under(record, &[]).imbalance;
        let per_head = imbalance_per_head(&sound);
        let (mut apart, mut whole) = (0.0, 0.0);
        for ((a, b), one) in imbalance(&off).iter().zip(imbalance(&sound)).zip(per_head) {
            // What it would add if it were put back it takes away.
            apart += (a - b + ALLOWED_HEADS * one).powi(2);
            whole += (a - b).powi(2);
        }
        assert!(apart < 1e-4 * whole, "{apart} of {whole}");
    }

    #[test]
    fn a_loss_that_is_measured_is_put_back_unless_the_suction_itself_is_at_fault() {
        let mut record = losing(ALLOWED_HEADS);
        record.suction_heads = Some(ALLOWED_HEADS);
        let gate = gate(&record);
        assert!(Unmeasured::of(&record, &gate, &[]).is_none());
        let seen = |place: Place| {
            let curve = Curve::new(place, Quantity::Time, (0.0, 5400.0), vec![0.0; 100]);
            [Applied::from(&curve)]
        };
        assert!(Unmeasured::of(&record, &gate, &seen(Place::Suction)).is_some());
        assert!(Unmeasured::of(&record, &gate, &seen(Place::RiserReading)).is_none());
    }
}
