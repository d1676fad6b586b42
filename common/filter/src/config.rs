//! Settings of the estimator. Every key carries its unit; what is left out takes the documented default.

use serde::{Deserialize, Serialize};

/// Settings of the estimator of one wagon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EstimatorConfig {
    /// Which filter runs: a name in [`crate::FILTERS`]; "default" is the one that suits what is watched.
    pub filter: String,
    /// Where Q and R of the filters `paper` and `rig` come from; `default` always takes `physical`.
    pub noise: NoisePreset,
    /// Accuracy of the sensors where it differs from what the vehicle file declares.
    pub sensors: SensorSettings,
    /// How fast things change.
    pub rates: RateSettings,
    /// What is known before any measurement.
    pub priors: PriorSettings,
    /// What happens to bad data.
    pub hygiene: HygieneSettings,
    /// Modes of the filter `imm`.
    pub imm: ImmSettings,
}

impl Default for EstimatorConfig {
    fn default() -> Self {
        Self {
            filter: "default".into(),
            noise: NoisePreset::default(),
            sensors: SensorSettings::default(),
            rates: RateSettings::default(),
            priors: PriorSettings::default(),
            hygiene: HygieneSettings::default(),
            imm: ImmSettings::default(),
        }
    }
}

/// Origin of Q and R.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoisePreset {
    /// From declared sensor accuracy and physical rates of change.
    #[default]
    Physical,
    /// The matrices (20) of Schwarz & Keck, for nearly noiseless data of a rig; on noisy recordings their R of 1e-9
    /// turns sensor noise into adhesion.
    SchwarzKeck2020,
}

/// One-sigma accuracy of the sensors; absent: as the vehicle file declares it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSettings {
    /// Vehicle speed, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_sigma_m_s: Option<f64>,
    /// Wheelset speed, rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wheel_speed_sigma_rad_s: Option<f64>,
    /// Pressing force, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressing_force_sigma_n: Option<f64>,
}

/// How fast things change: one-sigma growth of random walks in one second (`_per_sqrt_s`), and times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RateSettings {
    /// Speed, from what no force in the model explains, m/s per √s.
    pub speed_per_sqrt_s: f64,
    /// Wheelset speed against the rail while rolling, m/s at the rim per √s.
    pub rim_speed_per_sqrt_s: f64,
    /// Wheelset speed in the filters `paper` and `rig`, whose one adhesion fits no wheelset exactly, m/s at the rim per √s.
    pub rim_speed_plain_per_sqrt_s: f64,
    /// Adhesion utilised while rolling, beyond what the brake torque explains, per √s.
    pub adhesion_rolling_per_sqrt_s: f64,
    /// Adhesion utilised while sliding steadily, per √s.
    pub adhesion_sliding_per_sqrt_s: f64,
    /// Adhesion utilised while sliding when the innovations show it changing, per √s.
    pub adhesion_changing_per_sqrt_s: f64,
    /// Adhesion utilised in the filters `paper` and `rig`, which do not tell rolling from sliding, per √s.
    pub adhesion_plain_per_sqrt_s: f64,
    /// Pad friction common to all wheelsets while braking, relative to nominal, per √s.
    pub pad_common_per_sqrt_s: f64,
    /// Pad friction of one wheelset against the others while braking, relative to nominal, per √s.
    pub pad_split_per_sqrt_s: f64,
    /// Time in which a held pad friction becomes as uncertain as its prior, s.
    pub pad_forget_s: f64,
    /// Share of a change of pressing force that may not be at the pad yet.
    pub brake_lag_share: f64,
    /// Time in which it gets there, s.
    pub brake_lag_s: f64,
    /// Time over which the slope of adhesion over slip keeps its value, s.
    pub sliding_slope_s: f64,
    /// Time over which wind, and errors of grade and running resistance, keep their value, s.
    pub disturbance_s: f64,
    /// The same of a coupled wagon, whose couplers change faster than all of these, s.
    pub coupler_s: f64,
}

