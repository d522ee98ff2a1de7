//! The answer of a diagnosis for the terminal: one sentence, the findings, what was tested, the files.

use crate::say::{TextTable, brief, count};
use dgd_diagnose::{CorrectionCurve, Diagnosis, Finding, HeldOut, Outcome, Tested, Verdict};
use dgd_units::Legible;
use std::fmt::Write as _;
use std::path::Path;

/// The whole answer.
pub(super) fn tell(
    diagnosis: &Diagnosis,
    departures: &[(String, String)],
    recording: &str,
    out: &Path,
) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = tell_into(&mut text, diagnosis, departures, recording, out);
    text
}

fn tell_into(
    text: &mut String,
    diagnosis: &Diagnosis,
    departures: &[(String, String)],
    recording: &str,
    out: &Path,
) -> std::fmt::Result {
    writeln!(text, "{recording}: {}\n", sentence(diagnosis))?;
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        tell_finding(text, index + 1, finding, diagnosis)?;
    }
    // What they gain is known of all together.
    if let Some(gain) = diagnosis.findings.iter().find_map(|f| f.held_out.as_ref()) {
        let said = if diagnosis.acts_held_out() {
            gained(gain, with(diagnosis))
        } else {
            "no held-out window lies where what was found acts, so they say nothing of it"
                .to_owned()
        };
        writeln!(text, "held out: {said}\n")?;
    }
    tell_tested(text, diagnosis)?;
    for (name, what) in departures {
        writeln!(text, "{name}: {what}")?;
    }
    let (passed, all) = (
        diagnosis.checks.iter().filter(|c| c.passed).count(),
        diagnosis.checks.len(),
    );
    if all > 0 {
        writeln!(text, "checks: {passed} of {all} passed")?;
    }
    for check in diagnosis.checks.iter().filter(|c| !c.passed) {
        writeln!(text, "  failed: {}: {}", check.name, check.detail)?;
    }
    let shown = out.display();
    writeln!(
        text,
        "\nwrote {shown}/diagnosis.json, simulation.csv and model.toml; open {shown}/report.html"
    )
}

/// The answer on one line, and how far the model is off on the next.
fn sentence(diagnosis: &Diagnosis) -> String {
    let windows: f64 = diagnosis
        .held_out_s
        .iter()
        .map(|(from, to)| to - from)
        .sum();
    let hours = brief(windows / 3600.0);
    let Some(first) = diagnosis.findings.first() else {
        let off: Vec<String> = ["riser_level_m", "return_flow_m3_s"]
            .iter()
            .filter_map(|name| {
                let signal = diagnosis
                    .simulation
                    .signals
                    .iter()
                    .find(|s| s.name == *name)?;
                let (rmse, _) = diagnosis.simulation.held_out_rmse(signal)?;
                Some(format!("{} {}", stem(name), quantity(name, rmse)))
            })
            .collect();
        let off = if off.is_empty() {
            String::new()
        } else {
            format!(
                "\nfree run over {hours} h held out: error {} (root mean square)",
                off.join(", ")
            )
        };
        let beyond = match diagnosis.started_from.join(", ") {
            none if none.is_empty() => none,
            held => format!(", beyond the effects of the starting model ({held})"),
        };
        if !diagnosis.suspected.is_empty() {
            let lead = diagnosis.verdict.name();
            let what = diagnosis.suspected.join(", ");
            return format!(
                "{lead}, no sign of what was suspected ({what}){beyond}{}{off}",
                unsuspected(diagnosis)
            );
        }
        if diagnosis.verdict == Verdict::Unexplained {
            return format!(
                "unexplained, the recording differs from the model by more than noise{beyond}, and no cause could be identified; see the failed check{off}"
            );
        }
        let failed = diagnosis.checks.iter().filter(|c| !c.passed).count();
        let but = match failed {
            0 => "",
            1 => "; but a check failed, see below",
            _ => "; but checks failed, see below",
        };
        return format!(
            "consistent, the model leaves out nothing that this recording could show{beyond}{but}{off}"
        );
    };
    let lead = match diagnosis.verdict {
        Verdict::Consistent => "consistent",
        Verdict::Explained => "explained",
        Verdict::PartlyExplained => "partly explained",
        Verdict::Unexplained => "unexplained",
    };
    let (likely, refuted): (Vec<_>, Vec<_>) =
        diagnosis.findings.iter().partition(|f| f.is_likely());
    let more = match likely.len().saturating_sub(1) {
        0 => String::new(),
        n => format!(", and {n} more"),
    };
    let told = first
        .held_out
        .as_ref()
        .filter(|_| diagnosis.acts_held_out());
    let gain = told.map_or(String::new(), |g| {
        format!(
            "\nfree run over {hours} h held out: {} error {} without, {} {}",
            stem(&g.signal),
            quantity(&g.signal, g.rmse_before),
            quantity(&g.signal, g.rmse_after),
            with(diagnosis)
        )
    });
    let titles: Vec<&str> = refuted.iter().map(|f| f.title.as_str()).collect();
    let suspected = match titles.join(", ") {
        none if none.is_empty() => none,
        titles => {
            let beside = unsuspected(diagnosis);
            format!("what was suspected is less likely than not: {titles}{beside}")
        }
    };
    let said: Vec<String> = (likely.first().map(|f| format!("{}{more}", f.title)))
        .into_iter()
        .chain(Some(suspected).filter(|s| !s.is_empty()))
        .collect();
    let short = match diagnosis.shortfalls().join(", and ") {
        none if none.is_empty() => none,
        short => format!(" ({short})"),
    };
    format!("{lead}{short}, {}{gain}", said.join("; "))
}

