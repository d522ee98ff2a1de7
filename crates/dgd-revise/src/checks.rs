//! Checks on what is claimed, passed or failed.

use crate::baseline::{self, Baseline};
use crate::chain::Withdrawn;
use crate::conclude::{Evidence, Told};
use crate::confirm::{self};
use crate::context::{Context, Trial};
use crate::findings::Standing;
use crate::floor::Level;
use crate::noise::{lags, portmanteau};
use crate::revision::{Check, Excuse};
use crate::screen::screen;
use crate::tangent::dot;
use crate::validate::LeftOut;
use dgd_assembly::EffectParameter;

/// - `slight`: members taken from the chosen set because they may as well be none.
pub(crate) fn gate_checks(e: &Evidence<'_, '_>, slight: &[usize]) -> Vec<Check> {
    let words = [
        "catalogue, whitened residual",
        "catalogue, plain residual",
        "corrections, whitened residual",
        "corrections, plain residual",
        "memory of the residual",
    ];
    let detail: Vec<String> = words
        .iter()
        .zip(e.gate)
        .map(|(w, p)| format!("{w}: p = {p:.3}"))
        .collect();
    let open = e.open(&e.gate);
    // A gate that stays shut is the answer, not a failure.
    let mut checks = vec![Check {
        name: if open {
            "more than noise is left of the re-fitted base"
        } else {
            "no more than noise is left of the re-fitted base"
        }
        .into(),
        passed: true,
        detail: detail.join("; "),
    }];
    let names = e.context.assembly.outputs();
    let accuracies = e.context.assembly.accuracies();
    let off = |l: &Level| l.rms * e.context.scale[l.output];
    let each = |said: &dyn Fn(&Level) -> String| {
        let each = e
            .levels
            .iter()
            .map(|l| format!("{}: {}", names[l.output], said(l)));
        each.collect::<Vec<_>>().join("; ")
    };
    let of_noise = |l: &Level| format!("{:.2} times its noise", l.ratio());
    match e.excuse {
        Some(Excuse::Accuracy) => checks.push(Check {
            name: "the re-fitted base is off by no more than the accuracy stated".into(),
            passed: true,
            detail: each(&|l| {
                // In no unit: whoever shows it has units of its own.
                let stated = accuracies[l.output].unwrap_or(f64::NAN);
                format!("{:.2} of it", off(l) / stated)
            }),
        }),
        Some(Excuse::Noise | Excuse::Small) => checks.push(Check {
            name: "the re-fitted base is off by the noise to ten per cent".into(),
            passed: true,
            detail: each(&of_noise),
        }),
        None if e.levels.iter().any(Level::unexcused) => checks.push(Check {
            // As above: that more is left is why effects were sought.
            name: "what the re-fitted base leaves is more than the instruments' own noise".into(),
            passed: true,
            detail: each(&of_noise),
        }),
        None => {}
    }
    if !slight.is_empty() {
        checks.push(Check {
            name: "effects that may as well be none are not claimed".into(),
            passed: true,
            detail: format!(
                "within two standard errors of no change: {}",
                e.names(slight).join("; ")
            ),
        });
    }
    if !e.unlikely.is_empty() {
        let each = e.unlikely.iter();
        let said: Vec<String> = each
            .map(|(m, w)| format!("{}: weight {w:.2}", e.name(*m)))
            .collect();
        checks.push(Check {
            name: "effects of less weight than a half are not claimed".into(),
            passed: true,
            detail: said.join("; "),
        });
    }
    checks
}

/// Whether the named set leaves no more than noise.
pub(crate) fn remainder(e: &Evidence<'_, '_>, poor: &[Level]) -> Check {
    let names = e.context.assembly.outputs();
    let said: Vec<String> = poor
        .iter()
        .map(|l| format!("{}: {:.1} times its noise", names[l.output], l.ratio()))
        .collect();
    Check {
        name: "what is named leaves no more than twice the noise".into(),
        passed: poor.is_empty(),
        detail: if poor.is_empty() {
            "of any instrument, training and test part".into()
        } else {
            said.join("; ")
        },
    }
}

