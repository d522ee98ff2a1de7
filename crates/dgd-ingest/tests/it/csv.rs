//! CSV text as rigs, laboratories and spreadsheets write it.

use crate::{assert_same, issue, table_of, unit, values};
use dgd_ingest::IngestError;
use dgd_recording::{IssueKind, Table};

const NAN: f64 = f64::NAN;

fn read(text: &str) -> Table {
    table_of(text.as_bytes()).unwrap()
}

fn tags(table: &Table) -> Vec<&str> {
    table.columns.iter().map(|c| c.tag.as_str()).collect()
}

#[test]
fn header_and_unit_row_name_the_columns() {
    let table = read("t,FT1,SPM\ns,gpm,%\n0,597,58.2\n1,598,58.3\n");
    assert_eq!(tags(&table), ["t", "FT1", "SPM"]);
    assert_eq!(unit(&table, "FT1"), Some("gpm"));
    assert_eq!(unit(&table, "SPM"), Some("%"));
    assert_eq!(values(&table, "FT1"), [597.0, 598.0]);
    assert!(table.issues.is_empty());
}

#[test]
fn a_header_alone_is_no_unit_row_even_if_its_names_are_units() {
    let table = read("t,m,s\n0,1,2\n1,2,3\n");
    assert_eq!(tags(&table), ["t", "m", "s"]);
    assert_eq!(unit(&table, "m"), None);
}

#[test]
fn unknown_units_below_a_full_header_are_units() {
    let table = read("t,WOB\nsek,k-lbs\n0,1\n");
    assert_eq!(tags(&table), ["t", "WOB"]);
    assert_eq!(unit(&table, "WOB"), Some("k-lbs"));
}

#[test]
fn first_rows_with_words_are_rows_and_the_header_stays() {
    let table = read("t,a\n0,bad\n1,2\n2,3\n");
    assert_eq!(tags(&table), ["t", "a"]);
    assert_same(values(&table, "t"), &[0.0, 1.0, 2.0]);
    assert_same(values(&table, "a"), &[NAN, 2.0, 3.0]);
    assert_eq!((unit(&table, "t"), unit(&table, "a")), (None, None));
    assert_eq!(
        issue(&table, IssueKind::UnreadableValue).place,
        "line 2, column `a`"
    );
    // Below units too; and `1` is a number unless units stand beside it.
    let table = read("t,a\ns,gpm\n1,bad\n2,2\n3,3\n");
    assert_eq!(unit(&table, "a"), Some("gpm"));
    assert_same(values(&table, "t"), &[1.0, 2.0, 3.0]);
    assert_same(
        values(&read("t,a\nbad,1\n1,2\n2,3\n"), "a"),
        &[1.0, 2.0, 3.0],
    );
    // Units of one kind, and items of WITS, are a header too.
    for (text, tag) in [
        ("a,b\npsi,psi\nbad,5\n6,7\n8,9\n", "b"),
        ("0108,0110\nbad,5\n6,7\n8,9\n", "0110"),
    ] {
        assert_same(values(&read(text), tag), &[5.0, 7.0, 9.0]);
    }
    let table = read("t,a,ratio\ns,psi,1\n0,2,0.5\n1,3,0.6\n");
    assert_eq!(unit(&table, "ratio"), Some("1"));
    assert_eq!(values(&table, "t"), [0.0, 1.0]);
}

#[test]
fn a_historian_export_that_begins_without_data_keeps_its_header() {
    let rows = |from: u32, cells: &str, n: u32| -> String {
        (from..from + n).map(|s| format!("{s},{cells}\n")).collect()
    };
    let text = format!("time,FT4\n{}{}", rows(100, "No Data", 3), rows(103, "5", 5));
    let table = read(&text);
    assert_eq!(tags(&table), ["time", "FT4"]);
    assert_eq!(values(&table, "time").len(), 8);
    assert_eq!(
        issue(&table, IssueKind::UnreadableValue).place,
        "line 2, column `FT4`"
    );
    // Dated, most tags without data: for 3 rows, and for more than are sampled at the start.
    for missing in [3, 300] {
        let row = |i: u32, value: &str| {
            let clock = format!("{:02}:{:02}", i / 60, i % 60);
            format!(
                "2024-10-22 15:{clock},1.2{}\n",
                format!(",{value}").repeat(6)
            )
        };
        let rows: String = (0..missing)
            .map(|i| row(i, "No Data"))
            .chain((missing..1000).map(|i| row(i, "3.5")))
            .collect();
        let table = read(&format!("Time,Choke,FT1,FT2,PT1,PT2,SPM,TT1\n{rows}"));
        assert_eq!(
            tags(&table),
            ["Time", "Choke", "FT1", "FT2", "PT1", "PT2", "SPM", "TT1"]
        );
        assert_eq!(table.origin.as_deref(), Some("2024-10-22T15:00:00-00:00"));
        assert_eq!(values(&table, "TT1").len(), 1000);
        assert!(values(&table, "TT1")[0].is_nan());
        assert_eq!(values(&table, "TT1")[999], 3.5);
    }
}

#[test]
fn rows_of_one_word_are_no_units_and_are_told() {
    let nothing = "No Data,No Data\n";
    for text in [
        format!("t,a\n{nothing}{nothing}0,1\n1,2\n"),
        format!("t,a\n{nothing}0,No Data\n1,2\n2,3\n"),
    ] {
        let table = read(&text);
        assert_eq!(tags(&table), ["t", "a"]);
        assert_eq!(unit(&table, "a"), None);
        assert_eq!(issue(&table, IssueKind::Skipped).place, "line 2");
    }
    let table = read("WOB,Hook\nk-lbs,k-lbs\n0,1\n1,2\n");
    assert_eq!(unit(&table, "WOB"), Some("k-lbs"));
}

