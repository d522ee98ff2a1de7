//! Where: residuals of each relation over time, with noise, findings and held-out windows, and the region in words.

use dgd_diagnose::{Diagnosis, Finding, Trace};

use super::draw::{
    ACTS, ACTS_INK, HELD, HELD_INK, TEXT, WIDTH, border, grid, keys, line, pen, range, stretches,
    time_label, time_units,
};
use super::html::{Cell, Html};
use super::letter;
use super::quantity::significant;
use super::words::{self, capital, title};
use crate::axis::{Scale, count, to_ticks};
use crate::color::{Color, INK, Role, SOFT_INK};
use crate::panel::Sign;
use crate::scene::{Anchor, Pen, Scene, Shape};
use crate::thin::Frame;

const LEFT: f64 = 62.0;
const RIGHT: f64 = WIDTH - 10.0;
const LANE: f64 = 92.0;
const NOISE: Color = Color(0xd6, 0xd9, 0xdd);
const BAND: Color = Color(0x5b, 0x63, 0x6e);
/// Edge of the wider band.
const EDGE: Pen = Pen {
    color: BAND,
    width: 1.0,
    dash: Some([2.0, 3.0]),
};
/// Half width of either band, in standard deviations.
const SIGMAS: f64 = 2.0;
const MOST_TRACES: usize = 8;
const MOST_FINDINGS: usize = 8;

pub(super) fn write(diagnosis: &Diagnosis, html: &mut Html) {
    let span = words::span(diagnosis);
    if diagnosis.findings.is_empty() {
        html.paragraph(if !diagnosis.unsuspected().is_empty() {
            "What was suspected shows in no relation, but something else may: the timeline shows the residuals of each."
        } else if diagnosis.traces.iter().any(Trace::exceeds_noise) {
            "A check reports residuals larger than noise and instrument accuracy explain, but nothing that could be named. The timeline shows where."
        } else {
            "No relation exceeds the limit for its noise and accuracy (see Checks). The timeline shows the residuals of each."
        });
    }
    timeline(diagnosis, span, html);
    if !diagnosis.findings.is_empty() {
        let rows: Vec<Vec<Cell>> = diagnosis
            .findings
            .iter()
            .enumerate()
            .map(|(index, finding)| {
                let region = finding.region.trim();
                vec![
                    Cell::Text(format!("{}. {}", letter(index), capital(&title(finding)))),
                    Cell::Named(
                        capital(words::relation(finding.relation)),
                        finding.relation.name().to_owned(),
                    ),
                    Cell::Text(capital(&words::when(finding, diagnosis))),
                    Cell::Text(if region.is_empty() {
                        "–".to_owned()
                    } else {
                        capital(region)
                    }),
                ]
            })
            .collect();
        html.table(
            "Where each finding acts: in the model, in time, in the operating space.",
            &["Finding", "Relation", "When", "Operating region"],
            &rows,
            "",
        );
    }
}

/// Shown unit and factor of a residual.
fn shown(unit: &str) -> (&str, f64) {
    match unit {
        "Pa" => ("bar", 1e-5),
        "m3/s" => ("L/min", 6e4),
        other => (other, 1.0),
    }
}