/// Whether a named effect has a weight of a half.
pub(crate) fn outweighs(
    e: &Evidence<'_, '_>,
    standing: &[Standing],
    unexplained: f64,
    passed: bool,
) -> Check {
    let each = standing.iter().map(|s| {
        let name = e.name(s.member);
        format!("{name}: {:.2} with its alternatives", s.together)
    });
    let said: Vec<String> = each.collect();
    Check {
        name:
            "something named has a weight of half or more, less chance and what stays unexplained"
                .into(),
        passed,
        detail: format!(
            "{}; {:.0} % of the remaining squares are not noise",
            said.join("; "),
            100.0 * unexplained
        ),
    }
}

/// Why the claim does not stand on the test part; `None` if it does, or if there is no such part.
pub(crate) fn confirmation(
    e: &Evidence<'_, '_>,
    before: &Told,
    after: &Told,
    checks: &mut Vec<Check>,
) -> Option<Withdrawn> {
    let (Some(b), Some(a)) = (&before.test, &after.test) else {
        if e.test.data.windows.is_empty() {
            checks.push(Check {
                name: "stands on the test part".into(),
                passed: true,
                detail: "there is none: the claim rests on left-out blocks of the training part"
                    .into(),
            });
            return None;
        }
        checks.push(Check {
            name: "stands on the test part".into(),
            passed: false,
            detail: "a model cannot be simulated there".into(),
        });
        return Some(Withdrawn::NotRun);
    };
    let (mut gains, mut best, mut worst, mut sum) = (false, Vec::new(), Vec::new(), 0.0);
    for (o, name) in e.context.assembly.outputs().iter().enumerate() {
        let (rb, ra) = (
            confirm::rms(b, &e.test.data, o),
            confirm::rms(a, &e.test.data, o),
        );
        if !rb.is_finite() {
            continue;
        }
        let (low, high) = confirm::gain_interval(b, a, &e.test.data, o, e.memory);
        // In no unit: whoever shows it has units of its own.
        let line = format!(
            "{name}: {:.3} of what it was, 95 % {:.3} to {:.3}",
            ra / rb,
            1.0 - high,
            1.0 - low
        );
        sum += (ra / e.context.scale[o]).powi(2) - (rb / e.context.scale[o]).powi(2);
        gains |= low > 0.0;
        // A worsening counts that is more than chance and more than a twentieth of what noise there is.
        if high < 0.0 && ra > 1.05 * rb {
            worst.push(line.clone());
        }
        best.push(line);
    }
    // The sum over outputs, each in its own scale, must fall as well.
    let why = if sum >= 0.0 {
        Some(Withdrawn::Worse)
    } else {
        (!gains).then_some(Withdrawn::Chance)
    };
    checks.push(Check {
        name: "stands on the test part".into(),
        passed: why.is_none(),
        detail: best.join("; "),
    });
    checks.push(Check {
        name: "no instrument is met worse on the test part".into(),
        passed: worst.is_empty(),
        detail: if worst.is_empty() {
            "none".into()
        } else {
            worst.join("; ")
        },
    });
    why
}

pub(crate) fn whiteness(e: &Evidence<'_, '_>, rows: &[f64], checks: &mut Vec<Check>) {
    for (o, name) in e.context.assembly.outputs().iter().enumerate() {
        let values: Vec<f64> = e
            .context
            .data
            .of_output(o)
            .iter()
            .map(|&i| rows[i])
            .collect();
        if values.len() < 30 {
            continue;
        }
        let (q, deviate) = portmanteau(&values, lags(values.len()));
        checks.push(Check {
            name: format!("residual of {name} is white"),
            passed: deviate < 2.33,
            detail: format!("Ljung-Box {q:.0}, {deviate:.1} standard deviations"),
        });
    }
}

