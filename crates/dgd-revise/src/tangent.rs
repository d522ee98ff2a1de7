//! The space of changes that a re-fit of the base parameters can make.

pub(crate) use dgd_lsq::dot;
use nalgebra::DMatrix;

/// Orthonormal columns that span it.
#[derive(Debug, Clone)]
pub(crate) struct Tangent {
    columns: Vec<Vec<f64>>,
}

impl Tangent {
    /// From the columns of a Jacobian; those that add nothing are dropped.
    pub(crate) fn of(columns: impl IntoIterator<Item = Vec<f64>>) -> Self {
        let mut basis = Self {
            columns: Vec::new(),
        };
        for mut column in columns {
            let before = dot(&column, &column);
            // Twice is enough (Parlett 1980).
            basis.project(&mut column);
            basis.project(&mut column);
            let after = dot(&column, &column);
            if after > 1e-12 * before && after > 1e-300 {
                let size = after.sqrt();
                column.iter_mut().for_each(|c| *c /= size);
                basis.columns.push(column);
            }
        }
        basis
    }

    pub(crate) fn of_matrix(jacobian: &DMatrix<f64>) -> Self {
        Self::of(jacobian.column_iter().map(|c| c.iter().copied().collect()))
    }

    /// Takes out of `v` what lies in the space.
    pub(crate) fn project(&self, v: &mut [f64]) {
        for c in &self.columns {
            let share = dot(c, v);
            v.iter_mut().zip(c).for_each(|(v, c)| *v -= share * c);
        }
    }

    /// `v` without what lies in the space.
    pub(crate) fn off(&self, v: &[f64]) -> Vec<f64> {
        let mut v = v.to_vec();
        self.project(&mut v);
        v
    }

    /// Its orthonormal columns.
    pub(crate) fn each(&self) -> impl Iterator<Item = &[f64]> {
        self.columns.iter().map(Vec::as_slice)
    }

    /// Part of the square of `v` that lies in the space.
    pub(crate) fn within(&self, v: &[f64]) -> f64 {
        self.columns.iter().map(|c| dot(c, v).powi(2)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_off_the_tangent_is_square_to_every_column() {
        let a = vec![1.0, 2.0, 3.0, 4.0];
        let b = vec![1.0, 2.0, 3.0, 4.1];
        let t = Tangent::of([a.clone(), b.clone(), a.clone()]);
        assert_eq!(t.each().count(), 2);
        let off = t.off(&[1.0, -1.0, 2.0, 0.5]);
        assert!(dot(&off, &a).abs() < 1e-9 && dot(&off, &b).abs() < 1e-9);
        assert!((t.within(&[1.0, -1.0, 2.0, 0.5]) + dot(&off, &off) - 6.25).abs() < 1e-9);
    }
}