fn timeline(diagnosis: &Diagnosis, span: (f64, f64), html: &mut Html) {
    let traces: Vec<&Trace> = diagnosis.traces.iter().take(MOST_TRACES).collect();
    if traces.is_empty() {
        html.small("There are no residuals to draw.");
        return;
    }
    // Without findings the two models are one.
    let twofold = !diagnosis.findings.is_empty();
    let (units, label) = time_units(span);
    let x_scale = {
        let x = to_ticks([span.0, span.1], 8.0, units);
        Scale::new(x, 8.0, units)
    };
    let mut scene = Scene {
        width: WIDTH,
        ..Scene::default()
    };
    let after = if twofold { "After" } else { "Residual" };
    let mut legend = Vec::new();
    if twofold {
        legend.push((Sign::Line(pen(Role::Before)), "Before"));
    }
    legend.push((Sign::Line(pen(Role::Model)), after));
    legend.push((Sign::Box(NOISE), "Noise of a block, ±2 σ"));
    legend.push((Sign::Line(EDGE), "Noise and instrument wander, ±2 σ"));
    if twofold {
        legend.push((Sign::Box(ACTS), "Where a finding acts"));
    }
    legend.push((Sign::Box(HELD), "Held out"));
    let mut top = keys(&mut scene, LEFT, RIGHT, 4.0, &legend) + 4.0;
    let frame = |top: f64, height: f64, y: [f64; 2]| Frame {
        left: LEFT,
        top,
        width: RIGHT - LEFT,
        height,
        x: [x_scale.low, x_scale.high],
        y,
    };
    for (index, finding) in diagnosis.findings.iter().take(MOST_FINDINGS).enumerate() {
        let lane = frame(top, 12.0, [0.0, 1.0]);
        stretches(
            &mut scene,
            &lane,
            &[(lane.x[0], lane.x[1])],
            Color(0xf6, 0xf5, 0xfb),
        );
        stretches(&mut scene, &lane, &finding.intervals_s, ACTS_INK);
        let name = letter(index).to_string();
        scene.bold([LEFT - 7.0, top + 10.5], &name, TEXT, ACTS_INK, Anchor::End);
        top += 18.0;
    }
    let lane = frame(top, 6.0, [0.0, 1.0]);
    stretches(&mut scene, &lane, &diagnosis.held_out_s, HELD_INK);
    scene.text(
        [LEFT - 7.0, top + 7.0],
        "held out",
        11.0,
        SOFT_INK,
        Anchor::End,
    );
    top += 16.0;
    let mut outside = 0;
    for (index, trace) in traces.iter().enumerate() {
        top = head(&mut scene, trace, twofold, top);
        let (_, factor) = shown(trace.unit);
        let y = y_range(trace, twofold, factor);
        let lane = frame(top, LANE, y);
        let y_scale = Scale::new(y, 3.0, crate::axis::Units::Plain);
        stretches(&mut scene, &lane, &diagnosis.held_out_s, HELD);
        let somewhere = |f: &Finding| traces.iter().any(|t| shows(f, t));
        for finding in (diagnosis.findings.iter()).filter(|f| shows(f, trace) || !somewhere(f)) {
            stretches(&mut scene, &lane, &finding.intervals_s, ACTS);
        }
        band(&mut scene, &lane, trace.expected_sd() * factor, 0.08);
        band(&mut scene, &lane, trace.noise * factor, 0.17);
        edges(&mut scene, &lane, trace.expected_sd() * factor);
        grid(&mut scene, &lane, &x_scale, &y_scale);
        let mut draw = |values: &[f64], role: Role| {
            let points = trace.t_s.iter().zip(values).map(|(&t, &v)| (t, v * factor));
            outside += line(&mut scene, &lane, points, pen(role), role == Role::Model);
        };
        if twofold {
            draw(&trace.before, Role::Before);
        }
        draw(&trace.after, Role::Model);
        border(
            &mut scene,
            &lane,
            &x_scale,
            &y_scale,
            index + 1 == traces.len(),
            true,
        );
        top = lane.bottom() + 10.0;
    }
    time_label(&mut scene, LEFT, RIGHT, top + 24.0, label);
    scene.height = (top + 32.0).round();
    html.picture(
        &scene,
        "Residuals by relation over time",
        &caption(diagnosis, twofold, outside),
    );
}

/// Whether a finding enters the residual of a lane.
fn shows(finding: &Finding, trace: &Trace) -> bool {
    match trace.pair {
        None => finding.shows_in.contains(&trace.relation),
        pair => finding.pair == pair,
    }
}

/// Standard deviation of what a complete relation may leave: noise of a block, and what instruments may wander by.
/// Heights of `SIGMAS` standard deviations above and below zero, if there are any.
fn heights(lane: &Frame, sigma: f64) -> Option<[f64; 2]> {
    let half = SIGMAS * sigma;
    (half.is_finite() && half > 0.0).then(|| [half, -half].map(|v| lane.place(lane.x[0], v)[1]))
}

