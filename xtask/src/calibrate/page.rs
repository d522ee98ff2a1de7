//! `calibration.html`.

use super::belief::{Belief, NAMES, PRIOR};
use super::hurdles::{Hurdle, Hurdles};
use super::sizes::{Size, Sizes, WIDENING};
use super::{Calibration, logistic::Fit};
use crate::prove::page::{self, Cell, figure, put, table};
use crate::prove::stats::{Tally, reliability};
use crate::prove::svg::{Anchor, BLUE, FAINT, GREEN, GRID, INK, RED, Svg, escape};
use crate::prove::truth::Sort;

/// A spread below this is no exponential tail's, nor is one above the other.
const LIGHT: f64 = 0.7;
/// See [`LIGHT`].
const HEAVY: f64 = 1.5;

/// The page.
pub(crate) fn write(c: &Calibration) -> String {
    let mut html = page::begin("Calibration of the diagnosis");
    put!(html, "<h1>Hurdles and probabilities, calibrated</h1>");
    put!(html, "<p class=\"lead\">{}</p>", escape(&ensembles(c)));
    put!(
        html,
        "<p>{} {}</p><p class=\"quiet\">Nothing here proves anything: <code>cargo xtask prove</code> refuses these seeds. No source was edited.</p>",
        escape(&alarms(&c.hurdles)),
        escape(&brier(&c.belief))
    );
    hurdles(&mut html, &c.hurdles, c.settings.tail);
    belief(&mut html, &c.belief);
    sizes(&mut html, &c.sizes);
    method(&mut html, c);
    html.push_str(page::END);
    html
}

fn share(tally: Tally) -> String {
    match tally.interval() {
        Some((low, high)) => format!(
            "{} of {} ({:.0}–{:.0} %)",
            tally.right,
            tally.of,
            100.0 * low,
            100.0 * high
        ),
        None => "none".into(),
    }
}

/// What the calibration rests on, in a sentence.
pub(crate) fn ensembles(c: &Calibration) -> String {
    let of = |level: u8| c.cases.iter().filter(move |k| k.level == level);
    let clean = |level: u8| of(level).filter(|k| k.truth.sort() == Sort::Clean).count();
    let levels: Vec<String> = c
        .settings
        .level
        .list()
        .iter()
        .map(|l| {
            format!(
                "{} of level {l}, {} of them clean ({:.0} %)",
                of(*l).count(),
                clean(*l),
                100.0 * clean(*l) as f64 / (of(*l).count().max(1)) as f64
            )
        })
        .collect();
    let seeds: Vec<String> = c.settings.seeds.iter().map(u64::to_string).collect();
    let silent = match c.broken.len() {
        0 => String::new(),
        n => format!("; {n} runs gave no answer"),
    };
    format!(
        "{} recordings of the seeds {}: {}{silent}.",
        c.cases.len(),
        seeds.join(", "),
        levels.join("; ")
    )
}

/// How often clean recordings exceed hurdles, in words.
pub(crate) fn alarms(h: &Hurdles) -> String {
    let mut text = format!(
        "Some effect's evidence exceeds its hurdle of now in {} of the clean recordings",
        share(h.alarms_now)
    );
    if h.alarms_left_out.of > 0 {
        text.push_str(&format!(
            ", and a hurdle derived from the other seeds in {}",
            share(h.alarms_left_out)
        ));
    }
    text + "."
}

/// The Brier scores, in words.
pub(crate) fn brier(b: &Belief) -> String {
    let told = |v: Option<f64>| v.map_or("–".into(), |v| format!("{v:.4}"));
    let [bare, now, left_out] = b.brier().map(told);
    format!(
        "Of {} findings {} are right; Brier score {bare} bare, {now} by the constants now, {left_out} by constants derived from the other seeds.",
        b.claims.len(),
        b.claims.iter().filter(|c| c.right).count()
    )
}

