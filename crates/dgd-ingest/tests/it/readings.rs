//! Texts with one reading a line: time, tag, value.

use crate::{assert_same, issue, table_of, unit, values};
use dgd_ingest::{BlockOptions, BlockReader, IngestError, Opened, ReadOptions};
use dgd_recording::{Issue, IssueKind, Table};
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
fn events_in_milliseconds_are_moved_to_whole_seconds() {
    // A scan files its tags some milliseconds apart, when they have changed.
    let mut text = String::from("time,tag,value\n");
    let mut at = 0.0;
    for i in 0..200 {
        at += f64::from(1 + 3 * (i % 4)) + 0.013 * f64::from(i % 5);
        _ = writeln!(text, "{at:.3},a,{i}");
        if i % 3 > 0 {
            _ = writeln!(text, "{:.3},b,{i}", at + 0.004);
        }
    }
    let table = read(&text);
    assert_eq!(
        values(&table, "a").iter().filter(|v| v.is_finite()).count(),
        200
    );
    assert!(values(&table, "b").iter().filter(|v| v.is_finite()).count() > 130);
    let first = values(&table, "time")[0];
    assert!(
        values(&table, "time")
            .iter()
            .all(|t| ((t - first) % 1.0).abs() < 1e-9)
    );
    assert_eq!(issue(&table, IssueKind::Jitter).place, "text");
}

#[test]
fn a_bad_reading_is_none_and_one_of_two_at_a_time_stays() {
    let text = "Timestamp;TagName;Value;Quality\n\
        2026-03-01 10:00:00;FT1;600;Good\n\
        2026-03-01 10:00:01;FT1;601;Bad - no comm\n\
        2026-03-01 10:00:02;FT1;599;Bad\n\
        2026-03-01 10:00:02;FT1;602;Good\n\
        2026-03-01 10:00:02;FT1;603;Good\n\
        2026-03-01 10:00:03;FT1;604;Good\n\
        2026-03-01 10:00:04;FT1;605;Good\n\
        2026-03-01 10:00:05;;606;Good\n";
    let table = read(text);
    assert_same(values(&table, "FT1"), &[600.0, NAN, 602.0, 604.0, 605.0]);
    let places = table
        .issues
        .iter()
        .filter(|i| i.kind == IssueKind::UnreadableValue);
    assert_eq!(
        places.map(|i| i.place.as_str()).collect::<Vec<_>>(),
        ["line 3"]
    );
    assert!(
        issue(&table, IssueKind::DuplicateTime)
            .message
            .starts_with("2 readings with")
    );
    assert!(
        issue(&table, IssueKind::MissingTime)
            .message
            .starts_with("1 line without")
    );
    // In numbers of OPC, where they are; of others 0 is good.
    for (good, second) in [(192, NAN), (1, 2.0)] {
        let text = format!("time,tag,value,quality\n0,a,1,{good}\n1,a,2,0\n2,a,3,{good}\n");
        assert_same(values(&read(&text), "a"), &[1.0, second, 3.0]);
    }
}

#[test]
fn what_is_not_read_is_told_and_a_tag_in_two_units_refused() {
    let text = "time,name,avg,max,uom\n0,a,1,5,gpm\n1,a,2,5,gpm\n2,a,3,5,gpm\n3,a,4,5,gpm\n";
    let table = read(text);
    assert_eq!(tags(&table), ["time", "a"]);
    assert_eq!(unit(&table, "a"), Some("gpm"));
    assert!(
        issue(&table, IssueKind::Skipped)
            .message
            .ends_with("not read: `max`")
    );
    let Err(IngestError::NotTabular { place, .. }) =
        table_of(text.replace("3,5,gpm", "3,5,lpm").as_bytes())
    else {
        panic!("it has two units");
    };
    assert_eq!(place, "line 4");
}

