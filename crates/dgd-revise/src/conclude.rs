//! From what was weighed to what is said.

use crate::baseline::{Baseline, fresh_jacobian};
use crate::belief;
use crate::chain::{Claim, Withdrawn};
use crate::checks::{bounds_check, confirmation, gate_checks, outweighs, remainder, whiteness};
use crate::confirm::{self, Readings, TestPart};
use crate::context::{Context, Trial};
use crate::error::ReviseError;
use crate::estimates::estimates;
use crate::findings::{Standing, classes, findings, standings, tested, unnamed};
use crate::floor::{self, Level};
use crate::revision::{
    Check, Contender, Excuse, Model, Options, OutputGain, Revision, Signal, Stage, Trace, Verdict,
};
use crate::screen::Screened;
use crate::sets::Scored;
use crate::stack::{Data, Row, Runner};
use crate::validate::{Folds, LeftOut};
use crate::{empirical, sections, strength};
use std::collections::BTreeSet;

/// Everything weighed.
pub(crate) struct Evidence<'c, 'a> {
    pub context: &'c Context<'a>,
    pub options: &'c Options,
    pub test: &'c TestPart,
    pub in_time: bool,
    pub memory: usize,
    pub base: &'c Baseline,
    pub base_trial: &'c Trial,
    pub base_left: LeftOut,
    pub screened: &'c [Screened],
    pub gate: [f64; 5],
    /// The re-fitted base beside the noise, by instrument.
    pub levels: Vec<Level>,
    /// Why what is left of the base does not matter, if it does not.
    pub excuse: Option<Excuse>,
    /// What was chosen and has too little weight to be claimed.
    pub unlikely: Vec<(usize, f64)>,
    /// All sets that were scored; the base first, if any.
    pub scored: Vec<Scored>,
    /// Those of them that did not stand their placebo.
    pub refused: BTreeSet<usize>,
    pub claim: Claim,
}

/// What a model says over both parts.
pub(crate) struct Told {
    pub train: Readings,
    pub test: Option<Readings>,
    /// Training residuals in rows, scaled.
    pub rows: Vec<f64>,
}

impl Evidence<'_, '_> {
    /// Whether any of some probabilities of the gate is too small for chance.
    pub(crate) fn open(&self, of: &[f64]) -> bool {
        of.iter()
            .any(|p| self.gate.len() as f64 * p <= self.options.gate)
    }

    /// Whether a score of the gate is more than chance, or the memory is none that an instrument has of its own.
    pub(crate) fn stands_out(&self) -> bool {
        let open = self.open(&self.gate[..self.gate.len() - 1]);
        self.excuse.is_none() && (open || self.levels.iter().any(Level::unexcused))
    }

    /// Whether something is left out that nothing was found for: it stands out, or what explained it on the training part is withdrawn
    /// and an instrument lies far above its noise.
    pub(crate) fn is_left_out(&self, claim: &Claim) -> bool {
        let far = self.excuse.is_none() && self.levels.iter().any(Level::far);
        self.stands_out() || (claim.withdrawn.is_some() && far)
    }

    /// What a model leaves of each instrument, on the training and on the test part.
    fn left(&self, after: &Told) -> [Vec<Level>; 2] {
        let c = self.context;
        let outputs = c.scale.len();
        let train = floor::plain(c.data, &after.rows, outputs, &c.scale, &[]);
        let mut held = Vec::new();
        if let Some(test) = &after.test {
            let of = |row: &Row| test[row.window][row.output][row.sample];
            let rows = self.test.data.rows.iter().zip(&self.test.data.measured);
            let off: Vec<f64> = rows
                .map(|(row, m)| (of(row) - m) / c.scale[row.output])
                .collect();
            held = floor::plain(&self.test.data, &off, outputs, &c.scale, &[]);
        }
        [train, held]
    }

    /// Share of the squares left that is neither noise nor within the stated accuracy, on the part where it is greater.
    fn unexplained(&self, after: &Told) -> f64 {
        let accuracies = self.context.assembly.accuracies();
        let mut parts = self.left(after);
        for l in parts.iter_mut().flatten() {
            let accuracy = accuracies[l.output].unwrap_or(0.0);
            l.floor = l.floor.max(accuracy / self.context.scale[l.output]);
        }
        let shares = parts.iter().map(|l| floor::unexplained(l));
        shares.fold(0.0, f64::max)
    }

