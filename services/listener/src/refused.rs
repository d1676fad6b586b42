//! What a listener did not take, by payload and reason.

use railgrip_messages::Refusal;
use std::collections::BTreeMap;

/// Counts of what was refused.
#[derive(Debug, Default)]
pub(crate) struct Refused(BTreeMap<(&'static str, Refusal), u64>);

impl Refused {
    /// Whether a payload passed its check; one that did not is counted, and told ever more rarely.
    pub fn passes(&mut self, payload: &'static str, checked: Result<(), Refusal>) -> bool {
        let Err(why) = checked else { return true };
        let count = self.0.entry((payload, why)).or_insert(0);
        *count += 1;
        if count.is_power_of_two() {
            tracing::warn!(payload, why = why.word(), count = *count, "a payload is refused");
        }
        false
    }

    /// All that was refused.
    pub fn count(&self) -> u64 {
        self.0.values().sum()
    }
}
