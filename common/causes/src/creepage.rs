//! What the creepage of one wheelset says of its pads and of what holds it back.
//!
//! At small creepage the tangential force F of a wheelset shows as `r ω / v − 1 = F · c`, with the creep compliance c. A
//! brake of pad friction μ_B gives `F = −μ_B F_⊥ r_B / r`, a drive torque M and inertia give `F = (M − J ω̇) / r`. Hence for
//! the mean over a second
//!
//! ```text
//! r ω / v − 1 = δ − κ · (μ_nominal F_⊥ r_B / r) c + γ · ((M − J ω̇) / r) c − τ v̇ / v
//! ```
//!
//! with δ the error of the radius, κ pad friction over nominal (times the error of c), γ the error of c and τ by how much
//! this tachometer lags behind the speed of the train. All four are learnt by linear Bayesian regression, with priors from
//! what vehicle files are known to be worth. Couplers do not enter: what holds the wagon back does not turn its wheels.
//!
//! What has been learnt is a wheelset's own past. An application is judged by how far κ lies from it, rolling by how far δ
//! does; both before the application or the roll teaches anything, and what differs much teaches nothing.

/// Regressors.
const TERMS: usize = 4;
/// Friction of a healthy pad differs so much from one application to the next.
const PAD_WANDER: f64 = 0.03;
/// Of the samples of a second, coloured noise leaves so many independent ones.
const INDEPENDENT: f64 = 0.3;
/// A roll is judged after so many seconds.
const ROLL_S: f64 = 40.0;
const LEAST_ROLL_S: f64 = 15.0;

/// A tachometer may have begun to lag by so much since its past, s.
const BEGINS_TO_LAG_S: f64 = 0.15;

/// What is known before anything is learnt, and how good the equation is.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
pub(crate) struct Belief {
    /// δ, κ, γ and the last term, and one sigma of each.
    nominal: [f64; TERMS],
    prior: [f64; TERMS],
    /// What the equation leaves unexplained in a second: a constant, and a share of what brake and drive do.
    unexplained: (f64, f64),
    /// A healthy δ differs so much between two rolls.
    roll_wander: f64,
    /// Up to this brake, and this drive, a second counts as rolling.
    rolling: f64,
    coasting: f64,
    /// Whether the last term is a lag, 1, or not, 0.
    lagging: f64,
    /// What drive torque does is known to this share: the creep curve bends, and torque is inferred from current.
    drive_share: f64,
}

impl Belief {
    /// Of the creepage of a wheelset: radius, pad friction over nominal, creep compliance, lag (s).
    pub(crate) const CREEPAGE: Self = Self {
        nominal: [0.0, 1.0, 1.0, 0.0],
        prior: [0.02, 0.2, 0.08, 0.05],
        unexplained: (3e-5, 0.06),
        roll_wander: 1e-5,
        rolling: 2e-5,
        coasting: 2e-4,
        lagging: 1.0,
        drive_share: 0.15,
    };

    /// Of the same beside the other wheelsets of the wagon: all are differences.
    pub(crate) const BESIDE: Self = Self {
        nominal: [0.0; TERMS],
        prior: [0.02, 0.1, 0.08, 0.05],
        unexplained: (1e-5, 0.03),
        coasting: f64::INFINITY,
        drive_share: 0.03,
        ..Self::CREEPAGE
    };

    /// Of the balance of a wagon that runs alone: resistance over weight, pad friction and drive torque, both over mass. Measured
    /// acceleration stands on one side only: a term for the mass beside it would be fitted to its noise.
    pub(crate) const fn balance(mass_sigma: f64) -> Self {
        Self {
            nominal: [0.0, 1.0, 1.0, 0.0],
            prior: [0.002, 0.2, mass_sigma, 0.0],
            unexplained: (8e-4, 0.04),
            roll_wander: 4e-4,
            rolling: 1e-3,
            coasting: f64::INFINITY,
            lagging: 0.0,
            drive_share: 0.02,
        }
    }
}

/// A second of one wheelset.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Creep {
    /// `r ω / v − 1`.
    pub creepage: f64,
    /// Nominal brake creepage, positive.
    pub brake: f64,
    /// Creepage of drive torque and inertia.
    pub drive: f64,
    /// Acceleration over speed, 1/s.
    pub rate: f64,
    /// Variance of the creepage by its sensors, of the mean of the second.
    pub variance: f64,
}

/// A difference with its variance.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Change {
    pub value: f64,
    pub variance: f64,
}

impl Change {
    /// The difference over its sigma.
    pub(crate) fn sigmas(&self) -> f64 {
        self.value / self.variance.sqrt()
    }
}