fn hurdles(html: &mut String, h: &Hurdles, tail: f64) {
    figure(
        html,
        "Evidence in clean recordings",
        &lanes(&h.effects),
        &format!(
            "First-round evidence (natural logarithm of the Bayes factor) of each effect in clean recordings that can show it, a dot a recording. Red stroke: the hurdle now. Green: the evidence \
             that a clean recording exceeds at a rate of {:.4} an effect, with its 95 % interval.",
            h.rate
        ),
    );
    let number = |v: Option<f64>| v.map_or("–".into(), |v| format!("{v:.1}"));
    let row = |e: &Hurdle| {
        let both = |count: &dyn Fn(f64) -> String| {
            let of = |v: Option<f64>| v.map_or("–".into(), count);
            format!("{} / {}", of(e.now), of(e.derived()))
        };
        vec![
            Cell::Name(e.effect.replace('_', " ")),
            Cell::Text(e.clean.len().to_string()),
            Cell::Text(e.forbidden.to_string()),
            Cell::Text(number(e.tail.map(|t| t.threshold))),
            Cell::Text(number(e.tail.map(|t| t.scale))),
            Cell::Text(e.tail.map_or("–".into(), |t| format!("{:.2}", t.spread))),
            Cell::Text(number(e.tail.map(|t| t.largest))),
            Cell::Number(number(e.now)),
            Cell::Number(number(e.derived())),
            Cell::Basis(e.error().map_or(String::new(), |v| format!("± {v:.1}"))),
            Cell::Text(both(&|v| e.above(v).to_string())),
            Cell::Text(both(&|v| e.power(v).right.to_string())),
            Cell::Basis(format!("of {}", e.own.len())),
            told(e),
        ]
    };
    let cells: Vec<Vec<Cell>> = h.effects.iter().map(row).collect();
    let head = [
        "effect",
        "clean",
        "forbidden",
        "threshold",
        "scale",
        "spread",
        "largest",
        "hurdle now",
        "derived",
        "",
        "clean above",
        "own above",
        "",
        "now is",
    ];
    put!(html, "<h2>Hurdles</h2>");
    table(html, &head, &cells);
    put!(
        html,
        "<p class=\"quiet\">The tail above the {:.0} % quantile, the threshold, is taken for exponential: derived = threshold + scale · ln(share above it / rate), scale the mean exceedance; the \
         standard error is that of threshold and scale. Spread: standard deviation over mean of the exceedances, 1 if they are exponential; well above 1 the tail is heavier and the derived hurdle \
         too low, well below 1 it is lighter and the hurdle too high (a threshold far below 0, where evidence falls off evenly, does that: a larger <code>--tail</code> mends it where there are \
         recordings enough). Not below 1: less is no evidence. Forbidden: clean recordings in which size, bounds or place forbid to name the effect whatever its evidence, where \
         <code>dgd diagnose</code> tells it (<code>admissible</code>); where it does not, evidence above a hurdle is not yet an alarm, and the derived hurdle is too high for an effect that is mostly too \
         small to be named. Clean above, own above: above the hurdle now / derived, of clean recordings and of those in which the effect alone is concealed, from strong to trace. Low, high: by \
         more than two standard errors. Evidence below half of the hurdle of now is told before the minutes about an onset are taken out, which lowers it: where the derived hurdle comes out near \
         there, look twice. A dash: the effect is not weighed in the first round, or too few clean recordings can show it.</p>",
        100.0 * tail
    );
}

/// What the derived hurdle says of that now.
fn told(e: &Hurdle) -> Cell {
    let (Some(tail), Some(now), Some(derived), Some(error)) =
        (e.tail, e.now, e.derived(), e.error())
    else {
        return Cell::Text("–".into());
    };
    let off = (now - derived) / error;
    match off {
        _ if tail.spread < LIGHT => Cell::Text("(light tail)".into()),
        _ if tail.spread > HEAVY => Cell::Text("(heavy tail)".into()),
        _ if off < -2.0 => Cell::Target(Some(false), "low".into()),
        _ if off > 2.0 => Cell::Target(Some(true), "high".into()),
        _ => Cell::Target(Some(true), "near".into()),
    }
}

