//! What lies between two configs of a running train, and whom it touches.

use railgrip_settings::TrainSettings;

use super::role::{Role, Who};
use super::table::{Differs, ROWS, Way};

/// A setting that has changed.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Change {
    key: String,
    wagon: Option<u32>,
    touches: &'static [(Who, Way)],
}

/// What has changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Plan {
    changes: Vec<Change>,
}

impl Plan {
    /// What leads from one config to another.
    pub(crate) fn of(old: &TrainSettings, new: &TrainSettings) -> Self {
        let mut changes = Vec::new();
        for row in ROWS {
            let mut add = |key: String, wagon: Option<u32>| {
                changes.push(Change { key, wagon, touches: row.touches });
            };
            match row.differs {
                Differs::Train(differs) if differs(old, new) => add(row.key.to_owned(), None),
                Differs::Train(_) => {}
                Differs::Wagon(differs) => {
                    let pairs = old.wagons.iter().zip(&new.wagons);
                    for (_, wagon) in pairs.filter(|(old, new)| differs(old, new)) {
                        add(format!("wagon.{}.{}", wagon.number, row.key), Some(wagon.number));
                    }
                }
                Differs::Microphone(differs) => {
                    for new in &new.microphones {
                        if old.microphone(new.wagon).is_some_and(|old| differs(old, new)) {
                            add(format!("{} of wagon {}", row.key, new.wagon), Some(new.wagon));
                        }
                    }
                }
            }
        }
        Self { changes }
    }

    /// Keys of what cannot change while the train runs.
    pub(crate) fn refused(&self) -> Vec<&str> {
        self.changes.iter().filter(|one| one.touches.is_empty()).map(|one| one.key.as_str()).collect()
    }

    /// Keys of all that has changed.
    pub(crate) fn keys(&self) -> Vec<&str> {
        self.changes.iter().map(|one| one.key.as_str()).collect()
    }

    /// How a process follows, if it is touched at all.
    pub(crate) fn way(&self, role: Role) -> Option<Way> {
        let of = |one: &Change| {
            one.touches.iter().filter(|(who, _)| who.is(role, one.wagon)).map(|(_, way)| *way).max()
        };
        self.changes.iter().filter_map(of).max()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use railgrip_settings::Overrides;

    use super::*;

    const TEXT: &str = "schema = 1\n[train]\nname = \"t\"\nvehicle = \"vehicle.toml\"\n[[wagon]]\n[[wagon]]\n\
                        [source]\nkind = \"simulate\"\nscenario = \"demo\"\nseed = 1\n[alerts]\nraise_after_s = 2.0\n";

    fn parse(text: &str) -> TrainSettings {
        let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/train.toml"));
        TrainSettings::parse(file, text, &Overrides::default()).expect("sound")
    }

    fn plan(from: &str, to: &str) -> Plan {
        assert!(TEXT.contains(from), "{from}");
        Plan::of(&parse(TEXT), &parse(&TEXT.replacen(from, to, 1)))
    }

    #[test]
    fn the_same_config_touches_nobody() {
        let plan = plan("seed = 1", "seed = 1");
        assert!(plan.keys().is_empty() && plan.refused().is_empty() && plan.way(Role::Health).is_none());
    }

    #[test]
    fn a_threshold_is_taken_over_and_a_filter_restarts_one_estimator() {
        let live = plan("raise_after_s = 2.0", "raise_after_s = 3.0");
        assert_eq!(live.keys(), ["alerts"]);
        assert_eq!((live.way(Role::Health), live.way(Role::Estimator(1))), (Some(Way::Live), None));
        let one = plan("[[wagon]]\n[source]", "[[wagon]]\nfilter = \"paper\"\n[source]");
        assert_eq!(one.keys(), ["wagon.2.filter"]);
        let ways = [Role::Estimator(1), Role::Estimator(2), Role::Health, Role::Ingest].map(|r| one.way(r));
        assert_eq!(ways, [None, Some(Way::Restart), None, None]);
    }

    #[test]
    fn whoever_must_start_again_does_not_take_over_as_well() {
        let both = plan(
            "raise_after_s = 2.0",
            "raise_after_s = 3.0\njournal = \"other.db\"\n[history]\nflush_s = 5.0",
        );
        assert_eq!(both.way(Role::Health), Some(Way::Restart));
        assert_eq!(both.way(Role::Ingest), None);
        let level = plan("[alerts]", "[logging]\nlevel = \"debug\"\n[alerts]");
        assert_eq!((level.way(Role::Holder), level.way(Role::Judge)), (Some(Way::Live), Some(Way::Live)));
    }

    #[test]
    fn what_channels_and_processes_are_made_by_is_refused() {
        for (from, to, key) in [
            ("name = \"t\"", "name = \"other\"", "train.name"),
            ("[[wagon]]\n[source]", "[[wagon]]\n[[wagon]]\n[source]", "train.wagons"),
            ("[alerts]", "[instance]\nprefix = \"rgx_\"\n[alerts]", "instance.prefix"),
            ("kind = \"simulate\"\nscenario = \"demo\"\nseed = 1", "kind = \"external\"", "source.kind"),
            ("[alerts]", "[diagnosis]\nautomatic = false\n[alerts]", "diagnosis.automatic"),
        ] {
            let plan = plan(from, to);
            assert!(plan.refused().contains(&key), "{key}: {plan:?}");
        }
    }
}
