//! Alert rules: which there are, how long each must be broken, which cause it points to, what inhibits that, and what to do.

use super::model::Scope;
use crate::api::grade::Grade;
use railgrip_indicators::{Advice, AlertRule, Reach, Table};

/// A rule of the service itself, for what is no indicator: symptom and rule.
type OwnRule = (&'static str, AlertRule);

/// Rules of the service itself.
const OWN: [OwnRule; 3] = [
    ("silent", of_train("silent", "Check the data connection and the processes of these wagons.")),
    // A disk that is full or read-only takes neither indicators nor alerts.
    ("storage", of_train("storage", STORAGE)),
    ("history", of_train("storage", STORAGE)),
];

const STORAGE: &str = "Free space on the disk, make it writable or replace it; live figures go on, what is remembered has a gap.";

const fn of_train(cause: &'static str, advice: &'static str) -> AlertRule {
    AlertRule { of_train: true, ..AlertRule::of(cause, Reach::Nowhere, Advice::same(advice)) }
}

/// All rules: those of the table of indicators, and those of the service itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules(pub Table);

impl Rules {
    fn of(self, rule: &str) -> Option<AlertRule> {
        let own = || OWN.iter().find(|(name, _)| *name == rule).map(|(_, rule)| *rule);
        self.0.find(rule).and_then(|spec| spec.alert).or_else(own)
    }

    /// The name of today of a rule that a journal holds; `None` if there is no such rule any more.
    pub fn known(self, name: &str) -> Option<&'static str> {
        let is = |alert: AlertRule, id: &str| id == name || alert.formerly.contains(&name);
        let of_table = self.0.iter().find(|spec| spec.alert.is_some_and(|alert| is(alert, spec.id)));
        let own = || OWN.iter().find(|(id, _)| *id == name).map(|(id, _)| *id);
        of_table.map(|spec| spec.id).or_else(own)
    }

    /// The cause that a rule points to: its symptoms make one alert.
    pub fn cause_of(self, rule: &'static str) -> &'static str {
        self.of(rule).map_or(rule, |rule| rule.cause)
    }

    /// How much longer than others a rule must be broken until its symptom fires.
    pub fn patience(self, rule: &str, grade: Grade) -> f64 {
        let [watch, act] = self.of(rule).map_or([1.0; 2], |rule| rule.patience);
        if grade == Grade::Watch { watch } else { act }
    }

    /// True for causes that lie in the rail, the train, the data path or this service, never in one wagon.
    pub fn is_of_the_train(self, cause: &str) -> bool {
        self.of(cause).is_some_and(|rule| rule.of_train)
    }

    /// Causes that explain this one: while one of them needs action on the same wagon, this one is inhibited.
    pub fn inhibited_by(self, cause: &str) -> &'static [&'static str] {
        self.of(cause).map_or(&[], |rule| rule.inhibited_by)
    }

    /// True if a recording of the latest minutes explains the cause.
    pub fn is_recorded(self, cause: &str) -> bool {
        self.of(cause).is_some_and(|rule| rule.recorded)
    }

    /// What to do about a cause.
    pub fn advice(self, cause: &str, scope: Scope) -> &'static str {
        let advice = self.of(cause).map_or(Advice::LOOK, |rule| rule.advice);
        if scope == Scope::Train { advice.train } else { advice.wagon }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_indicators::INDICATORS;

    #[test]
    fn journals_of_older_versions_are_understood() {
        let rules = Rules(INDICATORS);
        let known = [
            ("late", "brake_delay"),
            ("no_pressure", "isolated"),
            ("silent", "silent"),
            ("filter", "filter"),
        ];
        for (then, now) in known {
            assert_eq!(rules.known(then), Some(now));
        }
        assert_eq!(rules.known("nothing of the kind"), None);
    }

    #[test]
    fn what_shares_a_cause_is_grouped_and_what_explains_it_inhibits() {
        let rules = Rules(INDICATORS);
        for (rule, cause) in [
            ("asymmetry", "brake_friction"),
            ("brake_delay", "response"),
            ("model", "filter"),
            ("history", "storage"),
            ("stopping_distance", "stopping_distance"),
        ] {
            assert_eq!(rules.cause_of(rule), cause);
        }
        assert_eq!(rules.inhibited_by("response"), ["isolated"]);
        assert_eq!(rules.inhibited_by("filter"), ["sensors"]);
        assert!(rules.is_of_the_train("rail") && rules.is_of_the_train("stopping_distance"));
        assert!(!rules.is_of_the_train("dragging") && rules.is_recorded("filter"));
        assert_eq!(rules.patience("filter", Grade::Watch), 60.0);
        assert_eq!(rules.patience("sensors", Grade::Act), 1.0);
    }
}
