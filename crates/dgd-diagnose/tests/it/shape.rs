//! What holds of any answer.

use super::rig::{case, recorded, screened, tried};
use dgd_diagnose::{Diagnosis, Options, Stage, diagnose};
use dgd_recording::Recording;

/// An hour and a half of a case with an influx in it.
fn ninety_minutes() -> (dgd_recording::Well, Recording, f64) {
    let (well, recording, step_s) = recorded(&case(302, Some("influx")));
    (well, recording.slice(4800..10_200), step_s)
}

/// Numbers hold together, whatever was found.
fn sound(found: &Diagnosis, samples: usize) {
    let s = &found.simulation;
    assert_eq!(
        (s.t_s.len(), s.held_out.len(), s.valid.len()),
        (samples, samples, samples)
    );
    for signal in &s.signals {
        for series in [&signal.measured, &signal.before, &signal.after] {
            assert_eq!(series.len(), samples, "{}", signal.name);
        }
        let ran = signal.after.iter().filter(|v| v.is_finite()).count();
        assert!(ran * 2 > samples, "{} ran for {ran} samples", signal.name);
    }
    // Where nothing is left out any more, what stands still is what instruments may wander by.
    for trace in &found.traces {
        assert!(trace.noise > 0.0 && trace.wander > 0.0);
        let mut left: Vec<f64> = trace
            .after
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        left.sort_by(f64::total_cmp);
        let middle = left[left.len() / 2];
        let may = trace.noise.hypot(trace.wander);
        assert!(
            middle.abs() < 2.0 * may,
            "{:?}: {middle} of {may}",
            trace.relation
        );
    }
    for finding in &found.findings {
        let others: f64 = finding.alternatives.iter().map(|a| a.1).sum();
        assert!((0.0..=1.0).contains(&finding.probability));
        assert!(finding.probability + others <= 1.0 + 1e-9, "{finding:?}");
        for p in &finding.parameters {
            assert!(p.ci95.0 <= p.estimate && p.estimate <= p.ci95.1, "{p:?}");
        }
    }
}

#[test]
fn two_runs_give_the_same_answer_to_the_last_bit() {
    let (well, recording, step_s) = ninety_minutes();
    let samples = recording.len();
    let [one, two] = [(); 2].map(|()| {
        let found = tried(&well, recording.clone(), step_s).unwrap();
        sound(&found, samples);
        // NaN is not equal to itself; numbers print with every digit that they have.
        format!("{found:?}")
    });
    assert!(one == two);
}

/// A clock that starts at another time changes nothing but the times that are told, and those by as much.
#[test]
fn the_start_of_the_clock_does_not_matter() {
    const LATER_S: f64 = 4096.0;
    let (well, mut recording, step_s) = ninety_minutes();
    let start = recording.time_s[0];
    recording.time_s.iter_mut().for_each(|t| *t -= start);
    let mut late = recording.clone();
    late.time_s.iter_mut().for_each(|t| *t += LATER_S);
    let early = tried(&well, recording, step_s).unwrap();
    let late = tried(&well, late, step_s).unwrap();
    assert_eq!(early.held_out_s.len(), late.held_out_s.len());
    for (a, b) in early.held_out_s.iter().zip(&late.held_out_s) {
        // Sums with another start round in their last bits.
        assert!((a.0 + LATER_S - b.0).abs() < 1e-6 && (a.1 + LATER_S - b.1).abs() < 1e-6);
    }
    assert_eq!(early.simulation.held_out, late.simulation.held_out);
    let brief = |d: &Diagnosis| -> Vec<_> {
        let one = |f: &dgd_diagnose::Finding| (f.effect.clone(), f.evidence, f.intervals_s.clone());
        d.findings.iter().map(one).collect()
    };
    assert!(!early.findings.is_empty());
    for (a, b) in brief(&early).iter().zip(&brief(&late)) {
        assert_eq!(a.0, b.0);
        assert!((a.1 / b.1 - 1.0).abs() < 1e-6, "{a:?} {b:?}");
        assert!((a.2[0].0 + LATER_S - b.2[0].0).abs() < 1e-6, "{a:?} {b:?}");
    }
    for (a, b) in early
        .simulation
        .signals
        .iter()
        .zip(&late.simulation.signals)
    {
        for (x, y) in a.after.iter().zip(&b.after) {
            assert!(x.is_nan() && y.is_nan() || (x - y).abs() <= 1e-6 * x.abs().max(1e-3));
        }
    }
}

#[test]
fn stages_come_in_order() {
    let (well, recording, step_s) = ninety_minutes();
    let mut stages = Vec::new();
    let prepared = screened(recording, step_s);
    diagnose(&well, &prepared, &Options::default(), &mut |s| {
        stages.push(s)
    })
    .unwrap();
    assert_eq!(stages[..2], [Stage::Baseline, Stage::Screening(1)]);
    assert_eq!(
        stages[stages.len() - 2..],
        [Stage::Fitting, Stage::Confirming]
    );
}

#[test]
fn one_outlet_transmitter_and_no_riser_transmitter_are_enough() {
    let (well, mut recording, step_s) = ninety_minutes();
    let samples = recording.len();
    recording.riser_pressure_pa = None;
    let mut dead = recording.clone();
    recording.pump_outlet_pressure_pa.truncate(1);
    let found = tried(&well, recording, step_s).unwrap();
    sound(&found, samples);
    assert!(found.findings.iter().any(|f| f.effect == "influx"));
    // One that is mapped and says nothing is as good as none.
    dead.pump_outlet_pressure_pa[1].fill(f64::NAN);
    let found = tried(&well, dead, step_s).unwrap();
    sound(&found, samples);
    assert!(found.findings.iter().any(|f| f.effect == "influx"));
}
