//! A finding in words and numbers.

use crate::diagnosis::{CorrectionCurve, Finding, HeldOut, ParameterEstimate};
use crate::estimates::Estimator;
use crate::heave::Swell;
use crate::numbers::tails;
use crate::record::Record;
use crate::selection::Named;
use crate::twins::Pair;
use dgd_effects::{About, Curve, Excitation, Place, Quantity, Relation, find, told_apart_by};

/// One named effect, or the correction that no effect explains.
///
/// - `held_out`: gain on the held-out windows, the same for each finding.
pub(crate) fn finding(
    record: &Record,
    named: &Named,
    estimator: &Estimator,
    held_out: Option<HeldOut>,
) -> Finding {
    let about = named.applied.effect.about();
    let curve = named.applied.curve();
    let place = curve.as_ref().map(|c| c.place);
    let relation = place.map_or(about.relation, Place::relation);
    let before = match place {
        Some(place) => (place.reading()).unwrap_or_else(|| base_equation(place.relation())),
        None => equation_without(about),
    };
    let title = amiss(named, record.setting.span_s).map_or_else(
        || about.title.to_owned(),
        |amiss| format!("something outside the catalogue: {amiss}"),
    );
    let span = record.setting.span_s;
    let interval = named.applied.interval_s(span);
    let told = Finding {
        effect: about.id.to_owned(),
        resembles: None,
        title,
        probability: named.probability.clamp(0.01, 0.99),
        alternatives: named.alternatives.clone(),
        relation,
        shows_in: place.map_or_else(|| vec![relation], |p| p.shows_in().to_vec()),
        pair: (place.and_then(Pair::of))
            .or((about.sensor().is_some() && record.outlets.len() > 1).then_some(Pair::Outlets))
            .map(Pair::name),
        intervals_s: vec![interval],
        region: region(record, about, interval),
        parameters: estimator.estimates(named),
        curve: curve.as_ref().map(|curve| told_curve(curve, span)),
        held_out,
        equation_before: before.to_owned(),
        equation_after: match &curve {
            Some(curve) => format!("{before} + f({})", curve.quantity.name()),
            None => about.equation.to_owned(),
        },
        source: about.source.to_owned(),
        evidence: named.evidence,
        hurdle: named.hurdle,
        separating_test: separating_test(about.id, &named.alternatives),
        same_as: same_as(record, named),
    };
    // What passes, but not within the recording, does not look like it in that.
    let lasts = about.duration().map(|k| named.applied.parameters[k]);
    let stays = lasts.is_some_and(|lasts_s| lasts_s > record.lasts_s());
    only_resembled(told, about, stays)
}

/// What of the model a correction finds amiss, such as "pump head depends on inlet pressure"; `None` of a cause.
pub(crate) fn amiss(named: &Named, span_s: (f64, f64)) -> Option<String> {
    let curve = named.applied.curve()?;
    let does = if let Some((from_s, to_s)) = curve.episode_s(span_s) {
        match (from_s > span_s.0, to_s < span_s.1) {
            (true, false) => format!("shifts at {from_s:.0} s"),
            (false, _) => format!("is off until {to_s:.0} s"),
            (true, true) => format!("is off from {from_s:.0} s to {to_s:.0} s"),
        }
    } else if let Some((from_s, to_s)) = curve.period_s() {
        format!("swings with a period of {:.0} min", (to_s - from_s) / 60.0)
    } else if is_level(&curve.knots, SAME) {
        "is offset by a constant amount".to_owned()
    } else if curve.quantity == Quantity::Time {
        "drifts over time".to_owned()
    } else {
        format!("depends on {}", curve.quantity.name())
    };
    Some(format!("{} {does}", curve.place.name()))
}

/// A finding whose effect is likelier to resemble the cause than to be it, told as what the catalogue does not hold.
fn only_resembled(mut told: Finding, about: &About, stays: bool) -> Finding {
    let unknown = dgd_effects::unknown().about().id;
    let at = (told.alternatives.iter())
        .position(|(id, probability)| id == unknown && *probability > told.probability);
    let Some(at) = at else {
        return told;
    };
    let (_, probability) = told.alternatives.remove(at);
    let named = std::mem::replace(&mut told.effect, unknown.to_owned());
    told.alternatives.push((named, told.probability));
    told.alternatives.sort_by(|a, b| b.1.total_cmp(&a.1));
    told.separating_test = separating_test(unknown, &told.alternatives);
    // They are those of what it looks like.
    told.parameters.clear();
    told.same_as = None;
    Finding {
        resembles: Some(about.id),
        title: format!(
            "something outside the catalogue, which looks as if {}{}",
            about.title,
            if stays { ", but stays" } else { "" }
        ),
        probability: probability.clamp(0.01, 0.99),
        ..told
    }
}

