//! Joint re-fits: singles, all pairs of the best few, then greedily more, with a score on left-out blocks for the best
//! of each size.

use crate::baseline::{Baseline, NEAR, QUICK};
use crate::blocks::Blocks;
use crate::checks::shifted;
use crate::context::{Context, Trial, Values, path};
use crate::screen::{Point, Screened, screen_again};
use crate::tangent::dot;
use crate::validate::{Folds, LeftOut};
use dgd_lsq::lm::Effort;
use std::collections::BTreeSet;

/// A set with its score on left-out blocks.
#[derive(Debug, Clone)]
pub(crate) struct Scored {
    pub trial: Trial,
    pub left: LeftOut,
}

/// How wide to search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Width {
    /// Effects in all pairs.
    pub pool: usize,
    /// Sets of a size that are fitted to the end and scored.
    pub scored: usize,
    /// Sets of a size to which more is added.
    pub beam: usize,
    /// Most effects together.
    pub most: usize,
}

/// A fit to be tried.
struct Task {
    members: Vec<usize>,
    values: Values,
}

/// Start of a fit with an effect at one of its strengths beside `values`.
fn with(values: &Values, context: &Context<'_>, number: usize, point: &Point) -> Values {
    let mut all = values.clone();
    let h = &context.hypotheses[number];
    all.extend(
        h.parameters
            .iter()
            .zip(&point.values)
            .map(|(p, v)| (path(h, p), *v)),
    );
    all
}

fn joined(a: &[usize], b: usize) -> Vec<usize> {
    let mut all = a.to_vec();
    all.push(b);
    all.sort_unstable();
    all
}

/// Fits tasks briefly, and keeps the best of each set, best first.
fn try_all(context: &Context<'_>, tasks: &[Task], effort: Effort) -> Vec<Trial> {
    let found = context
        .threads
        .map(tasks, |t| context.fit(&t.members, &t.values, effort));
    let mut best: Vec<Trial> = Vec::new();
    for trial in found.into_iter().flatten() {
        match best.iter_mut().find(|b| b.members == trial.members) {
            Some(b) if trial.cost() < b.cost() => *b = trial,
            Some(_) => {}
            None => best.push(trial),
        }
    }
    best.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    best
}

/// Fits to the end and scores.
pub(crate) fn finish(context: &Context<'_>, folds: &Folds, trials: &[Trial]) -> Vec<Scored> {
    context
        .threads
        .map(trials, |t| {
            let trial = context.refine(t, NEAR).unwrap_or_else(|| t.clone());
            let left = folds.of_trial(context, &trial)?;
            Some(Scored { trial, left })
        })
        .into_iter()
        .flatten()
        .collect()
}

/// Linear gain of two directions together, as share of the residual's square.
fn pair_gain(a: &[f64], b: &[f64], residual: &[f64], total: f64) -> f64 {
    let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
    let (ar, br) = (dot(a, residual), dot(b, residual));
    let det = aa * bb - ab * ab;
    // Two that do the same are one.
    if det <= 1e-3 * aa * bb {
        return (ar * ar / aa).max(br * br / bb) / total;
    }
    (bb * ar * ar - 2.0 * ab * ar * br + aa * br * br) / det / total
}

