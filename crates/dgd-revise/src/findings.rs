//! Findings in words and numbers, what cannot be told apart, and how every effect fared.

use crate::baseline::fresh_jacobian;
use crate::belief;
use crate::chain::{Claim, Withdrawn};
use crate::checks::placebo;
use crate::choice::stands_in;
use crate::conclude::Evidence;
use crate::context::Trial;
use crate::empirical::{self, Corrected, Place};
use crate::estimates::estimates;
use crate::floor::Level;
use crate::locate;
use crate::revision::{Check, Class, Estimate, Finding, Outcome, Shape, Tested};
use crate::screen::SHOWS;
use crate::sets::Scored;
use crate::stack::Row;
use crate::strength;
use crate::tangent::dot;
use crate::validate::Folds;
use dgd_assembly::About;

/// A quantity along which a finding may lie, by window and sample.
type Quantity = (String, Vec<Vec<f64>>);

/// What a member of the claimed set rests on.
pub(crate) struct Standing {
    pub member: usize,
    /// The set without it.
    without: Option<Scored>,
    /// Probability, alone and with what does as well in its place.
    alone: f64,
    pub together: f64,
}

/// - `unexplained`: share of the squares the set leaves that is no noise.
pub(crate) fn standings(
    e: &Evidence<'_, '_>,
    chosen: usize,
    unexplained: f64,
    folds: &Folds,
) -> Vec<Standing> {
    let set = &e.scored[chosen];
    let weights = belief::weights(&e.scored, chosen, &e.refused);
    let together = belief::of_members(&e.scored, chosen, &e.refused);
    let of = |(member, together): (usize, f64)| {
        let without = e.reduced_set(chosen, member, folds);
        let mean = set.left.mean().max(1e-300);
        let loss = without.as_ref().map_or((f64::NAN, f64::NAN), |w| {
            let (loss, error) = w.left.less(&set.left);
            (loss / mean, error / mean)
        });
        let holds = |s: &Scored| s.trial.members.contains(&member);
        let alone: f64 = e
            .scored
            .iter()
            .zip(&weights)
            .filter(|(s, _)| holds(s))
            .map(|(_, w)| w)
            .sum();
        let tempered = |weight: f64| belief::tempered(weight, loss, unexplained);
        Standing {
            member,
            without,
            alone: tempered(alone.min(1.0)),
            together: tempered(together),
        }
    };
    together.into_iter().map(of).collect()
}

/// Findings, and what is part of the model with too little weight for one.
pub(crate) fn findings(
    e: &Evidence<'_, '_>,
    claim: &Claim,
    trial: &Trial,
    standing: Vec<Standing>,
    checks: &mut Vec<Check>,
) -> (Vec<Finding>, Vec<Finding>) {
    let c = e.context;
    let (mut all, mut doubtful) = (Vec::new(), Vec::new());
    let quantities = empirical::quantities(
        c,
        c.data,
        &e.base_trial.members,
        &e.base_trial.minimum.theta,
    )
    .unwrap_or_default();
    if let Some(k) = claim.set {
        let left = &e.scored[k].left;
        let estimates =
            fresh_jacobian(c, trial).map_or_else(Vec::new, |j| estimates(c, trial, &j, left));
        for one in &standing {
            if let Some(without) = &one.without {
                checks.push(placebo(e, &without.trial, one.member));
            }
            let list = if one.together < belief::LIKELY {
                &mut doubtful
            } else {
                &mut all
            };
            list.push(named(e, k, one, &estimates, &quantities));
        }
        for list in [&mut all, &mut doubtful] {
            list.sort_by(|a, b| b.left_out_loss.total_cmp(&a.left_out_loss));
        }
    }
    if let Some(correction) = &claim.correction {
        all.push(corrected(e, claim.set, correction, trial, &quantities));
    }
    if all.is_empty() && e.is_left_out(claim) {
        all.push(left_out(e, claim));
    }
    (all, doubtful)
}

