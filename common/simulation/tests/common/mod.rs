//! A coach and scenarios for the tests.

use railgrip_simulation::{Scenario, Train, WagonSample};
use railgrip_vehicle::{Body, Brake, Contact, Rail, Resistance, Sensors, VehicleParameters, Wheelset};
use std::path::Path;

pub fn coach() -> VehicleParameters {
    VehicleParameters {
        schema: 1,
        name: "coach".into(),
        body: Body {
            mass_kg: 41e3,
            com_height_m: 1.6,
            wheelbase_m: 12.0,
            wheelset_positions_m: None,
            mass_sigma: None,
        },
        wheelset: Wheelset { radius_m: 0.45, inertia_kg_m2: 140.0 },
        brake: Brake { radius_m: 0.25, friction_coefficient: 0.35, friction_by_wheelset: None },
        resistance: Resistance { constant_n: 400.0, linear_n_s_per_m: 8.0, drag_n_s2_per_m2: 4.0 },
        contact: Contact {
            stiffness_n: 6.5e6,
            k_a: 1.0,
            k_s: 0.4,
            friction_ratio: 1.0,
            friction_decay_s_per_m: 0.0,
        },
        rail: Rail { dry: 0.3, wet: 0.12, low: 0.05 },
        sensors: Sensors {
            sample_rate_hz: 100.0,
            speed_sigma_m_s: 0.03,
            wheel_speed_sigma_rad_s: 0.04,
            pressing_force_sigma_n: 150.0,
        },
        bogie: None,
        train: None,
        effects: Vec::new(),
    }
}

/// A scenario of these lines on top of name, length, start speed and number of wagons.
pub fn scenario(duration_s: f64, start_speed_m_s: f64, wagons: usize, lines: &str) -> Scenario {
    let text = format!(
        "schema = 1\nname = \"test\"\nduration_s = {duration_s:?}\nstart_speed_m_s = {start_speed_m_s:?}\n{}\n[train]\nwagons = {wagons}\n{}",
        if lines.contains("repeat") { "repeat_s = 30.0" } else { "" },
        lines.replace("repeat", "")
    );
    Scenario::parse(Path::new("test.toml"), &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// All samples of one wagon (from 0) of a train of coaches.
pub fn samples(scenario: &Scenario, seed: u64, wagon: usize) -> Vec<WagonSample> {
    let mut train = Train::new(scenario, &vec![coach(); scenario.train.wagons], seed, None).expect("a train");
    let count = (scenario.duration_s / train.sample_period_s()).round() as usize;
    (0..count).map(|_| train.step().wagons[wagon]).collect()
}