/// All sets that were scored, the base first.
pub(crate) fn search(
    context: &Context<'_>,
    folds: &Folds,
    blocks: &Blocks,
    (base, base_scored): (&Baseline, Scored),
    screened: &[Screened],
    width: Width,
    watch: &mut dyn FnMut(usize),
) -> Vec<Scored> {
    let base_trial = base_scored.trial.clone();
    let base_trial = &base_trial;
    let mut all = vec![base_scored];
    let usable: Vec<&Screened> = screened.iter().filter(|s| s.usable()).collect();

    watch(1);
    let tasks: Vec<Task> = usable
        .iter()
        .flat_map(|s| {
            s.points.iter().map(|point| Task {
                members: vec![s.number],
                values: with(&point.from, context, s.number, point),
            })
        })
        .collect();
    // All are followed to the end of the quick fit, from the best of their strengths and shapes.
    let singles = try_best(context, &tasks, usable.len());
    report(context, "singles", &singles, base_trial);
    let top: Vec<Trial> = singles.iter().take(width.scored).cloned().collect();
    all.extend(finish(context, folds, &top));

    watch(2);
    let pairs = pairs(context, base, &usable, &singles, width);
    report(context, "pairs", &pairs, base_trial);
    let top: Vec<Trial> = pairs.iter().take(width.scored).cloned().collect();
    let mut last = finish(context, folds, &top);
    for size in 3..=width.most {
        all.append(&mut last);
        // Three hide each other at times, and one what is there; beyond that, more of what is worth nothing is not tried.
        let chosen =
            choose(&all, usable.len(), &BTreeSet::new()).map_or(0, |k| all[k].trial.members.len());
        if (chosen + 2).max(3) < size {
            break;
        }
        watch(size);
        let mut beam: Vec<&Scored> = all
            .iter()
            .filter(|s| s.trial.members.len() == size - 1)
            .collect();
        beam.sort_by(|a, b| a.left.mean().total_cmp(&b.left.mean()));
        beam.truncate(width.beam);
        let tasks = additions(context, blocks, &beam, &usable, width.pool);
        let found = try_best(context, &tasks, 3 * width.scored);
        report(context, "more", &found, base_trial);
        let top: Vec<Trial> = found.iter().take(width.scored).cloned().collect();
        last = finish(context, folds, &top);
    }
    all.append(&mut last);
    all
}

/// Pairs of the best by fit and by score, and pairs that promise most together although each alone may give little.
fn pairs(
    context: &Context<'_>,
    base: &Baseline,
    usable: &[&Screened],
    singles: &[Trial],
    width: Width,
) -> Vec<Trial> {
    let total = dot(&base.off, &base.off).max(1e-300);
    let mut pool: BTreeSet<usize> = singles
        .iter()
        .take(width.pool * 2 / 3)
        .map(|t| t.members[0])
        .collect();
    let mut by_score: Vec<&&Screened> = usable.iter().collect();
    by_score.sort_by(|a, b| b.score.total_cmp(&a.score));
    for s in by_score {
        if pool.len() < width.pool {
            pool.insert(s.number);
        }
    }
    let mut promising: Vec<(f64, &Screened, &Point, &Screened, &Point)> = Vec::new();
    for (i, a) in usable.iter().enumerate() {
        for b in &usable[i + 1..] {
            let mut best = (0.0, &a.points[0], &b.points[0]);
            for p in &a.points {
                for q in &b.points {
                    let gain = pair_gain(&p.direction, &q.direction, &base.off, total);
                    if gain > best.0 {
                        best = (gain, p, q);
                    }
                }
            }
            promising.push((best.0, a, best.1, b, best.2));
        }
    }
    promising.sort_by(|a, b| b.0.total_cmp(&a.0));
    let moved = |point: &Point| *point.from != base.values;
    let mut tasks = Vec::new();
    for (_, a, p, b, q) in promising.iter().take(2 * width.pool) {
        let values = with(
            &with(
                if moved(q) { &q.from } else { &p.from },
                context,
                a.number,
                p,
            ),
            context,
            b.number,
            q,
        );
        tasks.push(Task {
            members: joined(&[a.number], b.number),
            values,
        });
    }
    let fitted = |n: usize| singles.iter().find(|t| t.members == [n]);
    let pool: Vec<usize> = pool.into_iter().collect();
    for (i, &a) in pool.iter().enumerate() {
        for &b in &pool[i + 1..] {
            let (Some(ta), Some(tb)) = (fitted(a), fitted(b)) else {
                continue;
            };
            // The base's parameters from the better of the two.
            let (first, second) = if ta.cost() <= tb.cost() {
                (ta, tb)
            } else {
                (tb, ta)
            };
            let mut values = second.values();
            values.extend(first.values());
            tasks.push(Task {
                members: joined(&[a], b),
                values,
            });
        }
    }
    try_best(context, &tasks, 2 * width.pool)
}

