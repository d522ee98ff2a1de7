use dgd_units::{Density, Dimension, FlowRate, Length, Pressure, Unit, UnitError, split_number};
use proptest::prelude::*;

#[test]
fn table_2_3_is_met_exactly() {
    assert_eq!(Unit::parse("gpm").unwrap().to_si(1.0), 6.3090e-5);
    assert_eq!(Unit::parse("psi").unwrap().to_si(1.0), 6894.75729);
    assert_eq!(Unit::parse("inch").unwrap().to_si(1.0), 0.0254);
}

#[test]
fn the_units_of_the_rig_floor_have_their_defined_values() {
    let cases = [
        ("sg", 1.08, 1080.0),
        ("m", 350.3, 350.3),
        ("ft", 10.0, 3.048),
        ("bar", 2.0, 2e5),
        ("kPa", 3.0, 3e3),
        ("l/min", 60_000.0, 1.0),
        ("bbl", 1.0, 0.158_987_294_928),
        ("%", 65.2, 65.2),
        ("ppg", 8.345_404_452_021, 1000.0),
        ("degF", 212.0, 373.15),
        ("klb", 1.0, 4_448.221_615_260_5),
    ];
    for (unit, value, si) in cases {
        let got = Unit::parse(unit).unwrap().to_si(value);
        assert!(
            (got - si).abs() <= 1e-9 * si.abs(),
            "{value} {unit} = {got}, expected {si}"
        );
    }
}

#[test]
fn gauge_pressure_adds_one_atmosphere_and_absolute_does_not() {
    assert_eq!(Unit::parse("psig").unwrap().to_si(0.0), 101_325.0);
    assert_eq!(Unit::parse("psia").unwrap().to_si(0.0), 0.0);
    assert_eq!(Unit::parse("bar(g)").unwrap().to_si(1.0), 201_325.0);
    for (absolute, gauge, one_pa) in [
        ("MPaa", "MPag", 1e6),
        ("MPa(a)", "MPa(g)", 1e6),
        ("mbara", "mbarg", 1e2),
        ("mbar(abs)", "mbar(g)", 1e2),
    ] {
        assert_eq!(Unit::parse(absolute).unwrap().to_si(1.0), one_pa);
        assert_eq!(Unit::parse(gauge).unwrap().to_si(1.0), 101_325.0 + one_pa);
    }
}

#[test]
fn the_si_unit_of_a_dimension_is_what_its_symbol_names() {
    for unit in Unit::known() {
        let si = Unit::si(unit.dimension);
        assert_eq!(Unit::parse(unit.dimension.si_symbol()), Ok(si));
    }
}

#[test]
fn case_spaces_brackets_and_superscripts_do_not_count() {
    for (written, symbol) in [
        ("[PSI]", "psi"),
        ("L / min", "l/min"),
        ("m³/s", "m3/s"),
        ("KG/M3", "kg/m3"),
    ] {
        assert_eq!(Unit::parse(written).unwrap().symbol, symbol);
    }
}

#[test]
fn millipascal_is_refused_because_megapascal_differs_by_case_alone() {
    for spelling in [
        "mPa", "[mPa]", " m Pa ", "mPag", "mPa(g)", "mPaa", "mPa(abs)",
    ] {
        assert!(Unit::parse(spelling).is_err(), "{spelling}");
    }
    let error = Unit::parse("mPa(g)").unwrap_err();
    assert!(error.to_string().contains("`MPag`"), "{error}");
    assert_eq!(Unit::parse("mPa.s").unwrap().symbol, "cP");
    let error = Unit::parse("mPa").unwrap_err();
    assert!(error.to_string().contains("`MPa`"), "{error}");
    assert_eq!(Unit::parse("MPa").unwrap().factor, 1e6);
}

#[test]
fn a_misspelt_unit_is_refused_with_the_nearest_one() {
    let error = Unit::parse("gmp").unwrap_err();
    assert!(matches!(error, UnitError::UnknownUnit { .. }));
    assert_eq!(
        Unit::parse("psiaa").unwrap_err(),
        UnitError::UnknownUnit {
            found: "psiaa".into(),
            suggestion: Some("psia")
        }
    );
}

#[test]
fn a_unit_of_something_else_is_refused_with_both_dimensions() {
    let error = Unit::parse_as("psi", Dimension::FlowRate).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`psi` is a unit of pressure, expected a unit of flow rate such as `gpm`"
    );
}

