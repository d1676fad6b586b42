//! The rig in a test: demand, cylinder, slide protection, contact, and what the sensors say.
//!
//! The paper gives speeds, times and adhesion levels; dimensions and the rest are chosen:
//! a trailer wheelset (0.46 m, 110 kg m²) with disc brakes (r_B 0.25 m) under 60 kN on rollers of the same
//! represented mass, pads that grip better as speed falls, and a slide protection that vents, holds and pulses.

pub use super::programme::{SAMPLE_PERIOD_S, Test};

use super::programme::Programme;
use super::protection::{SlideProtection, Valve};
use railgrip_vehicle::brake::{BrakeCylinder, pad_torque_nm};
use railgrip_vehicle::roller_rig::RigParameters;
use railgrip_vehicle::{GRAVITY_M_S2, Loading, MAX_WHEELSETS, WagonInput, WagonModel, WagonState};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Step of the integrator, s.
const STEP_S: f64 = 1e-3;
/// Load of the wheelset, N.
pub const LOAD_N: f64 = 6e4;
/// Mass that the rollers represent: that of the load, as (1) and (2) have it, kg.
pub const MASS_KG: f64 = LOAD_N / GRAVITY_M_S2;
/// Moment of inertia of the wheelset, kg m².
pub const INERTIA_KG_M2: f64 = 110.0;
/// Rolling radius, m.
pub const RADIUS_M: f64 = 0.46;
/// Friction radius, m.
pub const BRAKE_RADIUS_M: f64 = 0.25;
/// Time by which the pads of a rig follow the measured pressing force late, s: the filter does not know of it.
pub const PAD_LAG_S: f64 = 0.04;
/// The same of a train in service, whose pressing force is inferred from a pressure far from the pads.
pub const SERVICE_PAD_LAG_S: f64 = 0.15;
/// Inertia in the filter's model over that of the rig.
pub const INERTIA_ERROR: f64 = 1.05;
/// Pad friction that the filter starts from.
pub const NOMINAL_PAD_FRICTION: f64 = 0.35;

/// Accuracy of the rig's sensors, one sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigSensors {
    /// Speed of the wheelset, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Speed of the roller's rim, m/s.
    pub speed_m_s: f64,
    /// Pressing force, N.
    pub pressing_force_n: f64,
    /// Time by which the pads follow the measured pressing force late, s.
    pub pad_lag_s: f64,
}

impl RigSensors {
    /// A rig's encoders: the wheelset as R of (20) says, the roller three times better than its R says.
    pub const RIG: Self =
        Self { wheel_speed_rad_s: 3.2e-5, speed_m_s: 1e-4, pressing_force_n: 20.0, pad_lag_s: PAD_LAG_S };
    /// What a train in service has (the sensors of the product's default vehicle).
    pub const SERVICE: Self = Self {
        wheel_speed_rad_s: 0.03,
        speed_m_s: 0.03,
        pressing_force_n: 150.0,
        pad_lag_s: SERVICE_PAD_LAG_S,
    };
}

/// One sample of a test with its truth.
#[derive(Clone, Copy, Debug)]
pub struct RigSample {
    /// Time, s.
    pub time_s: f64,
    /// Measured ω_W, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Measured v_x, m/s.
    pub v_m_s: f64,
    /// v_x in truth, m/s.
    pub v_true_m_s: f64,
    /// Measured F_⊥, N.
    pub pressing_force_n: f64,
    /// Force of the roller's drive on the represented mass, N; known.
    pub roller_force_n: f64,
    /// Adhesion utilised in truth, signed (what the load cells of the rig give).
    pub adhesion: f64,
    /// Pad friction in truth.
    pub pad_friction: f64,
    /// Creepage in truth.
    pub creepage: f64,
    /// True while the slide protection holds or vents.
    pub wsp_active: bool,
    /// True from a release of pressing force until the wheelset rolls again.
    pub reversing: bool,
}

/// Pads grip better as the disc slows down, and a little better as it warms up.
fn pad_friction(rim_speed_m_s: f64, heat_j: f64) -> f64 {
    0.31 + 0.07 * (-rim_speed_m_s / 12.0).exp() + 0.02 * (heat_j / 2e6).min(1.0)
}

/// Slow random variation of the adhesion available: first order, seeded.
struct Variation {
    random: Pcg64Mcg,
    value: f64,
}

impl Variation {
    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// Relative variation with a time constant of 0.5 s and a sigma of 6 %.
    fn advance(&mut self) -> f64 {
        let kept = (-SAMPLE_PERIOD_S / 0.5f64).exp();
        self.value = self.value * kept + 0.06 * (1.0 - kept * kept).sqrt() * self.normal();
        self.value.clamp(-0.2, 0.2)
    }
}

/// Cylinder of the rig: small, hence quick.
const CYLINDER: BrakeCylinder = BrakeCylinder {
    fill_time_s: 0.25,
    vent_time_s: 0.08,
    full_pressure_pa: 3.8e5,
    full_pressing_force_n: 3.2e4,
    spring_pressure_pa: 2e4,
};

/// Speed at which a test ends, m/s.
const END_SPEED_M_S: f64 = 0.8;

/// The rig in motion.
struct Rig {
    test: Test,
    programme: Programme,
    model: WagonModel,
    sensors: RigSensors,
    rail: Variation,
    noise: Variation,
    protection: SlideProtection,
    state: WagonState,
    acceleration_m_s2: f64,
    pressure_pa: f64,
    pad_force_n: f64,
    heat_j: f64,
    reversing: bool,
}

/// What holds over one sample period.
struct Period {
    target_pa: f64,
    friction: f64,
    peak: f64,
}

