//! What has been named already, and what it leaves over for want of form.

use crate::contest::{hurdle, material};
use crate::empirical::again;
use crate::record::Record;
use crate::relations::Applied;
use crate::selection::Selection;
use crate::tangent::{Bend, Tangent};
use crate::twins::seen_curve;
use dgd_effects::{About, Excitation};
use dgd_lsq::dot;

/// One cause that has been named.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known {
    /// Its place in the state.
    pub place: usize,
    pub evidence: f64,
    /// What its form gained within its error, where its strength differs along stands; else 0.
    pub bent: f64,
}

/// Whether the strength of an effect differs from stand to stand and along them. At a stop there is no more to differ than the
/// strength itself.
pub(super) fn differs_along_stands(about: &About) -> bool {
    about.search.stand_error.is_some() && !about.search.needs.contains(&Excitation::PumpStops)
}

/// What has been named: what the search starts from, as far as this recording shows it, and what the search has found.
pub(super) fn known(
    record: &Record,
    state: &[Applied],
    selection: &Selection,
) -> Option<Vec<Known>> {
    let mut known = Vec::new();
    if selection.held > 0 {
        // Without the slack of named effects, which would stand in for what is left out.
        let whole = Tangent::at(record, state, &[], Bend::Lean)?;
        // What is within an instrument's accuracy is no finding.
        for k in (0..selection.held).filter(|k| material(&state[*k])) {
            let mut without = state.to_vec();
            without.remove(k);
            let evidence = if state[k].is_correction() {
                // Knots are many, and the riser's transmitter may be the one that shows them.
                let held = state[k].curve();
                held.and_then(|held| again(record, &without, &held, &[]).map(|c| c.evidence))
            } else {
                let off = whole.left_over(record, &without);
                let gained = 0.5 * (dot(&off, &off) - dot(&whole.off, &whole.off));
                (gained > hurdle(record, &state[k])).then_some(gained)
            };
            let Some(evidence) = evidence else {
                continue;
            };
            let bent = if differs_along_stands(state[k].effect.about()) {
                let bare = Tangent::at(record, &without, &[], Bend::Lean)?;
                (bare.formed(record, &without, &state[k]) - evidence).max(0.0)
            } else {
                0.0
            };
            known.push(Known {
                place: k,
                evidence,
                bent,
            });
        }
    }
    let first = state.len() - selection.named.len();
    let found = selection.named.iter().enumerate();
    known.extend(found.map(|(k, n)| Known {
        place: first + k,
        evidence: n.held.as_ref().map_or(n.evidence, |held| held.borne),
        bent: n.bent,
    }));
    Some(known)
}

/// Evidence that an effect's want of form leaves over where it acts, over the root of the effect's own.
pub(super) const LEFT_OVER: f64 = 0.5;

/// How much more of it there is where knots meet a form of physics, on either side.
pub(super) const KNOTS_WANT: f64 = 5.0;

/// Share of what a strength gained by differing from stand to stand, and along them, that it leaves over.
pub(super) const WITHIN_STANDS: f64 = 0.05;

/// Where a named effect acts, and how strongly it showed.
pub(super) struct Footprint {
    pub rows: Vec<bool>,
    pub evidence: f64,
    pub bent: f64,
    /// Whether it is a curve through knots, which meets no form of physics.
    pub knots: bool,
}

