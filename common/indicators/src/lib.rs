//! railgrip indicators.
mod settings;

pub use settings::{
    AdhesionSettings, AsymmetrySettings, BrakeFrictionSettings, FilterSettings, IndicatorSettings,
    SensorSettings, SettingError, SlideSettings, WspSettings,
};
