//! From residuals to named effects: screening, acceptance one by one, joint refinement, second thoughts.

use crate::empirical::{Correction, corrections};
use crate::record::{Record, whole};
use crate::relations::Applied;
use crate::scan::{Candidate, allowances_with, joined, ln_mean_exp, on_grid, scan, sharpen, weigh};
use crate::tangent::{Bend, Tangent, dot};
use dgd_effects::{Effect, RELATIONS, Relation, Role, catalogue};

/// A named effect.
#[derive(Clone)]
pub(crate) struct Named {
    pub applied: Applied,
    pub evidence: f64,
    pub probability: f64,
    pub alternatives: Vec<(String, f64)>,
    /// Relation and quantity, where it is an empirical correction.
    pub correction: Option<(usize, usize)>,
}

/// The outcome of the search.
pub(crate) struct Selection {
    pub allowances: Vec<Applied>,
    pub named: Vec<Named>,
    /// First-round evidence and the energy of a unit of strength, by effect.
    pub first: Vec<(&'static str, f64, f64)>,
}

impl Selection {
    /// The full hypothesis.
    pub(crate) fn state(&self) -> Vec<Applied> {
        let mut out = self.allowances.clone();
        for n in &self.named {
            out = joined(&out, &n.applied);
        }
        out
    }
}

/// What an effect must show before it is believed: evidence that sound recordings do not reach, and the scale on which
/// belief grows beyond it. Set by hand on simulated recordings, clean ones and others; what they are worth, `cargo xtask prove` tells on
/// seeds that were not looked at.
pub(crate) fn hurdle(id: &str) -> (f64, f64) {
    match id {
        "gas_in_pump" => (58.0, 40.0),
        "pump_wear" => (90.0, 40.0),
        "pump_speed_lag" => (35.0, 10.0),
        "gel_strength" => (15.0, 6.0),
        "return_flow_delay" | "line_gas_storage" => (25.0, 6.0),
        "outlet_pressure_bias_step" => (20.0, 6.0),
        "line_leak" | "line_restriction" => (30.0, 6.0),
        "pipe_displacement" => (24.0, 6.0),
        "influx" => (14.0, 4.0),
        "mud_density_change" => (14.0, 4.0),
        "annulus_area" => (12.0, 4.0),
        "yield_stress" => (5.0, 2.0),
        "outlet_pressure_bias" => (29.0, 5.0),
        _ => (9.0, 3.0),
    }
}

/// The smallest strength that is more than an instrument's accuracy.
fn material(c: &Applied) -> bool {
    let a = c.parameters[0].abs();
    match c.effect.about().id {
        "outlet_pressure_bias" | "outlet_pressure_bias_step" => a > 1.05e4,
        "return_flow_gain" | "inflow_gain" => a > 6e-3,
        "return_flow_delay" => a > 3.5,
        "pump_speed_lag" => a > 5.5,
        "line_gas_storage" => a > 3.5,
        "annulus_area" => a > 0.05,
        "mud_density_change" | "cuttings_loading" => a > 1.5,
        "gas_in_pump" => a > 8e-3,
        "viscosity_drift" => a > 0.05,
        "u_tube" => a > 7.5,
        "booster_line_storage" => a > 5.0,
        "pipe_displacement" => a > 0.045,
        _ => true,
    }
}

fn is_timing(id: &str) -> bool {
    matches!(id, "return_flow_delay" | "line_gas_storage")
}

fn is_pump(effect: &dyn Effect) -> bool {
    effect.about().relation == Relation::PumpHead
}

/// One effect in one round.
struct Contender {
    effect: &'static dyn Effect,
    best: Candidate,
    evidence: f64,
}

/// Evidence of every effect about a state, best first.
fn contest(record: &Record, gate: &Tangent, state: &[Applied], taken: &[&str]) -> Vec<Contender> {
    let pull = gate.whitening.transpose(&gate.off[..gate.layout.len()]);
    let mut free: Option<Tangent> = None;
    let mut out = Vec::new();
    for effect in catalogue() {
        let about = effect.about();
        if about.id == "heave" || taken.contains(&about.id) {
            continue;
        }
        let found = scan(record, gate, &pull, state, *effect);
        let Some(best) = found
            .iter()
            .filter(|c| c.evidence.is_finite())
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
        else {
            continue;
        };
        // A sharp peak falls between the points of a grid: it pays for the places it could have been.
        let places = (found.len() as f64).ln() + if effect.is_switch() { 4.0 } else { 0.0 };
        let mut evidence = ln_mean_exp(found.iter().map(|c| {
            if c.evidence.is_finite() {
                c.evidence
            } else {
                -1e3
            }
        }))
        .max(best.evidence - places);
        let mut best = best.clone();
        if is_pump(*effect) && evidence > 1.0 {
            // A lean of the head on the inlet pressure takes most of a pump's effects with it, and all of what the
            // curves only seem to lack. Without it they must stand out as well, with it they must not vanish.
            if free.is_none() {
                free = Tangent::at(record, state, &[], Bend::Free);
            }
            if let Some(free) = &free {
                let apart = if on_grid(about) {
                    scan(record, free, &[], state, *effect)
                        .into_iter()
                        .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
                } else {
                    let start = weigh(record, free, state, best.applied.clone());
                    Some(if effect.is_switch() {
                        sharpen(record, free, state, start)
                    } else {
                        start
                    })
                };
                if let Some(apart) = apart {
                    evidence = evidence.min(apart.evidence - places);
                    best = apart;
                }
            }
        }
        out.push(Contender {
            effect: *effect,
            best,
            evidence,
        });
    }
    out.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    out
}

/// A candidate with its strength solved for.
fn solved(c: &Candidate) -> Applied {
    let about = c.applied.effect.about();
    let mut one = c.applied.clone();
    if !on_grid(about) && c.energy > 0.0 {
        let p = &about.parameters[0];
        one.parameters[0] = (c.score / c.energy).clamp(p.low, p.high);
    }
    one
}

/// Sharpens every parameter of the effects at and after `from`, about the whole hypothesis.
pub(crate) fn refine(
    record: &Record,
    state: &mut [Applied],
    from: usize,
    excluded: &[bool],
    rounds: usize,
) {
    for _ in 0..rounds {
        for k in from..state.len() {
            if state[k].allowance || state[k].effect.about().id == "unknown" {
                continue;
            }
            let Some(tangent) = Tangent::at(record, state, excluded, Bend::Free) else {
                return;
            };
            refine_one(record, &tangent, state, k);
        }
    }
}

fn refine_one(record: &Record, tangent: &Tangent, state: &mut [Applied], k: usize) {
    let about = state[k].effect.about();
    let moved = |parameters: Vec<f64>, state: &[Applied]| -> Vec<f64> {
        let mut next = state.to_vec();
        next[k].parameters = parameters;
        tangent.signature(record, &next)
    };
    let base = state[k].parameters.clone();
    let mut best = base.clone();
    // The direction of a little more strength.
    let along = (!on_grid(about)).then(|| {
        let step = (0.05 * base[0].abs()).max(0.02 * about.parameters[0].usual);
        let mut p = base.clone();
        p[0] += step;
        let s: Vec<f64> = moved(p, state).iter().map(|v| v / step).collect();
        let energy = dot(&s, &s).max(1e-300);
        (s, energy)
    });
    if on_grid(about) && about.relation != Relation::RiserMassBalance {
        let misfit = |p: f64, state: &[Applied]| -> f64 {
            let mut next = state.to_vec();
            next[k].parameters[0] = p;
            let off = tangent.refitted(record, &next).off;
            dot(&off, &off)
        };
        let mut least = misfit(best[0], state);
        for step in [3.0, 1.5, 0.7] {
            for _ in 0..4 {
                let tries = [best[0] + step, best[0] - step]
                    .map(|p| p.clamp(0.5, about.parameters[0].high));
                let found = tries.map(|p| misfit(p, state));
                let k = usize::from(found[1] < found[0]);
                if found[k] >= least - 0.05 {
                    break;
                }
                (least, best[0]) = (found[k], tries[k]);
            }
        }
        state[k].parameters = best;
        return;
    }
    // What is left over when the parameters move, with the strength free: (misfit, change of strength).
    let left = |parameters: &[f64]| -> (f64, f64) {
        let shift = moved(parameters.to_vec(), state);
        let rest: Vec<f64> = tangent.off.iter().zip(&shift).map(|(a, b)| a - b).collect();
        let total = dot(&rest, &rest);
        match &along {
            Some((s, energy)) => {
                let c = dot(&rest, s);
                (total - c * c / energy, c / energy)
            }
            None => (total, 0.0),
        }
    };
    let (mut misfit, mut gain) = left(&best);
    for scale in [1.0, 0.5, 0.25, 0.12] {
        for (j, parameter) in about.parameters.iter().enumerate() {
            if j == 0 && along.is_some() || parameter.name == "sensor" {
                continue;
            }
            for _ in 0..3 {
                let mut better = false;
                for sign in [1.0, -1.0] {
                    let mut p = best.clone();
                    let step = match parameter.role {
                        Role::Onset | Role::Duration => 80.0 * scale,
                        Role::Grid(_) => 0.15 * scale * best[j].abs().max(1.0),
                        _ => 0.2 * scale * best[j].abs().max(0.1),
                    };
                    p[j] = (p[j] + sign * step).clamp(parameter.low, parameter.high);
                    let (m, g) = left(&p);
                    if m < misfit - 0.05 {
                        (best, misfit, gain, better) = (p, m, g, true);
                    }
                }
                if !better {
                    break;
                }
            }
        }
    }
    if along.is_some() {
        let p = &about.parameters[0];
        let limit = best[0].abs().max(p.usual);
        best[0] = (best[0] + gain.clamp(-limit, limit)).clamp(p.low, p.high);
    }
    state[k].parameters = best;
}

/// The search.
pub(crate) fn select(
    record: &Record,
    start: &[Applied],
    most: usize,
    mut round_begins: impl FnMut(usize),
) -> Option<Selection> {
    let allowances = allowances_with(record, start, &[], Bend::Lean)?;
    let mut selection = Selection {
        allowances,
        named: Vec::new(),
        first: Vec::new(),
    };
    for round in 0..most {
        round_begins(round + 1);
        let state = selection.state();
        let gate = Tangent::at(record, &state, &[], Bend::Lean)?;
        // Delay and store come together or not at all: what one leaves over looks like the other.
        let timed = state
            .iter()
            .any(|a| !a.allowance && is_timing(a.effect.about().id));
        let taken: Vec<&str> = state
            .iter()
            .filter(|a| !a.allowance)
            .map(|a| a.effect.about().id)
            .collect();
        let contenders = contest(record, &gate, &state, &taken);
        if round == 0 {
            selection.first = contenders
                .iter()
                .map(|c| {
                    (
                        c.effect.about().id,
                        c.evidence,
                        if on_grid(c.effect.about()) {
                            0.0
                        } else {
                            c.best.energy
                        },
                    )
                })
                .collect();
        }
        // What a strong effect leaves over for want of form is no second effect in its relation.
        let left_over = |relation: Relation| -> f64 {
            selection
                .named
                .iter()
                .map(|n| {
                    let about = n.applied.effect.about();
                    let share = if about.relation == relation || is_timing(about.id) {
                        0.02
                    } else {
                        0.005
                    };
                    share * n.evidence
                })
                .sum()
        };
        let passes = |c: &&Contender| {
            let about = c.effect.about();
            c.evidence > hurdle(about.id).0 + left_over(about.relation)
                && !at_bound(&solved(&c.best))
                && !(timed && is_timing(about.id))
                && material(&solved(&c.best))
                && stands(record, &solved(&c.best))
        };
        let loose = Tangent::at(record, &state, &[], Bend::Loose)?;
        let rival = corrections(record, &loose, &state)
            .into_iter()
            .find(plausible);
        let best = contenders
            .iter()
            .filter(passes)
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        let Some(best) = best else {
            if let Some(rival) = rival.filter(|r| {
                r.evidence > empirical_hurdle(r) + 3.0 * left_over(RELATIONS[r.relation])
            }) {
                selection.named.push(unnamed(record, &rival, &contenders));
            }
            break;
        };
        if let Some(rival) = &rival
            && RELATIONS[rival.relation] == best.effect.about().relation
            && rival.evidence > 1.35 * best.evidence + 40.0
            && rival.evidence > empirical_hurdle(rival)
        {
            selection.named.push(unnamed(record, rival, &contenders));
            break;
        }
        let id = best.effect.about().id;
        let (least, scale) = hurdle(id);
        let real = 1.0 / (1.0 + (-(best.evidence - least) / scale - 1.0).exp());
        let temperature = (0.08 * best.evidence).max(3.0);
        let weight = |e: f64| ((e - best.evidence) / temperature).exp();
        let mut others: Vec<(String, f64)> = contenders
            .iter()
            .filter(|c| c.effect.about().id != id && c.evidence > 0.0)
            .filter(|c| alike(&best.best, &c.best) && stands(record, &solved(&c.best)))
            .map(|c| (c.effect.about().id.to_owned(), weight(c.evidence)))
            .collect();
        let same = |r: &&Correction| {
            let relation = best.effect.about().relation;
            RELATIONS[r.relation] == relation
        };
        if let Some(r) = rival.as_ref().filter(same) {
            others.push(("unknown".to_owned(), weight(0.8 * r.evidence)));
        }
        let total: f64 = 1.0 + others.iter().map(|o| o.1).sum::<f64>();
        for other in &mut others {
            other.1 *= real / total;
        }
        others.retain(|o| o.1 > 0.01);
        others.sort_by(|a, b| b.1.total_cmp(&a.1));
        let applied = solved(&best.best);
        // Where the empirical correction is the likelier cause, it stands as the finding.
        if let Some(r) = rival.as_ref().filter(same)
            && let Some(share) = others.iter().find(|o| o.0 == "unknown").map(|o| o.1)
            && share > real / total
            && r.evidence > empirical_hurdle(r)
        {
            selection.named.push(unnamed(record, r, &contenders));
            break;
        }
        if is_timing(id)
            && let Some((delay, store, gained)) =
                timing_pair(record, &gate, &state, best.best.evidence)
        {
            for (one, other) in [(delay, "line_gas_storage"), (store, "return_flow_delay")] {
                selection.named.push(Named {
                    applied: one,
                    evidence: gained,
                    probability: 0.9 * real,
                    alternatives: vec![(other.to_owned(), 0.05)],
                    correction: None,
                });
            }
            allow_again(record, start, &mut selection)?;
            let mut joint = selection.state();
            let fixed = joint.len() - selection.named.len();
            refine(record, &mut joint, fixed, &[], 2);
            for (named, refined) in selection.named.iter_mut().zip(&joint[fixed..]) {
                named.applied = refined.clone();
            }
            continue;
        }
        selection.named.push(Named {
            applied: applied.clone(),
            evidence: best.evidence,
            probability: real / total,
            alternatives: others,
            correction: None,
        });
        if is_timing(id) || id == "pump_speed_lag" {
            allow_again(record, start, &mut selection)?;
        }
        let mut joint = selection.state();
        let fixed = joint.len() - selection.named.len();
        refine(record, &mut joint, fixed, &[], 2);
        for (named, refined) in selection.named.iter_mut().zip(&joint[fixed..]) {
            named.applied = refined.clone();
        }
    }
    reconsider(record, &mut selection)?;
    Some(selection)
}

/// A late meter and a line that stores, together, where the two beat either alone.
fn timing_pair(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    single: f64,
) -> Option<(Applied, Applied, f64)> {
    let delay = dgd_effects::find("return_flow_delay")?;
    let store = dgd_effects::find("line_gas_storage")?;
    let before = dot(&gate.off, &gate.off);
    let mut best: Option<(f64, Applied, Applied)> = None;
    for d in [8.0, 11.0, 14.0, 18.0] {
        for tau in [8.0, 13.0, 18.0, 25.0] {
            let one = Applied::new(delay, vec![d]);
            let two = Applied::new(store, vec![tau]);
            let off = gate
                .refitted(record, &joined(&joined(state, &one), &two))
                .off;
            let evidence = 0.5 * (before - dot(&off, &off)) - 3.0;
            if best.as_ref().is_none_or(|b| evidence > b.0) {
                best = Some((evidence, one, two));
            }
        }
    }
    let (evidence, one, two) = best?;
    (evidence > single + 20.0 + 0.03 * single).then_some((one, two, evidence - single))
}

/// Chooses the timing allowances again beside the named effects: without a late meter in the model, a late pump had to
/// stand in for it.
fn allow_again(record: &Record, start: &[Applied], selection: &mut Selection) -> Option<()> {
    selection.allowances = allowed_beside(record, start, &selection.named, &[])?;
    Some(())
}

/// What `start` holds, with the timing allowances that the named effects leave to be made.
pub(crate) fn allowed_beside(
    record: &Record,
    start: &[Applied],
    named: &[Named],
    excluded: &[bool],
) -> Option<Vec<Applied>> {
    let mut fixed = start.to_vec();
    fixed.extend(named.iter().map(|n| n.applied.clone()));
    let state = allowances_with(record, &fixed, excluded, Bend::Lean)?;
    let mut out = start.to_vec();
    out.extend(state.into_iter().filter(|a| a.allowance));
    Some(out)
}

/// Drops what the others made superfluous.
fn reconsider(record: &Record, selection: &mut Selection) -> Option<()> {
    if selection.named.len() < 2 {
        return Some(());
    }
    let mut k = 0;
    while k < selection.named.len() && selection.named.len() > 1 {
        if selection.named[k].correction.is_some() {
            k += 1;
            continue;
        }
        let one = selection.named[k].clone();
        let mut others = Selection {
            allowances: selection.allowances.clone(),
            named: selection.named.clone(),
            first: Vec::new(),
        };
        others.named.remove(k);
        let state = others.state();
        let tangent = Tangent::at(
            record,
            &state,
            &[],
            if is_pump(one.applied.effect) {
                Bend::Free
            } else {
                Bend::Lean
            },
        )?;
        let again = weigh(record, &tangent, &state, one.applied.clone());
        if again.evidence < 0.6 * hurdle(one.applied.effect.about().id).0 || !material(&one.applied)
        {
            selection.named.remove(k);
        } else {
            k += 1;
        }
    }
    Some(())
}

/// Evidence that corrections reach on sound recordings.
fn empirical_hurdle(c: &Correction) -> f64 {
    match c.relation {
        1 if c.quantity == 1 => 150.0,
        1 => 95.0,
        0 => 80.0,
        _ => 60.0,
    }
}

/// Whether two effects explain the same residuals: the cosine between their signatures.
fn alike(a: &Candidate, b: &Candidate) -> bool {
    let size = (a.energy * b.energy).sqrt();
    size > 0.0 && (dot(&a.signature, &b.signature) / size).abs() > 0.5
}

/// Whether the strength stands at a bound of what is plausible: then something else is the cause.
fn at_bound(one: &Applied) -> bool {
    let p = &one.effect.about().parameters[0];
    let v = one.parameters[0];
    (v <= p.low && p.low != 0.0) || v >= p.high
}

/// Whether a shift of one transmitter is there to see: the two differ by it before and after, for a while.
fn stands(record: &Record, one: &Applied) -> bool {
    let about = one.effect.about();
    let (Some(onset), [first, second]) = (about.onset(), record.outlets.as_slice()) else {
        return true;
    };
    if about.id != "outlet_pressure_bias_step" {
        return true;
    }
    let at = record.t_s.partition_point(|t| *t < one.parameters[onset]);
    let reach = whole(1200.0 / record.dt_s);
    let middle = |range: std::ops::Range<usize>| -> f64 {
        let mut d: Vec<f64> = range
            .map(|i| first[i] - second[i])
            .filter(|v| v.is_finite())
            .collect();
        if d.len() < 20 {
            return f64::NAN;
        }
        let rank = d.len() / 2;
        *d.select_nth_unstable_by(rank, f64::total_cmp).1
    };
    let step = middle(at..(at + reach).min(first.len())) - middle(at.saturating_sub(reach)..at);
    let sign = if one.parameters[2] > 1.5 { -1.0 } else { 1.0 };
    let share = sign * step / one.parameters[0];
    (0.5..1.6).contains(&share)
}

/// Whether a correction is more than the accuracy of instruments: its spread over the recording.
fn plausible(c: &Correction) -> bool {
    let knots = &c.applied.parameters[4..];
    let mean = knots.iter().sum::<f64>() / knots.len() as f64;
    let spread =
        (knots.iter().map(|k| (k - mean).powi(2)).sum::<f64>() / knots.len() as f64).sqrt();
    spread > [3e3, 6e3, 1.5e-4][c.relation]
}

fn unnamed(record: &Record, c: &Correction, contenders: &[Contender]) -> Named {
    let temperature = (0.08 * c.evidence).max(6.0);
    let mut others: Vec<(String, f64)> = contenders
        .iter()
        .filter(|o| o.evidence > 0.0 && stands(record, &solved(&o.best)))
        .filter(|o| o.effect.about().relation == RELATIONS[c.relation])
        .map(|o| {
            (
                o.effect.about().id.to_owned(),
                ((1.2 * o.evidence - c.evidence) / temperature)
                    .exp()
                    .min(1.0),
            )
        })
        .collect();
    let total: f64 = 1.0 + others.iter().map(|o| o.1).sum::<f64>();
    let real = 1.0 / (1.0 + (-(c.evidence - empirical_hurdle(c)) / 15.0 - 0.7).exp());
    for o in &mut others {
        o.1 *= real / total;
    }
    others.retain(|o| o.1 > 0.01);
    others.sort_by(|a, b| b.1.total_cmp(&a.1));
    Named {
        applied: c.applied.clone(),
        evidence: c.evidence,
        probability: real / total,
        alternatives: others,
        correction: Some((c.relation, c.quantity)),
    }
}
