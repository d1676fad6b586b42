//! A map of the adhesion available along the track, made of what every passing wagon saw.
//!
//! The track is divided into cells; each holds a [`Belief`] about the peak adhesion there. What a sliding wheelset utilises
//! is about the peak, what a rolling one utilises bounds it from below; likelihoods multiply, which for normal ones is
//! the precision-weighted mean. Between passes a cell fades to the prior: rails dry, and leaves fall. Wheelsets that
//! clean or wet the rail for those behind are not in the model.

mod cell;
mod kept;

use crate::belief::{Belief, CLASSES, Evidence, Rail};
use cell::Cell;
use railgrip_messages::{Health, WheelsetHealth};
use std::collections::{BTreeMap, BTreeSet};

/// Slower than this nothing about the rail is learnt, m/s.
const LEAST_SPEED_M_S: f64 = 0.5;
/// What came so long after the wagon's last news says nothing about the way between, s.
const LONGEST_STEP_S: f64 = 1.0;
/// A wheelset brakes from this pressing force on, N.
const BRAKES_FROM_N: f64 = 2000.0;

/// A cell as it is kept: its number, and its bytes or `None` if it is forgotten.
pub type KeptCell = (i64, Option<Vec<u8>>);

/// What is known of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct CellView {
    /// Where it begins, m.
    pub from_m: f64,
    /// Median of the peak adhesion, with the ends of its 95 % interval.
    pub adhesion: [f64; 3],
    /// Probability of dry, wet, low and very low rail.
    pub classes: [f64; CLASSES],
    /// Seconds since it was last passed.
    pub age_s: f64,
    /// Wagons that have passed it.
    pub wagons: usize,
    /// Observations of sliding wheelsets in it.
    pub slides: u32,
}

/// The map.
#[derive(Debug, Clone)]
pub struct TrackMap {
    rail: Rail,
    cell_m: f64,
    most_cells: usize,
    cells: BTreeMap<i64, Cell>,
    /// Cells that have changed since they were last kept.
    changed: BTreeSet<i64>,
}

impl TrackMap {
    /// An empty map with cells of this length; `rail` brings the prior and the memory.
    #[must_use]
    pub const fn new(rail: Rail, cell_m: f64, most_cells: usize) -> Self {
        Self { rail, cell_m, most_cells, cells: BTreeMap::new(), changed: BTreeSet::new() }
    }

    /// Takes in what a wagon says, for the time since it last spoke (`before_ns`, monotonic).
    pub fn take(&mut self, health: &Health, before_ns: Option<u64>) {
        // A position of 0 is unknown; NaN is, whatever it stands for.
        let known = health.position_m.abs() > 0.0
            && health.v_m_s > LEAST_SPEED_M_S
            && health.mu_w_sigma > 0.0
            && health.mu_w.is_finite();
        let Some(before_ns) = before_ns.filter(|_| known) else { return };
        let seconds = health.acquired.monotonic_ns.saturating_sub(before_ns) as f64 * 1e-9;
        if !(0.0..=LONGEST_STEP_S).contains(&seconds) || seconds == 0.0 {
            return;
        }
        let wheelsets = &health.wheelset[..health.wheelset_count()];
        let slides = |one: &&WheelsetHealth| {
            one.sliding != 0 && (one.wsp_active != 0 || one.pressing_force_n > BRAKES_FROM_N)
        };
        let (sum, number) = wheelsets
            .iter()
            .filter(slides)
            .filter(|one| one.mu_w.is_finite())
            .fold((0.0, 0.0), |(sum, n), one| (sum + one.mu_w.abs(), n + 1.0));
        let sliding = number > 0.0;
        let utilised = if sliding { sum / number } else { health.mu_w.abs() };
        let evidence = Evidence { utilised, sigma: health.mu_w_sigma, sliding };
        let now_s = health.acquired.monotonic_ns as f64 * 1e-9;
        self.add(health.wagon, health.position_m, now_s, seconds, evidence);
    }

