//! What one application, or one roll, changed: each wheelset beside the others of its wagon, and each wagon beside the train.
//!
//! The two are known differently well. Wheelsets of one wagon share its speed, whatever the couplers do. Wagons do not: while
//! slack runs in or out, a wagon is faster or slower than the train by more than pads do to creepage. How much that is on
//! this train shows in how much its wagons differ, of which most are well.

use crate::creepage::Change;
use crate::robust::median;

/// Median of absolute deviations of a normal distribution, times this, is its sigma.
const MAD_TO_SIGMA: f64 = 1.4826;
/// So many values tell a spread.
const TELL_SPREAD: usize = 8;
/// And so many wagons.
const TELL_WAGONS: usize = 4;

/// Changes, taken apart.
#[derive(Debug, Clone, Default)]
pub(crate) struct Split {
    /// Of each wheelset, in the order of what was given: beside the others of its wagon; `None` where there is no other.
    pub beside: Vec<Option<Change>>,
    /// Of each wagon with any: the mean of its wheelsets.
    pub wagons: Vec<(usize, Change)>,
}

/// Takes changes of wheelsets (wagon, wheelset, change) apart; those of one wagon stand in a row.
pub(crate) fn split(changes: &[(usize, usize, Change)]) -> Split {
    let mut split = Split::default();
    for of_wagon in changes.chunk_by(|a, b| a.0 == b.0) {
        let count = of_wagon.len() as f64;
        let sum = |of: fn(&Change) -> f64| of_wagon.iter().map(|(.., change)| of(change)).sum::<f64>();
        let whole = Change {
            value: sum(|one| one.value) / count,
            variance: sum(|one| one.variance) / (count * count),
        };
        split.wagons.push((of_wagon[0].0, whole));
        for (place, (.., own)) in of_wagon.iter().enumerate() {
            let others = of_wagon.iter().enumerate().filter(|(other, _)| *other != place);
            let mut values: Vec<f64> = others.map(|(_, (.., change))| change.value).collect();
            let known = values.len() as f64;
            let rest_variance = (sum(|one| one.variance) - own.variance) / (known * known);
            split.beside.push((known > 0.0).then(|| Change {
                value: own.value - median(&mut values),
                // A median of few is worth somewhat less than their mean.
                variance: own.variance + 1.5 * rest_variance,
            }));
        }
    }
    let within = spread(split.beside.iter().flatten().map(|change| change.value), TELL_SPREAD);
    let between = spread(split.wagons.iter().map(|(_, change)| change.value), TELL_WAGONS);
    for change in split.beside.iter_mut().flatten() {
        change.variance = change.variance.max(within * within);
    }
    for (_, change) in &mut split.wagons {
        change.variance = change.variance.max(between * between);
    }
    split
}

/// Robust sigma of values about their median; 0 where there are too few.
pub(crate) fn spread(values: impl Iterator<Item = f64>, least: usize) -> f64 {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    if values.len() < least {
        return 0.0;
    }
    let middle = median(&mut values);
    MAD_TO_SIGMA * median(&mut values.iter().map(|value| (value - middle).abs()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wagon_that_runs_in_is_no_change_of_its_wheelsets() {
        let mut changes = Vec::new();
        for wagon in 0..6 {
            for k in 0..4 {
                let runs_in = 0.2 * f64::from(wagon) - 0.5;
                let glazed = if (wagon, k) == (2, 1) { -0.4 } else { 0.0 };
                let value = runs_in + glazed + 0.01 * f64::from(k);
                changes.push((wagon as usize, k as usize, Change { value, variance: 1e-4 }));
            }
        }
        let split = split(&changes);
        let own = split.beside[9].expect("it has others");
        assert!((own.value + 0.4).abs() < 0.03 && own.variance < 1e-3, "{own:?}");
        let others = split.beside.iter().enumerate().filter(|(index, _)| *index != 9);
        assert!(others.flat_map(|(_, one)| one).all(|one| one.value.abs() < 0.05));
        assert!(split.wagons.iter().all(|(_, one)| one.variance > 0.05), "{:?}", split.wagons);
        let alone = super::split(&[(0, 0, Change { value: 1.0, variance: 1.0 })]);
        assert!(alone.beside[0].is_none() && alone.wagons.len() == 1);
    }
}
