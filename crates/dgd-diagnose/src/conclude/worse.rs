//! Which outputs the findings make worse where no fit has looked.

use crate::diagnosis::{Check, NOT_WORSE, Simulation};
use crate::free_run::Errors;
use dgd_units::Legible;

/// Growth of an error from which on a signal is worse: set by hand, so that the trifles by which two fits differ are not told.
const WORSE: f64 = 1.1;

/// Growth of all errors, e-folds, from which on the signals run worse together. Set by hand, above the 0.26 that right names alone
/// reach in the proofs of 547357 and 557369.
const WORSE_TOGETHER: f64 = 0.5;

/// Growth of an error from which on the model runs away. Set by hand, above the 2.4 that simulated recordings reach with what is there.
const RUNS_AWAY: f64 = 2.5;

/// Whether a signal runs away with the findings: that refutes them, however much better the rows are told.
pub(super) fn runs_away(errors: &[Option<Errors>]) -> bool {
    (errors.iter().flatten()).any(|errors| errors.after > RUNS_AWAY * errors.before)
}

/// Whether the signals together run worse with the findings, however much better one of them may be told.
pub(super) fn is_worse(errors: &[Option<Errors>]) -> bool {
    let growth = |errors: &Errors| (errors.after / errors.before).ln();
    let together: f64 = (errors.iter().flatten())
        .map(growth)
        .filter(|v| v.is_finite())
        .sum();
    together > WORSE_TOGETHER
}

/// Whether every signal runs free on the held-out windows as well with the findings as without them; those that do not are told by
/// name, with both errors (RMSE).
///
/// - `errors`: of each signal, on the held-out windows.
pub(super) fn worse(simulation: &Simulation, errors: &[Option<Errors>]) -> Check {
    let worse: Vec<String> = (simulation.signals.iter().zip(errors))
        .filter_map(|(signal, errors)| Some((signal, (*errors)?)))
        .filter(|(_, errors)| errors.after > WORSE * errors.before)
        .map(|(signal, errors)| told(signal.name, errors))
        .collect();
    let (count, of) = (worse.len(), simulation.signals.len());
    let mut detail =
        format!("{count} of {of} signals have an RMSE above {WORSE} times that before");
    if count > 0 {
        detail.push_str(&format!(": {}", worse.join("; ")));
    }
    Check {
        name: NOT_WORSE.into(),
        passed: worse.is_empty(),
        detail,
    }
}

/// `riser level 0.53 m without the findings, 0.61 m with them`
fn told(signal: &str, Errors { before, after }: Errors) -> String {
    let legible = Legible::of(signal);
    let Legible { factor, unit, .. } = legible;
    let [before, after] = figures([factor * before, factor * after]);
    format!(
        "{} {before} {unit} without the findings, {after} {unit} with them",
        legible.words()
    )
}

/// Both with as many decimals: three figures of the larger.
pub(super) fn figures(values: [f64; 2]) -> [String; 2] {
    let largest = values[0].abs().max(values[1].abs());
    let decimals = if largest >= 100.0 {
        0
    } else if largest >= 10.0 {
        1
    } else if largest >= 1.0 {
        2
    } else if largest >= 0.1 {
        3
    } else {
        4
    };
    values.map(|v| format!("{v:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::{is_worse, runs_away, worse};
    use crate::diagnosis::{Check, Signal, Simulation};
    use crate::free_run::{Part, errors};

    fn held_out(simulation: &Simulation) -> Check {
        worse(simulation, &errors(simulation, Part::HeldOut))
    }

    /// An hour, held out whole, in which a run is off by so much before and after.
    fn off(signals: &[(&'static str, f64, f64)]) -> Simulation {
        const N: usize = 3600;
        let signals = signals.iter().map(|(name, before, after)| Signal {
            name,
            measured: vec![0.0; N],
            before: vec![*before; N],
            after: vec![*after; N],
        });
        Simulation {
            t_s: (0..N).map(|i| i as f64).collect(),
            held_out: vec![true; N],
            valid: vec![true; N],
            signals: signals.collect(),
        }
    }

    #[test]
    fn each_signal_that_grows_by_more_than_a_tenth_is_told_with_both_errors() {
        let check = held_out(&off(&[
            ("return_flow_m3_s", 1e-3, 1.2e-3),
            ("riser_level_m", 0.5, 0.54),
            ("pump_outlet_pressure_pa", 2e5, 1e5),
            ("pump_head_m", 1.5, 2.25),
        ]));
        assert!(!check.passed);
        assert_eq!(
            check.detail,
            "2 of 4 signals have an RMSE above 1.1 times that before: return flow 60.0 L/min without the findings, \
             72.0 L/min with them; pump head 1.50 m without the findings, 2.25 m with them"
        );
    }

    #[test]
    fn a_tenth_more_is_not_worse_and_a_little_more_than_that_is() {
        for (after, passed) in [(0.5, true), (1.0, true), (1.09, true), (1.11, false)] {
            let check = held_out(&off(&[("riser_level_m", 1.0, after)]));
            assert_eq!(check.passed, passed, "{}", check.detail);
            assert_eq!(check.detail.contains("riser level"), !passed);
        }
    }

    #[test]
    fn a_model_runs_away_that_is_wrong_by_more_than_twice_and_a_half_in_any_signal() {
        for (after, away) in [(0.3, false), (2.4, false), (2.6, true)] {
            let of = |name| (name, 1.0, 1.0);
            let mut signals = ["return_flow_m3_s", "riser_level_m", "pump_head_m"].map(of);
            signals[1].2 = after;
            let errors = errors(&off(&signals), Part::HeldOut);
            assert_eq!(runs_away(&errors), away, "{after}");
        }
    }

    #[test]
    fn a_signal_that_nobody_measured_is_not_made_worse() {
        let mut unseen = off(&[("riser_level_m", 1.0, 2.0)]);
        unseen.signals[0].measured.fill(f64::NAN);
        assert!(held_out(&unseen).passed);
    }

    #[test]
    fn signals_run_worse_together_whatever_one_of_them_gains() {
        for (level, head, together) in [(0.9, 1.3, false), (1.85, 1.34, true), (0.6, 2.4, false)] {
            let signals = [("riser_level_m", 1.0, level), ("pump_head_m", 1.0, head)];
            let errors = errors(&off(&signals), Part::HeldOut);
            assert_eq!(is_worse(&errors), together, "{level} {head}");
        }
    }
}
