//! The paper's decision-maker (section 3.3) and its optimum slip reference (section 3.4).
//!
//! A classifier of rolling noise says how probably the rail is dry, once a window. Above one half it is dry, below it is
//! wet, at exactly one half the last condition stays. The adhesion that the Polach curve of the heard condition has at
//! the present slip and speed is compared with the measured one; if they differ by more than 0.2, the condition and
//! adhesion of the step before stay. The slip at which the curve of the condition peaks is the optimum.

use railgrip_vehicle::bogie_rig::{ContactLaw, RailCondition};

/// Difference between heard curve and measured adhesion above which both stay what they were.
pub const RULE_DIFFERENCE: f64 = 0.2;

/// Largest slip in which the optimum is searched.
const SEARCH_TO: f64 = 0.5;

/// Someone who listens to the rail: an acoustic classifier, or what stands for one.
pub trait RailListener {
    /// Probability that the rail was dry in the window that ends at `time_s`; nothing while no new window is over, or
    /// when nothing could be heard (silent, clipped).
    fn dry_probability(&mut self, time_s: f64) -> Option<f64>;
}

/// The condition heard, with the paper's hysteresis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeardCondition {
    /// As it stands.
    pub condition: RailCondition,
}

impl HeardCondition {
    /// Takes in a probability of "dry"; one that is no number changes nothing.
    pub fn hear(&mut self, dry_probability: f64) -> RailCondition {
        if dry_probability > 0.5 {
            self.condition = RailCondition::Dry;
        } else if dry_probability < 0.5 {
            self.condition = RailCondition::Wet;
        }
        self.condition
    }
}

/// Where a curve peaks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OptimumSlip {
    /// Slip λ.
    pub slip: f64,
    /// Adhesion there.
    pub adhesion: f64,
}

/// The peak of a law at a speed, by golden-section search: the curve has one.
pub fn optimum_slip(law: &ContactLaw, v_m_s: f64, wheelset_load_n: f64) -> OptimumSlip {
    let adhesion = |slip: f64| law.adhesion(slip, v_m_s, wheelset_load_n);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, SEARCH_TO);
    let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_left, mut at_right) = (adhesion(left), adhesion(right));
    while high - low > 1e-5 {
        if at_left < at_right {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = adhesion(right);
        } else {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = adhesion(left);
        }
    }
    let slip = 0.5 * (low + high);
    OptimumSlip { slip, adhesion: adhesion(slip) }
}

/// What the decision-maker concluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Condition to go by.
    pub condition: RailCondition,
    /// Adhesion to go by.
    pub adhesion: f64,
    /// Adhesion that the heard condition's curve has here.
    pub expected: f64,
    /// True if curve and measurement differed by more than the rule allows, so that the last decision stands.
    pub kept: bool,
    /// Where the curve of the condition peaks at this speed.
    pub optimum: OptimumSlip,
}

/// The decision-maker.
#[derive(Clone, Debug, PartialEq)]
pub struct DecisionMaker {
    dry: ContactLaw,
    wet: ContactLaw,
    wheelset_load_n: f64,
    heard: HeardCondition,
    decided: RailCondition,
    adhesion: f64,
}

impl DecisionMaker {
    /// A decision-maker that begins with a condition and the laws that it knows for both.
    pub fn new(dry: ContactLaw, wet: ContactLaw, wheelset_load_n: f64, begin: RailCondition) -> Self {
        let heard = HeardCondition { condition: begin };
        Self { dry, wet, wheelset_load_n, heard, decided: begin, adhesion: 0.0 }
    }

    /// The law that it knows for a condition.
    pub fn law(&self, condition: RailCondition) -> &ContactLaw {
        match condition {
            RailCondition::Dry => &self.dry,
            RailCondition::Wet => &self.wet,
        }
    }

    /// The condition heard last.
    pub fn heard(&self) -> RailCondition {
        self.heard.condition
    }

    /// Decides from the slip λ, the rollers' speed, the measured adhesion (positive in braking) and what was heard since.
    /// Without slip or adhesion the heard condition alone decides.
    pub fn decide(
        &mut self,
        slip: Option<f64>,
        v_m_s: f64,
        adhesion: Option<f64>,
        dry_probability: Option<f64>,
    ) -> Decision {
        if let Some(probability) = dry_probability {
            self.heard.hear(probability);
        }
        let condition = self.heard.condition;
        let expected =
            slip.map_or(f64::NAN, |slip| self.law(condition).adhesion(slip, v_m_s, self.wheelset_load_n));
        let difference = adhesion.map_or(f64::NAN, |adhesion| (expected - adhesion).abs());
        let kept = difference > RULE_DIFFERENCE;
        if !kept {
            self.decided = condition;
            self.adhesion = adhesion.unwrap_or(self.adhesion);
        }
        let optimum = optimum_slip(self.law(self.decided), v_m_s, self.wheelset_load_n);
        Decision { condition: self.decided, adhesion: self.adhesion, expected, kept, optimum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOAD_N: f64 = 4060.0;

    fn maker() -> DecisionMaker {
        let [dry, wet] = RailCondition::ALL.map(ContactLaw::of);
        DecisionMaker::new(dry, wet, LOAD_N, RailCondition::Dry)
    }

    #[test]
    fn exactly_one_half_keeps_the_last_condition() {
        use RailCondition::{Dry, Wet};
        let mut heard = HeardCondition { condition: Dry };
        let said = [0.5, 0.49, 0.5, 0.51, f64::NAN, 0.5].map(|p| heard.hear(p));
        assert_eq!(said, [Dry, Wet, Wet, Dry, Dry, Dry]);
    }

    #[test]
    fn a_difference_above_the_rule_keeps_the_decision() {
        let mut maker = maker();
        let first = maker.decide(Some(0.06), 1.388, Some(0.40), Some(0.9));
        assert!(!first.kept && first.condition == RailCondition::Dry);
        // "Wet" is heard, but 0.40 at this slip is 0.22 above the wet curve.
        let second = maker.decide(Some(0.06), 1.388, Some(0.40), Some(0.1));
        println!("wet curve has {:.3} here, measured 0.40", second.expected);
        assert!(second.kept && second.condition == RailCondition::Dry && second.adhesion == 0.40);
        // The slip has gone up and the adhesion down: now the wet curve fits.
        let third = maker.decide(Some(0.2), 1.388, Some(0.21), None);
        assert!(!third.kept && third.condition == RailCondition::Wet && third.adhesion == 0.21);
        // Nothing measured: what is heard decides, the adhesion stays.
        let fourth = maker.decide(None, 1.388, None, Some(0.8));
        assert!(fourth.condition == RailCondition::Dry && fourth.adhesion == 0.21);
    }

    #[test]
    fn optimum_is_the_peak_of_the_curve() {
        for condition in RailCondition::ALL {
            let law = ContactLaw::of(condition);
            for v in [0.1, 0.69, 1.388, 4.14] {
                let found = optimum_slip(&law, v, LOAD_N);
                let best =
                    (1..5000).map(|k| law.adhesion(f64::from(k) * 1e-4, v, LOAD_N)).fold(0.0, f64::max);
                println!("{} {v} m/s: {:.4} at {:.4}", condition.name(), found.adhesion, found.slip);
                assert!((found.adhesion - best).abs() < 1e-5);
            }
        }
    }
}
