//! The limits that the pages draw beside the figures: those by which the indicators are judged.

use railgrip_indicators::IndicatorSettings;
use railgrip_messages::GRAVITY_M_S2;
use railgrip_settings::{CapabilitySettings, TrainSettings};

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
    pub(crate) const fn free(low: f64, high: f64) -> Self {
        Self { scale: (low, high), act_low: None, watch_low: None, watch_high: None, act_high: None }
    }

    /// The same in another unit.
    fn times(&self, factor: f64) -> Self {
        let of = |end: Option<f64>| end.map(|end| end * factor);
        Self {
            scale: (self.scale.0 * factor, self.scale.1 * factor),
            act_low: of(self.act_low),
            watch_low: of(self.watch_low),
            watch_high: of(self.watch_high),
            act_high: of(self.act_high),
        }
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
    /// Of the time to 90 % of the brake force, s.
    pub response: Limit,
    /// Of the time by which a wagon brakes too late, s.
    pub delay: Limit,
    /// Of the retarding force of released brakes over the weight.
    drag_share: Limit,
    /// Of the share of braking without a brake.
    pub isolated: Limit,
    /// Of the factor by which sand raises adhesion.
    pub sanding: Limit,
    /// Weight of each wagon, N, wagon 1 first.
    weight_n: Vec<f64>,
    /// How indicators are computed and judged.
    pub settings: IndicatorSettings,
    /// What full braking is.
    pub capability: Option<CapabilitySettings>,
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
            response: none,
            delay: none,
            drag_share: none,
            isolated: none,
            sanding: none,
            weight_n: Vec::new(),
            settings: IndicatorSettings::default(),
            capability: None,
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
            response: Limit::above(
                1.3 * indicators.response.act_s,
                indicators.response.watch_s,
                indicators.response.act_s,
            ),
            delay: Limit {
                scale: (-0.5 * indicators.response.late_act_s, 1.3 * indicators.response.late_act_s),
                watch_high: Some(indicators.response.late_watch_s),
                act_high: Some(indicators.response.late_act_s),
                ..Limit::free(0.0, 1.0)
            },
            drag_share: Limit {
                scale: (-0.4 * indicators.dragging.act, 1.6 * indicators.dragging.act),
                watch_high: Some(indicators.dragging.watch),
                act_high: Some(indicators.dragging.act),
                ..Limit::free(0.0, 1.0)
            },
            isolated: Limit::above(1.0, indicators.isolated.watch, indicators.isolated.act),
            sanding: Limit {
                watch_low: Some(indicators.sanding.factor_watch),
                ..Limit::free(0.0, 3.0 * indicators.sanding.factor_watch)
            },
            weight_n: settings.wagons.iter().map(|wagon| wagon.vehicle.body.mass_kg * GRAVITY_M_S2).collect(),
            settings: *indicators,
            capability: Some(settings.capability.clone()),
        }
    }

    /// Of the retarding force of a wagon's released brakes, N.
    pub(crate) fn dragging(&self, wagon: u32) -> Option<Limit> {
        let weight_n = *self.weight_n.get((wagon as usize).checked_sub(1)?)?;
        Some(self.drag_share.times(weight_n))
    }

    /// Of a field of the history.
    pub(crate) fn of_field(&self, wagon: u32, field: &str) -> Option<Limit> {
        match field.rsplit('.').next()? {
            "brake_friction" | "brake_friction_standard" => self.brake_friction(wagon),
            "asymmetry" => Some(self.asymmetry),
            "response" => Some(self.response),
            "dragging" => self.dragging(wagon),
            "isolated" => Some(self.isolated),
            "wsp_share" => Some(self.wsp_share),
            "sensors" => Some(self.sensors),
            "filter" => Some(self.filter),
            _ => None,
        }
    }

    /// Of the pad friction of a wagon.
    pub(crate) fn brake_friction(&self, wagon: u32) -> Option<Limit> {
        let nominal = *self.nominal.get((wagon as usize).checked_sub(1)?)?;
        Some(self.ratio.times(nominal))
    }
}
