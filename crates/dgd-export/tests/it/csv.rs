//! CSV text.

use crate::{Full, column, table};
use dgd_export::{CsvOptions, ExportError, write_csv};
use dgd_recording::Table;

fn written(table: &Table, units_row: bool) -> String {
    let mut bytes = Vec::new();
    write_csv(table, &CsvOptions { units_row }, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn the_units_row_can_be_left_out_and_is_where_nothing_has_a_unit() {
    let with = table(vec![
        column("t", Some("s"), &[0.0]),
        column("a", None, &[1.5]),
    ]);
    assert_eq!(written(&with, true), "t,a\ns,\n0,1.5\n");
    assert_eq!(written(&with, false), "t,a\n0,1.5\n");
    let without = table(vec![column("t", None, &[0.0])]);
    assert_eq!(written(&without, true), "t\n0\n");
}

#[test]
fn missing_values_and_short_columns_are_empty_cells() {
    let table = table(vec![
        column("t", None, &[0.0, 1.0, 2.0]),
        column("a", None, &[f64::NAN, 1.0]),
    ]);
    assert_eq!(written(&table, true), "t,a\n0,\n1,1\n2,\n");
}

#[test]
fn numbers_have_the_fewest_digits_that_read_back() {
    let values = [0.1, -0.0, 342.40000000000003, 1e300, 5e-324, f64::INFINITY];
    let text = written(&table(vec![column("a", None, &values)]), true);
    assert_eq!(text, "a\n0.1\n-0\n342.40000000000003\n1e300\n5e-324\ninf\n");
}

#[test]
fn names_with_delimiters_are_quoted() {
    let table = table(vec![
        column("a,\"b\"", None, &[1.0]),
        column(" c ", None, &[2.0]),
    ]);
    assert_eq!(written(&table, true), "\"a,\"\"b\"\"\",\" c \"\n1,2\n");
}

#[test]
fn long_tables_are_written_whole() {
    let values: Vec<f64> = (0..50_000).map(|i| f64::from(i) * 0.5).collect();
    let text = written(&table(vec![column("a", None, &values)]), true);
    let read: Vec<f64> = text.lines().skip(1).map(|l| l.parse().unwrap()).collect();
    assert_eq!(read, values);
}

#[test]
fn each_refusal_has_its_error() {
    let write = |table: &Table| write_csv(table, &CsvOptions::default(), &mut Vec::new());
    assert!(matches!(
        write(&Table::default()),
        Err(ExportError::NoColumns)
    ));
    let twice = table(vec![column("a", None, &[1.0]), column("a", None, &[2.0])]);
    assert!(matches!(write(&twice), Err(ExportError::NameTaken { tag }) if tag == "a"));
    let one = table(vec![column("a", None, &[1.0])]);
    let full = write_csv(&one, &CsvOptions::default(), Full);
    assert!(matches!(full, Err(ExportError::Io(_))));
}

#[test]
fn units_of_one_stand_behind_the_names() {
    let shares = table(vec![
        column("t", None, &[0.0]),
        column("valve", Some("1"), &[0.5]),
        column("p[0]", Some("1"), &[0.25]),
    ]);
    assert_eq!(written(&shares, true), "t,valve [1],p[0] [1]\n0,0.5,0.25\n");
    assert_eq!(written(&shares, false), "t,valve,p[0]\n0,0.5,0.25\n");
    let empty = table(vec![column("t", Some(""), &[0.0])]);
    assert_eq!(written(&empty, true), "t\n0\n");
}
