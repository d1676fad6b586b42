//! Effects with delay lines under samples that come a little early or late, twice as often, and after a hole.

use railgrip_filter::{EstimatorConfig, WagonEstimator, WagonSample};
use railgrip_vehicle::{EffectEntry, VehicleParameters};

#[test]
fn delay_lines_take_any_step_of_time() {
    let text = "schema = 1\nname = \"x\"\n[body]\nmass_kg = 40000.0\ncom_height_m = 1.6\nwheelbase_m = 10.0\n\
         [wheelset]\nradius_m = 0.45\ninertia_kg_m2 = 200.0\n[brake]\nradius_m = 0.25\nfriction_coefficient = 0.35\n\
         [resistance]\nconstant_n = 400.0\nlinear_n_s_per_m = 8.0\ndrag_n_s2_per_m2 = 4.0\n\
         [contact]\nstiffness_n = 6.0e6\nk_a = 1.0\nk_s = 0.4\n[rail]\ndry = 0.3\nwet = 0.12\nlow = 0.06\n\
         [sensors]\nsample_rate_hz = 100.0\nspeed_sigma_m_s = 0.03\nwheel_speed_sigma_rad_s = 0.03\n\
         pressing_force_sigma_n = 150.0\n";
    for id in ["brake_lag", "wheel_encoder_window", "clock_skew", "speed_latency"] {
        let mut vehicle: VehicleParameters = toml::from_str(text).expect("vehicle");
        vehicle.effects.push(EffectEntry { id: id.into(), parameters: Default::default() });
        for step_s in [0.01, 0.01 + 1e-9, 0.01 - 1e-9, 0.0103, 0.005, 0.02] {
            let mut estimator =
                WagonEstimator::new(&EstimatorConfig::default(), &vehicle).expect("estimator");
            let mut time_s = 0.0;
            for k in 0..400 {
                time_s += if k == 200 { 0.4 } else { step_s };
                let v_m_s = 20.0 - 0.5 * time_s;
                let input = WagonSample {
                    v_m_s,
                    wheel_speed_rad_s: [v_m_s / 0.45, v_m_s / 0.45, f64::NAN, f64::NAN],
                    pressing_force_n: [2e4, 2e4, f64::NAN, f64::NAN],
                    drive_torque_nm: [0.0; 4],
                    ..WagonSample::missing(time_s)
                };
                let estimate = estimator.step(&input);
                assert!(
                    estimate.v_m_s.is_finite() && estimate.mu_w.is_finite(),
                    "{id}, step {step_s}, sample {k}"
                );
            }
        }
    }
}