    /// A wagon saw something at a position for `seconds`, at time `now_s`.
    pub fn add(&mut self, wagon: u32, position_m: f64, now_s: f64, seconds: f64, evidence: Evidence) {
        let sound = position_m.is_finite() && evidence.utilised.is_finite() && evidence.sigma > 0.0;
        if !sound || !now_s.is_finite() {
            return;
        }
        let index = (position_m / self.cell_m).floor() as i64;
        self.changed.insert(index);
        let rail = self.rail;
        let fresh = || Cell { belief: Belief::prior(&rail), seen_s: now_s, slides: 0, wagons: Vec::new() };
        let cell = self.cells.entry(index).or_insert_with(fresh);
        let idle_s = (now_s - cell.seen_s).max(0.0);
        if idle_s > seconds {
            cell.belief.update(&rail, idle_s - seconds, None);
        }
        cell.belief.update(&rail, seconds, Some(evidence));
        cell.seen_s = now_s;
        cell.slides += u32::from(evidence.sliding);
        if !cell.wagons.contains(&wagon) {
            cell.wagons.push(wagon);
        }
        if self.cells.len() > self.most_cells {
            let oldest =
                self.cells.iter().min_by(|a, b| a.1.seen_s.total_cmp(&b.1.seen_s)).map(|(index, _)| *index);
            if let Some(index) = oldest {
                self.cells.remove(&index);
                self.changed.insert(index);
            }
        }
    }

    /// The cells that have changed since this was last asked, for whoever keeps them. `unix_ahead_s` is what the wall clock
    /// is ahead of the clock of [`Self::add`]: the latter begins anew with every start of the machine.
    pub fn take_changed(&mut self, unix_ahead_s: f64) -> Vec<KeptCell> {
        let changed = std::mem::take(&mut self.changed);
        let cell =
            |index: &i64| self.cells.get(index).map(|cell| kept::pack(cell, self.cell_m, unix_ahead_s));
        changed.iter().map(|index| (*index, cell(index))).collect()
    }

    /// Goes on from kept cells, where nothing newer is known; returns how many there were. Cells of another length, and
    /// what is no cell, are left out.
    pub fn restore(&mut self, cells: &[(i64, Vec<u8>)], unix_ahead_s: f64) -> usize {
        let mut taken = 0;
        for (index, packed) in cells.iter().take(self.most_cells) {
            if let Some(cell) = kept::unpack(packed, self.cell_m, unix_ahead_s) {
                taken += 1;
                self.cells.entry(*index).or_insert(cell);
            }
        }
        taken
    }