impl Default for RateSettings {
    fn default() -> Self {
        Self {
            speed_per_sqrt_s: 0.001,
            rim_speed_per_sqrt_s: 0.002,
            rim_speed_plain_per_sqrt_s: 0.3,
            adhesion_rolling_per_sqrt_s: 0.0009,
            adhesion_sliding_per_sqrt_s: 0.008,
            adhesion_changing_per_sqrt_s: 0.1,
            adhesion_plain_per_sqrt_s: 0.05,
            pad_common_per_sqrt_s: 0.0055,
            pad_split_per_sqrt_s: 0.003,
            pad_forget_s: 60.0,
            brake_lag_share: 0.05,
            brake_lag_s: 0.2,
            sliding_slope_s: 10.0,
            disturbance_s: 60.0,
            coupler_s: 5.0,
        }
    }
}

/// What is known before any measurement, one sigma each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PriorSettings {
    /// Level of the pad friction common to the wheelsets, relative to nominal.
    pub pad_common: f64,
    /// Pad friction of one wheelset against their mean, relative to nominal.
    pub pad_split: f64,
    /// Mass, relative, where the vehicle file does not say how well it is known (`body.mass_sigma`).
    pub mass: f64,
    /// Error of a load sensor, relative: it stays as long as the load does.
    pub load_sensor: f64,
    /// Acceleration that couplers give a coupled wagon, m/s².
    pub coupler_m_s2: f64,
    /// Inertia of a wheelset, relative.
    pub inertia: f64,
    /// Running resistance, relative.
    pub resistance: f64,
    /// Wind along the track, m/s.
    pub wind_m_s: f64,
    /// Grade where it is measured, rad.
    pub grade_rad: f64,
    /// Grade where no value comes with the sample, rad.
    pub grade_unknown_rad: f64,
    /// Radius of a wheel, relative.
    pub wheel_radius: f64,
    /// Creepage at a given force, relative: how well the creep law is known on a clean rail.
    pub creep_law: f64,
    /// Creepage near the limit of adhesion beyond that of the linear law, relative.
    pub creep_excess: f64,
    /// Slope of adhesion over slip velocity in sliding, d ln μ / d ln u.
    pub sliding_slope: f64,
    /// Delay of the pads behind the measured pressing force, s.
    pub brake_delay_s: f64,
    /// Adhesion utilised at the start.
    pub adhesion: f64,
    /// Largest sigma of a wheelset's pad friction at which it is still called observable.
    pub observable_sigma: f64,
    /// Adhesion that the brake must ask for before a sample says something about pad friction.
    pub braking_adhesion: f64,
}

impl Default for PriorSettings {
    fn default() -> Self {
        Self {
            pad_common: 0.10,
            pad_split: 0.065,
            mass: 0.009,
            load_sensor: 0.03,
            coupler_m_s2: 2.0,
            inertia: 0.02,
            resistance: 0.058,
            wind_m_s: 0.5,
            grade_rad: 0.0002,
            grade_unknown_rad: 0.003,
            wheel_radius: 0.004,
            creep_law: 0.2,
            creep_excess: 0.6,
            sliding_slope: 0.1,
            brake_delay_s: 0.06,
            adhesion: 0.02,
            observable_sigma: 0.0075,
            braking_adhesion: 0.003,
        }
    }
}

/// What happens to bad data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HygieneSettings {
    /// Innovation beyond which a measurement is refused, in sigma.
    pub gate_sigma: f64,
    /// Jump of adhesion under a wheelset that is still believed at once; it widens the gate of wheelset speeds.
    pub gate_adhesion_jump: f64,
    /// A wheelset speed refused for that long is believed after all, s.
    pub wheel_recover_s: f64,
    /// A vehicle speed refused for that long is believed after all, s.
    pub speed_recover_s: f64,
    /// A value that repeats exactly for that long, while the estimate moves on, is a stuck sensor, s.
    pub stuck_after_s: f64,
    /// An input that is missing is held for that long; after that its effect is unknown, s.
    pub hold_s: f64,
    /// A time between samples beyond which the motion is measured anew instead of predicted, s.
    pub max_gap_s: f64,
    /// A step backwards in time up to this is a late sample and ignored; beyond it the clock was set, s.
    pub late_s: f64,
    /// So many late samples in a row mean that the clock was set.
    pub late_samples: u32,
}

