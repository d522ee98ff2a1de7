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
use crate::tangent::{Tangent, dot};
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
    let each = |said: &dyn Fn(&Level) -> String| {
        let each = e
            .levels
            .iter()
            .map(|l| format!("{}: {}", names[l.output], said(l)));
        each.collect::<Vec<_>>().join("; ")
    };
    let of_either =
        |l: &Level| excused_by(l, l.rms * e.context.scale[l.output], accuracies[l.output]);
    match e.excuse {
        Some(Excuse::Accuracy) => checks.push(Check {
            name: "the re-fitted base is off by no more than the accuracy stated".into(),
            passed: true,
            detail: each(&of_either),
        }),
        Some(Excuse::Noise | Excuse::Small) => checks.push(Check {
            name: "each instrument is within its accuracy, or off by the noise to ten per cent and chance"
                .into(),
            passed: true,
            detail: each(&of_either),
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

fn of_noise(l: &Level) -> String {
    format!("{:.2} times its noise", l.ratio())
}

/// What excuses an instrument that is `off` by so much: its accuracy, else its noise.
fn excused_by(l: &Level, off: f64, accuracy: Option<f64>) -> String {
    match accuracy {
        // In no unit: whoever shows it has units of its own.
        Some(stated) if off <= stated => format!("{:.2} of its accuracy", off / stated),
        _ => of_noise(l),
    }
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

/// Why the claim does not stand on the test part; `None` if it does, or if there is no such part or too few readings in it.
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
    let mut told = false;
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
        let share = format!("{name}: {:.3} of what it was", ra / rb);
        let line = if low.is_finite() {
            told = true;
            format!("{share}, 95 % {:.3} to {:.3}", 1.0 - high, 1.0 - low)
        } else {
            format!("{share}, too few readings for an interval")
        };
        sum += (ra / e.context.scale[o]).powi(2) - (rb / e.context.scale[o]).powi(2);
        gains |= low > 0.0;
        // A worsening counts that is more than chance and more than a twentieth of what noise there is.
        if high < 0.0 && ra > 1.05 * rb {
            worst.push(line.clone());
        }
        best.push(line);
    }
    if !told {
        // As without a test part: so few readings speak neither for it nor against it.
        checks.push(Check {
            name: "stands on the test part".into(),
            passed: true,
            detail: format!(
                "fewer than {} readings of each instrument, which tell nothing: the claim rests on left-out blocks of the training part{}",
                confirm::FEWEST,
                best.iter().map(|b| format!("; {b}")).collect::<String>()
            ),
        });
        return None;
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
    let shares = shifted(e.context, e.memory, without, member);
    let passed = shares.is_some_and(|(own, moved)| at_its_place(own, moved));
    match shares {
        Some((own, None)) => Check {
            name,
            passed,
            detail: format!(
                "explains {:.1} % of the squares at its place; nothing to shift against, as it is the same wherever it is shifted to",
                100.0 * own
            ),
        },
        Some((own, Some(greatest))) => Check {
            name,
            passed,
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

/// Whether a member stands its placebo, by what [`shifted`] tells.
pub(crate) fn at_its_place(own: f64, moved: Option<f64>) -> bool {
    moved.is_none_or(|moved| own > moved)
}

/// Correlation with the change at its place from which on a shifted one is the same: an experiment repeated after half the record
/// maps onto itself, and round-off tells which of the two explains more. Set by hand.
const SAME: f64 = 0.9;

/// Share of the squares left by `without` that a member's change takes at its place, and at most when it is shifted along the
/// record by eighths; `None` in place of the latter where every shift maps it onto itself.
pub(crate) fn shifted(
    c: &Context<'_>,
    memory: usize,
    without: &Trial,
    member: usize,
) -> Option<(f64, Option<f64>)> {
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
    let gain = |d: &[f64]| along(d, &base.off) / total;
    let rows: Vec<Vec<usize>> = (0..c.scale.len()).map(|o| c.data.of_output(o)).collect();
    let others = others(&point.direction, &rows, &base.tangent);
    Some((
        gain(&point.direction),
        others.iter().map(|d| gain(d)).reduce(f64::max),
    ))
}

/// Square of the part of `v` along `direction`.
fn along(direction: &[f64], v: &[f64]) -> f64 {
    dot(direction, v).powi(2) / dot(direction, direction).max(1e-300)
}

/// A direction off the tangent, shifted along the rows of each output by eighths, where it is no longer the [`SAME`].
fn others(direction: &[f64], rows: &[Vec<usize>], tangent: &Tangent) -> Vec<Vec<f64>> {
    let shifted = |shift: usize| {
        let mut moved = vec![0.0; direction.len()];
        for rows in rows {
            let n = rows.len();
            for (k, &i) in rows.iter().enumerate() {
                moved[i] = direction[rows[(k + shift * n / 8) % n]];
            }
        }
        tangent.off(&moved)
    };
    let differs = |d: &Vec<f64>| along(d, direction) < SAME * SAME * dot(direction, direction);
    (1..=7).map(shifted).filter(differs).collect()
}

#[cfg(test)]
mod tests {
    use super::{at_its_place, ends_by_nature, excused_by, others};
    use crate::floor::Level;
    use crate::tangent::Tangent;
    use dgd_assembly::EffectParameter;

    #[test]
    fn a_change_that_a_shift_maps_onto_itself_is_no_placebo_of_itself() {
        let rows = [(0..80).collect::<Vec<usize>>()];
        let none = Tangent::of([]);
        let of = |f: fn(usize) -> bool| -> usize {
            let direction: Vec<f64> = (0..80).map(|i| f64::from(u8::from(f(i)))).collect();
            others(&direction, &rows, &none).len()
        };
        assert_eq!(of(|i| i < 5), 7);
        // The same experiment twice: not where it is shifted by half.
        assert_eq!(of(|i| i % 40 < 5), 6);
        assert_eq!(of(|i| i % 10 < 5), 0);
        assert!(at_its_place(0.2, None) && at_its_place(0.2, Some(0.1)));
        assert!(!at_its_place(0.2, Some(0.2)));
    }

    #[test]
    fn an_instrument_within_its_accuracy_is_not_said_to_be_within_its_noise() {
        let level = Level {
            output: 0,
            rms: 5.0,
            floor: 1.0,
            readings: 100,
            memory: 0.0,
            own: false,
            rounding: false,
        };
        let of = |accuracy| excused_by(&level, 10.0, accuracy);
        assert_eq!(of(Some(20.0)), "0.50 of its accuracy");
        assert_eq!(of(Some(9.0)), "5.00 times its noise");
        assert_eq!(of(None), "5.00 times its noise");
    }

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
