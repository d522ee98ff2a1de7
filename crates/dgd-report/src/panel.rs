//! Panels under one another: margins from the labels, legends above the frame, data inside it.

mod paint;

use crate::axis::{Axis, Scale, Units, given, robust_range, roomy, to_ticks};
use crate::color::{Color, SOFT_INK};
use crate::error::ReportError;
use crate::font::text_width;
use crate::scene::{Anchor, Pen, Scene};
use crate::thin::Frame;
pub(crate) use paint::grid;
use paint::{border, data, foot, head, shades, side, side_width, y_label};

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
        grid(&mut drawn.scene, &frame, &x_scale, scale, 0.75);
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