/// How an application differed from the past.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
pub(crate) struct Braked {
    /// Change of κ.
    pub level: Change,
    /// Trend of κ within the application, 1/s.
    pub trend: Change,
    /// κ by this application alone.
    pub alone: Change,
    /// What drive and electric brake did, over what the pads did.
    pub driven: f64,
}

/// How a roll differed from the past.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rolled {
    /// Change of δ.
    pub change: Change,
    /// δ by this roll alone.
    pub alone: Change,
}

/// Sums of innovations against one regressor.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
struct Sums {
    seconds: f64,
    weight: f64,
    moment: f64,
    second_moment: f64,
    innovation: f64,
    innovation_moment: f64,
    regressors: [f64; TERMS],
}

impl Sums {
    /// An innovation with its regressor, at a time within the stretch.
    fn add(&mut self, innovation: f64, regressor: f64, variance: f64, row: &[f64; TERMS], t: f64) {
        let weight = regressor * regressor / variance;
        let pull = regressor * innovation / variance;
        self.seconds += 1.0;
        self.weight += weight;
        self.moment += weight * t;
        self.second_moment += weight * t * t;
        self.innovation += pull;
        self.innovation_moment += pull * t;
        for (sum, term) in self.regressors.iter_mut().zip(row) {
            *sum += regressor * term / variance;
        }
    }
}

/// Creepage of one wheelset against its own past.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Creepage {
    belief: Belief,
    theta: [f64; TERMS],
    covariance: [[f64; TERMS]; TERMS],
    before: ([f64; TERMS], [[f64; TERMS]; TERMS]),
    /// Squared innovations over what was expected; 1 if the declared noise is right.
    excess: f64,
    braking: Sums,
    rolling: Sums,
    learnt: f64,
}

impl Creepage {
    /// Nothing has been learnt yet.
    pub(crate) fn new(belief: Belief) -> Self {
        let mut covariance = [[0.0; TERMS]; TERMS];
        for k in 0..TERMS {
            covariance[k][k] = belief.prior[k] * belief.prior[k];
        }
        let theta = belief.nominal;
        Self {
            belief,
            theta,
            covariance,
            before: (theta, covariance),
            excess: 1.0,
            braking: Sums::default(),
            rolling: Sums::default(),
            learnt: 0.0,
        }
    }

    /// Variance that independent samples leave in a mean of `count`.
    pub(crate) fn of_mean(sigma: f64, count: f64) -> f64 {
        sigma * sigma / (INDEPENDENT * count).max(1.0)
    }

    /// Takes a second that belongs to the past that is being learnt; `t` since the application began, s.
    pub(crate) fn take(&mut self, creep: &Creep, t: f64) {
        let row = [1.0, -creep.brake, creep.drive, -creep.rate];
        let share = (self.belief.unexplained.1 * creep.brake).hypot(self.belief.drive_share * creep.drive);
        let own = self.belief.unexplained.0.hypot(share);
        let noise = self.excess.clamp(0.3, 30.0) * (creep.variance + own * own);
        let frozen: f64 = dot(&row, &self.before.0);
        if creep.brake > self.belief.rolling {
            self.braking.add(creep.creepage - frozen, -creep.brake, noise, &row, t);
        } else if creep.drive.abs() < self.belief.coasting {
            self.rolling.add(creep.creepage - frozen, 1.0, noise, &row, self.belief.lagging * creep.rate);
        }
        self.learn(creep.creepage, &row, noise);
    }

    fn learn(&mut self, creepage: f64, row: &[f64; TERMS], noise: f64) {
        let mut gain = [0.0; TERMS];
        for (i, place) in gain.iter_mut().enumerate() {
            *place = dot(&self.covariance[i], row);
        }
        let variance = noise + dot(&gain, row);
        let innovation = creepage - dot(row, &self.theta);
        let ratio = innovation * innovation / variance;
        self.learnt += 1.0;
        // A gross outlier says nothing about noise and teaches little.
        if ratio > 25.0 && self.learnt > 60.0 {
            return;
        }
        self.excess += (ratio.min(9.0) * self.excess - self.excess) / self.learnt.clamp(30.0, 600.0);
        for i in 0..TERMS {
            self.theta[i] += gain[i] * innovation / variance;
        }
        for i in 0..TERMS {
            for j in 0..TERMS {
                self.covariance[i][j] -= gain[i] * gain[j] / variance;
            }
        }
    }

