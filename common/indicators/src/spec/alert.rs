//! When an indicator raises an alert.
//!
//! # Glossary
//! *Rule*, *group*, *inhibition* as Alertmanager uses them: a rule raises an alert from an indicator; indicators with one
//! *cause* are grouped into one alert; an alert is inhibited while another one that explains it asks for action.

use super::reach::Reach;

/// When an indicator raises an alert, with what it is grouped, and what to do. What the judges of a wagon among its
/// neighbours and of the train say always raises one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlertRule {
    /// Id of the indicator that stands for the cause; alerts are grouped by it. Inhibition, reach and advice of that entry
    /// hold for the group.
    pub cause: &'static str,
    /// Which of the figures judged on the wagon raise it.
    pub raised_by: Reach,
    /// How many times longer than others it must last before it counts, at watch and at act.
    pub patience: [f64; 2],
    /// The cause never lies in one wagon: there is one alert for the train.
    pub of_train: bool,
    /// Causes that explain it: while one of them asks for action on the same wagon, this one is inhibited.
    pub inhibited_by: &'static [&'static str],
    /// It judges a wagon by its own motion, so that it holds only where none is coupled to it. The wagons of a coupled train
    /// are judged together instead, by their causes.
    pub of_free_wagon: bool,
    /// A recording of the latest minutes explains it.
    pub recorded: bool,
    /// What to do.
    pub advice: Advice,
    /// Names under which older versions kept its symptoms.
    pub formerly: &'static [&'static str],
}

impl AlertRule {
    /// A rule for one wagon that nothing inhibits.
    #[must_use]
    pub const fn of(cause: &'static str, raised_by: Reach, advice: Advice) -> Self {
        Self {
            cause,
            raised_by,
            patience: [1.0, 1.0],
            of_train: false,
            inhibited_by: &[],
            of_free_wagon: false,
            recorded: false,
            advice,
            formerly: &[],
        }
    }
}

/// What to do about a cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Advice {
    /// Where one wagon shows it.
    pub wagon: &'static str,
    /// Where most of the train shows it.
    pub train: &'static str,
}

impl Advice {
    /// Where nothing better is known.
    pub const LOOK: Self = Self { wagon: "Inspect this wagon.", train: "Inspect these wagons." };

    /// The same wherever it shows.
    #[must_use]
    pub const fn same(text: &'static str) -> Self {
        Self { wagon: text, train: text }
    }
}
