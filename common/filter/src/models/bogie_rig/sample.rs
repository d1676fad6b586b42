//! What the rig's filter takes in and gives out.

use railgrip_vehicle::bogie_rig::BOGIE_WHEELSETS;

/// Number of measured values: torque, link force, pulses of the rollers and of each wheelset.
pub const OUTPUTS: usize = 3 + BOGIE_WHEELSETS;

/// The sensors of a bogie rig at one instant: Shrestha et al., section 2. A value that is missing is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BogieSample {
    /// Time, s.
    pub time_s: f64,
    /// T_e between motor and gear, N m.
    pub shaft_torque_nm: f64,
    /// Force of the link, N, positive in braking.
    pub load_cell_n: f64,
    /// Pressure at the calipers, Pa.
    pub brake_pressure_pa: f64,
    /// Normal load of the bogie from its preloaded mass, N.
    pub load_n: f64,
    /// Pulses of the rollers' encoder in the window that ends now; NaN within a window.
    pub roller_pulses: f64,
    /// Pulses of each wheelset's encoder since the last sample.
    pub wheel_pulses: [f64; BOGIE_WHEELSETS],
}

impl BogieSample {
    /// An instant of which nothing but the time is known.
    pub const fn missing(time_s: f64) -> Self {
        Self {
            time_s,
            shaft_torque_nm: f64::NAN,
            load_cell_n: f64::NAN,
            brake_pressure_pa: f64::NAN,
            load_n: f64::NAN,
            roller_pulses: f64::NAN,
            wheel_pulses: [f64::NAN; BOGIE_WHEELSETS],
        }
    }

    /// The measured values: torque, link force, pulses.
    pub fn outputs(&self) -> [f64; OUTPUTS] {
        let [front, rear] = self.wheel_pulses;
        [self.shaft_torque_nm, self.load_cell_n, self.roller_pulses, front, rear]
    }
}

/// What the data are, and with them the estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BogieInputState {
    /// The filter has just begun: no numbers.
    #[default]
    Starting,
    /// Brakes released.
    Rolling,
    /// Brakes applied.
    Braking,
    /// A braked wheelset stands while the rollers turn.
    WheelLocked,
    /// The rollers stand: slip is not defined.
    Standstill,
    /// Normal load zero, missing or below a twentieth of the rig's: adhesion and slip are not defined.
    ZeroLoad,
    /// No usable torque: adhesion rests on the load cell alone.
    TorqueDead,
    /// No usable link force: adhesion rests on the torque alone.
    LoadCellDead,
    /// Neither torque nor link force: no adhesion.
    ForcesDead,
    /// No pulses of the rollers: no slip.
    RollerCounterDead,
    /// No pulses of a wheelset: no slip.
    WheelCounterDead,
    /// Torque and link force are exchanged: no adhesion.
    ForcesSwapped,
    /// Pulses of rollers and wheelsets do not fit the rig's radii while nothing brakes: exchanged or of another encoder.
    CountersSwapped,
    /// Torque and link force contradict each other: no adhesion.
    ForcesDisagree,
}

impl BogieInputState {
    /// Name for people and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Rolling => "rolling",
            Self::Braking => "braking",
            Self::WheelLocked => "wheel locked",
            Self::Standstill => "standstill",
            Self::ZeroLoad => "zero load",
            Self::TorqueDead => "torque transducer dead",
            Self::LoadCellDead => "load cell dead",
            Self::ForcesDead => "torque transducer and load cell dead",
            Self::RollerCounterDead => "roller counter dead",
            Self::WheelCounterDead => "wheelset counter dead",
            Self::ForcesSwapped => "torque and load cell swapped",
            Self::CountersSwapped => "counters swapped",
            Self::ForcesDisagree => "torque and load cell disagree",
        }
    }

    /// True if the adhesion means something.
    pub fn tells_adhesion(self) -> bool {
        !matches!(
            self,
            Self::Starting | Self::ZeroLoad | Self::ForcesDead | Self::ForcesSwapped | Self::ForcesDisagree
        )
    }

    /// True if the slip means something.
    pub fn tells_slip(self) -> bool {
        !matches!(
            self,
            Self::Starting
                | Self::Standstill
                | Self::ZeroLoad
                | Self::RollerCounterDead
                | Self::WheelCounterDead
                | Self::CountersSwapped
        )
    }
}

/// Contact of the rig at one instant. All `sigma` are one standard deviation. What the state does not tell is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BogieEstimate {
    /// That of the sample, s.
    pub time_s: f64,
    /// What the data are.
    pub state: BogieInputState,
    /// Speed of the rollers' rim, m/s.
    pub v_m_s: f64,
    /// 1 σ of it, m/s.
    pub v_sigma_m_s: f64,
    /// Creepage of each wheelset, negative in braking: −λ of (2).
    pub creepage: [f64; BOGIE_WHEELSETS],
    /// 1 σ of it.
    pub creepage_sigma: [f64; BOGIE_WHEELSETS],
    /// Adhesion utilised by the bogie, negative in braking.
    pub mu_w: f64,
    /// 1 σ of it.
    pub mu_w_sigma: f64,
    /// Zero error of the transducer, N m.
    pub torque_offset_nm: f64,
    /// Zero error of the load cell, N.
    pub load_cell_offset_n: f64,
    /// Roller acceleration, rad/s².
    pub roller_acceleration_rad_s2: f64,
    /// Measured minus predicted: N m, N, rad, rad, rad; 0 where nothing was compared.
    pub innovation: [f64; OUTPUTS],
    /// Predicted variance of each; 0 where nothing was compared.
    pub innovation_variance: [f64; OUTPUTS],
    /// Normalised innovation squared of this step, refused values too.
    pub nis: f64,
    /// Values behind `nis`.
    pub nis_dof: u32,
    /// Values refused by the gate, bit mask in the order of [`BogieSample::outputs`].
    pub rejected: u32,
}

impl BogieEstimate {
    /// An estimate that tells nothing yet.
    pub fn silent(time_s: f64) -> Self {
        Self {
            time_s,
            state: BogieInputState::Starting,
            v_m_s: f64::NAN,
            v_sigma_m_s: f64::NAN,
            creepage: [f64::NAN; BOGIE_WHEELSETS],
            creepage_sigma: [f64::NAN; BOGIE_WHEELSETS],
            mu_w: f64::NAN,
            mu_w_sigma: f64::NAN,
            torque_offset_nm: f64::NAN,
            load_cell_offset_n: f64::NAN,
            roller_acceleration_rad_s2: f64::NAN,
            innovation: [0.0; OUTPUTS],
            innovation_variance: [0.0; OUTPUTS],
            nis: 0.0,
            nis_dof: 0,
            rejected: 0,
        }
    }

    /// Slip λ (2) of the wheelset that slips most, if the state tells it.
    pub fn slip(&self) -> Option<f64> {
        self.state.tells_slip().then(|| -self.creepage.iter().copied().fold(f64::INFINITY, f64::min))
    }

    /// What people read: |mu_w|, if the state tells it.
    pub fn adhesion_utilised(&self) -> Option<f64> {
        self.state.tells_adhesion().then(|| self.mu_w.abs())
    }
}