/// What stands out that was not suspected.
fn unsuspected(diagnosis: &Diagnosis) -> String {
    let each: Vec<String> = (diagnosis.unsuspected().iter())
        .map(|t| format!("{} (ln BF {:.0})", t.effect, t.evidence))
        .collect();
    match each.join(", ") {
        none if none.is_empty() => none,
        each => format!("; also standing out: {each}"),
    }
}

fn tell_finding(
    text: &mut String,
    number: usize,
    finding: &Finding,
    diagnosis: &Diagnosis,
) -> std::fmt::Result {
    writeln!(
        text,
        "{number}. {} ({}), probability {}",
        finding.title,
        finding.effect,
        probability(finding.probability)
    )?;
    let mut line = |name: &str, what: String| writeln!(text, "   {name:<9}{what}");
    let mut place = finding.relation.name().to_owned();
    if !finding.shows_in.is_empty() && !finding.shows_in.contains(&finding.relation) {
        let seen = finding.shows_in.iter().map(|r| r.name());
        place.push_str(&format!(
            " (seen in {})",
            seen.collect::<Vec<_>>().join(", ")
        ));
    }
    line(
        "where",
        format!("{place}, {}", intervals(&finding.intervals_s, diagnosis)),
    )?;
    if !finding.region.is_empty() {
        line("", finding.region.clone())?;
    }
    for (index, p) in finding.parameters.iter().enumerate() {
        line(
            if index == 0 { "size" } else { "" },
            format!("{}: {}", sized(&p.name, p.estimate, p.ci95), p.meaning),
        )?;
    }
    if let Some(told) = finding.curve.as_ref().and_then(curve) {
        line("size", told)?;
    }
    let others: Vec<String> = finding
        .alternatives
        .iter()
        .take(4)
        .map(|(effect, p)| format!("{effect} {}", probability(*p)))
        .collect();
    if !others.is_empty() {
        line("or", others.join(", "))?;
    }
    if let Some(test) = finding
        .separating_test
        .as_ref()
        .filter(|_| !others.is_empty())
    {
        line("test", test.clone())?;
    }
    if let Some(described) = &finding.same_as {
        line("same as", described.clone())?;
    }
    writeln!(text)
}

/// Between what a correction runs, and along what.
fn curve(curve: &CorrectionCurve) -> Option<String> {
    let (low, high) = curve.range()?;
    let ((from, _), (to, _)) = (curve.knots.first()?, curve.knots.last()?);
    let told = |name, low: f64, high: f64| {
        let legible = Legible::of(name);
        let Legible { factor, unit, .. } = legible;
        // An end that is nothing beside the other is nothing.
        let least = 2e-3 * low.abs().max(high.abs());
        let [low, high] = [low, high].map(|v| if v.abs() < least { 0.0 } else { v * factor });
        let ends = format!("{} to {} {unit}", brief(low), brief(high));
        (legible.words(), ends.trim_end().to_owned())
    };
    if let Some(level) = curve.level {
        let legible = Legible::of(curve.adds);
        let size = format!("{} {}", brief(level * legible.factor), legible.unit);
        let size = size.trim_end();
        return Some(format!(
            "{} {size} while it acts, else nothing",
            legible.words()
        ));
    }
    let (stem, adds) = told(curve.adds, low, high);
    let (along, range) = told(curve.along, *from, *to);
    Some(format!("{stem} {adds} along {along}, {range}"))
}