#[test]
fn numbers_above_the_values_may_be_titles_and_names() {
    let table = read("Version,2.0,,\nt,FT1,FT2,7\n0,1,2,3\n1,2,3,4\n");
    assert_eq!(tags(&table), ["t", "FT1", "FT2", "7"]);
    assert_eq!(values(&table, "7"), [3.0, 4.0]);
    let table = read("Version,2.0,,\nt,FT1,FT2,PT1\ns,gpm,gpm,psi\n0,1,2,3\n1,2,3,4\n");
    assert_eq!(tags(&table), ["t", "FT1", "FT2", "PT1"]);
    assert_eq!(unit(&table, "PT1"), Some("psi"));
}

#[test]
fn units_stand_below_a_column_without_a_name() {
    let table = read("t,,FT4\ns,psi,gpm\n0,1,2\n1,2,3\n");
    assert_eq!(tags(&table), ["t", "c2", "FT4"]);
    assert_eq!(
        (unit(&table, "c2"), unit(&table, "FT4")),
        (Some("psi"), Some("gpm"))
    );
    // Names that are units below a title are names.
    assert_eq!(
        tags(&read("Title,,\nt,m,s\n0,1,2\n1,2,3\n")),
        ["t", "m", "s"]
    );
}

#[test]
fn a_number_too_large_to_be_one_is_unreadable() {
    let table = read("t,a\n0,1\n1,1e999\n2,-inf\n");
    assert_same(values(&table, "a"), &[1.0, NAN, f64::NEG_INFINITY]);
    assert_eq!(
        issue(&table, IssueKind::UnreadableValue).place,
        "line 3, column `a`"
    );
}

#[test]
fn lines_longer_than_the_header_are_told() {
    let table = read("t,a\n0,1,5\n1,2,5\n2,3,5\n");
    assert_eq!(tags(&table), ["t", "a", "c3"]);
    let told = issue(&table, IssueKind::Damaged);
    assert_eq!(told.place, "line 2, column `c3`");
    assert!(told.message.contains("decimal comma"), "{told}");
    assert!(read("t,a\n0,1,\n1,2,\n").issues.is_empty());
    assert!(read("0,1,5\n1,2,5\n").issues.is_empty());
}

#[test]
fn numbers_that_run_backwards_are_no_time_of_the_day() {
    for written in ["3\n1\n2\n2\n", "5\n4\n3\n", "120\n100\n59\n58\n"] {
        let table = read(&format!("t,a\n{}", written.replace('\n', ",1\n")));
        let expected: Vec<f64> = written.lines().map(|l| l.parse().unwrap()).collect();
        assert_same(values(&table, "t"), &expected);
        assert_eq!(unit(&table, "t"), None);
    }
    let midnight = read("t,a\n235958,1\n235959,2\n0,3\n1,4\n");
    assert_same(values(&midnight, "t"), &[0.0, 1.0, 2.0, 3.0]);
}

#[test]
fn units_stand_in_brackets_behind_names() {
    let table = read("t [s],FT1 (gpm),ROP(1 ft),Flow (in)\n0,1,2,3\n1,2,3,4\n");
    assert_eq!(tags(&table), ["t", "FT1", "ROP(1 ft)", "Flow (in)"]);
    assert_eq!(unit(&table, "t"), Some("s"));
    assert_eq!(unit(&table, "FT1"), Some("gpm"));
    assert_eq!(unit(&table, "Flow (in)"), None);
}

#[test]
fn title_lines_and_trailing_delimiters_are_no_columns() {
    let text = "U,of,U,,,\nMU,ESW1,58-32,,,\nDepth,Pump Press (psi),Flow %,,,\n85.18,463.72,101.6,,,\n86.18,459.53,101.7,,,\n,,,,,\n,,,,,\n";
    let table = read(text);
    assert_eq!(tags(&table), ["Depth", "Pump Press", "Flow %"]);
    assert_eq!(values(&table, "Depth"), [85.18, 86.18]);
    assert!(table.issues.is_empty(), "{:?}", table.issues);
}

#[test]
fn a_column_without_a_name_that_fills_later_is_kept() {
    let table = read("a,b,\n1,2,\n2,3,\n3,4,7\n");
    assert_eq!(tags(&table), ["a", "b", "c3"]);
    assert_same(values(&table, "c3"), &[NAN, NAN, 7.0]);
}

#[test]
fn without_a_header_columns_are_numbered() {
    let table = read("0,1.5\n1,2.5\n");
    assert_eq!(tags(&table), ["c1", "c2"]);
    assert_eq!(values(&table, "c2"), [1.5, 2.5]);
}

#[test]
fn delimiters_and_decimal_signs_give_one_table() {
    let expected = read("t,a\n0.5,-1.25\n1.5,1e3\n");
    for text in [
        "t;a\n0.5;-1.25\n1.5;1e3\n",
        "t;a\n0,5;-1,25\n1,5;1e3\n",
        "t\ta\r\n0,5\t-1,25\r\n1,5\t1000\r\n",
        "\u{feff}t,a\r\n 0.5 , -1.25 \r\n\"1.5\",\"1e3\"\r\n",
        "t,a\r0.5,-1.25\r1.5,1e3\r",
        "# t,a\n0.5,-1.25\n\n1.5,1e3",
    ] {
        assert_eq!(read(text), expected, "{text:?}");
    }
}

#[test]
fn commas_and_points_in_one_file_are_told() {
    let table = read("t;a\n0;1.5\n1;2,5\n2;3.5\n");
    assert_eq!(values(&table, "a"), [1.5, 2.5, 3.5]);
    assert_eq!(issue(&table, IssueKind::UnreadableValue).place, "line 3");
}

#[test]
fn thousands_are_grouped_where_two_signs_tell_and_not_guessed_elsewhere() {
    let table = read("t;a\n0;1,5\n1;1.234,5\n2;2,5\n");
    assert_same(values(&table, "a"), &[1.5, 1234.5, 2.5]);
    let table = read("t,a\n0,999.5\n1,\"1,234.5\"\n2,\"1,234\"\n3,\"12,5\"\n");
    assert_same(values(&table, "a"), &[999.5, 1234.5, NAN, 12.5]);
    let told = issue(&table, IssueKind::UnreadableValue);
    assert_eq!(told.place, "line 4, column `a`");
    assert!(
        told.message
            .contains("a thousands separator or a decimal sign?"),
        "{told}"
    );
}