impl Footprint {
    /// Of each effect that has been named.
    pub(super) fn all(
        record: &Record,
        gate: &Tangent,
        state: &[Applied],
        known: &[Known],
    ) -> Vec<Self> {
        /// Share of what an effect changes most in a section from which on it acts in a row. Set by hand.
        const ACTS: f64 = 0.05;
        let each = known.iter().map(|one| {
            let mut without = state.to_vec();
            without.remove(one.place);
            let trace = gate.change(record, &without);
            let most = |rows: std::ops::Range<usize>| -> f64 {
                trace[rows].iter().fold(0.0, |m, v| v.abs().max(m))
            };
            let rows = (gate.layout.sections().into_iter())
                .flat_map(|section| {
                    let least = ACTS * most(section.clone());
                    trace[section]
                        .iter()
                        .map(move |v| least > 0.0 && v.abs() > least)
                })
                .collect();
            let own = &state[one.place];
            let knots = own.is_correction() && seen_curve(own).is_none();
            // A shift that the other transmitter tells has no form to want.
            let told = own.effect.about().sensor().is_some() && record.outlets.len() == 2;
            Self {
                rows,
                evidence: if told { 0.0 } else { one.evidence },
                bent: one.bent,
                knots,
            }
        });
        each.collect()
    }

    /// Evidence that it leaves over for a candidate, which may be `knots` as well: what its form lacks is no second effect.
    pub(super) fn left_over(&self, signature: &[f64], knots: bool) -> f64 {
        let energy = |(v, _): (&f64, &bool)| v * v;
        let shared: f64 = (signature.iter().zip(&self.rows))
            .filter(|(_, acts)| **acts)
            .map(energy)
            .sum();
        let whole: f64 = signature.iter().zip(&self.rows).map(energy).sum();
        if whole > 0.0 {
            let times = if knots || self.knots { KNOTS_WANT } else { 1.0 };
            let form = times * LEFT_OVER * self.evidence.max(0.0).sqrt();
            // Knots fit what differs from stand to stand as well.
            let stands = WITHIN_STANDS * self.bent * if knots { KNOTS_WANT } else { 1.0 };
            (form + stands) * shared / whole
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Footprint, Known, WITHIN_STANDS, differs_along_stands, known};
    use crate::layout::Section;
    use crate::relations::Applied;
    use crate::selection::Selection;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, INFLUX_S, drilled};
    use dgd_effects::{Curve, KNOTS, Place, Quantity, find};

    /// A signature of four rows.
    const HERE: [f64; 4] = [3.0, 4.0, 0.0, 0.0];

    fn at(place: usize, evidence: f64) -> Known {
        Known {
            place,
            evidence,
            bent: 0.0,
        }
    }

    fn one(id: &str, parameters: &[f64]) -> Applied {
        Applied::new(find(id).unwrap(), parameters.to_vec())
    }

    #[test]
    fn strength_differs_along_stands_where_drilling_sets_it_and_not_where_a_stop_does() {
        let of = |id: &str| differs_along_stands(find(id).unwrap().about());
        assert!(of("cuttings_loading"));
        // At a stop there is only how much.
        assert!(!of("gel_strength") && !of("line_drainage"));
        assert!(!of("influx"));
    }

    #[test]
    fn what_a_form_lacks_is_left_over_where_it_acts_as_the_root_of_its_evidence() {
        let on = |rows: [bool; 4], evidence: f64| Footprint {
            rows: rows.to_vec(),
            evidence,
            bent: 0.0,
            knots: false,
        };
        let everywhere = on([true; 4], 100.0).left_over(&HERE, false);
        assert!(everywhere > 0.0);
        assert_eq!(
            on([true, true, false, false], 100.0).left_over(&HERE, false),
            everywhere
        );
        assert_eq!(
            on([false, false, true, true], 100.0).left_over(&HERE, false),
            0.0
        );
        // Three and four of a signature: nine and sixteen parts of its energy.
        let part = on([true, false, true, false], 100.0).left_over(&HERE, false);
        assert!((part / everywhere - 9.0 / 25.0).abs() < 1e-12);
        assert!((on([true; 4], 900.0).left_over(&HERE, false) / everywhere - 3.0).abs() < 1e-12);
        assert_eq!(on([true; 4], -1.0).left_over(&HERE, false), 0.0);
        assert_eq!(on([true; 4], 100.0).left_over(&[0.0; 4], false), 0.0);
        // What differs from stand to stand differs within them.
        let bent = Footprint {
            bent: 300.0,
            ..on([true; 4], 100.0)
        };
        assert!((bent.left_over(&HERE, false) - everywhere - 300.0 * WITHIN_STANDS).abs() < 1e-9);
    }

