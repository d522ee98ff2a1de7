//! A table that comes in blocks is surveyed as one that is there at once.

use dgd_recording::{BlockSurvey, Column, Table, survey};
use proptest::prelude::*;

fn column(tag: &str, unit: Option<&str>, values: Vec<f64>) -> Column {
    Column {
        tag: tag.into(),
        unit: unit.map(Into::into),
        values,
    }
}

/// Compares the surveys; returns the passes that the one in blocks took.
fn compare(columns: &[Column], rows: usize) -> usize {
    let table = |from: usize, to: usize| Table {
        columns: (columns.iter())
            .map(|c| Column {
                values: c.values[from..to].to_vec(),
                ..c.clone()
            })
            .collect(),
        ..Table::default()
    };
    let all = columns[0].values.len();
    let mut blocks = BlockSurvey::new(&table(0, 0));
    let mut passes = 0;
    loop {
        passes += 1;
        for from in (0..all).step_by(rows) {
            blocks.add(&table(from, all.min(from + rows)));
        }
        if !blocks.next_pass() {
            break;
        }
    }
    let expected = survey(&table(0, all));
    let found = blocks.finish();
    // As text, in which NaN is itself and no bit is lost.
    assert_eq!(format!("{found:?}"), format!("{expected:?}"));
    passes
}

#[test]
fn long_recordings_are_surveyed_alike_in_few_passes() {
    let n = 300_000;
    let values = |f: &dyn Fn(f64) -> f64| (0..n).map(|i| f(f64::from(i))).collect::<Vec<_>>();
    let others = [
        column("FT4", Some("gpm"), values(&|t| (0.001 * t).sin() * 800.0)),
        column("speed", Some("%"), values(&|t| (t / 600.0).floor() % 90.0)),
        column(
            "PT1",
            None,
            values(&|t| {
                if t % 5.0 < 2.0 {
                    f64::NAN
                } else {
                    (t * 0.7).cos()
                }
            }),
        ),
        column("dead", None, values(&|_| f64::NAN)),
    ];
    let wobble = |t: f64| t + 0.2 * (17.0 * t).sin();
    let back = |t: f64| {
        if (500.0..700.0).contains(&t) {
            t - 250.5
        } else {
            t
        }
    };
    let gaps = |t: f64| t + 3600.0 * (t / 50_000.0).floor();
    type Clock<'a> = (&'a str, &'a dyn Fn(f64) -> f64, usize);
    let clocks: [Clock<'_>; 6] = [
        ("even", &|t| t, 2),
        ("in tenths", &|t| 0.1 * t, 6),
        ("jitters", &wobble, 6),
        ("set back", &back, 3),
        ("with gaps", &gaps, 6),
        ("stands", &|_| 7.0, 2),
    ];
    for (name, clock, most) in clocks {
        for (tag, unit) in [("t", Some("min")), ("rising", None)] {
            let mut columns = vec![column(tag, unit, values(clock))];
            columns.extend(others.iter().cloned());
            let passes = compare(&columns, 30_000);
            assert!(passes <= most, "{name}: {passes} passes");
        }
    }
}

proptest! {
    #[test]
    fn short_recordings_are_surveyed_alike(
        time in proptest::collection::vec(
            prop_oneof![
                0.0..20.0_f64,
                (0..20_i32).prop_map(f64::from),
                Just(f64::NAN),
                Just(1e300),
                Just(f64::INFINITY),
            ],
            1..60,
        ),
        sorted: bool,
        rows in 1..70_usize,
    ) {
        let mut time = time;
        let values: Vec<f64> = time.iter().map(|t| (t / 3.0).round()).collect();
        if sorted {
            time.sort_by(f64::total_cmp);
        }
        compare(&[column("t", Some("s"), time), column("a", None, values)], rows);
    }
}
