//! The rig in a test: demand, cylinder, slide protection, contact, and what the sensors say.
//!
//! The paper gives speeds, times and adhesion levels; dimensions and the rest are chosen:
//! a trailer wheelset (0.46 m, 110 kg m²) with disc brakes (r_B 0.25 m) under 60 kN on rollers of the same
//! represented mass, pads that grip better as speed falls, and a slide protection that vents, holds and pulses.

use railgrip_vehicle::brake::BrakeCylinder;
use railgrip_vehicle::roller_rig::RigParameters;
use railgrip_vehicle::{Contact, GRAVITY_M_S2, MAX_WHEELSETS, WagonInput, WagonModel, WagonState};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Step of the integrator, s.
const STEP_S: f64 = 1e-3;
/// Period of samples and of the slide protection, s.
pub const SAMPLE_PERIOD_S: f64 = 5e-3;
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

/// One of the two tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Test {
    /// Fig. 4: from 120 km/h, three short applications, then the stop under near-continuous slide protection.
    SlideProtection,
    /// Figs. 5 and 6: from 200 km/h with sand.
    Sanding,
}

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
    /// The same from a second sensor with noise of its own, rad/s.
    pub second_wheel_speed_rad_s: f64,
    /// Measured v_x, m/s.
    pub v_m_s: f64,
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

/// Time course of what the operator asks for and what lies on the rollers.
struct Programme {
    start_speed_m_s: f64,
    duration_s: f64,
    /// Demand as a share of full braking over time, held until the next entry.
    demand: &'static [(f64, f64)],
    /// Slip beyond which the protection vents and holds.
    vent_slip: f64,
    hold_slip: f64,
    /// Apply pulse and pause, s.
    pulse_s: (f64, f64),
    contact: Contact,
}

impl Test {
    fn programme(self) -> Programme {
        let contact = |friction_ratio, friction_decay_s_per_m| Contact {
            stiffness_n: 6e6,
            k_a: 1.0,
            k_s: 0.4,
            friction_ratio,
            friction_decay_s_per_m,
        };
        match self {
            Self::SlideProtection => Programme {
                start_speed_m_s: 120.0 / 3.6,
                duration_s: 135.0,
                demand: &[
                    (18.0, 0.30),
                    (20.5, 0.0),
                    (24.0, 0.30),
                    (26.5, 0.0),
                    (30.5, 0.30),
                    (33.0, 0.0),
                    (42.0, 1.0),
                ],
                vent_slip: 0.22,
                hold_slip: 0.10,
                pulse_s: (0.08, 0.18),
                contact: contact(0.4, 0.2),
            },
            Self::Sanding => Programme {
                start_speed_m_s: 200.0 / 3.6,
                duration_s: 140.0,
                demand: &[
                    (3.5, 1.4),
                    (6.3, 0.0),
                    (12.0, 0.60),
                    (19.0, 0.75),
                    (24.0, 0.45),
                    (30.0, 1.25),
                    (37.0, 0.80),
                    (52.0, 1.0),
                ],
                vent_slip: 0.45,
                hold_slip: 0.30,
                pulse_s: (0.3, 0.3),
                contact: contact(0.35, 0.15),
            },
        }
    }

    /// Adhesion available at a time, before slow random variation.
    fn adhesion_peak(self, time_s: f64) -> f64 {
        let towards = |from: f64, to: f64, start_s: f64, length_s: f64| {
            from + (to - from) * ((time_s - start_s) / length_s).clamp(0.0, 1.0)
        };
        match self {
            // Water and soap, running dry towards the end.
            Self::SlideProtection => towards(0.050, 0.12, 108.0, 6.0),
            Self::Sanding => 0.106,
        }
    }
}

/// Pads grip better as the disc slows down, and a little better as it warms up.
fn pad_friction(rim_speed_m_s: f64, heat_j: f64) -> f64 {
    0.31 + 0.07 * (-rim_speed_m_s / 12.0).exp() + 0.02 * (heat_j / 2e6).min(1.0)
}

/// Slide protection of the rig: vents when slip is large and still grows, holds when it is moderate, gives pressure
/// back in pulses.
#[derive(Clone, Copy, Debug, Default)]
struct SlideProtection {
    last_rim_m_s: f64,
    rim_acceleration_m_s2: f64,
    since_pulse_s: f64,
    acting: bool,
}

/// What its valve does.
#[derive(Clone, Copy, PartialEq)]
enum Valve {
    Apply,
    Hold,
    Vent,
}