#[test]
fn a_comma_alone_that_may_separate_thousands_is_told_with_both_readings() {
    let doubts = |text: &str| -> Vec<String> {
        let issues = read(text).issues;
        issues.iter().map(ToString::to_string).collect()
    };
    let said = "line 4, column `a`: 2 cells with a comma that may separate thousands, the first is `1,002`; read as 1.002, not as 1002 \
                (write them without a thousands separator)";
    for delimiter in [";", "\t", "|"] {
        let text = |rows: &str| format!("t;a\n{rows}").replace(';', delimiter);
        // Whole numbers that go on into the thousands, and points in another column.
        let counted = text("0;998\n1;999\n2;1,002\n3;1,003\n");
        assert_eq!(doubts(&counted), [said], "{delimiter}");
        assert_eq!(values(&read(&counted), "a")[2], 1.002);
        let pointed = text("0.5;8\n1.5;9\n2.5;1,002\n3.5;1,003\n");
        assert_eq!(doubts(&pointed), [said], "{delimiter}");
        // Decimal commas: one of the column has other digits behind it, or nothing speaks for thousands.
        for sound in [
            "0,5;998\n1,5;999,5\n2,5;1,002\n",
            "0;0,998\n1;0,999\n2;1,002\n",
            "0,125;1,002\n0,250;1,003\n0,375;2\n",
        ] {
            assert!(doubts(&text(sound)).is_empty(), "{sound:?}");
        }
    }
}

#[test]
fn digits_alone_are_a_date_in_a_column_of_times() {
    let table = read("time,a\n20241026003000,1\n20241026003001,2\n20241026003100,3\n");
    assert_same(values(&table, "time"), &[0.0, 1.0, 60.0]);
    assert_eq!(table.origin.as_deref(), Some("2024-10-26T00:30:00-00:00"));
    assert_eq!((table.clock, unit(&table, "time")), (Some(0), Some("s")));
    let gap = read("Date_Time,a\n20241026003000,1\nNaN,2\n20241026003002,3\n");
    assert_same(values(&gap, "Date_Time"), &[0.0, NAN, 2.0]);
    // Elsewhere, or where one of them is none, they are numbers.
    let table = read("well,time\n20241026003000,20241026003000\n20241026003001,20241326003001\n");
    assert_same(
        values(&table, "well"),
        &[20_241_026_003_000.0, 20_241_026_003_001.0],
    );
    assert_same(
        values(&table, "time"),
        &[20_241_026_003_000.0, 20_241_326_003_001.0],
    );
    assert_eq!((table.clock, table.origin), (None, None));
}

/// Rows at 1 Hz from 07:58:30 on, whose time the closure writes.
fn timed(head: &str, written: impl Fn(u32, u32, u32) -> String) -> String {
    let rows = (0..180).map(|i| {
        let s = 7 * 3600 + 58 * 60 + 30 + i;
        format!("{},{i}\n", written(s / 3600, s / 60 % 60, s % 60))
    });
    format!("{head}\n{}", rows.collect::<String>())
}

#[test]
fn a_time_of_the_day_in_digits_goes_on_over_the_minute_and_the_hour() {
    let seconds: Vec<f64> = (0..180).map(f64::from).collect();
    for zeros in [true, false] {
        let table = read(&timed("TIME,a", |h, m, s| {
            let digits = format!("{h:02}{m:02}{s:02}");
            let short = digits.trim_start_matches('0').to_owned();
            if zeros { digits } else { short }
        }));
        assert_same(values(&table, "TIME"), &seconds);
        assert_eq!((unit(&table, "TIME"), &table.origin), (Some("s"), &None));
    }
    // Beside a date it is a clock of the wall; items of WITS are names.
    for (head, day) in [("Date,Time,a", "20260301"), ("0105,0106,0120", "260301")] {
        let table = read(&timed(head, |h, m, s| format!("{day},{h:02}{m:02}{s:02}")));
        let (clock, last) = (&table.columns[0], &table.columns[1]);
        assert_same(&clock.values, &seconds);
        assert_eq!(last.values.len(), 180);
        assert_eq!(table.origin.as_deref(), Some("2026-03-01T07:58:30-00:00"));
        assert_eq!(clock.tag, head.split(',').nth(1).unwrap());
    }
    // Past midnight, with and without a date.
    let late = |date: bool| {
        let rows = (86_340..86_460).map(|s| {
            let day = if date {
                format!("26030{},", 1 + s / 86_400)
            } else {
                String::new()
            };
            let s = s % 86_400;
            format!(
                "{day}{:02}{:02}{:02}.5,{s}\n",
                s / 3600,
                s / 60 % 60,
                s % 60
            )
        });
        let head = if date { "date,time,a\n" } else { "time,a\n" };
        read(&format!("{head}{}", rows.collect::<String>()))
    };
    for date in [true, false] {
        assert_same(values(&late(date), "time"), &seconds[..120]);
    }
}

#[test]
fn numbers_that_go_on_past_59_are_no_time_of_the_day() {
    // Seconds; hundreds of them; minutes with a fraction; and times of the day in a column that is not named like time.
    let counted = |from: u32, step: u32| {
        let rows = (0..200).map(|i| format!("{},{i}\n", from + i * step));
        read(&format!("t,a\n{}", rows.collect::<String>()))
    };
    for (from, step) in [(0, 1), (100, 1), (80_000, 1), (0, 100), (0, 7), (0, 10_000)] {
        let table = counted(from, step);
        assert_eq!(values(&table, "t")[0], f64::from(from));
        assert_eq!(values(&table, "t")[1], f64::from(from + step));
        assert_eq!(unit(&table, "t"), None);
    }
    let tenths: String = (0..100)
        .map(|i| format!("{:.1},{i}\n", f64::from(i) / 10.0))
        .collect();
    assert_eq!(values(&read(&format!("time,a\n{tenths}")), "time")[99], 9.9);
    let elsewhere = read(&timed("depth,a", |h, m, s| format!("{h:02}{m:02}{s:02}")));
    assert_eq!(values(&elsewhere, "depth")[0], 75_830.0);
}

