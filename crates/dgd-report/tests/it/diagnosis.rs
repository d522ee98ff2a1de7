use std::collections::HashSet;

use dgd_diagnose::{Diagnosis, Finding, Outcome, Signal, Trace, Verdict};
use dgd_effects::find;
use dgd_report::diagnosis_page;

use crate::diagnoses;
use crate::svg::assert_sound;

const SECTIONS: [&str; 6] = [
    "The answer",
    "Where",
    "What",
    "The equation, before and after",
    "The fit, before and after",
    "Checks, limits and settings",
];

fn page(diagnosis: &Diagnosis) -> String {
    diagnosis_page(
        diagnosis,
        "rig.mat",
        "dgd diagnose rig.mat --well well.toml",
    )
}

fn parse(html: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(html, options).unwrap()
}

/// All text of the page, spaces that do not break as plain ones.
fn words(html: &str) -> String {
    let document = parse(html);
    let texts: Vec<&str> = document
        .descendants()
        .filter(|n| n.is_text() && !n.parent().unwrap().has_tag_name("style"))
        .filter_map(|n| n.text())
        .collect();
    texts.join(" ").replace('\u{a0}', " ")
}

/// Every picture drawn within its paper, with words that stand in for it; how many there are.
fn assert_pictures(name: &str, html: &str) -> usize {
    let pictures: Vec<&str> = html
        .split("<svg ")
        .skip(1)
        .map(|rest| &rest[..rest.find("</svg>").unwrap()])
        .collect();
    for picture in &pictures {
        let svg = format!("<svg {picture}</svg>");
        assert_sound(name, &svg);
        let document = roxmltree::Document::parse(&svg).unwrap();
        for tag in ["title", "desc"] {
            let words = document
                .descendants()
                .find(|n| n.tag_name().name() == tag)
                .and_then(|n| n.text());
            assert!(words.is_some_and(|w| !w.is_empty()), "{name}");
        }
    }
    pictures.len()
}

#[test]
fn what_makes_an_answer_doubtful_is_told_in_the_headline_and_before_the_answer() {
    for (name, mut diagnosis) in diagnoses::all(2) {
        assert!(
            !page(&diagnosis).contains("First check the warnings"),
            "{name}"
        );
        diagnosis.warnings = vec!["is FT1 in psi?".to_owned()];
        let html = page(&diagnosis);
        let at = |text: &str| html.find(text).unwrap();
        assert!(
            at("First check the warnings") < at("is FT1 in psi?"),
            "{name}"
        );
        assert!(at("is FT1 in psi?") < at(">The answer</h2>"), "{name}");
    }
}

#[test]
fn the_timeline_says_what_noise_leaves_and_what_instruments_may_wander_by() {
    for (name, mut diagnosis) in diagnoses::all(2) {
        for trace in &mut diagnosis.traces {
            (trace.noise, trace.wander) = match trace.unit {
                "Pa" => (3e3, 4e3),
                _ => (3e-4, 4e-4),
            };
        }
        let told = words(&page(&diagnosis));
        for said in [
            "Noise of a block, ±2 σ",
            "Noise and instrument wander, ±2 σ",
            "noise 0.030, with wander 0.050",
            "noise 18, with wander 30",
        ] {
            assert!(told.contains(said), "{name}: {said}");
        }
    }
}

#[test]
fn every_verdict_has_every_section_and_both_pictures() {
    for (name, diagnosis) in diagnoses::all(2) {
        let html = page(&diagnosis);
        let document = parse(&html);
        let headings: Vec<&str> = document
            .descendants()
            .filter(|n| n.has_tag_name(("http://www.w3.org/1999/xhtml", "h2")))
            .filter_map(|n| n.text())
            .collect();
        assert_eq!(headings, SECTIONS, "{name}");
        let curves = diagnosis.findings.iter().filter(|f| f.curve.is_some());
        assert_eq!(assert_pictures(name, &html), 2 + curves.count(), "{name}");
        assert!(words(&html).contains("dgd diagnose rig.mat --well well.toml"));
    }
}

#[test]
fn what_the_model_to_start_from_holds_is_told_with_its_equation() {
    for (name, mut diagnosis) in diagnoses::all(2) {
        let without = page(&diagnosis);
        assert!(!words(&without).contains("starting model"), "{name}");
        diagnosis.started_from = vec!["lost_circulation"];
        let html = page(&diagnosis);
        let told = words(&html);
        let title = "mud is lost to the formation, driven by pressure";
        assert!(
            told.contains(&format!("In the starting model, {title}.")),
            "{name}"
        );
        let equation = find("lost_circulation").unwrap().about().equation;
        let alternative = format!("alttext=\"{equation}\"");
        let count = |html: &str| html.matches(&alternative).count();
        assert_eq!(count(&html), count(&without) + 1, "{name}");
        if diagnosis.findings.is_empty() {
            assert!(told.contains(&format!("Beyond the starting model, in which {title}")));
        }
    }
}