impl Default for HygieneSettings {
    fn default() -> Self {
        Self {
            gate_sigma: 5.0,
            gate_adhesion_jump: 0.1,
            wheel_recover_s: 0.05,
            speed_recover_s: 1.0,
            stuck_after_s: 0.15,
            hold_s: 0.5,
            max_gap_s: 2.0,
            late_s: 1.0,
            late_samples: 10,
        }
    }
}

/// Settings of the filter `imm`; one-sigma growth in one second (`_per_sqrt_s`), and times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ImmSettings {
    /// Adhesion utilised while steady, per √s.
    pub adhesion_steady_per_sqrt_s: f64,
    /// Adhesion utilised while moving, per √s.
    pub adhesion_moving_per_sqrt_s: f64,
    /// Wheelset speed at the rim, from what the torque balance does not explain, m/s per √s.
    pub rim_speed_per_sqrt_s: f64,
    /// Mean time in which adhesion stays steady, or moving, s.
    pub adhesion_dwell_s: f64,
    /// Mean time in which pads stay prompt, or late, s.
    pub pads_dwell_s: f64,
    /// Time by which late pads follow the measured pressing force, s.
    pub pads_late_s: f64,
}

impl Default for ImmSettings {
    fn default() -> Self {
        Self {
            adhesion_steady_per_sqrt_s: 0.01,
            adhesion_moving_per_sqrt_s: 0.3,
            rim_speed_per_sqrt_s: 0.15,
            adhesion_dwell_s: 0.15,
            pads_dwell_s: 2.0,
            pads_late_s: 0.15,
        }
    }
}

