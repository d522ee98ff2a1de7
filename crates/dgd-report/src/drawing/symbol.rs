//! Symbols after ISO 10628-2, as far as they are known beyond its readers.

use super::Symbol;
use crate::color::{Color, INK, PAPER, Role, SOFT_INK, tone};
use crate::scene::{Pen, Scene};

pub(super) const HEIGHT: f64 = 44.0;
const STROKE: f64 = 1.8;
const WATER: Color = Color(0xcf, 0xe2, 0xf5);

/// Height of a symbol: where pipes enter and leave it.
pub(super) fn height(symbol: Symbol) -> f64 {
    match symbol {
        Symbol::Junction => 8.0,
        Symbol::Orifice => 20.0,
        Symbol::Atmosphere | Symbol::Boundary => 26.0,
        Symbol::CentrifugalPump | Symbol::DisplacementPump => 36.0,
        Symbol::Valve => 32.0,
        Symbol::Tank | Symbol::Volume | Symbol::Line => HEIGHT,
    }
}

/// Width of a symbol at its middle: where an instrument is tied to it.
pub(super) fn width(symbol: Symbol) -> f64 {
    match symbol {
        Symbol::Tank => 40.0,
        Symbol::CentrifugalPump | Symbol::DisplacementPump => 36.0,
        Symbol::Orifice => 34.0,
        Symbol::Boundary => 32.0,
        Symbol::Volume => 30.0,
        Symbol::Line => 12.0,
        Symbol::Junction => 10.0,
        Symbol::Valve | Symbol::Atmosphere => 4.0,
    }
}

pub(super) fn draw(scene: &mut Scene, symbol: Symbol, [x, y]: [f64; 2]) {
    let pen = Pen::new(INK, STROKE);
    let half = height(symbol) / 2.0;
    let (top, bottom) = (y - half, y + half);
    match symbol {
        Symbol::Tank => {
            let (l, r) = (x - 20.0, x + 20.0);
            scene.rect([l, top], [40.0, HEIGHT], PAPER);
            scene.rect([l, y - 6.0], [40.0, bottom - y + 6.0], WATER);
            let surface = Pen::new(Role::Model.color(), 1.4);
            scene.line([l, y - 6.0], [r, y - 6.0], surface);
            scene.polygon(
                vec![[x - 4.0, y - 13.0], [x + 4.0, y - 13.0], [x, y - 7.0]],
                Role::Model.color(),
            );
            scene.lines(
                vec![vec![[l, top], [l, bottom], [r, bottom], [r, top]]],
                pen,
            );
        }
        Symbol::Volume => {
            let outline = capsule(x, y, 15.0, half);
            scene.polygon(outline.clone(), WATER);
            scene.lines(vec![outline], pen);
        }
        Symbol::Line => {
            scene.rect([x - 6.0, top], [12.0, HEIGHT], tone(INK, 0.12));
            let walls = [-6.0, 6.0].map(|d| vec![[x + d, top], [x + d, bottom]]);
            scene.lines(walls.to_vec(), pen);
        }
        Symbol::CentrifugalPump => {
            scene.ring([x, y], half, pen);
            // The impeller's triangle points the way the fluid goes.
            let side = half * 0.866;
            let triangle = vec![
                [x - side, y - half / 2.0],
                [x + side, y - half / 2.0],
                [x, bottom],
            ];
            closed(scene, triangle, pen);
        }
        Symbol::DisplacementPump => {
            scene.ring([x, y], half, pen);
            let rod = vec![
                vec![[x, top], [x, y - 4.0]],
                vec![[x - 11.0, y - 4.0], [x + 11.0, y - 4.0]],
            ];
            scene.lines(rod, pen);
            let cylinder = vec![
                [x - 11.0, y - 10.0],
                [x - 11.0, y + 9.0],
                [x + 11.0, y + 9.0],
                [x + 11.0, y - 10.0],
            ];
            scene.lines(vec![cylinder], pen);
        }
        Symbol::Valve => {
            let bow = [
                vec![[x - 12.0, top], [x + 12.0, top], [x, y], [x - 12.0, top]],
                vec![
                    [x - 12.0, bottom],
                    [x + 12.0, bottom],
                    [x, y],
                    [x - 12.0, bottom],
                ],
            ];
            for triangle in bow {
                scene.polygon(triangle.clone(), PAPER);
                scene.lines(vec![triangle], pen);
            }
        }
        Symbol::Orifice => {
            scene.line([x, top], [x, bottom], pen);
            let plates = vec![
                vec![[x - 17.0, y], [x - 4.0, y]],
                vec![[x + 4.0, y], [x + 17.0, y]],
            ];
            scene.rect([x - 3.0, y - 3.0], [6.0, 6.0], PAPER);
            scene.lines(plates, Pen::new(INK, 3.6));
        }
        Symbol::Boundary => {
            let flag = vec![
                [x - 16.0, top],
                [x + 16.0, top],
                [x + 16.0, y + 2.0],
                [x, bottom],
                [x - 16.0, y + 2.0],
            ];
            closed(scene, flag, pen);
        }
        Symbol::Junction => scene.dot([x, y], 5.0, INK),
        Symbol::Atmosphere => {
            let air = [0.0, 1.0, 2.0].map(|k| {
                let (half, y) = (15.0 - 4.5 * k, y - 4.0 + 6.0 * k);
                vec![[x - half, y], [x + half, y]]
            });
            scene.line([x, top], [x, y - 4.0], pen);
            scene.line([x, y + 8.0], [x, bottom], Pen::new(PAPER, 1.0));
            scene.lines(air.to_vec(), Pen::new(SOFT_INK, STROKE));
        }
    }
}

fn closed(scene: &mut Scene, mut points: Vec<[f64; 2]>, pen: Pen) {
    scene.polygon(points.clone(), PAPER);
    points.extend(points.first().copied());
    scene.lines(vec![points], pen);
}

/// An upright vessel with round ends.
fn capsule(x: f64, y: f64, radius: f64, half: f64) -> Vec<[f64; 2]> {
    let arc = |from: f64, at: f64| {
        (0..=12).map(move |k| {
            let angle = from + std::f64::consts::PI * f64::from(k) / 12.0;
            [x + radius * angle.cos(), at + radius * angle.sin()]
        })
    };
    let mut points: Vec<[f64; 2]> = arc(std::f64::consts::PI, y - half + radius).collect();
    points.extend(arc(0.0, y + half - radius));
    points.extend(points.first().copied());
    points
}