/// Of such a cause no correction tells more: the model holds the effect, and the page does not say otherwise.
#[test]
fn what_only_resembles_an_effect_is_told_with_what_the_model_holds() {
    let (name, mut diagnosis) = (diagnoses::all(2).into_iter())
        .find(|(_, d)| d.verdict == Verdict::Unexplained)
        .unwrap();
    let gel = find("gel_strength").unwrap().about();
    for finding in &mut diagnosis.findings {
        finding.resembles = Some(gel.id);
        finding.title = format!(
            "something outside the catalogue, which looks as if {}",
            gel.title
        );
        finding.curve = None;
    }
    let tested = (diagnosis.tested.iter_mut()).find(|t| t.effect == gel.id);
    tested.unwrap().outcome = Outcome::Resembled;
    let told = words(&page(&diagnosis));
    let title = &diagnosis.findings[0].title;
    assert!(told.contains(&format!("{title}; none of the")), "{name}");
    assert!(told.contains("the model contains the effect that it resembles"));
    assert!(told.contains("resembled") && told.contains("only an approximation"));
    assert!(!told.contains("empirical correction"), "{told}");
}

#[test]
fn the_wording_climbs_with_what_is_known() {
    let says = |diagnosis: &Diagnosis| {
        let html = page(diagnosis);
        let document = parse(&html);
        let lead = document
            .descendants()
            .find(|n| n.attribute("class") == Some("lead"))
            .and_then(|n| n.text())
            .unwrap();
        lead.replace('\u{a0}', " ")
    };
    assert!(says(&diagnoses::consistent(2)).starts_with(
        "The model leaves out nothing that this recording could show: 21 effects were looked for"
    ));
    assert!(says(&diagnoses::unknown(2)).contains("any of the 24 effects of the catalogue"));
    let class = says(&diagnoses::class(2));
    assert!(
        class.contains("either the return line loses mud before its meter (52 %)")
            && class.contains("this recording cannot tell which"),
        "{class}"
    );
    let mut finding = diagnoses::single(2);
    assert!(says(&finding).contains(
        "formation fluid enters the well; plateau of the influx 126 L/min (95 % interval 114 to 138 L/min)"
    ));
    assert!(
        says(&finding)
            .contains("including it cuts the riser level error by 94 % (95 % interval 90 to 95 %)")
    );
    // Without an interval there is a cause, and no number.
    finding.findings[0].parameters[0].ci95 = (f64::NAN, f64::NAN);
    let cause = says(&finding);
    assert!(cause.contains("formation fluid enters the well") && !cause.contains("L/min"));
    let two = says(&diagnoses::two(2));
    assert!(two.starts_with("Two things are left out: A, the return flow is measured late"));
    assert!(two.ends_with(
        "It does not explain everything: an output runs worse with it on the held-out windows."
    ));
    // What was only suspected need not be there.
    let mut suspected = diagnoses::two(2);
    for finding in &mut suspected.findings[1..] {
        finding.probability = 0.08;
        finding.alternatives.clear();
    }
    suspected.suspected = vec!["return_flow_delay".to_owned(), "influx".to_owned()];
    let told = words(&page(&suspected));
    assert!(told.contains("Only what was suspected was fitted (return_flow_delay, influx)"));
    let one = says(&suspected);
    assert!(
        one.starts_with("Seen in the friction of the return line"),
        "{one}"
    );
    assert!(
        one.contains("What was suspected is less likely than not: "),
        "{one}"
    );
    assert!(!one.contains("probably"), "{one}");
}

