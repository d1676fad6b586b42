//! The causes that an alert can name, and what to do about each.

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
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
    ($($name:ident $word:literal $advice:literal),+ $(,)?) => {
        /// What can be wrong.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
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

            /// What to do.
            #[must_use]
            pub const fn advice(self) -> &'static str {
                match self { $(Self::$name => $advice),+ }
            }
        }
    };
}

causes! {
    Dragging "dragging" "Feel discs and wheels at the next stop; release and isolate the brake if they are hot.",
    Isolated "isolated" "Check the isolating cock and the hoses here. Count this brake as missing until then.",
    PadLow "pad_low" "Check pads and discs of this wagon: wear, glazing, water or oil.",
    PadUneven "pad_uneven" "Check pads and discs of this wheelset: glazing, wear, oil.",
    BrakeFade "brake_fade" "Let the discs cool; check material and wear of the pads of this wagon.",
    SlowCylinder "slow_cylinder" "Check hoses, chokes and cylinder seals for leaks and narrow passages.",
    LateDistributor "late_distributor" "Check the distributor valve of this wagon.",
    WspValve "wsp_valve" "Check the dump valve of the slide protection of this wheelset.",
    WheelFlat "wheel_flat" "Look at the tread of this wheelset for a flat.",
    WheelDiameter "wheel_diameter" "Compare the wheel diameter with the vehicle file.",
    TachometerEccentric "tachometer_eccentric" "Check how the tachometer of this wheelset is mounted.",
    TachometerLate "tachometer_late" "Check the tachometer of this wheelset and the unit that reads it.",
    TachometerDropout "tachometer_dropout" "Check plug and cable of the tachometer of this wheelset.",
    SpeedSensor "speed_sensor" "Check the speed sensor of this wagon and its scale.",
    PressureSensor "pressure_sensor" "Check the pressure transducer of this wheelset against a gauge.",
    LowAdhesion "low_adhesion" "Brake early and gently; report the place.",
    Payload "payload" "Compare the load of this wagon with what was entered.",
    Silent "silent" "Check the data connection of this wagon.",
}