#[test]
fn four_digits_above_four_digits_are_no_names() {
    let table = read("0105,0106\n0107,0108\n0109,0110\n");
    assert_same(values(&table, "c1"), &[105.0, 107.0, 109.0]);
    let years = read("1999,2000\n1.5,2.5\n");
    assert_same(values(&years, "c1"), &[1999.0, 1.5]);
}

#[test]
fn cells_may_stand_between_bars() {
    let table = read("t|FT1 [gpm]|FT4\n0|1,5|2\n1|3.5|4\n");
    assert_same(values(&table, "FT1"), &[1.5, 3.5]);
    assert_same(values(&table, "FT4"), &[2.0, 4.0]);
}

#[test]
fn a_second_column_of_a_name_gets_another_and_it_is_told() {
    let table = read("t,FT1,FT1\n0,1,2\n1,3,4\n");
    assert_same(values(&table, "FT1_2"), &[2.0, 4.0]);
    let told = issue(&table, IssueKind::Renamed);
    assert_eq!(told.place, "column 3");
    assert!(told.message.contains("`FT1`") && told.message.contains("`FT1_2`"));
}

#[test]
fn a_second_header_in_another_order_is_refused_with_its_line() {
    let text = |second: &str| format!("t,FT1 [gpm],FT4\n0,1,2\n1,3,4\n{second}\n2,5,6\n3,7,8\n");
    // As files that were put behind each other have it.
    assert_eq!(values(&read(&text("t,FT1 [gpm],FT4")), "FT4").len(), 4);
    // One word that is a name may be a remark.
    assert_eq!(values(&read(&text(",,FT1")), "FT4").len(), 4);
    let twice = read("t,FT,FT,P\n0,1,2,3\n1,1,2,3\nt,FT,FT,P\n2,1,2,3\n3,1,2,3\n");
    assert_eq!(tags(&twice), ["t", "FT", "FT_2", "P"]);
    assert_eq!(values(&twice, "P").len(), 4);
    for second in ["t,FT4,FT1 [gpm]", "FT1,FT4", "t,PT1,FT1,FT4"] {
        let refused =
            dgd_ingest::read(text(second).as_bytes(), &dgd_ingest::ReadOptions::default());
        let said = refused.unwrap_err().to_string();
        assert!(
            said.contains("line 4: a second header") && said.contains("split"),
            "{said}"
        );
    }
}

#[test]
fn quoted_names_may_hold_delimiters_quotes_and_line_ends() {
    let table = read("t,\"Flow, \"\"out\"\"\n(gpm)\"\n0,1\n1,x\n");
    assert_eq!(tags(&table), ["t", "Flow, \"out\""]);
    assert_eq!(unit(&table, "Flow, \"out\""), Some("gpm"));
    // The line end inside the header counts.
    assert!(
        issue(&table, IssueKind::UnreadableValue)
            .place
            .starts_with("line 4")
    );
}

#[test]
fn latin_1_headers_are_read() {
    let table = table_of(b"t,T [\xb0C]\n0,20\n1,21\n").unwrap();
    assert_eq!(unit(&table, "T"), Some("°C"));
}

#[test]
fn words_for_nothing_are_missing_values() {
    let table = read("t,a\n0,NaN\n1,\n2,NULL\n3,#N/A\n4,n/a\n5,1\n");
    assert_same(values(&table, "a"), &[NAN, NAN, NAN, NAN, NAN, 1.0]);
    assert!(table.issues.is_empty());
}

#[test]
fn log_nulls_become_missing_and_are_told() {
    let table = read("t,a,b\n0,-999.25,1\n1,5,-9999\n2,-999.2500,-999\n");
    assert_same(values(&table, "a"), &[NAN, 5.0, NAN]);
    assert_same(values(&table, "b"), &[1.0, NAN, -999.0]);
    let places: Vec<&str> = table.issues.iter().map(|i| i.place.as_str()).collect();
    assert_eq!(places, ["line 2, column `a`", "line 3, column `b`"]);
    assert!(table.issues[0].message.starts_with("2 cells with -999.25"));
}

#[test]
fn a_column_whose_cells_hold_its_unit_is_told_how_to_mend_it() {
    let table = read("t,a,b,c\n0,60.5 %,\"1.002,5 gpm\",3 of 5\n1,61 %,900 gpm,4 of 5\n");
    let said = |tag: &str| {
        let mut issues = table.issues.iter();
        let issue = issues.find(|i| i.place.ends_with(&format!("`{tag}`")));
        issue.unwrap().to_string()
    };
    assert!(
        said("a").contains("remove `%` from its cells"),
        "{}",
        said("a")
    );
    assert!(
        said("b").contains("remove `gpm` from its cells"),
        "{}",
        said("b")
    );
    assert!(
        said("c").ends_with("the column was skipped"),
        "{}",
        said("c")
    );
}

#[test]
fn unreadable_cells_are_counted_with_their_first_place() {
    let table = read("t,a\n0,1\n1,bad\n2,3\n3,worse\n");
    assert_same(values(&table, "a"), &[1.0, NAN, 3.0, NAN]);
    let issue = issue(&table, IssueKind::UnreadableValue);
    assert_eq!(issue.place, "line 3, column `a`");
    assert_eq!(
        issue.message,
        "2 cells cannot be read as numbers, the first is `bad`; read as NaN"
    );
}

#[test]
fn a_word_for_rest_is_told_as_such() {
    let table = read("t,a,b\n0,1,4\n1,Off,bad\n2,3,\"stopped\"\n3, OFF ,1\n");
    assert_same(values(&table, "a"), &[1.0, NAN, 3.0, NAN]);
    let told: Vec<String> = (table.issues.iter())
        .map(|issue| format!("{:?} {}", issue.kind, issue.message))
        .collect();
    assert_eq!(
        told,
        [
            "WordForZero 2 cells with a word that may stand for 0, the first is `Off`; read as NaN (if it does, write 0)",
            "WordForZero 1 cell with a word that may stand for 0, the first is `stopped`; read as NaN (if it does, write 0)",
            "UnreadableValue 1 cell cannot be read as numbers, the first is `bad`; read as NaN",
        ]
    );
}

