//! How indicators are computed and from where on they are worth a look (watch) or need action (act).
//! Each table has defaults, so that a config names only what differs.

mod range;

pub use range::{SettingEntry, SettingError};

use range::table;
use serde::{Deserialize, Serialize};

table! {
    /// Pad friction of each wheelset and of the wagon.
    BrakeFrictionSettings {
        /// Braking that the mean remembers, s.
        memory_s = 120.0 in 1.0..100000.0;
        /// Estimates closer than this say the same thing twice, s.
        correlation_s = 5.0 in 0.1..600.0;
        /// Less braking than this gives no verdict, s.
        min_braking_s = 3.0 in 0.1..3600.0;
        /// A wheelset brakes from this pressing force on, N.
        min_pressing_force_n = 2000.0 in 0.0..1000000.0;
        /// 1 σ of what the estimate cannot know (mass, radii), as a share of the friction.
        systematic_share = 0.01 in 0.0..0.5;
        /// Watch below this ratio to nominal.
        ratio_watch_low = 0.85 in 0.0..1.0;
        /// Act below this ratio to nominal.
        ratio_act_low = 0.70 in 0.0..1.0;
        /// Watch above this ratio to nominal.
        ratio_watch_high = 1.20 in 1.0..10.0;
        /// Act above this ratio to nominal.
        ratio_act_high = 1.40 in 1.0..10.0;
    }
}

table! {
    /// The standard conditions that pad friction is referred to.
    StandardSettings {
        /// Speed, m/s.
        speed_m_s = 20.0 in 1.0..100.0;
        /// Pressing force of a wheelset, N.
        pressing_force_n = 50000.0 in 100.0..1000000.0;
        /// Disc temperature above the surroundings, K.
        disc_rise_k = 50.0 in 0.0..500.0;
        /// Heat capacity of the discs of a wheelset, J/K.
        disc_heat_j_per_k = 60000.0 in 100.0..10000000.0;
        /// Time constant with which whole discs cool between stops, s. (A law of fade has the friction ring's, 120 s: within a
        /// stop heat leaves it for the rest of the disc.)
        disc_cooling_s = 600.0 in 1.0..100000.0;
        /// Braking that the fit remembers, s.
        memory_s = 1800.0 in 10.0..1000000.0;
    }
}

table! {
    /// How fast the brake builds up.
    ResponseSettings {
        /// Watch above this median time to 90 % of the level, s.
        watch_s = 6.0 in 0.1..120.0;
        /// Act above it, s.
        act_s = 10.0 in 0.1..120.0;
        /// Watch when a wagon begins to brake so much later than its place in the train explains, s.
        late_watch_s = 0.6 in 0.05..60.0;
        /// Act when so much later, s.
        late_act_s = 2.0 in 0.05..60.0;
    }
}

table! {
    /// A retarding force while the brakes are released.
    DraggingSettings {
        /// Released running that the mean remembers, s.
        memory_s = 120.0 in 5.0..100000.0;
        /// Less of it gives no verdict, s.
        min_released_s = 12.0 in 4.0..3600.0;
        /// Watch above this share of the weight.
        watch = 0.008 in 0.0..1.0;
        /// Act above this share of the weight.
        act = 0.025 in 0.0..1.0;
    }
}

table! {
    /// Brakes that do not brake.
    IsolatedSettings {
        /// Braking that the share remembers, s.
        memory_s = 60.0 in 5.0..100000.0;
        /// Watch above this share of the braking without pressing force.
        watch = 0.3 in 0.0..1.0;
        /// Act above this share.
        act = 0.8 in 0.0..1.0;
        /// Pad friction below this ratio to nominal is a brake without effect.
        effect_ratio = 0.25 in 0.0..1.0;
    }
}

table! {
    /// What sand does.
    SandingSettings {
        /// Time that the comparison remembers, s.
        memory_s = 120.0 in 5.0..100000.0;
        /// Watch when sand raises adhesion by less than this factor.
        factor_watch = 1.1 in 0.0..10.0;
    }
}

table! {
    /// Pad friction of the front against the rear wheelsets.
    AsymmetrySettings {
        /// Watch above this difference over the mean.
        watch = 0.15 in 0.0..2.0;
        /// Act above this difference over the mean.
        act = 0.30 in 0.0..2.0;
    }
}