/// A few steps with each task; what is far behind after them is not followed.
fn try_best(context: &Context<'_>, tasks: &[Task], follow: usize) -> Vec<Trial> {
    let brief = Effort {
        steps: 3,
        fresh: 1,
        ..QUICK
    };
    let mut found = try_all(context, tasks, brief);
    let rest = found.split_off(found.len().min(follow));
    let mut found: Vec<Trial> = context.threads.map(&found, |t| {
        context.refine(t, QUICK).unwrap_or_else(|| t.clone())
    });
    found.extend(rest);
    found.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    found
}

/// What might be added to each set of the beam: screened anew beside it.
fn additions(
    context: &Context<'_>,
    blocks: &Blocks,
    beam: &[&Scored],
    usable: &[&Screened],
    pool: usize,
) -> Vec<Task> {
    let mut tasks = Vec::new();
    for set in beam {
        let Some(base) = Baseline::of(context, &set.trial) else {
            continue;
        };
        let others: Vec<&Screened> = usable
            .iter()
            .copied()
            .filter(|s| !set.trial.members.contains(&s.number))
            .collect();
        let found = screen_again(context, &base, blocks, &others);
        let mut by_gain: Vec<&Screened> = found.iter().filter(|s| s.usable()).collect();
        by_gain.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut chosen: Vec<&Screened> = by_gain.iter().take(pool).copied().collect();
        by_gain.sort_by(|a, b| b.score.total_cmp(&a.score));
        for s in by_gain.into_iter().take(pool / 3) {
            if chosen.iter().all(|c| c.number != s.number) {
                chosen.push(s);
            }
        }
        for s in chosen {
            for point in s.points.iter().take(1) {
                tasks.push(Task {
                    members: joined(&set.trial.members, s.number),
                    values: with(&base.values, context, s.number, point),
                });
            }
        }
    }
    tasks
}

/// Sets in which one member is exchanged for an effect that changes the readings in a like way.
pub(crate) fn swaps(
    context: &Context<'_>,
    folds: &Folds,
    chosen: &Scored,
    known: &[Scored],
    screened: &[Screened],
    scored: usize,
) -> Vec<Scored> {
    let likeness = |a: &Screened, b: &Screened| -> f64 {
        let mut greatest = 0.0_f64;
        for p in &a.points {
            for q in &b.points {
                let (p, q) = (&p.direction, &q.direction);
                greatest =
                    greatest.max(dot(p, q).abs() / (dot(p, p) * dot(q, q)).sqrt().max(1e-300));
            }
        }
        greatest
    };
    let mut tasks = Vec::new();
    for &out in &chosen.trial.members {
        let Some(own) = screened.iter().find(|s| s.number == out) else {
            continue;
        };
        let rest: Vec<usize> = chosen
            .trial
            .members
            .iter()
            .copied()
            .filter(|m| *m != out)
            .collect();
        let mut others: Vec<(f64, &Screened)> = screened
            .iter()
            .filter(|s| s.usable() && !chosen.trial.members.contains(&s.number))
            .filter(|s| {
                let members = joined(&rest, s.number);
                known.iter().all(|k| k.trial.members != members)
            })
            .map(|s| (likeness(own, s), s))
            .filter(|s| s.0 > 0.5)
            .collect();
        others.sort_by(|a, b| b.0.total_cmp(&a.0));
        others.truncate(scored);
        tasks.extend(others.into_iter().map(|(_, s)| Task {
            members: joined(&rest, s.number),
            values: with(&chosen.trial.values(), context, s.number, &s.points[0]),
        }));
    }
    let near: Vec<Trial> = try_best(context, &tasks, 2 * scored)
        .into_iter()
        .filter(|t| t.cost() < 1.3 * chosen.trial.cost())
        .take(scored)
        .collect();
    finish(context, folds, &near)
}