#[test]
fn a_column_of_nothing_but_rest_is_passed_over() {
    let table = read("t,state,a\n0,Off,1\n1,Off,2\n");
    assert_eq!(tags(&table), ["t", "a"]);
    let told = issue(&table, IssueKind::Skipped);
    assert_eq!(told.place, "line 2, column `state`");
}

#[test]
fn a_column_of_words_is_passed_over() {
    let table = read("t,state,a\n0,drilling,1\n1,tripping,2\n");
    assert_eq!(tags(&table), ["t", "a"]);
    assert_eq!(
        issue(&table, IssueKind::Skipped).place,
        "line 2, column `state`"
    );
}

#[test]
fn ragged_lines_are_told_with_their_number() {
    let table = read("t,a,b\n0,1,2\n1\n2,3,4,5\n3,4,5\n");
    assert_same(values(&table, "a"), &[1.0, NAN, 3.0, 4.0]);
    let places: Vec<&str> = table.issues.iter().map(|i| i.place.as_str()).collect();
    assert_eq!(places, ["line 3", "line 4"]);
}

#[test]
fn a_last_line_that_is_cut_off_is_left_out() {
    let table = read("t,a,b\n0,1,2\n1,2,3\n2,5");
    assert_eq!(values(&table, "a"), [1.0, 2.0]);
    assert_eq!(issue(&table, IssueKind::Truncated).place, "line 4");
    let whole = read("t,a,b\n0,1,2\n1,2,3\n2,5,6");
    assert_eq!(values(&whole, "a"), [1.0, 2.0, 5.0]);
    assert!(whole.issues.is_empty());
}

#[test]
fn a_header_repeated_in_the_middle_is_left_out() {
    let table = read("t,a\ns,gpm\n0,1\n1,2\nt,a\ns,gpm\n2,3\n");
    assert_eq!(values(&table, "t"), [0.0, 1.0, 2.0]);
    assert_eq!(issue(&table, IssueKind::Skipped).place, "line 5");
}

#[test]
fn an_empty_row_counts_between_values_but_not_at_the_end() {
    let table = read("a,b\n1,2\n,\n3,4\n,\n,\n");
    assert_same(values(&table, "a"), &[1.0, NAN, 3.0]);
}

#[test]
fn zeros_of_a_power_loss_are_cut_off() {
    let mut bytes = b"t,a\n0,1\n1,2\n2,3\n".to_vec();
    bytes.extend([0; 512]);
    let table = table_of(&bytes).unwrap();
    assert_eq!(values(&table, "a"), [1.0, 2.0, 3.0]);
    assert_eq!(issue(&table, IssueKind::Truncated).place, "byte 16");
}

#[test]
fn equal_names_are_told_apart() {
    let table = read("a,a,a_2,a\n1,2,3,4\n");
    let mut tags = tags(&table);
    assert_eq!(tags[0], "a");
    tags.sort_unstable();
    tags.dedup();
    assert_eq!(tags.len(), 4);
}

#[test]
fn iso_stamps_become_seconds_from_the_first() {
    let expected = [0.0, 0.1, 0.5, 86_400.0];
    for stamps in [
        [
            "2024-10-22T15:27:49Z",
            "2024-10-22T15:27:49.1Z",
            "2024-10-22T15:27:49.5Z",
            "2024-10-23T15:27:49Z",
        ],
        [
            "2024/10/22 15:27:49",
            "2024/10/22 15:27:49.100",
            "2024/10/22 15:27:49.500",
            "2024/10/23 15:27:49",
        ],
        [
            "2024-10-22 17:27:49+02:00",
            "2024-10-22 17:27:49.1+02:00",
            "2024-10-22 15:27:49.5+00:00",
            "2024-10-23 17:27:49+0200",
        ],
    ] {
        let rows: String = stamps.iter().map(|s| format!("{s},1\n")).collect();
        let table = read(&format!("time,a\n{rows}"));
        assert_same(values(&table, "time"), &expected);
        assert_eq!(unit(&table, "time"), Some("s"));
        let origin = table.origin.unwrap();
        assert!(origin.starts_with("2024-10-22T15:27:49"), "{origin}");
    }
}

#[test]
fn dates_in_slashes_are_read_where_one_of_them_tells_the_day() {
    let expected = [0.0, 1.0, 7200.0, 86_400.0];
    for stamps in [
        [
            "26/10/2024 23:00:00",
            "26/10/2024 23:00:01",
            "27/10/2024 01:00:00",
            "27/10/2024 23:00:00",
        ],
        [
            "10/26/2024 23:00",
            "10/26/2024 23:00:01",
            "10/27/2024 1:00:00",
            "10/27/2024 23:00:00",
        ],
        [
            "10/26/2024 11:00:00 PM",
            "10/26/2024 11:00:01 PM",
            "10/27/2024 1:00:00 AM",
            "10/27/2024 11:00:00 pm",
        ],
    ] {
        let rows: String = stamps.iter().map(|s| format!("{s},1\n")).collect();
        let table = read(&format!("Date/Time,a\n{rows}"));
        assert_same(values(&table, "Date/Time"), &expected);
        assert_eq!(table.origin.as_deref(), Some("2024-10-26T23:00:00-00:00"));
    }
    // Noon is twelve in the afternoon, midnight twelve before noon.
    let table = read("t,a\n10/26/2024 12:00:00 AM,1\n10/26/2024 12:00:00 PM,1\n");
    assert_same(values(&table, "t"), &[0.0, 43_200.0]);
    // Beside a column of dates, and in a file of decimal commas.
    let table = read(
        "Date,Time,a\n2024-10-26,11:59:59 AM,1\n2024-10-26,12:00:00 PM,2\n2024-10-26,1:00:00 PM,3\n",
    );
    assert_same(values(&table, "Time"), &[0.0, 1.0, 3601.0]);
    let table = read("Tid;a\n26/10/2024 23:00:00;1,5\n26/10/2024 23:00:01;2,5\n");
    assert_same(values(&table, "Tid"), &[0.0, 1.0]);
    assert_same(values(&table, "a"), &[1.5, 2.5]);
    // No clock has such an hour.
    let good: String = (0..6)
        .map(|k| format!("2024-10-26 11:00:0{k} PM,1\n"))
        .collect();
    let table = read(&format!(
        "t,a\n{good}2024-10-26 23:00:07 AM,2\n2024-10-26 0:15:00 PM,3\n"
    ));
    assert!(values(&table, "t")[6..].iter().all(|t| t.is_nan()));
}

