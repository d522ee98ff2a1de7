//! Claims about the arithmetic of columns.

mod reaches;

use super::{Column, Sparse, back_substitute, product_within, products, support, without};
use crate::test_rig::normals;
use dgd_lsq::dot;

/// Whole columns made orthonormal, of which the last rows are priors'; their triangle.
fn orthonormal(columns: &mut [Vec<f64>], rows: usize) -> (Vec<Column>, Vec<Vec<f64>>) {
    let of = |c: &Vec<f64>| Column::of(&c[..rows]).with_priors(c[rows..].to_vec());
    let mut held: Vec<Column> = columns.iter().map(of).collect();
    let triangle = super::orthonormal(&mut held);
    for (column, held) in columns.iter_mut().zip(&held) {
        *column = held.whole();
    }
    (held, triangle)
}

#[test]
fn columns_come_out_orthonormal_even_when_two_are_nearly_one() {
    let mut columns: Vec<Vec<f64>> = (1..=8).map(|k| normals(k, 203)).collect();
    let twin: Vec<f64> = columns[2]
        .iter()
        .zip(&columns[6])
        .map(|(a, b)| a + 1e-7 * b)
        .collect();
    columns[5] = twin;
    let before = columns.clone();
    let triangle = orthonormal(&mut columns, 203).1;
    for a in 0..columns.len() {
        for b in 0..columns.len() {
            let expected = if a == b { 1.0 } else { 0.0 };
            assert!((dot(&columns[a], &columns[b]) - expected).abs() < 1e-9);
        }
        for i in 0..203 {
            let rebuilt: f64 = (0..=a).map(|b| triangle[a][b] * columns[b][i]).sum();
            assert!((rebuilt - before[a][i]).abs() < 1e-12);
        }
    }
}

#[test]
fn a_column_that_is_rid_of_the_others_once_is_as_good_as_one_that_is_twice() {
    // From all of its own to a hundred-millionth.
    for own in (0..=16).map(|k| 10_f64.powf(-0.5 * f64::from(k))) {
        let mut columns: Vec<Vec<f64>> = (1..=5).map(|k| normals(k, 203)).collect();
        let among: Vec<f64> = (0..203)
            .map(|i| columns[0][i] - columns[1][i] + columns[2][i] + own * columns[4][i])
            .collect();
        columns[3] = among;
        orthonormal(&mut columns, 203);
        for a in 0..5 {
            for b in 0..a {
                let product = dot(&columns[a], &columns[b]);
                assert!(product.abs() < 1e-13, "{own}: {product}");
            }
        }
    }
}

#[test]
fn a_sparse_column_is_the_whole_one_and_takes_what_that_takes() {
    let noise = normals(3, 60);
    let mut column = vec![0.0; 60];
    for rows in [3..9, 12..13, 47..60] {
        column[rows.clone()].copy_from_slice(&noise[rows]);
    }
    let sparse = Sparse::of(&column, &[0..20, 20..40, 40..40, 40..60]);
    assert_eq!(sparse.whole(), column);
    let mut vector = normals(4, 60);
    let expected: Vec<f64> = (vector.iter().zip(&column))
        .map(|(v, c)| v - 0.7 * c)
        .collect();
    sparse.take_from(&mut vector, 0.7);
    assert_eq!(vector, expected);
    assert_eq!(Sparse::of(&[0.0; 5], &[0..2, 2..5]).whole(), [0.0; 5]);
}

#[test]
fn a_column_of_zeros_spans_nothing_and_gets_no_coefficient() {
    let mut columns = vec![normals(1, 50), vec![0.0; 50]];
    let triangle = orthonormal(&mut columns, 50).1;
    assert!(columns[1].iter().all(|v| *v == 0.0));
    assert_eq!(back_substitute(&triangle, vec![1.0, 1.0])[1], 0.0);
}

