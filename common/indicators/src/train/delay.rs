//! A wagon that begins to brake later than its place in the train explains.
//!
//! The beginnings of one application are put on a line over the place in the train (Theil–Sen: the signal travels along the
//! brake pipe, and one wagon must not bend it); the delay of a wagon is what remains, as median over its latest
//! applications.

use super::middle::{LEAST_WAGONS, median};
use railgrip_messages::Health;
use std::collections::{BTreeMap, VecDeque};

/// Beginnings within so long belong to one application of the train, ns.
const TOGETHER_NS: u64 = 12_000_000_000;
/// Delays that are kept of a wagon.
const KEPT: usize = 7;
/// Delays that a verdict needs.
const LEAST_DELAYS: usize = 3;

/// How late each wagon began in the latest applications of the train.
#[derive(Debug, Default)]
pub(super) struct Delays {
    wagons: BTreeMap<u32, Known>,
    /// The running application: when it began, and when on each wagon.
    began: Option<(u64, BTreeMap<u32, u64>)>,
}

#[derive(Debug, Default)]
struct Known {
    applications: Option<u64>,
    delays_s: VecDeque<f64>,
}

impl Delays {
    /// Takes in what the live wagons say at `now_ns`.
    pub(super) fn take(&mut self, live: &[&Health], now_ns: u64) {
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

    /// Delay of a wagon: median, smallest and largest of its latest applications, s.
    pub(super) fn delay_s(&self, wagon: u32) -> Option<[f64; 3]> {
        let delays_s = self.wagons.get(&wagon).map(|known| &known.delays_s)?;
        let mut sorted_s: Vec<f64> = delays_s.iter().copied().collect();
        let value_s = median(&mut sorted_s);
        let (low_s, high_s) = sorted_s.first().zip(sorted_s.last())?;
        (sorted_s.len() >= LEAST_DELAYS).then_some([value_s, *low_s, *high_s])
    }
}
