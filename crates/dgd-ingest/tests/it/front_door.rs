//! Detection, names, files.

use dgd_ingest::{FileError, Format, IngestError, ReadOptions, detect, read, read_file};
use dgd_recording::IssueKind;

#[test]
fn the_content_decides_and_a_wrong_name_is_told() {
    let bytes = b"t,a\n0,1\n1,2\n";
    let named = |name: &str| {
        let options = ReadOptions {
            name_hint: Some(name.into()),
        };
        read(bytes, &options).unwrap()
    };
    let (format, table) = named("recording.mat");
    assert_eq!(format, Format::Csv);
    assert_eq!(table.issues[0].kind, IssueKind::Skipped);
    assert_eq!(table.issues[0].place, "file name");
    for right in [
        "recording.csv",
        "RECORDING.CSV",
        "recording.txt",
        "recording",
    ] {
        assert!(named(right).1.issues.is_empty(), "{right}");
    }
}

#[test]
fn formats_are_told_from_their_first_bytes() {
    let mut mat5 = [b' '; 128];
    mat5[124..].copy_from_slice(&[0, 1, b'I', b'M']);
    assert_eq!(detect(&mat5), Ok(Format::Mat5));
    let mut mat73 = vec![0; 512];
    mat73.extend(b"\x89HDF\r\n\x1a\n");
    assert_eq!(detect(&mat73), Ok(Format::Mat73));
    assert_eq!(detect(b"\x89MCAP0\r\n"), Ok(Format::Mcap));
    assert_eq!(detect(b"t,a\n"), Ok(Format::Csv));
    assert_eq!(Format::Mat73.to_string(), "MAT v7.3");
}

#[test]
fn foreign_formats_are_named_with_a_mend() {
    for (bytes, word) in [
        (&b"PK\x03\x04rest"[..], "spreadsheet"),
        (b"\x1f\x8b\x08\0", "gzip"),
        (b"#ROSBAG V2.0\n", "ROS bag"),
        (b"PAR1\0\0", "Parquet"),
    ] {
        let error = detect(bytes).unwrap_err();
        assert!(matches!(error, IngestError::Unsupported { .. }));
        assert!(error.to_string().contains(word), "{error}");
    }
}

#[test]
fn nothing_and_noise_are_refused() {
    assert_eq!(detect(b""), Err(IngestError::Empty));
    for blank in [
        &b" \n\r\n"[..],
        b"\xef\xbb\xbf",
        b"\xef\xbb\xbf\n",
        &[0; 100],
    ] {
        assert_eq!(
            read(blank, &ReadOptions::default()).unwrap_err(),
            IngestError::Empty
        );
    }
    let noise: Vec<u8> = (0..=255).cycle().skip(3).take(4096).collect();
    let error = read(&noise, &ReadOptions::default()).unwrap_err();
    assert!(
        matches!(&error, IngestError::Unrecognised { first_bytes } if first_bytes.starts_with("03 04 05"))
    );
}

#[test]
fn a_file_is_read_with_progress_and_named_in_errors() {
    let path = std::env::temp_dir().join(format!("dgd-ingest-{}.csv", std::process::id()));
    std::fs::write(&path, "t,a\n0,1\n1,2\n").unwrap();
    let mut seen = Vec::new();
    let (format, table) =
        read_file(path.as_os_str(), |done, size| seen.push((done, size))).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!((format, table.rows()), (Format::Csv, 2));
    assert_eq!(seen.last(), Some(&(12, 12)));
    let error = read_file(&path, |_, _| {}).unwrap_err();
    assert!(matches!(error, FileError::Io { .. }));
    assert!(error.to_string().contains("dgd-ingest-"));
}
