use crate::figures;
use crate::synthetic::Noise;
use dgd_report::{Axis, Role, Scatter, Series, TimePanel, all_samples, time_series};

const MEGABYTE: usize = 1_000_000;

/// Well-formed, and every number in a geometry attribute finite and near the paper.
pub(crate) fn assert_sound(name: &str, svg: &str) {
    let document = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{name}: {e}"));
    let root = document.root_element();
    let size = |key: &str| root.attribute(key).unwrap().parse::<f64>().unwrap();
    let most = size("width").max(size("height"));
    for node in document.descendants().filter(roxmltree::Node::is_element) {
        // Points are in units of their cell, half a unit of the paper where few.
        let scale = if node
            .attribute("transform")
            .is_some_and(|t| t.contains("scale(0.5)"))
        {
            2.0
        } else {
            1.0
        };
        for attribute in node.attributes() {
            if !matches!(
                attribute.name(),
                "d" | "x" | "y" | "cx" | "cy" | "r" | "width" | "height" | "transform"
            ) {
                continue;
            }
            let numbers = attribute.value().split(|c: char| {
                !matches!(c, '0'..='9' | '.' | '-' | 'e' | 'n' | 'N' | 'i' | 'a' | 'f')
            });
            // Words such as "translate" leave letters behind; no number of ours holds any.
            for number in numbers.filter(|n| n.contains(|c: char| c.is_ascii_digit())) {
                let value: f64 = number
                    .parse()
                    .unwrap_or_else(|_| panic!("{name}: `{number}`"));
                assert!(
                    value.is_finite() && value.abs() <= scale * most + 10.0,
                    "{name}: {number} in {}",
                    attribute.name()
                );
            }
            let lower = attribute.value().to_lowercase();
            assert!(
                !lower.contains("nan") && !lower.contains("inf"),
                "{name}: {lower}"
            );
        }
    }
}

#[test]
fn every_figure_is_well_formed_with_finite_coordinates() {
    for (name, figure) in figures::all(20_000) {
        assert_sound(name, &figure.svg());
        assert_sound(name, &figure.captioned().svg());
    }
}

#[test]
fn every_figure_of_305_820_samples_stays_below_a_megabyte() {
    for (name, figure) in figures::all(305_820) {
        let bytes = figure.svg().len();
        assert!(bytes < MEGABYTE, "{name}: {bytes} bytes");
    }
}

#[test]
fn noise_that_fills_the_frame_stays_below_a_megabyte() {
    let mut noise = Noise::new(1);
    for n in [30_000, 100_000, 305_820] {
        let (x, y): (Vec<f64>, Vec<f64>) = (0..n).map(|_| (noise.even(), noise.even())).unzip();
        let figure =
            all_samples(Scatter { x: &x, y: &y }, &Axis::new("x"), &Axis::new("y")).unwrap();
        let bytes = figure.svg().len();
        assert!(bytes < MEGABYTE, "{n} samples: {bytes} bytes");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    for ((name, one), (_, other)) in figures::all(5_000).into_iter().zip(figures::all(5_000)) {
        assert_eq!(one.svg(), other.svg(), "{name}");
        assert_eq!(one.png(1.0).unwrap(), other.png(1.0).unwrap(), "{name}");
    }
}

#[test]
fn a_figure_holds_no_id_script_or_reference() {
    for (name, figure) in figures::all(5_000) {
        let svg = figure.svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        for node in document.descendants().filter(roxmltree::Node::is_element) {
            assert!(
                !matches!(node.tag_name().name(), "script" | "image" | "use" | "style"),
                "{name}"
            );
            for attribute in node.attributes() {
                assert!(
                    !matches!(attribute.name(), "id" | "href" | "class"),
                    "{name}"
                );
                assert!(!attribute.value().contains("url("), "{name}");
            }
        }
    }
}

#[test]
fn labels_and_captions_are_escaped() {
    let x = [1.0, 2.0];
    let figure = all_samples(
        Scatter { x: &x, y: &x },
        &Axis::new("<x> & \"y\""),
        &Axis::new("a < b"),
    )
    .unwrap();
    let svg = figure.captioned().svg();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<&str> = document
        .descendants()
        .filter(|n| n.has_tag_name("text"))
        .filter_map(|n| n.text())
        .collect();
    assert!(
        texts.contains(&"<x> & \"y\"") && texts.contains(&"a < b"),
        "{texts:?}"
    );
}

#[test]
fn text_in_the_figure_is_text() {
    let svg = figures::all(2_000).remove(0).1.svg();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<&str> = document
        .descendants()
        .filter(|n| n.has_tag_name("text"))
        .filter_map(|n| n.text())
        .collect();
    for wanted in [
        "Return flow [%]",
        "Frictional pressure loss [%]",
        "60",
        "−40",
    ] {
        assert!(texts.contains(&wanted), "{wanted} in {texts:?}");
    }
}

#[test]
fn readings_with_gaps_between_them_are_dots() {
    let time_s: Vec<f64> = (0..120).map(f64::from).collect();
    let every = |step: usize| -> Vec<f64> {
        let value = |i: usize| (0.1 * i as f64).sin();
        (0..120)
            .map(|i| if i % step == 0 { value(i) } else { f64::NAN })
            .collect()
    };
    let model = every(1);
    let drawn = |measured: &[f64]| {
        let series =
            [(Role::Measured, measured), (Role::Model, &model)].map(|(role, value)| Series {
                label: "Level",
                role,
                time_s: &time_s,
                value,
            });
        let panel = TimePanel {
            axis: Axis::new("Level [m]"),
            title: "",
            series: &series,
        };
        time_series(&[panel], &[]).unwrap().svg()
    };
    let (lone, joined) = (drawn(&every(10)), drawn(&every(1)));
    assert_sound("lone", &lone);
    let dots = |svg: &str| svg.matches("stroke-linecap=\"round\"").count();
    assert_eq!((dots(&lone), dots(&joined)), (1, 0));
    // In the key as well.
    let keys = |svg: &str| svg.matches("<circle").count();
    assert_eq!((keys(&lone), keys(&joined)), (1, 0));
}
