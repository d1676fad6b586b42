//! What only the wagons together show: a wagon that does not brake while the train does, and one that begins later than
//! its place in the train explains.
//!
//! No wagon can tell by itself that the train brakes; here all of them are known. A wagon is *without* a brake when its
//! pressing force is a small share of the median of all wagons for as long as that median stands. The beginnings of one
//! application are put on a line over the place in the train (Theil–Sen: the signal travels along the brake pipe, and
//! one wagon must not bend it); the *delay* of a wagon is what remains, as median over its latest applications.

use crate::api::figure::Figure;
use crate::api::figure::rounded;
use crate::api::grade::Grade;
use railgrip_indicators::IndicatorSettings;
use railgrip_messages::Health;
use std::collections::{BTreeMap, VecDeque};

/// Fewer live wagons say nothing about each other.
const LEAST_WAGONS: usize = 3;
/// The train must have braked for this long, s: cylinders do not fill at the same instant.
const AFTER_S: f64 = 4.0;
/// Less than this share of the median is no pressing force.
const NONE_SHARE: f64 = 0.15;
/// Braking behind a verdict, s.
const LEAST_BRAKING_S: f64 = 3.0;
/// Beginnings within this time belong to one application of the train, ns.
const TOGETHER_NS: u64 = 12_000_000_000;
/// Delays that are kept, and how many a verdict needs.
const KEPT: usize = 7;
const LEAST_DELAYS: usize = 3;

/// What is known of all wagons.
#[derive(Debug, Default)]
pub(crate) struct Neighbours {
    wagons: BTreeMap<u32, Known>,
    braking_s: f64,
    /// The running application: when it began, and when on each wagon.
    began: Option<(u64, BTreeMap<u32, u64>)>,
}

#[derive(Debug, Default)]
struct Known {
    without: f64,
    weight_s: f64,
    applications: Option<u64>,
    delays_s: VecDeque<f64>,
}

impl Neighbours {
    /// Takes in what the live wagons say, `dt_s` after the last time.
    pub fn take(&mut self, live: &[&Health], now_ns: u64, dt_s: f64, settings: &IndicatorSettings) {
        self.pressed(live, dt_s.clamp(0.0, 1.0), settings);
        for health in live {
            let known = self.wagons.entry(health.wagon).or_default();
            let before = known.applications.replace(health.brake_applications);
            let at_ns = health.brake_applied.monotonic_ns;
            if before.is_some_and(|before| health.brake_applications > before) && at_ns <= now_ns {
                let (_, began) = self.began.get_or_insert_with(|| (now_ns, BTreeMap::new()));
                began.entry(health.wagon).or_insert(at_ns);
            }
        }
        if self.began.as_ref().is_some_and(|(since_ns, _)| now_ns.saturating_sub(*since_ns) > TOGETHER_NS)
            && let Some((_, began)) = self.began.take()
        {
            self.compare(&began, live.len());
        }
    }

    fn pressed(&mut self, live: &[&Health], dt_s: f64, settings: &IndicatorSettings) {
        let of = |health: &Health| health.pressing_force_n / health.wheelset_count().max(1) as f64;
        let mut forces: Vec<f64> =
            live.iter().map(|health| of(health)).filter(|force| force.is_finite()).collect();
        forces.sort_by(f64::total_cmp);
        let median = forces.get(forces.len() / 2).copied().unwrap_or(0.0);
        let braking =
            forces.len() >= LEAST_WAGONS && median >= 2.0 * settings.brake_friction.min_pressing_force_n;
        self.braking_s = if braking { self.braking_s + dt_s } else { 0.0 };
        if self.braking_s < AFTER_S {
            return;
        }
        let keep = (-dt_s / settings.isolated.memory_s).exp();
        for health in live.iter().filter(|health| of(health).is_finite()) {
            let protected = health.wheelset[..health.wheelset_count()].iter().any(|one| one.wsp_active != 0);
            if protected {
                continue;
            }
            let known = self.wagons.entry(health.wagon).or_default();
            let none = f64::from(u8::from(of(health) < NONE_SHARE * median));
            known.without = keep * known.without + dt_s * none;
            known.weight_s = keep * known.weight_s + dt_s;
        }
    }

    fn compare(&mut self, began: &BTreeMap<u32, u64>, live: usize) {
        if began.len() < LEAST_WAGONS.max(live.div_ceil(2)) {
            return;
        }
        let first_ns = began.values().copied().min().unwrap_or(0);
        let points: Vec<(f64, f64)> = began
            .iter()
            .map(|(wagon, at_ns)| (f64::from(*wagon), at_ns.saturating_sub(first_ns) as f64 * 1e-9))
            .collect();
        let mut slopes: Vec<f64> = Vec::new();
        for (index, (x, y)) in points.iter().enumerate() {
            slopes.extend(points[..index].iter().map(|(u, v)| (y - v) / (x - u)));
        }
        let slope = median(&mut slopes);
        let mut offsets: Vec<f64> = points.iter().map(|(x, y)| y - slope * x).collect();
        let offset = median(&mut offsets);
        for ((wagon, _), (x, y)) in began.iter().zip(&points) {
            let delays_s = &mut self.wagons.entry(*wagon).or_default().delays_s;
            delays_s.push_back(y - offset - slope * x);
            if delays_s.len() > KEPT {
                delays_s.pop_front();
            }
        }
    }

