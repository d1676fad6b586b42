//! Slides of one wheelset: when they begin and end, how long, how much energy.

use bytemuck::{Pod, Zeroable};

/// A slide ends when the wheelset has rolled for this long, s: the slide protection makes a slide of many short ones.
const ROLLING_ENDS_S: f64 = 0.3;
/// Below this creepage a wheelset counts as locked.
const LOCKED_CREEPAGE: f64 = -0.9;
/// Slower than this a locked wheelset is a stop, m/s.
const LOCKED_FROM_M_S: f64 = 2.0;

/// Counts and energies, with what the running slide has so far.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Slides {
    /// Slides that lasted long enough.
    pub count: f64,
    /// Energy of all sliding, J.
    pub energy_j: f64,
    /// Time of all sliding, s.
    pub seconds: f64,
    /// Energy of the last time, fading, J.
    pub recent_energy_j: f64,
    /// Time locked of the last time, fading, s.
    pub recent_locked_s: f64,
    /// The running slide, or zeros.
    pub running: Slide,
    pub rolling_s: f64,
}

/// One slide.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Slide {
    /// Duration, s; 0 means that there is none.
    pub seconds: f64,
    /// Energy: friction force times slip velocity over time, J.
    pub energy_j: f64,
    /// Largest magnitude of creepage.
    pub creepage: f64,
    /// Smallest adhesion utilised, magnitude.
    pub utilised: f64,
}

/// One sample of a wheelset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Motion {
    pub v_m_s: f64,
    pub creepage: f64,
    pub utilised: f64,
    pub normal_load_n: f64,
    pub sliding: bool,
}

/// What a sample changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Change {
    /// A slide has lasted long enough to count.
    Began,
    /// It is over.
    Ended(Slide),
}

impl Slides {
    /// Takes in one sample that holds for `dt_s`.
    pub fn add(&mut self, dt_s: f64, motion: Motion, least_s: f64, memory_s: f64) -> Option<Change> {
        let keep = 1.0 - (dt_s / memory_s).min(1.0);
        self.recent_energy_j *= keep;
        self.recent_locked_s *= keep;
        if !motion.sliding {
            self.rolling_s += dt_s;
            let over = self.running.seconds > 0.0 && self.rolling_s >= ROLLING_ENDS_S;
            return over.then(|| self.end(least_s)).flatten();
        }
        self.rolling_s = 0.0;
        let slip_velocity_m_s = motion.creepage.abs() * motion.v_m_s.max(0.5);
        let energy_j = motion.utilised * motion.normal_load_n * slip_velocity_m_s * dt_s;
        if energy_j.is_finite() {
            self.energy_j += energy_j;
            self.recent_energy_j += energy_j;
            self.running.energy_j += energy_j;
        }
        if motion.creepage < LOCKED_CREEPAGE && motion.v_m_s > LOCKED_FROM_M_S {
            self.recent_locked_s += dt_s;
        }
        self.seconds += dt_s;
        self.grow(dt_s, motion, least_s)
    }

    fn grow(&mut self, dt_s: f64, motion: Motion, least_s: f64) -> Option<Change> {
        let slide = &mut self.running;
        let begins = slide.seconds == 0.0;
        let counted = !begins && slide.seconds >= least_s;
        slide.utilised = if begins { motion.utilised } else { slide.utilised.min(motion.utilised) };
        slide.creepage = slide.creepage.max(motion.creepage.abs());
        slide.seconds += dt_s;
        if !counted && slide.seconds >= least_s {
            self.count += 1.0;
            return Some(Change::Began);
        }
        None
    }

    /// Ends the running slide, if there is one; `Some` if it was long enough to count.
    pub fn end(&mut self, least_s: f64) -> Option<Change> {
        let slide = std::mem::take(&mut self.running);
        (slide.seconds > 0.0 && slide.seconds >= least_s).then_some(Change::Ended(slide))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROLLING: Motion =
        Motion { v_m_s: 20.0, creepage: -0.002, utilised: 0.06, normal_load_n: 200e3, sliding: false };
    const SLIDING: Motion = Motion { creepage: -0.2, sliding: true, ..ROLLING };

    fn play(slides: &mut Slides, motion: Motion, seconds: f64) -> Vec<Change> {
        (0..(seconds * 100.0) as usize).filter_map(|_| slides.add(0.01, motion, 0.1, 3600.0)).collect()
    }

    #[test]
    fn a_slide_has_the_energy_of_force_times_slip_velocity() {
        let mut slides = Slides::default();
        assert_eq!(play(&mut slides, SLIDING, 5.0), [Change::Began]);
        let ended = play(&mut slides, ROLLING, 1.0);
        let expected_j = 0.06 * 200e3 * 0.2 * 20.0 * 5.0;
        let [Change::Ended(slide)] = ended[..] else { panic!("{ended:?}") };
        assert!(
            (slide.energy_j / expected_j - 1.0).abs() < 1e-9 && (slide.seconds - 5.0).abs() < 1e-9,
            "{slide:?}"
        );
        assert!((slide.utilised, slide.creepage) == (0.06, 0.2));
        assert_eq!((slides.count, slides.running), (1.0, Slide::default()));
        assert!((slides.recent_energy_j / expected_j - 1.0).abs() < 0.01);
    }

    #[test]
    fn slide_protection_makes_one_slide_of_many_short_ones() {
        let mut slides = Slides::default();
        for _ in 0..5 {
            play(&mut slides, SLIDING, 0.4);
            play(&mut slides, ROLLING, 0.2);
        }
        assert_eq!(slides.count, 1.0);
        play(&mut slides, ROLLING, 0.3);
        play(&mut slides, SLIDING, 0.05);
        play(&mut slides, ROLLING, 1.0);
        assert_eq!(slides.count, 1.0, "50 ms are no slide");
    }

    #[test]
    fn a_locked_wheelset_is_told_from_a_standing_train() {
        let mut slides = Slides::default();
        play(&mut slides, Motion { creepage: -1.0, ..SLIDING }, 2.0);
        play(&mut slides, Motion { creepage: -1.0, v_m_s: 0.5, ..SLIDING }, 2.0);
        assert!((slides.recent_locked_s - 2.0).abs() < 0.01, "{}", slides.recent_locked_s);
    }
}
