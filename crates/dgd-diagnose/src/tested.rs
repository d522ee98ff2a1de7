//! What was looked for: each effect of the catalogue with its detection limit, and the placebo.

use crate::diagnosis::{Check, Finding, Outcome, Tested};
use crate::heave::Swell;
use crate::record::Record;
use crate::scan::{joined, weigh};
use crate::select::{Selection, hurdle};
use crate::tangent::{Bend, Tangent};
use dgd_effects::catalogue;

/// The same effect at a shifted time, or with a foreign driver, must not gain: the strongest finding with its onset
/// moved by a third of the recording.
pub(crate) fn placebo(record: &Record, selection: &Selection) -> Vec<Check> {
    let mut out = Vec::new();
    for named in &selection.named {
        let about = named.applied.effect.about();
        let Some(onset) = about.onset() else { continue };
        let mut others = selection.allowances.clone();
        for n in &selection.named {
            if n.applied.effect.about().id != about.id {
                others = joined(&others, &n.applied);
            }
        }
        let Some(tangent) = Tangent::at(record, &others, &[], Bend::Free) else {
            continue;
        };
        let span = record.setting.span_s;
        let shift = 0.33 * (span.1 - span.0);
        let mut moved = named.applied.clone();
        let later = moved.parameters[onset] + shift;
        moved.parameters[onset] = if later < span.1 - 1800.0 {
            later
        } else {
            moved.parameters[onset] - shift
        };
        let true_one = weigh(record, &tangent, &others, named.applied.clone());
        let false_one = weigh(record, &tangent, &others, moved.clone());
        out.push(Check {
            name: format!("{}: placebo at another time explains less", about.id),
            passed: false_one.evidence < 0.7 * true_one.evidence,
            detail: format!(
                "ln Bayes factor {:.0} at {:.0} s, {:.0} at {:.0} s",
                true_one.evidence,
                named.applied.parameters[onset],
                false_one.evidence,
                moved.parameters[onset]
            ),
        });
    }
    out
}

/// How each effect of the catalogue fared, and the smallest strength that would have passed its hurdle.
pub(crate) fn tested(
    record: &Record,
    selection: &Selection,
    findings: &[Finding],
    swell: Option<Swell>,
) -> Vec<Tested> {
    let connections = record.setting.connections.len();
    let stops = record
        .filled
        .pumping
        .windows(2)
        .filter(|w| w[0] && !w[1])
        .count();
    let booster = {
        let v = &record.filled.booster;
        let (low, high) = v
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
        high - low > 1e-3
    };
    catalogue()
        .iter()
        .map(|effect| {
            let about = effect.about();
            let first = selection.first.iter().find(|f| f.0 == about.id);
            let missing = match about.id {
                "gel_strength" | "line_drainage" if stops == 0 => {
                    Some("the subsea pump never stops")
                }
                "pipe_displacement" | "u_tube" | "cuttings_loading" if connections == 0 => {
                    Some("the mud pump never stops")
                }
                "booster_line_storage" if !booster => Some("the booster flow does not change"),
                "heave" if swell.is_none() => Some("the sampling is too slow to show swell"),
                "outlet_pressure_bias_step" if record.outlets.len() < 2 => None,
                _ => None,
            };
            let found = findings
                .iter()
                .any(|f| f.effect == about.id && f.probability >= 0.5);
            let outcome = if found {
                Outcome::Found
            } else if let Some(why) = missing {
                Outcome::NotTestable(why.to_owned())
            } else if first.is_none() && about.id != "heave" {
                Outcome::NotTestable("nothing in the recording excites it".to_owned())
            } else {
                Outcome::NotSeen
            };
            let energy = first.map_or(0.0, |f| f.2);
            let limit =
                (energy > 0.0).then(|| (2.0 * (hurdle(about.id).0 + 3.0)).sqrt() / energy.sqrt());
            let shown = |v: f64| match about.id {
                "annulus_area" => v * record.setting.riser_area_m2,
                _ => v,
            };
            Tested {
                effect: about.id,
                title: about.title,
                outcome,
                evidence: first.map_or(0.0, |f| f.1),
                strength: about.parameters[0].name,
                limit: limit.filter(|l| l.is_finite()).map(shown),
            }
        })
        .collect()
}