    /// How much of the latest braking of the train a wagon had no pressing force.
    pub fn without(&self, wagon: u32, settings: &IndicatorSettings) -> Option<Figure> {
        let known = self.wagons.get(&wagon).filter(|known| known.weight_s >= LEAST_BRAKING_S)?;
        let share = known.without / known.weight_s;
        let (limits, percent) = (&settings.isolated, 100.0 * share);
        let (grade, words) = match share {
            share if share > limits.act => {
                (Grade::Act, "the whole wagon is without pressing force while the train brakes")
            }
            share if share > limits.watch => {
                (Grade::Watch, "the whole wagon is often without pressing force while the train brakes")
            }
            _ => (Grade::Ok, "pressed like the other wagons"),
        };
        let share = Some(rounded(share));
        let reason = format!("{words}: without in {percent:.0} % of the latest braking");
        Some(Figure { value: share, low: share, high: share, grade, reason })
    }

    /// How much later than its place explains a wagon begins to brake, s.
    pub fn delay(&self, wagon: u32, settings: &IndicatorSettings) -> Figure {
        let delays = self.wagons.get(&wagon).map(|known| &known.delays_s);
        let Some(delays) = delays.filter(|delays| delays.len() >= LEAST_DELAYS) else {
            let reason = "needs three brake applications of at least three wagons".to_owned();
            return Figure { value: None, low: None, high: None, grade: Grade::Unknown, reason };
        };
        let mut sorted: Vec<f64> = delays.iter().copied().collect();
        let value = median(&mut sorted);
        let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
        // Half of the way to the lowest: one early beginning does not excuse the others.
        let sure = 0.5 * (low + value);
        let (grade, words) = match sure {
            sure if sure > settings.response.late_act_s => (Grade::Act, "begins to brake far too late"),
            sure if sure > settings.response.late_watch_s => (Grade::Watch, "begins to brake late"),
            _ => (Grade::Ok, "begins in its turn"),
        };
        let reason = format!(
            "{words}: {value:+.2} s against its place in the train, {low:+.2} to {high:+.2} s of late"
        );
        let of = |value: f64| Some(rounded(value));
        Figure { value: of(value), low: of(low), high: of(high), grade, reason }
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.get(middle) {
        None => 0.0,
        Some(upper) if values.len() % 2 == 1 => *upper,
        Some(upper) => 0.5 * (upper + values[middle - 1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Stamp;

    /// Eight wagons that brake for 12 s every 40 s; wagon 5 is cut off, wagon 3 begins late.
    fn run(cut_off: Option<u32>, late: Option<(u32, f64)>) -> Neighbours {
        let settings = IndicatorSettings::default();
        let mut seen = Neighbours::default();
        let mut health: Vec<Health> =
            (1..=8).map(|wagon| Health { wagon, wheelsets: 2, ..Health::default() }).collect();
        for tenth in 0..2000_u64 {
            let t_s = 0.1 * tenth as f64;
            for one in &mut health {
                let delay_s = 0.1 * f64::from(one.wagon)
                    + late.filter(|(wagon, _)| *wagon == one.wagon).map_or(0.0, |(_, s)| s);
                let in_cycle_s = (t_s % 40.0) - 5.0 - delay_s;
                let pressed = (0.0..12.0).contains(&in_cycle_s) && cut_off != Some(one.wagon);
                if pressed && one.pressing_force_n == 0.0 {
                    one.brake_applications += 1;
                    one.brake_applied = Stamp { unix_ns: 0, monotonic_ns: (1e9 * (t_s - in_cycle_s)) as u64 };
                }
                one.pressing_force_n = if pressed { 60_000.0 } else { 0.0 };
            }
            let live: Vec<&Health> = health.iter().collect();
            seen.take(&live, tenth * 100_000_000, 0.1, &settings);
        }
        seen
    }

    #[test]
    fn a_wagon_that_is_cut_off_is_told_from_the_others() {
        let (seen, settings) = (run(Some(5), None), IndicatorSettings::default());
        for wagon in 1..=8 {
            let figure = seen.without(wagon, &settings).unwrap();
            println!("wagon {wagon}: {}", figure.reason);
            let expected = if wagon == 5 { Grade::Act } else { Grade::Ok };
            assert_eq!(figure.grade, expected);
        }
    }

    #[test]
    fn a_late_wagon_is_told_from_the_way_of_the_signal() {
        let (seen, settings) = (run(None, Some((3, 1.2))), IndicatorSettings::default());
        for wagon in 1..=8 {
            let figure = seen.delay(wagon, &settings);
            println!("wagon {wagon}: {}", figure.reason);
            let expected = if wagon == 3 { Grade::Watch } else { Grade::Ok };
            assert_eq!(figure.grade, expected);
        }
        assert!((seen.delay(3, &settings).value.unwrap() - 1.2).abs() < 0.15);
        assert_eq!(Neighbours::default().delay(1, &settings).grade, Grade::Unknown);
    }
}
