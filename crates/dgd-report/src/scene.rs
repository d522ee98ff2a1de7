//! What is drawn, before anybody decides how: a list of shapes that the SVG and the PNG writer both read.

use crate::color::Color;

/// Where a text is tied to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A pen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pen {
    pub color: Color,
    pub width: f64,
    pub dash: Option<[f64; 2]>,
}

impl Pen {
    pub(crate) fn new(color: Color, width: f64) -> Self {
        Self {
            color,
            width,
            dash: None,
        }
    }
}

/// Cells of a grid that hold a point, as horizontal runs; drawn as round-ended strokes, so a lone cell is a dot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Runs {
    /// Centre of cell (0, 0).
    pub origin: [f64; 2],
    /// Side of a cell.
    pub cell: f64,
    /// Row, first column, last column; rows grow downwards. Sorted.
    pub runs: Vec<[u32; 3]>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Rect {
        at: [f64; 2],
        size: [f64; 2],
        fill: Color,
    },
    /// Each inner list is a line of its own.
    Lines { lines: Vec<Vec<[f64; 2]>>, pen: Pen },
    Polygon {
        points: Vec<[f64; 2]>,
        fill: Color,
        opacity: f64,
    },
    Circle {
        centre: [f64; 2],
        radius: f64,
        fill: Option<Color>,
        pen: Option<Pen>,
    },
    Dots {
        runs: Runs,
        width: f64,
        color: Color,
    },
    Text {
        at: [f64; 2],
        text: String,
        size: f64,
        bold: bool,
        color: Color,
        anchor: Anchor,
        upright: bool,
    },
}

/// A picture: shapes painted in order on white paper.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Scene {
    pub width: f64,
    pub height: f64,
    pub shapes: Vec<Shape>,
}

impl Scene {
    pub(crate) fn rect(&mut self, at: [f64; 2], size: [f64; 2], fill: Color) {
        self.shapes.push(Shape::Rect { at, size, fill });
    }

    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], pen: Pen) {
        self.lines(vec![vec![from, to]], pen);
    }

    pub(crate) fn lines(&mut self, lines: Vec<Vec<[f64; 2]>>, pen: Pen) {
        if !lines.is_empty() {
            self.shapes.push(Shape::Lines { lines, pen });
        }
    }

    pub(crate) fn dot(&mut self, centre: [f64; 2], radius: f64, fill: Color) {
        self.shapes.push(Shape::Circle {
            centre,
            radius,
            fill: Some(fill),
            pen: None,
        });
    }

    /// A circle with an outline on white paper.
    pub(crate) fn ring(&mut self, centre: [f64; 2], radius: f64, pen: Pen) {
        self.shapes.push(Shape::Circle {
            centre,
            radius,
            fill: Some(crate::color::PAPER),
            pen: Some(pen),
        });
    }

    pub(crate) fn polygon(&mut self, points: Vec<[f64; 2]>, fill: Color) {
        self.shapes.push(Shape::Polygon {
            points,
            fill,
            opacity: 1.0,
        });
    }

    pub(crate) fn text(
        &mut self,
        at: [f64; 2],
        text: &str,
        size: f64,
        color: Color,
        anchor: Anchor,
    ) {
        self.shapes.push(Shape::Text {
            at,
            text: text.to_owned(),
            size,
            bold: false,
            color,
            anchor,
            upright: false,
        });
    }

    pub(crate) fn bold(
        &mut self,
        at: [f64; 2],
        text: &str,
        size: f64,
        color: Color,
        anchor: Anchor,
    ) {
        self.shapes.push(Shape::Text {
            at,
            text: text.to_owned(),
            size,
            bold: true,
            color,
            anchor,
            upright: false,
        });
    }

    /// Text that reads upwards, its middle at `at`.
    pub(crate) fn upright(&mut self, at: [f64; 2], text: &str, size: f64, color: Color) {
        let text = text.to_owned();
        self.shapes.push(Shape::Text {
            at,
            text,
            size,
            bold: false,
            color,
            anchor: Anchor::Middle,
            upright: true,
        });
    }
}
