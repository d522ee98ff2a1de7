//! Texts with one reading a line: time, tag, value.

use crate::{assert_same, issue, table_of, unit, values};
use dgd_ingest::{BlockOptions, BlockReader, IngestError, Opened, ReadOptions};
use dgd_recording::{IssueKind, Table};
use std::fmt::Write;

const NAN: f64 = f64::NAN;

fn read(text: &str) -> Table {
    table_of(text.as_bytes()).unwrap()
}

fn tags(table: &Table) -> Vec<&str> {
    table.columns.iter().map(|c| c.tag.as_str()).collect()
}

/// A stamp of so many seconds.
fn stamp(second: f64) -> String {
    format!(
        "2026-03-01 10:{:02}:{:06.3}",
        (second / 60.0) as u32,
        second % 60.0
    )
}

#[test]
fn tags_become_columns_in_whichever_order_their_readings_come() {
    let head = "Tag,Timestamp,Value,Units\n";
    let line = |tag: &str, unit: &str, second: u32, value: f64| {
        format!("{tag},{},{value},{unit}\n", stamp(f64::from(second)))
    };
    let flow = |s: u32| line("FT1", "gpm", s, 600.0 + f64::from(s));
    let pressure = |s: u32| line("PT1", "psia", s, 990.5 - f64::from(s));
    let by_time: String = (0..50).flat_map(|s| [flow(s), pressure(s)]).collect();
    let by_tag: String = (0..50).map(flow).chain((0..50).map(pressure)).collect();
    let backwards: String = (0..50).rev().flat_map(|s| [flow(s), pressure(s)]).collect();
    for rows in [by_time, by_tag, backwards] {
        let table = read(&format!("{head}{rows}"));
        assert_eq!(tags(&table), ["Timestamp", "FT1", "PT1"]);
        assert_eq!(
            (unit(&table, "FT1"), unit(&table, "PT1")),
            (Some("gpm"), Some("psia"))
        );
        assert_eq!(values(&table, "FT1").len(), 50);
        assert_eq!(values(&table, "FT1")[7], 607.0);
        assert_eq!(values(&table, "PT1")[7], 983.5);
        let steps = values(&table, "Timestamp")
            .windows(2)
            .map(|pair| pair[1] - pair[0]);
        assert!(steps.into_iter().all(|step| step == 1.0));
        assert!(table.issues.is_empty(), "{:?}", table.issues);
    }
}

#[test]
fn a_tag_without_a_reading_at_a_time_has_none_there() {
    let table = read("time,tag,value\n0,a,1\n0,b,10\n1,a,2\n2,a,3\n2,b,30\n");
    assert_eq!(values(&table, "time"), [0.0, 1.0, 2.0]);
    assert_eq!(values(&table, "a"), [1.0, 2.0, 3.0]);
    assert_same(values(&table, "b"), &[10.0, NAN, 30.0]);
}

#[test]
fn tags_that_are_polled_at_their_own_instants_share_the_clock_of_the_busiest() {
    let mut text = String::from("time,tag,value\n");
    for s in 0..60 {
        let s = f64::from(s);
        _ = writeln!(text, "{},a,{}\n{},b,{}", s, s, s + 0.25, 100.0 + s);
    }
    text.push_str("60,a,60\n");
    let table = read(&text);
    assert_eq!(values(&table, "a").len(), 61);
    assert_eq!(values(&table, "b")[59], 159.0);
    let told = issue(&table, IssueKind::Jitter);
    assert_eq!(told.place, "tag `b`");
    assert!(told.message.contains("by up to 0.25 s"), "{}", told.message);
}

