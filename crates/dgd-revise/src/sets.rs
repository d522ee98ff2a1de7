//! Joint re-fits: singles, all pairs of the best few, then greedily more, with a score on left-out blocks for the best
//! of each size.

use crate::baseline::{Baseline, NEAR, QUICK};
use crate::blocks::Blocks;
use crate::choice::choose;
use crate::context::{self, Context, Trial, Values};
use crate::empirical;
use crate::floor;
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

/// Sets of a size to which more is added.
const BEAM: usize = 2;

/// How wide to search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Width {
    /// Effects in all pairs.
    pub pool: usize,
    /// Sets of a size that are fitted to the end and scored.
    pub scored: usize,
    /// Most effects together.
    pub most: usize,
}

/// A fit to be tried.
pub(crate) struct Task {
    pub members: Vec<usize>,
    pub values: Values,
}

/// Start of a fit with an effect at one of its strengths beside `values`.
fn with(values: &Values, context: &Context<'_>, number: usize, point: &Point) -> Values {
    context::with(values, &context.hypotheses[number], &point.values)
}

fn joined(a: &[usize], b: usize) -> Vec<usize> {
    let mut all = a.to_vec();
    all.push(b);
    all.sort_unstable();
    all
}

/// Fits tasks briefly, and keeps the best of each set, best first.
pub(crate) fn try_all(context: &Context<'_>, tasks: &[Task], effort: Effort) -> Vec<Trial> {
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
    if settled(context, &all, usable.len()) {
        return all;
    }

    watch(2);
    // What does nothing by itself may do something beside another: a level stands above a brim where there is one.
    let idle: Vec<&Screened> = screened.iter().filter(|s| !s.moves).collect();
    let more = additions(context, blocks, &beam(&all, 1), &idle, IDLE);
    let pairs = pairs(context, base, &usable, &singles, width, more);
    report(context, "pairs", &pairs, base_trial);
    let top: Vec<Trial> = pairs.iter().take(width.scored).cloned().collect();
    let mut last = finish(context, folds, &top);
    for size in 3..=width.most {
        all.append(&mut last);
        // Three hide each other at times, and one what is there; beyond that, more of what is worth nothing is not tried.
        let chosen =
            choose(&all, usable.len(), &BTreeSet::new()).map_or(0, |k| all[k].trial.members.len());
        if (chosen + 2).max(3) < size || settled(context, &all, usable.len()) {
            break;
        }
        watch(size);
        let beam = beam(&all, size - 1);
        let mut tasks = additions(context, blocks, &beam, &usable, width.pool);
        tasks.extend(additions(context, blocks, &beam, &idle, IDLE));
        let found = try_best(context, &tasks, 3 * width.scored);
        report(context, "more", &found, base_trial);
        let top: Vec<Trial> = found.iter().take(width.scored).cloned().collect();
        last = finish(context, folds, &top);
    }
    all.append(&mut last);
    all
}

/// Most effects that do nothing by themselves and are tried beside a set.
const IDLE: usize = 3;

/// The sets of a size to which more is added.
fn beam(scored: &[Scored], size: usize) -> Vec<&Scored> {
    let of = |s: &&Scored| s.trial.members.len() == size;
    let mut beam: Vec<&Scored> = scored.iter().filter(of).collect();
    beam.sort_by(|a, b| a.left.mean().total_cmp(&b.left.mean()));
    beam.truncate(BEAM);
    beam
}

/// Whether the best set so far leaves no more than noise, so that there is nothing for another effect to take.
fn settled(context: &Context<'_>, scored: &[Scored], hypotheses: usize) -> bool {
    let Some(best) = choose(scored, hypotheses, &BTreeSet::new()) else {
        return false;
    };
    let trial = &scored[best].trial;
    if trial.members.is_empty() {
        return false;
    }
    let (members, theta) = (&trial.members, &trial.minimum.theta);
    let quantities =
        empirical::quantities(context, context.data, members, theta).unwrap_or_default();
    let residuals = &trial.minimum.residuals;
    let outputs = context.scale.len();
    let levels = floor::plain(
        context.data,
        residuals,
        outputs,
        &context.scale,
        &quantities,
    );
    floor::too_small(&levels.iter().collect::<Vec<_>>(), floor::SETTLED)
}

/// Pairs of the best by fit and by score, pairs that promise most together although each alone may give little, and `more`.
fn pairs(
    context: &Context<'_>,
    base: &Baseline,
    usable: &[&Screened],
    singles: &[Trial],
    width: Width,
    more: Vec<Task>,
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
    let mut tasks = more;
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
        let rest = chosen.trial.others(out);
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
