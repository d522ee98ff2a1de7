//! Small dense linear algebra over long columns.

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

/// Makes columns orthonormal in place (modified Gram-Schmidt, twice); returns the upper triangle by columns.
pub(crate) fn orthonormal(columns: &mut [Vec<f64>]) -> Vec<Vec<f64>> {
    let p = columns.len();
    let mut triangle = vec![vec![0.0; p]; p];
    for a in 0..p {
        let (done, rest) = columns.split_at_mut(a);
        let column = &mut rest[0];
        for _ in 0..2 {
            for (b, q) in done.iter().enumerate() {
                let r = dot(q, column);
                triangle[a][b] += r;
                column.iter_mut().zip(q).for_each(|(v, q)| *v -= r * q);
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
        let triangle = orthonormal(&mut columns);
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
    fn a_column_of_zeros_spans_nothing_and_gets_no_coefficient() {
        let mut columns = vec![normals(1, 50), vec![0.0; 50]];
        let triangle = orthonormal(&mut columns);
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
        let triangle = orthonormal(&mut basis);
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
