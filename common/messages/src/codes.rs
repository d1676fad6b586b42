//! Small enumerations. On the wire each is a `u32`, because a reader must survive a code that it does not know.

/// Declares an enumeration with its codes, its reader and its words.
macro_rules! codes {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $code:literal, $word:literal;)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u32)]
        pub enum $name { $($(#[$variant_meta])* $variant = $code,)+ }

        impl $name {
            /// Every value, in the order of the codes.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// The number that travels.
            #[must_use]
            pub const fn code(self) -> u32 {
                self as u32
            }

            /// The value of a number; `None` for a number of another version.
            #[must_use]
            pub const fn from_code(code: u32) -> Option<Self> {
                match code {
                    $($code => Some(Self::$variant),)+
                    _ => None,
                }
            }

            /// The word that people and JSON see.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.pad(self.word())
            }
        }
    };
}

codes! {
    /// How an indicator is judged; a larger code is worse.
    Grade {
        /// Not enough data to judge.
        Unknown = 0, "unknown";
        /// As it should be.
        Ok = 1, "ok";
        /// Worth a look at the next occasion.
        Watch = 2, "watch";
        /// Needs action.
        Act = 3, "act";
    }
}

codes! {
    /// State of the rail as the adhesion shows it; the codes index `Health::condition_probability`.
    Condition {
        /// Dry rail.
        Dry = 0, "dry";
        /// Wet rail.
        Wet = 1, "wet";
        /// Low adhesion, for example leaf film.
        Low = 2, "low";
        /// Very low adhesion.
        VeryLow = 3, "very low";
    }
}

codes! {
    /// What an estimate is worth; the codes are those of the filter.
    EstimateState {
        /// The filter has just begun.
        Starting = 0, "starting";
        /// The data determine what is estimated.
        Observable = 1, "observable";
        /// The data say something about it.
        Weak = 2, "weak";
        /// Nothing in the data speaks about it.
        Unobservable = 3, "unobservable";
        /// The same, because no traction load is there.
        NoLoad = 4, "unobservable_no_load";
        /// No usable measurement came.
        NoMeasurement = 5, "no_measurement";
        /// Two phases are exchanged.
        PhasesSwapped = 6, "phases_swapped";
        /// A stator current is not measured.
        CurrentMissing = 7, "current_missing";
        /// A stator voltage is not measured.
        VoltageMissing = 8, "voltage_missing";
        /// The speed of motor or roller is not measured.
        SpeedMissing = 9, "speed_missing";
        /// The current of the generator is not measured.
        LoadCurrentMissing = 10, "load_current_missing";
        /// A voltage that cannot be.
        VoltageImplausible = 11, "voltage_implausible";
        /// Currents, voltages and speeds do not fit together.
        Inconsistent = 12, "inputs_inconsistent";
        /// The filter was started anew, because it contradicted its sensors.
        Diverged = 13, "diverged";
        /// Samples come at another rate than the rig's file says.
        WrongRate = 14, "wrong_sample_rate";
        /// No normal load.
        ZeroLoad = 15, "zero_load";
        /// The torque is not measured.
        TorqueMissing = 16, "torque_missing";
        /// The force of the link is not measured.
        LoadCellMissing = 17, "load_cell_missing";
        /// Neither torque nor link force is measured.
        ForcesMissing = 18, "forces_missing";
        /// The rollers' pulses are missing.
        RollerCounterMissing = 19, "roller_counter_missing";
        /// A wheelset's pulses are missing.
        WheelCounterMissing = 20, "wheel_counter_missing";
        /// Torque and link force are exchanged.
        ForcesSwapped = 21, "forces_swapped";
        /// The counters are exchanged.
        CountersSwapped = 22, "counters_swapped";
        /// Torque and link force contradict each other.
        ForcesDisagree = 23, "forces_disagree";
        /// The rollers stand.
        Standstill = 24, "standstill";
    }
}

codes! {
    /// What came of listening to a second of audio.
    HearingState {
        /// The listener has just begun.
        Starting = 0, "starting";
        /// Classified; only this comes with a probability.
        Heard = 1, "heard";
        /// Another sample rate than the features are defined for.
        WrongSampleRate = 2, "wrong_sample_rate";
        /// No sound: the microphone is off or dead.
        SilentMicrophone = 3, "silent_microphone";
        /// Overdriven.
        Clipped = 4, "clipped";
        /// Samples that are not finite numbers.
        NotFinite = 5, "not_finite";
        /// Less than a window.
        TooShort = 6, "too_short";
        /// The vehicle stands: nothing rolls.
        Standstill = 7, "standstill";
        /// Nothing like it was in training.
        Unfamiliar = 8, "unfamiliar";
        /// No audio arrives.
        NoAudio = 9, "no_audio";
    }
}

codes! {
    /// Which kind of process speaks.
    ProcessKind {
        /// Creates and keeps the channels.
        Holder = 1, "holder";
        /// Brings samples onto the channels.
        Ingest = 2, "ingest";
        /// Filters the samples of one wagon.
        Estimator = 3, "estimator";
        /// Serves the indicators over HTTP.
        Health = 4, "health";
        /// Writes channels to recordings.
        Record = 5, "record";
        /// Listens to the microphone of one wagon.
        Listener = 6, "listener";
        /// Judges all wagons of a coupled train together.
        Judge = 7, "judge";
    }
}

