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
    /// The data determine what is estimated: μ0 of a driven rig, adhesion and slip of a bogie rig, the pad friction of
    /// every wheelset of a wagon.
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
    /// No normal load is on the wheelsets, or it is not measured.
    ZeroLoad = 15, "zero_load";
    /// The torque transducer is missing or repeats one value: adhesion rests on the load cell alone.
    TorqueMissing = 16, "torque_missing";
    /// The load cell is missing or repeats one value: adhesion rests on the torque alone.
    LoadCellMissing = 17, "load_cell_missing";
    /// Neither torque nor link force is measured.
    ForcesMissing = 18, "forces_missing";
    /// The rollers' pulses are missing, or none come while the wheelsets turn.
    RollerCounterMissing = 19, "roller_counter_missing";
    /// A wheelset's pulses are missing, or none come while it must roll.
    WheelCounterMissing = 20, "wheel_counter_missing";
    /// Torque and link force are exchanged.
    ForcesSwapped = 21, "forces_swapped";
    /// Pulses of rollers and wheelsets do not fit the radii while nothing brakes.
    CountersSwapped = 22, "counters_swapped";
    /// Torque and link force contradict each other.
    ForcesDisagree = 23, "forces_disagree";
    /// The rollers stand: slip is not defined.
    Standstill = 24, "standstill";
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

    /// True if something is wrong with the input.
    pub const fn is_fault(self) -> bool {
        use EstimateState as S;
        !matches!(self, S::Starting | S::Observable | S::Weak | S::Unobservable | S::NoLoad | S::Standstill)
    }

    /// True if the adhesion utilised is a figure: the input is sound, or one of two sensors of the same force still is.
    pub const fn tells_adhesion(self) -> bool {
        use EstimateState as S;
        matches!(
            self,
            S::TorqueMissing
                | S::LoadCellMissing
                | S::RollerCounterMissing
                | S::WheelCounterMissing
                | S::CountersSwapped
        ) || !self.is_fault()
    }

    /// True if creepage is a figure.
    pub const fn tells_slip(self) -> bool {
        use EstimateState as S;
        match self {
            S::Standstill => false,
            S::TorqueMissing
            | S::LoadCellMissing
            | S::ForcesMissing
            | S::ForcesSwapped
            | S::ForcesDisagree => true,
            _ => !self.is_fault(),
        }
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
