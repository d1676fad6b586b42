//! What an estimate is worth, in one word. Bad input has a name of its own: where it stands, the figures say nothing.

use serde::Serialize;

/// Declares the states with their codes and words.
macro_rules! states {
    ($($(#[$meta:meta])* $name:ident = $code:literal, $word:literal;)+) => {
        /// What an estimate is worth.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
        #[serde(rename_all = "snake_case")]
        #[repr(u32)]
        pub enum EstimateState { $($(#[$meta])* $name = $code,)+ }

        impl EstimateState {
            /// Every state, in the order of the codes.
            pub const ALL: &'static [Self] = &[$(Self::$name,)+];

            /// The word for files and people.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$name => $word,)+ }
            }
        }
    };
}

states! {
    /// The filter has just begun.
    #[default]
    Starting = 0, "starting";
    /// The data determine what is estimated: μ0 of a driven rig, the pad friction of every wheelset of a wagon.
    Observable = 1, "observable";
    /// The data say something about it, but its sigma is a large part of it; on a wagon: of some wheelsets only.
    Weak = 2, "weak";
    /// Nothing in the data speaks about it: it is held, or the prior's.
    Unobservable = 3, "unobservable";
    /// The same, because no traction load is there.
    NoLoad = 4, "unobservable_no_load";
    /// No usable measurement came with this sample: a prediction.
    NoMeasurement = 5, "no_measurement";
    /// Current or voltage turn against the motor: two phases are exchanged.
    PhasesSwapped = 6, "phases_swapped";
    /// A stator current is not measured, or its sensor repeats one value.
    CurrentMissing = 7, "current_missing";
    /// A stator voltage is not measured, or its sensor repeats one value.
    VoltageMissing = 8, "voltage_missing";
    /// The speed of motor or roller is not measured.
    SpeedMissing = 9, "speed_missing";
    /// The current of the generator is not measured.
    LoadCurrentMissing = 10, "load_current_missing";
    /// A voltage that the rig cannot have, or that the motor cannot have at this current and speed.
    VoltageImplausible = 11, "voltage_implausible";
    /// Currents, voltages and speeds do not fit together for a motor with these constants.
    Inconsistent = 12, "inputs_inconsistent";
    /// The filter contradicted its sensors for so long that it was started anew.
    Diverged = 13, "diverged";
    /// Samples come at another rate than the rig's file says.
    WrongRate = 14, "wrong_sample_rate";
}

impl EstimateState {
    /// The number that travels.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// True if the friction that is estimated (μ0 of a driven rig) is more than a prior.
    pub const fn tells_friction(self) -> bool {
        matches!(self, Self::Observable | Self::Weak)
    }

    /// True if nothing in the data speaks about friction.
    pub const fn is_unobservable(self) -> bool {
        matches!(self, Self::Unobservable | Self::NoLoad)
    }

    /// True if the input is so bad that no figure means anything.
    pub const fn is_fault(self) -> bool {
        !matches!(self, Self::Starting | Self::Observable | Self::Weak | Self::Unobservable | Self::NoLoad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_words_are_unique() {
        for (index, state) in EstimateState::ALL.iter().enumerate() {
            assert_eq!(state.code() as usize, index);
            assert!(EstimateState::ALL[..index].iter().all(|other| other.name() != state.name()));
        }
    }
}
