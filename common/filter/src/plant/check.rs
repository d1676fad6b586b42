//! Checks of the values of a rig's file.

use railgrip_vehicle::Contact;

/// A value of a rig's file that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` is {value}, allowed is {allowed}")]
pub struct PlantError {
    /// Dotted key.
    pub key: &'static str,
    /// What stands there.
    pub value: String,
    /// What may stand there.
    pub allowed: &'static str,
}

/// One check: key, value, range, range in words.
pub(super) type Check = (&'static str, f64, f64, f64, &'static str);

pub(super) fn refuse_first(checks: &[Check]) -> Result<(), PlantError> {
    match checks.iter().find(|(_, value, low, high, _)| !(low..=high).contains(&value)) {
        Some((key, value, _, _, allowed)) => Err(PlantError { key, value: value.to_string(), allowed }),
        None => Ok(()),
    }
}

pub(super) fn check_head(schema: u32, kind: &str, expected: &'static str) -> Result<(), PlantError> {
    if schema != 1 {
        return Err(PlantError { key: "schema", value: schema.to_string(), allowed: "1" });
    }
    if kind != expected {
        return Err(PlantError {
            key: "kind",
            value: format!("{kind:?}"),
            allowed: "\"roller\", \"traction\" or \"bogie\"",
        });
    }
    Ok(())
}

/// Keys of the table `contact`.
pub(super) const CONTACT_KEYS: [&str; 5] = [
    "contact.stiffness_n",
    "contact.k_a",
    "contact.k_s",
    "contact.friction_ratio",
    "contact.friction_decay_s_per_m",
];

pub(super) fn contact_checks(contact: &Contact, keys: [&'static str; 5]) -> [Check; 5] {
    let [stiffness, k_a, k_s, ratio, decay] = keys;
    [
        (stiffness, contact.stiffness_n, 1e3, 1e9, "1e3 to 1e9"),
        (k_a, contact.k_a, 1e-3, 1.0, "0.001 to 1"),
        (k_s, contact.k_s, 1e-3, 1.0, "0.001 to 1"),
        (ratio, contact.friction_ratio, 0.05, 1.0, "0.05 to 1"),
        (decay, contact.friction_decay_s_per_m, 0.0, 10.0, "0 to 10"),
    ]
}
