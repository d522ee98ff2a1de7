//! Claims about a pump that lifts less for a while, or from then on.

use crate::belief::calibrate;
use crate::record::Record;
use crate::select::{Named, Sought, select};
use crate::test_rig::{Hidden, drilled};

/// The same drilling with a pump that lifts less by a share in a stretch, s, for which it turns faster.
fn lifting_less(loss: f64, stretch_s: std::ops::Range<f64>) -> Record {
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        if stretch_s.contains(&record.t_s[i]) {
            let lift = record.outlet[i] - record.inlet[i];
            // Its head is 45 bar times the square of the speed over 70 %, less what the flow takes.
            let more = lift * loss / (1.0 - loss) / 45e5 * 70.0_f64.powi(2);
            record.speed[i] = (record.speed[i].powi(2) + more).sqrt();
        }
    }
    record.filled.speed.clone_from(&record.speed);
    record
}

#[test]
fn a_head_that_is_lost_for_a_while_is_gas_and_one_that_stays_lost_is_nothing_of_the_catalogue() {
    let ends = 5400.0;
    for (stretch_s, is_gas) in [
        (1800.0..3600.0, true),
        (1800.0..ends, false),
        // It may have come before the recording began.
        (-1.0..3600.0, true),
    ] {
        let record = lifting_less(0.05, stretch_s.clone());
        let mut found = select(&record, &[], Sought::Any(3), |_| {}).unwrap().named;
        calibrate(&mut found);
        let gas = |n: &&Named| n.applied.effect.about().id == "gas_in_pump" && n.probability > 0.5;
        assert_eq!(found.iter().any(|n| gas(&n)), is_gas, "{stretch_s:?}");
        let unknown = |n: &Named| {
            let told = n
                .alternatives
                .iter()
                .any(|(id, p)| id == "unknown" && *p > 0.5);
            n.applied.is_correction() || told
        };
        assert_eq!(found.iter().any(unknown), !is_gas, "{stretch_s:?}");
    }
}
