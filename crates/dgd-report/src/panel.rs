//! Panels under one another: margins from the labels, legends above the frame, data inside it.

use crate::axis::{Axis, Scale, Units, given, robust_range, roomy, to_ticks};
use crate::color::{Color, FRAME, GRID, INK, PAPER, SHADE, SOFT_INK, tone};
use crate::error::ReportError;
use crate::font::{shorten, text_width};
use crate::scene::{Anchor, Pen, Runs, Scene, Shape};
use crate::thin::{Frame, cells, curve};

/// Width of every figure, in units of 1/96 inch.
pub(crate) const WIDTH: f64 = 640.0;
pub(crate) const TICK: f64 = 13.5;
pub(crate) const LABEL: f64 = 14.5;
pub(crate) const LEGEND: f64 = 13.5;
/// Half of a six-digit tick text fits beside the frame.
const RIGHT: f64 = 26.0;
const ROW: f64 = 22.0;
/// Height of the strip above the first frame that names the shaded intervals.
const WORDS: f64 = 18.0;
/// All clouds of a figure together: 60,000 runs are 0.4 MB of SVG at most.
const MOST_RUNS: usize = 60_000;

pub(crate) struct Cloud<'a> {
    pub x: &'a [f64],
    pub y: &'a [f64],
    pub color: Color,
    pub shade: bool,
    /// Points beyond the frame are counted for the caption, unless another cloud holds the same points.
    pub counted: bool,
}

pub(crate) struct Line<'a> {
    pub x: &'a [f64],
    pub y: &'a [f64],
    pub pen: Pen,
    /// A white rim, so that the line stands out from a cloud.
    pub rim: bool,
    /// A dot at every point.
    pub dots: bool,
    /// Samples beyond the frame are counted for the caption; those of a model's curve say nothing.
    pub counted: bool,
}

impl<'a> Line<'a> {
    pub(crate) fn new(x: &'a [f64], y: &'a [f64], pen: Pen) -> Self {
        Self {
            x,
            y,
            pen,
            rim: false,
            dots: false,
            counted: true,
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) enum Sign {
    Dot(Color),
    Line(Pen),
    Box(Color),
}

#[derive(Debug, Clone)]
pub(crate) struct Key {
    pub sign: Sign,
    pub text: String,
}

pub(crate) struct Panel<'a> {
    pub y: Axis,
    pub clouds: Vec<Cloud<'a>>,
    pub lines: Vec<Line<'a>>,
    /// Filled shapes in data units, under the lines.
    pub areas: Vec<(Vec<[f64; 2]>, Color)>,
    pub keys: Vec<Key>,
    pub title: Option<String>,
    pub height: f64,
    /// Extra room under the data, as a share of their span.
    pub foot: f64,
    /// How much wider than the central values the full range may be and still be drawn whole.
    pub tolerance: f64,
    pub empty: &'static str,
}

impl Panel<'_> {
    pub(crate) fn new(y: &Axis, height: f64) -> Self {
        Self {
            y: y.clone(),
            clouds: Vec::new(),
            lines: Vec::new(),
            areas: Vec::new(),
            keys: Vec::new(),
            title: None,
            height,
            foot: 0.0,
            tolerance: 1.3,
            empty: "No samples to show",
        }
    }

    fn is_empty(&self) -> bool {
        let shown =
            |x: &[f64], y: &[f64]| x.iter().zip(y).any(|(x, y)| x.is_finite() && y.is_finite());
        self.areas.is_empty()
            && !self.clouds.iter().any(|c| shown(c.x, c.y))
            && !self.lines.iter().any(|l| shown(l.x, l.y))
    }

    fn pairs(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let clouds = self
            .clouds
            .iter()
            .flat_map(|c| c.x.iter().copied().zip(c.y.iter().copied()));
        let lines = self
            .lines
            .iter()
            .flat_map(|l| l.x.iter().copied().zip(l.y.iter().copied()));
        let areas = self
            .areas
            .iter()
            .flat_map(|(points, _)| points.iter().map(|p| (p[0], p[1])));
        clouds
            .chain(lines)
            .chain(areas)
            .filter(|(x, y)| x.is_finite() && y.is_finite())
    }
}