#[test]
fn dates_that_could_be_either_are_passed_over_with_what_to_write() {
    for stamps in [
        ["03/04/2024 10:00:00", "03/04/2024 10:00:01"],
        // Told both ways.
        ["13/04/2024 10:00:00", "04/13/2024 10:00:01"],
    ] {
        let rows: String = stamps.iter().map(|s| format!("{s},1\n")).collect();
        let table = read(&format!("when,a\n{rows}"));
        assert_eq!(tags(&table), ["a"]);
        let message = &table.issues[0].message;
        assert!(message.contains("write the year first"), "{message}");
    }
}

#[test]
fn a_stamp_is_no_missing_value_whatever_its_seconds() {
    // In reverse: the last lies 9,999 s before the first.
    let table = read("time,a\n2024-10-22T03:00:00,1\n2024-10-22T00:13:21,2\n");
    assert_same(values(&table, "time"), &[0.0, -9999.0]);
    assert!(table.issues.is_empty(), "{:?}", table.issues);
}

#[test]
fn a_stamp_without_a_zone_says_so_in_the_origin() {
    let origin = |text: &str| read(text).origin;
    assert_eq!(
        origin("time,a\n2024-10-22 15:27:49.648,1\n").as_deref(),
        Some("2024-10-22T15:27:49.648-00:00")
    );
    assert_eq!(
        origin("time,a\n2024-10-22T15:27:49+02:00,1\n").as_deref(),
        Some("2024-10-22T13:27:49Z")
    );
    assert_eq!(origin("time,a\n15:27:49,1\n"), None);
}

#[test]
fn clocks_run_on_past_midnight_and_past_the_hour() {
    assert_same(
        values(
            &read("time,a\n23:59:59,1\n00:00:00,2\n00:00:01,3\n"),
            "time",
        ),
        &[0.0, 1.0, 2.0],
    );
    assert_same(
        values(&read("time,a\n59:59.9,1\n00:00.0,2\n00:00.1,3\n"), "time"),
        &[0.0, 0.1, 0.2],
    );
    assert_same(
        values(&read("time,a\n14:11,1\n14:12,2\n"), "time"),
        &[0.0, 60.0],
    );
}

#[test]
fn date_and_clock_columns_are_one_clock() {
    let table =
        read("Date,Time,a\n2024/10/22,23:59:59,1\n2024/10/23,00:00:00,2\n2024/10/25,00:00:00,3\n");
    assert_eq!(tags(&table), ["Time", "a"]);
    assert_same(values(&table, "Time"), &[0.0, 1.0, 172_801.0]);
    assert_eq!(table.origin.as_deref(), Some("2024-10-22T23:59:59-00:00"));
}

#[test]
fn a_bad_stamp_is_missing_and_told() {
    let table =
        read("time,a\n2024-10-22 00:00:00,1\n2024-10-32 00:00:01,2\n2024-10-22 00:00:02,3\n");
    assert_same(values(&table, "time"), &[0.0, NAN, 2.0]);
    assert_eq!(
        issue(&table, IssueKind::UnreadableValue).place,
        "line 3, column `time`"
    );
}

#[test]
fn epoch_numbers_become_seconds_from_the_first() {
    for scale in [1.0, 1e3, 1e6] {
        let row = |s: f64| format!("{},1\n", 1_412_640_000.0 * scale + s * scale);
        let table = read(&format!("timestamp,a\n{}{}", row(0.0), row(2.0)));
        assert_same(values(&table, "timestamp"), &[0.0, 2.0]);
        assert_eq!(table.origin.as_deref(), Some("2014-10-07T00:00:00Z"));
    }
    // Large numbers under another name stay as they are.
    assert_eq!(
        values(&read("count,a\n1412640000,1\n"), "count"),
        [1_412_640_000.0]
    );
}

#[test]
fn a_stated_unit_of_time_tells_dates_from_counters() {
    let stamped = |unit: &str, first: f64, step: f64| {
        read(&format!("time [{unit}],a\n{first},1\n{},2\n", first + step))
    };
    // A counter in ms or µs that runs for days is no date in seconds.
    for counter in ["ms", "us", "µs"] {
        let table = stamped(counter, 1e9, 1e3);
        assert_same(values(&table, "time"), &[1e9, 1e9 + 1e3]);
        assert_eq!(
            (unit(&table, "time"), &table.origin),
            (Some(counter), &None)
        );
    }
    for (written, scale) in [
        ("s", 1.0),
        ("ms", 1e3),
        ("us", 1e6),
        ("ns", 1e9),
        ("UTC", 1.0),
    ] {
        let table = stamped(written, 1_412_640_000.0 * scale, 2.0 * scale);
        assert_same(values(&table, "time"), &[0.0, 2.0]);
        assert_eq!(unit(&table, "time"), Some("s"));
        assert_eq!(table.origin.as_deref(), Some("2014-10-07T00:00:00Z"));
    }
    let days = stamped("d", 1e9, 1.0);
    assert_same(values(&days, "time"), &[1e9, 1e9 + 1.0]);
}