fn report(context: &Context<'_>, what: &str, trials: &[Trial], base: &Trial) {
    for t in trials.iter().take(8) {
        let names: Vec<String> = t
            .members
            .iter()
            .map(|&m| {
                let h = &context.hypotheses[m];
                format!("{}.{}", h.component, h.effect)
            })
            .collect();
        tracing::debug!(
            "{what}: {} leaves {:.3} of the base's residual",
            names.join(" + "),
            (t.cost() / base.cost()).sqrt()
        );
    }
}

/// What one more effect must gain on left-out blocks to be believed, in natural logarithms of likelihood, beyond the logarithm
/// of the number of hypotheses that it was picked from.
const HURDLE: f64 = 4.0;
/// Where the residual remembers itself and likelihoods say little: the share of the root mean square that must go, and
/// its standard errors.
const LARGE: (f64, f64) = (0.3, 1.5);
/// The same for what is added to a set that is established: smaller, as noise alone no longer explains the residual, and
/// surer, as it was picked from many.
const FURTHER: (f64, f64) = (0.05, 2.0);

/// Whether the larger set is worth its further effects.
pub(crate) fn worth(smaller: &Scored, larger: &Scored, hypotheses: usize) -> bool {
    let (a, b) = (smaller.trial.members.len(), larger.trial.members.len());
    let further = b.saturating_sub(a).max(1) as f64;
    let (gain, error) = smaller.left.less(&larger.left);
    let ratio = larger.left.mean() / smaller.left.mean().max(1e-300);
    // Not even one standard error: the smaller one is as good.
    if !(gain > error && ratio < 1.0) {
        return false;
    }
    let independent = independent(&larger.trial);
    let nats = -0.5 * independent * ratio.ln();
    let (share, errors) = if a == 0 { LARGE } else { FURTHER };
    nats >= further * (HURDLE + (hypotheses.max(1) as f64).ln())
        || (ratio.sqrt() <= (1.0 - share).powf(further) && gain >= errors * error)
}

/// Readings that count as independent, by the residual's lag-one correlation (Bartlett).
pub(crate) fn independent(trial: &Trial) -> f64 {
    let r = &trial.minimum.residuals;
    let lagged: f64 = r.windows(2).map(|w| w[0] * w[1]).sum();
    let memory = (lagged / dot(r, r).max(1e-300)).clamp(0.0, 0.99);
    r.len() as f64 * (1.0 - memory) / (1.0 + memory)
}

/// Whether a set does as well on left-out blocks as the chosen one: within one standard error, or within what one
/// more unit of log-likelihood is worth.
pub(crate) fn alike(set: &Scored, chosen: &Scored) -> bool {
    let (more, error) = set.left.less(&chosen.left);
    more <= error.max(2.0 / independent(&chosen.trial).max(2.0) * chosen.left.mean())
}

/// What does as well in the place of a member of the chosen set, the others kept.
pub(crate) fn stand_ins(scored: &[Scored], chosen: usize, member: usize) -> Vec<usize> {
    let set = &scored[chosen];
    let members = &set.trial.members;
    let mut found = Vec::new();
    for s in scored.iter().filter(|s| alike(s, set)) {
        let m = &s.trial.members;
        if m.len() != members.len() || members.iter().any(|o| *o != member && !m.contains(o)) {
            continue;
        }
        found.extend(m.iter().copied().filter(|o| !members.contains(o)));
    }
    found
}

/// The set without one member; fitted and scored if it was not.
pub(crate) fn without(
    context: &Context<'_>,
    folds: &Folds,
    scored: &mut Vec<Scored>,
    set: usize,
    member: usize,
) -> Option<usize> {
    let trial = scored[set].trial.clone();
    let rest: Vec<usize> = trial
        .members
        .iter()
        .copied()
        .filter(|o| *o != member)
        .collect();
    if let Some(known) = scored.iter().position(|s| s.trial.members == rest) {
        return Some(known);
    }
    let fitted = context.fit(&rest, &trial.values(), NEAR)?;
    let left = folds.of_trial(context, &fitted)?;
    scored.push(Scored {
        trial: fitted,
        left,
    });
    Some(scored.len() - 1)
}

/// Prices that differ by less are equal: which of two that do the same comes first is left to their order, not to round-off.
const TIE: f64 = 0.01;