/// Panels that share their x axis.
pub(crate) struct Stack<'a> {
    pub x: Axis,
    pub units: Units,
    pub panels: Vec<Panel<'a>>,
    /// A column of keys right of the frames: its heading and keys.
    pub side: Option<(String, Vec<Key>)>,
    /// Room kept free at the right for something the figure draws itself.
    pub side_room: f64,
    /// Shaded stretches of x with a word at the top.
    pub shades: Vec<([f64; 2], String)>,
    /// Margin around time axes is a waste; clouds need it.
    pub tight_x: bool,
}

impl<'a> Stack<'a> {
    pub(crate) fn new(x: &Axis, panels: Vec<Panel<'a>>) -> Self {
        Self {
            x: x.clone(),
            units: Units::Plain,
            panels,
            side: None,
            side_room: 0.0,
            shades: Vec::new(),
            tight_x: false,
        }
    }
}

/// What was drawn, and what it leaves to say in the caption.
pub(crate) struct Drawn {
    pub scene: Scene,
    pub frames: Vec<Frame>,
    /// Points (clouds) and samples (lines) beyond the frame.
    pub outside: usize,
    /// Points with a coordinate that is no number.
    pub missing: usize,
    pub shaded: bool,
    /// A curve was drawn as its mean with a band.
    pub banded: bool,
}

pub(crate) fn draw(stack: &Stack<'_>) -> Result<Drawn, ReportError> {
    let right_room = stack.side.as_ref().map_or(stack.side_room, side_width);
    let right = WIDTH
        - if right_room > 0.0 {
            right_room + 14.0
        } else {
            RIGHT
        };
    let x_range = x_range(stack)?;
    let nothing = stack.panels.iter().all(Panel::is_empty);
    let scales: Vec<Scale> = stack
        .panels
        .iter()
        .map(|panel| {
            let range = y_range(panel)?;
            let blank = panel.is_empty() && panel.y.range.is_none();
            let wanted = (panel.height / 46.0).max(2.5);
            Ok(if blank {
                Scale::blank(range)
            } else {
                Scale::new(range, wanted, Units::Plain)
            })
        })
        .collect::<Result<_, ReportError>>()?;
    let widest = scales
        .iter()
        .flat_map(|s| &s.ticks)
        .map(|(_, text)| text_width(text, TICK, false))
        .fold(16.0, f64::max);
    let left = (LABEL + 18.0 + widest + 7.0).round();
    let wanted = ((right - left) / 82.0).max(3.0);
    let x_scale = if nothing && stack.x.range.is_none() {
        Scale::blank(x_range)
    } else if stack.tight_x {
        Scale::new(to_ticks(x_range, wanted, stack.units), wanted, stack.units)
    } else {
        Scale::new(x_range, wanted, stack.units)
    };

    let mut drawn = Drawn {
        scene: Scene {
            width: WIDTH,
            ..Scene::default()
        },
        frames: Vec::new(),
        outside: 0,
        missing: 0,
        shaded: false,
        banded: false,
    };
    let clouds: usize = stack.panels.iter().map(|p| p.clouds.len()).sum();
    let mut top = 8.0;
    for (index, (panel, scale)) in stack.panels.iter().zip(&scales).enumerate() {
        top = head(&mut drawn.scene, panel, scale, left, right, top);
        if index == 0 && stack.shades.iter().any(|(_, word)| !word.is_empty()) {
            top += WORDS;
        }
        let frame = Frame {
            left,
            top,
            width: right - left,
            height: panel.height,
            x: [x_scale.low, x_scale.high],
            y: [scale.low, scale.high],
        };
        shades(&mut drawn.scene, &frame, stack, index == 0);
        grid(&mut drawn.scene, &frame, &x_scale, scale);
        data(&mut drawn, panel, &frame, MOST_RUNS / clouds.max(1));
        border(
            &mut drawn.scene,
            &frame,
            &x_scale,
            scale,
            index + 1 == stack.panels.len(),
        );
        if panel.is_empty() {
            let at = [
                frame.left + frame.width / 2.0,
                frame.top + frame.height / 2.0 + 5.0,
            ];
            drawn
                .scene
                .text(at, panel.empty, LABEL, SOFT_INK, Anchor::Middle);
        }
        y_label(&mut drawn.scene, &panel.y.label, &frame);
        drawn.frames.push(frame);
        top = frame.bottom() + 12.0;
    }
    let bottom = top - 12.0;
    foot(&mut drawn.scene, stack, &x_scale, left, right, bottom);
    if let (Some((heading, keys)), Some(first)) = (&stack.side, drawn.frames.first().copied()) {
        side(&mut drawn.scene, heading, keys, right + 18.0, first.top);
    }
    drawn.scene.height = (bottom + TICK + LABEL + 26.0).round();
    Ok(drawn)
}