#[test]
fn written_values_are_read_with_decimals_and_fractions() {
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs().max(1.0), "{a} {b}");
    close(Length::parse("19.5 in").unwrap().si(), 0.4953);
    close(Length::parse("13 5/8 in").unwrap().si(), 0.346_075);
    close(Length::parse("-13 5/8 in").unwrap().si(), -0.346_075);
    close(Length::parse("-0 1/2 in").unwrap().si(), -0.0127);
    close(Length::parse("5/8in").unwrap().si(), 0.015_875);
    close(Length::parse("350.30 mRKB").unwrap().si(), 350.3);
    close(Density::parse("1.080 sg").unwrap().si(), 1080.0);
    close(FlowRate::parse("1e3 l/min").unwrap().si(), 1.0 / 60.0);
    close(Pressure::parse("1 bar(g)").unwrap().si(), 201_325.0);
}

#[test]
fn a_bare_number_and_a_bare_unit_are_refused() {
    assert!(matches!(
        Length::parse("19.5"),
        Err(UnitError::NoUnit { .. })
    ));
    assert!(matches!(
        Length::parse("in"),
        Err(UnitError::NoNumber { .. })
    ));
    assert!(matches!(
        Length::parse("1e999 in"),
        Err(UnitError::NoNumber { .. })
    ));
    assert!(matches!(Length::parse(""), Err(UnitError::NoNumber { .. })));
}

#[test]
fn a_quantity_converts_to_units_of_its_own_dimension_only() {
    let length = Length::from_si(0.254);
    assert!((length.to_unit(Unit::parse("in").unwrap()).unwrap() - 10.0).abs() < 1e-12);
    assert!(length.to_unit(Unit::parse("psi").unwrap()).is_err());
    assert_eq!(length.to_string(), "0.254 m");
}

#[test]
fn a_quantity_is_given_in_the_unit_that_was_passed_and_not_in_its_namesake() {
    let from_seabed = Unit {
        offset: 350.0,
        factor: 2.0,
        ..Unit::parse("m").unwrap()
    };
    let depth = Length::from_si(400.0);
    assert_eq!(depth.to_unit(from_seabed), Ok(25.0));
    let speed = Unit::parse("m").unwrap().in_percent_of(500.0).unwrap();
    assert_eq!(
        depth.to_unit(speed).unwrap_err().to_string(),
        "`m` is a unit of percent, expected a unit of length such as `m`"
    );
}

#[test]
fn strokes_are_a_flow_by_their_volume() {
    let spm = Unit::parse("strokes/min").unwrap();
    let pump = spm.in_flow_of(0.0159).unwrap();
    assert_eq!(pump.dimension, Dimension::FlowRate);
    assert!((pump.to_si(100.0) - 0.0265).abs() < 1e-15);
    assert!(pump.counts_turns() && spm.counts_turns());
    assert!(!Unit::parse("gpm").unwrap().counts_turns());
    for stroke_m3 in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        let error = spm.in_flow_of(stroke_m3).unwrap_err();
        assert!(matches!(error, UnitError::Stroke { .. }), "{stroke_m3}");
    }
    let error = Unit::parse("gpm").unwrap().in_flow_of(0.0159).unwrap_err();
    assert!(matches!(error, UnitError::WrongDimension { .. }), "{error}");
}

#[test]
fn what_cannot_be_100_percent_is_refused() {
    let rpm = Unit::parse("rpm").unwrap();
    for full in [0.0, -0.0, -1800.0, f64::NAN, f64::INFINITY, 1e-320] {
        let error = rpm.in_percent_of(full).unwrap_err();
        assert!(matches!(error, UnitError::Full { .. }), "{full}");
    }
}

#[test]
fn units_and_quantities_are_parsed_as_the_standard_library_does() {
    assert_eq!("gal/min".parse(), Unit::parse("gpm"));
    assert_eq!("600 gpm".parse(), FlowRate::parse("600 gpm"));
    assert_eq!("14.7 psia".parse(), Pressure::parse("14.7 psia"));
    assert_eq!("1.08 sg".parse(), Density::parse("1.08 sg"));
    assert_eq!("19.5".parse::<Length>(), Length::parse("19.5"));
}

proptest! {
    #[test]
    fn to_si_and_back_is_the_identity(value in -1e6f64..1e6, index in 0usize..60) {
        let units: Vec<Unit> = Unit::known().collect();
        let unit = units[index % units.len()];
        let back = unit.from_si(unit.to_si(value));
        // An offset (gauge, degrees) costs the digits below its own size.
        let scale = value.abs() + (unit.offset / unit.factor).abs();
        prop_assert!((back - value).abs() <= 4.0 * f64::EPSILON * scale);
    }

    #[test]
    fn no_text_makes_the_parsers_panic(text in "\\PC{0,24}") {
        let _ = Unit::parse(&text);
        let _ = Length::parse(&text);
        let _ = split_number(&text);
    }
}
