//! The decision-maker of Shrestha et al. on live data: heard condition, measured slip and adhesion, optimum slip.
//!
//! It advises people. Nothing in railgrip drives a brake.

use railgrip_filter::Plant;
use railgrip_filter::models::bogie_rig::{Decision, DecisionMaker};
use railgrip_messages::{Condition, Estimate, Heard};
use railgrip_vehicle::bogie_rig::{ContactLaw, RailCondition};

/// Speed below which slip means nothing, m/s.
const LEAST_SPEED_M_S: f64 = 0.15;
/// Estimates older than this are not used, s.
const STALE_S: f64 = 2.0;

/// A decision-maker with the last estimate of its wagon.
pub(crate) struct Adviser {
    maker: DecisionMaker,
    wheelsets: usize,
    last: Option<Estimate>,
}

impl Adviser {
    /// With the curves of the plant's file: those of a bogie rig, else its contact law at the adhesion of dry and of wet
    /// rail.
    pub fn of(plant: &Plant) -> Self {
        let vehicle = plant.as_vehicle();
        let law = |friction_at_rest| ContactLaw { contact: vehicle.contact.clone(), friction_at_rest };
        let [dry, wet] = match plant {
            Plant::Bogie(rig) => RailCondition::ALL.map(|condition| rig.law(condition)),
            _ => [law(vehicle.rail.dry), law(vehicle.rail.wet)],
        };
        let maker = DecisionMaker::new(dry, wet, plant.load_n(), RailCondition::Dry);
        Self { maker, wheelsets: plant.wheelsets(), last: None }
    }

    /// Takes note of an estimate.
    pub fn take(&mut self, estimate: &Estimate) {
        self.last = Some(*estimate);
    }

    /// Decides with what was heard in this window and writes it down.
    pub fn advise(&mut self, now_ns: u64, heard: &mut Heard) {
        let Some(estimate) = self.last.filter(|estimate| estimate.acquired.age_s(now_ns) < STALE_S) else {
            return;
        };
        if estimate.v_m_s.is_nan() || estimate.v_m_s < LEAST_SPEED_M_S {
            return;
        }
        // The paper's slip of the wheelset that slips most; positive in braking.
        let slips = estimate.slip.iter().take(self.wheelsets);
        let slip = slips.copied().fold(None, |worst: Option<f64>, slip| match worst {
            _ if !slip.is_finite() => worst,
            Some(worst) => Some(worst.max(-slip)),
            None => Some(-slip),
        });
        let adhesion = Some(estimate.mu_w.abs()).filter(|adhesion| adhesion.is_finite());
        let dry = heard.wet().map(|wet| 1.0 - wet);
        let decision = self.maker.decide(slip.map(|slip| slip.max(0.0)), estimate.v_m_s, adhesion, dry);
        write(&decision, heard);
    }
}

fn write(decision: &Decision, heard: &mut Heard) {
    heard.decided = 1;
    heard.decided_condition = match decision.condition {
        RailCondition::Dry => Condition::Dry.code(),
        RailCondition::Wet => Condition::Wet.code(),
    };
    heard.kept = u32::from(decision.kept);
    heard.decided_adhesion = decision.adhesion;
    heard.optimum_slip = decision.optimum.slip;
    heard.optimum_adhesion = decision.optimum.adhesion;
}