/// Columns that live in different rows, before one row of a prior each.
fn sparse() -> Vec<Vec<f64>> {
    const ROWS: usize = 5003;
    let lives = [
        0..ROWS,
        0..1700,
        900..2400,
        1700..3400,
        3400..ROWS,
        11..11,
        2399..2409,
    ];
    let p = lives.len();
    lives
        .into_iter()
        .enumerate()
        .map(|(k, rows)| {
            let mut column = vec![0.0; ROWS + p];
            let noise = normals(k as u64 + 1, ROWS);
            column[rows.clone()].copy_from_slice(&noise[rows]);
            column[ROWS + k] = 0.3;
            column
        })
        .collect()
}

fn bits(values: &[f64]) -> Vec<u64> {
    // A zero's sign is no digit.
    values.iter().map(|v| (v + 0.0).to_bits()).collect()
}

#[test]
fn columns_that_share_few_rows_come_out_as_if_all_were_full() {
    // Three that touch ten rows each, two of which overlap, before three full ones; five rows that all may hold.
    let mut columns: Vec<Vec<f64>> = (1..=6).map(|k| normals(k, 205)).collect();
    for (column, from) in columns.iter_mut().zip([20, 25, 90]) {
        for (i, v) in column[..200].iter_mut().enumerate() {
            if !(from..from + 10).contains(&i) {
                *v = 0.0;
            }
        }
    }
    let mut full = columns.clone();
    let sparse = orthonormal(&mut columns, 200).1;
    let dense = orthonormal(&mut full, 0).1;
    for a in 0..6 {
        for b in 0..6 {
            assert!((sparse[a][b] - dense[a][b]).abs() < 1e-12, "{a} {b}");
        }
        for (x, y) in columns[a].iter().zip(&full[a]) {
            assert!((x - y).abs() < 1e-12);
        }
    }
}

#[test]
fn piece_by_piece_products_and_differences_have_the_digits_of_whole_ones() {
    let mut columns = sparse();
    let (held, _) = orthonormal(&mut columns, 5003);
    let mut vector = normals(99, columns[0].len());
    for touched in [0..5003, 3..4999, 1701..1702, 2000..2000, 4000..5003] {
        let found = products(&held, &vector, &touched);
        for (q, found) in columns.iter().zip(found) {
            let whole = dot(&q[touched.clone()], &vector[touched.clone()]);
            assert_eq!(
                (found + 0.0).to_bits(),
                (whole + 0.0).to_bits(),
                "{touched:?}"
            );
        }
    }
    let shares = [0.5, -1.0, 0.0, 2.0, 1e-3, 3.0, 0.25];
    let mut plain = vector.clone();
    for (q, share) in columns.iter().zip(shares) {
        plain.iter_mut().zip(q).for_each(|(v, q)| *v -= share * q);
    }
    without(&mut vector, &held, &shares);
    assert!(bits(&vector) == bits(&plain));
}

#[test]
fn a_product_of_what_touches_little_has_the_digits_of_the_whole() {
    let columns = sparse();
    for a in &columns {
        for b in &columns {
            let found = product_within((a, &support(a)), (b, &support(b)));
            assert_eq!(bits(&[found]), bits(&[dot(a, b)]));
        }
    }
}

#[test]
fn back_substitution_returns_the_coefficients_of_the_columns() {
    let plain: Vec<Vec<f64>> = (1..=5).map(|k| normals(k, 120)).collect();
    let truth = [3.0, -1.0, 0.5, 0.0, 1e4];
    let y: Vec<f64> = (0..120)
        .map(|i| plain.iter().zip(truth).map(|(c, b)| b * c[i]).sum())
        .collect();
    let mut basis = plain.clone();
    let triangle = orthonormal(&mut basis, 120).1;
    let right = basis.iter().map(|q| dot(q, &y)).collect();
    for (found, truth) in back_substitute(&triangle, right).iter().zip(truth) {
        assert!((found - truth).abs() < 1e-9, "{found} for {truth}");
    }
}

#[test]
fn a_product_of_vectors_takes_the_shorter_length() {
    let a: Vec<f64> = (0..19).map(f64::from).collect();
    assert_eq!(dot(&a, &a), 2109.0);
    assert_eq!(dot(&a, &a[..3]), 5.0);
}