/// Share of its mean by which a curve may vary to be the same all along.
const SAME: f64 = 0.1;

/// Whether knots vary by less than a share of their mean.
fn is_level(knots: &[f64], share: f64) -> bool {
    let mean = knots.iter().sum::<f64>() / knots.len() as f64;
    knots
        .iter()
        .all(|knot| (knot - mean).abs() < 0.5 * share * mean.abs())
}

/// What would show the same if the description of the well were at fault; a correction of the outlet's reading or of the friction that is
/// nearly the same all along is nearly an offset.
fn same_as(record: &Record, named: &Named) -> Option<String> {
    /// Share of its mean by which a curve may vary to be nearly an offset.
    const LEVEL: f64 = 0.5;
    let Some(curve) = named.applied.curve() else {
        let (effect, parameters) = (named.applied.effect, &named.applied.parameters);
        return effect.same_as(parameters, &record.setting);
    };
    if curve.quantity == Quantity::Episode {
        return None;
    }
    let Curve { place, knots, .. } = curve;
    if place == Place::Balance && is_level(&knots, SAME) {
        let told = "a flow meter with a zero error, or a flow that is in another unit, under another tag or not logged";
        return Some(told.to_owned());
    }
    let outlet = matches!(place, Place::OutletReading | Place::Friction);
    let mean = knots.iter().sum::<f64>() / knots.len() as f64;
    let offset = (outlet && is_level(&knots, LEVEL)).then(|| find("outlet_pressure_bias"))??;
    let told = offset.same_as(&[mean], &record.setting)?;
    Some(format!("mostly {told}"))
}

/// The curve of a correction, as it is told.
fn told_curve(curve: &Curve, span_s: (f64, f64)) -> CorrectionCurve {
    /// Points to a stretch between knots that lie along a logarithm, where the curve is not straight.
    const BENT: usize = 8;
    let adds = match curve.place {
        Place::MeterFactor => "correction_fraction",
        Place::Balance => "correction_m3_s",
        _ => "correction_pa",
    };
    if let Some((begins, ends)) = curve.episode_s(span_s) {
        let value = curve.at(begins);
        let mut knots = vec![(begins, value), (ends, value)];
        // At an end of the recording there is no edge.
        if begins > span_s.0 {
            knots.splice(0..0, [(span_s.0, 0.0), (begins, 0.0)]);
        }
        if ends < span_s.1 {
            knots.extend([(ends, 0.0), (span_s.1, 0.0)]);
        }
        return CorrectionCurve {
            along: Quantity::Time.si_name(),
            adds,
            knots,
            level: Some(value),
        };
    }
    let (from, to, values) = (curve.from, curve.to, &curve.knots);
    let last = values.len() - 1;
    // Knots lie evenly along the logarithm of the minutes and one.
    let bent = curve.quantity == Quantity::SinceStart;
    let points = if bent { BENT } else { 1 };
    let at = |x: f64| if bent { 60.0 * x.exp_m1() } else { x };
    let knots = (0..=points * last)
        .map(|j| {
            let (k, beyond) = (j / points, (j % points) as f64 / points as f64);
            let next = values[last.min(k + 1)];
            let value = if beyond > 0.0 {
                values[k] + beyond * (next - values[k])
            } else {
                values[k]
            };
            let share = j as f64 / (points * last) as f64;
            (at(from + (to - from) * share), value)
        })
        .collect();
    CorrectionCurve {
        along: curve.quantity.si_name(),
        adds,
        knots,
        level: None,
    }
}

/// What would tell a cause from its likeliest serious alternative for which the catalogue knows a test.
fn separating_test(id: &str, alternatives: &[(String, f64)]) -> Option<String> {
    let mut serious = (alternatives.iter()).filter(|(_, p)| *p >= Finding::SERIOUS);
    (serious.find_map(|(other, _)| told_apart_by(id, other))).map(str::to_owned)
}

/// What an effect changes, as the base model has it.
fn equation_without(about: &About) -> &'static str {
    about
        .equation_without
        .unwrap_or_else(|| base_equation(about.relation))
}

