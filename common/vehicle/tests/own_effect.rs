//! An effect of one's own, as the README shows it: a spec, a struct, one law. In the crate it would stand in the file of its
//! term, with the line `(&resistance::TUNNEL, resistance::Tunnel::boxed),` in the table of effects; here it goes into a
//! model without the table.

use railgrip_vehicle::effects::{Effect, EffectSpec, Operating, ParameterSpec, Term, Twin, window_share};
use railgrip_vehicle::{VehicleParameters, WagonInput, WagonModel, WagonState};

/// Air that a tunnel does not let pass.
pub static TUNNEL: EffectSpec = EffectSpec {
    id: "tunnel",
    term: Term::Resistance,
    equation: "F = -k v^2 for x in [x0, x0 + L]",
    source: "general knowledge: 2 to 16 kg/m",
    parameters: &[
        ParameterSpec {
            name: "drag_n_s2_per_m2",
            unit: "N/(m/s)^2",
            lower: 0.0,
            upper: 30.0,
            default: 5.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec { name: "start_m", unit: "m", lower: -1e5, upper: 1e5, ..ParameterSpec::PLAIN },
        ParameterSpec {
            name: "length_m",
            unit: "m",
            lower: 20.0,
            upper: 2e4,
            default: 300.0,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("grade"), Twin::look_alike("headwind")],
    separated_by: "pass the same stretch at two speeds",
};

/// See [`TUNNEL`].
#[derive(Debug)]
pub struct Tunnel {
    drag_n_s2_per_m2: f64,
    start_m: f64,
    length_m: f64,
}

impl Tunnel {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { drag_n_s2_per_m2: values[0], start_m: values[1], length_m: values[2] })
    }
}

impl Effect for Tunnel {
    fn spec(&self) -> &'static EffectSpec {
        &TUNNEL
    }

    fn body_force_n(&self, at: &Operating, _hidden: &[f64], force_n: f64) -> f64 {
        let inside = window_share(at.position_m, self.start_m, self.length_m, 10.0);
        force_n - inside * self.drag_n_s2_per_m2 * at.v_m_s * at.v_m_s.abs()
    }
}

#[test]
fn an_effect_of_ones_own_acts_where_it_says() {
    let vehicle: VehicleParameters =
        toml::from_str(include_str!("../../../config/vehicle.toml")).expect("vehicle");
    let model = WagonModel::with_effects(&vehicle, vec![Tunnel::boxed(&[5.0, 100.0, 300.0])]);
    let radius_m = vehicle.wheelset.radius_m;
    let state = WagonState { v_m_s: 30.0, wheel_speed_rad_s: [30.0 / radius_m; 4] };
    let force_n = |position_m: f64| {
        let input = WagonInput { position_m, adhesion_peak: [0.3; 4], ..WagonInput::default() };
        model.loading(&model.operating(&state, &input), &input, 0.01, &[]).other_n
    };
    let (outside, inside) = (force_n(0.0), force_n(250.0));
    assert!((outside - inside - 5.0 * 900.0).abs() < 1.0, "{outside} outside, {inside} inside");
}
