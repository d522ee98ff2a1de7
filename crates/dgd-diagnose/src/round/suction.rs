//! What the suction might lose with the flow where nothing tells, so that no effect is named for it.

use crate::layout::Section;
use crate::record::Record;
use crate::relations::{Applied, imbalance_per_head};
use crate::suction::ALLOWED_HEADS;
use crate::tangent::Tangent;
use crate::twins::seen_curve;
use dgd_effects::Place;
use dgd_lsq::dot;

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

    use super::Unmeasured;
    use crate::ablation::Step;
    use crate::record::Record;
    use crate::relations::{Applied, Blocks, imbalance_per_head};
    use crate::scan::weigh;
    use crate::suction::ALLOWED_HEADS;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, drilled};
    use dgd_effects::{Curve, Place, Quantity, find};

    /// Drilling whose inlet reads less by what the suction loses with the flow.
    fn losing(heads: f64) -> Record {
        let mut record = drilled(Hidden::default());
        // Flows that may be late take most of what the loss does.
        record.without = vec![Step::LateFlows];
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
