//! The catalogue held against the residuals: a grid over shapes, strengths solved exactly.

mod switches;

pub(crate) use switches::{gap, switches};

use crate::bayes::evidence;
use crate::cores::apiece;
use crate::numbers::{product, whole};
use crate::record::Record;
use crate::relations::{Applied, joined, on_grid};
use crate::tangent::{Sketch, Tangent};
use dgd_effects::{Effect, Role};
use dgd_lsq::dot;

/// An effect at one point of its grid.
#[derive(Clone)]
pub(crate) struct Candidate {
    pub applied: Applied,
    /// Signature off the tangent for one unit of strength (or for the grid value); empty where it was not asked for.
    pub signature: Vec<f64>,
    /// Its energy and its product with the residual.
    pub energy: f64,
    pub score: f64,
    /// Logarithm of the Bayes factor against nothing.
    pub evidence: f64,
}

impl Candidate {
    /// Without its signature, which is as long as the recording.
    pub(crate) fn bare(self) -> Self {
        Self {
            signature: Vec::new(),
            ..self
        }
    }
}

/// Onsets on the grid at the most: each is weighed on the whole recording. Where they would be more, the grid only measures energies, for which
/// fewer do.
const MOST_ONSETS: f64 = 60.0;
const COARSE_ONSETS: f64 = 32.0;

/// Whether an effect is sought where a [switch](switches) in its place would explain most, and sharpened to the block there: its grid only measures
/// energies.
fn is_switched(effect: &dyn Effect) -> bool {
    effect.is_switch() || effect.lasting().is_some()
}

/// How far apart the onsets of an effect are tried, s, unless that were too many.
fn every_s(effect: &dyn Effect) -> f64 {
    if is_switched(effect) { 1200.0 } else { 600.0 }
}

/// Onsets that would be tried, were the grid as fine on all recordings.
fn places(effect: &dyn Effect, record: &Record) -> f64 {
    let (from, to) = record.setting.span_s;
    (to - from) / every_s(effect)
}

/// Whether a recording is so long that the grid steps over what passes.
fn is_coarse(effect: &dyn Effect, record: &Record) -> bool {
    effect.about().onset().is_some() && places(effect, record) > MOST_ONSETS
}

/// What the places that a grid of long recordings leaves out cost a candidate that is proposed between its points, e-folds.
pub(crate) fn more_places(effect: &dyn Effect, record: &Record) -> f64 {
    if is_coarse(effect, record) {
        (places(effect, record) / COARSE_ONSETS).ln()
    } else {
        0.0
    }
}

/// The first and the last onset, s, at which what stays is sought: it shows little at the end, and is not told from what was always there at the
/// beginning.
pub(crate) fn onsets_that_stay(record: &Record) -> (f64, f64) {
    let (from, to) = record.setting.span_s;
    let span = to - from;
    (
        from + (0.06 * span).min(1800.0),
        to - (0.08 * span).min(2400.0),
    )
}

/// Grid values of each parameter; the strength of a proportional effect stands at a third of its usual size.
pub(crate) fn grids(effect: &dyn Effect, record: &Record) -> Vec<Vec<f64>> {
    let about = effect.about();
    let (from, to) = record.setting.span_s;
    let span = to - from;
    about
        .parameters
        .iter()
        .map(|p| match p.role {
            Role::Amplitude => vec![p.usual / 3.0],
            Role::Grid(values)
            | Role::Shape(values)
            | Role::Choice(values)
            | Role::Sensor(values) => values.to_vec(),
            Role::Onset => {
                let count = whole(if is_coarse(effect, record) {
                    COARSE_ONSETS
                } else {
                    places(effect, record).max(10.0)
                });
                let (first, last) = if about.duration().is_some() {
                    (from + 0.01 * span, to - 0.04 * span)
                } else {
                    onsets_that_stay(record)
                };
                let step = (last - first) / (count - 1) as f64;
                (0..count).map(|k| first + step * k as f64).collect()
            }
            Role::Edge(values) => values[..1].to_vec(),
            Role::Duration(values) => {
                let tried = values.iter().copied();
                tried.filter(|d| *d < 0.7 * span).collect()
            }
        })
        .collect()
}