table! {
    /// Adhesion and the condition of the rail.
    AdhesionSettings {
        /// Adhesion utilised is the largest of so many seconds, s.
        window_s = 10.0 in 1.0..60.0;
        /// What a slide showed of the adhesion available holds for so long, s.
        slide_hold_s = 20.0 in 0.0..3600.0;
        /// Without news the belief about the rail fades to the prior in about so long, s.
        memory_s = 60.0 in 1.0..100000.0;
        /// Probability of dry rail before anything is known; wet, low and very low rail share the rest 25 : 12 : 3.
        prior_dry = 0.60 in 0.01..0.99;
        /// Watch when low or very low rail is at least so probable.
        low_probability_watch = 0.60 in 0.0..1.0;
        /// Act when very low rail is at least so probable.
        very_low_probability_act = 0.60 in 0.0..1.0;
        /// Ok when low or very low rail is at most so probable; unknown in between.
        low_probability_ok = 0.10 in 0.0..1.0;
    }
}

table! {
    /// Slides and their energy: the risk of wheel flats.
    SlideSettings {
        /// Shorter slides are not counted, s.
        min_duration_s = 0.10 in 0.0..60.0;
        /// Slides and energy count towards the grade for about so long, s.
        memory_s = 3600.0 in 1.0..10000000.0;
        /// Watch above this energy, J.
        energy_watch_j = 2000000.0 in 0.0..1000000000.0;
        /// Act above this energy, J.
        energy_act_j = 10000000.0 in 0.0..1000000000.0;
        /// Watch above this time with the wheelset locked, s.
        locked_watch_s = 1.0 in 0.0..3600.0;
        /// Act above this time with the wheelset locked, s.
        locked_act_s = 4.0 in 0.0..3600.0;
    }
}

table! {
    /// Wheels that are not round.
    WheelFlatSettings {
        /// Free rolling that the mean over the angle remembers, s.
        memory_s = 300.0 in 30.0..100000.0;
        /// Watch above this variation of the speed over a turn, as a share of the speed.
        variation_watch = 0.0004 in 0.0..0.1;
        /// Act above it.
        variation_act = 0.0012 in 0.0..0.1;
    }
}

table! {
    /// Wheel-slide protection.
    WspSettings {
        /// Braking that the share remembers, s.
        memory_s = 120.0 in 1.0..100000.0;
        /// Watch above this share of the braking time.
        share_watch = 0.25 in 0.0..1.0;
        /// Act above this share of the braking time.
        share_act = 0.75 in 0.0..1.0;
    }
}

table! {
    /// Whether the sensors deliver.
    SensorSettings {
        /// The share is over about so long, s.
        memory_s = 10.0 in 0.5..3600.0;
        /// Watch above this share of values missing or refused.
        faulty_share_watch = 0.02 in 0.0..1.0;
        /// Act above this share of values missing or refused.
        faulty_share_act = 0.20 in 0.0..1.0;
    }
}

table! {
    /// Whether the filter's expectation and the data agree.
    FilterSettings {
        /// The mean is over about so long, s.
        memory_s = 10.0 in 0.5..3600.0;
        /// Watch below this mean normalised innovation squared over its degrees of freedom.
        nis_watch_low = 0.4 in 0.0..1.0;
        /// Watch above it.
        nis_watch_high = 1.8 in 1.0..1000.0;
        /// Act above it.
        nis_act_high = 5.0 in 1.0..1000.0;
        /// Nothing is judged more slowly than this, m/s: creepage loses its meaning as the wagon comes to rest.
        min_speed_m_s = 2.0 in 0.0..20.0;
    }
}

/// All tables of a config's `[indicators]`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IndicatorSettings {
    /// Pad friction.
    pub brake_friction: BrakeFrictionSettings,
    /// Conditions that pad friction is referred to.
    pub standard: StandardSettings,
    /// How fast the brake builds up.
    pub response: ResponseSettings,
    /// Brakes that do not release.
    pub dragging: DraggingSettings,
    /// Brakes that do not brake.
    pub isolated: IsolatedSettings,
    /// What sand does.
    pub sanding: SandingSettings,
    /// Front against rear.
    pub asymmetry: AsymmetrySettings,
    /// Adhesion and rail.
    pub adhesion: AdhesionSettings,
    /// Slides.
    pub slides: SlideSettings,
    /// Wheels that are not round.
    pub wheel_flat: WheelFlatSettings,
    /// Wheel-slide protection.
    pub wsp: WspSettings,
    /// Sensors.
    pub sensors: SensorSettings,
    /// Filter.
    pub filter: FilterSettings,
}

