//! Weather: rain over the day, wind, and the friction that both and the place leave on the rail.

use crate::random::Stream;

use super::line::{Line, LowStretch};

/// Friction levels of one day.
#[derive(Debug, Clone)]
pub struct Weather {
    /// Friction of clean dry rail.
    pub dry: f64,
    /// Friction in steady rain.
    pub wet: f64,
    /// When (s) how wet (0 to 1), linear between.
    pub wetness: Vec<(f64, f64)>,
    /// Mean speed of the air against the train, m/s.
    pub headwind_m_s: f64,
    /// Standard deviation of gusts, m/s.
    pub gust_m_s: f64,
    /// Air temperature, °C.
    pub air_c: f64,
    /// Energy per metre that cleans a dirty rail, J/m.
    pub(crate) cleaning_j_per_m: f64,
}

impl Weather {
    pub(crate) fn draw(stream: &mut Stream, duration_s: f64) -> Self {
        let level = |stream: &mut Stream, value: f64| value * stream.uniform(0.86, 1.15);
        let (dry, wet) = (level(stream, 0.3), level(stream, 0.115));
        let wetness = match stream.below(10) {
            0..5 => vec![(0.0, 0.0)],
            5..7 => vec![(0.0, 1.0)],
            _ => {
                let from_s = duration_s * stream.uniform(0.05, 0.6);
                let to_s = from_s + duration_s * stream.uniform(0.1, 0.5);
                let soak_s = stream.uniform(60.0, 400.0);
                vec![(from_s, 0.0), (from_s + soak_s, 1.0), (to_s + soak_s, 1.0), (to_s + 5.0 * soak_s, 0.0)]
            }
        };
        Self {
            dry,
            wet,
            wetness,
            headwind_m_s: stream.uniform(-4.0, 4.0),
            gust_m_s: stream.uniform(0.2, 0.7),
            air_c: stream.uniform(-5.0, 30.0),
            cleaning_j_per_m: stream.uniform(3e3, 8e3),
        }
    }

    /// How wet the rail is at a time, 0 to 1.
    pub(crate) fn wet_at(&self, time_s: f64) -> f64 {
        let after = self.wetness.partition_point(|(at_s, _)| *at_s <= time_s);
        match (after.checked_sub(1).map(|before| self.wetness[before]), self.wetness.get(after)) {
            (Some((from_s, from)), Some((to_s, to))) => {
                from + (to - from) * (time_s - from_s) / (to_s - from_s)
            }
            (Some((_, wet)), None) => wet,
            (None, first) => first.map_or(0.0, |(_, wet)| *wet),
        }
    }

    /// Friction of the rail at a place before any wheelset of this train has cleaned it.
    pub(crate) fn friction(&self, line: &Line, position_m: f64, wetness: f64) -> f64 {
        let clean = (self.dry + (self.wet - self.dry) * wetness.sqrt()) * line.texture(position_m);
        line.dirt(position_m).map_or(clean, |dirt| dirt.min(clean))
    }

    /// Friction after `energy_j_per_m` of slip by the wheelsets ahead.
    pub(crate) fn cleaned(&self, friction: f64, energy_j_per_m: f64) -> f64 {
        let clean = (1.8 * friction).min(0.16).max(friction);
        clean - (clean - friction) / (1.0 + energy_j_per_m / self.cleaning_j_per_m)
    }
}

/// Leaves here and there, as on one line in four.
pub(crate) fn leaves(stream: &mut Stream, length_m: f64) -> Vec<LowStretch> {
    if !stream.chance(0.25) {
        return Vec::new();
    }
    let count = 1 + stream.below(3);
    let mut stretch = |_| {
        let from_m = stream.uniform(0.05, 0.95) * length_m;
        LowStretch {
            from_m,
            to_m: from_m + stream.uniform(150.0, 900.0),
            friction: stream.uniform(0.055, 0.1),
        }
    };
    (0..count).map(&mut stretch).collect()
}