codes! {
    /// What an event is about.
    EventKind {
        /// A process came up.
        Started = 1, "started";
        /// A process went down in order.
        Stopped = 2, "stopped";
        /// A wheelset began to slide or spin.
        SlideBegan = 3, "slide began";
        /// A wheelset rolls again; values: duration in s, energy in J, largest |creepage|, smallest adhesion utilised.
        SlideEnded = 4, "slide ended";
        /// The wheel-slide protection became active.
        WspBegan = 5, "wsp began";
        /// The wheel-slide protection became inactive.
        WspEnded = 6, "wsp ended";
        /// The rail condition changed; values: old code, new code, probability.
        ConditionChanged = 7, "condition changed";
        /// The grade of an indicator changed; values: old code, new code, the indicator's value.
        GradeChanged = 8, "grade changed";
        /// Samples are missing; values: how many, seconds.
        SamplesMissed = 9, "samples missed";
        /// A recording that is played once has ended: what stays away from now on is not missing.
        SourceChanged = 10, "source changed";
        /// The filter started anew or resumed from a snapshot; values: age of the snapshot in s.
        FilterRestarted = 11, "filter restarted";
        /// The model does not explain the data of a wagon for long; values: ratio of the innovations, seconds.
        ModelMismatch = 12, "model mismatch";
        /// What a microphone hears has changed: its state, or the condition of the rail.
        HearingChanged = 13, "hearing changed";
        /// The columns of a wagon's source cannot be in their units and are withheld, or are plausible again.
        UnitsImplausible = 14, "units implausible";
        /// The clock of a wagon's source drifts, or no longer does; values: parts in a million.
        ClockDrifts = 15, "clock drifts";
    }
}

codes! {
    /// What a source of samples counts. Each thing that is dropped has its name here.
    SourceCount {
        /// Frames, telegrams, lines or messages that arrived.
        Arrived = 0, "arrived";
        /// Samples of a wagon that came of them.
        Samples = 1, "samples";
        /// Samples with a time that is not after that of the one before.
        Late = 2, "late";
        /// Samples of a wagon whose columns cannot be in their units.
        Withheld = 3, "withheld";
        /// Lines and messages that are no sample.
        Unreadable = 4, "unreadable";
        /// Frames and telegrams that the mapping has no use for.
        Unwanted = 5, "unwanted";
        /// Values that a frame or telegram is too short for.
        Short = 6, "short";
        /// Values outside of what their description says that they can be, or of what such a sensor can give.
        OutOfRange = 7, "out_of_range";
        /// Frames by which a CAN controller reports an error.
        ErrorFrame = 8, "error_frame";
        /// CAN frames that ask for data.
        RemoteFrame = 9, "remote_frame";
        /// Frames, telegrams and datagrams lost because the queue of the socket was full.
        Overrun = 10, "overrun";
        /// Telegrams shorter than a header.
        HeaderShort = 11, "header_short";
        /// Telegrams with a wrong checksum of the header.
        HeaderCrc = 12, "header_crc";
        /// Telegrams of another version of the protocol.
        ProtocolVersion = 13, "protocol_version";
        /// Telegrams that carry no process data.
        TelegramKind = 14, "telegram_kind";
        /// Telegrams that are not as long as they say.
        TelegramLength = 15, "telegram_length";
        /// Telegrams that never came, by the gaps of their counters.
        Lost = 16, "lost";
        /// Telegrams that came twice, or that others had overtaken.
        Old = 17, "old";
        /// Telegrams of an address that is no sender of this train.
        ForeignSender = 18, "foreign_sender";
        /// Times at which a sender began its counter again.
        SenderRestarts = 19, "sender_restarts";
        /// Times at which the topography of the train changed.
        TopologyChanges = 20, "topology_changes";
        /// Samples of a wagon that never came in, by the time of the source: it went on by more than its usual step. Other names
        /// may say why.
        Skipped = 21, "skipped";
        /// Times at which a source said nothing of a wagon for so long that nobody can say what is missing.
        Pauses = 22, "pauses";
        /// Samples whose time was ahead of the clock of their source: the next one came without a jump.
        Ahead = 23, "ahead";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_survive_the_way_there_and_back() {
        for kind in EventKind::ALL {
            assert_eq!(EventKind::from_code(kind.code()), Some(*kind));
        }
        for grade in Grade::ALL {
            assert_eq!(Grade::from_code(grade.code()), Some(*grade));
        }
        for state in HearingState::ALL {
            assert_eq!(HearingState::from_code(state.code()), Some(*state));
        }
        assert_eq!(ProcessKind::from_code(0), None);
        assert_eq!(Condition::from_code(4), None);
        assert_eq!(format!("{:<9}|", Condition::VeryLow), "very low |");
    }

    #[test]
    fn a_worse_grade_compares_greater() {
        assert!(Grade::Act > Grade::Watch && Grade::Watch > Grade::Ok && Grade::Ok > Grade::Unknown);
    }
}