/// A member of the chosen set as a finding, with the set's `estimates`.
fn named(
    e: &Evidence<'_, '_>,
    chosen: usize,
    standing: &Standing,
    estimates: &[Estimate],
    quantities: &[Quantity],
) -> Finding {
    let c = e.context;
    let set = &e.scored[chosen];
    let h = &c.hypotheses[standing.member];
    let about = h.law.about();
    let without = standing.without.as_ref();
    let (loss, error) = without.map_or((f64::NAN, f64::NAN), |w| w.left.less(&set.left));
    let rows = &set.trial.minimum.residuals;
    let reduced = without.map(|w| &w.trial.minimum.residuals);
    let alternatives = e.alternatives(chosen, standing.member);
    let rivals: Vec<Vec<usize>> = alternatives.iter().map(|(other, _)| vec![*other]).collect();
    let prefix = format!("{}.{}.", h.component, h.effect);
    let own = estimates.iter().filter(|p| p.path.starts_with(&prefix));
    let parameters = own.map(|p| {
        let name = &p.path[prefix.len()..];
        let known = about.parameters.iter().find(|a| a.name == name);
        Estimate {
            meaning: known.map_or("", |a| a.meaning).into(),
            ..p.clone()
        }
    });
    Finding {
        effect: h.effect.into(),
        component: h.component.clone(),
        title: about.title.into(),
        equation: about.equation.into(),
        source: about.source.into(),
        parameters: parameters.collect(),
        intervals: reduced.map_or_else(Vec::new, |b| locate::intervals(c.data, b, rows)),
        region: reduced.and_then(|b| locate::region(c.data, b, rows, quantities)),
        left_out_loss: loss / set.left.mean(),
        standard_errors: loss / error,
        probability: Some(belief::calibrated(standing.alone)),
        probability_with_alternatives: Some(belief::calibrated(standing.together)),
        alternatives: (alternatives.into_iter())
            .map(|(other, worse)| (e.name(other), worse))
            .collect(),
        separating_test: separating(e, &[standing.member], &rivals),
        slight: strength::slight(h, estimates),
        shape: None,
    }
}

/// A correction, on top of the chosen set or of the base, as a finding; `plain` is fitted without it.
fn corrected(
    e: &Evidence<'_, '_>,
    chosen: Option<usize>,
    k: &Corrected,
    plain: &Trial,
    quantities: &[Quantity],
) -> Finding {
    let c = e.context;
    let along = &k.candidate.along;
    let (of, what, equation) = match &k.candidate.place {
        Place::Output(o) => {
            let of = c.assembly.outputs()[*o].clone();
            let equation = format!("{of} = model + f({along})");
            (of, "reading", equation)
        }
        Place::Inflow(component) => (
            component.clone(),
            "balance",
            format!("inflow of {component} = model + f({along})"),
        ),
    };
    let before = chosen.map_or(&e.base_left, |k| &e.scored[k].left);
    let (loss, error) = before.less(&k.left);
    let (rows, plain) = (&k.minimum.residuals, &plain.minimum.residuals);
    Finding {
        effect: "unknown".into(),
        component: of.clone(),
        title: format!("something outside the catalogue: the {what} of {of} depends on {along}"),
        equation,
        source: "piecewise linear, no physics".into(),
        parameters: Vec::new(),
        intervals: locate::intervals(c.data, plain, rows),
        region: locate::region(c.data, plain, rows, quantities),
        left_out_loss: loss / k.left.mean(),
        standard_errors: loss / error,
        probability: None,
        probability_with_alternatives: None,
        alternatives: Vec::new(),
        separating_test: None,
        slight: false,
        shape: Some(Shape {
            of,
            along: along.clone(),
            knots: k.candidate.knots.clone(),
            values: k.values.clone(),
        }),
    }
}

/// What no effect and no correction tells, although it is there.
fn left_out(e: &Evidence<'_, '_>, claim: &Claim) -> Finding {
    let mut far: Vec<&Level> = e.levels.iter().filter(|l| l.far()).collect();
    far.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    let title = match claim.withdrawn {
        Some(Withdrawn::NotRun) => {
            "something is left out, but what fits the training part better cannot be simulated on the test part"
        }
        Some(Withdrawn::Worse) => {
            "something is left out, but what fits the training part better does not fit the test part better"
        }
        Some(Withdrawn::Chance) => {
            "something is left out, but what fits the training part better improves no instrument on the test part by more than chance"
        }
        Some(Withdrawn::Outweighed) => {
            "something is left out, but no effect that could be named has a weight of half or more, less chance and what stays unexplained"
        }
        None => {
            "something is left out, but no effect and no correction improves the left-out blocks"
        }
    };
    let rows = &e.base_trial.minimum.residuals;
    unnamed(e, e.base_trial, rows, &far, title)
}

