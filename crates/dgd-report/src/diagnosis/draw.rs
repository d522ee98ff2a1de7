//! What the two pictures of the report share: frames, thinned lines, keys.

use crate::axis::{Scale, Units, robust_range, roomy};
use crate::color::{Color, FRAME, INK, Role, SOFT_INK};
use crate::font::text_width;
use crate::panel::Sign;
use crate::scene::{Anchor, Pen, Scene, Shape};
use crate::thin::{Frame, curve};

/// Width of the page's column.
pub(super) const WIDTH: f64 = 760.0;
pub(super) const TEXT: f64 = 12.5;
/// Where findings act.
pub(super) const ACTS: Color = Color(0xe5, 0xe0, 0xf5);
pub(super) const ACTS_INK: Color = Color(0x4b, 0x3b, 0x8f);
/// Held-out windows.
pub(super) const HELD: Color = Color(0xee, 0xf2, 0xf5);
pub(super) const HELD_INK: Color = Color(0x7c, 0x88, 0x96);
/// From here on a clock reads better in hours.
const HOURS_FROM_S: f64 = 3.0 * 3600.0;
/// Ends of a band and mean of what falls on one column.
const COLUMN: f64 = 2.0;

/// Time units for a span, and the label of the axis.
pub(super) fn time_units(span_s: (f64, f64)) -> (Units, &'static str) {
    if span_s.1 - span_s.0 >= HOURS_FROM_S {
        (Units::Hours, "Time [h]")
    } else {
        (Units::Plain, "Time [s]")
    }
}

/// Range of the values without far outliers, and with some room.
pub(super) fn range(values: &mut [f64]) -> [f64; 2] {
    roomy(robust_range(values, 4.0))
}

pub(super) fn pen(role: Role) -> Pen {
    Pen {
        color: role.color(),
        width: 1.5,
        dash: role.dash().map(|[on, off]| [0.75 * on, 0.75 * off]),
    }
}

/// Stretches of time behind the data, cut at the frame.
pub(super) fn stretches(scene: &mut Scene, frame: &Frame, spans_s: &[(f64, f64)], color: Color) {
    for &(from, to) in spans_s {
        if !(from.is_finite() && to.is_finite() && to >= frame.x[0] && from <= frame.x[1]) {
            continue;
        }
        let place = |t: f64| frame.place(t, frame.y[0])[0].clamp(frame.left, frame.right());
        let (a, b) = (place(from), place(to));
        scene.rect([a, frame.top], [(b - a).max(1.5), frame.height], color);
    }
}

/// Grid and the line at zero, under the data.
pub(super) fn grid(scene: &mut Scene, frame: &Frame, x: &Scale, y: &Scale) {
    crate::panel::grid(scene, frame, x, y, 0.8);
}

/// Frame and tick texts, over the data.
pub(super) fn border(
    scene: &mut Scene,
    frame: &Frame,
    x: &Scale,
    y: &Scale,
    x_texts: bool,
    y_texts: bool,
) {
    let (l, r, t, b) = (frame.left, frame.right(), frame.top, frame.bottom());
    scene.lines(
        vec![vec![[l, t], [r, t], [r, b], [l, b], [l, t]]],
        Pen::new(FRAME, 1.0),
    );
    if y_texts {
        for (value, text) in &y.ticks {
            let at = frame.place(frame.x[0], *value)[1];
            scene.text([l - 6.0, at + TEXT * 0.36], text, TEXT, INK, Anchor::End);
        }
    }
    if x_texts {
        for (value, text) in &x.ticks {
            let at = frame.place(*value, frame.y[0])[0];
            scene.text([at, b + 4.0 + TEXT], text, TEXT, INK, Anchor::Middle);
        }
    }
}

/// One line over time, thinned to its mean and, if wanted, the band it spans; returns samples above or below.
pub(super) fn line(
    scene: &mut Scene,
    frame: &Frame,
    points: impl Iterator<Item = (f64, f64)>,
    pen: Pen,
    band: bool,
) -> usize {
    let mut columns = Columns::new(frame);
    let mut outside = 0;
    for (t, value) in points {
        if t < frame.x[0] || t > frame.x[1] {
            continue;
        }
        if value < frame.y[0] || value > frame.y[1] {
            outside += 1;
        }
        columns.add(t, value);
    }
    let (x, mean, bands) = columns.finish();
    if band {
        for points in bands {
            scene.shapes.push(Shape::Polygon {
                points,
                fill: pen.color,
                opacity: 0.2,
            });
        }
    }
    let path = curve(frame, &x, &mean);
    scene.shapes.extend(path.dots(frame, pen.color));
    scene.lines(path.lines, pen);
    outside
}