    /// Instruments that a named set leaves far above their noise, on the training or the test part, worst first.
    fn poor(&self, after: &Told) -> Vec<Level> {
        let c = self.context;
        let accuracies = c.assembly.accuracies();
        let mut all = self.left(after).concat();
        all.retain(|l| {
            let off = l.rms * c.scale[l.output];
            l.poor() && accuracies[l.output].is_none_or(|a| off > a)
        });
        all.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
        let mut seen = BTreeSet::new();
        all.retain(|l| seen.insert(l.output));
        all
    }

    /// The set that is claimed, or the base.
    fn trial(&self, claim: &Claim) -> &Trial {
        claim.set.map_or(self.base_trial, |k| &self.scored[k].trial)
    }

    pub(crate) fn name(&self, m: usize) -> String {
        let h = &self.context.hypotheses[m];
        format!("{}.{}", h.component, h.effect)
    }

    pub(crate) fn names(&self, members: &[usize]) -> Vec<String> {
        members.iter().map(|&m| self.name(m)).collect()
    }

    fn tell(&self, trial: &Trial, claim: &Claim) -> Option<Told> {
        let c = self.context;
        // Beside names a correction is told, not run: the model after is the one that can be written down.
        let correction = claim.correction.as_ref().filter(|_| claim.set.is_none());
        let train = match correction {
            None => {
                let built = c.build(&trial.members)?;
                Runner::new(&built, c.data, &c.simulation)
                    .ok()?
                    .outputs(&trial.minimum.theta)?
            }
            Some(k) => {
                let theta = &k.minimum.theta[..trial.paths.len()];
                empirical::run_corrected(c, c.data, &trial.members, theta, &k.candidate, &k.values)?
            }
        };
        let test = if self.test.data.windows.is_empty() {
            None
        } else {
            match correction {
                None => confirm::run_test(c, trial, None, self.test),
                Some(k) => {
                    let mut own = trial.clone();
                    own.minimum.theta = k.minimum.theta[..trial.paths.len()].to_vec();
                    confirm::run_test(c, &own, Some((k, trial)), self.test)
                }
            }
        };
        let simulated = c
            .data
            .rows
            .iter()
            .map(|row| train[row.window][row.output][row.sample])
            .collect();
        Some(Told {
            train,
            test,
            rows: c.residual(simulated),
        })
    }
}

pub(crate) fn conclude(
    mut evidence: Evidence<'_, '_>,
    folds: &Folds,
    watch: &mut dyn FnMut(Stage),
) -> Result<Revision, ReviseError> {
    watch(Stage::Confirming);
    let nothing = Claim::default();
    let before = evidence
        .tell(evidence.base_trial, &nothing)
        .ok_or(ReviseError::NotRun)?;
    let (claim, slight) = firm(&mut evidence, folds);
    let e = &evidence;
    let mut checks = gate_checks(e, &slight);
    let Held {
        claim,
        trial,
        after,
        standing,
        withdrawn,
    } = hold(e, claim, &before, folds, &mut checks)?;
    let left_after = match (claim.set, &claim.correction) {
        (Some(k), _) => &e.scored[k].left,
        (None, Some(k)) => &k.left,
        _ => &e.base_left,
    };
    let (mut findings, doubtful) = findings(e, &claim, &trial, standing, &mut checks);
    if claim.set.is_some() {
        bounds_check(e, &trial, left_after, &mut checks);
    }
    let mut verdict = verdict(e, &claim);
    if verdict == Verdict::Explained {
        let poor = e.poor(&after);
        checks.push(remainder(e, &poor));
        if !poor.is_empty() {
            verdict = Verdict::PartlyExplained;
            findings.push(unnamed(
                e,
                &trial,
                &after.rows,
                &poor.iter().collect::<Vec<_>>(),
                "something else is left out",
            ));
        }
    }
    whiteness(e, &after.rows, &mut checks);
    // What is consistent holds throughout.
    let sections = if e.in_time || verdict == Verdict::Consistent {
        Vec::new()
    } else {
        sections::sections(e.context, &trial, &e.scored, e)
    };
    if sections.len() > 1 {
        checks.push(Check {
            name: "one cause holds throughout".into(),
            passed: false,
            detail: format!("{} sections with parameters of their own", sections.len()),
        });
    }
    let excused = (e.excuse).filter(|_| verdict == Verdict::Consistent && e.open(&e.gate));
    Ok(Revision {
        verdict,
        excused,
        tested: tested(e, &findings, &doubtful),
        findings,
        also_possible: doubtful,
        classes: classes(e, &claim),
        checks,
        contenders: contenders(e),
        before: model(e, e.base_trial, &e.base_left)?,
        // A correction is part of no model: without a set these are the base's parameters, and its folds tell of them.
        after: model(e, &trial, claim.set.map_or(&e.base_left, |_| left_after))?,
        outputs: gains(e, &before, &after, left_after),
        traces: traces(e, &before, &after),
        sections,
        settings: settings(e, &withdrawn),
    })
}