/// An `unknown` at the instrument that lies far above its noise; without a place if there are several, which are told, or none.
///
/// - `rows`: training residuals of the fitted `trial`.
pub(crate) fn unnamed(
    e: &Evidence<'_, '_>,
    trial: &Trial,
    rows: &[f64],
    far: &[&Level],
    title: &str,
) -> Finding {
    let c = e.context;
    let names = c.assembly.outputs();
    let said: Vec<String> = far
        .iter()
        .map(|l| format!("{} {:.1} times", names[l.output], l.ratio()))
        .collect();
    let (mut intervals, mut region) = (Vec::new(), None);
    if !far.is_empty() {
        let of = |(row, r): (&Row, &f64)| {
            let there = far.iter().any(|l| l.output == row.output);
            if there { *r } else { 0.0 }
        };
        let before: Vec<f64> = c.data.rows.iter().zip(rows).map(of).collect();
        let after = vec![0.0; before.len()];
        intervals = locate::intervals(c.data, &before, &after);
        let (members, theta) = (&trial.members, &trial.minimum.theta);
        let quantities = empirical::quantities(c, c.data, members, theta).unwrap_or_default();
        region = locate::region(c.data, &before, &after, &quantities);
    }
    Finding {
        effect: "unknown".into(),
        component: match far {
            [only] => names[only.output].clone(),
            // The largest error often sits downstream of what is wrong.
            _ => String::new(),
        },
        title: if said.is_empty() {
            title.into()
        } else {
            format!("{title}: error larger than the noise, {}", said.join(", "))
        },
        equation: String::new(),
        source: String::new(),
        parameters: Vec::new(),
        intervals,
        region,
        left_out_loss: f64::NAN,
        standard_errors: f64::NAN,
        probability: None,
        probability_with_alternatives: None,
        alternatives: Vec::new(),
        separating_test: None,
        slight: false,
        shape: None,
    }
}

impl Evidence<'_, '_> {
    /// The chosen set without one member; fitted and scored if it was not, but not added to what is scored.
    fn reduced_set(&self, chosen: usize, member: usize, folds: &Folds) -> Option<Scored> {
        let set = &self.scored[chosen].trial;
        let rest = set.others(member);
        if let Some(known) = self.scored.iter().find(|s| s.trial.members == rest) {
            return Some(known.clone());
        }
        let trial = self
            .context
            .fit(&rest, &set.values(), crate::baseline::FULL)?;
        let left = folds.of_trial(self.context, &trial)?;
        Some(Scored { trial, left })
    }

    /// What left-out blocks do not tell from a member in its place.
    fn alternatives(&self, chosen: usize, member: usize) -> Vec<(usize, f64)> {
        let set = &self.scored[chosen];
        let rest = set.trial.others(member);
        let mut found: Vec<(usize, f64)> = Vec::new();
        for s in &self.scored {
            let m = &s.trial.members;
            if m.len() != set.trial.members.len() || !rest.iter().all(|r| m.contains(r)) {
                continue;
            }
            let Some(&other) = m.iter().find(|o| !rest.contains(o) && **o != member) else {
                continue;
            };
            let (more, _) = s.left.less(&set.left);
            if stands_in(&self.scored, s, set) && found.iter().all(|f| f.0 != other) {
                found.push((other, more / set.left.mean()));
            }
        }
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        found
    }
}

pub(crate) fn classes(e: &Evidence<'_, '_>, claim: &Claim) -> Vec<Class> {
    let Some(k) = claim.set else {
        return Vec::new();
    };
    let chosen = &e.scored[k];
    let size = chosen.trial.members.len();
    let residual = chosen.trial.minimum.residuals.as_slice();
    let rms = dot(residual, residual).sqrt();
    let mut alike: Vec<&Scored> = e
        .scored
        .iter()
        .filter(|s| s.trial.members.len() == size && s.trial.members != chosen.trial.members)
        .filter(|s| stands_in(&e.scored, s, chosen))
        .collect();
    if alike.is_empty() {
        return Vec::new();
    }
    alike.sort_by(|a, b| a.left.mean().total_cmp(&b.left.mean()));
    let mut class = Class {
        members: vec![e.names(&chosen.trial.members)],
        apart: vec![0.0],
        separating_test: None,
    };
    let mut rivals = Vec::new();
    for s in alike {
        let names = e.names(&s.trial.members);
        if class.members.contains(&names) {
            continue;
        }
        let d: Vec<f64> = s
            .trial
            .minimum
            .residuals
            .iter()
            .zip(residual)
            .map(|(a, b)| a - b)
            .collect();
        class.members.push(names);
        class.apart.push(dot(&d, &d).sqrt() / rms);
        rivals.push(s.trial.members.clone());
    }
    class.separating_test = separating(e, &chosen.trial.members, &rivals);
    vec![class]
}

