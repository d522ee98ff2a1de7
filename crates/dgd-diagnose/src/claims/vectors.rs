//! Claims about columns that touch few rows: what is left out is zeros only.

use crate::draws::normals;
use crate::vectors::{dot, dot_within, orthonormal, products, support, without};

const ROWS: usize = 5003;
/// More than eight, so that some stand before the last whole eight.
const PRIORS: usize = 21;

/// Short columns before a full one, some of which overlap; a row of a prior each at the very end.
fn columns() -> Vec<Vec<f64>> {
    let lives = [4100..4105, 3400..4000, 900..1700, 1500..2400, 0..ROWS];
    (lives.into_iter().enumerate())
        .map(|(k, rows)| {
            let mut column = vec![0.0; ROWS + PRIORS];
            column[rows.clone()].copy_from_slice(&normals(k as u64 + 1, ROWS)[rows]);
            column[ROWS + 4 * k] = 0.3;
            column
        })
        .collect()
}

#[test]
fn reaches_stay_short_until_a_longer_column_is_taken_out() {
    let mut columns = columns();
    let reaches = orthonormal(&mut columns, ROWS).reaches;
    assert_eq!(
        reaches,
        [4100..4105, 3400..4000, 900..1700, 900..2400, 0..ROWS]
    );
    for (column, reach) in columns.iter().zip(&reaches) {
        assert_eq!(support(&column[..ROWS]), *reach);
    }
}

#[test]
fn products_within_reaches_have_the_digits_of_whole_ones() {
    let mut columns = columns();
    let reaches = orthonormal(&mut columns, ROWS).reaches;
    let vector = normals(99, ROWS + PRIORS);
    for touched in [0..ROWS, 3..4999, 1511..1689, 4101..5000, 2000..2000] {
        let found = products(&columns, &reaches, &vector, &touched);
        assert_eq!(found.len(), columns.len());
        for (q, found) in columns.iter().zip(found) {
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
    let reaches = orthonormal(&mut columns, ROWS).reaches;
    let mut vector = normals(98, ROWS + PRIORS);
    for (q, reach) in columns.iter().zip(&reaches) {
        let found = dot_within(q, &vector, reach, PRIORS);
        assert_eq!((found + 0.0).to_bits(), (dot(q, &vector) + 0.0).to_bits());
    }
    let shares = [0.5, -1.0, 2.0, 1e-3, 0.25];
    let mut plain = vector.clone();
    for (q, share) in columns.iter().zip(shares) {
        plain.iter_mut().zip(q).for_each(|(v, q)| *v -= share * q);
    }
    without(&mut vector, &columns, &reaches, &shares, PRIORS);
    assert_eq!(vector, plain);
}