#[test]
fn suspects_that_explain_nothing_are_not_told_as_a_sound_recording() {
    let plain = |diagnosis: &Diagnosis| -> String {
        let told = words(&page(diagnosis));
        told.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let mut of_one = diagnoses::consistent(2);
    of_one.suspected = vec!["return_flow_gain".to_owned()];
    let told = plain(&of_one);
    for wanted in [
        "The recording shows no sign of what was suspected; nothing else was fitted except swell.",
        "No relation exceeds the limit",
        "Effects looked for 1 ",
    ] {
        assert!(told.contains(wanted), "{wanted}: {told}");
    }
    let kick = of_one.tested.iter_mut().find(|t| t.effect == "influx");
    kick.unwrap().evidence = 328.0;
    of_one.verdict = Verdict::Unexplained;
    let told = plain(&of_one);
    for wanted in [
        "nothing else was fitted, but this also stands out: formation fluid enters the well (ln BF 328, needed 3).",
        "What was suspected shows in no relation, but something else may",
        "Unexplained what was suspected is less likely than not",
    ] {
        assert!(told.contains(wanted), "{wanted}: {told}");
    }
    assert!(!told.contains("No relation exceeds the limit"));
}

#[test]
fn a_class_names_its_rivals_and_the_test_that_separates_them() {
    let text = words(&page(&diagnoses::class(2)));
    for wanted in [
        "Cannot be separated on this recording:",
        "“mud is lost to the formation, driven by pressure”",
        "A test that would separate it from one of them:",
        "check head and line friction: a leak changes both",
    ] {
        assert!(text.contains(wanted), "{wanted}");
    }
    let mut diagnosis = diagnoses::class(2);
    diagnosis.findings[0].alternatives.truncate(1);
    assert!(words(&page(&diagnosis)).contains("A test that would separate them:"));
    // None is promised where none is known.
    diagnosis.findings[0].separating_test = None;
    assert!(!words(&page(&diagnosis)).contains("A test that would"));
    assert!(!words(&page(&diagnoses::single(2))).contains("Cannot be separated"));
}

#[test]
fn a_likely_cause_without_rivals_is_no_class_and_no_certainty() {
    let mut diagnosis = diagnoses::single(2);
    diagnosis.findings[0].probability = 0.54;
    diagnosis.findings[0].alternatives.clear();
    let text = words(&page(&diagnosis));
    for said in [
        "the cause is likely, but not certain",
        "46 % for something else, or nothing",
    ] {
        assert!(text.contains(said), "{said} is not in {text}");
    }
    for unsaid in ["one of a few", "Separated:", "would separate them"] {
        assert!(!text.contains(unsaid), "{unsaid}");
    }
}

#[test]
fn what_others_take_is_not_needed_beside_the_finding_and_checks_speak_words() {
    let mut diagnosis = diagnoses::single(2);
    let other = (diagnosis.tested.iter_mut())
        .find(|t| t.outcome == Outcome::NotSeen)
        .unwrap();
    (other.evidence, other.hurdle) = (900.0, 10.0);
    diagnosis.settings.push(("blank".to_owned(), String::new()));
    let text = words(&page(&diagnosis));
    assert!(text.contains("not needed"), "{text}");
    assert!(text.contains("Formation fluid enters the well: explains less at any other onset"));
    assert!(!text.contains("Blank"));
}

#[test]
fn the_letters_of_an_equation_are_explained() {
    let text = words(&page(&diagnoses::single(2)));
    assert!(
        text.contains("Symbols:") && text.contains("flow into the riser"),
        "{text}"
    );
}

#[test]
fn failed_checks_and_untestable_effects_are_said() {
    let text = words(&page(&diagnoses::unknown(2)));
    assert!(text.contains("One check on this answer failed"));
    assert!(text.contains("1 passed, 1 failed."));
    assert!(text.contains("Needs sampling faster than half the period"));
    assert!(text.contains("The model file contains what is called unknown"));
}

#[test]
fn errors_are_taken_over_trusted_held_out_samples() {
    let mut diagnosis = diagnoses::single(2);
    let simulation = &mut diagnosis.simulation;
    simulation.t_s = vec![0.0, 1.0, 2.0, 3.0, 4.0];
    simulation.held_out = vec![true, true, true, false, true];
    simulation.valid = vec![true, true, false, true, true];
    simulation.signals = vec![Signal {
        name: "riser_level_m",
        measured: vec![0.0, 0.0, 0.0, 0.0, f64::NAN],
        before: vec![3.0, 5.0, 900.0, 900.0, 900.0],
        after: vec![0.5, -0.5, 900.0, 900.0, 900.0],
    }];
    diagnosis.held_out_s = vec![(0.0, 2.0), (4.0, 5.0)];
    let text = words(&page(&diagnosis));
    // The root of (9 + 25) / 2 is 4.12.
    assert!(text.contains("RMSE 4.12 before, 0.500 after"), "{text}");
    assert!(text.contains("1 better, 0 worse"));
}

#[test]
fn equations_are_mathml_or_readable_code() {
    let mut diagnosis = diagnoses::single(2);
    diagnosis.findings[0].equation_after = "A dh/dt = § <b>".to_owned();
    let html = page(&diagnosis);
    let document = parse(&html);
    let formulas = document.descendants().filter(|n| {
        let class = n.parent().and_then(|p| p.attribute("class"));
        n.tag_name().name() == "math" && class.is_some_and(|c| c.starts_with("equation"))
    });
    assert_eq!(formulas.count(), 1);
    assert!(html.contains("<code>A dh/dt = § &lt;b&gt;</code>"));
}

const HOSTILE: &str = "</style><script>alert('1')</script>\"]]>&<b onclick=\"x\">\u{0}";

fn poison(finding: &mut Finding) {
    for text in [
        &mut finding.title,
        &mut finding.region,
        &mut finding.source,
        &mut finding.equation_before,
        &mut finding.equation_after,
    ] {
        *text = HOSTILE.to_owned();
    }
    finding.alternatives = vec![(HOSTILE.to_owned(), 0.3)];
    finding.separating_test = Some(HOSTILE.to_owned());
    finding.same_as = Some(HOSTILE.to_owned());
    if let Some(parameter) = finding.parameters.first_mut() {
        parameter.name = HOSTILE.to_owned();
        parameter.meaning = HOSTILE.to_owned();
    }
    if let Some(curve) = &mut finding.curve {
        (curve.along, curve.adds) = (HOSTILE, HOSTILE);
    }
    finding.held_out.as_mut().unwrap().signal = HOSTILE.to_owned();
}

#[test]
fn hostile_names_are_escaped() {
    for (name, mut diagnosis) in diagnoses::all(2) {
        diagnosis.findings.iter_mut().for_each(poison);
        for check in &mut diagnosis.checks {
            check.name = HOSTILE.to_owned();
            check.detail = HOSTILE.to_owned();
        }
        for tested in &mut diagnosis.tested {
            if matches!(tested.outcome, Outcome::NotTestable(_)) {
                tested.outcome = Outcome::NotTestable(HOSTILE.to_owned());
            }
        }
        diagnosis.settings = vec![(HOSTILE.to_owned(), HOSTILE.to_owned())];
        diagnosis.warnings = vec![HOSTILE.to_owned()];
        let html = diagnosis_page(&diagnosis, HOSTILE, HOSTILE);
        let document = parse(&html);
        for node in document.descendants().filter(roxmltree::Node::is_element) {
            assert!(
                !matches!(
                    node.tag_name().name(),
                    "script" | "link" | "img" | "iframe" | "form"
                ),
                "{name}"
            );
            for attribute in node.attributes() {
                assert!(
                    !attribute.name().starts_with("on") && attribute.name() != "src",
                    "{name}"
                );
                assert!(attribute.name() != "href" || attribute.value().starts_with("#s"));
            }
        }
        assert_eq!(html.matches("<style>").count(), 1);
        assert!(
            !html.contains("<script") && !html.contains("<b onclick"),
            "{name}"
        );
    }
}

fn spoil(diagnosis: &mut Diagnosis, bad: f64) {
    for finding in &mut diagnosis.findings {
        finding.probability = bad;
        finding.evidence = bad;
        finding.intervals_s = vec![(bad, bad), (0.0, bad), (bad, 1.0)];
        finding.alternatives.iter_mut().for_each(|a| a.1 = bad);
        for p in &mut finding.parameters {
            p.estimate = bad;
            p.ci95 = (bad, bad);
        }
        if let Some(curve) = &mut finding.curve {
            for (k, knot) in curve.knots.iter_mut().enumerate() {
                *knot = if k % 2 == 0 {
                    (bad, 1.0)
                } else {
                    (knot.0, bad)
                };
            }
        }
        if let Some(held) = &mut finding.held_out {
            held.rmse_before = bad;
            held.rmse_after = bad;
            held.improvement_ci95 = (bad, bad);
        }
    }
    for tested in &mut diagnosis.tested {
        tested.evidence = bad;
        tested.limit = Some(bad);
    }
    let all = |values: &mut Vec<f64>| values.iter_mut().for_each(|v| *v = bad);
    for Trace {
        t_s,
        before,
        after,
        noise,
        wander,
        ..
    } in &mut diagnosis.traces
    {
        [t_s, before, after].into_iter().for_each(all);
        (*noise, *wander) = (bad, bad);
    }
    all(&mut diagnosis.simulation.t_s);
    for signal in &mut diagnosis.simulation.signals {
        [&mut signal.measured, &mut signal.before, &mut signal.after]
            .into_iter()
            .for_each(all);
    }
    diagnosis
        .held_out_s
        .iter_mut()
        .for_each(|w| *w = (bad, bad));
    let s = &mut diagnosis.setting;
    s.span_s = (bad, bad);
    s.density_kg_m3 = bad;
    s.riser_area_m2 = bad;
    s.line_length_m = bad;
    s.line_diameter_m = bad;
}

const NASTY: [f64; 9] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    5e-324,
    0.0,
    -1.0,
    1e300,
];

