//! One wagon in closed loop.

use crate::ScenarioError;
use crate::disturbance::Disturbance;
use crate::driver::{Demand, Programme};
use crate::fault::Faults;
use crate::pneumatics::{Pneumatics, full_pressing_force_n};
use crate::sample::{WagonSample, WagonTruth};
use crate::scenario::Scenario;
use crate::sensors::{self, Measurand, Sensors};
use crate::track::{Nodes, Track};
use crate::traction::Traction;
use crate::wsp::{CONTROL_PERIOD_S, Valve, WheelSlideProtection};
use railgrip_recording::{Row, TruthRow};
use railgrip_vehicle::effects::Operating;
use railgrip_vehicle::{
    Forces, Loading, MAX_WHEELSETS, PerWheelset, RailClass, VehicleParameters, WagonInput, WagonModel,
    WagonState,
};
use std::sync::Arc;

/// Pressing force below which truth gives no pad friction, N.
const PAD_FRICTION_FORCE_N: f64 = 2e3;

/// Share of full brake pressure above which traction is cut off.
const INTERLOCK_SHARE: f64 = 0.1;

/// Counts of time that all wagons share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Sample period, s.
    pub period_s: f64,
    /// Integration steps in a sample period.
    pub steps: usize,
    /// Integration step, s.
    pub step_s: f64,
}

/// One wagon with everything that acts on it.
#[derive(Clone, Debug)]
pub(crate) struct SimulatedWagon {
    model: WagonModel,
    nominal_wheel_radius_m: f64,
    positions_m: PerWheelset,
    programme: Arc<Programme>,
    traction: Traction,
    headwind_m_s: f64,
    sanding_gain: f64,
    sanding_time_s: f64,
    track: Track,
    near: [Nodes; MAX_WHEELSETS],
    pneumatics: Pneumatics,
    /// Pressing force of pads that do not release; no sensor sees it.
    dragging_force_n: f64,
    wsp: Vec<WheelSlideProtection>,
    disturbance: Disturbance,
    sensors: Sensors,
    faults: Faults,
    pace: Pace,
    control_every: usize,
    steps_to_control: usize,
    start_m: f64,
    position_m: f64,
    state: WagonState,
    acceleration_m_s2: f64,
    hidden: Vec<f64>,
    at: Operating,
    input: WagonInput,
    sanding: f64,
    demand: Demand,
}

impl SimulatedWagon {
    /// Wagon `index` (from 0) of a scenario's train.
    pub fn new(
        scenario: &Scenario,
        programme: &Arc<Programme>,
        vehicle: &VehicleParameters,
        pace: Pace,
        seed: u64,
        index: usize,
    ) -> Result<Self, ScenarioError> {
        let own = scenario.wagon.iter().find(|wagon| wagon.number == index + 1);
        let mut vehicle = vehicle.clone();
        let full_force_n = full_pressing_force_n(&vehicle, scenario.brake.full_service_deceleration_m_s2);
        vehicle.body.mass_kg *= own.map_or(1.0, |own| own.mass_factor);
        let contact = &mut vehicle.contact;
        contact.friction_ratio = scenario.track.friction_ratio.unwrap_or(contact.friction_ratio);
        contact.friction_decay_s_per_m =
            scenario.track.friction_decay_s_per_m.unwrap_or(contact.friction_decay_s_per_m);
        let model = WagonModel::new(&vehicle)?;
        let constants = model.constants();
        let wheelsets = constants.wheelsets;
        let distance_m = index as f64 * scenario.train.wagon_length_m;
        let v_m_s = scenario.start_speed_m_s;
        let mut state = WagonState { v_m_s, ..WagonState::default() };
        for i in 0..wheelsets {
            state.wheel_speed_rad_s[i] = v_m_s / constants.wheel_radius_m[i];
        }
        let mut wsp_table = scenario.wsp.clone();
        wsp_table.enabled &= !own.is_some_and(|own| own.wsp_isolated);
        let pad_factors = own.map(|own| own.pad_friction_factors.as_slice()).unwrap_or_default();
        let factor = own.map_or(1.0, |own| own.adhesion_factor);
        let mut brake = scenario.brake.clone();
        brake.fill_time_s *= own.map_or(1.0, |own| own.fill_time_factor);
        brake.dead_time_s += own.map_or(0.0, |own| own.brake_delay_s);
        let isolated = own.map(|own| own.isolated_wheelsets.as_slice()).unwrap_or_default();
        let mut wagon = Self {
            nominal_wheel_radius_m: vehicle.wheelset.radius_m,
            positions_m: constants.wheelset_positions_m,
            programme: Arc::clone(programme),
            traction: Traction::new(
                &scenario.traction,
                constants.mass_kg,
                vehicle.wheelset.radius_m,
                wheelsets,
            ),
            headwind_m_s: scenario.track.headwind_m_s,
            sanding_gain: scenario.track.sanding_gain,
            sanding_time_s: scenario.track.sanding_time_s,
            near: [Nodes::default(); MAX_WHEELSETS],
            track: Track::new(scenario, &vehicle.rail, factor, seed),
            pneumatics: Pneumatics::new(&brake, &wsp_table, full_force_n, distance_m, isolated),
            dragging_force_n: own.map_or(0.0, |own| own.dragging_force_n),
            wsp: vec![WheelSlideProtection::new(&wsp_table, v_m_s); wheelsets],
            disturbance: Disturbance::new(&scenario.disturbance, pad_factors, pace.period_s, seed, index),
            sensors: Sensors::new(
                &scenario.sensors,
                &vehicle.sensors,
                wheelsets,
                pace.step_s,
                pace.period_s,
                seed,
                index,
            ),
            faults: Faults::new(&scenario.fault, index + 1),
            pace,
            control_every: ((CONTROL_PERIOD_S / pace.step_s).round() as usize).max(1),
            steps_to_control: 0,
            start_m: -distance_m,
            position_m: -distance_m,
            state,
            acceleration_m_s2: 0.0,
            hidden: Vec::new(),
            at: Operating::default(),
            input: WagonInput::default(),
            sanding: 0.0,
            demand: Demand::default(),
            model,
        };
        wagon.gather_input(0.0, 0.0);
        wagon.hidden = wagon.model.start_hidden(&wagon.at, pace.period_s);
        Ok(wagon)
    }

