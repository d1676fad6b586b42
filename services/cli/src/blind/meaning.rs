//! Which parameters mean the same in the plant and in the library.

use railgrip_diagnosis::decide::learning::TrueValue;
use railgrip_truth_plant::label::LabelledEffect;

/// A parameter that means the same in the plant and in the catalogue, if the edges of its law do not: effect, the plant's
/// name, the catalogue's, and what the plant's value is multiplied with and added to.
struct Meaning(&'static str, &'static str, &'static str, f64, f64);

const AGREEING: [Meaning; 11] = [
    Meaning("wheel_radius", "relative", "relative_error", 1.0, 0.0),
    Meaning("mass_error", "relative", "relative_error", 1.0, 0.0),
    Meaning("rotating_inertia", "relative", "relative_error", 1.0, 0.0),
    Meaning("load_transfer", "factor", "relative_error", 1.0, -1.0),
    Meaning("dragging_brake", "torque_nm", "torque_nm", 1.0, 0.0),
    Meaning("wheel_encoder_window", "window_s", "window_s", 1.0, 0.0),
    // Edges softer or harder than the catalogue's, delay part transport and part smoothing, wind that breathes.
    Meaning("pressing_force_offset", "threshold_n", "threshold_n", 1.0, 0.0),
    Meaning("low_adhesion_patch", "loss", "loss", 1.0, 0.0),
    Meaning("grade", "slope_rad", "error_permil", 1e3, 0.0),
    Meaning("speed_latency", "latency_s", "latency_s", 1.0, 0.0),
    Meaning("headwind", "mean_m_s", "headwind_m_s", 1.0, 0.0),
];

/// The true value of what means the same of an effect.
pub(super) fn true_value(truth: &LabelledEffect) -> Option<TrueValue> {
    let Meaning(effect, plants, parameter, factor, offset) = AGREEING.iter().find(|m| m.0 == truth.id)?;
    let (_, value) = truth.parameters.iter().find(|(name, _)| name == plants)?;
    Some(TrueValue { effect: (*effect).to_owned(), parameter, value: factor * value + offset })
}
