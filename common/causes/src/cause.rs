//! The causes that an alert can name, and what to do about each.

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Grade {
    /// Somebody should look at it.
    Watch,
    /// Somebody must act.
    Act,
}

impl Grade {
    /// The word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Watch => "watch",
            Self::Act => "act",
        }
    }
}

macro_rules! causes {
    ($($name:ident $word:literal $title:literal $advice:literal),+ $(,)?) => {
        /// What can be wrong.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        pub enum Cause {
            $(#[doc = $advice] $name),+
        }

        impl Cause {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name),+];

            /// Stable name.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self { $(Self::$name => $word),+ }
            }

            /// Name for people.
            #[must_use]
            pub const fn title(self) -> &'static str {
                match self { $(Self::$name => $title),+ }
            }

            /// What to do.
            #[must_use]
            pub const fn advice(self) -> &'static str {
                match self { $(Self::$name => $advice),+ }
            }
        }
    };
}

causes! {
    Dragging "dragging" "Dragging brake" "Feel discs and wheels at the next stop; release and isolate the brake if they are hot.",
    Isolated "isolated" "Without a brake" "Check the isolating cock and the hoses here. Count this brake as missing until then.",
    PadLow "pad_low" "Pads of a wagon" "Check pads and discs of this wagon: wear, glazing, water or oil.",
    PadUneven "pad_uneven" "Pads of a wheelset" "Check pads and discs of this wheelset: glazing, wear, oil.",
    BrakeFade "brake_fade" "Brake fade" "Let the discs cool; check material and wear of the pads of this wagon.",
    SlowCylinder "slow_cylinder" "Slow or leaking cylinder" "Check hoses, chokes and cylinder seals for leaks and narrow passages.",
    LateDistributor "late_distributor" "Late distributor" "Check the distributor valve of this wagon.",
    WspValve "wsp_valve" "Dump valve" "Check the dump valve of the slide protection of this wheelset.",
    WheelFlat "wheel_flat" "Wheel flat" "Look at the tread of this wheelset for a flat.",
    WheelDiameter "wheel_diameter" "Wheel diameter" "Compare the wheel diameter with the vehicle file.",
    TachometerEccentric "tachometer_eccentric" "Eccentric tachometer" "Check how the tachometer of this wheelset is mounted.",
    TachometerLate "tachometer_late" "Late tachometer" "Check the tachometer of this wheelset and the unit that reads it.",
    TachometerDropout "tachometer_dropout" "Tachometer drops out" "Check plug and cable of the tachometer of this wheelset.",
    SpeedSensor "speed_sensor" "Speed sensor" "Check the speed sensor of this wagon and its scale.",
    PressureSensor "pressure_sensor" "Pressure transducer" "Check the pressure transducer of this wheelset against a gauge.",
    LowAdhesion "low_adhesion" "Low adhesion" "Brake early and gently; report the place.",
    Payload "payload" "Load entry" "Compare the load of this wagon with what was entered.",
    Clock "clock" "Clock of a wagon" "Check the clock by which this wagon stamps its data, and what the data wait for on their way.",
    Silent "silent" "Silent wagon" "Check the data connection of this wagon.",
}

impl Cause {
    /// Its code in messages: its place in [`Self::ALL`], 1 first. All processes of a train are one program.
    #[must_use]
    pub const fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The cause of a code.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.get((code as usize).checked_sub(1)?).copied()
    }

    /// The cause of a stable name.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|cause| cause.word() == word)
    }

    /// Whether it lies in what measures creepage.
    #[must_use]
    pub(crate) const fn is_of_wheel_speeds(self) -> bool {
        matches!(
            self,
            Self::WheelFlat
                | Self::WheelDiameter
                | Self::TachometerEccentric
                | Self::TachometerLate
                | Self::TachometerDropout
                | Self::SpeedSensor
                | Self::Clock
        )
    }

    /// Whether it is an error of scale, which stays what it is: where it has been learnt, creepage tells as much as ever.
    #[must_use]
    pub(crate) const fn is_of_scale(self) -> bool {
        matches!(self, Self::WheelDiameter | Self::SpeedSensor)
    }

    /// Whether it explains what another was blamed for: a sensor that is wrong speaks louder than what it showed, and one wheelset of
    /// which it has shown than all of its wagon.
    #[must_use]
    pub(crate) const fn outranks(self, other: Self) -> bool {
        let by_creepage = matches!(other, Self::Dragging | Self::PadLow | Self::PadUneven | Self::BrakeFade);
        (self.is_of_wheel_speeds() && by_creepage)
            || (matches!(self, Self::PadUneven) && matches!(other, Self::PadLow))
    }

    /// Whether it shows in pressing forces.
    const fn is_of_pressure(self) -> bool {
        matches!(
            self,
            Self::Isolated
                | Self::SlowCylinder
                | Self::LateDistributor
                | Self::WspValve
                | Self::PressureSensor
        )
    }

    /// Whether `other` on the same wagon is no alert of its own while this one is open, because it may be what this one shows. A wrong
    /// entry of the payload changes what pads and rail seem to give; a brake that drags, cylinders and sensors it leaves alone. What
    /// measures wheel speeds says nothing of pressing forces, unless all of the wagon comes late; a wrong scale hides nothing of pads and
    /// drag once it is known.
    #[must_use]
    pub(crate) const fn explains(self, other: Self) -> bool {
        let by_weight = matches!(
            other,
            Self::Payload | Self::PadLow | Self::PadUneven | Self::BrakeFade | Self::LowAdhesion
        );
        let by_creepage = matches!(other, Self::Dragging | Self::PadLow | Self::PadUneven | Self::BrakeFade);
        match self {
            Self::Payload => by_weight,
            Self::WheelDiameter | Self::SpeedSensor if by_creepage => false,
            Self::Clock => true,
            _ => !(self.is_of_wheel_speeds() && other.is_of_pressure()),
        }
    }

    /// So long after nothing confirms it any more it is over, s. What comes and goes with the place is over soon; what
    /// shows in some applications only needs hours.
    #[must_use]
    pub(crate) const fn lasts_s(self) -> f64 {
        match self {
            Self::LowAdhesion => 180.0,
            Self::Silent => 30.0,
            _ => 3600.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_words_lead_back() {
        for cause in Cause::ALL {
            assert_eq!(Cause::from_code(cause.code()), Some(*cause));
            assert_eq!(Cause::from_word(cause.word()), Some(*cause));
        }
        assert_eq!(Cause::from_code(0), None);
    }
}
