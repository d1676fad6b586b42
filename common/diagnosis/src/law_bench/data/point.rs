//! Measured points of a bench, and the variables that a law may depend on.

/// One measured point. Columns that the bench does not have are NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Index of its file among the files of its folder.
    pub file: usize,
    /// Place within its file, from 0 at the first row to 1 at the last.
    pub sequence: f64,
    /// Creepage, dimensionless, signed.
    pub creepage: f64,
    /// Normal load of the contact, N.
    pub load_n: f64,
    /// Speed of the vehicle or of the rig's circumference, m/s.
    pub speed_m_s: f64,
    /// Temperature of the disc, °C.
    pub temperature_c: f64,
    /// Pressing force on the pad, N.
    pub pressing_force_n: f64,
    /// What was measured: creep force in N, or brake friction.
    pub measured: f64,
}

/// A variable of the operating point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Covariate {
    /// |creepage| · speed, m/s; |creepage| where the bench has no speed column.
    SlipVelocity,
    /// |creepage|.
    Creepage,
    /// Normal load, N.
    Load,
    /// Speed, m/s.
    Speed,
    /// Disc temperature, °C.
    Temperature,
    /// Pressing force, N.
    PressingForce,
    /// Place within the file, 0 to 1.
    Sequence,
}

impl Covariate {
    /// The variable's value at a point; NaN where the bench does not have it.
    pub fn of(self, point: &Point) -> f64 {
        match self {
            Self::SlipVelocity if point.speed_m_s.is_nan() => point.creepage.abs(),
            Self::SlipVelocity => point.creepage.abs() * point.speed_m_s.abs(),
            Self::Creepage => point.creepage.abs(),
            Self::Load => point.load_n,
            Self::Speed => point.speed_m_s.abs(),
            Self::Temperature => point.temperature_c,
            Self::PressingForce => point.pressing_force_n,
            Self::Sequence => point.sequence,
        }
    }

    /// Name for people, and in `where.regime`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SlipVelocity => "slip_velocity",
            Self::Creepage => "creepage",
            Self::Load => "load",
            Self::Speed => "speed",
            Self::Temperature => "temperature",
            Self::PressingForce => "pressing_force",
            Self::Sequence => "order_of_measurement",
        }
    }

    /// Unit of values as they are measured; empty where dimensionless.
    pub const fn si_unit(self) -> &'static str {
        match self {
            Self::Load | Self::PressingForce => "N",
            other => other.unit(),
        }
    }

    /// Unit on axes; empty where dimensionless. See [`Self::shown`].
    pub const fn unit(self) -> &'static str {
        match self {
            Self::SlipVelocity | Self::Speed => "m/s",
            Self::Creepage | Self::Sequence => "",
            Self::Load | Self::PressingForce => "kN",
            Self::Temperature => "°C",
        }
    }

    /// A value of the variable in the unit of its axis.
    pub fn shown(self, value: f64) -> f64 {
        match self {
            Self::Load | Self::PressingForce => 1e-3 * value,
            _ => value,
        }
    }
}

/// Spread of a variable over a set of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Smallest value.
    pub low: f64,
    /// Median.
    pub median: f64,
    /// Largest value.
    pub high: f64,
    /// Values at 5, 35, 65 and 95 % of the points.
    pub quantiles: [f64; 4],
}

impl Spread {
    /// The spread of `covariate`, unless the bench does not have it or does not vary it.
    pub fn of(points: &[Point], covariate: Covariate) -> Option<Self> {
        let mut values: Vec<f64> = points.iter().map(|point| covariate.of(point)).collect();
        if values.iter().any(|value| value.is_nan()) {
            return None;
        }
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        let (low, median, high) = (*values.first()?, at(0.5), *values.last()?);
        let varies = high - low > 0.02 * high.abs().max(low.abs()).max(1e-9);
        varies.then(|| Self { low, median, high, quantiles: knots(&values) })
    }

    /// Width of the range.
    pub fn width(&self) -> f64 {
        self.high - self.low
    }
}

/// Four knots that are apart even where the points stand on few levels.
fn knots(sorted: &[f64]) -> [f64; 4] {
    let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
    let even = |share: f64| low + share * (high - low);
    let knots = [0.05, 0.35, 0.65, 0.95].map(|share| 0.5 * (at(share) + even(share)));
    let apart = knots.windows(2).all(|pair| pair[1] - pair[0] > 0.05 * (high - low));
    if apart { knots } else { [0.05, 0.35, 0.65, 0.95].map(even) }
}
