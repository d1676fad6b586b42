//! Orthogonal triangularisation on the stack.

use nalgebra::{SMatrix, SVector};

/// Replaces the upper triangular R by the triangular factor of the stack `[R; rows]`: Householder reflections that
/// leave the zeros of R alone. `rows` is used up.
#[inline]
pub(super) fn fold_rows<const N: usize, const K: usize>(
    r: &mut SMatrix<f64, N, N>,
    rows: &mut SMatrix<f64, K, N>,
) {
    for pivot in 0..N {
        let column: SVector<f64, K> = rows.column(pivot).into_owned();
        let below = column.norm_squared();
        if below == 0.0 {
            continue;
        }
        let head = r[(pivot, pivot)];
        let norm = (head * head + below).sqrt();
        // The sign that adds, not cancels.
        let target = if head > 0.0 { -norm } else { norm };
        let lead = head - target;
        let scale = 2.0 / (lead * lead + below);
        r[(pivot, pivot)] = target;
        for other in pivot + 1..N {
            let along = (lead * r[(pivot, other)] + column.dot(&rows.column(other))) * scale;
            r[(pivot, other)] -= along * lead;
            rows.column_mut(other).axpy(-along, &column, 1.0);
        }
    }
}

/// [`fold_rows`] for one row, by Givens rotations.
#[inline]
pub(super) fn fold_row<const N: usize>(r: &mut SMatrix<f64, N, N>, mut row: SVector<f64, N>) {
    for pivot in 0..N {
        let (head, below) = (r[(pivot, pivot)], row[pivot]);
        if below == 0.0 {
            continue;
        }
        let norm = (head * head + below * below).sqrt();
        let (cos, sin) = (head / norm, below / norm);
        for other in pivot..N {
            let (upper, lower) = (r[(pivot, other)], row[other]);
            r[(pivot, other)] = cos * upper + sin * lower;
            row[other] = cos * lower - sin * upper;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Matrix5x3, Vector3};

    #[test]
    fn folding_keeps_the_gram_matrix() {
        let mut r = Matrix3::new(2.0, 0.3, -1.0, 0.0, -1.5, 0.4, 0.0, 0.0, 0.7);
        let rows = Matrix5x3::from_fn(|i, j| ((3 * i + 7 * j) as f64).sin());
        let row = Vector3::new(0.4, -2.0, 1.1);
        let gram = r.transpose() * r + rows.transpose() * rows + row * row.transpose();
        fold_rows(&mut r, &mut rows.clone());
        fold_row(&mut r, row);
        assert!((r.transpose() * r - gram).norm() < 1e-13);
        assert_eq!((r[(1, 0)], r[(2, 0)], r[(2, 1)]), (0.0, 0.0, 0.0));
    }
}
