//! Inhibition: what a worse symptom of the same wagon explains raises no alert of its own.

/// Rules whose symptoms, where they need action, explain others.
pub(super) const SOURCES: [&str; 2] = ["isolated", "sensors"];

/// True if the cause `target` on a wagon follows from the cause `source` on the same wagon, which needs action.
pub(super) fn inhibits(source: &str, target: &str) -> bool {
    match source {
        "isolated" => matches!(target, "brake_friction" | "response"),
        "sensors" => matches!(target, "filter" | "brake_friction" | "slides" | "wsp_share" | "dragging"),
        _ => false,
    }
}