fn belief(html: &mut String, b: &Belief) {
    put!(html, "<h2>From evidence to probability</h2>");
    put!(
        html,
        "<p>logit p = b<sub>0</sub> + b<sub>1</sub> ln(evidence / hurdle) + b<sub>2</sub> logit(share); share: the bare probability among alternatives, 0.01 to 0.99.</p>"
    );
    let value = |list: Option<&[f64]>, k: usize| -> String {
        let value = list.and_then(|l| l.get(k));
        value.map_or("–".into(), |v| format!("{v:.2}"))
    };
    let fit = b.fit.as_ref();
    let errors = fit.map(|f: &Fit| f.errors.as_slice());
    let row = |(k, name): (usize, &&str)| {
        let fitted = fit.map(|f: &Fit| f.coefficients.as_slice());
        vec![
            Cell::Name((*name).to_owned()),
            Cell::Number(value(b.now.as_ref().map(|n| n.as_slice()), k)),
            Cell::Number(value(fitted, k)),
            Cell::Basis(match fitted {
                Some(_) => format!("± {}", value(errors, k)),
                None => String::new(),
            }),
        ]
    };
    let cells: Vec<Vec<Cell>> = NAMES.iter().enumerate().map(row).collect();
    table(html, &["coefficient", "now", "derived", ""], &cells);
    put!(
        html,
        "<p class=\"quiet\">{} findings of effects of the catalogue. A normal prior of standard deviation {PRIOR:.0} on each coefficient keeps it finite. \
         Findings are those that the hurdles of now let through and that are likelier than not: with other hurdles, calibrate again. Errors take findings of one recording \
         for independent.</p>",
        b.claims.len()
    );
    figure(
        html,
        "Are the probabilities honest?",
        &honest(b),
        "Findings by tenth of the probability stated, with the share that was right, its 95 % interval and the number of findings: bare, by the constants now, and by constants derived from \
         the other seeds alone.",
    );
}

fn sizes(html: &mut String, s: &Sizes) {
    put!(html, "<h2>How well sizes are told</h2>");
    let number = |v: Option<f64>| v.map_or("–".into(), |v| format!("{v:.3}"));
    let row = |s: &Size| {
        vec![
            Cell::Name(s.effect.replace('_', " ")),
            Cell::Text(s.told.len().to_string()),
            Cell::Text(number(s.typical())),
            Cell::Number(number(Some(s.now))),
            Cell::Number(number(s.derived())),
            Cell::Text(share(s.held())),
        ]
    };
    let cells: Vec<Vec<Cell>> = s.effects.iter().map(row).collect();
    let head = [
        "effect",
        "told",
        "median error",
        "share now",
        "derived",
        "held by the share now",
    ];
    table(html, &head, &cells);
    put!(
        html,
        "<p class=\"quiet\">Sizes of effects that were concealed and found, errors as shares of what was told (of a gain, of its distance from 1). An interval reaches 1.96 times the root of \
         ({WIDENING} standard errors)² + (share of the size)²; derived: the share with which 19 of 20 intervals hold what was concealed. All intervals by the shares now: {}.</p>",
        share(s.held())
    );
}

fn method(html: &mut String, c: &Calibration) {
    let s = c.settings;
    let seeds: Vec<String> = s.seeds.iter().map(u64::to_string).collect();
    let level = match s.level.list() {
        [one] => one.to_string(),
        _ => "both".into(),
    };
    put!(
        html,
        "<h2>How this was made</h2><p><code>cargo xtask calibrate --seeds {} --count {} --clean {} --level {level} --rate {} --tail {}</code></p>\
         <p>For each seed and level <code>dgd-plant</code> made {} mixed recordings (of twenty three are clean) and {} clean ones, those that are also in the mix counted once. \
         <code>dgd diagnose --without calibration</code> ran on each alone.</p>",
        seeds.join(","),
        s.count,
        s.clean,
        s.rate,
        s.tail,
        s.count,
        s.clean
    );
    for line in &c.broken {
        put!(html, "<p class=\"quiet\">{}</p>", escape(line));
    }
}

