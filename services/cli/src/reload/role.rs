//! The processes of a train, as a supervisor names them.

use std::fmt;

use railgrip_messages::{NO_WAGON, ProcessKind};

/// One process of a train.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    Holder,
    Health,
    /// Of a wagon.
    Estimator(u32),
    Judge,
    /// At the microphone of a wagon.
    Listener(u32),
    Diagnoser,
    Ingest,
}

impl Role {
    /// As the channels know it; `None` for one that is not on them, or that is not one of its kind.
    pub(super) const fn process(self) -> Option<(ProcessKind, u32)> {
        match self {
            Self::Health => Some((ProcessKind::Health, NO_WAGON)),
            Self::Estimator(wagon) => Some((ProcessKind::Estimator, wagon)),
            Self::Judge => Some((ProcessKind::Judge, NO_WAGON)),
            Self::Listener(wagon) => Some((ProcessKind::Listener, wagon)),
            Self::Ingest => Some((ProcessKind::Ingest, NO_WAGON)),
            Self::Holder | Self::Diagnoser => None,
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Holder => f.pad("holder"),
            Self::Health => f.pad("health"),
            Self::Estimator(wagon) => write!(f, "estimator {wagon}"),
            Self::Judge => f.pad("judge"),
            Self::Listener(wagon) => write!(f, "listener {wagon}"),
            Self::Diagnoser => f.pad("diagnoser"),
            Self::Ingest => f.pad("ingest"),
        }
    }
}

/// Whom a setting touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Who {
    All,
    Health,
    /// Those of the wagon, where the setting is of one.
    Estimators,
    Judge,
    /// As above.
    Listeners,
    Diagnoser,
    Ingest,
}

impl Who {
    /// In words.
    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::All => "all processes",
            Self::Health => "health",
            Self::Estimators => "the estimators it is about",
            Self::Judge => "judge",
            Self::Listeners => "the listeners it is about",
            Self::Diagnoser => "diagnoser",
            Self::Ingest => "ingest",
        }
    }

    /// True if `role` is among them; `wagon` is that of the setting.
    pub(super) fn is(self, role: Role, wagon: Option<u32>) -> bool {
        match (self, role) {
            (Self::All, _)
            | (Self::Health, Role::Health)
            | (Self::Judge, Role::Judge)
            | (Self::Diagnoser, Role::Diagnoser)
            | (Self::Ingest, Role::Ingest) => true,
            (Self::Estimators, Role::Estimator(own)) | (Self::Listeners, Role::Listener(own)) => {
                wagon.is_none_or(|wagon| wagon == own)
            }
            _ => false,
        }
    }
}
