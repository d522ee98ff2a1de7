//! The same scene as PNG.

use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash,
    Transform,
};
use ttf_parser::OutlineBuilder;

use crate::color::Color;
use crate::error::ReportError;
use crate::font::Font;
use crate::scene::{Anchor, Pen, Scene, Shape};

/// The largest picture that is painted: 64 million pixels, 256 MB while it is made.
pub const MAX_PIXELS: u32 = 64_000_000;

pub(crate) fn paint(scene: &Scene, scale: f64) -> Result<Vec<u8>, ReportError> {
    let (width, height) = (
        (scene.width * scale).round(),
        (scene.height * scale).round(),
    );
    let refused = || ReportError::Scale {
        scale,
        width,
        height,
        most: MAX_PIXELS,
    };
    if !(width >= 1.0 && height >= 1.0 && width * height <= f64::from(MAX_PIXELS)) {
        return Err(refused());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 1 and MAX_PIXELS"
    )]
    let mut map = Pixmap::new(width as u32, height as u32).ok_or_else(refused)?;
    map.fill(tiny_skia::Color::WHITE);
    let mut painter = Painter {
        map,
        scale: single(scale),
        fonts: [Font::load(false), Font::load(true)],
    };
    for shape in &scene.shapes {
        painter.shape(shape);
    }
    painter.map.encode_png().map_err(|e| ReportError::Encode {
        reason: e.to_string(),
    })
}

struct Painter {
    map: Pixmap,
    scale: f32,
    fonts: [Option<Font>; 2],
}

impl Painter {
    fn base(&self) -> Transform {
        Transform::from_scale(self.scale, self.scale)
    }

    fn shape(&mut self, shape: &Shape) {
        match shape {
            Shape::Rect { at, size, fill } => {
                let [x, y, w, h] = [at[0], at[1], size[0], size[1]].map(single);
                if let Some(rect) = Rect::from_xywh(x, y, w, h) {
                    self.map
                        .fill_rect(rect, &paint_of(*fill), self.base(), None);
                }
            }
            Shape::Lines { lines, pen } => {
                let path = build(|b| lines.iter().for_each(|line| trace(b, line)));
                self.stroke(path, pen, LineCap::Butt, self.base());
            }
            Shape::Polygon {
                points,
                fill,
                opacity,
            } => {
                let path = build(|b| {
                    trace(b, points);
                    b.close();
                });
                self.fill(path, *fill, *opacity, self.base());
            }
            Shape::Circle {
                centre,
                radius,
                fill,
                pen,
            } => {
                let [x, y] = centre.map(single);
                let path = PathBuilder::from_circle(x, y, single(*radius));
                if let Some(fill) = fill {
                    self.fill(path.clone(), *fill, 1.0, self.base());
                }
                if let Some(pen) = pen {
                    self.stroke(path, pen, LineCap::Butt, self.base());
                }
            }
            Shape::Dots { runs, width, color } => {
                let path = build(|b| {
                    for run in &runs.runs {
                        let [row, first, last] = run.map(f64::from);
                        let y = single(runs.origin[1] + row * runs.cell);
                        b.move_to(single(runs.origin[0] + first * runs.cell), y);
                        // A stroke of no length has no round ends here; a hair's breadth has.
                        b.line_to(single(runs.origin[0] + last * runs.cell + 1e-3), y);
                    }
                });
                self.stroke(path, &Pen::new(*color, *width), LineCap::Round, self.base());
            }
            Shape::Text { .. } => self.text(shape),
        }
    }

    /// Paints a text; other shapes are none.
    fn text(&mut self, shape: &Shape) {
        let &Shape::Text {
            at,
            ref text,
            size,
            bold,
            color,
            anchor,
            upright,
        } = shape
        else {
            return;
        };
        let Some(font) = &self.fonts[usize::from(bold)] else {
            return;
        };
        let shift = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5,
            Anchor::End => -1.0,
        } * crate::font::text_width(text, size, bold);
        let per_unit = size / font.units_per_em();
        let path = build(|b| {
            for (glyph, pen) in font.glyphs(text) {
                let mut outline = Outline {
                    path: b,
                    scale: single(per_unit),
                    left: single(shift + pen * size),
                };
                font.face().outline_glyph(glyph, &mut outline);
            }
        });
        let mut place = self.base().pre_translate(single(at[0]), single(at[1]));
        if upright {
            place = place.pre_concat(Transform::from_rotate(-90.0));
        }
        self.fill(path, color, 1.0, place);
    }

    fn fill(&mut self, path: Option<Path>, color: Color, opacity: f64, place: Transform) {
        if let Some(path) = path {
            let mut paint = paint_of(color);
            paint.shader.apply_opacity(single(opacity));
            self.map
                .fill_path(&path, &paint, FillRule::Winding, place, None);
        }
    }

    fn stroke(&mut self, path: Option<Path>, pen: &Pen, cap: LineCap, place: Transform) {
        let Some(path) = path else { return };
        let stroke = Stroke {
            width: single(pen.width),
            line_cap: cap,
            line_join: LineJoin::Round,
            dash: pen
                .dash
                .and_then(|[on, off]| StrokeDash::new(vec![single(on), single(off)], 0.0)),
            ..Stroke::default()
        };
        self.map
            .stroke_path(&path, &paint_of(pen.color), &stroke, place, None);
    }
}

struct Outline<'a> {
    path: &'a mut PathBuilder,
    scale: f32,
    left: f32,
}

impl Outline<'_> {
    /// Font units grow upwards, pictures downwards.
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.left + x * self.scale, -y * self.scale)
    }
}

impl OutlineBuilder for Outline<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

fn build(draw: impl FnOnce(&mut PathBuilder)) -> Option<Path> {
    let mut builder = PathBuilder::new();
    draw(&mut builder);
    builder.finish()
}

fn trace(builder: &mut PathBuilder, points: &[[f64; 2]]) {
    for (index, point) in points.iter().enumerate() {
        let [x, y] = point.map(single);
        if index == 0 {
            builder.move_to(x, y)
        } else {
            builder.line_to(x, y)
        }
    }
}

fn paint_of(c: Color) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color_rgba8(c.0, c.1, c.2, 255);
    paint
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a place on paper; single precision is ample"
)]
fn single(value: f64) -> f32 {
    value as f32
}
