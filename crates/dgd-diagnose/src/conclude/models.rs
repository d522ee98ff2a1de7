//! The models before and after, trained without the held-out windows, and how they run through them.

use crate::belief::unmodelled;
use crate::diagnosis::{Check, DiagnoseError, Simulation};
use crate::finding::amiss;
use crate::free_run::{Part, errors, simulate};
use crate::held_out::{ends_after, held_out_of, model, trained};
use crate::record::Record;
use crate::refine::{fitted_here, unshown};
use crate::relations::Applied;
use crate::select::Sought;
use crate::selection::{Named, Selection};
use crate::tangent::{Bend, FRICTION_PRIOR_PA, Tangent};
use crate::timing::allowances_with;
use dgd_effects::AugmentedModel;
use dgd_identify::Prepared;
use dgd_recording::Well;
use tracing::debug;

/// The model without what was found, and the one with it.
pub(super) struct Models {
    /// Held-out windows, s.
    pub windows: Vec<(f64, f64)>,
    /// Blocks that lie in them.
    excluded: Vec<bool>,
    /// The effects of the model to start from, trained.
    pub start: Vec<Applied>,
    pub before_fit: Tangent,
    after_state: Vec<Applied>,
    pub before: AugmentedModel,
    pub after: AugmentedModel,
}

impl Models {
    /// Trains both; `None` where the training samples do not suffice.
    ///
    /// - `known`: effects of the model to start from, as they are in this recording.
    /// - `kept`: the same as they were given.
    pub(super) fn trained(
        record: &Record,
        selection: &Selection,
        known: &[Applied],
        kept: Vec<Applied>,
    ) -> Option<Self> {
        let span = record.setting.span_s;
        let acting = selection.named.iter().map(|n| &n.applied).chain(known);
        let intervals: Vec<(f64, f64)> = acting.map(|a| a.interval_s(span)).collect();
        let windows = held_out_of(record, &intervals);
        let excluded = blocks_within(record, &windows);
        // From what was given, not from what the whole recording made of it: the held-out windows would have had their say.
        let start = fitted_here(record, &kept, &excluded).into_iter().zip(kept);
        let start: Vec<Applied> = start
            .map(|(trained, given)| trained.unwrap_or_else(|| unshown(given)))
            .collect();
        let before_state = allowances_with(record, &start, &excluded, Bend::Stiff, None)?;
        let after_state = trained(record, &start, selection, &excluded)?;
        let before_fit = runnable(record, &before_state, &excluded)?;
        let after_fit = runnable(record, &after_state, &excluded)?;
        let before = model(record, &before_state, &before_fit, &excluded);
        let after = model(record, &after_state, &after_fit, &excluded);
        Some(Self {
            windows,
            excluded,
            start,
            before_fit,
            after_state,
            before,
            after,
        })
    }

    /// Runs both through the windows; with what was found amiss with the corrections, which are then left out of the model and doubted.
    ///
    /// # Errors
    /// Those of a free run.
    pub(super) fn run(
        mut self,
        well: &Well,
        record: &Record,
        prepared: &Prepared,
        named: &mut Vec<Named>,
        sought: Sought<'_>,
    ) -> Result<(Self, Simulation, Option<Check>), DiagnoseError> {
        let run = |after: &AugmentedModel| {
            simulate(well, record, prepared, &self.windows, &self.before, after)
        };
        let mut simulation = run(&self.after)?;
        let mut check = None;
        // An empirical correction can make the free run unstable: on the training stretches that shows, and it is left out.
        if named.iter().any(|n| n.applied.is_correction())
            && ln_error_ratio(&simulation) > 0.0
            && let Some(plain) = self.without_corrections(record, named.len())
        {
            let other = run(&plain)?;
            debug!(
                "relative error of free runs on the training stretches: {:.2} with the correction, {:.2} without it",
                ln_error_ratio(&simulation),
                ln_error_ratio(&other)
            );
            if ln_error_ratio(&other) < ln_error_ratio(&simulation) {
                check = Some(unstable(named, sought, record.setting.span_s));
                (self.after, simulation) = (plain, other);
            }
        }
        if named.is_empty() {
            // Nothing found: the two models are one.
            self.after = self.before.clone();
            for signal in &mut simulation.signals {
                signal.after = signal.before.clone();
            }
        }
        Ok((self, simulation, check))
    }