    #[test]
    fn an_effect_leaves_its_footprint_in_the_rows_that_it_changes() {
        let record = drilled(Hidden::default());
        let (from, lasts, rise) = INFLUX_S;
        let allowance = Applied {
            allowance: true,
            ..one("return_flow_delay", &[1.0])
        };
        let (flow, drag) = (
            one("influx", &[3e-3, from, lasts, rise]),
            one("line_restriction", &[5.0, 3000.0]),
        );
        let state = [allowance, flow.clone(), drag.clone()];
        let gate = Tangent::at(&record, &state, &[], Bend::Lean).unwrap();
        let all = Footprint::all(&record, &gate, &state, &[at(1, 40.0), at(2, 70.0)]);
        assert_eq!(
            all.iter().map(|f| f.evidence).collect::<Vec<_>>(),
            [40.0, 70.0]
        );
        let layout = gate.layout;
        for (row, acts) in all[0].rows.iter().enumerate() {
            let at = row
                .checked_sub(layout.rows(Section::Balance).start)
                .map(|k| 30.0 * (k as f64 + 0.5));
            let inside = at.is_some_and(|t| t > from && t < from + lasts);
            assert_eq!(*acts, inside, "{row}");
        }
        assert_eq!(all[1].rows.len(), layout.len());
        let acting = all[1].rows.iter().filter(|acts| **acts).count();
        assert!(
            acting > 0
                && all[1].rows[layout.rows(Section::Balance)]
                    .iter()
                    .all(|acts| !acts)
        );
    }

    #[test]
    fn a_shift_that_the_other_transmitter_tells_leaves_nothing_over() {
        let left = |outlets: usize| {
            let mut record = drilled(Hidden::default());
            record.outlets = vec![record.outlet.clone(); outlets];
            let state = [one("outlet_pressure_bias_step", &[5e4, 3000.0, 1.0])];
            let gate = Tangent::at(&record, &state, &[], Bend::Lean).unwrap();
            Footprint::all(&record, &gate, &state, &[at(0, 400.0)])[0].evidence
        };
        assert_eq!((left(1), left(2)), (400.0, 0.0));
    }

    #[test]
    fn knots_leave_five_times_as_much_over() {
        let record = drilled(Hidden::default());
        let knots = Curve::new(
            Place::Head,
            Quantity::Time,
            (0.0, record.setting.span_s.1),
            vec![1e4; KNOTS],
        );
        let state = [
            Applied::from(&knots),
            one("line_restriction", &[5.0, 3000.0]),
        ];
        let gate = Tangent::at(&record, &state, &[], Bend::Lean).unwrap();
        let all = Footprint::all(&record, &gate, &state, &[at(0, 40.0), at(1, 40.0)]);
        assert!(all[0].knots && !all[1].knots);
    }

    #[test]
    fn of_a_model_to_start_from_counts_what_the_recording_shows() {
        let (from, lasts, rise) = INFLUX_S;
        let record = drilled(Hidden {
            influx_m3_s: 3e-3,
            ..Hidden::default()
        });
        // A delay as models hold it for timing, the influx, and a restriction that is not there.
        let state = vec![
            one("return_flow_delay", &[0.5]),
            one("influx", &[3e-3, from, lasts, rise]),
            one("line_restriction", &[1e-3, 3000.0]),
        ];
        let of = |held: usize| {
            let selection = Selection {
                held,
                allowances: state.clone(),
                named: Vec::new(),
                first: Vec::new(),
                stays: false,
            };
            known(&record, &state, &selection).unwrap()
        };
        let counted = of(3);
        assert_eq!(counted.len(), 1);
        assert_eq!(counted[0].place, 1);
        assert!(counted[0].evidence > 100.0, "{counted:?}");
        // What is allowed for beside it counts for nothing.
        assert!(of(0).is_empty());
    }
}
