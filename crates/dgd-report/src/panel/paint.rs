//! What stands in and around a frame: keys, grid, data, border, labels.

use super::{
    Drawn, Key, LABEL, LEGEND, Line, MOST_RUNS, Panel, ROW, Sign, Stack, TICK, WIDTH, WORDS,
};
use crate::axis::Scale;
use crate::color::{Color, FRAME, GRID, INK, PAPER, SHADE, SOFT_INK, tone};
use crate::font::{shorten, text_width};
use crate::scene::{Anchor, Pen, Runs, Scene, Shape};
use crate::thin::{Frame, cells, curve};

/// Title, power of ten and keys above the frame; returns the top of the frame.
pub(super) fn head(
    scene: &mut Scene,
    panel: &Panel<'_>,
    scale: &Scale,
    left: f64,
    right: f64,
    top: f64,
) -> f64 {
    let mut pen = left;
    let mut line = top;
    let mut used = false;
    if let Some(title) = &panel.title {
        // Bold is wider by less than 15 %.
        let text = shorten(title, LABEL * 1.15, right - left);
        scene.bold([left, line + 14.0], &text, LABEL, INK, Anchor::Start);
        pen += text_width(&text, LABEL, true) + 24.0;
        used = true;
    }
    if let Some(factor) = &scale.factor {
        scene.text([pen, line + 14.0], factor, TICK, SOFT_INK, Anchor::Start);
        pen += text_width(factor, TICK, false) + 20.0;
        used = true;
    }
    for key in &panel.keys {
        let text = shorten(&key.text, LEGEND, right - left - 32.0);
        let width = 28.0 + text_width(&text, LEGEND, false);
        if pen > left && pen + width > right {
            pen = left;
            line += ROW;
        }
        sign(scene, &key.sign, pen, line + 9.5);
        scene.text([pen + 28.0, line + 14.0], &text, LEGEND, INK, Anchor::Start);
        // Room to spare: a viewer without our font may take one that is wider.
        pen += width + 28.0;
        used = true;
    }
    line + if used { ROW + 1.0 } else { 4.0 }
}

pub(super) fn sign(scene: &mut Scene, sign: &Sign, x: f64, y: f64) {
    match sign {
        Sign::Dot(color) => scene.shapes.push(Shape::Circle {
            centre: [x + 13.0, y],
            radius: 4.0,
            fill: Some(*color),
            pen: None,
        }),
        Sign::Line(pen) => {
            let pen = Pen {
                width: pen.width.max(2.2),
                ..*pen
            };
            scene.line([x, y], [x + 22.0, y], pen);
        }
        Sign::Box(color) => scene.rect([x + 2.0, y - 5.5], [18.0, 11.0], *color),
    }
}

pub(super) fn shades(scene: &mut Scene, frame: &Frame, stack: &Stack<'_>, first: bool) {
    let spans: Vec<([f64; 2], &str)> = stack
        .shades
        .iter()
        .filter(|([from, to], _)| to >= from && *to >= frame.x[0] && *from <= frame.x[1])
        .map(|(span, word)| {
            (
                span.map(|v| frame.place(v, frame.y[0])[0].clamp(frame.left, frame.right())),
                word.as_str(),
            )
        })
        .collect();
    for (index, ([a, b], word)) in spans.iter().enumerate() {
        // The strip of words touches the shade it names.
        let named = first && !word.is_empty();
        let top = if named { frame.top - WORDS } else { frame.top };
        scene.rect([*a, top], [(b - a).max(1.5), frame.bottom() - top], SHADE);
        if named {
            let next = spans
                .get(index + 1..)
                .into_iter()
                .flatten()
                .map(|(span, _)| span[0])
                .find(|x| x > a);
            let room = next.map_or(WIDTH - 4.0, |x| x - 4.0) - a - 5.0;
            let text = shorten(word, 12.5, room);
            if text != "…" {
                scene.text(
                    [a + 5.0, frame.top - 5.0],
                    &text,
                    12.5,
                    Color(0x4b, 0x3b, 0x8f),
                    Anchor::Start,
                );
            }
        }
    }
}

/// Grid and the line at zero, in this tone of the frame's colour, under the data.
pub(crate) fn grid(scene: &mut Scene, frame: &Frame, x: &Scale, y: &Scale, zero: f64) {
    let rows = y.ticks.iter().map(|(v, _)| frame.place(frame.x[0], *v)[1]);
    let columns = x.ticks.iter().map(|(v, _)| frame.place(*v, frame.y[0])[0]);
    let mut lines: Vec<Vec<[f64; 2]>> = rows
        .map(|at| vec![[frame.left, at], [frame.right(), at]])
        .collect();
    lines.extend(columns.map(|at| vec![[at, frame.top], [at, frame.bottom()]]));
    scene.lines(lines, Pen::new(GRID, 1.0));
    if y.low < 0.0 && y.high > 0.0 {
        let at = frame.place(frame.x[0], 0.0)[1];
        scene.line(
            [frame.left, at],
            [frame.right(), at],
            Pen::new(tone(FRAME, zero), 1.0),
        );
    }
}

