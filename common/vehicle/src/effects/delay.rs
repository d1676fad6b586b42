//! A delay line of values per wheelset inside the hidden states of an effect.

use crate::{MAX_WHEELSETS, PerWheelset};

/// Layout: `[next row, row 0 … row n−1]` with one value a wheelset in each row; all in one slice of hidden states.
pub(super) struct DelayLine;

impl DelayLine {
    /// Hidden states for delays up to `longest_s`.
    pub(super) fn len(longest_s: f64, sample_period_s: f64) -> usize {
        let rows = (longest_s / sample_period_s).ceil() as usize + 3;
        1 + rows * MAX_WHEELSETS
    }

    /// Starts with a constant past.
    pub(super) fn fill(line: &mut [f64], values: &PerWheelset) {
        line[0] = 0.0;
        line[1..].chunks_exact_mut(MAX_WHEELSETS).for_each(|row| row.copy_from_slice(values));
    }

    /// Adds the newest sample.
    pub(super) fn push(line: &mut [f64], values: &PerWheelset) {
        let rows = (line.len() - 1) / MAX_WHEELSETS;
        let row = line[0] as usize;
        line[1 + row * MAX_WHEELSETS..][..MAX_WHEELSETS].copy_from_slice(values);
        line[0] = if row + 1 == rows { 0.0 } else { (row + 1) as f64 };
    }

    /// The value `samples` before the newest one, linear between samples; clamped to what the line holds.
    pub(super) fn read(line: &[f64], samples: f64) -> PerWheelset {
        let rows = (line.len() - 1) / MAX_WHEELSETS;
        let back = samples.clamp(0.0, (rows - 2) as f64);
        let whole = back as usize;
        let share = back - whole as f64;
        let newest = line[0] as usize + rows - 1;
        let row = |age: usize| &line[1 + ((newest - age) % rows) * MAX_WHEELSETS..][..MAX_WHEELSETS];
        let (near, far) = (row(whole), row(whole + 1));
        std::array::from_fn(|i| near[i] + share * (far[i] - near[i]))
    }

    /// Mean over the last `samples` samples (fractional), the newest included.
    pub(super) fn mean(line: &[f64], samples: f64) -> PerWheelset {
        let rows = (line.len() - 1) / MAX_WHEELSETS;
        let count = samples.clamp(1.0, (rows - 1) as f64);
        let newest = line[0] as usize + rows - 1;
        let mut sum = [0.0; MAX_WHEELSETS];
        let mut age = 0;
        while (age as f64) < count {
            let weight = (count - age as f64).min(1.0);
            let row = &line[1 + ((newest - age) % rows) * MAX_WHEELSETS..][..MAX_WHEELSETS];
            sum.iter_mut().zip(row).for_each(|(total, value)| *total += weight * value);
            age += 1;
        }
        sum.map(|total| total / count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_between_samples_and_averages() {
        let mut line = vec![0.0; DelayLine::len(0.1, 0.01)];
        DelayLine::fill(&mut line, &[0.0; 4]);
        for k in 0..37 {
            DelayLine::push(&mut line, &[f64::from(k), 0.0, 0.0, 0.0]);
        }
        assert_eq!(DelayLine::read(&line, 0.0)[0], 36.0);
        assert!((DelayLine::read(&line, 3.25)[0] - 32.75).abs() < 1e-12);
        assert!((DelayLine::mean(&line, 4.0)[0] - 34.5).abs() < 1e-12);
        assert!((DelayLine::mean(&line, 2.5)[0] - (36.0 + 35.0 + 17.0) / 2.5).abs() < 1e-12);
    }
}