fn x_range(stack: &Stack<'_>) -> Result<[f64; 2], ReportError> {
    if let Some(range) = given(&stack.x)? {
        return Ok(range);
    }
    let mut values: Vec<f64> = stack
        .panels
        .iter()
        .flat_map(Panel::pairs)
        .map(|(x, _)| x)
        .collect();
    // A clock has no outliers that may be cut.
    let tolerance = if stack.tight_x { f64::INFINITY } else { 1.3 };
    let range = robust_range(&mut values, tolerance);
    Ok(match range {
        Some([low, high]) if stack.tight_x && high > low => [low, high],
        other => roomy(other),
    })
}

fn y_range(panel: &Panel<'_>) -> Result<[f64; 2], ReportError> {
    if let Some(range) = given(&panel.y)? {
        return Ok(range);
    }
    let mut values: Vec<f64> = panel.pairs().map(|(_, y)| y).collect();
    let [low, high] = roomy(robust_range(&mut values, panel.tolerance));
    Ok([low - panel.foot * (high - low), high])
}

/// Title, power of ten and keys above the frame; returns the top of the frame.
fn head(
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

fn sign(scene: &mut Scene, sign: &Sign, x: f64, y: f64) {
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

fn shades(scene: &mut Scene, frame: &Frame, stack: &Stack<'_>, first: bool) {
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

fn grid(scene: &mut Scene, frame: &Frame, x: &Scale, y: &Scale) {
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
            Pen::new(tone(FRAME, 0.75), 1.0),
        );
    }
}

fn data(drawn: &mut Drawn, panel: &Panel<'_>, frame: &Frame, most_runs: usize) {
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

fn dots(scene: &mut Scene, frame: &Frame, line: &Line<'_>) {
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

fn count_outside(drawn: &mut Drawn, frame: &Frame, x: &[f64], y: &[f64], cloud: bool) {
    for (&x, &y) in x.iter().zip(y) {
        if !(x.is_finite() && y.is_finite()) {
            drawn.missing += usize::from(cloud);
        } else if !frame.holds(x, y) {
            drawn.outside += 1;
        }
    }
}

fn border(scene: &mut Scene, frame: &Frame, x: &Scale, y: &Scale, last: bool) {
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
fn y_label(scene: &mut Scene, label: &str, frame: &Frame) {
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

fn foot(scene: &mut Scene, stack: &Stack<'_>, x: &Scale, left: f64, right: f64, bottom: f64) {
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

fn side_width(side: &(String, Vec<Key>)) -> f64 {
    let keys = side
        .1
        .iter()
        .map(|key| 28.0 + text_width(&key.text, LEGEND, false))
        .fold(0.0, f64::max);
    keys.max(text_width(&side.0, LEGEND, false))
        .clamp(40.0, 200.0)
        + 14.0
}

fn side(scene: &mut Scene, heading: &str, keys: &[Key], left: f64, top: f64) {
    scene.text([left, top + 12.0], heading, LEGEND, SOFT_INK, Anchor::Start);
    for (row, key) in (1_u32..).zip(keys) {
        let y = top + 12.0 + f64::from(row) * 21.0;
        sign(scene, &key.sign, left, y - 4.5);
        scene.text([left + 28.0, y], &key.text, LEGEND, INK, Anchor::Start);
    }
}
