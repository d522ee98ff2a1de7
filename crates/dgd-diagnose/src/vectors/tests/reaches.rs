//! Claims about columns that touch few rows: what is left out is zeros only.

use crate::test_rig::normals;
use crate::vectors::{Column, orthonormal, products, support, without};
use dgd_lsq::dot;

const ROWS: usize = 5003;
/// More than eight, so that some stand before the last whole eight.
const PRIORS: usize = 21;

/// Short columns before a full one, some of which overlap; a row of a prior each at the very end.
fn columns() -> Vec<Column> {
    let lives = [4100..4105, 3400..4000, 900..1700, 1500..2400, 0..ROWS];
    (lives.into_iter().enumerate())
        .map(|(k, rows)| {
            let mut column = vec![0.0; ROWS + PRIORS];
            column[rows.clone()].copy_from_slice(&normals(k as u64 + 1, ROWS)[rows]);
            column[ROWS + 4 * k] = 0.3;
            Column::of(&column[..ROWS]).with_priors(column[ROWS..].to_vec())
        })
        .collect()
}

#[test]
fn reaches_stay_short_until_a_longer_column_is_taken_out() {
    let mut columns = columns();
    orthonormal(&mut columns);
    let reaches = [4100..4105, 3400..4000, 900..1700, 900..2400, 0..ROWS];
    for (column, reach) in columns.iter().zip(reaches) {
        assert_eq!(*column.reach(), reach);
        assert_eq!(support(&column.whole()[..ROWS]), reach);
    }
}

#[test]
fn products_within_reaches_have_the_digits_of_whole_ones() {
    let mut columns = columns();
    orthonormal(&mut columns);
    let vector = normals(99, ROWS + PRIORS);
    for touched in [0..ROWS, 3..4999, 1511..1689, 4101..5000, 2000..2000] {
        let found = products(&columns, &vector, &touched);
        assert_eq!(found.len(), columns.len());
        for (q, found) in columns.iter().map(Column::whole).zip(found) {
            let whole = dot(&q[touched.clone()], &vector[touched.clone()]);
            assert_eq!(
                (found + 0.0).to_bits(),
                (whole + 0.0).to_bits(),
                "{touched:?}"
            );
        }
    }
}

#[test]
fn a_product_within_reaches_holds_every_prior() {
    let mut columns = columns();
    orthonormal(&mut columns);
    let mut vector = normals(98, ROWS + PRIORS);
    for q in &columns {
        let whole = dot(&q.whole(), &vector);
        assert_eq!((q.dot(&vector) + 0.0).to_bits(), (whole + 0.0).to_bits());
    }
    let shares = [0.5, -1.0, 2.0, 1e-3, 0.25];
    let mut plain = vector.clone();
    for (q, share) in columns.iter().map(Column::whole).zip(shares) {
        plain.iter_mut().zip(&q).for_each(|(v, q)| *v -= share * q);
    }
    without(&mut vector, &columns, &shares);
    assert_eq!(vector, plain);
}

#[test]
fn a_column_holds_no_more_than_it_reaches_wherever_its_rows_end() {
    for rows in [1, 7, 8, 9, 40, 41, 47, 48] {
        for priors in [0, 1, 8, 13] {
            let vector = normals(97, rows + priors);
            for (from, to) in [(0, rows), (0, 1), (rows - 1, rows), (rows / 2, rows / 2)] {
                let mut whole = vec![0.0; rows];
                whole[from..to].copy_from_slice(&normals(5, rows)[from..to]);
                let mut column = Column::of(&whole).with_priors(normals(6, priors));
                whole.extend(normals(6, priors));
                assert_eq!(column.whole(), whole);
                let (found, all) = (column.dot(&vector), dot(&whole, &vector));
                assert_eq!((found + 0.0).to_bits(), (all + 0.0).to_bits());
                orthonormal(std::slice::from_mut(&mut column));
                let length = dot(&whole, &whole).sqrt();
                if length > 0.0 {
                    whole.iter_mut().for_each(|v| *v /= length);
                }
                assert_eq!(column.whole(), whole, "{rows} rows, {priors} priors");
            }
        }
    }
}
