//! The answer: one sentence with numbers, then each finding on a card with the rung it reaches.

use dgd_diagnose::{Diagnosis, Finding, Outcome, Verdict};

use super::html::Html;
use super::letter;
use super::quantity::{percent, percent_change, split};
use super::words::{
    self, RUNGS, Rung, capital, estimated, improvement, listed, strength, title, title_of,
};

/// The sentence, and whether to believe it.
pub(super) fn headline(diagnosis: &Diagnosis) -> String {
    let sentence = sentence(diagnosis);
    if diagnosis.warnings.is_empty() {
        return sentence;
    }
    format!("{sentence} First check the warnings about the recording and its description.")
}

/// The whole diagnosis in a sentence.
fn sentence(diagnosis: &Diagnosis) -> String {
    let of = |likely: bool| {
        let all = diagnosis.findings.iter().enumerate();
        all.filter(move |(_, f)| f.is_likely() == likely)
    };
    let left_out: Vec<(usize, &Finding)> = of(true).collect();
    let refuted = match refuted(of(false).map(|(_, f)| f)) {
        none if none.is_empty() && left_out.is_empty() && !diagnosis.suspected.is_empty() => {
            "The recording shows no sign of what was suspected".to_owned()
        }
        refuted => refuted,
    };
    match left_out.as_slice() {
        [] if !refuted.is_empty() => format!("{refuted}; {}.", words::beside_suspects(diagnosis)),
        [] if diagnosis.verdict == Verdict::Consistent => nothing(diagnosis),
        [] => "Model and recording differ by more than noise and instrument accuracy explain, but no cause could be identified.".to_owned(),
        found => {
            let said = match found {
                [(_, only)] => format!("{}.", clause(only, diagnosis)),
                many => several(many, diagnosis),
            };
            let and = match refuted.as_str() {
                "" => String::new(),
                refuted => format!(" {refuted}."),
            };
            format!("{said}{}{and}", unnamed(diagnosis))
        }
    }
}