#[test]
fn readings_of_events_keep_their_own_times() {
    // Hardly two share a time, and none comes evenly.
    let mut text = String::from("time,tag,value\n");
    let (mut a, mut b) = (0, 0);
    for i in 0..60 {
        a += 1 + 7 * (i % 3);
        b += 2 + 5 * (i % 4);
        _ = writeln!(text, "{a},a,{i}\n{b},b,{i}");
    }
    let table = read(&text);
    for tag in ["a", "b"] {
        let read = values(&table, tag).iter().filter(|v| v.is_finite());
        assert_eq!(read.count(), 60, "{tag}");
    }
}

#[test]
fn a_bad_reading_is_none_and_one_of_two_at_a_time_stays() {
    let text = "Timestamp;TagName;Value;Quality\n\
        2026-03-01 10:00:00;FT1;600;Good\n\
        2026-03-01 10:00:01;FT1;601;Bad - no comm\n\
        2026-03-01 10:00:02;FT1;602;Good\n\
        2026-03-01 10:00:02;FT1;603;Good\n\
        2026-03-01 10:00:03;;604;Good\n";
    let table = read(text);
    assert_same(values(&table, "FT1"), &[600.0, NAN, 602.0]);
    assert_eq!(issue(&table, IssueKind::UnreadableValue).place, "line 3");
    assert!(
        issue(&table, IssueKind::DuplicateTime)
            .message
            .starts_with("1 reading with")
    );
    assert!(
        issue(&table, IssueKind::MissingTime)
            .message
            .starts_with("1 line without")
    );
}

#[test]
fn what_is_not_read_or_changes_its_unit_is_told() {
    let text = "time,name,avg,max,uom\n0,a,1,5,gpm\n1,a,2,5,gpm\n2,a,3,5,lpm\n3,a,4,5,gpm\n";
    let table = read(text);
    assert_eq!(tags(&table), ["time", "a"]);
    assert_eq!(unit(&table, "a"), Some("gpm"));
    assert!(
        issue(&table, IssueKind::Skipped)
            .message
            .ends_with("not read: `max`")
    );
    assert_eq!(issue(&table, IssueKind::UnitDisagrees).place, "line 4");
}

#[test]
fn times_of_the_day_need_their_date() {
    let text = "time,tag,value\n10:00:00,a,1\n10:00:01,a,2\n10:00:00,b,3\n10:00:01,b,4\n";
    let Err(IngestError::NotTabular { place, .. }) = table_of(text.as_bytes()) else {
        panic!("it has no date");
    };
    assert_eq!(place, "column `time`");
    let dated = "date,time,tag,value\n2026-03-01,10:00:00,a,1\n2026-03-01,10:00:01,a,2\n\
        2026-03-01,10:00:00,b,3\n2026-03-01,10:00:01,b,4\n";
    assert_eq!(values(&read(dated), "b"), [3.0, 4.0]);
}

#[test]
fn words_beside_several_channels_are_no_tags() {
    // What the rig does, beside a table with a channel a column; and one channel with a remark.
    for text in [
        "time,activity,FT1\n0,drilling,1\n1,tripping,2\n",
        "time,status,FT1,PT1\n0,run,1,2\n1,stop,2,3\n",
    ] {
        let table = read(text);
        assert_eq!(values(&table, "FT1"), [1.0, 2.0], "{text}");
    }
}

#[test]
fn more_cells_than_the_text_may_say_are_refused() {
    let mut text = String::from("time,tag,value\n");
    for i in 0..9000 {
        _ = writeln!(text, "{i},t{i},1");
    }
    let Err(IngestError::TooLarge { claimed, .. }) = table_of(text.as_bytes()) else {
        panic!("9,000 tags at 9,000 stamps");
    };
    assert_eq!(claimed, 9000 * 9001);
}

#[test]
fn such_a_text_is_read_whole() {
    let text = std::io::Cursor::new("time,tag,value\n0,a,1\n1,a,2\n");
    let opened = BlockReader::open(text, &ReadOptions::default(), BlockOptions::default());
    assert!(matches!(opened, Ok(Opened::Whole(why)) if why.contains("one reading a line")));
}