/// The points of the grid that are tried: what lasts for hours begins at fewer places, and its ends move further.
fn points(effect: &'static dyn Effect, record: &Record) -> Vec<Applied> {
    /// Duration up to which every place is tried, s; of twice that every second one, and so on.
    const EVERYWHERE_S: f64 = 3600.0;
    let grids = grids(effect, record);
    let about = effect.about();
    let timed = about.onset().zip(about.duration());
    let tried = |p: &Vec<f64>| {
        timed.is_none_or(|(onset, duration)| {
            let place = grids[onset].iter().position(|onset_s| *onset_s == p[onset]);
            let every = whole((p[duration] / EVERYWHERE_S).round()).max(1);
            place.is_none_or(|place| place % every == 0)
        })
    };
    let all = product(&grids).into_iter().filter(tried);
    all.map(|p| Applied::new(effect, p)).collect()
}

/// The likeliest of one effect, everywhere on its grid and between its points, with its signature; `None` if nothing can be weighed.
pub(crate) fn scan(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    effect: &'static dyn Effect,
) -> Option<Candidate> {
    let found = searched(record, tangent, state, &[effect]).concat();
    likeliest(record, tangent, state, &found)
}

/// Candidates of each of some effects: the points of its grid, and between them, to the block, where it would explain most; without their
/// signatures.
pub(crate) fn searched(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    effects: &[&'static dyn Effect],
) -> Vec<Vec<Candidate>> {
    let pull = tangent.pull();
    let grids = effects.iter().map(|effect| points(*effect, record));
    let mut found = of_each(grids.collect(), |one| {
        vec![weighed(record, tangent, state, one).bare()]
    });
    let beyond = apiece(found.iter().collect(), |coarse| {
        beyond_grid(record, tangent, state, coarse)
    });
    for (found, more) in found.iter_mut().zip(beyond) {
        found.extend(more);
    }
    let both = effects.iter().zip(&found).collect();
    let places = apiece(both, |(effect, coarse)| {
        if !is_switched(*effect) && !is_coarse(*effect, record) {
            return Vec::new();
        }
        let proposed = (switches(record, tangent, &pull, state, *effect, coarse).into_iter())
            .map(|parameters| Applied::new(*effect, parameters));
        if effect.lasting().is_none() {
            return proposed.collect();
        }
        // What otherwise stays has several in each of its shapes, and is sought from the best of its grid as well.
        let best = (coarse.iter().filter(|c| c.evidence.is_finite()))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        let proposed = proposed.chain(best.map(|c| c.applied.clone()));
        most_likely(record, tangent, state, proposed)
    });
    let more = of_each(places, |one| sharpened(record, tangent, state, one));
    for (found, more) in found.iter_mut().zip(more) {
        found.extend(more);
    }
    found
}

/// The likeliest of some places: few are worth sharpening.
fn most_likely(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    places: impl Iterator<Item = Applied>,
) -> Vec<Applied> {
    /// Places that are sharpened. Set by hand.
    const MOST: usize = 5;
    let mut weighed: Vec<Candidate> = places
        .map(|one| weighed(record, tangent, state, one).bare())
        .collect();
    weighed.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    weighed.truncate(MOST);
    weighed.into_iter().map(|c| c.applied).collect()
}

/// Where the best strength of a grid is its last, further ones, as far as they explain more: what is late by minutes is too rare for these to be weighed
/// each time.
fn beyond_grid(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    coarse: &[Candidate],
) -> Vec<Candidate> {
    /// From one strength to the next. Set by hand.
    const FURTHER: f64 = 1.3;
    /// So many in a row that explain less are enough.
    const WORSE: usize = 2;
    let mut found = Vec::new();
    let best = (coarse.iter().filter(|c| c.evidence.is_finite()))
        .max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    let Some(best) = best else {
        return found;
    };
    let strength = &best.applied.effect.about().parameters[0];
    let Role::Grid(&[.., last]) = strength.role else {
        return found;
    };
    if best.applied.parameters[0] < last {
        return found;
    }
    let (mut most, mut worse) = (best.evidence, 0);
    let mut at = last * FURTHER;
    while at <= strength.high && worse < WORSE {
        let mut one = best.applied.clone();
        one.parameters[0] = at;
        let further = weighed(record, tangent, state, one).bare();
        worse = if further.evidence > most {
            0
        } else {
            worse + 1
        };
        most = most.max(further.evidence);
        found.push(further);
        at *= FURTHER;
    }
    found
}

/// What is made of each of some hypotheses, group by group.
///
/// On all cores, each by itself, so that their number changes no digit; and not group by group, as some have far more of them than others, or
/// dearer ones.
pub(crate) fn of_each(
    groups: Vec<Vec<Applied>>,
    of: impl Fn(Applied) -> Vec<Candidate> + Send + Sync,
) -> Vec<Vec<Candidate>> {
    let sizes: Vec<usize> = groups.iter().map(Vec::len).collect();
    let all: Vec<Applied> = groups.into_iter().flatten().collect();
    let mut made = apiece(all, of).into_iter();
    (sizes.into_iter())
        .map(|size| made.by_ref().take(size).flatten().collect())
        .collect()
}

/// One hypothesis with its ends where they explain most, and with each length of edge that it may have; without their signatures.
fn sharpened(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    one: Applied,
) -> Vec<Candidate> {
    let start = weigh(record, tangent, state, one);
    let sharp = sharpen(record, tangent, state, start);
    let soft = softened(record, tangent, state, &sharp);
    (soft.into_iter().chain([sharp]))
        .map(Candidate::bare)
        .collect()
}

/// The likeliest of some candidates, the last of equals, with its signature, which is worked out if it was not kept; `None` if none can be
/// weighed.
pub(crate) fn likeliest(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    found: &[Candidate],
) -> Option<Candidate> {
    let best = (found.iter())
        .filter(|c| c.evidence.is_finite())
        .max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    Some(if best.signature.is_empty() {
        weigh(record, tangent, state, best.applied.clone())
    } else {
        best.clone()
    })
}

/// A candidate whose edges take longer, their middles kept, for each length of edge that its effect may have.
fn softened(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    sharp: &Candidate,
) -> Vec<Candidate> {
    let about = sharp.applied.effect.about();
    let edge = about.parameters.iter().enumerate();
    let Some((k, values)) = edge.into_iter().find_map(|(k, p)| match p.role {
        Role::Edge(values) => Some((k, values)),
        _ => None,
    }) else {
        return Vec::new();
    };
    (values.iter().skip(1))
        .map(|value| {
            let mut p = sharp.applied.parameters.clone();
            let longer = value - p[k];
            p[k] = *value;
            if let Some(onset) = about.onset() {
                p[onset] -= 0.5 * longer;
            }
            if let Some(duration) = about.duration() {
                p[duration] += longer;
            }
            let one = Applied::new(sharp.applied.effect, p);
            let soft = weigh(record, tangent, state, one);
            sharpen(record, tangent, state, soft)
        })
        .collect()
}

/// Moves the ends of a candidate's interval, block by block, to where they explain most.
pub(crate) fn sharpen(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    start: Candidate,
) -> Candidate {
    let effect = start.applied.effect;
    let about = effect.about();
    let Some(onset) = about.onset() else {
        return start;
    };
    let mut best = start;
    // What was weighed before was no better than the best of then.
    let mut seen = vec![best.applied.parameters.clone()];
    // What otherwise stays may end anywhere, and its energy differs too much from place to place to be proposed close by.
    let form = effect.lasting().is_some();
    let steps_s: &[f64] = if form {
        &[640.0, 320.0, 160.0, 80.0, 40.0, 20.0, 10.0]
    } else {
        &[40.0, 20.0, 10.0]
    };
    for step_s in steps_s.iter().copied() {
        for _ in 0..4 {
            let mut moved = false;
            for (ends, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
                let mut p = best.applied.parameters.clone();
                match (ends, about.duration()) {
                    (0, duration) => {
                        p[onset] += sign * step_s;
                        if let Some(d) = duration {
                            // The end stays.
                            p[d] -= sign * step_s;
                        }
                    }
                    (_, Some(d)) => p[d] += sign * step_s,
                    _ => continue,
                }
                let short = |d: usize| form && p[d] < about.parameters[d].low;
                if seen.contains(&p) || about.duration().is_some_and(short) {
                    continue;
                }
                seen.push(p.clone());
                let next = Applied::new(best.applied.effect, p);
                let next = weighed(record, tangent, state, next);
                if next.evidence() > best.evidence + 0.1 {
                    best = next.whole();
                    moved = true;
                }
            }
            if !moved {
                break;
            }
        }
    }
    best
}

/// A candidate whose signature is not worked out until it is known to be wanted.
pub(crate) struct Weighed<'a> {
    candidate: Candidate,
    sketch: Option<Sketch<'a>>,
    /// What the signature is multiplied by.
    unit: f64,
}