/// The claim without members that may as well be none, and those.
fn firm(e: &mut Evidence<'_, '_>, folds: &Folds) -> (Claim, Vec<usize>) {
    let mut claim = std::mem::take(&mut e.claim);
    let mut slight = Vec::new();
    // A correction was fitted on top of the whole set.
    if let (Some(k), None) = (claim.set, &claim.correction) {
        let (rest, gone) = strength::firm(e.context, e.memory, folds, &mut e.scored, k);
        claim.set = Some(rest);
        slight = gone;
    }
    (claim, slight)
}

/// What is claimed after the test part was seen.
struct Held {
    claim: Claim,
    trial: Trial,
    after: Told,
    standing: Vec<Standing>,
    /// Names that were claimed before.
    withdrawn: Vec<String>,
}

/// The claim, or nothing where something speaks against it.
fn hold(
    e: &Evidence<'_, '_>,
    claim: Claim,
    before: &Told,
    folds: &Folds,
    checks: &mut Vec<Check>,
) -> Result<Held, ReviseError> {
    let trial = e.trial(&claim);
    let after = e.tell(trial, &claim).ok_or(ReviseError::NotRun)?;
    let (why, standing) = objection(e, &claim, (before, &after), folds, checks);
    if why.is_none() {
        return Ok(Held {
            trial: trial.clone(),
            claim,
            after,
            standing,
            withdrawn: Vec::new(),
        });
    }
    let nothing = Claim {
        withdrawn: why,
        ..Claim::default()
    };
    Ok(Held {
        after: (e.tell(e.base_trial, &nothing)).ok_or(ReviseError::NotRun)?,
        trial: e.base_trial.clone(),
        claim: nothing,
        standing: Vec::new(),
        withdrawn: e.names(&trial.members),
    })
}

/// Why a claim is withdrawn, if it is, and what its members rest on.
fn objection(
    e: &Evidence<'_, '_>,
    claim: &Claim,
    (before, after): (&Told, &Told),
    folds: &Folds,
    checks: &mut Vec<Check>,
) -> (Option<Withdrawn>, Vec<Standing>) {
    if claim.set.is_none() && claim.correction.is_none() {
        return (None, Vec::new());
    }
    let why = confirmation(e, before, after, checks);
    let (None, Some(k)) = (why, claim.set) else {
        return (why, Vec::new());
    };
    let unexplained = e.unexplained(after);
    let standing = standings(e, k, unexplained, folds);
    let surest = standing.iter().map(|s| s.together).fold(0.0, f64::max);
    let outweighed = surest < belief::LIKELY;
    checks.push(outweighs(e, &standing, unexplained, !outweighed));
    (outweighed.then_some(Withdrawn::Outweighed), standing)
}

fn verdict(e: &Evidence<'_, '_>, claim: &Claim) -> Verdict {
    match (claim.set.is_some(), claim.correction.is_some()) {
        (true, true) => Verdict::PartlyExplained,
        (true, false) => Verdict::Explained,
        (false, true) => Verdict::Unexplained,
        (false, false) if e.is_left_out(claim) => Verdict::Unexplained,
        (false, false) => Verdict::Consistent,
    }
}

