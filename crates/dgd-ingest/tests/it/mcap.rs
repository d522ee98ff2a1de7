//! MCAP logs, sound and broken.

use crate::{assert_same, issue, table_of, unit, values};
use dgd_ingest::IngestError;
use dgd_recording::IssueKind;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::Cursor;

const NAN: f64 = f64::NAN;
const SECOND: u64 = 1_000_000_000;

/// A log being written.
struct Log(Writer<Cursor<Vec<u8>>>);

impl Log {
    fn new(options: WriteOptions) -> Self {
        let options = options.compression_threads(0);
        Self(options.create(Cursor::new(Vec::new())).unwrap())
    }

    fn channel(&mut self, topic: &str, encoding: &str, schema: &str) -> u16 {
        let schema = match schema {
            "" => 0,
            text => self
                .0
                .add_schema(topic, "jsonschema", text.as_bytes())
                .unwrap(),
        };
        self.0
            .add_channel(schema, topic, encoding, &BTreeMap::new())
            .unwrap()
    }

    fn write(&mut self, channel_id: u16, log_time: u64, text: &str) {
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        self.0
            .write_to_known_channel(&header, text.as_bytes())
            .unwrap();
    }

    fn bytes(mut self) -> Vec<u8> {
        self.0.finish().unwrap();
        self.0.into_inner().into_inner()
    }
}

/// One topic, a sample a second, many chunks.
fn plain(options: WriteOptions, samples: u64) -> Vec<u8> {
    let mut log = Log::new(options.chunk_size(Some(1000)));
    let rig = log.channel("/rig", "json", "");
    for i in 0..samples {
        log.write(
            rig,
            100 * SECOND + i * SECOND,
            &format!(r#"{{"FT1":{i}.5,"SPM":{}}}"#, i % 10),
        );
    }
    log.bytes()
}

fn position(bytes: &[u8], wanted: &[u8], nth: usize) -> usize {
    let mut places = bytes
        .windows(wanted.len())
        .enumerate()
        .filter(|(_, w)| *w == wanted);
    places.nth(nth).unwrap().0
}

#[test]
fn every_compression_gives_the_same_table() {
    let expected = table_of(&plain(WriteOptions::new().compression(None), 200)).unwrap();
    assert_eq!(values(&expected, "t")[199], 199.0);
    assert_eq!(values(&expected, "FT1")[199], 199.5);
    assert!(expected.issues.is_empty());
    for options in [
        WriteOptions::new().compression(Some(Compression::Zstd)),
        WriteOptions::new().compression(Some(Compression::Lz4)),
        WriteOptions::new().use_chunks(false),
        WriteOptions::new().calculate_chunk_crcs(false),
    ] {
        assert_eq!(table_of(&plain(options, 200)).unwrap(), expected);
    }
}

#[test]
fn members_become_columns_by_path() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    log.write(
        rig,
        0,
        r#"{"a": {"b": 1, "on": true}, "p": [2, 3.5], "name": "x", "n": null, "q": NaN}"#,
    );
    log.write(rig, SECOND, r#"{"late": 9, "p": [4], "a": {"on": false}}"#);
    let table = table_of(&log.bytes()).unwrap();
    assert_same(values(&table, "a.b"), &[1.0, NAN]);
    assert_same(values(&table, "a.on"), &[1.0, 0.0]);
    assert_same(values(&table, "p[0]"), &[2.0, 4.0]);
    assert_same(values(&table, "p[1]"), &[3.5, NAN]);
    assert_same(values(&table, "n"), &[NAN, NAN]);
    assert_same(values(&table, "late"), &[NAN, 9.0]);
    assert!(table.column("name").is_none());
}

#[test]
fn the_log_is_the_clock_and_a_members_own_time_stays_beside_it() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    log.write(
        rig,
        1_412_640_000 * SECOND,
        r#"{"t": 7, "time": 8, "a": 1}"#,
    );
    log.write(
        rig,
        1_412_640_000 * SECOND + SECOND / 10,
        r#"{"t": 8, "time": 9, "a": 2}"#,
    );
    let table = table_of(&log.bytes()).unwrap();
    assert_same(values(&table, "t"), &[0.0, 0.1]);
    assert_same(values(&table, "rig.t"), &[7.0, 8.0]);
    assert_same(values(&table, "time"), &[8.0, 9.0]);
    assert_eq!(table.origin.as_deref(), Some("2014-10-07T00:00:00Z"));
}