/// Clean evidence, a lane an effect, on a scale that is even near zero and logarithmic far from it.
fn lanes(effects: &[Hurdle]) -> String {
    const LEFT: f64 = 185.0;
    const WIDTH: f64 = 560.0;
    const LANE: f64 = 20.0;
    const ENDS: (f64, f64) = (-30.0, 300.0);
    let bottom = 8.0 + LANE * effects.len() as f64;
    let mut svg = Svg::new(
        LEFT + WIDTH + 20.0,
        bottom + 42.0,
        "Evidence of each effect in clean recordings",
    );
    let bent = |v: f64| (v / 4.0).asinh();
    let x = |v: f64| {
        let share = (bent(v.clamp(ENDS.0, ENDS.1)) - bent(ENDS.0)) / (bent(ENDS.1) - bent(ENDS.0));
        LEFT + share * WIDTH
    };
    for v in [-30.0, -10.0, -3.0, 0.0, 3.0, 10.0, 30.0, 100.0, 300.0] {
        let (stroke, width) = if v == 0.0 { (FAINT, 1.4) } else { (GRID, 1.0) };
        svg.line((x(v), 8.0), (x(v), bottom), stroke, width);
        svg.text((x(v), bottom + 15.0), Anchor::Middle, FAINT, &v.to_string());
    }
    svg.text(
        (LEFT + WIDTH / 2.0, bottom + 33.0),
        Anchor::Middle,
        INK,
        "evidence (ln Bayes factor)",
    );
    for (k, e) in effects.iter().enumerate() {
        let y = 8.0 + LANE * (k as f64 + 0.5);
        let name = e.effect.replace('_', " ");
        svg.text((LEFT - 8.0, y + 4.0), Anchor::End, INK, &name);
        for (n, v) in e.clean.iter().enumerate() {
            // Spread a little, always the same way, so that equal ones show.
            let jitter = 0.8 * (((n * 7) % 11) as f64 - 5.0);
            svg.dot((x(*v), y + jitter), 1.8, BLUE, 0.45);
        }
        if let (Some(derived), Some(error)) = (e.derived(), e.error()) {
            let ends = (x(derived - 1.96 * error), x(derived + 1.96 * error));
            svg.line((ends.0, y), (ends.1, y), GREEN, 1.4);
            svg.line((x(derived), y - 7.0), (x(derived), y + 7.0), GREEN, 2.0);
        }
        if let Some(now) = e.now {
            svg.line((x(now), y - 8.0), (x(now), y + 8.0), RED, 2.0);
        }
    }
    svg.finish()
}

/// Share right against probability stated, a panel each.
fn honest(b: &Belief) -> String {
    const W: f64 = 260.0;
    const SIDE: f64 = 190.0;
    let titles = ["bare", "by the constants now", "derived from other seeds"];
    let mut svg = Svg::new(
        W * titles.len() as f64,
        SIDE + 72.0,
        "Share of findings right, against their probability",
    );
    let panels = titles.iter().zip(b.forecasts());
    for (k, (title, forecasts)) in panels.enumerate() {
        let left = W * k as f64 + 40.0;
        let x = |p: f64| left + p * SIDE;
        let y = |p: f64| 28.0 + (1.0 - p) * SIDE;
        svg.text((left, 16.0), Anchor::Start, INK, title);
        svg.reliability_frame(x, y);
        for (p, tally) in reliability(&forecasts) {
            let (Some(share), Some((low, high))) = (tally.share(), tally.interval()) else {
                continue;
            };
            svg.line((x(p), y(low)), (x(p), y(high)), BLUE, 1.2);
            svg.dot((x(p), y(share)), 3.6, BLUE, 1.0);
            let label = tally.of.to_string();
            let lift = if share > 0.5 { 14.0 } else { -6.0 };
            svg.text((x(p) - 6.0, y(share) + lift), Anchor::End, FAINT, &label);
        }
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::super::belief::tests::claimed;
    use super::super::hurdles::tests::cases;
    use super::super::tests::settings;
    use super::*;
    use crate::calibrate::Case;
    use crate::calibrate::hurdles::tests::RULE;
    use std::collections::BTreeMap;

    fn page_of(cases: Vec<Case>) -> String {
        write(&Calibration {
            settings: &settings(&[11, 12, 13]),
            hurdles: Hurdles::of(&cases, RULE),
            belief: Belief::of(&cases, Some([-0.9, 0.55, 0.5])),
            sizes: Sizes::of(&cases, &BTreeMap::new()),
            cases,
            broken: vec!["seed-11-mix/level-2/c003: <b>".into()],
        })
    }

    #[test]
    fn every_section_stands_with_and_without_recordings() {
        let mut all = cases();
        all.extend(claimed([-1.0, 0.8, 0.6]));
        let full = page_of(all);
        for html in [&full, &page_of(Vec::new())] {
            for section in [
                "Evidence in clean recordings",
                "Hurdles</h2>",
                "From evidence to probability",
                "Are the probabilities honest?",
                "How well sizes are told",
                "--seeds 11,12,13 --count 6 --clean 4 --level 2",
                "1 runs gave no answer",
                "c003: &lt;b&gt;",
            ] {
                assert!(html.contains(section), "{section}");
            }
            assert!(!html.contains("NaN"));
        }
        assert!(page_of(cases()).contains("✓ high"));
        assert!(page_of(cases()).contains("312 of level 2, 300 of them clean (96 %)"));
    }
}
