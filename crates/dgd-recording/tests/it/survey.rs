use crate::wells::{column, table};
use dgd_recording::{Column, Run, Table, quantum, survey, survey_clock};

#[test]
fn a_column_is_summed_up_in_its_own_unit() {
    let values: Vec<f64> = (0..200)
        .map(|i| match i {
            50..=79 => 3.5,
            90 => f64::NAN,
            i => 0.5 * f64::from(i * 7 % 11),
        })
        .collect();
    let mut table = table(&(0..200).map(f64::from).collect::<Vec<_>>());
    table.columns.push(column("extra", "wombat", &values));
    let surveyed = survey(&table);
    let extra = surveyed.columns.last().unwrap();
    assert_eq!((extra.samples, extra.missing), (200, 1));
    assert_eq!(extra.range, Some((0.0, 3.0, 5.0)));
    assert_eq!(extra.quantum, Some(2.0));
    let run = Run {
        start: 50,
        length: 30,
        value: 3.5,
    };
    assert_eq!(extra.longest_run, Some(run));
    assert!((extra.repeated_share - 29.0 / 199.0).abs() < 1e-12);
    assert_eq!(extra.unit, None);
    assert_eq!(extra.unit_written.as_deref(), Some("wombat"));
    assert_eq!(surveyed.time_column, Some(0));
    assert_eq!(surveyed.clock.unwrap().unwrap().step_s, 1.0);
}

#[test]
fn a_decimal_quantum_is_found_under_rounding() {
    // Tenths are no binary numbers, and neither are their products with a unit's factor.
    for factor in [1.0, 6.3090e-5, 6894.75729] {
        let mut state = 1u64;
        let values: Vec<f64> = (0..5000)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 57) as f64 / 10.0 * factor
            })
            .collect();
        let found = quantum(&values).unwrap();
        assert!(
            (found / (0.1 * factor) - 1.0).abs() < 1e-6,
            "{factor}: {found}"
        );
    }
}

#[test]
fn a_value_that_hardly_changes_has_no_quantum() {
    assert_eq!(quantum(&[1.0; 1000]), None);
    assert_eq!(quantum(&[]), None);
    assert_eq!(quantum(&[f64::NAN; 1000]), None);
}

#[test]
fn time_is_found_by_name_then_unit_then_growth() {
    let find = |columns: Vec<Column>| {
        survey(&Table {
            columns,
            ..Table::default()
        })
        .time_column
    };
    let grows = [1.0, 2.0, 3.0];
    let idle = [5.0, 5.0, 5.0];
    assert_eq!(
        find(vec![
            column("depth", "m", &grows),
            column("rig.Time [s]", "", &grows)
        ]),
        Some(1)
    );
    assert_eq!(
        find(vec![
            column("depth", "m", &grows),
            column("x", "min", &grows)
        ]),
        Some(1)
    );
    assert_eq!(
        find(vec![column("a", "1", &idle), column("b", "1", &grows)]),
        Some(1)
    );
    assert_eq!(find(vec![column("a", "1", &idle)]), None);
}

#[test]
fn a_suffix_names_a_column_only_if_it_is_the_only_one() {
    let table = table(&[0.0, 1.0]);
    assert_eq!(table.find("FT4"), Some(4));
    assert_eq!(table.find("gom.FT4"), Some(4));
    assert_eq!(table.find("T4"), None);
    assert_eq!(table.rows(), 2);
}

#[test]
fn a_clock_that_was_set_back_is_told_with_the_place() {
    let hour = |from: i32| (0..3600).map(move |i| f64::from(from + i));
    let set_back: Vec<f64> = hour(0).chain(hour(0)).chain(hour(3600)).collect();
    let clock = survey_clock(&set_back).unwrap();
    assert_eq!((clock.backward, clock.duplicates), (1, 3600));
    assert_eq!(clock.furthest_back_s, Some((3599.0, 3599.0)));
    let told: Vec<String> = clock.issues().iter().map(ToString::to_string).collect();
    let place = "time runs backwards 1 time, furthest by 3599 s after 3599 s";
    assert!(told.iter().any(|t| t.contains(place)), "{told:?}");
    assert!(
        told.iter().any(|t| t.ends_with("was the clock set back?")),
        "{told:?}"
    );

    // Rows from the newest to the oldest, one of them twice, are no clock that was set back.
    let mut reversed: Vec<f64> = hour(0).collect();
    reversed.reverse();
    reversed.insert(7, reversed[7]);
    let told = survey_clock(&reversed).unwrap().issues();
    assert!(
        told.iter().all(|t| !t.message.contains("set back")),
        "{told:?}"
    );
}