#[test]
fn no_value_everywhere_does_not_panic() {
    for bad in NASTY {
        for (name, mut diagnosis) in diagnoses::all(1) {
            spoil(&mut diagnosis, bad);
            let html = page(&diagnosis);
            assert_pictures(&format!("{name} of {bad}"), &html);
            let text = words(&html);
            assert!(
                !text.contains("NaN") && !text.contains("inf "),
                "{name} of {bad}"
            );
        }
    }
}

#[test]
fn nasty_values_in_sound_time_are_drawn_or_left_out() {
    for (name, mut diagnosis) in diagnoses::all(1) {
        let mut nasty = NASTY.into_iter().cycle();
        let mut sow = |values: &mut Vec<f64>| {
            for value in values.iter_mut().step_by(17) {
                *value = nasty.next().unwrap();
            }
        };
        for trace in &mut diagnosis.traces {
            sow(&mut trace.before);
            sow(&mut trace.after);
        }
        for signal in &mut diagnosis.simulation.signals {
            sow(&mut signal.measured);
            sow(&mut signal.before);
            sow(&mut signal.after);
        }
        for finding in &mut diagnosis.findings {
            if let Some(curve) = &mut finding.curve {
                curve.knots[3].1 = f64::NAN;
                curve.knots[5].1 = f64::MAX;
            }
        }
        let curves = diagnosis.findings.iter().filter(|f| f.curve.is_some());
        let pictures = 2 + curves.count();
        assert_eq!(assert_pictures(name, &page(&diagnosis)), pictures, "{name}");
    }
}

