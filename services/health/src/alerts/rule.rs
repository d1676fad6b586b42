//! Alert rules: which there are, how long each must be broken, which cause it points to, what inhibits that, and what to do.

use super::model::Scope;
use crate::api::grade::Grade;
use railgrip_causes::Cause;
use railgrip_indicators::{Advice, AlertRule, Reach, Table};

/// A rule of the service itself, for what is no indicator: symptom and rule.
type OwnRule = (&'static str, AlertRule);

/// Rules of the service itself.
const OWN: [OwnRule; 6] = [
    ("silent", of_train("silent", "Check the data connection and the processes of these wagons.")),
    ("units", of_train("units", UNITS)),
    ("source_clock", of_train("source_clock", SOURCE_CLOCK)),
    // A disk that is full or read-only takes neither indicators nor alerts.
    ("storage", of_train("storage", STORAGE)),
    ("history", of_train("storage", STORAGE)),
    ("judge", of_train("judge", "Check the process `judge` in the list of processes and its log.")),
];
/// On a train whose wagons are judged together, rules of single wagons must be broken so many times longer until they count:
/// the judge shall have its say first, so that one fault does not raise two alerts.
const AFTER_THE_JUDGE: f64 = 45.0;

const UNITS: &str =
    "Say in [mapping] which units the source sends; until then the samples of these wagons are withheld.";
const SOURCE_CLOCK: &str =
    "Set the clock of the device that stamps these samples, or have it follow the train's time.";
const STORAGE: &str = "Free space on the disk, make it writable or replace it; live figures go on, what is remembered has a gap.";

const fn of_train(cause: &'static str, advice: &'static str) -> AlertRule {
    AlertRule { of_train: true, ..AlertRule::of(cause, Reach::Nowhere, Advice::same(advice)) }
}

/// All rules: those of the table of indicators, those of the service itself, and on a train whose wagons are judged together
/// one a cause; there a rule of the table that has the name of a cause stands for that cause.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules {
    /// The indicators.
    pub table: Table,
    /// The wagons are judged together.
    pub together: bool,
}

impl Rules {
    fn of(self, rule: &str) -> Option<AlertRule> {
        let own = || OWN.iter().find(|(name, _)| *name == rule).map(|(_, rule)| *rule);
        let judged = self.judged(rule).map(|cause| AlertRule {
            of_train: cause == Cause::LowAdhesion,
            ..AlertRule::of(cause.word(), Reach::Nowhere, Advice::same(cause.advice()))
        });
        judged.or_else(|| self.table.find(rule).and_then(|spec| spec.alert)).or_else(own)
    }

    /// The cause of that name, where causes are judged.
    pub fn judged(self, rule: &str) -> Option<Cause> {
        // That nothing comes from a wagon the service sees itself, and sooner.
        Cause::from_word(rule).filter(|cause| self.together && *cause != Cause::Silent)
    }

    /// The name of today of a rule that a journal holds; `None` if there is no such rule any more.
    pub fn known(self, name: &str) -> Option<&'static str> {
        if let Some(cause) = self.judged(name) {
            return Some(cause.word());
        }
        let is = |alert: AlertRule, id: &str| id == name || alert.formerly.contains(&name);
        let of_table = self.table.iter().find(|spec| spec.alert.is_some_and(|alert| is(alert, spec.id)));
        let own = || OWN.iter().find(|(id, _)| *id == name).map(|(id, _)| *id);
        of_table.map(|spec| spec.id).or_else(own)
    }

    /// Whether a cause that is judged on some wagons explains symptoms of single wagons there.
    pub fn is_explained_by_the_judge(self, cause: &str) -> bool {
        let of_table = || self.table.find(cause).and_then(|spec| spec.alert);
        self.together && self.judged(cause).is_none() && of_table().is_some_and(|alert| !alert.of_train)
    }

    /// The cause that a rule points to: its symptoms make one alert.
    pub fn cause_of(self, rule: &'static str) -> &'static str {
        self.of(rule).map_or(rule, |rule| rule.cause)
    }

    /// How much longer than others a rule must be broken until its symptom fires.
    pub fn patience(self, rule: &str, grade: Grade) -> f64 {
        if self.judged(rule).is_some() {
            return 0.0;
        }
        let [watch, act] = self.of(rule).map_or([1.0; 2], |rule| rule.patience);
        let own = if grade == Grade::Watch { watch } else { act };
        if self.is_explained_by_the_judge(rule) { own.max(AFTER_THE_JUDGE) } else { own }
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
        let rules = Rules { table: INDICATORS, together: false };
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
    fn a_train_that_is_judged_together_has_rules_by_cause() {
        let rules = Rules { table: INDICATORS, together: true };
        assert_eq!(rules.known("pad_uneven"), Some("pad_uneven"));
        assert_eq!(rules.cause_of("dragging"), "dragging");
        assert_eq!(rules.advice("dragging", Scope::Wagon), Cause::Dragging.advice());
        assert!(rules.is_of_the_train("low_adhesion") && !rules.is_of_the_train("isolated"));
        assert!(rules.is_explained_by_the_judge("sensors") && !rules.is_explained_by_the_judge("storage"));
        assert_eq!(rules.patience("pad_low", Grade::Watch), 0.0);
        assert!(rules.patience("sensors", Grade::Act) > 30.0);
        assert_eq!(rules.judged("silent"), None, "the age of data shows that sooner");
    }

    #[test]
    fn what_shares_a_cause_is_grouped_and_what_explains_it_inhibits() {
        let rules = Rules { table: INDICATORS, together: false };
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
