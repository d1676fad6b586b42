//! Local observability: what the measurements of this instant and their first derivatives tell, as in Schwarz & Keck
//! (16)–(18).
//!
//! The speeds are measured; what else is observable shows in the derivative of the speeds with respect to adhesions
//! and pad frictions. Scaled so that 1 means "the expected range of the component moves the speed by one sensor sigma
//! within one second", the rank is the number of pivots above 0.1 (what the mean of a hundred samples resolves) of a
//! complete-pivoting elimination.

use nalgebra::SMatrix;

/// Pivot below which a direction cannot be seen.
const LEAST_PIVOT: f64 = 0.1;

/// Number of directions that a scaled derivative tells apart. Only so many rows and columns of it are looked at, no more than it
/// has; the others are zero.
pub fn scaled_rank<const R: usize, const C: usize>(
    mut scaled: SMatrix<f64, R, C>,
    rows: usize,
    columns: usize,
) -> u32 {
    let (rows, columns) = (rows.min(R), columns.min(C));
    let mut rank = 0;
    let mut used = [false; R];
    for _ in 0..rows.min(columns) {
        let mut best = (0, 0, 0.0_f64);
        for column in 0..columns {
            for row in (0..rows).filter(|&row| !used[row]) {
                if scaled[(row, column)].abs() > best.2 {
                    best = (row, column, scaled[(row, column)].abs());
                }
            }
        }
        let (pivot_row, pivot_column, size) = best;
        if size <= LEAST_PIVOT {
            break;
        }
        used[pivot_row] = true;
        rank += 1;
        for row in (0..rows).filter(|&row| !used[row]) {
            let factor = scaled[(row, pivot_column)] / scaled[(pivot_row, pivot_column)];
            for column in 0..columns {
                scaled[(row, column)] -= factor * scaled[(pivot_row, column)];
            }
        }
    }
    rank
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rank_counts_what_is_large_and_independent() {
        let two = SMatrix::<f64, 3, 3>::new(100.0, 50.0, 0.0, 0.0, 20.0, 0.0, 100.0, 70.05, 0.03);
        assert_eq!(scaled_rank(two, 3, 3), 2);
        assert_eq!(scaled_rank(two.fixed_resize::<5, 8>(0.0), 3, 3), 2);
        assert_eq!(scaled_rank(SMatrix::<f64, 2, 4>::repeat(0.05), 2, 4), 0);
        assert_eq!(scaled_rank(SMatrix::<f64, 2, 2>::identity() * 5.0, 2, 2), 2);
    }
}