    /// Number of wheelsets.
    pub fn wheelsets(&self) -> usize {
        self.wsp.len()
    }

    /// Rail class under the wagon's middle.
    pub fn rail_class(&self) -> RailClass {
        self.track.class(self.position_m)
    }

    /// Way since the start of the programme, m, and speed, m/s: what couplers see.
    pub fn motion(&self) -> (f64, f64) {
        (self.position_m - self.start_m, self.state.v_m_s)
    }

    /// The train stands again at its start, as a live train's programme repeats.
    pub fn return_to_start(&mut self) {
        self.position_m = self.start_m;
    }

    /// What the sensors say, and the truth, at train time `t_s`; then slow things move on by one sample.
    pub fn sample(&mut self, t_s: f64) -> WagonSample {
        self.gather_input(t_s, 0.0);
        let loading = self.loading();
        let forces = self.model.forces(&self.state, &loading);
        self.model.note_forces(&mut self.at, &forces);
        let truth = self.truth(t_s, &loading, &forces);
        let (row, present) = self.measure(t_s);
        self.model.advance_hidden(&self.at, self.pace.period_s, &mut self.hidden);
        self.disturbance.step();
        WagonSample { row, present, wheelsets: self.wheelsets(), truth }
    }

    fn measure(&mut self, t_s: f64) -> (Row, bool) {
        let observed = self.model.observe(&self.at, self.pace.period_s, &self.hidden);
        let reading = self.sensors.read(&Measurand {
            v_m_s: observed.v_m_s,
            wheel_speed_rad_s: observed.wheel_speed_rad_s,
            pressing_force_n: self.cylinder_force_n(),
        });
        let only_own = |values: PerWheelset| {
            std::array::from_fn(|i| if i < self.wsp.len() { values[i] } else { f64::NAN })
        };
        let mut row = Row {
            t_s,
            v_m_s: reading.v_m_s,
            wheel_speed_rad_s: only_own(reading.wheel_speed_rad_s),
            pressing_force_n: only_own(reading.pressing_force_n),
            drive_torque_nm: only_own(sensors::torques_nm(&self.input.drive_torque_nm)),
            grade_rad: sensors::grade_rad(self.input.grade_rad),
            sanding: self.input.sanding,
            position_m: self.sensors.position_m(self.position_m),
            wsp_active: only_own(self.wsp_active()),
            ..Row::default()
        };
        let present = self.faults.apply(self.programme.time_s(t_s), &mut row);
        (row, present)
    }

    fn wsp_active(&self) -> PerWheelset {
        std::array::from_fn(|i| self.wsp.get(i).map_or(0.0, |wsp| f64::from(wsp.active())))
    }

    fn truth(&self, t_s: f64, loading: &Loading, forces: &Forces) -> WagonTruth {
        let radius_m = self.model.constants().brake_radius_m;
        let pads = |i: usize| {
            let force_n = self.input.pressing_force_n[i];
            if force_n > PAD_FRICTION_FORCE_N {
                loading.brake_torque_nm[i] / (radius_m * force_n)
            } else {
                f64::NAN
            }
        };
        WagonTruth {
            row: TruthRow {
                t_s,
                v_m_s: self.state.v_m_s,
                mu_w: forces.wagon_adhesion_utilised(),
                mu_w_wheelset: std::array::from_fn(|i| forces.adhesion_utilised(i)),
                mu_b: std::array::from_fn(pads),
            },
            position_m: self.position_m,
            wheel_speed_rad_s: self.state.wheel_speed_rad_s,
            pressing_force_n: self.input.pressing_force_n,
            adhesion_available: loading.adhesion_peak,
            normal_load_n: forces.load_n,
            contact_force_n: forces.contact_n,
            resistance_n: forces.resistance_n,
            acceleration_m_s2: forces.acceleration_m_s2,
            rail: self.rail_class(),
        }
    }