/// The relation as the base model has it.
fn base_equation(relation: Relation) -> &'static str {
    match relation {
        Relation::ReturnLineFriction => "p_out = p_0 + rho g L + phi(q) + rho L/A dq/dt",
        Relation::PumpHead => "p_out - p_in = H(w, q)",
        Relation::RiserMassBalance => "A dh/dt = q_in - q",
        Relation::Momentum => "rho L/A dq/dt = p_out - p_0 - rho g L - phi(q)",
        Relation::Instrument => "p_meter = p",
    }
}

/// The operating region in which an effect acts.
fn region(record: &Record, about: &About, interval: (f64, f64)) -> String {
    let inside: Vec<usize> = (0..record.t_s.len())
        .filter(|i| record.t_s[*i] >= interval.0 && record.t_s[*i] <= interval.1)
        .collect();
    if about.search.needs.contains(&Excitation::PumpStops) {
        return stops(record, &inside);
    }
    let range = |values: &[f64], least: f64| -> Option<(f64, f64)> {
        let v: Vec<f64> = inside
            .iter()
            .map(|i| values[*i])
            .filter(|x| *x > least)
            .collect();
        tails(&v, 20)
    };
    let flow = range(&record.flow, 1e-3);
    let speed = range(&record.speed, 5.0);
    match (flow, speed) {
        (Some(q), Some(w)) => format!(
            "return flow {:.0} to {:.0} L/min, pump speed {:.0} to {:.0} %",
            q.0 * 6e4,
            q.1 * 6e4,
            w.0,
            w.1
        ),
        _ if inside.iter().any(|i| record.filled.pumping[*i]) => {
            "no reading of return flow and pump speed together".to_owned()
        }
        _ => "pump at rest".to_owned(),
    }
}

/// How often, and for how long, the pump stands in these samples.
fn stops(record: &Record, inside: &[usize]) -> String {
    let pumping = &record.filled.pumping;
    let times = inside
        .chunk_by(|a, b| pumping[*a] == pumping[*b])
        .filter(|run| run.first().is_some_and(|i| !pumping[*i]))
        .count();
    let rests = inside.iter().filter(|i| !pumping[**i]).count();
    let minutes = rests as f64 * record.dt_s / 60.0;
    let lasts = if minutes < 90.0 {
        format!("{minutes:.0} min")
    } else {
        format!("{:.1} h", minutes / 60.0)
    };
    let plural = if times == 1 { "" } else { "s" };
    format!("{times} stop{plural} of the pump, {lasts} at rest")
}

/// Doubt in a swell that stands no higher than it must; one twice as high is doubted half as much. Set by hand, not calibrated.
const DOUBT: f64 = 0.4;

/// Standard deviation that the period of a swell has at the least, s: the sea's own changes by more within hours.
const LEAST_PERIOD_SD_S: f64 = 0.05;

/// An effect that comes from a spectrum, not from the relations.
pub(crate) fn heaving(
    record: &Record,
    about: &About,
    s: Swell,
    held_out: Option<HeldOut>,
) -> Finding {
    let span = record.setting.span_s;
    let within = |value: f64, sd: f64| (value, (value - 1.96 * sd, value + 1.96 * sd));
    // Period, then amplitude.
    let found = [
        within(s.period_s, s.period_sd_s.max(LEAST_PERIOD_SD_S)),
        within(s.amplitude_m, s.amplitude_sd_m),
    ];
    Finding {
        effect: about.id.to_owned(),
        resembles: None,
        title: about.title.to_owned(),
        probability: (1.0 - DOUBT * s.believed / s.ratio).min(0.98),
        alternatives: Vec::new(),
        relation: about.relation,
        shows_in: vec![about.relation],
        pair: None,
        intervals_s: vec![span],
        region: region(record, about, span),
        parameters: about
            .parameters
            .iter()
            .zip(found)
            .map(|(p, (estimate, ci95))| ParameterEstimate {
                name: p.name.to_owned(),
                meaning: p.meaning.to_owned(),
                estimate,
                ci95,
            })
            .collect(),
        curve: None,
        held_out,
        equation_before: equation_without(about).to_owned(),
        equation_after: about.equation.to_owned(),
        source: about.source.to_owned(),
        evidence: s.evidence,
        hurdle: s.hurdle,
        separating_test: None,
        same_as: (s.folded_s).map(|folded_s| {
            format!("a motion with a period of {folded_s:.1} s, if nothing smooths it before the logger: sampled so seldom the two are one")
        }),
    }
}

#[cfg(test)]
mod tests;