pub(crate) fn bounds_check(
    e: &Evidence<'_, '_>,
    trial: &Trial,
    left: &LeftOut,
    checks: &mut Vec<Check>,
) {
    let (mut at, mut ends): (Vec<String>, Vec<String>) = Default::default();
    let mut turning: Vec<String> = Vec::new();
    for &m in &trial.members {
        let h = &e.context.hypotheses[m];
        for (k, p) in h.parameters.iter().enumerate() {
            let path = crate::context::path(h, p);
            let Some(i) = trial.paths.iter().position(|q| *q == path) else {
                continue;
            };
            let value = trial.minimum.theta[i];
            let near = 1e-6 * (p.high - p.low);
            let (side, bound) = match (value - p.low <= near, p.high - value <= near) {
                (true, _) => ("lower", p.low),
                (_, true) => ("upper", p.high),
                _ => ("", f64::NAN),
            };
            if ends_by_nature(p, bound) {
                ends.push(format!("{path} is {bound}, where it ends by nature"));
            } else if !side.is_empty() {
                at.push(format!("{path} is on its {side} bound"));
            }
            let side = |t: &Vec<f64>| (t[i] - p.neutral).signum();
            if k == 0
                && p.neutral.is_finite()
                && left
                    .thetas
                    .iter()
                    .any(|t| side(t) != (value - p.neutral).signum())
            {
                turning.push(path);
            }
        }
    }
    checks.push(Check {
        name: "effects lie within their bounds".into(),
        passed: at.is_empty(),
        detail: match at.is_empty() {
            true if ends.is_empty() => "all".into(),
            true => format!("all; {}", ends.join("; ")),
            false => at.join("; "),
        },
    });
    checks.push(Check {
        name: "effects keep their sign in every fold".into(),
        passed: turning.is_empty(),
        detail: if turning.is_empty() {
            "all".into()
        } else {
            turning.join("; ")
        },
    });
}

/// Whether a parameter can be no more than a bound whatever the range that is searched: a share of none or all, a size of nothing.
fn ends_by_nature(p: &EffectParameter, bound: f64) -> bool {
    let share = p.low == 0.0 && p.high == 1.0;
    bound == 0.0 || bound == p.neutral || (share && bound == p.high)
}

/// The same change of the readings, shifted along the record, must explain less of what the member explains.
pub(crate) fn placebo(e: &Evidence<'_, '_>, without: &Trial, member: usize) -> Check {
    let name = format!("placebo of {}", e.name(member));
    match shifted(e.context, e.memory, without, member) {
        Some((own, greatest)) => Check {
            name,
            passed: own > greatest,
            detail: format!(
                "explains {:.1} % of the squares at its place, {:.1} % at most when shifted",
                100.0 * own,
                100.0 * greatest
            ),
        },
        None => Check {
            name,
            passed: false,
            detail: "nothing to shift".into(),
        },
    }
}

/// Share of the squares left by `without` that a member's change takes at its place, and at most when it is shifted along the
/// record by eighths.
pub(crate) fn shifted(
    c: &Context<'_>,
    memory: usize,
    without: &Trial,
    member: usize,
) -> Option<(f64, f64)> {
    let blocks = crate::blocks::Blocks::new(c.data, memory);
    let own = |base: &Baseline| {
        let screened = screen(c, base, &blocks, &[member]);
        screened.into_iter().next()?.points.into_iter().next()
    };
    let fitted = Baseline::of(c, without)?;
    let (base, point) = match own(&fitted) {
        Some(point) => (fitted, point),
        // On its bounds the rest may leave it nothing to act on.
        None => {
            let inside = baseline::inside(c, without)?;
            let point = own(&inside)?;
            (inside, point)
        }
    };
    let total = dot(&base.off, &base.off).max(1e-300);
    let gain = |d: &[f64]| dot(d, &base.off).powi(2) / dot(d, d).max(1e-300) / total;
    let mut greatest = 0.0_f64;
    for shift in 1..=7 {
        let mut moved = vec![0.0; point.direction.len()];
        for o in 0..c.scale.len() {
            let rows = c.data.of_output(o);
            let n = rows.len();
            for (k, &i) in rows.iter().enumerate() {
                moved[i] = point.direction[rows[(k + shift * n / 8) % n]];
            }
        }
        greatest = greatest.max(gain(&base.tangent.off(&moved)));
    }
    Some((gain(&point.direction), greatest))
}

#[cfg(test)]
mod tests {
    use super::ends_by_nature;
    use dgd_assembly::EffectParameter;

    #[test]
    fn none_and_all_are_natural_ends_and_how_far_a_search_goes_is_not() {
        let of = |low: f64, high: f64, neutral: f64| EffectParameter {
            name: "share",
            low,
            high,
            neutral,
            usual: high,
        };
        let share = of(0.0, 1.0, 0.0);
        assert!(ends_by_nature(&share, 0.0) && ends_by_nature(&share, 1.0));
        assert!(!ends_by_nature(&of(0.0, 0.2, 0.0), 0.2));
        let exponent = of(-0.6, 1.0, 0.0);
        assert!(!ends_by_nature(&exponent, -0.6) && !ends_by_nature(&exponent, 1.0));
        assert!(!ends_by_nature(&share, f64::NAN));
    }
}
