//! Drawings of assemblies, rankings, and series over another variable than time.

use dgd_report::{
    Axis, Diagram, DrawnComponent, DrawnInstrument, DrawnLink, Ranked, ReportError, Role, Series,
    Symbol, TimePanel, WithinBounds, assembly_drawing, ranking, series_over, within_bounds,
};

const SYMBOLS: [Symbol; 10] = [
    Symbol::Tank,
    Symbol::Volume,
    Symbol::Line,
    Symbol::CentrifugalPump,
    Symbol::DisplacementPump,
    Symbol::Valve,
    Symbol::Orifice,
    Symbol::Boundary,
    Symbol::Junction,
    Symbol::Atmosphere,
];

fn part(name: &str, symbol: Symbol) -> DrawnComponent {
    DrawnComponent {
        name: name.into(),
        symbol,
        notes: vec!["length 30 m".into()],
        marks: vec!["free: roughness".into()],
        instruments: vec![DrawnInstrument {
            letters: "PT".into(),
            label: format!("{name} pressure [bar]"),
        }],
    }
}

fn link(from: usize, to: usize) -> DrawnLink {
    DrawnLink {
        from,
        to,
        leaves: "suction".into(),
        enters: String::new(),
    }
}

/// Every `<text>` with its place and words.
fn texts(svg: &str) -> Vec<(f64, f64, String)> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let texts = document.descendants().filter(|n| n.has_tag_name("text"));
    texts
        .map(|n| {
            let number = |key: &str| n.attribute(key).unwrap().parse().unwrap();
            (
                number("x"),
                number("y"),
                n.text().unwrap_or_default().to_owned(),
            )
        })
        .collect()
}

#[test]
fn every_component_is_drawn_within_the_picture_and_beside_no_other() {
    let components: Vec<DrawnComponent> = SYMBOLS
        .iter()
        .enumerate()
        .map(|(i, s)| part(&format!("part{i}"), *s))
        .collect();
    let links = (0..9)
        .map(|i| link(i, i + 1))
        .chain([link(2, 7), link(8, 1)])
        .collect();
    let diagram = Diagram {
        components,
        links,
        caption: "Ten parts.".into(),
    };
    let figure = assembly_drawing(&diagram).unwrap();
    let texts = texts(&figure.svg());
    let (width, height) = figure.size();
    let mut names: Vec<f64> = Vec::new();
    for i in 0..10 {
        let name = format!("part{i}");
        let found: Vec<_> = texts.iter().filter(|t| t.2 == name).collect();
        assert_eq!(found.len(), 1, "{name}");
        let (x, y, _) = found[0];
        assert!((0.0..width).contains(x) && (0.0..height).contains(y));
        names.push(*y);
    }
    // Downwards, one row a part.
    assert!(
        names.windows(2).all(|pair| pair[1] - pair[0] > 40.0),
        "{names:?}"
    );
    assert_eq!(figure.png(1.0).unwrap()[1..4], *b"PNG");
}

#[test]
fn a_drawing_holds_whatever_words_and_circles_it_is_given() {
    let long = "x<&>\"".repeat(200);
    let mut wild = part(&long, Symbol::Tank);
    wild.notes = vec![long.clone(); 5];
    let diagram = Diagram {
        components: vec![wild, part("b", Symbol::Valve)],
        links: vec![link(0, 0), link(0, 1), link(1, 0), link(0, 1)],
        caption: long,
    };
    let svg = assembly_drawing(&diagram).unwrap().svg();
    roxmltree::Document::parse(&svg).unwrap();
    assert!(assembly_drawing(&Diagram::default()).is_ok());
}

#[test]
fn a_connection_to_nothing_and_too_many_components_are_refused() {
    let diagram = Diagram {
        components: vec![part("a", Symbol::Tank)],
        links: vec![link(0, 3)],
        ..Diagram::default()
    };
    assert!(matches!(
        assembly_drawing(&diagram),
        Err(ReportError::Length {
            expected: 4,
            found: 1,
            ..
        })
    ));
    let crowd = Diagram {
        components: vec![part("a", Symbol::Tank); 401],
        ..Diagram::default()
    };
    assert!(matches!(
        assembly_drawing(&crowd),
        Err(ReportError::TooMany { found: 401, .. })
    ));
}

#[test]
fn a_ranking_stands_from_the_largest_down_and_bears_what_is_no_number() {
    let row = |label: &str, value| Ranked {
        label: label.into(),
        value,
        note: String::new(),
    };
    let rows = [row("small", 0.1), row("none", f64::NAN), row("large", 2.0)];
    let figure = ranking(&rows, &Axis::new("Importance")).unwrap();
    let texts = texts(&figure.svg());
    let y = |name: &str| texts.iter().find(|t| t.2 == name).unwrap().1;
    assert!(y("large") < y("small") && y("small") < y("none"));
    assert!(figure.caption().contains("large"));
    assert!(
        ranking(&[], &Axis::new("Importance"))
            .unwrap()
            .caption()
            .contains("Nothing")
    );
    let many = vec![row("a", 1.0); 201];
    assert!(matches!(
        ranking(&many, &Axis::new("")),
        Err(ReportError::TooMany { .. })
    ));
}

#[test]
fn an_estimate_stands_between_its_bounds_whatever_its_interval() {
    let row = |interval, value| WithinBounds {
        label: "c".into(),
        value,
        interval,
        bounds: (0.0, 1.0),
        note: "0.5 m".into(),
    };
    let endless = (f64::NEG_INFINITY, f64::INFINITY);
    let rows = [
        row((0.4, 0.6), 0.5),
        row(endless, 0.5),
        row((f64::NAN, 2.0), -7.0),
    ];
    let svg = within_bounds(&rows).unwrap().svg();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let places: Vec<f64> = document
        .descendants()
        .filter(|n| n.has_tag_name("circle"))
        .map(|n| n.attribute("cx").unwrap().parse().unwrap())
        .collect();
    assert_eq!(places[0], places[1]);
    assert!(places[2] < places[0] && places[2] > 0.0);
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn a_series_over_depth_says_depth() {
    let (depth, value) = ([100.0, 20_000.0], [1.0, 2.0]);
    let series = [Series {
        label: "Measured",
        role: Role::Measured,
        time_s: &depth,
        value: &value,
    }];
    let panel = [TimePanel {
        axis: Axis::new("Pressure [bar]"),
        title: "",
        series: &series,
    }];
    let figure = series_over(&Axis::new("Depth [ft]"), &panel, &[], "Along the well.").unwrap();
    assert!(figure.svg().contains("Depth [ft]") && !figure.svg().contains("Time"));
    assert_eq!(figure.caption(), "Along the well.");
}