/// With what a run is the better.
fn with(diagnosis: &Diagnosis) -> &'static str {
    if diagnosis.findings.len() > 1 {
        "with them"
    } else {
        "with it"
    }
}

/// What the findings gain where no fit has looked.
fn gained(gain: &HeldOut, with: &str) -> String {
    // 0.0 is not -0.
    let percent = |share: f64| brief((1000.0 * share).round() / 10.0 + 0.0);
    let (low, high) = gain.improvement_ci95;
    let said = if !(low.is_finite() && high.is_finite()) {
        "too short for an interval".to_owned()
    } else if low > 0.0 {
        format!("{} to {} % less (95 %)", percent(low), percent(high))
    } else if high >= 0.0 {
        let (more, less) = (percent(-low), percent(high));
        format!("not significant: {more} % more to {less} % less (95 %)")
    } else {
        format!("{} to {} % more (95 %)", percent(-high), percent(-low))
    };
    format!(
        "{} error {} without, {} {with}: {said}",
        stem(&gain.signal),
        quantity(&gain.signal, gain.rmse_before),
        quantity(&gain.signal, gain.rmse_after),
    )
}

/// On the recording's clock, with dates where it has them.
fn intervals(intervals_s: &[(f64, f64)], diagnosis: &Diagnosis) -> String {
    const SHOWN: usize = 3;
    let span_s = diagnosis.setting.span_s;
    if let [(from, to)] = intervals_s
        && *from <= span_s.0
        && *to >= span_s.1
    {
        return "the whole recording".into();
    }
    let mut told: Vec<String> = intervals_s
        .iter()
        .take(SHOWN)
        .map(|&(from, to)| {
            let dates = diagnosis.began.and_then(|began| began.stretch((from, to)));
            let dates = dates.map_or_else(String::new, |dates| format!(" ({dates})"));
            format!("{from:.0} to {to:.0} s{dates}")
        })
        .collect();
    if intervals_s.len() > SHOWN {
        told.push(format!("and {} more", intervals_s.len() - SHOWN));
    }
    if told.is_empty() {
        return "at no specific time".into();
    }
    told.join(", ")
}

/// What was looked for: in full where nothing was found, for then that is the answer.
fn tell_tested(text: &mut String, diagnosis: &Diagnosis) -> std::fmt::Result {
    let of =
        |wanted: fn(&Outcome) -> bool| diagnosis.tested.iter().filter(move |t| wanted(&t.outcome));
    if !diagnosis.suspected.is_empty() {
        return tell_suspected(text, diagnosis);
    }
    let found = of(|o| matches!(o, Outcome::Found)).count();
    let unseen = || of(|o| matches!(o, Outcome::NotSeen));
    let blind: Vec<&Tested> = of(|o| matches!(o, Outcome::NotTestable(_))).collect();
    if diagnosis.tested.is_empty() {
        return Ok(());
    }
    if diagnosis.findings.is_empty() {
        let mut table = TextTable::new(["looked for, not seen", "smallest visible", "", ""]);
        for one in unseen() {
            let strength = Legible::of(one.strength);
            let limit = one.limit.filter(|l| l.is_finite());
            let [size, unit, name] = limit.map_or([const { String::new() }; 3], |l| {
                let side = if one.is_departure() { "±" } else { "" };
                [
                    format!("{side}{}", brief(l * strength.factor)),
                    strength.unit.to_owned(),
                    strength.words(),
                ]
            });
            table.row([one.effect.to_owned(), size, unit, name]);
        }
        writeln!(text, "{}", table.render())?;
    }
    let all = count(diagnosis.tested.len());
    let resembled = match of(|o| matches!(o, Outcome::Resembled)).count() {
        0 => String::new(),
        n => format!("{n} resembled by a cause outside the catalogue, "),
    };
    let not_needed = match diagnosis.findings.len() {
        0 => 0,
        _ => unseen().filter(|t| t.exceeded_its_hurdle()).count(),
    };
    let beside = match not_needed {
        0 => String::new(),
        n => format!("{n} not needed in addition, "),
    };
    writeln!(
        text,
        "tested {all} effects: {found} found, {resembled}{beside}{} not seen, {} not testable on this recording",
        unseen().count() - not_needed,
        blind.len()
    )?;
    blind.into_iter().try_for_each(|one| tell_blind(text, one))
}