/// The sets of a size that do alike, the best one included, by what their parameters cost at Akaike's price.
fn best_of(scored: &[Scored], size: usize, refused: &BTreeSet<usize>) -> Vec<usize> {
    let mut of: Vec<usize> = (0..scored.len())
        .filter(|i| scored[*i].trial.members.len() == size && !refused.contains(i))
        .collect();
    let readings = of
        .iter()
        .map(|&i| independent(&scored[i].trial))
        .fold(f64::INFINITY, f64::min);
    let price = |i: usize| {
        0.5 * readings * scored[i].left.mean().max(1e-300).ln() + scored[i].trial.paths.len() as f64
    };
    let least = of.iter().map(|&i| price(i)).fold(f64::INFINITY, f64::min) + TIE;
    of.sort_by(|&a, &b| {
        let [pa, pb] = [a, b].map(|i| price(i).max(least));
        let members = |i: usize| &scored[i].trial.members;
        pa.total_cmp(&pb).then_with(|| members(a).cmp(members(b)))
    });
    let best = of.first().copied();
    of.retain(|&i| best.is_some_and(|b| alike(&scored[i], &scored[b])));
    of
}

/// Up the sizes: the first of those that do best in a size and are worth it takes the place of what stood before. `refused`
/// are not looked at.
pub(crate) fn choose(
    scored: &[Scored],
    hypotheses: usize,
    refused: &BTreeSet<usize>,
) -> Option<usize> {
    let most = scored.iter().map(|s| s.trial.members.len()).max()?;
    let mut now = *best_of(scored, 0, refused).first()?;
    for size in 1..=most {
        let next = best_of(scored, size, refused);
        if let Some(next) = next
            .into_iter()
            .find(|&i| worth(&scored[now], &scored[i], hypotheses))
        {
            now = next;
        }
    }
    Some(now)
}

/// Whether each member of a set takes more of what the others leave at its place than shifted along the record. One whose like
/// is as good anywhere is none, be its left-out score what it may.
pub(crate) fn stand(
    context: &Context<'_>,
    memory: usize,
    folds: &Folds,
    scored: &mut Vec<Scored>,
    set: usize,
) -> bool {
    let trial = scored[set].trial.clone();
    // A single one stands beside the base, which was scored first.
    for &m in &trial.members {
        let Some(rest) = without(context, folds, scored, set, m) else {
            return false;
        };
        let without = &scored[rest];
        let shares = shifted(context, memory, &without.trial, m);
        tracing::debug!(?shares, member = m, set = ?trial.members, "placebo");
        if !shares.is_some_and(|(own, moved)| own > moved) {
            return false;
        }
    }
    true
}

/// Takes away what the others make superfluous, the least first; adds the sets it had to fit.
pub(crate) fn prune(
    context: &Context<'_>,
    folds: &Folds,
    scored: &mut Vec<Scored>,
    chosen: usize,
) -> usize {
    let mut now = chosen;
    while scored[now].trial.members.len() > 1 {
        let set = scored[now].trial.clone();
        let tasks: Vec<Task> = set
            .members
            .iter()
            .map(|m| {
                set.members
                    .iter()
                    .copied()
                    .filter(|o| o != m)
                    .collect::<Vec<_>>()
            })
            .filter(|rest| scored.iter().all(|s| s.trial.members != *rest))
            .map(|members| Task {
                members,
                values: set.values(),
            })
            .collect();
        let found = try_all(context, &tasks, QUICK);
        scored.extend(finish(context, folds, &found));
        let smaller = (0..scored.len())
            .filter(|&i| {
                let m = &scored[i].trial.members;
                m.len() + 1 == set.members.len() && m.iter().all(|m| set.members.contains(m))
            })
            .min_by(|a, b| scored[*a].left.mean().total_cmp(&scored[*b].left.mean()));
        match smaller {
            Some(i) if !worth(&scored[i], &scored[now], context.hypotheses.len()) => now = i,
            _ => break,
        }
    }
    now
}
