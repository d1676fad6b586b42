//! Whether a column has the sign of a run: told by what it does beside the speed of the wagon.

use crate::columns::Quantity;

/// Correlation below which a sign is the other way round; sensors that have theirs lie above 0, noise near it.
const TURNED: f64 = -0.5;
/// Stretches that a run is cut into to see whether it gains or loses speed: long beside noise, short beside an application.
const STRETCHES: usize = 100;
/// Fewer rows tell no sign.
const LEAST_ROWS: usize = 20;

/// Why the sign of a column is the other way round, as a sentence; nothing where it is right or cannot be told.
pub(super) fn turned(quantity: Quantity, cells: &[f64], speed: Option<&[f64]>) -> Option<&'static str> {
    if cells.len() < LEAST_ROWS {
        return None;
    }
    match quantity {
        Quantity::WheelSpeed => (correlation(cells, speed?) < TURNED)
            .then_some("turns backward while the wagon runs forward, so that its sign is turned"),
        Quantity::PressingForce => (balance(cells) < TURNED)
            .then_some("is below zero while the brake is applied, so that its sign is turned"),
        Quantity::DriveTorque => {
            let (gains, torques) = (gains(speed?), means(cells));
            (correlation(&torques, &gains) < TURNED).then_some(
                "drives while the wagon loses speed and brakes while it gains some, so that its sign is turned",
            )
        }
        _ => None,
    }
}

/// Like a correlation, but about zero: −1 where two columns always have opposite signs, 0 where one of them is nothing.
fn correlation(one: &[f64], other: &[f64]) -> f64 {
    let scale = |cells: &[f64]| {
        cells
            .iter()
            .copied()
            .filter(|cell| cell.is_finite())
            .fold(0.0, |most: f64, cell| most.max(cell.abs()))
    };
    let (of_one, of_other) = (scale(one), scale(other));
    if of_one == 0.0 || of_other == 0.0 {
        return 0.0;
    }
    let (mut product, mut squares) = (0.0, [0.0, 0.0]);
    for (a, b) in one.iter().zip(other).filter(|(a, b)| a.is_finite() && b.is_finite()) {
        let (a, b) = (a / of_one, b / of_other);
        product += a * b;
        squares = [squares[0] + a * a, squares[1] + b * b];
    }
    let size = (squares[0] * squares[1]).sqrt();
    if size > 0.0 { product / size } else { 0.0 }
}

/// How much of what a column reads is above zero rather than below: 1 all, −1 nothing.
fn balance(cells: &[f64]) -> f64 {
    let ones = vec![1.0; cells.len()];
    correlation(cells, &ones)
}

/// The mean of each stretch, NaN where nothing was measured.
fn means(cells: &[f64]) -> Vec<f64> {
    cells.chunks(cells.len().div_ceil(STRETCHES).max(2)).map(mean).collect()
}

fn mean(cells: &[f64]) -> f64 {
    let known = || cells.iter().copied().filter(|cell| cell.is_finite());
    known().sum::<f64>() / known().count() as f64
}

/// By how much the second half of each stretch of [`means`] is faster than the first.
fn gains(speed: &[f64]) -> Vec<f64> {
    let gain = |cells: &[f64]| {
        let (before, after) = cells.split_at(cells.len() / 2);
        mean(after) - mean(before)
    };
    speed.chunks(speed.len().div_ceil(STRETCHES).max(2)).map(gain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wagon that speeds up, coasts and brakes with its motors.
    fn run() -> (Vec<f64>, Vec<f64>) {
        let torque = |k: usize| [800.0, 0.0, -1500.0][k / 1000];
        let torques: Vec<f64> = (0..3000).map(torque).collect();
        let mut speed = 10.0;
        let speeds = torques.iter().enumerate().map(|(k, torque)| {
            speed += torque * 1e-5;
            speed + 0.02 * (k as f64 * 1.7).sin()
        });
        (speeds.collect(), torques)
    }

    fn negative(cells: &[f64]) -> Vec<f64> {
        cells.iter().map(|cell| -cell).collect()
    }

    #[test]
    fn a_turned_torque_is_told_and_a_right_one_is_not() {
        let (speed, torque) = run();
        assert_eq!(turned(Quantity::DriveTorque, &torque, Some(&speed)), None);
        assert!(turned(Quantity::DriveTorque, &negative(&torque), Some(&speed)).is_some());
        // Backward, what drives forward brakes.
        assert_eq!(turned(Quantity::DriveTorque, &negative(&torque), Some(&negative(&speed))), None);
        assert_eq!(turned(Quantity::DriveTorque, &negative(&torque), None), None);
    }

    #[test]
    fn wheels_turn_as_the_wagon_runs_and_pads_press() {
        let (speed, _) = run();
        let wheels: Vec<f64> = speed.iter().map(|speed| speed / 0.46).collect();
        assert_eq!(turned(Quantity::WheelSpeed, &wheels, Some(&speed)), None);
        assert!(turned(Quantity::WheelSpeed, &negative(&wheels), Some(&speed)).is_some());
        let pads: Vec<f64> = (0..3000).map(|k| if k < 1500 { 0.3 } else { 3.8 }).collect();
        assert_eq!(turned(Quantity::PressingForce, &pads, None), None);
        assert!(turned(Quantity::PressingForce, &negative(&pads), None).is_some());
    }

    #[test]
    fn nothing_is_told_of_nothing() {
        for cells in [vec![], vec![f64::NAN; 100], vec![0.0; 100], vec![1e308; 100]] {
            for quantity in Quantity::ALL {
                assert_eq!(turned(quantity, &cells, Some(&cells)), None, "{quantity:?} {cells:?}");
            }
        }
    }
}