    /// All cells in the order of position, as they are known at `now_s`.
    #[must_use]
    pub fn view(&self, now_s: f64) -> Vec<CellView> {
        let view = |(index, cell): (&i64, &Cell)| {
            let age_s = (now_s - cell.seen_s).max(0.0);
            let mut belief = cell.belief;
            belief.update(&self.rail, age_s, None);
            let adhesion = [0.5, 0.025, 0.975].map(|share| belief.quantile(&self.rail, share));
            CellView {
                from_m: *index as f64 * self.cell_m,
                adhesion,
                classes: belief.classes(&self.rail),
                age_s,
                wagons: cell.wagons.len(),
                slides: cell.slides,
            }
        };
        self.cells.iter().map(view).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A low stretch from 1000 m to 1500 m at 0.055, braked over by wagons that see it with an error each.
    #[test]
    fn every_wagon_makes_the_map_more_certain_and_it_ages() {
        let rail = Rail::new([0.30, 0.12, 0.06], 0.6, 1800.0);
        let mut map = TrackMap::new(rail, 50.0, 100);
        let mut widths = Vec::new();
        for wagon in 1..=8u32 {
            let error = 0.004 * (f64::from(wagon) * 2.3).sin();
            for step in 0..100 {
                let position_m = 800.0 + 9.0 * f64::from(step);
                let low = (1000.0..1500.0).contains(&position_m);
                let utilised = if low { 0.055 + error } else { 0.08 };
                let now_s = 2.0 * f64::from(wagon) + 0.2 * f64::from(step);
                map.add(wagon, position_m, now_s, 0.2, Evidence { utilised, sigma: 0.003, sliding: low });
            }
            let cells = map.view(40.0);
            let inside = cells.iter().filter(|cell| (1000.0..1500.0).contains(&cell.from_m));
            let (sum, count) = inside
                .fold((0.0, 0.0), |(sum, n), cell| (sum + cell.adhesion[2] - cell.adhesion[1], n + 1.0));
            widths.push(sum / count);
        }
        println!("width of the 95 % interval after each wagon: {widths:.4?}");
        assert!(widths[7] < 0.6 * widths[0] && widths.windows(2).all(|pair| pair[1] <= pair[0] + 1e-9));
        let cell = |map: &TrackMap, from_m: f64, now_s: f64| {
            map.view(now_s).into_iter().find(|cell| cell.from_m == from_m).unwrap()
        };
        let inside = cell(&map, 1200.0, 40.0);
        println!("{inside:?}");
        assert!(inside.adhesion[1] <= 0.058 && inside.adhesion[2] >= 0.055);
        assert!(inside.classes[2] > 0.9 && inside.wagons == 8);
        assert!(cell(&map, 900.0, 40.0).classes[0] > 0.5, "beside it nothing is low");
        let aged = cell(&map, 1200.0, 20_000.0);
        assert!((aged.classes[0] - 0.6).abs() < 0.01, "{:?}", aged.classes);
    }

    #[test]
    fn a_map_outlives_its_process_and_its_machine() {
        let rail = Rail::new([0.30, 0.12, 0.06], 0.6, 1800.0);
        let mut map = TrackMap::new(rail, 50.0, 3);
        let evidence = |utilised| Evidence { utilised, sigma: 0.003, sliding: true };
        (0..4).for_each(|cell| {
            map.add(7, 50.0 * f64::from(cell), 100.0 + f64::from(cell), 1.0, evidence(0.055))
        });
        let kept = map.take_changed(1e9);
        assert_eq!(
            kept.iter().map(|(index, packed)| (*index, packed.is_some())).collect::<Vec<_>>(),
            [(0, false), (1, true), (2, true), (3, true)]
        );
        assert!(map.take_changed(1e9).is_empty());
        let kept: Vec<(i64, Vec<u8>)> =
            kept.into_iter().filter_map(|(index, packed)| Some((index, packed?))).collect();
        // The machine has started anew 60 s later: its own clock says 5 s.
        let mut next = TrackMap::new(rail, 50.0, 3);
        assert_eq!(next.restore(&kept, 1e9 + 163.0 - 5.0), 3);
        for (a, b) in map.view(163.0).iter().zip(next.view(5.0)) {
            println!("{a:?}");
            assert_eq!(
                (a.from_m, a.adhesion, a.wagons, a.slides),
                (b.from_m, b.adhesion, b.wagons, b.slides)
            );
            assert!(
                (a.age_s - b.age_s).abs() < 1e-3 && (a.classes[2] - b.classes[2]).abs() < 1e-6,
                "{a:?} {b:?}"
            );
        }
        assert_eq!(TrackMap::new(rail, 100.0, 3).restore(&kept, 0.0), 0, "cells of another length");
        for length in 0..kept[0].1.len() {
            let cut = vec![(1, kept[0].1[..length].to_vec())];
            let taken = TrackMap::new(rail, 50.0, 3).restore(&cut, 0.0);
            assert_eq!(taken, usize::from(length >= kept[0].1.len() - 4), "{length}");
        }
        assert_eq!(TrackMap::new(rail, 50.0, 3).restore(&[(1, vec![0xff; 300])], 0.0), 0);
    }

    #[test]
    fn the_map_is_bounded() {
        let mut map = TrackMap::new(Rail::new([0.30, 0.12, 0.06], 0.6, 60.0), 50.0, 10);
        for step in 0..100 {
            let evidence = Evidence { utilised: 0.05, sigma: 0.01, sliding: false };
            map.add(1, 50.0 * f64::from(step), f64::from(step), 1.0, evidence);
        }
        assert_eq!((map.view(100.0).len(), map.view(100.0)[0].from_m), (10, 4500.0));
    }
}