    /// The application is over: how it differed; `None` if it was too short to say.
    pub(crate) fn end_of_braking(&mut self) -> Option<Braked> {
        let sums = std::mem::take(&mut self.braking);
        if sums.seconds < 4.0 || sums.weight <= 0.0 {
            return None;
        }
        let row = sums.regressors.map(|sum| sum / sums.weight);
        let level = Change {
            value: sums.innovation / sums.weight,
            variance: 1.0 / sums.weight
                + quadratic(&row, &self.before.1)
                + PAD_WANDER * PAD_WANDER
                // An error of the drive's share is the same in every second of the application.
                + (self.belief.drive_share * row[2]).powi(2),
        };
        let middle = sums.moment / sums.weight;
        let spread = sums.second_moment - middle * sums.moment;
        let trend = Change {
            value: (sums.innovation_moment - middle * sums.innovation) / spread.max(1e-9),
            variance: 1.0 / spread.max(1e-9),
        };
        // Whatever was believed of κ has no part in it.
        let others = [row[0], 0.0, row[2], row[3]];
        let alone = Change {
            value: self.before.0[1] + level.value,
            variance: level.variance - quadratic(&row, &self.before.1) + quadratic(&others, &self.before.1),
        };
        Some(Braked { level, trend, alone, driven: row[2].abs() })
    }

    /// A roll is over, or has lasted long enough.
    pub(crate) fn end_of_roll(&mut self, interrupted: bool) -> Option<Rolled> {
        if self.rolling.seconds < if interrupted { LEAST_ROLL_S } else { ROLL_S } {
            if interrupted {
                self.rolling = Sums::default();
            }
            return None;
        }
        let sums = std::mem::take(&mut self.rolling);
        let row = sums.regressors.map(|sum| sum / sums.weight);
        // A tachometer that has begun to lag reads less the more the train accelerates: what is left at no acceleration counts.
        let lag = sums.second_moment + 1.0 / (BEGINS_TO_LAG_S * BEGINS_TO_LAG_S);
        let determinant = sums.weight * lag - sums.moment * sums.moment;
        let value = (sums.innovation * lag - sums.moment * sums.innovation_moment) / determinant;
        let own = lag / determinant + self.belief.roll_wander.powi(2);
        let change = Change { value, variance: own + quadratic(&row, &self.before.1) };
        // Whatever was believed of δ has no part in it.
        let others = [0.0, row[1], row[2], row[3]];
        let alone =
            Change { value: self.before.0[0] + value, variance: own + quadratic(&others, &self.before.1) };
        Some(Rolled { change, alone })
    }

    /// What was learnt since the last call stays (`true`) or is forgotten.
    pub(crate) fn settle(&mut self, stays: bool) {
        if stays {
            self.before = (self.theta, self.covariance);
        } else {
            (self.theta, self.covariance) = self.before;
        }
    }

    /// What was learnt since the last call of [`Self::settle`], and the application or roll that runs, are forgotten.
    pub(crate) fn abandon(&mut self) {
        (self.braking, self.rolling) = (Sums::default(), Sums::default());
        self.settle(false);
    }

    /// Whether all that was learnt is a number.
    pub(crate) fn is_sound(&self) -> bool {
        let (theta, covariance) = &self.before;
        self.excess.is_finite()
            && theta.iter().chain(covariance.iter().flatten()).all(|value| value.is_finite())
    }

    /// Takes another rail for its own past: the train as a whole creeps by so much less, or more.
    pub(crate) fn shift_friction(&mut self, by: f64) {
        self.before.0[1] += by;
        self.before.1[1][1] += by * by;
        (self.theta, self.covariance) = self.before;
    }

    /// Error of the radius: creepage at rest.
    pub(crate) const fn radius(&self) -> f64 {
        self.before.0[0]
    }

    /// Pad friction over nominal, times the error of the creep compliance.
    pub(crate) fn friction(&self) -> Change {
        Change { value: self.before.0[1], variance: self.before.1[1][1] + PAD_WANDER * PAD_WANDER }
    }

    /// What drive torque says of the mass in a balance: over that of the file, less one.
    pub(crate) fn mass(&self) -> Change {
        let per_mass = self.before.0[2].max(0.1);
        Change { value: 1.0 / per_mass - 1.0, variance: self.before.1[2][2] / per_mass.powi(4) }
    }
}

