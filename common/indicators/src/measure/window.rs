//! The largest value of the last seconds.

use bytemuck::{Pod, Zeroable};

/// Places of the ring; the window is divided into so many.
const PLACES: usize = 20;

/// Largest magnitude in a sliding window, with its 1 σ.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct WindowMaximum {
    largest: [f64; PLACES],
    sigma: [f64; PLACES],
    elapsed_s: f64,
    place: u64,
}

impl WindowMaximum {
    /// Takes in a value that holds for `dt_s`.
    pub fn add(&mut self, dt_s: f64, value: f64, sigma: f64, window_s: f64) {
        self.elapsed_s += dt_s;
        let place_s = window_s / PLACES as f64;
        while self.elapsed_s >= place_s {
            self.elapsed_s -= place_s;
            self.place = (self.place + 1) % PLACES as u64;
            let place = self.index();
            (self.largest[place], self.sigma[place]) = (0.0, 0.0);
        }
        let place = self.index();
        if value > self.largest[place] && sigma.is_finite() {
            (self.largest[place], self.sigma[place]) = (value, sigma);
        }
    }

    /// The largest value and its 1 σ; `None` if nothing but zeros came.
    pub fn largest(&self) -> Option<(f64, f64)> {
        let place = (0..PLACES).max_by(|a, b| self.largest[*a].total_cmp(&self.largest[*b]))?;
        (self.largest[place] > 0.0).then(|| (self.largest[place], self.sigma[place]))
    }

    const fn index(&self) -> usize {
        // A snapshot may bring any number.
        (self.place % PLACES as u64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forgets_a_peak_after_the_window() {
        let mut window = WindowMaximum::default();
        assert_eq!(window.largest(), None);
        window.add(0.1, 0.2, 0.01, 10.0);
        for step in 1..140 {
            window.add(0.1, 0.05, 0.02, 10.0);
            let expected = if step < 95 { Some((0.2, 0.01)) } else { window.largest() };
            assert_eq!(window.largest(), expected, "step {step}");
        }
        assert_eq!(window.largest(), Some((0.05, 0.02)));
    }
}