/// More than one thing that was left out, by the letters of their cards.
fn several(found: &[(usize, &Finding)], diagnosis: &Diagnosis) -> String {
    let number = match found.len() {
        2 => "Two things".to_owned(),
        3 => "Three things".to_owned(),
        4 => "Four things".to_owned(),
        n => format!("{n} things"),
    };
    let each: Vec<String> = found
        .iter()
        .map(|(i, f)| format!("{}, {}", letter(*i), brief(f, diagnosis)))
        .collect();
    let best = found
        .iter()
        .filter_map(|(_, f)| {
            let h = f.held_out.as_ref()?;
            Some((improvement(h.rmse_before, h.rmse_after)?, f))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .and_then(|(_, f)| words::gain(f, diagnosis, true))
        .map_or_else(String::new, |gain| format!(" {}.", capital(&gain)));
    format!("{number} are left out: {}.{best}", each.join("; "))
}

/// What was suspected and is likelier not there; nothing of nothing.
fn refuted<'a>(suspected: impl Iterator<Item = &'a Finding>) -> String {
    let each: Vec<String> = suspected
        .map(|f| format!("{} ({})", title(f), percent(f.probability)))
        .collect();
    if each.is_empty() {
        return String::new();
    }
    format!(
        "What was suspected is less likely than not: {}",
        listed(&each, "and")
    )
}

/// The consistent verdict with its numbers.
fn nothing(diagnosis: &Diagnosis) -> String {
    let all = diagnosis.tested.len();
    let untestable = diagnosis
        .tested
        .iter()
        .filter(|t| matches!(t.outcome, Outcome::NotTestable(_)))
        .count();
    let numbers = match (all - untestable, untestable) {
        (0, _) => String::new(),
        (seen, 0) => format!(": {seen} effects were looked for, none was seen"),
        (seen, not) => format!(
            ": {seen} effects were looked for, none was seen, and {not} could not be tested on it"
        ),
    };
    match words::held(diagnosis) {
        None => format!("The model leaves out nothing that this recording could show{numbers}."),
        Some(held) => format!(
            "Beyond the starting model, in which {held}, nothing is left out that this recording could show{numbers}."
        ),
    }
}

/// What a partial verdict adds where no finding says it.
fn unnamed(diagnosis: &Diagnosis) -> String {
    match diagnosis.shortfalls().join(", and ") {
        none if none.is_empty() => none,
        short => format!(" It does not explain everything: {short}."),
    }
}

/// What, how strong, where and when.
fn brief(finding: &Finding, diagnosis: &Diagnosis) -> String {
    let when = words::when(finding, diagnosis);
    match Rung::of(finding) {
        Rung::Located if finding.resembles.is_some() => format!("{}, {when}", title(finding)),
        Rung::Located => {
            format!(
                "{}, {when}, in a way that is in neither the model nor the catalogue",
                located(finding)
            )
        }
        Rung::Class => format!("{when}: {}", class(finding)),
        Rung::Cause => format!("{}, {when}", title(finding)),
        Rung::Measured => match strength(finding) {
            Some(p) => format!(
                "{}: {} {}, {when}",
                title(finding),
                name_of(p),
                estimated(p)
            ),
            None => title(finding),
        },
    }
}

fn clause(finding: &Finding, diagnosis: &Diagnosis) -> String {
    let place = words::relation(finding.relation);
    let when = words::when(finding, diagnosis);
    let gain =
        words::gain(finding, diagnosis, false).map_or_else(String::new, |gain| format!("; {gain}"));
    match Rung::of(finding) {
        Rung::Located if finding.resembles.is_some() => format!(
            "Seen in the {place}, {when}: {}; none of the {} effects of the catalogue has its form, and the model contains the effect that it \
             resembles{gain}",
            title(finding),
            dgd_effects::catalogue().len()
        ),
        Rung::Located => format!(
            "{}, {when}, in a way described neither by the model nor by any of the {} effects of the catalogue; it is modelled by an empirical \
             correction{gain}",
            capital(&located(finding)),
            dgd_effects::catalogue().len()
        ),
        Rung::Class => format!("Seen in the {place}, {when}: {}{gain}", class(finding)),
        Rung::Cause => format!("Seen in the {place}, {when}: {}{gain}", title(finding)),
        Rung::Measured => {
            let strong = strength(finding).map_or_else(String::new, |p| {
                format!("; {} {}", name_of(p), estimated(p))
            });
            format!(
                "Seen in the {place}, {when}: {}{strong}{gain}",
                title(finding)
            )
        }
    }
}

/// What depends on what, without the words that it is in no catalogue.
fn located(finding: &Finding) -> String {
    let title = title(finding);
    (title.split_once(": ")).map_or_else(|| title.clone(), |(_, what)| what.to_owned())
}

fn name_of(p: &dgd_diagnose::ParameterEstimate) -> String {
    if p.meaning.trim().is_empty() {
        split(&p.name).0
    } else {
        p.meaning.clone()
    }
}

/// The causes that cannot be told apart, with their probabilities.
fn class(finding: &Finding) -> String {
    let mut causes = vec![format!(
        "{} ({})",
        title(finding),
        percent(finding.probability)
    )];
    causes.extend(
        finding
            .serious()
            .map(|(id, probability)| format!("{} ({})", title_of(id), percent(*probability))),
    );
    if causes.len() == 1 {
        format!("probably {}", causes[0])
    } else {
        format!(
            "either {}; this recording cannot tell which",
            listed(&causes, "or")
        )
    }
}

pub(super) fn write(diagnosis: &Diagnosis, html: &mut Html) {
    let (class, word) = match diagnosis.verdict {
        Verdict::Consistent => ("good", "Consistent"),
        Verdict::Explained => ("found", "Explained"),
        Verdict::PartlyExplained => ("part", "Partly explained"),
        Verdict::Unexplained => ("open", "Unexplained"),
    };
    let unsure = |f: &&Finding| Rung::of(f) == Rung::Class;
    let likely = || diagnosis.findings.iter().filter(|f| f.is_likely());
    let only_suspected = likely().next().is_none() && !diagnosis.suspected.is_empty();
    let says = match likely().find(unsure) {
        _ if only_suspected => "what was suspected is less likely than not",
        Some(finding) if diagnosis.verdict == Verdict::Explained => {
            if finding.serious().next().is_some() {
                "the location is known; the cause is one of a few"
            } else {
                "the location is known; the cause is likely, but not certain"
            }
        }
        _ => meaning(diagnosis),
    };
    html.open("p", "verdict")
        .element("span", &format!("mark {class}"), word)
        .element("span", "says", says)
        .close("p");
    if diagnosis.findings.is_empty() {
        consistent(diagnosis, html);
    }
    for (index, finding) in diagnosis.findings.iter().enumerate() {
        card(diagnosis, index, finding, html);
    }
    let failed = diagnosis.checks.iter().filter(|c| !c.passed).count();
    match failed {
        0 => {}
        1 => {
            html.note("One check on this answer failed; it is listed in the last section.");
        }
        n => {
            html.note(&format!(
                "{n} checks on this answer failed; they are listed in the last section."
            ));
        }
    }
}

fn meaning(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.verdict {
        Verdict::Consistent => {
            "the mismatch is within the limits for noise and instrument accuracy"
        }
        Verdict::Explained => "what was left out is named",
        Verdict::PartlyExplained => "what is named does not explain everything",
        Verdict::Unexplained if diagnosis.findings.is_empty() => {
            "more than noise is left, and no cause could be identified"
        }
        Verdict::Unexplained => "something is left out that is not in the catalogue",
    }
}

fn consistent(diagnosis: &Diagnosis, html: &mut Html) {
    let suspected = &diagnosis.suspected;
    let asked = |id: &str| suspected.is_empty() || suspected.iter().any(|s| s == id);
    let count = |wanted: fn(&Outcome) -> bool| {
        diagnosis
            .tested
            .iter()
            .filter(|t| asked(t.effect) && wanted(&t.outcome))
            .count()
            .to_string()
    };
    html.open("dl", "facts")
        .fact(
            "Effects looked for",
            &count(|o| !matches!(o, Outcome::NotTestable(_))),
            "each with the smallest size that would have been seen",
        )
        .fact(
            "Not testable here",
            &count(|o| matches!(o, Outcome::NotTestable(_))),
            "not excited by this recording, or too weak in it at any plausible size",
        )
        .fact(
            "Held out from every fit",
            &held_out_share(diagnosis),
            &format!("{} windows", diagnosis.held_out_s.len()),
        )
        .close("dl");
}

/// Share of the recording that no fit has seen.
fn held_out_share(diagnosis: &Diagnosis) -> String {
    let (from, to) = words::span(diagnosis);
    let held: f64 = diagnosis.held_out_s.iter().map(|(a, b)| b - a).sum();
    percent(held / (to - from))
}

fn card(diagnosis: &Diagnosis, index: usize, finding: &Finding, html: &mut Html) {
    let rung = Rung::of(finding);
    html.open("div", "card")
        .element(
            "h3",
            "",
            &format!("{}. {}", letter(index), capital(&title(finding))),
        )
        .element("code", "name", &finding.effect);
    html.open("ol", "ladder");
    for (step, word) in RUNGS {
        // An empirical correction reaches the first rung only; the others stay open.
        let class = if step < rung {
            "below"
        } else if step == rung {
            "here"
        } else {
            "ahead"
        };
        html.element("li", class, word);
    }
    html.close("ol").open("dl", "facts");
    let among: Vec<String> = finding.serious().map(|(id, _)| id.clone()).collect();
    let more = match (among.len(), finding.is_unknown()) {
        (0, true) => "that it is outside the catalogue".to_owned(),
        (0, false) => words::other_or_nothing(finding),
        (1, _) => "one alternative".to_owned(),
        (n, _) => format!("{n} alternatives"),
    };
    html.fact("Probability", &percent(finding.probability), &more);
    if let Some(p) = strength(finding) {
        let (_, unit) = split(&p.name);
        let interval = unit
            .interval(p.estimate, p.ci95)
            .map_or_else(|| "no interval".to_owned(), |i| format!("95\u{a0}%: {i}"));
        html.fact(
            &capital(&name_of(p)),
            &unit.estimate(p.estimate, p.ci95),
            &interval,
        );
    }
    html.fact(
        "Where",
        &capital(words::relation(finding.relation)),
        &words::when(finding, diagnosis),
    );
    match finding
        .held_out
        .as_ref()
        .filter(|_| diagnosis.acts_held_out())
    {
        Some(held) => {
            let share = improvement(held.rmse_before, held.rmse_after);
            let value = share.map_or_else(|| "–".to_owned(), |s| percent_change(-s));
            let whose = if diagnosis.findings.len() > 1 {
                "Held-out error, all findings"
            } else {
                "Held-out error"
            };
            html.fact(
                &format!("{whose}, {}", words::signal(&held.signal)),
                &value,
                &words::less(held.improvement_ci95),
            )
        }
        None => html.fact("Held-out error", "–", "no window to confirm on"),
    };
    html.close("dl").close("div");
}