#[test]
fn empty_and_unequal_series_are_still_a_page() {
    for (name, mut diagnosis) in diagnoses::all(1) {
        diagnosis.simulation.held_out.clear();
        diagnosis.simulation.valid.truncate(10);
        diagnosis.simulation.signals[0].before.clear();
        diagnosis.simulation.signals[1].measured.truncate(3);
        diagnosis.traces[0].after.clear();
        diagnosis.traces[1].t_s.clear();
        assert_pictures(name, &page(&diagnosis));
        diagnosis.simulation.t_s.clear();
        diagnosis.simulation.signals.clear();
        diagnosis.traces.clear();
        diagnosis.tested.clear();
        diagnosis.checks.clear();
        diagnosis.held_out_s.clear();
        for finding in &mut diagnosis.findings {
            finding.parameters.clear();
            if let Some(curve) = &mut finding.curve {
                curve.knots.truncate(1);
            }
            finding.held_out = None;
            finding.intervals_s.clear();
            finding.alternatives.clear();
            finding.equation_after.clear();
        }
        assert_eq!(assert_pictures(name, &page(&diagnosis)), 0, "{name}");
    }
    let mut lost = diagnoses::single(1);
    lost.findings.clear();
    assert_eq!(lost.verdict, Verdict::Explained);
    assert!(words(&page(&lost)).contains("no cause could be identified"));
    lost.verdict = Verdict::Unexplained;
    assert!(
        words(&page(&lost)).contains("more than noise is left, and no cause could be identified")
    );
}

#[test]
fn eighty_five_hours_stay_below_half_a_megabyte() {
    for (name, diagnosis) in diagnoses::all(85) {
        let bytes = page(&diagnosis).len();
        assert!(bytes < 500_000, "{name}: {bytes} bytes");
    }
}

#[test]
fn the_same_diagnosis_gives_the_same_bytes() {
    let all: HashSet<String> = (0..2).map(|_| page(&diagnoses::two(1))).collect();
    assert_eq!(all.len(), 1);
}

#[test]
fn tables_name_their_columns_and_rows() {
    for (name, diagnosis) in diagnoses::all(1) {
        let html = page(&diagnosis);
        let document = parse(&html);
        for table in document
            .descendants()
            .filter(|n| n.tag_name().name() == "table")
        {
            let scope = |wanted: &str| {
                table
                    .descendants()
                    .filter(|n| n.attribute("scope") == Some(wanted))
                    .count()
            };
            let rows = table
                .descendants()
                .filter(|n| n.tag_name().name() == "tr")
                .count();
            assert!(scope("col") > 1 && scope("row") + 1 == rows, "{name}");
            assert!(table.children().any(|n| n.tag_name().name() == "caption"));
        }
    }
}
