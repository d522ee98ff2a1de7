//! Which of the scored sets stands: what a further effect must be worth, what does as well in its place, what the others make
//! superfluous.

use crate::baseline::{NEAR, QUICK};
use crate::checks::{at_its_place, shifted};
use crate::context::{Context, Trial};
use crate::sets::{Scored, Task, finish, try_all};
use crate::tangent::dot;
use crate::validate::Folds;
use std::collections::BTreeSet;

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

/// Standard errors within which two sets are not told apart.
const TOLD: f64 = 2.0;

/// Whether left-out blocks do not tell a set from the chosen one. Wider than [`alike`], which asks what is as good: whoever
/// trusts the one name must seldom be wrong.
pub(crate) fn untold(set: &Scored, chosen: &Scored) -> bool {
    let (more, error) = set.left.less(&chosen.left);
    more <= TOLD * error || alike(set, chosen)
}

/// Share of the squares between the chosen set and what it has in common with another, above which that does not take its place.
const IN_PLACE: f64 = 0.5;

/// Whether a set may stand in the chosen one's place: not told from it, and worth more than half of what the chosen one is worth beyond their
/// common members. Where the squares sit in few blocks the standard error alone lets pass what is worse than nothing.
pub(crate) fn stands_in(scored: &[Scored], set: &Scored, chosen: &Scored) -> bool {
    let kept = |m: &&usize| set.trial.members.contains(m);
    let members = chosen.trial.members.iter();
    let common: Vec<usize> = members.filter(kept).copied().collect();
    let common = scored.iter().find(|s| s.trial.members == common);
    let worth = common.map_or(f64::INFINITY, |c| c.left.less(&chosen.left).0);
    let unit = 2.0 / independent(&chosen.trial).max(2.0) * chosen.left.mean();
    untold(set, chosen) && set.left.less(&chosen.left).0 <= unit.max(IN_PLACE * worth)
}

/// What does as well in the place of a member of the chosen set, the others kept.
pub(crate) fn stand_ins(scored: &[Scored], chosen: usize, member: usize) -> Vec<usize> {
    let set = &scored[chosen];
    let members = &set.trial.members;
    let mut found = Vec::new();
    for s in scored.iter().filter(|s| stands_in(scored, s, set)) {
        let m = &s.trial.members;
        if m.len() != members.len() || members.iter().any(|o| *o != member && !m.contains(o)) {
            continue;
        }
        found.extend(m.iter().copied().filter(|o| !members.contains(o)));
    }
    found
}

/// The number of the set without one member; fitted, scored and added if it was not there.
pub(crate) fn find_or_fit_reduced(
    context: &Context<'_>,
    folds: &Folds,
    scored: &mut Vec<Scored>,
    set: usize,
    member: usize,
) -> Option<usize> {
    let trial = scored[set].trial.clone();
    let rest = trial.others(member);
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
        let Some(rest) = find_or_fit_reduced(context, folds, scored, set, m) else {
            return false;
        };
        let without = &scored[rest];
        let shares = shifted(context, memory, &without.trial, m);
        tracing::debug!(?shares, member = m, set = ?trial.members, "placebo");
        if !shares.is_some_and(|(own, moved)| at_its_place(own, moved)) {
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
            .map(|&m| set.others(m))
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