impl Weighed<'_> {
    pub(crate) fn evidence(&self) -> f64 {
        self.candidate.evidence
    }

    /// With its signature.
    pub(crate) fn whole(self) -> Candidate {
        let mut out = self.candidate;
        if let Some(sketch) = self.sketch {
            out.signature = sketch.signature();
            if self.unit != 1.0 {
                out.signature.iter_mut().for_each(|v| *v *= self.unit);
            }
        }
        out
    }

    /// Without.
    pub(crate) fn bare(self) -> Candidate {
        self.candidate.bare()
    }
}

/// One point of the grid, with its signature.
pub(crate) fn weigh(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    one: Applied,
) -> Candidate {
    weighed(record, tangent, state, one).whole()
}

/// One point of the grid.
pub(crate) fn weighed<'a>(
    record: &Record,
    tangent: &'a Tangent,
    state: &[Applied],
    one: Applied,
) -> Weighed<'a> {
    record.tally.weighed();
    let about = one.effect.about();
    let applied = joined(state, &one);
    if about.search.timing.is_some() {
        // A late meter or pump bends the curves that were fitted without it: they are fitted again.
        let left = tangent.left_over(record, &applied);
        let signature: Vec<f64> = (tangent.off.iter().zip(&left))
            .map(|(a, b)| a - b)
            .collect();
        let energy = dot(&signature, &signature);
        let score = dot(&signature, &tangent.off);
        let evidence = 0.5 * (dot(&tangent.off, &tangent.off) - dot(&left, &left));
        let candidate = Candidate {
            applied: one,
            signature,
            energy,
            score,
            evidence,
        };
        return Weighed {
            candidate,
            sketch: None,
            unit: 1.0,
        };
    }
    let sketch = tangent.sketch(record, &applied);
    let grid = on_grid(about);
    let unit = if grid { 1.0 } else { 1.0 / one.parameters[0] };
    let (energy, score) = (unit * unit * sketch.energy, unit * sketch.score);
    let evidence = if grid {
        score - 0.5 * energy
    } else {
        // Of one sign, that of the strength that is tried.
        let one_sided = about.parameters[0].low >= 0.0;
        let usual = about.parameters[0].usual;
        evidence(energy, score * unit.signum(), usual, one_sided)
    };
    let candidate = Candidate {
        applied: one,
        signature: Vec::new(),
        energy,
        score,
        evidence,
    };
    Weighed {
        candidate,
        sketch: Some(sketch),
        unit,
    }
}

#[cfg(test)]
mod tests;
