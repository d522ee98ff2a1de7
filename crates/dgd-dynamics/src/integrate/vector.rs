//! State storage: stack arrays for the small dimensions we meet daily, `Vec` for the rest.
//!
//! The integrators are written once over [`Vector`]; with `[f64; N]` every loop bound is a
//! compile-time constant after inlining, which is worth a factor of two at `N = 2`.

/// Storage of one state vector, with the matching square matrix and row indices.
pub(crate) trait Vector: Clone {
    /// Row-major square matrix.
    type Square;
    /// One row index a state.
    type Rows;
    fn zeros(n: usize) -> Self;
    fn square(n: usize) -> Self::Square;
    fn rows(n: usize) -> Self::Rows;
    fn get(&self) -> &[f64];
    fn get_mut(&mut self) -> &mut [f64];
    fn flat(matrix: &Self::Square) -> &[f64];
    fn flat_mut(matrix: &mut Self::Square) -> &mut [f64];
    fn index(rows: &Self::Rows) -> &[usize];
    fn index_mut(rows: &mut Self::Rows) -> &mut [usize];
}

impl<const N: usize> Vector for [f64; N] {
    type Square = [[f64; N]; N];
    type Rows = [usize; N];
    #[inline(always)]
    fn zeros(_: usize) -> Self {
        [0.0; N]
    }
    #[inline(always)]
    fn square(_: usize) -> Self::Square {
        [[0.0; N]; N]
    }
    #[inline(always)]
    fn rows(_: usize) -> Self::Rows {
        [0; N]
    }
    #[inline(always)]
    fn get(&self) -> &[f64] {
        self
    }
    #[inline(always)]
    fn get_mut(&mut self) -> &mut [f64] {
        self
    }
    #[inline(always)]
    fn flat(matrix: &Self::Square) -> &[f64] {
        matrix.as_flattened()
    }
    #[inline(always)]
    fn flat_mut(matrix: &mut Self::Square) -> &mut [f64] {
        matrix.as_flattened_mut()
    }
    #[inline(always)]
    fn index(rows: &Self::Rows) -> &[usize] {
        rows
    }
    #[inline(always)]
    fn index_mut(rows: &mut Self::Rows) -> &mut [usize] {
        rows
    }
}

impl Vector for Vec<f64> {
    type Square = Vec<f64>;
    type Rows = Vec<usize>;
    fn zeros(n: usize) -> Self {
        vec![0.0; n]
    }
    fn square(n: usize) -> Self::Square {
        vec![0.0; n * n]
    }
    fn rows(n: usize) -> Self::Rows {
        vec![0; n]
    }
    fn get(&self) -> &[f64] {
        self
    }
    fn get_mut(&mut self) -> &mut [f64] {
        self
    }
    fn flat(matrix: &Self::Square) -> &[f64] {
        matrix
    }
    fn flat_mut(matrix: &mut Self::Square) -> &mut [f64] {
        matrix
    }
    fn index(rows: &Self::Rows) -> &[usize] {
        rows
    }
    fn index_mut(rows: &mut Self::Rows) -> &mut [usize] {
        rows
    }
}

/// Factors the row-major `n × n` matrix in place with partial pivoting; the diagonal holds the
/// reciprocals of the pivots. The determinant's sign, or 0 if a pivot is zero or not finite.
///
/// A matrix of two is inverted instead, by Cramer's rule, whose error for two is as small as elimination's (Higham 2002, 1.10.1),
/// though its residual need not be: one division in place of two that wait for each other, and shorter solves.
#[inline(always)]
pub(super) fn lu_factor(a: &mut [f64], rows: &mut [usize], n: usize) -> f64 {
    if n == 2 {
        return invert_two(a);
    }
    let mut sign = 1.0_f64;
    for k in 0..n {
        let mut p = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[p * n + k].abs() {
                p = i;
            }
        }
        rows[k] = p;
        if p != k {
            sign = -sign;
            for j in 0..n {
                a.swap(k * n + j, p * n + j);
            }
        }
        let inverse = 1.0 / a[k * n + k];
        if !inverse.is_finite() {
            return 0.0;
        }
        sign *= inverse.signum();
        a[k * n + k] = inverse;
        for i in k + 1..n {
            let factor = a[i * n + k] * inverse;
            a[i * n + k] = factor;
            for j in k + 1..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
        }
    }
    sign
}

/// Replaces a matrix of two by its inverse; its determinant's sign, or 0 if it has no inverse in numbers.
#[inline(always)]
fn invert_two(a: &mut [f64]) -> f64 {
    let inverse = 1.0 / (a[0] * a[3] - a[1] * a[2]);
    (a[0], a[3]) = (a[3] * inverse, a[0] * inverse);
    (a[1], a[2]) = (-a[1] * inverse, -a[2] * inverse);
    // Neither singular nor beyond what squares can hold.
    if inverse.is_normal() {
        inverse.signum()
    } else {
        0.0
    }
}