impl Rig {
    fn new(test: Test, seed: u64, sensors: RigSensors) -> Self {
        let programme = test.programme();
        let start = programme.start_speed_m_s;
        Self {
            test,
            model: parameters(&programme).model(),
            sensors,
            rail: Variation { random: Pcg64Mcg::seed_from_u64(seed), value: 0.0 },
            noise: Variation { random: Pcg64Mcg::seed_from_u64(seed ^ 0x5eed), value: 0.0 },
            protection: SlideProtection::new(start),
            state: WagonState { v_m_s: start, wheel_speed_rad_s: [start / RADIUS_M, 0.0, 0.0, 0.0] },
            programme,
            acceleration_m_s2: 0.0,
            pressure_pa: 0.0,
            pad_force_n: 0.0,
            heat_j: 0.0,
            reversing: false,
        }
    }

    /// The sample at a time; the rig moves on to the next.
    fn next_sample(&mut self, time_s: f64) -> RigSample {
        let demand_pa = self.programme.demand_at(time_s) * CYLINDER.full_pressure_pa;
        let rim = RADIUS_M * self.state.wheel_speed_rad_s[0];
        let filled = if demand_pa > 0.0 { self.pressure_pa / demand_pa } else { 1.0 };
        let valve = self.protection.control(&self.programme, self.state.v_m_s, rim, filled);
        let period = Period {
            target_pa: match valve {
                Valve::Apply => demand_pa,
                Valve::Hold => self.pressure_pa.min(demand_pa),
                Valve::Vent => 0.0,
            },
            peak: self.test.adhesion_peak(time_s) * (1.0 + self.rail.advance()),
            friction: pad_friction(rim, self.heat_j),
        };
        let sample = self.measure(time_s, &period, valve != Valve::Apply || self.protection.acting());
        for _ in 0..(SAMPLE_PERIOD_S / STEP_S).round() as usize {
            self.advance(&period);
        }
        sample
    }

    fn measure(&mut self, time_s: f64, period: &Period, wsp_active: bool) -> RigSample {
        let adhesion = self.model.forces(&self.state, &self.loading(period)).adhesion_utilised(0);
        let (omega, v) = (self.state.wheel_speed_rad_s[0], self.state.v_m_s);
        let creepage = railgrip_vehicle::creepage(RADIUS_M * omega, v);
        let releases = period.target_pa < self.pressure_pa - 1e3 && creepage < -0.03;
        self.reversing = releases || self.reversing && creepage < -0.01;
        let force_n = CYLINDER.pressing_force_n(self.pressure_pa);
        let (sensors, noise) = (&self.sensors, &mut self.noise);
        RigSample {
            time_s,
            wheel_speed_rad_s: omega + sensors.wheel_speed_rad_s * noise.normal(),
            v_m_s: v + sensors.speed_m_s * noise.normal(),
            v_true_m_s: v,
            pressing_force_n: (force_n + sensors.pressing_force_n * noise.normal()).max(0.0),
            roller_force_n: 0.0,
            adhesion,
            pad_friction: period.friction,
            creepage,
            wsp_active,
            reversing: self.reversing,
        }
    }

    fn advance(&mut self, period: &Period) {
        self.pressure_pa = CYLINDER.step(self.pressure_pa, period.target_pa, STEP_S);
        let force_n = CYLINDER.pressing_force_n(self.pressure_pa);
        self.pad_force_n += (force_n - self.pad_force_n) * (STEP_S / self.sensors.pad_lag_s);
        let loading = self.loading(period);
        self.state = self.model.step(&self.state, &loading, STEP_S, &mut self.acceleration_m_s2);
        let torque_nm = pad_torque_nm(period.friction, self.pad_force_n, BRAKE_RADIUS_M);
        self.heat_j += torque_nm * self.state.wheel_speed_rad_s[0] * STEP_S;
    }

    fn loading(&self, period: &Period) -> Loading {
        let input = input(self.pad_force_n, period.friction, period.peak);
        self.model.loading(&self.model.operating(&self.state, &input), &input, STEP_S, &[])
    }
}

/// Runs a test with seeded rail and sensor noise, until the rig stands.
pub fn simulate(test: Test, seed: u64, sensors: RigSensors) -> Vec<RigSample> {
    let mut rig = Rig::new(test, seed, sensors);
    let mut samples = Vec::new();
    for k in 0..(rig.programme.duration_s / SAMPLE_PERIOD_S) as usize {
        samples.push(rig.next_sample(k as f64 * SAMPLE_PERIOD_S));
        if rig.state.v_m_s < END_SPEED_M_S {
            break;
        }
    }
    samples
}

fn input(force_n: f64, friction: f64, peak: f64) -> WagonInput {
    WagonInput {
        pressing_force_n: [force_n, 0.0, 0.0, 0.0],
        adhesion_peak: [peak; MAX_WHEELSETS],
        brake_friction_factor: [friction / NOMINAL_PAD_FRICTION; MAX_WHEELSETS],
        ..WagonInput::default()
    }
}

fn parameters(programme: &Programme) -> RigParameters {
    RigParameters {
        wheel_radius_m: RADIUS_M,
        inertia_kg_m2: INERTIA_KG_M2,
        brake_radius_m: BRAKE_RADIUS_M,
        brake_friction: NOMINAL_PAD_FRICTION,
        load_n: LOAD_N,
        equivalent_mass_kg: MASS_KG,
        contact: programme.contact.clone(),
    }
}

/// The rig's model as a filter knows it: with an inertia somewhat off.
pub fn nominal_model(test: Test) -> WagonModel {
    let mut parameters = parameters(&test.programme());
    parameters.inertia_kg_m2 *= INERTIA_ERROR;
    parameters.model()
}
