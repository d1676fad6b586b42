//! A train put together from its spec: bodies at rest, and each wagon's gear, controllers and sensors.

use super::{
    dynamics::{Body, Coupler, Motion},
    faults::WagonDefects,
    gear::Gear,
    line::START_M,
    pitch::Pitch,
    protection::Protection,
    sensors::Sensors,
    spec::TrainSpec,
    traction::Traction,
    units::{GRAVITY_M_S2, PerWheelset},
    wagon::Wagon,
};

/// One wagon at work, beside its body in [`Motion`].
pub(crate) struct Car {
    pub(crate) gear: Gear,
    pub(crate) protection: Protection,
    pub(crate) traction: Traction,
    pub(crate) sensors: Sensors,
    pub(crate) defects: WagonDefects,
    pub(crate) sliding_since_s: Option<f64>,
    pub(crate) sanding: bool,
    pub(crate) demand: f64,
    /// Contact stiffness at the load of standstill, N, and that load, N.
    pub(crate) stiffness: (f64, f64),
}

/// Bodies at rest, stretched out with the head at its starting place.
pub(crate) fn motion(spec: &TrainSpec) -> Motion {
    let mut position_m = START_M;
    let mut bodies: Vec<Body> = Vec::with_capacity(spec.wagons.len());
    for (index, wagon) in spec.wagons.iter().enumerate() {
        if index > 0 {
            position_m -= 0.5 * (spec.wagons[index - 1].real.length_m + wagon.real.length_m);
        }
        bodies.push(body(spec, wagon, position_m));
    }
    let couplers = spec.couplers.iter().map(|gear| Coupler { gear: *gear, extension_m: 0.0, force_n: 0.0 });
    bodies.iter_mut().for_each(|body| body.load_n = standing(body));
    Motion::new(bodies, couplers.collect())
}

fn body(spec: &TrainSpec, wagon: &Wagon, position_m: f64) -> Body {
    let real = &wagon.real;
    let heights_m = (real.body_height_m, real.coupler_height_m);
    Body {
        wheelsets: wagon.wheelsets(),
        mass_kg: real.mass_kg,
        radius_m: real.radius_m,
        inertia_kg_m2: real.inertia_kg_m2,
        resistance: real.resistance,
        law: spec.law,
        pitch: Pitch::new(real.mass_kg, heights_m, wagon.file.wheelbase_m, real.bogies, real.pitching),
        v_m_s: 0.0,
        position_m,
        wheel_speed_rad_s: [0.0; 4],
        load_n: [0.0; 4],
        drive_nm: [0.0; 4],
        brake_nm: [0.0; 4],
        friction: [spec.weather.dry; 4],
        stiffness_n: [real.stiffness_n; 4],
        slope_rad: 0.0,
        curve: 0.0,
        headwind_m_s: 0.0,
        contact_n: [0.0; 4],
        braked_nm: [0.0; 4],
        outer_n: 0.0,
        acceleration_m_s2: 0.0,
        turn_rad_s: [0.0; 4],
    }
}

/// Wheel loads at rest, N.
fn standing(body: &Body) -> PerWheelset {
    let share_n = body.mass_kg * GRAVITY_M_S2 / body.wheelsets as f64;
    std::array::from_fn(|k| if k < body.wheelsets { share_n } else { 0.0 })
}

pub(crate) fn car(
    spec: &TrainSpec,
    wagon: &Wagon,
    index: usize,
    worst: &WagonDefects,
    times_s: (f64, f64),
) -> Car {
    let (seed, wheelsets) = (spec.seed, wagon.wheelsets());
    let real = &wagon.real;
    let believed_n = wagon.file.mass_kg * GRAVITY_M_S2 / wheelsets as f64;
    Car {
        gear: Gear::new(real.gear, seed, index, spec.weather.air_c, times_s.0),
        protection: Protection::new(real.protection),
        traction: Traction::new(real.traction, wheelsets),
        sensors: Sensors::new(wagon.sensors, wheelsets, worst, (seed, index), times_s),
        defects: WagonDefects::default(),
        sliding_since_s: None,
        sanding: false,
        demand: 0.0,
        stiffness: (real.stiffness_n, believed_n),
    }
}