fn contenders(e: &Evidence<'_, '_>) -> Vec<Contender> {
    let Some(first) = e.scored.first() else {
        return Vec::new();
    };
    let mut order: Vec<&Scored> = e.scored.iter().collect();
    order.sort_by(|a, b| a.left.mean().total_cmp(&b.left.mean()));
    let best = order[0];
    let base = first.left.mean();
    order
        .iter()
        .map(|s| Contender {
            members: e.names(&s.trial.members),
            training: (s.trial.cost() / first.trial.cost()).sqrt(),
            left_out: (s.left.mean() / base).sqrt(),
            standard_error: s.left.less(&best.left).1 / base,
        })
        .collect()
}

fn model(e: &Evidence<'_, '_>, trial: &Trial, left: &LeftOut) -> Result<Model, ReviseError> {
    let asked = e.context.as_asked();
    let built = asked.build(&trial.members).ok_or(ReviseError::NotRun)?;
    let (paths, theta, _) = Context::start(&built, &trial.values()).ok_or(ReviseError::NotRun)?;
    let jacobian = fresh_jacobian(e.context, trial).ok_or(ReviseError::NotRun)?;
    let mut parameters = estimates(e.context, trial, &jacobian, left);
    parameters.retain(|p| paths.contains(&p.path));
    Ok(Model {
        assembly: built.with_values(&theta)?,
        theta,
        parameters,
    })
}

fn gains(e: &Evidence<'_, '_>, before: &Told, after: &Told, left: &LeftOut) -> Vec<OutputGain> {
    let c = e.context;
    c.assembly
        .outputs()
        .into_iter()
        .enumerate()
        .map(|(o, output)| {
            let test = |t: &Told| {
                t.test
                    .as_ref()
                    .map_or(f64::NAN, |r| confirm::rms(r, &e.test.data, o))
            };
            let by = |l: &LeftOut| (l.by_output[o].0 / l.by_output[o].1).sqrt() * c.scale[o];
            OutputGain {
                output,
                training: (
                    c.data.rms(&before.rows, o) * c.scale[o],
                    c.data.rms(&after.rows, o) * c.scale[o],
                ),
                left_out: (by(&e.base_left), by(left)),
                test: (test(before), test(after)),
                test_gain_ci95: match (&before.test, &after.test) {
                    (Some(b), Some(a)) => confirm::gain_interval(b, a, &e.test.data, o, e.memory),
                    _ => (f64::NAN, f64::NAN),
                },
            }
        })
        .collect()
}

fn traces(e: &Evidence<'_, '_>, before: &Told, after: &Told) -> Vec<Trace> {
    let names = e.context.assembly.outputs();
    let part = |data: &Data, before: &Readings, after: &Readings, test: bool| -> Vec<Trace> {
        data.windows
            .iter()
            .enumerate()
            .map(|(w, window)| Trace {
                test,
                time: window.time.clone(),
                outputs: names
                    .iter()
                    .enumerate()
                    .map(|(o, name)| Signal {
                        output: name.clone(),
                        measured: window.readings[o].clone(),
                        before: before[w][o].clone(),
                        after: after[w][o].clone(),
                    })
                    .collect(),
            })
            .collect()
    };
    let mut all = part(e.context.data, &before.train, &after.train, false);
    if let (Some(b), Some(a)) = (&before.test, &after.test) {
        all.extend(part(&e.test.data, b, a, true));
    }
    all
}

fn settings(e: &Evidence<'_, '_>, withdrawn: &[String]) -> Vec<(String, String)> {
    let mut all = vec![
        (
            "training readings".into(),
            e.context.data.rows.len().to_string(),
        ),
        ("test readings".into(), e.test.data.rows.len().to_string()),
        ("hypotheses".into(), e.context.hypotheses.len().to_string()),
        ("sets fitted to the end".into(), e.scored.len().to_string()),
        (
            "memory of the base's residual, samples".into(),
            e.memory.to_string(),
        ),
    ];
    for (name, ar) in e.context.assembly.outputs().iter().zip(&e.base.noise.of) {
        let a: Vec<String> = ar.a.iter().map(|a| format!("{a:.3}")).collect();
        all.push((format!("autoregression of {name}"), a.join(" ")));
    }
    for (name, held) in (e.context.assembly.outputs().iter()).zip(&e.context.data.held) {
        if *held > 1 {
            let told = format!("samples over which the log repeats {name}, counted once");
            all.push((told, held.to_string()));
        }
    }
    if !withdrawn.is_empty() {
        all.push(("withdrawn".into(), withdrawn.join(", ")));
    }
    all
}