#[test]
fn every_cell_agrees_with_an_independent_parser() {
    let mut dice = crate::Dice(7);
    let mut text = String::from("t,a,b\n");
    for row in 0..500 {
        let mut number = || {
            let size = 10_f64.powi(dice.below(30) as i32 - 15);
            (dice.next() as f64 - 1e9) * size
        };
        text += &format!("{row},{:e},\"{}\"\n", number(), number());
    }
    let table = read(&text);
    let mut oracle = ::csv::Reader::from_reader(text.as_bytes());
    for (row, record) in oracle.records().enumerate() {
        for (column, cell) in table.columns.iter().zip(&record.unwrap()) {
            assert_eq!(
                column.values[row].to_bits(),
                cell.parse::<f64>().unwrap().to_bits()
            );
        }
    }
}

#[test]
fn utf_16_is_refused_with_the_mend() {
    let text = "t,a\n0,1\n1,2\n";
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let marked = [vec![0xff, 0xfe], little.clone()].concat();
    for bytes in [little, marked] {
        let error = table_of(&bytes).unwrap_err();
        assert!(
            matches!(
                error,
                IngestError::Unsupported {
                    format: "UTF-16 text",
                    ..
                }
            ),
            "{error}"
        );
    }
}

#[test]
fn blanks_between_numbers_are_refused_with_the_mend() {
    let error = table_of(b"t a\n0 1.5\n1 2.5\n").unwrap_err();
    assert!(matches!(error, IngestError::NotTabular { .. }), "{error}");
}

#[test]
fn text_without_numbers_is_refused() {
    for text in [
        "t,FT1,FT2\n",
        "t,a\ns,gpm\n",
        "just words\nand more\n",
        "a,b\n,\n,\n",
    ] {
        let error = table_of(text.as_bytes()).unwrap_err();
        assert!(
            matches!(error, IngestError::NothingNumeric { format: "CSV", .. }),
            "{text:?}: {error}"
        );
    }
}

#[test]
fn numbers_from_1970_are_times_under_every_name_of_a_clock() {
    for name in ["tid", "seconds", "elapsed", "unix", "utc", "Date Time"] {
        let table = read(&format!("a,{name}\n1,1412640000\n2,1412640002\n"));
        assert_same(values(&table, name), &[0.0, 2.0]);
        assert_eq!(table.origin.as_deref(), Some("2014-10-07T00:00:00Z"));
        // The survey takes no other column for the clock.
        assert_eq!(dgd_recording::survey(&table).time_column, Some(1), "{name}");
    }
}

#[test]
fn minutes_above_23_far_down_tell_that_two_fields_are_minutes_and_seconds() {
    // A second a row from 00:00 on: above 23:59 below the sampled rows of the start, and those of the middle are past the hour.
    let from = |first: u32, rows: u32| -> String {
        let row = |s: u32| format!("{:02}:{:02},{s}\n", s / 60 % 60, s % 60);
        (first..first + rows).map(row).collect()
    };
    for rows in [2200, 7400] {
        let text = format!("time,a\n{}", from(0, rows));
        let table = read(&text);
        let expected: Vec<f64> = (0..rows).map(f64::from).collect();
        assert_same(values(&table, "time"), &expected);
        // In blocks too.
        let options = dgd_ingest::ReadOptions::default();
        let limits = dgd_ingest::BlockOptions {
            cells: 1000,
            ..Default::default()
        };
        let file = std::io::Cursor::new(text);
        let opened = dgd_ingest::BlockReader::open(file, &options, limits).unwrap();
        let dgd_ingest::Opened::Blocks(mut blocks) = opened else {
            panic!("rows of one layout");
        };
        let mut found = Vec::new();
        while let Some(block) = blocks.next_block().unwrap() {
            found.extend_from_slice(&block.columns[0].values);
        }
        assert_same(&found, &expected);
    }
    // Hours stay hours.
    let table = read(&format!("time,a\n{}", from(0, 1440)));
    assert_same(&values(&table, "time")[..2], &[0.0, 60.0]);
}

#[test]
fn a_second_header_with_another_unit_is_refused_with_its_line() {
    let said = |text: &str| {
        let options = dgd_ingest::ReadOptions::default();
        dgd_ingest::read(text.as_bytes(), &options).map_err(|error| error.to_string())
    };
    for (first, second) in [
        ("t [s],FT4 [gpm]", "t [s],FT4 [l/min]"),
        ("t,FT4\ns,gpm", "t,FT4\ns,l/min"),
        ("t,FT4\ns,gpm", "s,l/min"),
        ("t,FT4\ns,gpm", "t (s),FT4 (l/min)"),
    ] {
        let text = format!("{first}\n0,1\n1,2\n2,3\n{second}\n3,4\n4,5\n");
        let refused = said(&text).unwrap_err();
        assert!(
            refused.contains("`l/min`") && refused.contains("split"),
            "{refused}"
        );
    }
    for (first, second) in [
        ("t [s],FT4 [gpm]", "t [s],FT4 [gpm]"),
        ("t [s],FT4 [gpm]", "t [s],FT4 [gal/min]"),
        ("t [s],FT4 [gpm]", "t,FT4"),
        ("t,FT4", "t [s],FT4 [gpm]"),
        ("t,FT4\ns,gpm", "t,FT4\n[s],[gpm]"),
        ("t [min],FT4 [gpm]\ns,gpm", "t [min],FT4 [gpm]\ns,gpm"),
        // A remark.
        ("t [s],FT4 [gpm]", ",FT4 [l/min]"),
    ] {
        let text = format!("{first}\n0,1\n1,2\n2,3\n{second}\n3,4\n4,5\n");
        let (_, table) = said(&text).unwrap();
        assert_eq!(values(&table, "FT4").len(), 5, "{second}");
    }
}

#[test]
fn a_row_with_a_word_in_each_column_keeps_its_place() {
    let bad = "Bad Input,Bad Input\n";
    let table = read(&format!(
        "FT1,PT1\ngpm,bar\n700,98\n{bad}{bad}702,100\n703,101\n{bad}"
    ));
    assert_same(values(&table, "FT1"), &[700.0, NAN, NAN, 702.0, 703.0]);
    let told = issue(&table, IssueKind::Skipped);
    assert_eq!(told.place, "line 4");
    assert!(
        told.message.starts_with("3 rows with words in all columns"),
        "{told}"
    );
    // Remarks, comments, units and names are none.
    for remark in ["Connection made,", "# pause,x", "gpm,bar", "FT1,PT1"] {
        let table = read(&format!("FT1,PT1\ngpm,bar\n700,98\n{remark}\n702,100\n"));
        assert_same(values(&table, "FT1"), &[700.0, 702.0]);
    }
}