    /// The model after without the corrections among so many that were found.
    fn without_corrections(&self, record: &Record, found: usize) -> Option<AugmentedModel> {
        // Those of the model that the search starts from stay.
        let first = self.after_state.len() - found;
        let plain: Vec<Applied> = (self.after_state.iter().enumerate())
            .filter(|(k, a)| *k < first || !a.is_correction())
            .map(|(_, a)| a.clone())
            .collect();
        let fit = runnable(record, &plain, &self.excluded)?;
        Some(model(record, &plain, &fit, &self.excluded))
    }
}

/// Which blocks lie in any of some windows, s, in order.
fn blocks_within(record: &Record, windows: &[(f64, f64)]) -> Vec<bool> {
    let seconds = record.block_s();
    (0..record.blocks)
        .map(|b| {
            let from = record.setting.span_s.0 + b as f64 * seconds;
            let to = from + seconds;
            ends_after(windows, from).is_some_and(|w| to > w.0)
        })
        .collect()
}

/// Errors of free runs on the training stretches with what was found, over those without: the sum of their logarithms, above 0 where the runs got worse.
fn ln_error_ratio(simulation: &Simulation) -> f64 {
    (errors(simulation, Part::Training).into_iter().flatten())
        .map(|errors| errors.left().ln())
        .filter(|v| v.is_finite())
        .sum()
}

/// Curves for a free run. Where mud at rest pulls the friction's intercept far from any plausible one, the column at rest is not the
/// model's: the stops are left out, as curves that are bent to fit them make the run unstable.
pub(super) fn runnable(record: &Record, state: &[Applied], excluded: &[bool]) -> Option<Tangent> {
    /// Standard deviations of its prior up to which the intercept is one. Set by hand.
    const INTERCEPT: f64 = 3.0;
    let fit = Tangent::at(record, state, excluded, Bend::Stiff)?;
    if fit.curves.friction[0].abs() < INTERCEPT * FRICTION_PRIOR_PA[0] {
        return Some(fit);
    }
    let stops = |(out, still): (&bool, &bool)| *out || *still;
    let flowing: Vec<bool> = excluded.iter().zip(&fit.rows.still).map(stops).collect();
    Tangent::at(record, state, &flowing, Bend::Stiff).or(Some(fit))
}

