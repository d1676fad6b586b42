//! The limits that the pages draw beside the figures: those by which the indicators are judged.

use railgrip_settings::TrainSettings;

/// From where on a figure is worth a look or needs action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Ends of the scale on which it is drawn.
    pub scale: (f64, f64),
    /// Needs action below.
    pub act_low: Option<f64>,
    /// Worth a look below.
    pub watch_low: Option<f64>,
    /// Worth a look above.
    pub watch_high: Option<f64>,
    /// Needs action above.
    pub act_high: Option<f64>,
}

impl Limit {
    /// A scale without limits.
    pub(super) const fn free(low: f64, high: f64) -> Self {
        Self { scale: (low, high), act_low: None, watch_low: None, watch_high: None, act_high: None }
    }

    const fn above(scale_high: f64, watch: f64, act: f64) -> Self {
        Self { watch_high: Some(watch), act_high: Some(act), ..Self::free(0.0, scale_high) }
    }
}

/// The limits of one train.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Nominal pad friction of each wagon, wagon 1 first.
    nominal: Vec<f64>,
    /// Of pad friction over its nominal value.
    ratio: Limit,
    /// Of the asymmetry.
    pub asymmetry: Limit,
    /// Of the share of braking with slide protection.
    pub wsp_share: Limit,
    /// Of the share of sensor values missing or refused.
    pub sensors: Limit,
    /// Of the mean normalised innovation squared.
    pub filter: Limit,
}

impl Default for Limits {
    /// None: nothing is judged.
    fn default() -> Self {
        let none = Limit::free(0.0, 1.0);
        Self {
            nominal: Vec::new(),
            ratio: none,
            asymmetry: Limit::free(-1.0, 1.0),
            wsp_share: none,
            sensors: none,
            filter: none,
        }
    }
}

impl Limits {
    /// Those of a train.
    #[must_use]
    pub fn of(settings: &TrainSettings) -> Self {
        let indicators = &settings.indicators;
        let friction = &indicators.brake_friction;
        let (watch, act) = (indicators.asymmetry.watch, indicators.asymmetry.act);
        Self {
            nominal: settings.wagons.iter().map(|wagon| wagon.vehicle.brake.friction_coefficient).collect(),
            ratio: Limit {
                scale: (0.4 * friction.ratio_act_low, 1.15 * friction.ratio_act_high),
                act_low: Some(friction.ratio_act_low),
                watch_low: Some(friction.ratio_watch_low),
                watch_high: Some(friction.ratio_watch_high),
                act_high: Some(friction.ratio_act_high),
            },
            asymmetry: Limit {
                scale: (-1.4 * act, 1.4 * act),
                act_low: Some(-act),
                watch_low: Some(-watch),
                watch_high: Some(watch),
                act_high: Some(act),
            },
            wsp_share: Limit::above(1.0, indicators.wsp.share_watch, indicators.wsp.share_act),
            sensors: Limit::above(
                (1.5 * indicators.sensors.faulty_share_act).min(1.0),
                indicators.sensors.faulty_share_watch,
                indicators.sensors.faulty_share_act,
            ),
            filter: Limit {
                watch_low: Some(indicators.filter.nis_watch_low),
                ..Limit::above(
                    1.2 * indicators.filter.nis_act_high,
                    indicators.filter.nis_watch_high,
                    indicators.filter.nis_act_high,
                )
            },
        }
    }

    /// Of the pad friction of a wagon.
    pub(super) fn brake_friction(&self, wagon: u32) -> Option<Limit> {
        let nominal = *self.nominal.get((wagon as usize).checked_sub(1)?)?;
        let of = |ratio: Option<f64>| ratio.map(|ratio| ratio * nominal);
        Some(Limit {
            scale: (self.ratio.scale.0 * nominal, self.ratio.scale.1 * nominal),
            act_low: of(self.ratio.act_low),
            watch_low: of(self.ratio.watch_low),
            watch_high: of(self.ratio.watch_high),
            act_high: of(self.ratio.act_high),
        })
    }
}
