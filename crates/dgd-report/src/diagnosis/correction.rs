//! The curve of an empirical correction: what it adds, along the quantity that it depends on.

use dgd_diagnose::CorrectionCurve;

use super::draw::{TEXT, WIDTH, border, grid, pen, range, time_label, time_units};
use super::html::Html;
use super::quantity::split;
use super::words::capital;
use crate::axis::{Scale, Units};
use crate::color::{INK, Role, SOFT_INK};
use crate::scene::{Anchor, Pen, Scene, Shape};
use crate::thin::{Frame, curve};

const LEFT: f64 = 58.0;
const TOP: f64 = 22.0;
const HEIGHT: f64 = 150.0;

/// Draws it; nothing where no two knots are numbers.
pub(super) fn picture(correction: &CorrectionCurve, html: &mut Html) {
    let (adds, value) = split(correction.adds);
    let (along, quantity) = split(correction.along);
    let knots: Vec<[f64; 2]> = (correction.knots.iter())
        .map(|(x, y)| [x * quantity.factor, y * value.factor])
        .filter(|knot| knot.iter().all(|v| v.is_finite()))
        .collect();
    let ends = knots.first().zip(knots.last());
    let Some(([from, _], [to, _])) = ends.filter(|(first, last)| last[0] > first[0]) else {
        return;
    };
    // Nothing is added at zero, which therefore must be seen.
    let mut values: Vec<f64> = knots.iter().map(|k| k[1]).chain([0.0]).collect();
    let frame = Frame {
        left: LEFT,
        top: TOP,
        width: WIDTH - 10.0 - LEFT,
        height: HEIGHT,
        x: [*from, *to],
        y: range(&mut values),
    };
    let (units, label) = if quantity.symbol == "s" {
        let (units, label) = time_units((*from, *to));
        (units, label.replace("Time", &capital(&along)))
    } else {
        (
            Units::Plain,
            format!("{} [{}]", capital(&along), quantity.symbol),
        )
    };
    let x = Scale::new(frame.x, frame.width / 70.0, units);
    let y = Scale::new(frame.y, 4.0, Units::Plain);
    let mut scene = Scene {
        width: WIDTH,
        height: TOP + HEIGHT + 54.0,
        ..Scene::default()
    };
    let heading = format!("{} [{}]", capital(&adds), value.symbol);
    scene.bold([LEFT, 13.0], &heading, 13.0, INK, Anchor::Start);
    grid(&mut scene, &frame, &x, &y);
    scene.lines(
        vec![vec![
            frame.place(frame.x[0], 0.0),
            frame.place(frame.x[1], 0.0),
        ]],
        Pen::new(SOFT_INK, 1.0),
    );
    for [x, y] in knots.iter().filter(|[x, y]| frame.holds(*x, *y)) {
        scene.shapes.push(Shape::Circle {
            centre: frame.place(*x, *y),
            radius: 2.5,
            fill: Some(Role::Model.color()),
            pen: None,
        });
    }
    let (at, added): (Vec<f64>, Vec<f64>) = knots.iter().map(|[x, y]| (x, y)).unzip();
    scene.lines(curve(&frame, &at, &added).lines, pen(Role::Model));
    border(&mut scene, &frame, &x, &y, true, true);
    time_label(
        &mut scene,
        LEFT,
        frame.right(),
        frame.bottom() + 2.6 * TEXT,
        &label,
    );
    html.picture(
        &scene,
        &format!("The correction along the {along}"),
        "Linear between knots; estimated on the whole recording.",
    );
}
