//! MCAP logs, read back by the library's own reader.

use crate::{Full, column, table};
use dgd_export::{ExportError, McapOptions, write_mcap};
use dgd_recording::Table;
use mcap::MessageStream;
use serde_json::{Value, json};
use std::io::Cursor;

fn written(table: &Table, options: &McapOptions) -> Vec<u8> {
    let mut log = Cursor::new(Vec::new());
    write_mcap(table, options, &mut log).unwrap();
    log.into_inner()
}

/// Log time, topic and members of every message.
fn messages(log: &[u8]) -> Vec<(u64, String, Value)> {
    MessageStream::new(log)
        .unwrap()
        .map(|m| {
            let m = m.unwrap();
            let members = serde_json::from_slice(&m.data).unwrap();
            (m.log_time, m.channel.topic.clone(), members)
        })
        .collect()
}

fn rig() -> Table {
    table(vec![
        column("t", Some("s"), &[0.0, 0.1, 0.3]),
        column("FT4", Some("gpm"), &[796.5, f64::NAN, f64::INFINITY]),
        column("odd \"name\"", None, &[1.0]),
    ])
}

#[test]
fn each_sample_is_a_message_at_its_time() {
    let found = messages(&written(&rig(), &McapOptions::default()));
    let expected = [
        (0, json!({"FT4": 796.5, "odd \"name\"": 1})),
        (100_000_000, json!({"FT4": null, "odd \"name\"": null})),
        (300_000_000, json!({"FT4": null, "odd \"name\"": null})),
    ];
    assert_eq!(found.len(), expected.len());
    for ((log_ns, topic, members), (expected_ns, expected)) in found.iter().zip(&expected) {
        assert_eq!(log_ns, expected_ns);
        assert_eq!(topic, "/rig");
        assert_eq!(members, expected);
    }
}

#[test]
fn log_times_count_from_the_origin_and_in_the_columns_unit() {
    let minutes = table(vec![
        column("time", Some("min"), &[0.0, 1.5]),
        column("a", None, &[1.0, 2.0]),
    ]);
    let table = Table {
        origin: Some("2014-10-07T00:00:00Z".into()),
        ..minutes
    };
    let options = McapOptions {
        time_tag: Some("time".into()),
        topic: "/well".into(),
    };
    let found = messages(&written(&table, &options));
    // Without a tag the column named like time is found.
    let unnamed = McapOptions {
        topic: "/well".into(),
        ..McapOptions::default()
    };
    assert_eq!(messages(&written(&table, &unnamed)), found);
    let times: Vec<u64> = found.iter().map(|m| m.0).collect();
    assert_eq!(
        times,
        [1_412_640_000_000_000_000, 1_412_640_090_000_000_000]
    );
    assert_eq!(found[0].1, "/well");
}

#[test]
fn the_clock_is_the_given_one_then_the_tables_then_t() {
    let of = |clock, time_tag: Option<&str>| {
        let table = Table {
            clock,
            ..table(vec![
                column("pump.t", Some("s"), &[5.0, 6.0]),
                column("t", Some("s"), &[1.0, 2.0]),
                column("stamp", Some("s"), &[3.0, 4.0]),
            ])
        };
        let options = McapOptions {
            time_tag: time_tag.map(Into::into),
            ..McapOptions::default()
        };
        messages(&written(&table, &options))[0].0
    };
    assert_eq!(of(Some(2), Some("pump.t")), 5_000_000_000);
    assert_eq!(of(Some(2), None), 3_000_000_000);
    assert_eq!(of(None, None), 1_000_000_000);
    // A clock that ends in `.t` is none by its name.
    let nested = table(vec![
        column("time", Some("s"), &[1.0, 2.0]),
        column("motor.t", Some("degC"), &[3.0, 4.0]),
    ]);
    assert_eq!(
        messages(&written(&nested, &McapOptions::default()))[0].0,
        1_000_000_000
    );
}

#[test]
fn the_schema_says_type_and_unit_of_each_member() {
    let log = written(&rig(), &McapOptions::default());
    let summary = mcap::Summary::read(&log).unwrap().unwrap();
    let schema = summary.schemas.values().next().unwrap();
    assert_eq!(schema.encoding, "jsonschema");
    let schema: Value = serde_json::from_slice(&schema.data).unwrap();
    assert_eq!(schema["type"], "object");
    assert_eq!(
        schema["properties"]["FT4"],
        json!({"type": "number", "unit": "gpm", "description": "unit: gpm"})
    );
    assert_eq!(
        schema["properties"]["odd \"name\""],
        json!({"type": "number"})
    );
    assert!(schema["properties"].get("t").is_none());
    assert_eq!(
        summary.channels.values().next().unwrap().message_encoding,
        "json"
    );
    assert_eq!(summary.stats.unwrap().message_count, 3);
}

#[test]
fn each_refusal_has_its_error() {
    let write = |table: &Table| write_mcap(table, &McapOptions::default(), Cursor::new(Vec::new()));
    assert!(matches!(
        write(&Table::default()),
        Err(ExportError::NoColumns)
    ));
    let of = |tag: &str, unit, times: &[f64]| {
        table(vec![
            column(tag, unit, times),
            column("a", None, &[1.0, 2.0]),
        ])
    };
    assert!(matches!(
        write(&of("a", None, &[0.0])),
        Err(ExportError::NameTaken { .. })
    ));
    assert!(
        matches!(write(&of("x", None, &[0.0])), Err(ExportError::NoTime { present, .. }) if present == "x, a")
    );
    assert!(matches!(
        write(&of("t", Some("gpm"), &[0.0])),
        Err(ExportError::TimeUnit { .. })
    ));
    let only = table(vec![column("t", Some("s"), &[0.0, 1.0])]);
    assert!(matches!(write(&only), Err(ExportError::OnlyTime { tag }) if tag == "t"));
    for bad in [f64::NAN, -1.0, 1.4e9, f64::INFINITY] {
        assert!(matches!(
            write(&of("t", None, &[0.0, bad])),
            Err(ExportError::TimeValue { index: 1, .. })
        ));
    }
    // A time column shorter than the others leaves samples without a time.
    assert!(matches!(
        write(&of("t", None, &[0.0])),
        Err(ExportError::TimeValue { index: 1, .. })
    ));
    let odd = Table {
        origin: Some("yesterday".into()),
        ..rig()
    };
    assert!(matches!(write(&odd), Err(ExportError::Origin { .. })));
    let full = write_mcap(&rig(), &McapOptions::default(), Full);
    let Err(ExportError::Mcap(library)) = full else {
        panic!("{full:?}");
    };
    // Whatever the library calls it: its types are not those of this crate.
    let library: Box<dyn std::error::Error + Send + Sync> = library;
    let told = ExportError::Mcap(library).to_string();
    assert!(told.starts_with("cannot write the log: "), "{told}");
}
