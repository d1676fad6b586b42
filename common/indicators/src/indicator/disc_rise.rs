//! Disc temperature: worked out from braking power, never measured.

use super::judging::{known, unknown};
use crate::spec::{Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Unit};
use railgrip_messages::{Grade, Indicator};

/// 1 σ of heat capacity and cooling together, as a share of the rise: both are set by hand.
const MODEL_SHARE: f64 = 0.2;
/// 1 σ that is left of discs that are cold, K: sun, and what was braked before the start.
const FLOOR_K: f64 = 5.0;

/// How much warmer the discs of a wheelset are than the surroundings.
pub static DISC_RISE: IndicatorSpec = IndicatorSpec {
    id: "disc_rise",
    unit: Unit::Kelvins,
    form: Form::KELVINS,
    judge: Judge {
        wheelset: Some(|seen, index| match seen.state.braking_s {
            0.0 => unknown("no braking yet"),
            _ => judge(seen.state.wheelset[index].standard.rise_k),
        }),
        ..Judge::NONE
    },
    limit: Some(|_, _| Limit::free(0.0, 400.0)),
    metric: Some(Metric {
        reach: Reach::Wheelsets,
        ..Metric::gauge("brake_disc_rise_kelvin", "Brake discs above the surroundings, worked out")
    }),
    meaning: Meaning {
        name: "Disc above ambient",
        block: "manipulation",
        definition: "How much warmer the brake discs of a wheelset are than the surroundings. Worked out as a lumped body: braking power heats it, and it cools with a time constant; nothing measures it.",
        unit: "K",
        interval: "95 %: heat capacity and cooling are set by hand, to about 20 %",
        cannot_see: "A hot spot, the pads themselves, the weather, and what was braked before the start.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// The rise with its interval; nothing is judged by it.
fn judge(rise_k: f64) -> Indicator {
    if !rise_k.is_finite() {
        return unknown("no estimate yet");
    }
    let half_k = 1.96 * (MODEL_SHARE * rise_k).hypot(FLOOR_K);
    let (low_k, high_k) = ((rise_k - half_k).max(0.0), rise_k + half_k);
    let reason = format!("about {rise_k:.0} K above the surroundings, {low_k:.0} to {high_k:.0} K");
    known(rise_k, low_k, high_k, Grade::Ok, &reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::standard::WheelsetStandard;
    use crate::settings::StandardSettings;

    /// Against the closed solution of `C dT/dt = P − C T/τ` at constant power, and of cooling after it.
    #[test]
    fn a_disc_heats_and_cools_by_the_closed_solution() {
        let settings = StandardSettings::default();
        let (heat_j_per_k, cooling_s) = (settings.disc_heat_j_per_k, settings.disc_cooling_s);
        let (power_w, braking_s, rest_s) = (150e3, 60.0, 300.0);
        let mut disc = WheelsetStandard::default();
        let steps = |seconds: f64| 0..(seconds / 0.01) as usize;
        steps(braking_s).for_each(|_| disc.heat(0.01, power_w, &settings));
        let hot_k = power_w * cooling_s / heat_j_per_k * (1.0 - (-braking_s / cooling_s).exp());
        assert!((disc.rise_k / hot_k - 1.0).abs() < 1e-3, "{} against {hot_k}", disc.rise_k);
        steps(rest_s).for_each(|_| disc.heat(0.01, 0.0, &settings));
        let cooler_k = hot_k * (-rest_s / cooling_s).exp();
        assert!((disc.rise_k / cooler_k - 1.0).abs() < 1e-3, "{} against {cooler_k}", disc.rise_k);
        let told = judge(hot_k);
        assert!(told.low < 0.7 * hot_k && told.high > 1.3 * hot_k && told.grade() == Grade::Ok);
        assert_eq!(judge(0.0).low, 0.0);
        assert_eq!(judge(f64::NAN).known, 0);
    }
}
