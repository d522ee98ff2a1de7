//! MAT v5 and v7.3 out. That they read back bit by bit is tested in `dgd-ingest`.

use dgd_export::{ExportError, field_names, write_mat5, write_mat73};
use dgd_recording::{Column, Table};

fn table(tags: &[&str]) -> Table {
    let column = |tag: &&str| Column {
        tag: (*tag).into(),
        unit: Some("gpm".into()),
        values: (0..300).map(f64::from).collect(),
    };
    Table {
        columns: tags.iter().map(column).collect(),
        ..Table::default()
    }
}

fn mat5(table: &Table, root: &str) -> Result<Vec<u8>, ExportError> {
    let mut out = Vec::new();
    write_mat5(table, root, &mut out).map(|()| out)
}

#[test]
fn the_same_table_gives_the_same_bytes() {
    let table = table(&["gom.t", "gom.FT1"]);
    assert_eq!(mat5(&table, "gom").unwrap(), mat5(&table, "gom").unwrap());
    assert_eq!(
        write_mat73(&table, "gom").unwrap(),
        write_mat73(&table, "gom").unwrap()
    );
}

#[test]
fn both_carry_matlabs_header() {
    let table = table(&["t"]);
    let five = mat5(&table, "gom").unwrap();
    assert!(five.starts_with(b"MATLAB 5.0 MAT-file"));
    assert_eq!(five[124..128], [0, 1, b'I', b'M']);
    let seven = write_mat73(&table, "gom").unwrap();
    assert!(seven.starts_with(b"MATLAB 7.3 MAT-file"));
    assert_eq!(seven[124..128], [0, 2, b'I', b'M']);
    assert_eq!(&seven[512..520], b"\x89HDF\r\n\x1a\n");
}

#[test]
fn a_root_that_matlab_would_not_take_is_refused() {
    let table = table(&["t"]);
    for root in [
        "",
        "2nd",
        "a b",
        "a.b",
        "_a",
        "é",
        "end",
        "for",
        &"a".repeat(64),
    ] {
        assert!(
            matches!(mat5(&table, root), Err(ExportError::Name { .. })),
            "{root}"
        );
        assert!(
            matches!(write_mat73(&table, root), Err(ExportError::Name { .. })),
            "{root}"
        );
    }
}

#[test]
fn a_table_without_columns_is_refused() {
    let empty = Table::default();
    assert!(matches!(mat5(&empty, "gom"), Err(ExportError::NoColumns)));
    assert!(matches!(
        write_mat73(&empty, "gom"),
        Err(ExportError::NoColumns)
    ));
}

#[test]
fn field_names_are_ones_that_matlab_takes_and_differ() {
    let long = "n".repeat(80);
    let tags = [
        "",
        "é",
        "units",
        "gom.units",
        "gom.pump.SPM",
        &long,
        &long,
        "a-b",
        "a b",
        "return",
        "Return",
    ];
    let names = field_names(&table(&tags), "gom");
    assert_eq!(names[..5], ["x", "x_", "units_2", "units_3", "pump_SPM"]);
    assert_eq!(names[5], "n".repeat(63));
    assert_eq!(names[6], "n".repeat(61) + "_2");
    assert_eq!(names[7..], ["a_b", "a_b_2", "xreturn", "Return"]);
    for name in &names {
        assert!(name.len() <= 63 && name.starts_with(|c: char| c.is_ascii_alphabetic()));
    }
}

#[test]
fn a_writer_that_fails_is_told() {
    let mut small = [0_u8; 100];
    let found = write_mat5(&table(&["t"]), "gom", &mut small.as_mut_slice());
    assert!(matches!(found, Err(ExportError::Io(_))));
}

mod values {
    use dgd_export::{ExportError, MatValue, write_mat5_values};
    use dgd_ingest::{ReadOptions, read};

    fn matrix(rows: usize, columns: usize, values: &[f64]) -> MatValue {
        MatValue::Matrix {
            rows,
            columns,
            values: values.to_vec(),
        }
    }

    fn written(values: &[(&str, MatValue)]) -> Result<Vec<u8>, ExportError> {
        let values: Vec<(String, MatValue)> = values
            .iter()
            .map(|(name, value)| ((*name).to_owned(), value.clone()))
            .collect();
        let mut bytes = Vec::new();
        write_mat5_values(&values, "linear", &mut bytes).map(|()| bytes)
    }

    #[test]
    fn a_matrix_given_by_rows_reads_back_with_its_columns() {
        let names = MatValue::Texts(vec!["tank.level".into(), "line.flow".into()]);
        let inner = MatValue::Fields(vec![("B".into(), matrix(3, 1, &[7.0, 8.0, 9.0]))]);
        let a = matrix(3, 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let bytes = written(&[("A", a), ("states", names), ("discrete", inner)]).unwrap();
        let (_, table) = read(&bytes, &ReadOptions::default()).unwrap();
        let column = |tag: &str| table.column(tag).unwrap().values.clone();
        assert_eq!(column("A(:,1)"), [1.0, 3.0, 5.0]);
        assert_eq!(column("A(:,2)"), [2.0, 4.0, 6.0]);
        assert_eq!(column("discrete.B"), [7.0, 8.0, 9.0]);
    }

    #[test]
    fn what_matlab_would_not_take_is_refused() {
        let one = || matrix(1, 1, &[1.0]);
        assert!(matches!(written(&[]), Err(ExportError::NoColumns)));
        assert!(matches!(
            written(&[("a b", one())]),
            Err(ExportError::Name { .. })
        ));
        let twice = [("A", one()), ("A", one())];
        assert!(matches!(
            written(&twice),
            Err(ExportError::NameTaken { .. })
        ));
        assert!(matches!(
            written(&[("while", one())]),
            Err(ExportError::Name { .. })
        ));
        let short = written(&[("A", matrix(2, 3, &[1.0]))]).unwrap_err();
        assert!(matches!(
            short,
            ExportError::Shape {
                rows: 2,
                columns: 3,
                found: 1,
                ..
            }
        ));
        assert_eq!(short.to_string(), "matrix `A` has 1 values, expected 2 x 3");
    }
}