fn tell_blind(text: &mut String, one: &Tested) -> std::fmt::Result {
    match &one.outcome {
        Outcome::NotTestable(reason) => {
            writeln!(text, "  not testable: {}: {reason}", one.effect)
        }
        _ => Ok(()),
    }
}

/// How what was suspected fared: nothing else was fitted.
fn tell_suspected(text: &mut String, diagnosis: &Diagnosis) -> std::fmt::Result {
    let suspected = |id: &str| diagnosis.suspected.iter().any(|s| s == id);
    // Swell is told apart, whatever was suspected.
    let of_them = diagnosis.findings.iter();
    let of_them = of_them.filter(|f| suspected(f.resembles.unwrap_or(&f.effect)));
    let (likely, unlikely): (Vec<_>, Vec<_>) = of_them.partition(|f| f.is_likely());
    writeln!(
        text,
        "looked for {}: {} found, {} less likely than not; omit --suspect to look for all effects",
        diagnosis.suspected.join(" and "),
        likely.len(),
        unlikely.len(),
    )?;
    let mut of_them = diagnosis.tested.iter().filter(|t| suspected(t.effect));
    of_them.try_for_each(|one| tell_blind(text, one))
}

/// A signal's name without its unit.
fn stem(signal: &str) -> String {
    Legible::of(signal).words()
}

/// A size of a signal in a unit that people read.
fn quantity(signal: &str, value: f64) -> String {
    let Legible { factor, unit, .. } = Legible::of(signal);
    format!("{} {unit}", brief(value * factor))
}

/// A parameter by its name without its unit, its estimate and interval, and the unit that people read.
fn sized(name: &str, value: f64, (low, high): (f64, f64)) -> String {
    if name == "sensor" {
        return format!("{name} {value:.0}");
    }
    let legible = Legible::of(name);
    let Legible { factor, unit, .. } = legible;
    let size = estimate(value * factor, (low * factor, high * factor));
    let told = format!("{} {size} {unit}", legible.words());
    told.trim_end().to_owned()
}

/// An estimate with its interval, to the digits that the interval leaves.
fn estimate(value: f64, (low, high): (f64, f64)) -> String {
    let width = high - low;
    // One of a few values has no interval.
    if !width.is_finite() || width == 0.0 {
        return brief(value);
    }
    let largest = low.abs().max(high.abs());
    if !(width > 0.0 && (1e-3..1e6).contains(&largest)) {
        return format!("{} [{}, {}]", brief(value), brief(low), brief(high));
    }
    // Two figures of the width.
    let decimals = (1.0 - width.log10().floor()).clamp(0.0, 9.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 9"
    )]
    let decimals = decimals as usize;
    format!("{value:.decimals$} [{low:.decimals$}, {high:.decimals$}]")
}

/// A probability in percent would hide the last step to certainty: two figures, and three near the ends.
fn probability(p: f64) -> String {
    if (0.1..=0.99).contains(&p) {
        format!("{p:.2}")
    } else {
        format!("{p:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::{estimate, sized};

    #[test]
    fn a_parameter_is_told_in_the_unit_that_people_read() {
        let told = |name, value: f64| sized(name, value, (0.9 * value, 1.1 * value));
        assert_eq!(told("rate_m3_s", 2e-3), "rate 120 [108, 132] L/min");
        assert_eq!(told("bias_pa", 5e4), "bias 0.50 [0.45, 0.55] bar");
        assert_eq!(told("tau_gel_pa", 5.0), "tau gel 5.0 [4.5, 5.5] Pa");
        assert_eq!(told("gain", 1.0), "gain 1.00 [0.90, 1.10]");
        assert_eq!(
            told("relative_mu_change", 0.5),
            "relative mu change 50 [45, 55] %"
        );
    }

    #[test]
    fn an_estimate_has_the_digits_that_its_interval_leaves() {
        assert_eq!(
            estimate(1.04123, (1.0386, 1.0439)),
            "1.0412 [1.0386, 1.0439]"
        );
        assert_eq!(estimate(9714.83, (9650.2, 9779.5)), "9715 [9650, 9780]");
        assert_eq!(
            estimate(2.5e-8, (2e-8, 3e-8)),
            "2.500e-8 [2.000e-8, 3.000e-8]"
        );
        assert_eq!(estimate(3.0, (f64::NAN, 4.0)), "3");
        assert_eq!(estimate(3.0, (3.0, 3.0)), "3");
    }
}
