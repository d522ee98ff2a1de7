use dgd_report::{Axis, Figure, ReportError, Scatter, all_samples};
use tiny_skia::Pixmap;

use crate::figures;

fn decoded(figure: &Figure, scale: f64) -> Pixmap {
    Pixmap::decode_png(&figure.png(scale).unwrap()).unwrap()
}

/// Pixels darker than half in a part of the picture, given in shares of its size.
fn ink(map: &Pixmap, x: [f64; 2], y: [f64; 2]) -> usize {
    let (w, h) = (f64::from(map.width()), f64::from(map.height()));
    let inside = |at: u32, share: [f64; 2], size: f64| {
        let at = f64::from(at) + 0.5;
        at >= share[0] * size && at <= share[1] * size
    };
    (0..map.height())
        .flat_map(|py| (0..map.width()).map(move |px| (px, py)))
        .filter(|&(px, py)| inside(px, x, w) && inside(py, y, h))
        .filter(|&(px, py)| map.pixel(px, py).unwrap().green() < 128)
        .count()
}

fn with_label(label: &str) -> Figure {
    let x = [0.0, 50.0, 100.0];
    all_samples(Scatter { x: &x, y: &x }, &Axis::new(label), &Axis::new("y")).unwrap()
}

#[test]
fn every_png_has_the_expected_size_and_is_not_blank() {
    for (name, figure) in figures::all(5_000) {
        let (width, height) = figure.size();
        for scale in [0.5, 1.0, 2.0] {
            let map = decoded(&figure, scale);
            let size = [f64::from(map.width()), f64::from(map.height())];
            assert_eq!(
                size,
                [(width * scale).round(), (height * scale).round()],
                "{name}"
            );
        }
        assert!(
            ink(&decoded(&figure, 1.0), [0.0, 1.0], [0.0, 1.0]) > 200,
            "{name}"
        );
    }
}

/// The foot of the picture holds the label and nothing else that is dark.
#[test]
fn the_label_is_drawn_letter_by_letter() {
    let foot = |label: &str| ink(&decoded(&with_label(label), 2.0), [0.0, 1.0], [0.955, 1.0]);
    let (none, one, ten) = (foot(""), foot("M"), foot("MMMMMMMMMM"));
    assert_eq!(none, 0);
    assert!(one > 40, "{one}");
    // Anti-aliasing differs from letter to letter.
    assert!((8 * one..=12 * one).contains(&ten), "{one} and {ten}");
}

#[test]
fn the_letters_of_a_label_stand_in_its_place() {
    let map = decoded(&with_label("Return flow [%]"), 2.0);
    assert!(ink(&map, [0.40, 0.70], [0.955, 1.0]) > 300);
    assert_eq!(ink(&map, [0.0, 0.35], [0.955, 1.0]), 0);
}

#[test]
fn no_ink_touches_the_edge_of_the_paper() {
    let long = "A label that goes on and on about the quantity it names, its unit, its origin and its history [%]";
    let x = [0.0, 1e9];
    let stretched =
        all_samples(Scatter { x: &x, y: &x }, &Axis::new(long), &Axis::new(long)).unwrap();
    let mut all = figures::all(5_000);
    all.push(("stretched", stretched));
    for (name, figure) in all {
        let map = decoded(&figure.captioned(), 1.0);
        let edge =
            |px: u32, py: u32| px < 2 || py < 2 || px + 2 >= map.width() || py + 2 >= map.height();
        for (px, py) in (0..map.height()).flat_map(|py| (0..map.width()).map(move |px| (px, py))) {
            assert!(
                !edge(px, py) || map.pixel(px, py).unwrap().green() > 240,
                "{name} at {px}, {py}"
            );
        }
    }
}

#[test]
fn a_scale_without_a_picture_is_refused() {
    let figure = with_label("x");
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e3] {
        assert!(
            matches!(figure.png(scale), Err(ReportError::Scale { .. })),
            "{scale}"
        );
    }
}

#[test]
fn a_caption_makes_the_figure_taller() {
    let figure = with_label("x");
    let captioned = figure.captioned();
    assert_eq!(captioned.size().0, figure.size().0);
    assert!(captioned.size().1 > figure.size().1 + 15.0);
    assert!(ink(&decoded(&captioned, 1.0), [0.0, 1.0], [0.95, 1.0]) > 100);
}