#[test]
fn a_date_written_with_midnight_is_the_date_of_the_clock_beside_it() {
    for date in [
        "2024-10-22 00:00:00",
        "2024-10-22T00:00:00",
        "22.10.2024 00:00",
    ] {
        let rows: String = (0..3)
            .map(|s| format!("{date},15:27:0{s},70{s}\n"))
            .collect();
        let table = read(&format!("DATE,TIME,FT4\n,,gpm\n{rows}"));
        assert_eq!(tags(&table), ["TIME", "FT4"]);
        assert_same(values(&table, "TIME"), &[0.0, 1.0, 2.0]);
        assert_eq!(table.origin.as_deref(), Some("2024-10-22T15:27:00-00:00"));
    }
    // A stamp in full is no such date.
    let table =
        read("when,TIME,a\n2024-10-22 15:00:00,15:27:00,1\n2024-10-22 15:00:01,15:27:01,2\n");
    assert_eq!(tags(&table), ["when", "TIME", "a"]);
    assert_same(values(&table, "when"), &[0.0, 1.0]);
}

#[test]
fn a_date_that_stays_does_not_keep_a_clock_from_passing_midnight() {
    let table = read(
        "Spud Date,Time,a\n2024-10-01,23:59:58,1\n2024-10-01,23:59:59,2\n2024-10-01,00:00:00,3\n2024-10-01,00:00:01,4\n",
    );
    assert_same(values(&table, "Time"), &[0.0, 1.0, 2.0, 3.0]);
    // A date that comes a row late.
    let table = read(
        "Date,Time,a\n2024-10-01,23:59:59,1\n2024-10-01,00:00:00,2\n2024-10-02,00:00:01,3\n2024-10-02,23:00:00,4\n",
    );
    assert_same(values(&table, "Time"), &[0.0, 1.0, 2.0, 82_801.0]);
    // From the newest row to the oldest, with a gap of more than half a day.
    let table = read(
        "Date,Time,a\n2024-10-02,20:00:02,1\n2024-10-02,20:00:01,2\n2024-10-02,06:00:00,3\n2024-10-01,20:00:00,4\n",
    );
    assert_same(values(&table, "Time"), &[0.0, -1.0, -50_402.0, -86_402.0]);
}

#[test]
fn a_number_cut_off_at_the_end_is_no_value_and_a_missing_line_end_is_no_fault() {
    let row = |i: u32| format!("{i},{}.{}\n", 700 + i, i % 10);
    let text = |rows: u32| -> String { (0..rows).map(row).collect() };
    let read = |text: &str| read(&format!("t,FT1\ns,gpm\n{text}"));
    for part in ["200,90", "200,900", "200,900.", "200,9"] {
        let table = read(&format!("{}{part}", text(200)));
        assert_eq!(values(&table, "t")[200], 200.0);
        assert!(values(&table, "FT1")[200].is_nan(), "{part}");
        assert_eq!(issue(&table, IssueKind::Truncated).place, "line 203");
    }
    // Whole; ended by a line end; of few rows; and of numbers in their shortest form.
    let shortest = text(200).replace(".0\n", "\n");
    for sound in [
        format!("{}200,900.5", text(200)),
        format!("{}200,900\n", text(200)),
        format!("{}20,900", text(20)),
        format!("{shortest}200,900"),
    ] {
        let table = read(&sound);
        assert!(table.issues.is_empty(), "{:?}", table.issues);
        assert!(values(&table, "FT1").iter().all(|v| v.is_finite()));
    }
}

#[test]
fn a_zone_in_letters_is_told_with_the_offset_to_write() {
    let text = "time,x\n2024-10-27 00:30:00 CEST,1\n2024-10-27 00:30:01 CEST,2\n";
    let table = table_of(text.as_bytes()).unwrap();
    assert_eq!(table.columns.len(), 1);
    let skipped = issue(&table, IssueKind::Skipped);
    assert!(
        skipped.message.contains("`CEST` does not tell a time zone")
            && skipped.message.contains("+02:00"),
        "{}",
        skipped.message
    );
}

#[test]
fn names_that_repeat_below_those_of_groups_or_tags_are_told_apart_by_them() {
    let rows = "0,500,700,10\n1,501,701,11\n2,502,702,12\n";
    let named = |header: &str| {
        let table = table_of(format!("{header}\n{rows}").as_bytes()).unwrap();
        let units = table
            .columns
            .iter()
            .map(|c| c.unit.clone().unwrap_or_default());
        let tags = table.columns.iter().map(|c| c.tag.clone());
        (tags.collect::<Vec<_>>(), units.collect::<Vec<_>>())
    };
    // A group over each column, or over the first of its own.
    let (tags, units) = named(",Mud pump,Return,Inlet\nTime,Flow,Flow,P1\ns,gpm,gpm,bar");
    assert_eq!(tags, ["Time", "Mud pump Flow", "Return Flow", "Inlet P1"]);
    assert_eq!(units, ["s", "gpm", "gpm", "bar"]);
    let (tags, _) = named(",Pumps,,Line\nTime,Flow,Speed,Flow\ns,gpm,%,gpm");
    assert_eq!(tags, ["Time", "Pumps Flow", "Pumps Speed", "Line Flow"]);
    // What each measures, below its tag.
    let (tags, _) = named("t,FT1,FT4,PT1\n,Flow,Flow,Pressure\ns,gpm,gpm,bar");
    assert_eq!(tags, ["t", "FT1", "FT4", "PT1"]);
    // A title is no group, and what stays equal is told apart by number.
    let (tags, _) = named("Report of the 3rd\nTime,Flow,Flow,P1\ns,gpm,gpm,bar");
    assert_eq!(tags, ["Time", "Flow", "Flow_2", "P1"]);
}