impl EstimatorConfig {
    /// Checks every value against its allowed range.
    ///
    /// # Errors
    /// The first value out of range, with its dotted key.
    pub(crate) fn out_of_range(&self) -> Vec<ConfigError> {
        let (rates, priors, hygiene) = (&self.rates, &self.priors, &self.hygiene);
        let positive = (1e-9, 1e6, "above 0, up to 1e6");
        let share = (1e-6, 1.0, "1e-6 to 1");
        let seconds = (1e-3, 1e5, "0.001 to 100000");
        let optional = |value: Option<f64>| value.unwrap_or(1.0);
        let checks = [
            ("sensors.speed_sigma_m_s", optional(self.sensors.speed_sigma_m_s), positive),
            ("sensors.wheel_speed_sigma_rad_s", optional(self.sensors.wheel_speed_sigma_rad_s), positive),
            ("sensors.pressing_force_sigma_n", optional(self.sensors.pressing_force_sigma_n), positive),
            ("rates.speed_per_sqrt_s", rates.speed_per_sqrt_s, positive),
            ("rates.rim_speed_per_sqrt_s", rates.rim_speed_per_sqrt_s, positive),
            ("rates.rim_speed_plain_per_sqrt_s", rates.rim_speed_plain_per_sqrt_s, positive),
            ("rates.adhesion_rolling_per_sqrt_s", rates.adhesion_rolling_per_sqrt_s, positive),
            ("rates.adhesion_sliding_per_sqrt_s", rates.adhesion_sliding_per_sqrt_s, positive),
            ("rates.adhesion_changing_per_sqrt_s", rates.adhesion_changing_per_sqrt_s, positive),
            ("rates.adhesion_plain_per_sqrt_s", rates.adhesion_plain_per_sqrt_s, positive),
            ("rates.pad_common_per_sqrt_s", rates.pad_common_per_sqrt_s, share),
            ("rates.pad_split_per_sqrt_s", rates.pad_split_per_sqrt_s, share),
            ("rates.pad_forget_s", rates.pad_forget_s, seconds),
            ("rates.brake_lag_share", rates.brake_lag_share, share),
            ("rates.brake_lag_s", rates.brake_lag_s, seconds),
            ("rates.sliding_slope_s", rates.sliding_slope_s, seconds),
            ("rates.disturbance_s", rates.disturbance_s, seconds),
            ("rates.coupler_s", rates.coupler_s, seconds),
            ("priors.pad_common", priors.pad_common, share),
            ("priors.pad_split", priors.pad_split, share),
            ("priors.mass", priors.mass, share),
            ("priors.load_sensor", priors.load_sensor, share),
            ("priors.coupler_m_s2", priors.coupler_m_s2, (0.0, 50.0, "0 to 50")),
            ("priors.inertia", priors.inertia, share),
            ("priors.resistance", priors.resistance, share),
            ("priors.wind_m_s", priors.wind_m_s, (0.0, 50.0, "0 to 50")),
            ("priors.grade_rad", priors.grade_rad, (0.0, 0.1, "0 to 0.1")),
            ("priors.grade_unknown_rad", priors.grade_unknown_rad, (0.0, 0.1, "0 to 0.1")),
            ("priors.wheel_radius", priors.wheel_radius, share),
            ("priors.creep_law", priors.creep_law, share),
            ("priors.sliding_slope", priors.sliding_slope, share),
            ("priors.brake_delay_s", priors.brake_delay_s, share),
            ("priors.creep_excess", priors.creep_excess, (0.0, 10.0, "0 to 10")),
            ("priors.adhesion", priors.adhesion, share),
            ("priors.observable_sigma", priors.observable_sigma, share),
            ("priors.braking_adhesion", priors.braking_adhesion, share),
            ("hygiene.gate_sigma", hygiene.gate_sigma, (1.0, 100.0, "1 to 100")),
            ("hygiene.gate_adhesion_jump", hygiene.gate_adhesion_jump, (0.0, 1.0, "0 to 1")),
            ("hygiene.wheel_recover_s", hygiene.wheel_recover_s, seconds),
            ("hygiene.speed_recover_s", hygiene.speed_recover_s, seconds),
            ("hygiene.stuck_after_s", hygiene.stuck_after_s, seconds),
            ("hygiene.hold_s", hygiene.hold_s, (0.0, 1e5, "0 to 100000")),
            ("hygiene.max_gap_s", hygiene.max_gap_s, seconds),
            ("imm.adhesion_steady_per_sqrt_s", self.imm.adhesion_steady_per_sqrt_s, positive),
            ("imm.adhesion_moving_per_sqrt_s", self.imm.adhesion_moving_per_sqrt_s, positive),
            ("imm.rim_speed_per_sqrt_s", self.imm.rim_speed_per_sqrt_s, positive),
            ("imm.adhesion_dwell_s", self.imm.adhesion_dwell_s, seconds),
            ("imm.pads_dwell_s", self.imm.pads_dwell_s, seconds),
            ("imm.pads_late_s", self.imm.pads_late_s, seconds),
            ("hygiene.late_s", hygiene.late_s, (0.0, 1e5, "0 to 100000")),
        ];
        let wrong = checks.into_iter().filter(|(_, value, (low, high, _))| !(*low..=*high).contains(value));
        wrong.map(|(key, value, (.., allowed))| ConfigError::OutOfRange { key, value, allowed }).collect()
    }
}

/// A setting that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// A value outside its range.
    #[error("`{key}` is {value}, allowed is {allowed}")]
    OutOfRange {
        /// Dotted key.
        key: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        allowed: &'static str,
    },
    /// A filter that does not exist.
    #[error("`filter` is \"{name}\", known are {known}")]
    UnknownFilter {
        /// What stands there.
        name: String,
        /// What may stand there.
        known: String,
    },
}
