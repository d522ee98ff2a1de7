//! Claims about what stands for the flow without the noise of its meter.

use crate::empirical::{Correction, correction, hurdle};
use crate::layout::Section;
use crate::record::Record;
use crate::relations::Blocks;
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{FLOW_M3_S, Hidden, SPEED_PCT, drilled, normals};
use dgd_effects::{Place, Quantity};
use dgd_lsq::dot;

const ALONG_LEVEL: (Place, Quantity) = (Place::Head, Quantity::InletPressure);

/// What the meter is off by, m³/s, new in each block.
fn errors(record: &Record, size_m3_s: f64) -> Vec<f64> {
    let each = normals(31, record.blocks);
    each.into_iter().map(|v| size_m3_s * v).collect()
}

/// Drilling whose pump lifts less by a law of the inlet pressure, Pa, with a meter that is off by so much in each block.
fn metered(size_m3_s: f64, less_pa: impl Fn(f64) -> f64) -> Record {
    let mut record = drilled(Hidden::default());
    let errors = errors(&record, size_m3_s);
    for i in 0..record.t_s.len() {
        record.flow[i] += errors[i / record.per_block];
        // It turns faster for it: its head is 45 bar times the square of the speed over 70 %, less what the flow takes.
        let more = less_pa(record.inlet[i]) / 45e5 * SPEED_PCT.powi(2);
        record.speed[i] = (record.speed[i].powi(2) + more).sqrt();
    }
    record.filled.flow.clone_from(&record.flow);
    record.filled.speed.clone_from(&record.speed);
    record
}

fn along_level(record: &Record) -> Correction {
    let loose = Tangent::at(record, &[], &[], Bend::Loose).unwrap();
    correction(record, &loose, &[], &[], ALONG_LEVEL).unwrap()
}

#[test]
fn errors_of_the_meter_show_as_large_as_they_are() {
    let size = 2e-4;
    let record = metered(size, |_| 0.0);
    let tangent = Tangent::at(&record, &[], &[], Bend::Stiff).unwrap();
    // Where the flow rests they are averaged with their neighbours.
    let flow = |record: &Record| Blocks::under(record, &[]).flow;
    let sound = flow(&metered(0.0, |_| 0.0));
    let errors: Vec<f64> = (flow(&record).iter().zip(&sound))
        .map(|(read, sound)| read - sound)
        .collect();
    for (section, along) in [
        (Section::Head, Quantity::InletPressure),
        (Section::Friction, Quantity::PumpSpeed),
    ] {
        let found = tangent.flow_errors(&record, section, along).unwrap();
        let rows = &found[tangent.layout.rows(section)];
        // Friction grows and the head falls by 8 and 10 bar for one more usual flow.
        let slope = match section {
            Section::Head => -2.0 * 5e5 / FLOW_M3_S,
            _ => 2.0 * 4e5 / FLOW_M3_S,
        };
        let expected: Vec<f64> = errors.iter().map(|e| -slope * e).collect();
        let share = dot(rows, &expected) / dot(&expected, &expected);
        let alike = dot(rows, &expected) / (dot(rows, rows) * dot(&expected, &expected)).sqrt();
        assert!(
            (0.5..1.2).contains(&share) && alike > 0.5,
            "{section:?}: {share} {alike}"
        );
        assert!(found.len() == tangent.layout.len() && rows.len() == record.blocks);
    }
}

#[test]
fn noise_of_the_meter_makes_no_law_of_the_level_and_hides_none() {
    let noisy = along_level(&metered(1e-3, |_| 0.0));
    assert!(noisy.evidence < 0.5 * hurdle(&noisy), "{}", noisy.evidence);
    assert!(
        noisy.evidence + noisy.owed > hurdle(&noisy),
        "{}",
        noisy.owed
    );
    for size in [0.0, 2e-4, 5e-4, 1e-3] {
        let law = along_level(&metered(size, |inlet| 1e5 * (inlet / 4e3).sin()));
        assert!(law.evidence > hurdle(&law), "{size}: {}", law.evidence);
    }
}