fn band(scene: &mut Scene, lane: &Frame, sigma: f64, opacity: f64) {
    if let Some(heights) = heights(lane, sigma) {
        let [high, low] = heights.map(|y| y.clamp(lane.top, lane.bottom()));
        scene.shapes.push(Shape::Polygon {
            points: vec![[LEFT, high], [RIGHT, high], [RIGHT, low], [LEFT, low]],
            fill: BAND,
            opacity,
        });
    }
}

fn edges(scene: &mut Scene, lane: &Frame, sigma: f64) {
    for y in heights(lane, sigma).into_iter().flatten() {
        if (lane.top..=lane.bottom()).contains(&y) {
            scene.line([LEFT, y], [RIGHT, y], EDGE);
        }
    }
}

/// Without the digits that only rounding left.
fn rounded(offset: f64) -> f64 {
    if offset.abs() < 1e-6 { 0.0 } else { offset }
}

fn caption(diagnosis: &Diagnosis, twofold: bool, outside: usize) -> String {
    let mut text = if twofold {
        "Measured minus model in blocks, before and after the findings; a violet stretch is where a finding acts, in the lane of its relation or, \
         for a faulty reading, of all relations that it affects. "
            .to_owned()
    } else {
        "Measured minus model in blocks. ".to_owned()
    };
    text.push_str(
        "With nothing missing, blocks stay mostly within the dark grey band (noise); over minutes and hours it may depart from zero \
         as far as the dotted lines, because instruments wander within their accuracy. A constant departure is an offset: the limits under Checks \
         give the size from which one is named. ",
    );
    // A constant between two transmitters is fitted; that it was must be seen.
    let taken_off: Vec<String> = (diagnosis.traces.iter())
        .filter(|t| t.offset.is_finite())
        .filter_map(|t| {
            let (unit, factor) = shown(t.unit);
            Some(format!(
                "{} {} {unit}",
                t.pair?,
                significant(rounded(t.offset * factor), 2)
            ))
        })
        .collect();
    if !taken_off.is_empty() {
        text.push_str(&format!(
            "Constant offsets removed: {}. ",
            taken_off.join(", ")
        ));
    }
    text.push_str(
        "Where blocks are dense, the line is their mean and the pale blue band spans them all.",
    );
    if let Some(began) = diagnosis.began {
        text.push_str(&format!(" 0 is {began}."));
    }
    if outside > 0 {
        text.push_str(&format!(
            " {} blocks lie outside the frame.",
            count(outside)
        ));
    }
    text
}

/// Name, unit and how the residual stands to what a complete relation may leave, above a lane.
fn head(scene: &mut Scene, trace: &Trace, twofold: bool, top: f64) -> f64 {
    let (unit, factor) = shown(trace.unit);
    let name = trace.pair.unwrap_or(words::relation(trace.relation));
    let name = format!("{} [{unit}]", capital(name));
    scene.bold([LEFT, top + 13.0], &name, 13.0, INK, Anchor::Start);
    let text = |value: f64| significant(value * factor, 2);
    let after = text(rms(&trace.after));
    let said = if twofold {
        format!("{} before, {after} after", text(rms(&trace.before)))
    } else {
        after
    };
    let text = format!(
        "RMS {said}; noise {}, with wander {}",
        text(trace.noise),
        text(trace.expected_sd())
    );
    scene.text([RIGHT, top + 13.0], &text, TEXT, SOFT_INK, Anchor::End);
    top + 19.0
}

fn rms(values: &[f64]) -> f64 {
    let (sum, n) = values
        .iter()
        .filter(|v| v.is_finite())
        .fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    (sum / n).sqrt()
}

fn y_range(trace: &Trace, twofold: bool, factor: f64) -> [f64; 2] {
    let before = trace.before.iter().filter(|_| twofold);
    let noise = [
        1.1 * SIGMAS * trace.expected_sd(),
        -1.1 * SIGMAS * trace.expected_sd(),
    ];
    let mut values: Vec<f64> = before
        .chain(&trace.after)
        .chain(&noise)
        .map(|v| v * factor)
        .filter(|v| v.is_finite())
        .collect();
    range(&mut values)
}