fn dot(a: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn quadratic(row: &[f64; TERMS], matrix: &[[f64; TERMS]; TERMS]) -> f64 {
    let product: [f64; TERMS] = std::array::from_fn(|i| dot(&matrix[i], row));
    dot(&product, row).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A second at 20 m/s: pads over nominal, brake creepage, and what holds the wheelset back besides.
    fn second(pads: f64, brake: f64, held: f64, turn: usize) -> Creep {
        // Errors of a fixed pattern without mean, of the size that is declared.
        let error = [1.0, -1.0, -1.0, 1.0][turn % 4] * 2e-5;
        let rate = if brake > 0.0 { -0.03 } else { 0.001 };
        Creep {
            creepage: 1.2e-3 - pads * brake - held - 0.01 * rate + error,
            brake,
            drive: 0.0,
            rate,
            variance: 4e-10,
        }
    }

    /// So many stops of half a minute, each after a minute and a half of rolling.
    fn day(wheel: &mut Creepage, stops: usize, pads: f64, held: f64) -> (Vec<Braked>, Vec<Change>) {
        let (mut braked, mut rolled) = (Vec::new(), Vec::new());
        for _ in 0..stops {
            for turn in 0..90 {
                wheel.take(&second(pads, 0.0, held, turn), 0.0);
                if let Some(Rolled { change, .. }) = wheel.end_of_roll(false) {
                    rolled.push(change);
                    wheel.settle(change.value.abs() < 4.0 * change.variance.sqrt());
                }
            }
            wheel.end_of_roll(true);
            for turn in 0..30 {
                // The order grows and lessens, as stops are made.
                let brake = 3e-4 + 3e-4 * (turn as f64 / 30.0);
                wheel.take(&second(pads, brake, held, turn), turn as f64);
            }
            if let Some(one) = wheel.end_of_braking() {
                braked.push(one);
                wheel.settle(one.level.value.abs() < 0.1 || one.level.variance > 0.05);
            }
        }
        (braked, rolled)
    }

    #[test]
    fn radius_and_pads_are_learnt_and_their_change_is_seen() {
        let mut wheel = Creepage::new(Belief::CREEPAGE);
        day(&mut wheel, 5, 0.95, 0.0);
        let friction = wheel.friction();
        assert!((friction.value - 0.95).abs() < 3.0 * friction.variance.sqrt(), "{friction:?}");
        let (braked, _) = day(&mut wheel, 3, 0.65, 0.0);
        for one in &braked {
            let sigmas = one.level.value / one.level.variance.sqrt();
            assert!((one.level.value + 0.3).abs() < 0.06 && sigmas < -4.0, "{one:?}");
        }
    }

    #[test]
    fn what_holds_a_rolling_wheelset_back_is_no_change_of_its_pads() {
        let mut wheel = Creepage::new(Belief::CREEPAGE);
        day(&mut wheel, 5, 1.0, 0.0);
        let (braked, rolled) = day(&mut wheel, 2, 1.0, 2e-4);
        assert!(rolled.iter().all(|change| (change.value + 2e-4).abs() < 5e-5), "{rolled:?}");
        assert!(braked.iter().all(|one| one.level.value > -0.05), "{braked:?}");
    }

    /// Acceleration is measured with noise, and only on one side of the balance: the mass does not drift towards nothing.
    #[test]
    fn the_mass_of_a_wagon_that_runs_alone_stays_what_it_is() {
        let mut balance = Creepage::new(Belief::balance(0.3));
        for turn in 0..4000_u32 {
            let drive = [0.08, 0.04, 0.0, 0.0][(turn / 30) as usize % 4];
            let brake = if turn % 120 >= 95 { 0.07 } else { 0.0 };
            let noise = 6e-3 * (f64::from(turn) * 2.399).sin();
            let accelerated = (drive - brake) / 1.2 + noise;
            balance
                .take(&Creep { creepage: accelerated, brake, drive, rate: accelerated, variance: 2e-5 }, 0.0);
        }
        balance.settle(true);
        let mass = balance.mass();
        assert!((mass.value - 0.2).abs() < 0.02, "{mass:?}");
    }

    /// A tachometer that lags reads less while the train gathers speed; that is not what holds its wheelset back.
    #[test]
    fn a_lag_is_no_drag() {
        let mut wheel = Creepage::new(Belief::CREEPAGE);
        let rolls = |wheel: &mut Creepage, lag_s: f64| {
            for turn in 0..40 {
                let rate = if turn % 20 < 10 { 0.02 } else { -0.002 };
                let creepage = 1e-3 - lag_s * rate;
                wheel.take(&Creep { creepage, brake: 0.0, drive: 0.0, rate, variance: 4e-10 }, 0.0);
            }
            let change = wheel.end_of_roll(false).expect("a roll").change;
            wheel.settle(true);
            change
        };
        for _ in 0..4 {
            rolls(&mut wheel, 0.0);
        }
        let change = rolls(&mut wheel, 0.1);
        assert!(change.value.abs() < 4.0 * change.variance.sqrt() && change.value.abs() < 1e-4, "{change:?}");
    }
}