impl SlideProtection {
    fn control(&mut self, programme: &Programme, v_m_s: f64, rim_m_s: f64, filled: f64) -> Valve {
        let raw = (rim_m_s - self.last_rim_m_s) / SAMPLE_PERIOD_S;
        self.last_rim_m_s = rim_m_s;
        self.rim_acceleration_m_s2 += 0.2 * (raw - self.rim_acceleration_m_s2);
        self.since_pulse_s += SAMPLE_PERIOD_S;
        if v_m_s < 1.5 {
            self.acting = false;
            return Valve::Apply;
        }
        let slip = (v_m_s - rim_m_s) / v_m_s;
        if slip > programme.vent_slip && self.rim_acceleration_m_s2 < 0.5 {
            self.acting = true;
            return Valve::Vent;
        }
        if slip > programme.hold_slip {
            self.acting = true;
            return Valve::Hold;
        }
        if !self.acting {
            return Valve::Apply;
        }
        self.acting = filled < 0.95;
        let (pulse_s, pause_s) = programme.pulse_s;
        self.since_pulse_s %= pulse_s + pause_s;
        if self.since_pulse_s < pulse_s { Valve::Apply } else { Valve::Hold }
    }
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

/// Runs a test with seeded rail and sensor noise.
pub fn simulate(test: Test, seed: u64, sensors: RigSensors) -> Vec<RigSample> {
    let programme = test.programme();
    let parameters = parameters(&programme);
    let model = parameters.model();
    let radius = parameters.wheel_radius_m;
    let cylinder = BrakeCylinder {
        fill_time_s: 0.25,
        vent_time_s: 0.08,
        full_pressure_pa: 3.8e5,
        full_pressing_force_n: 3.2e4,
        spring_pressure_pa: 2e4,
    };
    let mut rail = Variation { random: Pcg64Mcg::seed_from_u64(seed), value: 0.0 };
    let mut noise = Variation { random: Pcg64Mcg::seed_from_u64(seed ^ 0x5eed), value: 0.0 };
    let mut protection =
        SlideProtection { last_rim_m_s: programme.start_speed_m_s, ..SlideProtection::default() };
    let start = programme.start_speed_m_s;
    let mut state = WagonState { v_m_s: start, wheel_speed_rad_s: [start / radius, 0.0, 0.0, 0.0] };
    let (mut pressure_pa, mut pad_force_n, mut acceleration, mut heat_j) = (0.0, 0.0, 0.0, 0.0);
    let mut releasing = false;
    let mut samples = Vec::new();
    for k in 0..(programme.duration_s / SAMPLE_PERIOD_S) as usize {
        let time_s = k as f64 * SAMPLE_PERIOD_S;
        let demand =
            programme.demand.iter().rev().find(|(from, _)| time_s >= *from).map_or(0.0, |(_, share)| *share);
        let demand_pa = demand * cylinder.full_pressure_pa;
        let rim = radius * state.wheel_speed_rad_s[0];
        let filled = if demand_pa > 0.0 { pressure_pa / demand_pa } else { 1.0 };
        let valve = protection.control(&programme, state.v_m_s, rim, filled);
        let target_pa = match valve {
            Valve::Apply => demand_pa,
            Valve::Hold => pressure_pa.min(demand_pa),
            Valve::Vent => 0.0,
        };
        let peak = test.adhesion_peak(time_s) * (1.0 + rail.advance());
        let friction = pad_friction(rim, heat_j);
        let force_n = cylinder.pressing_force_n(pressure_pa);
        let input = input(pad_force_n, friction, peak);
        let forces =
            model.forces(&state, &model.loading(&model.operating(&state, &input), &input, STEP_S, &[]));
        let creepage = railgrip_vehicle::creepage(rim, state.v_m_s);
        releasing = target_pa < pressure_pa - 1e3 && creepage < -0.03 || releasing && creepage < -0.01;
        samples.push(RigSample {
            time_s,
            wheel_speed_rad_s: state.wheel_speed_rad_s[0] + sensors.wheel_speed_rad_s * noise.normal(),
            second_wheel_speed_rad_s: state.wheel_speed_rad_s[0] + sensors.wheel_speed_rad_s * noise.normal(),
            v_m_s: state.v_m_s + sensors.speed_m_s * noise.normal(),
            pressing_force_n: (force_n + sensors.pressing_force_n * noise.normal()).max(0.0),
            roller_force_n: 0.0,
            adhesion: forces.adhesion_utilised(0),
            pad_friction: friction,
            creepage,
            wsp_active: valve != Valve::Apply || protection.acting,
            reversing: releasing,
        });
        for _ in 0..(SAMPLE_PERIOD_S / STEP_S).round() as usize {
            pressure_pa = cylinder.step(pressure_pa, target_pa, STEP_S);
            pad_force_n +=
                (cylinder.pressing_force_n(pressure_pa) - pad_force_n) * (STEP_S / sensors.pad_lag_s);
            let input = self::input(pad_force_n, friction, peak);
            let loading = model.loading(&model.operating(&state, &input), &input, STEP_S, &[]);
            state = model.step(&state, &loading, STEP_S, &mut acceleration);
            heat_j +=
                friction * pad_force_n * parameters.brake_radius_m * state.wheel_speed_rad_s[0] * STEP_S;
        }
        if state.v_m_s < 0.8 {
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
