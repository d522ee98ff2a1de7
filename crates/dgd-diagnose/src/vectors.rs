//! Small dense linear algebra over long columns.

use std::ops::Range;

/// Product of two vectors, in eight sums that the processor adds side by side.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut sums = [0.0; 8];
    let (parts_a, parts_b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = parts_a
        .remainder()
        .iter()
        .zip(parts_b.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in parts_a.zip(parts_b) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Where a column holds anything but zeros: from the first to after the last.
pub(crate) fn support(column: &[f64]) -> Range<usize> {
    let first = column.iter().position(|v| *v != 0.0);
    let last = column.iter().rposition(|v| *v != 0.0);
    match (first, last) {
        (Some(first), Some(last)) => first..last + 1,
        _ => 0..0,
    }
}

/// The rows that both ranges hold.
fn common(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    let from = a.start.max(b.start);
    from..a.end.min(b.end).max(from)
}

/// Makes columns orthonormal in place (modified Gram-Schmidt, twice); returns the upper triangle by columns.
///
/// Behind row `rows` every column may hold something; before it only the rows that two columns share cost anything. So
/// columns that touch little belong first.
pub(crate) fn orthonormal(columns: &mut [Vec<f64>], rows: usize) -> Vec<Vec<f64>> {
    let p = columns.len();
    let mut triangle = vec![vec![0.0; p]; p];
    let mut reach: Vec<Range<usize>> = (columns.iter())
        .map(|c| support(&c[..rows.min(c.len())]))
        .collect();
    for a in 0..p {
        let (done, rest) = columns.split_at_mut(a);
        let column = &mut rest[0];
        for _ in 0..2 {
            for (b, q) in done.iter().enumerate() {
                let shared = common(&reach[a], &reach[b]);
                let tail = rows.min(q.len())..q.len();
                let r = dot(&q[shared.clone()], &column[shared])
                    + dot(&q[tail.clone()], &column[tail.clone()]);
                if r == 0.0 {
                    continue;
                }
                triangle[a][b] += r;
                for part in [reach[b].clone(), tail] {
                    let both = column[part.clone()].iter_mut().zip(&q[part]);
                    both.for_each(|(v, q)| *v -= r * q);
                }
                reach[a] = joined(&reach[a], &reach[b]);
            }
        }
        let norm = dot(column, column).sqrt();
        triangle[a][a] = norm;
        if norm > 0.0 {
            column.iter_mut().for_each(|v| *v /= norm);
        }
    }
    triangle
}

/// The least range that holds both.
fn joined(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    if a.is_empty() {
        return b.clone();
    }
    if b.is_empty() {
        return a.clone();
    }
    a.start.min(b.start)..a.end.max(b.end)
}

/// Solves the triangle that [`orthonormal`] returns; a column that spans nothing gets 0.
pub(crate) fn back_substitute(triangle: &[Vec<f64>], mut right: Vec<f64>) -> Vec<f64> {
    for a in (0..right.len()).rev() {
        let pivot = triangle[a][a];
        right[a] = if pivot > 0.0 { right[a] / pivot } else { 0.0 };
        for b in 0..a {
            right[b] -= triangle[a][b] * right[a];
        }
    }
    right
}

#[cfg(test)]
mod tests {
    use super::{back_substitute, dot, orthonormal};
    use crate::draws::normals;

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
        let triangle = orthonormal(&mut columns, 203);
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
        let sparse = orthonormal(&mut columns, 200);
        let dense = orthonormal(&mut full, 0);
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
    fn a_column_of_zeros_spans_nothing_and_gets_no_coefficient() {
        let mut columns = vec![normals(1, 50), vec![0.0; 50]];
        let triangle = orthonormal(&mut columns, 50);
        assert!(columns[1].iter().all(|v| *v == 0.0));
        assert_eq!(back_substitute(&triangle, vec![1.0, 1.0])[1], 0.0);
    }

    #[test]
    fn back_substitution_returns_the_coefficients_of_the_columns() {
        let plain: Vec<Vec<f64>> = (1..=5).map(|k| normals(k, 120)).collect();
        let truth = [3.0, -1.0, 0.5, 0.0, 1e4];
        let y: Vec<f64> = (0..120)
            .map(|i| plain.iter().zip(truth).map(|(c, b)| b * c[i]).sum())
            .collect();
        let mut basis = plain.clone();
        let triangle = orthonormal(&mut basis, 120);
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
}