impl IndicatorSettings {
    /// Every setting with what it says, its default and its range, in the order of the tables.
    #[must_use]
    pub fn entries(&self) -> Vec<SettingEntry> {
        [
            self.brake_friction.entries("brake_friction"),
            self.standard.entries("standard"),
            self.response.entries("response"),
            self.dragging.entries("dragging"),
            self.isolated.entries("isolated"),
            self.sanding.entries("sanding"),
            self.asymmetry.entries("asymmetry"),
            self.adhesion.entries("adhesion"),
            self.slides.entries("slides"),
            self.wheel_flat.entries("wheel_flat"),
            self.wsp.entries("wsp"),
            self.sensors.entries("sensors"),
            self.filter.entries("filter"),
        ]
        .concat()
    }

    /// Checks every value, and that act lies beyond watch.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), SettingError> {
        self.wrong().into_iter().next().map_or(Ok(()), Err)
    }

    /// Everything that is out of its range, and each act that does not lie beyond its watch.
    #[must_use]
    pub fn wrong(&self) -> Vec<SettingError> {
        let mut wrong = [
            self.brake_friction.wrong("brake_friction"),
            self.standard.wrong("standard"),
            self.response.wrong("response"),
            self.dragging.wrong("dragging"),
            self.isolated.wrong("isolated"),
            self.sanding.wrong("sanding"),
            self.asymmetry.wrong("asymmetry"),
            self.adhesion.wrong("adhesion"),
            self.slides.wrong("slides"),
            self.wheel_flat.wrong("wheel_flat"),
            self.wsp.wrong("wsp"),
            self.sensors.wrong("sensors"),
            self.filter.wrong("filter"),
        ]
        .concat();
        let friction = &self.brake_friction;
        let pairs = [
            ("brake_friction.ratio_watch_low", friction.ratio_act_low, friction.ratio_watch_low),
            ("brake_friction.ratio_act_high", friction.ratio_watch_high, friction.ratio_act_high),
            ("response.act_s", self.response.watch_s, self.response.act_s),
            ("response.late_act_s", self.response.late_watch_s, self.response.late_act_s),
            ("dragging.act", self.dragging.watch, self.dragging.act),
            ("isolated.act", self.isolated.watch, self.isolated.act),
            ("asymmetry.act", self.asymmetry.watch, self.asymmetry.act),
            ("slides.energy_act_j", self.slides.energy_watch_j, self.slides.energy_act_j),
            ("slides.locked_act_s", self.slides.locked_watch_s, self.slides.locked_act_s),
            ("wheel_flat.variation_act", self.wheel_flat.variation_watch, self.wheel_flat.variation_act),
            ("wsp.share_act", self.wsp.share_watch, self.wsp.share_act),
            ("sensors.faulty_share_act", self.sensors.faulty_share_watch, self.sensors.faulty_share_act),
            ("filter.nis_act_high", self.filter.nis_watch_high, self.filter.nis_act_high),
        ];
        // Of a table with a value out of its range nobody knows where the two were meant to lie.
        let table = |key: &str| key.split('.').next().map(str::to_owned);
        let doubted: Vec<_> = wrong.iter().map(|one| table(&one.key)).collect();
        let crossed = |(key, low, high): &(&str, f64, f64)| low > high && !doubted.contains(&table(key));
        for (key, low, value) in pairs.into_iter().filter(crossed) {
            wrong.push(SettingError { key: key.to_owned(), value, allowed: format!("{low} and more") });
        }
        wrong
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_pass_their_own_check() {
        assert_eq!(IndicatorSettings::default().check(), Ok(()));
    }

    #[test]
    fn a_value_out_of_range_and_crossed_thresholds_are_named() {
        let mut settings = IndicatorSettings::default();
        settings.wsp.share_watch = 1.5;
        assert_eq!(settings.check().unwrap_err().to_string(), "`wsp.share_watch` is 1.5, allowed is 0 to 1");
        settings.wsp.share_watch = 0.9;
        assert_eq!(
            settings.check().unwrap_err().to_string(),
            "`wsp.share_act` is 0.75, allowed is 0.9 and more"
        );
    }
}