/// Lowers the probability of corrections that make the free run unstable, and drops what is then more likely not there, unless it was
/// suspected.
fn unstable(named: &mut Vec<Named>, sought: Sought<'_>, span_s: (f64, f64)) -> Check {
    named.iter_mut().for_each(unmodelled);
    let mut detail =
        "it does not on the training stretches, so it is left out of the model that runs"
            .to_owned();
    if let Sought::Any(_) = sought {
        let unlikely = named.iter().filter(|n| n.likely() < 0.5);
        for (amiss, p) in unlikely.filter_map(|n| Some((amiss(n, span_s)?, n.probability))) {
            detail += &format!("; that {amiss} is therefore not claimed (probability {p:.2})");
        }
        named.retain(|n| n.likely() >= 0.5);
    }
    Check {
        name: "the empirical correction keeps the free run stable".into(),
        passed: false,
        detail,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Models, model, runnable};
    use crate::diagnosis::Check;
    use crate::record::Record;
    use crate::relations::Applied;
    use crate::select::Sought;
    use crate::selection::{Named, Selection};
    use crate::test_rig::{FLOW_M3_S, Hidden, INFLUX_S, drilled, named, one, recorded};
    use dgd_effects::{AugmentedModel, Curve, KNOTS, Place, Quantity};

    const RATE_M3_S: f64 = 3e-3;

    fn influx(rate: f64) -> Applied {
        let (from, lasts, rise) = INFLUX_S;
        one("influx", &[rate, from, lasts, rise])
    }

    /// So much more inflow at every return flow.
    fn more(inflow_m3_s: f64) -> Applied {
        let range = (0.9 * FLOW_M3_S, 1.4 * FLOW_M3_S);
        let knots = vec![inflow_m3_s; KNOTS];
        Applied::from(&Curve::new(
            Place::Balance,
            Quantity::ReturnFlow,
            range,
            knots,
        ))
    }

    fn claimed(applied: Applied) -> Named {
        Named {
            applied,
            probability: 0.7,
            ..named("influx", &[0.0; 4])
        }
    }

    fn flowing(influx_m3_s: f64) -> Record {
        drilled(Hidden {
            influx_m3_s,
            ..Hidden::default()
        })
    }

    fn ids(model: &AugmentedModel) -> Vec<&str> {
        model.effects.iter().map(|e| e.id.as_str()).collect()
    }

    /// Trained, beside a model that it starts from.
    fn trained(record: &Record, start: &[Applied], named: &[Named]) -> Models {
        let selection = Selection {
            held: start.len(),
            allowances: start.to_vec(),
            named: named.to_vec(),
            first: Vec::new(),
            stays: false,
        };
        Models::trained(record, &selection, start, start.to_vec()).unwrap()
    }

    #[test]
    fn of_corrections_those_found_are_left_out_and_those_started_from_stay() {
        let record = flowing(RATE_M3_S);
        let found = [claimed(influx(RATE_M3_S)), claimed(more(0.0))];
        let alone = trained(&record, &[], &found);
        assert_eq!(ids(&alone.after), ["influx", "unknown"]);
        let plain = alone.without_corrections(&record, 2).unwrap();
        assert_eq!(ids(&plain), ["influx"]);
        let beside = trained(&record, &[more(0.0)], &found);
        let plain = beside.without_corrections(&record, 2).unwrap();
        assert_eq!(ids(&plain), ["unknown", "influx"]);
    }

    /// Run with what it was not trained to, and what is then claimed and checked.
    fn run(
        record: &Record,
        state: &[Applied],
        sought: Sought<'_>,
    ) -> (Models, Vec<f64>, Option<Check>) {
        let mut named: Vec<Named> = state.iter().cloned().map(claimed).collect();
        let mut models = trained(record, &[], &named);
        models.after_state = state.to_vec();
        let fit = runnable(record, state, &models.excluded).unwrap();
        models.after = model(record, state, &fit, &models.excluded);
        let (well, prepared) = recorded(record, 0.0);
        let (models, _, check) = models
            .run(&well, record, &prepared, &mut named, sought)
            .unwrap();
        (models, named.iter().map(|n| n.probability).collect(), check)
    }

    #[test]
    fn a_correction_that_makes_the_run_unstable_is_neither_run_nor_claimed() {
        let record = flowing(RATE_M3_S);
        let state = [influx(RATE_M3_S), more(0.2 * FLOW_M3_S)];
        let (models, left, check) = run(&record, &state, Sought::Any(6));
        assert_eq!(ids(&models.after), ["influx"]);
        assert_eq!(left, [0.7]);
        let check = check.unwrap();
        assert!(!check.passed && check.detail.contains("not claimed"));
        // What was asked about is told all the same.
        let suspects = ["unknown".to_owned()];
        let (_, left, check) = run(&record, &state, Sought::Given(&suspects));
        assert!(left.len() == 2 && left[1] < 0.5 && check.is_some());
    }

    #[test]
    fn a_correction_without_which_the_run_is_no_better_stays() {
        let state = [influx(RATE_M3_S), more(0.0)];
        // With both the run is better than without; where nothing is concealed it is worse, and the correction has no part in that.
        for concealed in [RATE_M3_S, 0.0] {
            let (models, left, check) = run(&flowing(concealed), &state, Sought::Any(6));
            assert_eq!(ids(&models.after), ["influx", "unknown"]);
            assert_eq!((left, check), (vec![0.7, 0.7], None));
        }
    }

    #[test]
    fn where_nothing_is_found_the_two_models_are_one() {
        let record = flowing(0.0);
        let (well, prepared) = recorded(&record, 0.0);
        let mut models = trained(&record, &[], &[]);
        models.after = model(
            &record,
            &[influx(RATE_M3_S)],
            &models.before_fit,
            &models.excluded,
        );
        let (models, simulation, check) = models
            .run(&well, &record, &prepared, &mut Vec::new(), Sought::Any(6))
            .unwrap();
        assert_eq!((models.after, check), (models.before, None));
        let same = simulation.signals.iter().all(|s| s.before == s.after);
        assert!(same && !simulation.signals.is_empty());
    }
}