/// Samples gathered by the column of paper they fall on.
struct Columns<'a> {
    frame: &'a Frame,
    /// Sum of times, sum, number, least, greatest.
    held: Vec<(f64, f64, f64, f64, f64)>,
    /// A column that saw a gap and no value.
    gap: Vec<bool>,
}

impl<'a> Columns<'a> {
    fn new(frame: &'a Frame) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a paper is small"
        )]
        let n = (frame.width / COLUMN).clamp(1.0, 10_000.0) as usize;
        Self {
            frame,
            held: vec![(0.0, 0.0, 0.0, f64::MAX, f64::MIN); n],
            gap: vec![false; n],
        }
    }

    fn add(&mut self, t: f64, value: f64) {
        let share = (t - self.frame.x[0]) / (self.frame.x[1] - self.frame.x[0]);
        if !share.is_finite() {
            return;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "a share of a small number"
        )]
        let column =
            ((share.clamp(0.0, 1.0) * self.held.len() as f64) as usize).min(self.held.len() - 1);
        if !value.is_finite() {
            self.gap[column] = true;
            return;
        }
        let h = &mut self.held[column];
        // Sums of what no paper can show would overflow.
        let value = value.clamp(-1e150, 1e150);
        *h = (
            h.0 + t,
            h.1 + value,
            h.2 + 1.0,
            h.3.min(value),
            h.4.max(value),
        );
    }

    /// Places and means with a NaN at each gap, and the bands.
    fn finish(self) -> (Vec<f64>, Vec<f64>, Vec<Vec<[f64; 2]>>) {
        let (mut x, mut mean, mut bands) = (Vec::new(), Vec::new(), Vec::new());
        let (mut above, mut below): (Vec<[f64; 2]>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
        let mut close = |above: &mut Vec<[f64; 2]>, below: &mut Vec<[f64; 2]>| {
            if above.len() > 1 {
                below.reverse();
                above.append(below);
                bands.push(std::mem::take(above));
            }
            above.clear();
            below.clear();
        };
        let frame = self.frame;
        let place = |t: f64, v: f64| {
            let [x, y] = frame.place(t, v);
            [
                x.clamp(frame.left, frame.right()),
                y.clamp(frame.top, frame.bottom()),
            ]
        };
        for (held, gap) in self.held.iter().zip(&self.gap) {
            let &(t, sum, n, low, high) = held;
            if n > 0.0 {
                x.push(t / n);
                mean.push(sum / n);
                above.push(place(t / n, high));
                below.push(place(t / n, low));
            } else if *gap {
                x.push(f64::NAN);
                mean.push(f64::NAN);
                close(&mut above, &mut below);
            }
        }
        close(&mut above, &mut below);
        (x, mean, bands)
    }
}

/// Keys in a row that wraps; returns the bottom.
pub(super) fn keys(
    scene: &mut Scene,
    left: f64,
    right: f64,
    top: f64,
    keys: &[(Sign, &str)],
) -> f64 {
    let (mut x, mut y) = (left, top);
    for (sign, text) in keys {
        let width = 26.0 + text_width(text, TEXT, false);
        if x > left && x + width > right {
            x = left;
            y += 19.0;
        }
        match sign {
            Sign::Line(pen) => scene.line(
                [x, y + 8.5],
                [x + 20.0, y + 8.5],
                Pen {
                    width: pen.width.max(2.2),
                    ..*pen
                },
            ),
            Sign::Box(color) => scene.rect([x, y + 3.0], [20.0, 11.0], *color),
            Sign::Dot(color) => scene.shapes.push(Shape::Circle {
                centre: [x + 10.0, y + 8.5],
                radius: 3.5,
                fill: Some(*color),
                pen: None,
            }),
        }
        scene.text([x + 26.0, y + 13.0], text, TEXT, INK, Anchor::Start);
        x += width + 22.0;
    }
    y + 22.0
}

/// Label of the time axis under the middle of the picture.
pub(super) fn time_label(scene: &mut Scene, left: f64, right: f64, y: f64, label: &str) {
    scene.text(
        [f64::midpoint(left, right), y],
        label,
        TEXT,
        SOFT_INK,
        Anchor::Middle,
    );
}