#[test]
fn units_come_from_the_schema_and_from_metadata() {
    let schema = r#"{"properties": {"FT1": {"type": "number", "unit": "gpm"}, "PT1": {"description": "inlet (psia)"}}}"#;
    let mut log = Log::new(WriteOptions::new());
    let schema = log
        .0
        .add_schema("s", "jsonschema", schema.as_bytes())
        .unwrap();
    let metadata = BTreeMap::from([("SPM.unit".to_owned(), "%".to_owned())]);
    let rig = log
        .0
        .add_channel(schema, "/rig", "json", &metadata)
        .unwrap();
    log.write(rig, 0, r#"{"FT1": 1, "PT1": 2, "SPM": 3}"#);
    let table = table_of(&log.bytes()).unwrap();
    assert_eq!(unit(&table, "t"), Some("s"));
    assert_eq!(unit(&table, "FT1"), Some("gpm"));
    assert_eq!(unit(&table, "PT1"), Some("psia"));
    assert_eq!(unit(&table, "SPM"), Some("%"));
}

#[test]
fn several_topics_come_onto_the_busiest_ones_clock() {
    let mut log = Log::new(WriteOptions::new());
    let slow = log.channel("/tank", "json", "");
    let fast = log.channel("/rig/flow", "json", "");
    for i in 0..10_u64 {
        log.write(fast, i * SECOND, &format!(r#"{{"q": {i}}}"#));
        if i % 5 == 0 {
            log.write(
                slow,
                i * SECOND + SECOND / 100,
                &format!(r#"{{"level": {i}}}"#),
            );
        }
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_eq!(values(&table, "t").len(), 10);
    assert_eq!(values(&table, "rig.flow.q")[9], 9.0);
    // The nearest within 0.6 of the slow topic's 5 s, not the last one.
    assert_same(
        values(&table, "tank.level"),
        &[0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, NAN],
    );
    assert_eq!(issue(&table, IssueKind::Jitter).place, "topic `/tank`");
}

#[test]
fn topics_in_step_are_not_delayed_against_each_other() {
    let mut log = Log::new(WriteOptions::new());
    let first = log.channel("/a", "json", "");
    let second = log.channel("/b", "json", "");
    for i in 0..5_u64 {
        log.write(first, i * SECOND, &format!(r#"{{"x": {i}}}"#));
        log.write(second, i * SECOND + 300, &format!(r#"{{"x": {i}}}"#));
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_same(values(&table, "b.x"), values(&table, "a.x"));
}

#[test]
fn messages_that_share_a_log_time_keep_those_behind_them_within_reach() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    let tank = log.channel("/tank", "json", "");
    for i in 0..10_u64 {
        log.write(rig, i * SECOND, &format!(r#"{{"a": {i}}}"#));
    }
    for (s, level) in [(0, 0), (2, 2), (2, 20), (4, 4), (6, 6), (8, 8)] {
        log.write(tank, s * SECOND, &format!(r#"{{"level": {level}}}"#));
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_same(
        values(&table, "tank.level"),
        &[0.0, 0.0, 20.0, 20.0, 4.0, 4.0, 6.0, 6.0, 8.0, 8.0],
    );
}

#[test]
fn messages_out_of_order_are_sorted_and_told() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    for i in [0_u64, 2, 1, 3] {
        log.write(rig, i * SECOND, &format!(r#"{{"a": {i}}}"#));
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_same(values(&table, "a"), &[0.0, 1.0, 2.0, 3.0]);
    assert_eq!(issue(&table, IssueKind::BackwardTime).place, "topic `/rig`");
}

#[test]
fn a_clock_that_was_set_back_is_left_for_whoever_reads_it() {
    let mut log = Log::new(WriteOptions::new());
    let channel = log.channel("/rig", "json", "");
    for s in (0..40).chain(20..60) {
        log.write(channel, s * SECOND, &format!(r#"{{"a":{s}}}"#));
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_eq!(values(&table, "t")[39..42], [39.0, 20.0, 21.0]);
    let told = issue(&table, IssueKind::BackwardTime);
    assert!(told.message.contains("left as logged"), "{told}");
}

#[test]
fn a_clock_that_was_set_back_is_left_beside_other_topics_too() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    let tank = log.channel("/tank", "json", "");
    for s in (0..40).chain(20..60) {
        log.write(rig, s * SECOND, &format!(r#"{{"a":{s}}}"#));
    }
    for s in 0..60 {
        log.write(tank, s * SECOND, &format!(r#"{{"level":{s}}}"#));
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_eq!(values(&table, "t")[39..42], [39.0, 20.0, 21.0]);
    assert_eq!(values(&table, "rig.a")[39..42], [39.0, 20.0, 21.0]);
    assert_same(values(&table, "tank.level"), values(&table, "t"));
    let told = issue(&table, IssueKind::BackwardTime);
    assert_eq!(told.place, "topic `/rig`");
}

#[test]
fn a_channel_may_name_the_clock() {
    let logged = |tag: &str, member: &str| {
        let mut log = Log::new(WriteOptions::new());
        let metadata = [("time_tag".to_owned(), tag.to_owned())].into();
        let channel = log.0.add_channel(0, "/rig", "json", &metadata).unwrap();
        for s in 0..3 {
            log.write(channel, s * SECOND, &format!(r#"{{"{member}":{s}}}"#));
        }
        let table = table_of(&log.bytes()).unwrap();
        let tags: Vec<String> = table.columns.into_iter().map(|c| c.tag).collect();
        tags.join(" ")
    };
    assert_eq!(logged("time", "a"), "time a");
    assert_eq!(logged("time", "t"), "time t");
    assert_eq!(logged("time", "time"), "t time");
    assert_eq!(logged("", "a"), "t a");
    assert_eq!(logged("t", "t"), "t rig.t");
}

#[test]
fn other_encodings_and_bad_json_are_passed_over_and_told() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    let camera = log.channel("/camera", "protobuf", "");
    log.write(rig, 0, r#"{"a": 1}"#);
    log.write(rig, SECOND, r#"{"a": 1"#);
    log.write(rig, 2 * SECOND, r#"{"a": 3}"#);
    log.write(camera, 0, "xyz");
    let table = table_of(&log.bytes()).unwrap();
    assert_same(values(&table, "a"), &[1.0, 3.0]);
    assert!(
        issue(&table, IssueKind::Damaged)
            .message
            .contains("number 2, wrong at its byte 7")
    );
    assert_eq!(issue(&table, IssueKind::Skipped).place, "topic `/camera`");
}

#[test]
fn a_log_without_numbers_is_refused() {
    let mut log = Log::new(WriteOptions::new());
    let camera = log.channel("/camera", "cdr", "");
    log.write(camera, 0, "xyz");
    let error = table_of(&log.bytes()).unwrap_err();
    assert!(
        matches!(&error, IngestError::NothingNumeric { format: "MCAP", found } if found.contains("cdr")),
        "{error}"
    );
    let error = table_of(&plain(WriteOptions::new(), 0)).unwrap_err();
    assert!(
        matches!(error, IngestError::NothingNumeric { .. }),
        "{error}"
    );
}

#[test]
fn a_truncated_log_is_recovered_as_far_as_it_goes() {
    for options in [
        WriteOptions::new().compression(None),
        WriteOptions::new().compression(Some(Compression::Lz4)),
        WriteOptions::new().compression(Some(Compression::Zstd)),
    ] {
        let bytes = plain(options, 500);
        let table = table_of(&bytes[..bytes.len() / 2]).unwrap();
        let kept = values(&table, "FT1");
        assert!(kept.len() > 100 && kept.len() < 500, "{}", kept.len());
        let expected: Vec<f64> = (0..kept.len()).map(|i| i as f64 + 0.5).collect();
        assert_same(kept, &expected);
        let issue = issue(&table, IssueKind::Truncated);
        assert!(
            issue
                .message
                .contains(&format!("{} messages recovered", kept.len())),
            "{issue}"
        );
    }
}

#[test]
fn of_a_cut_uncompressed_chunk_the_whole_messages_are_kept() {
    let bytes = plain(WriteOptions::new().compression(None).chunk_size(None), 100);
    let cut = position(&bytes, br#"{"FT1":50.5"#, 0);
    let table = table_of(&bytes[..cut]).unwrap();
    assert_eq!(values(&table, "FT1").len(), 50);
}

#[test]
fn a_chunk_with_a_wrong_checksum_is_left_out_and_told() {
    let mut bytes = plain(WriteOptions::new().compression(None), 100);
    let at = position(&bytes, br#"{"FT1":50.5"#, 0);
    bytes[at + 7] = b'9';
    let table = table_of(&bytes).unwrap();
    let kept = values(&table, "FT1");
    assert!(!kept.contains(&90.5) || kept.iter().filter(|v| **v == 90.5).count() == 1);
    assert!(!kept.contains(&50.5));
    assert!(
        kept.contains(&0.5) && kept.contains(&99.5),
        "what lies before and behind is kept"
    );
    let issue = issue(&table, IssueKind::Damaged);
    assert!(
        issue.place.starts_with("byte ") && issue.message.contains("damaged chunk"),
        "{issue}"
    );
}

#[test]
fn a_wrong_record_length_costs_what_it_covers_and_no_more() {
    let bytes = plain(WriteOptions::new(), 300);
    let chunk = position(&bytes, b"zstd", 2) - 41;
    for wrong in [0_u64, 17, 1_000_000, u64::MAX] {
        let mut bytes = bytes.clone();
        bytes[chunk + 1..chunk + 9].copy_from_slice(&wrong.to_le_bytes());
        let table = table_of(&bytes).unwrap();
        let kept = values(&table, "FT1");
        assert!(
            kept.contains(&0.5) && kept.contains(&299.5),
            "length {wrong}"
        );
        assert!(
            kept.len() > 250 && kept.len() < 300,
            "length {wrong} leaves {}",
            kept.len()
        );
        assert!(table.issues.iter().any(|i| i.kind == IssueKind::Damaged));
    }
}

#[test]
fn a_chunk_that_claims_to_unpack_to_terabytes_is_left_out() {
    let mut bytes = plain(WriteOptions::new(), 300);
    let size = position(&bytes, b"zstd", 1) - 16;
    bytes[size..size + 8].copy_from_slice(&(1_u64 << 42).to_le_bytes());
    let table = table_of(&bytes).unwrap();
    assert!(
        issue(&table, IssueKind::Damaged)
            .message
            .contains("the limit is")
    );
    assert!(values(&table, "FT1").len() > 250);
}

#[test]
fn ever_new_members_are_refused_not_stored() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    for i in 0..5000 {
        log.write(rig, i, &format!(r#"{{"m{i}": 1}}"#));
    }
    let error = table_of(&log.bytes()).unwrap_err();
    assert!(matches!(error, IngestError::TooLarge { .. }), "{error}");
}

#[test]
fn members_that_cover_few_messages_have_a_bound() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    for i in 0..40_000 {
        log.write(rig, i, &format!(r#"{{"m{}": 1}}"#, i % 4000));
    }
    let error = table_of(&log.bytes()).unwrap_err();
    assert!(matches!(error, IngestError::TooLarge { .. }), "{error}");
}

#[test]
fn a_log_written_by_another_library_is_read() {
    let table = table_of(include_bytes!("../data/mcap/python-lz4.mcap")).unwrap();
    assert_same(values(&table, "t"), &[0.0, 1.0, 2.0, 3.0]);
    assert_same(values(&table, "rig.FT4"), &[796.5, 797.0, NAN, 798.25]);
    assert_same(
        values(&table, "tank.level"),
        &[0.1, 0.2, 0.30000000000000004, 0.4],
    );
    assert_eq!(unit(&table, "FT4"), Some("gpm"));
    assert_eq!(table.origin.as_deref(), Some("2014-10-07T00:00:00Z"));
}

#[test]
fn a_second_column_of_a_name_gets_another_and_it_is_told() {
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    let pump = log.channel("/rig/pump", "json", "");
    for i in 0..3 {
        log.write(rig, i * SECOND, r#"{"pump":{"speed":50}}"#);
        log.write(pump, i * SECOND, r#"{"speed":99}"#);
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_same(values(&table, "rig.pump.speed"), &[50.0; 3]);
    assert_same(values(&table, "rig.pump.speed_2"), &[99.0; 3]);
    assert_eq!(issue(&table, IssueKind::Renamed).place, "column 3");
    // Of one topic, which is read in blocks too.
    let mut log = Log::new(WriteOptions::new());
    let rig = log.channel("/rig", "json", "");
    log.write(rig, 0, r#"{"t":7,"rig.t":8}"#);
    let bytes = log.bytes();
    let whole = table_of(&bytes).unwrap();
    assert_same(values(&whole, "rig.t_2"), &[8.0]);
    let (options, limits) = Default::default();
    let opened = dgd_ingest::BlockReader::open(Cursor::new(bytes), &options, limits).unwrap();
    let dgd_ingest::Opened::Blocks(blocks) = opened else {
        panic!("one topic in order");
    };
    assert_eq!(blocks.head().issues, whole.issues);
    assert_eq!(blocks.head().columns[2].tag, "rig.t_2");
}

#[test]
fn messages_that_are_nobodys_nearest_are_counted() {
    let mut log = Log::new(WriteOptions::new());
    let slow = log.channel("/slow", "json", "");
    let fast = log.channel("/fast", "json", "");
    // Long at 1 Hz, beside two seconds at 50 Hz.
    for i in 0..200_u64 {
        log.write(slow, i * SECOND, &format!(r#"{{"a": {i}}}"#));
    }
    for i in 0..101_u64 {
        log.write(fast, i * SECOND / 50, &format!(r#"{{"b": {i}}}"#));
    }
    let table = table_of(&log.bytes()).unwrap();
    assert_same(&values(&table, "fast.b")[..4], &[0.0, 50.0, 100.0, NAN]);
    let told = issue(&table, IssueKind::Crowded);
    assert_eq!(told.place, "topic `/fast`");
    assert!(told.message.starts_with("98 of its 101 messages"), "{told}");
}