#[test]
fn the_tags_and_the_time_are_those_of_the_readings_not_of_a_query() {
    let text = "_start,_stop,_time,_value,_field,_measurement\n\
        2026-03-01T00:00:00Z,2026-03-02T00:00:00Z,2026-03-01T10:00:00Z,1,FT1,rig\n\
        2026-03-01T00:00:00Z,2026-03-02T00:00:00Z,2026-03-01T10:00:00Z,10,PT1,rig\n\
        2026-03-01T00:00:00Z,2026-03-02T00:00:00Z,2026-03-01T10:00:01Z,2,FT1,rig\n\
        2026-03-01T00:00:00Z,2026-03-02T00:00:00Z,2026-03-01T10:00:01Z,11,PT1,rig\n";
    let table = read(text);
    assert_eq!(tags(&table), ["_time", "FT1", "PT1"]);
    assert_eq!(values(&table, "PT1"), [10.0, 11.0]);
    // Of words that are no tags most readings have the time of another.
    let text = "time,name,value\n0,rig,1\n0,rig,10\n0,rig,3\n1,rig,2\n1,rig,11\n1,rig,4\n";
    assert!(matches!(
        table_of(text.as_bytes()),
        Err(IngestError::NotTabular { .. })
    ));
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

/// By tag, for longer than half a day.
#[test]
fn dates_beside_times_of_the_day_are_taken_as_they_are() {
    let mut text = String::from("date,time,tag,value\n");
    for tag in ["a", "b", "c"] {
        for minute in 0..900 {
            _ = writeln!(
                text,
                "2026-03-01,{:02}:{:02}:00,{tag},{minute}",
                minute / 60,
                minute % 60
            );
        }
    }
    let table = read(&text);
    for tag in ["a", "b", "c"] {
        assert_eq!(values(&table, tag).len(), 900);
        assert_eq!(values(&table, tag)[899], 899.0);
    }
}

#[test]
fn a_table_with_a_channel_a_column_stays_one_whatever_words_stand_in_it() {
    for text in [
        "time,activity,FT1\n0,drilling,1\n1,tripping,2\n",
        "t,Field,FT1,FT2,FT3,FT4,PV\n0,Gullfaks,1,0,0,0,5\n1,Gullfaks,2,0,0,0,6\n",
        "time,name,FT1\n0,,1\n1,,2\n",
    ] {
        let table = read(text);
        assert_eq!(values(&table, "FT1"), [1.0, 2.0], "{text}");
    }
}

#[test]
fn a_slow_tag_beside_fast_ones_has_each_reading_once() {
    let mut text = String::from("time,tag,value\n");
    for s in 0..60 {
        let s = f64::from(s);
        _ = writeln!(text, "{},a,{s}\n{},b,{s}", s, s + 0.3);
        if s % 5.0 == 0.0 {
            _ = writeln!(text, "{},slow,{s}", s + 0.2);
        }
    }
    let table = read(&text);
    let slow = values(&table, "slow");
    assert_eq!(slow.iter().filter(|v| v.is_finite()).count(), 12);
    assert_eq!((slow[10], slow[15]), (10.0, 15.0));
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
    assert!(matches!(opened, Ok(Opened::Whole(why)) if why.contains("times of their own")));
}

/// As a spreadsheet gets the recorded values of several tags: each with its own times beside it, as long as it has readings.
#[test]
fn values_with_their_own_times_beside_them_are_put_on_one_clock() {
    let row = |s: usize| {
        let time = |s: usize| stamp(s as f64);
        // The second tag begins two seconds later, and changes every third second.
        let b = if s < 20 {
            format!("{},{}", time(2 + 3 * s), 100 + s)
        } else {
            ",".into()
        };
        format!("{},{s},{b}\n", time(s))
    };
    let rows: String = (0..60).map(row).collect();
    for (header, named) in [
        ("Time FT1,FT1 (gpm),Time PT1,PT1\n", "Time FT1"),
        // Each name above its times.
        ("FT1,,PT1,\n", "time"),
    ] {
        let table = read(&format!("{header}{rows}"));
        assert_eq!(table.columns[0].tag, named);
        assert_eq!(table.rows(), 60);
        let (one, other) = (&table.columns[1], &table.columns[2]);
        assert!(one.tag.starts_with("FT1") && other.tag == "PT1", "{header}");
        assert_eq!(one.values[7], 7.0);
        assert_eq!(
            (other.values[2], other.values[5], other.values[59]),
            (100.0, 101.0, 119.0)
        );
        assert!(other.values[3].is_nan());
    }
    // A date and a clock beside one value are no pairs, nor is a table with a time at its end.
    let dated = read("Date,Time,x\n2026-03-01,10:00:00,1\n2026-03-01,10:00:01,2\n");
    assert_eq!(tags(&dated), ["Time", "x"]);
}

/// As pivoting readings makes it: a row for each stamp of any, most cells empty.
#[test]
fn a_pivoted_table_is_that_of_a_text_with_one_reading_a_line() {
    let tags = ["FT1", "PT1", "PT2", "SPM"];
    // Polled at instants of their own; and by events, irregularly.
    for even in [true, false] {
        let mut readings: Vec<(f64, usize)> = Vec::new();
        for (tag, _) in tags.iter().enumerate() {
            for i in 0..200 {
                let late = if even {
                    0.0
                } else {
                    0.37 * f64::from((i * 7 + 3) % 5)
                };
                readings.push((2.0 * f64::from(i) + 0.211 * tag as f64 + late, tag));
            }
        }
        readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut wide = format!("Timestamp,{}\n", tags.join(","));
        let mut long = String::from("Timestamp,Tag,Value\n");
        for (second, tag) in &readings {
            let value = 100.0 * *tag as f64 + second;
            let mut cells = [const { String::new() }; 4];
            cells[*tag] = value.to_string();
            _ = writeln!(wide, "{},{}", stamp(*second), cells.join(","));
            _ = writeln!(long, "{},{},{value}", stamp(*second), tags[*tag]);
        }
        let (pivoted, lines) = (read(&wide), read(&long));
        assert_eq!(pivoted.rows(), lines.rows());
        assert!(pivoted.rows() < 500, "{even}: {}", pivoted.rows());
        for tag in ["Timestamp"].iter().chain(&tags) {
            assert_same(values(&pivoted, tag), values(&lines, tag));
        }
        let text = std::io::Cursor::new(wide);
        let opened = BlockReader::open(text, &ReadOptions::default(), BlockOptions::default());
        assert!(matches!(opened, Ok(Opened::Whole(_))));
    }
    // Rows that share a second, one with a value for each tag, and a clock that was set back: left as they are.
    let full = "t,a,b,c\n2026-03-01 10:00:00.5,1,2,3\n2026-03-01 10:00:01.5,1,2,3\n";
    assert_eq!(read(full).rows(), 2);
    let back = "t,a,b,c\n2026-03-01 10:00:04.5,1,,\n2026-03-01 10:00:00.5,,2,\n2026-03-01 10:00:02.5,,,3\n";
    assert_same(values(&read(back), "a"), &[1.0, NAN, NAN]);
}

/// However a pivoted table tells its times, and beside columns of which nothing was read.
#[test]
fn a_pivoted_table_is_put_on_one_clock_by_any_times_in_seconds() {
    let tags = ["FT1", "PT1", "PT2", "SPM"];
    let epoch = |s: f64| 1_772_359_200.0 + s;
    let forms: [(&str, &dyn Fn(f64) -> String); 5] = [
        ("Timestamp", &|s| stamp(s)),
        ("Time", &|s| stamp(s).split_off(11)),
        ("epoch", &|s| format!("{:.3}", epoch(s))),
        ("unixtime", &|s| format!("{:.0}", 1e3 * epoch(s))),
        ("Time [s]", &|s| format!("{s:.3}")),
    ];
    for (time, written) in forms {
        let mut text = format!("{time},Row,Well,{}\n", tags.join(","));
        for row in 0..800 {
            // Each tag at its own part of a second, every two seconds; which of them was read is counted up.
            let tag = row % 4;
            let second = 2.0 * f64::from(row / 4) + 0.211 * f64::from(tag);
            let mut cells = [const { String::new() }; 4];
            cells[tag as usize] = (1000 * tag + row / 4).to_string();
            _ = writeln!(text, "{},{row},15,{}", written(second), cells.join(","));
        }
        let table = read(&text);
        assert_eq!(table.rows(), 200, "{time}");
        for (tag, name) in tags.iter().enumerate() {
            let told: Vec<f64> = (0..200).map(|i| f64::from(1000 * tag as u32 + i)).collect();
            assert_same(values(&table, name), &told);
        }
        assert!(values(&table, "Well").iter().all(|well| *well == 15.0));
        let rows = values(&table, "Row");
        assert!(
            rows.windows(2).all(|pair| pair[1] - pair[0] == 4.0),
            "{time}"
        );
        let opened = BlockReader::open(
            std::io::Cursor::new(text),
            &ReadOptions::default(),
            BlockOptions::default(),
        );
        assert!(matches!(opened, Ok(Opened::Whole(_))), "{time}");
    }
}

/// Scans that come about half a second behind the first reading of all are not parted by whole seconds from it.
#[test]
fn readings_by_events_are_put_on_the_part_of_a_second_at_which_they_come() {
    let mut text = String::from("Timestamp,Tag,Value\n");
    _ = writeln!(text, "{},FT1,0", stamp(0.0));
    let mut filed = [0_usize; 3];
    for i in 1..600_u32 {
        // A scan is now before the half of its second and now behind it.
        let second = f64::from(i) + 0.5 + 0.04 * (f64::from(i * 7 % 11) - 5.0) / 5.0;
        for (tag, filed) in filed.iter_mut().enumerate() {
            // Unevenly, as by events.
            if (i * (3 + tag as u32)) % 7 < 3 {
                *filed += 1;
                _ = writeln!(text, "{},T{tag},{i}", stamp(second + 0.002 * tag as f64));
            }
        }
    }
    let table = read(&text);
    for (tag, filed) in filed.iter().enumerate() {
        let values = values(&table, &format!("T{tag}"));
        let told: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        assert_eq!(told.len(), *filed, "T{tag}");
    }
    let crowded = |issue: &&Issue| issue.kind == IssueKind::Crowded;
    assert_eq!(table.issues.iter().find(crowded), None);
}