/// Solves with the factors of [`lu_factor`], in place.
#[inline(always)]
pub(super) fn lu_solve(a: &[f64], rows: &[usize], b: &mut [f64], n: usize) {
    if n == 2 {
        let (b0, b1) = (b[0], b[1]);
        b[0] = a[0] * b0 + a[1] * b1;
        b[1] = a[2] * b0 + a[3] * b1;
        return;
    }
    for (k, &p) in rows.iter().enumerate() {
        if p != k {
            b.swap(k, p);
        }
    }
    for i in 1..n {
        let mut sum = b[i];
        for j in 0..i {
            sum -= a[i * n + j] * b[j];
        }
        b[i] = sum;
    }
    for i in (0..n).rev() {
        let mut sum = b[i];
        for j in i + 1..n {
            sum -= a[i * n + j] * b[j];
        }
        b[i] = sum * a[i * n + i];
    }
}

#[cfg(test)]
mod tests {
    use super::{lu_factor, lu_solve};

    #[test]
    fn lu_solves_a_system_that_needs_pivoting_twice() {
        let a = [0.0, 2.0, 1.0, 4.0, 0.0, -1.0, 8.0, 1.0, 0.5];
        let x = [1.0, -2.0, 3.0];
        let mut b = [0.0; 3];
        for i in 0..3 {
            b[i] = (0..3).map(|j| a[i * 3 + j] * x[j]).sum();
        }
        let (mut lu, mut rows) = (a, [0; 3]);
        // 0·(0·0.5 + 1·1) − 2·(4·0.5 + 1·8) + 1·(4·1 − 0·8) = −16.
        assert_eq!(lu_factor(&mut lu, &mut rows, 3), -1.0);
        lu_solve(&lu, &rows, &mut b, 3);
        for i in 0..3 {
            assert!((b[i] - x[i]).abs() < 1e-14, "{b:?}");
        }
    }

    #[test]
    fn a_diagonal_of_nothing_costs_no_digit_at_any_size() {
        let mut state = 1_u64;
        let mut draw = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            f64::from(u32::try_from(state >> 40).unwrap_or(0)) / f64::from(1_u32 << 23) - 1.0
        };
        for n in 2..=6 {
            for _ in 0..20 {
                let mut a: Vec<f64> = (0..n * n).map(|_| draw()).collect();
                // The first pivot is nothing, and so is the second once the first is eliminated.
                a[0] = 1e-17;
                a[n] = 1.0;
                a[n + 1] = 1e-17;
                let x: Vec<f64> = (0..n).map(|_| draw()).collect();
                let row = |i: usize| (0..n).map(|j| a[i * n + j] * x[j]).sum();
                let mut b: Vec<f64> = (0..n).map(row).collect();
                let (mut lu, mut rows) = (a.clone(), vec![0; n]);
                assert_ne!(lu_factor(&mut lu, &mut rows, n), 0.0);
                // With the greatest of each column as pivot no factor is above 1; two are not factored.
                for i in 0..if n == 2 { 0 } else { n } {
                    assert!((0..i).all(|k| lu[i * n + k].abs() <= 1.0), "{lu:?}");
                }
                lu_solve(&lu, &rows, &mut b, n);
                for i in 0..n {
                    let back: f64 = (0..n).map(|j| a[i * n + j] * (b[j] - x[j])).sum();
                    assert!(back.abs() < 1e-13, "row {i} of {n}: {back:e}");
                }
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_reported() {
        assert_eq!(lu_factor(&mut [1.0, 2.0, 2.0, 4.0], &mut [0; 2], 2), 0.0);
        let mut three = [1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.0, 1.0, 1.0];
        assert_eq!(lu_factor(&mut three, &mut [0; 3], 3), 0.0);
        // An inverse of nothing would let any step pass.
        let mut beyond = [1e200, 0.0, 0.0, 1e200];
        assert_eq!(lu_factor(&mut beyond, &mut [0; 2], 2), 0.0);
    }

    #[test]
    fn the_sign_is_the_determinants_at_any_size() {
        for n in 1..=5 {
            for swapped in [false, true] {
                // A row of −3 makes it negative, two rows that change places turn that round.
                let mut a = vec![0.0; n * n];
                for i in 0..n {
                    a[i * n + i] = if i == 0 { -3.0 } else { 2.0 };
                }
                let mut expected = -1.0;
                if swapped && n > 1 {
                    a.chunks_exact_mut(n).for_each(|row| row.swap(0, 1));
                    expected = 1.0;
                }
                assert_eq!(lu_factor(&mut a, &mut vec![0; n], n), expected, "{n}");
            }
        }
    }
}