pub(super) fn data(drawn: &mut Drawn, panel: &Panel<'_>, frame: &Frame, most_runs: usize) {
    for (points, color) in &panel.areas {
        let clamped = points
            .iter()
            .filter(|p| p[0].is_finite() && p[1].is_finite())
            .map(|p| {
                frame.place(
                    p[0].clamp(frame.x[0], frame.x[1]),
                    p[1].clamp(frame.y[0], frame.y[1]),
                )
            })
            .collect();
        drawn.scene.shapes.push(Shape::Polygon {
            points: clamped,
            fill: *color,
            opacity: 1.0,
        });
    }
    for cloud in &panel.clouds {
        if cloud.counted {
            count_outside(drawn, frame, cloud.x, cloud.y, true);
        }
        let thin = cells(frame, cloud.x, cloud.y, most_runs, cloud.shade);
        drawn.shaded |= thin.shaded;
        for (runs, share) in thin.shades.into_iter().zip([0.3, 0.52, 0.76, 1.0]) {
            if !runs.runs.is_empty() {
                drawn.scene.shapes.push(Shape::Dots {
                    runs,
                    width: thin.dot,
                    color: tone(cloud.color, share),
                });
            }
        }
    }
    for line in &panel.lines {
        if line.counted {
            count_outside(drawn, frame, line.x, line.y, false);
        }
        let path = curve(frame, line.x, line.y);
        if line.rim {
            let rim = Pen {
                color: PAPER,
                width: line.pen.width + 3.0,
                dash: None,
            };
            drawn.scene.lines(path.lines.clone(), rim);
        }
        let lone = path.dots(frame, line.pen.color);
        drawn.scene.shapes.extend(lone);
        drawn.banded |= !path.bands.is_empty();
        for points in path.bands {
            drawn.scene.shapes.push(Shape::Polygon {
                points,
                fill: line.pen.color,
                opacity: 0.25,
            });
        }
        drawn.scene.lines(path.lines, line.pen);
        if line.dots {
            dots(&mut drawn.scene, frame, line);
        }
    }
}

pub(super) fn dots(scene: &mut Scene, frame: &Frame, line: &Line<'_>) {
    let thin = cells(frame, line.x, line.y, MOST_RUNS, false);
    for runs in thin
        .shades
        .into_iter()
        .filter(|r: &Runs| !r.runs.is_empty())
    {
        scene.shapes.push(Shape::Dots {
            runs,
            width: 5.5,
            color: line.pen.color,
        });
    }
}

pub(super) fn count_outside(drawn: &mut Drawn, frame: &Frame, x: &[f64], y: &[f64], cloud: bool) {
    for (&x, &y) in x.iter().zip(y) {
        if !(x.is_finite() && y.is_finite()) {
            drawn.missing += usize::from(cloud);
        } else if !frame.holds(x, y) {
            drawn.outside += 1;
        }
    }
}

pub(super) fn border(scene: &mut Scene, frame: &Frame, x: &Scale, y: &Scale, last: bool) {
    let (l, r, t, b) = (frame.left, frame.right(), frame.top, frame.bottom());
    let mut lines = vec![vec![[l, t], [r, t], [r, b], [l, b], [l, t]]];
    for (value, text) in &y.ticks {
        let at = frame.place(frame.x[0], *value)[1];
        lines.push(vec![[l - 4.0, at], [l, at]]);
        scene.text([l - 7.0, at + TICK * 0.36], text, TICK, INK, Anchor::End);
    }
    for (value, text) in &x.ticks {
        let at = frame.place(*value, frame.y[0])[0];
        lines.push(vec![[at, b], [at, b + 4.0]]);
        if last {
            scene.text([at, b + 7.0 + TICK], text, TICK, INK, Anchor::Middle);
        }
    }
    scene.lines(lines, Pen::new(FRAME, 1.0));
}

/// The label beside the frame, smaller and then shortened where it is longer than the frame is high.
pub(super) fn y_label(scene: &mut Scene, label: &str, frame: &Frame) {
    let middle = frame.top + frame.height / 2.0;
    let room = frame.height + 14.0;
    let width = text_width(label, LABEL, false);
    let size = if width > room {
        (LABEL * room / width).max(11.0)
    } else {
        LABEL
    };
    let text = shorten(label, size, room);
    scene.upright([LABEL + 3.0, middle], &text, size, INK);
}

pub(super) fn foot(
    scene: &mut Scene,
    stack: &Stack<'_>,
    x: &Scale,
    left: f64,
    right: f64,
    bottom: f64,
) {
    let y = bottom + TICK + LABEL + 15.0;
    let mut room = right - left;
    if let Some(factor) = &x.factor {
        scene.text([right, y], factor, TICK, SOFT_INK, Anchor::End);
        room -= 2.0 * text_width(factor, TICK, false) + 12.0;
    }
    let text = shorten(&stack.x.label, LABEL, room);
    scene.text(
        [f64::midpoint(left, right), y],
        &text,
        LABEL,
        INK,
        Anchor::Middle,
    );
}

pub(super) fn side_width(side: &(String, Vec<Key>)) -> f64 {
    let keys = side
        .1
        .iter()
        .map(|key| 28.0 + text_width(&key.text, LEGEND, false))
        .fold(0.0, f64::max);
    keys.max(text_width(&side.0, LEGEND, false))
        .clamp(40.0, 200.0)
        + 14.0
}

pub(super) fn side(scene: &mut Scene, heading: &str, keys: &[Key], left: f64, top: f64) {
    scene.text([left, top + 12.0], heading, LEGEND, SOFT_INK, Anchor::Start);
    for (row, key) in (1_u32..).zip(keys) {
        let y = top + 12.0 + f64::from(row) * 21.0;
        sign(scene, &key.sign, left, y - 4.5);
        scene.text([left + 28.0, y], &key.text, LEGEND, INK, Anchor::Start);
    }
}
