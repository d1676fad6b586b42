//! The middle of a train: what most of its wagons do.

/// Fewer live wagons say nothing about each other.
pub(super) const LEAST_WAGONS: usize = 3;

/// The median; 0 of nothing.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.get(middle) {
        None => 0.0,
        Some(upper) if values.len() % 2 == 1 => *upper,
        Some(upper) => 0.5 * (upper + values[middle - 1]),
    }
}