    /// Advances by one sample period from train time `t_s` without couplers.
    pub fn advance(&mut self, t_s: f64) {
        for step in 0..self.pace.steps {
            self.step(t_s + step as f64 * self.pace.step_s, 0.0);
        }
    }

    /// One integration step with a force of the couplers on the body.
    pub fn step(&mut self, t_s: f64, coupler_force_n: f64) {
        let step_s = self.pace.step_s;
        self.actuate(t_s);
        self.gather_input(t_s, coupler_force_n);
        let loading = self.loading();
        let before = self.state;
        self.state = self.model.step(&self.state, &loading, step_s, &mut self.acceleration_m_s2);
        self.position_m += 0.5 * (before.v_m_s + self.state.v_m_s) * step_s;
        for i in 0..self.wsp.len() {
            let turned_rad_s = 0.5 * (before.wheel_speed_rad_s[i] + self.state.wheel_speed_rad_s[i]);
            self.at.wheel_angle_rad[i] += turned_rad_s * step_s;
        }
        if self.sensors.remembers() {
            self.sensors.remember(Measurand {
                v_m_s: self.state.v_m_s,
                wheel_speed_rad_s: self.state.wheel_speed_rad_s,
                pressing_force_n: self.cylinder_force_n(),
            });
        }
    }

    /// What the cylinders press, as their sensors see it.
    fn cylinder_force_n(&self) -> PerWheelset {
        std::array::from_fn(|i| if i < self.wsp.len() { self.pneumatics.pressing_force_n(i) } else { 0.0 })
    }

    /// Driver, valves, air, traction and sand over one step.
    fn actuate(&mut self, t_s: f64) {
        let step_s = self.pace.step_s;
        if self.steps_to_control == 0 {
            self.steps_to_control = self.control_every;
            self.control(t_s);
        }
        self.steps_to_control -= 1;
        let valves: [Valve; MAX_WHEELSETS] =
            std::array::from_fn(|i| self.wsp.get(i).map_or(Valve::Apply, WheelSlideProtection::valve));
        self.pneumatics.step(self.demand.brake, &valves[..self.wsp.len()], step_s);
        let interlocked = self.pneumatics.supply_share() > INTERLOCK_SHARE;
        let traction = if interlocked { 0.0 } else { self.demand.traction };
        self.traction.step(traction, self.state.v_m_s, step_s);
        self.sanding += (self.demand.sanding - self.sanding) * step_s / (self.sanding_time_s + step_s);
    }

    /// Wheel-slide and spin protection, and the driver's demand, once a control period.
    fn control(&mut self, t_s: f64) {
        let v_m_s = self.state.v_m_s;
        self.demand = self.programme.demand(t_s, v_m_s);
        self.demand.brake = self.programme.demand(t_s - self.pneumatics.delay_s, v_m_s).brake;
        let period_s = self.control_every as f64 * self.pace.step_s;
        for (i, wsp) in self.wsp.iter_mut().enumerate() {
            let rim_m_s = self.nominal_wheel_radius_m * self.state.wheel_speed_rad_s[i];
            wsp.control(v_m_s, rim_m_s, self.pneumatics.filled(i));
            self.traction.control(i, v_m_s, rim_m_s, period_s);
        }
    }

    fn gather_input(&mut self, t_s: f64, coupler_force_n: f64) {
        let sand = 1.0 + self.sanding_gain * self.sanding;
        let input = &mut self.input;
        input.time_s = t_s;
        input.grade_rad = self.track.grade_rad(self.position_m);
        input.sanding = self.demand.sanding;
        input.position_m = self.position_m;
        input.wind_m_s = self.headwind_m_s + self.disturbance.gust_m_s;
        input.brake_friction_factor = self.disturbance.pad_friction_factor;
        input.body_force_n = coupler_force_n;
        for i in 0..self.wsp.len() {
            input.pressing_force_n[i] = self.pneumatics.pressing_force_n(i).max(self.dragging_force_n);
            input.drive_torque_nm[i] = self.traction.torque_nm(i);
            let place_m = self.position_m + self.positions_m[i];
            input.adhesion_peak[i] = sand * self.track.adhesion(place_m, &mut self.near[i]);
        }
        let at = &mut self.at;
        at.time_s = t_s;
        at.v_m_s = self.state.v_m_s;
        at.position_m = self.position_m;
        at.sanding = input.sanding;
        at.grade_rad = input.grade_rad;
        at.wheel_speed_rad_s = self.state.wheel_speed_rad_s;
        at.pressing_force_n = input.pressing_force_n;
        at.drive_torque_nm = input.drive_torque_nm;
    }

    fn loading(&self) -> Loading {
        self.model.loading(&self.at, &self.input, self.pace.period_s, &self.hidden)
    }
}