/// What would tell a set from its rivals.
pub(crate) fn separating(
    e: &Evidence<'_, '_>,
    set: &[usize],
    rivals: &[Vec<usize>],
) -> Option<String> {
    let about = |members: &[usize]| -> Vec<(usize, &'static About)> {
        let each = members.iter();
        each.map(|m| (*m, e.context.hypotheses[*m].law.about()))
            .collect()
    };
    let rivals: Vec<_> = rivals.iter().map(|r| about(r)).collect();
    test_between(&about(set), &rivals)
}

/// What the catalogue says of telling a set from the first of its rivals of which it says so, by a member of each that the other has not;
/// what shows the set best where it says so of none, and nothing where there is no rival.
fn test_between(set: &[(usize, &About)], rivals: &[Vec<(usize, &About)>]) -> Option<String> {
    let known = |a: &About, b: &About| {
        let ways = [(a, b), (b, a)];
        let ways = ways.map(|(x, y)| x.confusable.iter().find(|(id, _)| *id == y.id));
        ways.into_iter().flatten().map(|(_, test)| *test).next()
    };
    for rival in rivals {
        for (_, mine) in set.iter().filter(|m| rival.iter().all(|n| n.0 != m.0)) {
            let mut theirs = rival.iter().filter(|n| set.iter().all(|m| m.0 != n.0));
            let test = theirs.find_map(|n| known(mine, n.1));
            if let Some(test) = test {
                return Some(test.to_owned());
            }
        }
    }
    // Not foreseen by the catalogue.
    let first = rivals.first()?;
    let mine = set.iter().find(|m| first.iter().all(|n| n.0 != m.0))?;
    Some(format!("more of: {}", mine.1.excited_by))
}

pub(crate) fn tested(
    e: &Evidence<'_, '_>,
    findings: &[Finding],
    doubtful: &[Finding],
) -> Vec<Tested> {
    e.screened
        .iter()
        .map(|s| {
            let h = &e.context.hypotheses[s.number];
            let name = e.name(s.number);
            let first = h.parameters.first();
            let reach = first.map_or(0.0, |p| {
                (p.high - p.neutral).abs().max((p.neutral - p.low).abs())
            });
            let names = |list: &[Finding]| {
                list.iter()
                    .any(|f| f.effect == h.effect && f.component == h.component)
            };
            let outcome = if names(findings) {
                Outcome::Found
            } else if names(doubtful) {
                Outcome::Possible
            } else if findings
                .iter()
                .any(|f| f.alternatives.iter().any(|a| a.0 == name))
            {
                Outcome::Alternative
            } else if s.absorbed() {
                Outcome::Absorbed
            } else if !s.moves || (s.limit.is_finite() && s.limit > reach) {
                Outcome::NotTestable
            } else if s.score.sqrt() >= SHOWS && !findings.is_empty() {
                Outcome::NotNeeded
            } else {
                Outcome::NotSeen
            };
            Tested {
                component: h.component.clone(),
                effect: h.effect,
                title: h.law.about().title,
                outcome,
                gain: s.gain,
                score: s.score.sqrt(),
                limit: (s.usable() && s.limit.is_finite()).then_some(s.limit),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::test_between;
    use dgd_assembly::effects;

    #[test]
    fn a_test_is_that_of_a_pair_at_hand_from_either_side_or_says_what_shows_the_effect() {
        let of = |id: &str| effects::find(id).unwrap().about();
        let between = |rivals: &[&str]| {
            let rivals: Vec<_> = (1..).zip(rivals).map(|(n, r)| vec![(n, of(r))]).collect();
            test_between(&[(0, of("opening_play"))], &rivals)
        };
        // The catalogue has it under stiction alone.
        let own = of("opening_play").confusable;
        assert!(own.iter().all(|(id, _)| *id != "opening_stiction"));
        let test = between(&["opening_stiction"]).unwrap();
        assert!(test.contains("without a jump"), "{test}");
        assert_eq!(between(&["vortex", "opening_stiction"]).unwrap(), test);
        let none = between(&["vortex"]).unwrap();
        assert!(none.starts_with("more of: an opening that turns"), "{none}");
        assert_eq!(between(&[]), None);
    }

    #[test]
    fn what_both_sets_hold_is_told_from_nothing() {
        let of = |id: &str| effects::find(id).unwrap().about();
        let play = (0, of("opening_play"));
        let (set, rival) = ([play, (1, of("vortex"))], vec![play, (2, of("taper"))]);
        let test = test_between(&set, &[rival]).unwrap();
        assert!(!test.contains("opening"), "{test}");
    }
}
