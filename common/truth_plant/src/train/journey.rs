//! A train on its day: driver, brake pipe, gear, wheels, couplers and sensors, tick by tick.

use crate::random::{Stream, Wander};

use super::{
    car::{Car, car, motion},
    driver::{Driver, Handles, LOOK_S, View},
    dynamics::Motion,
    family::BrakeLine,
    faults::{ActsOn, Begins, WagonDefects},
    gear::Turning,
    line::LowStretch,
    pipe::Pipe,
    sensors::{Reading, Seen},
    spec::TrainSpec,
    truth::Truth,
};

/// Longest time between two decisions of controllers, s.
const TICK_S: f64 = 0.01;
/// Longest integration step, s.
const STEP_S: f64 = 0.005;
/// Friction that sand gives at least.
const SANDED: f64 = 0.17;

/// A train on its way.
pub struct Journey {
    spec: TrainSpec,
    motion: Motion,
    cars: Vec<Car>,
    driver: Driver,
    handles: Handles,
    pipe: Pipe,
    gust: Wander,
    tick_s: f64,
    steps: usize,
    ticks_per_sample: usize,
    tick: usize,
    onset_s: Option<f64>,
    readings: Vec<Reading>,
    truths: Vec<Truth>,
}

impl Journey {
    /// A train at its first platform.
    #[must_use]
    pub fn new(spec: TrainSpec) -> Self {
        let sample_s = 1.0 / spec.rate_hz;
        let tick_s = sample_s.min(TICK_S);
        let motion = motion(&spec);
        let mut worst = vec![WagonDefects::default(); spec.wagons.len()];
        if let Some(fault) = &spec.fault {
            fault.put(&mut worst);
        }
        let cars = spec.wagons.iter().enumerate();
        let cars: Vec<Car> =
            cars.map(|(index, wagon)| car(&spec, wagon, index, &worst[index], (tick_s, sample_s))).collect();
        let gust_stream = Stream::new(spec.seed, "gust", 0);
        let mut journey = Self {
            driver: Driver::new(spec.driver, Stream::new(spec.seed, "driver", 0)),
            pipe: Pipe::new(&spec, tick_s),
            gust: Wander::new(gust_stream, spec.weather.gust_m_s, 6.0, tick_s),
            tick_s,
            steps: (tick_s / STEP_S).ceil() as usize,
            ticks_per_sample: (sample_s / tick_s).round() as usize,
            tick: 0,
            onset_s: None,
            readings: Vec::with_capacity(cars.len()),
            truths: Vec::with_capacity(cars.len()),
            handles: Handles::default(),
            spec,
            motion,
            cars,
        };
        journey.begin_fault(0.0);
        journey
    }

    /// The train.
    #[must_use]
    pub fn spec(&self) -> &TrainSpec {
        &self.spec
    }

    /// When the fault began, s; none before it has.
    #[must_use]
    pub fn onset_s(&self) -> Option<f64> {
        self.onset_s
    }

    /// The readings of all wagons at the last sample.
    #[must_use]
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// The truth of all wagons at the last sample.
    #[must_use]
    pub fn truths(&self) -> &[Truth] {
        &self.truths
    }

    /// Brake that the driver orders, 0 to 1.
    #[must_use]
    pub fn brake_ordered(&self) -> f64 {
        self.handles.brake
    }

    /// Goes on to the next sample; false at the end of the day.
    pub fn advance(&mut self) -> bool {
        for _ in 0..self.ticks_per_sample {
            if self.tick as f64 * self.tick_s >= self.spec.duration_s {
                return false;
            }
            self.advance_tick();
        }
        true
    }

    fn advance_tick(&mut self) {
        let time_s = self.tick as f64 * self.tick_s;
        self.begin_fault(time_s);
        if self.tick.is_multiple_of((LOOK_S / self.tick_s).round() as usize) {
            let head = &self.motion.bodies[0];
            let view = View {
                time_s,
                head_m: head.position_m,
                v_m_s: head.v_m_s,
                acceleration_m_s2: head.acceleration_m_s2,
            };
            self.handles = self.driver.look(&view, &self.spec.line);
        }
        self.pipe.advance(self.handles.brake);
        self.brake_and_drive(time_s);
        self.meet_the_rail(time_s);
        for _ in 0..self.steps {
            self.motion.step(self.tick_s / self.steps as f64);
        }
        self.follow(time_s);
        if self.tick.is_multiple_of(self.ticks_per_sample) {
            self.read(time_s);
        }
        self.tick += 1;
    }

    /// Puts the fault on the train when its time or place has come.
    fn begin_fault(&mut self, time_s: f64) {
        let Some(fault) = self.spec.fault.filter(|_| self.onset_s.is_none()) else { return };
        let here = match fault.kind.begins {
            Begins::AtDeparture => true,
            Begins::OnTheWay => time_s >= fault.onset_s,
            Begins::AtPlace => {
                let head_m = self.motion.bodies[0].position_m;
                let inside = |low: &LowStretch| (low.from_m..low.to_m).contains(&head_m);
                self.handles.brake > 0.1 && self.spec.soiled.iter().any(inside)
            }
        };
        if here {
            self.onset_s = Some(time_s);
            for wagon in fault.wagons(self.cars.len()) {
                (fault.kind.put)(fault.size, fault.wheelset, &mut self.cars[wagon].defects);
            }
            if fault.kind.acts_on == ActsOn::RearPart {
                self.pipe.shut(fault.wagon);
            }
        }
    }

    fn brake_and_drive(&mut self, time_s: f64) {
        let by_wire = self.spec.brake_line == BrakeLine::Electric;
        for (index, (car, body)) in self.cars.iter_mut().zip(&mut self.motion.bodies).enumerate() {
            let heard = self.pipe.heard(index, car.defects.distributor_s);
            let direct = if self.spec.wagons[index].is_motored() { self.handles.direct } else { 0.0 };
            car.demand = if by_wire { self.handles.brake } else { self.handles.brake.max(direct) };
            let order = heard.max(direct);
            let blended = car.traction.advance(
                (self.handles.traction, order),
                &car.gear,
                body,
                car.protection.active(),
                self.tick_s,
            );
            body.drive_nm = car.traction.torque_nm;
            let turning = Turning {
                wheelsets: body.wheelsets,
                wheel_speed_rad_s: &body.wheel_speed_rad_s,
                radius_m: &body.radius_m,
                braked_nm: &body.braked_nm,
                air_c: self.spec.weather.air_c,
            };
            car.gear.advance(blended, &car.protection, &car.defects, &turning, self.tick_s);
            body.brake_nm = car.gear.capacity_nm;
            let sliding = car.protection.active() && order > 0.0;
            car.sliding_since_s = if sliding { car.sliding_since_s.or(Some(time_s)) } else { None };
            let due = car.sliding_since_s.is_some_and(|since_s| time_s > since_s + 0.5);
            let sander = self.spec.wagons[index].real.sander;
            // Sand goes on until the brake is released or the train has started well.
            let braking = body.v_m_s > 2.0 && order > 0.05 && (due || car.sanding);
            let starting = body.v_m_s < 12.0 && car.traction.wants_sand();
            car.sanding = sander && (braking || starting);
        }
    }

    /// Friction, slope and curve under every wheelset; wheelsets ahead clean and sand the rail for those behind.
    fn meet_the_rail(&mut self, time_s: f64) {
        let (line, weather) = (&self.spec.line, &self.spec.weather);
        let wetness = weather.wet_at(time_s);
        let headwind_m_s = weather.headwind_m_s + self.gust.advance();
        let (mut energy_j_per_m, mut sanded) = (0.0, false);
        for ((body, car), wagon) in self.motion.bodies.iter_mut().zip(&self.cars).zip(&self.spec.wagons) {
            sanded |= car.sanding && !car.defects.sander_empty;
            body.slope_rad = line.grade_rad(body.position_m);
            body.curve = line.curve(body.position_m);
            body.headwind_m_s = headwind_m_s * (body.v_m_s / 3.0).clamp(-1.0, 1.0);
            let (stiffness_n, still_n) = car.stiffness;
            for (k, ahead_m) in wagon.file.positions_m.iter().enumerate() {
                let raw = weather.friction(line, body.position_m + ahead_m, wetness);
                let cleaned = weather.cleaned(raw, energy_j_per_m);
                body.friction[k] = if sanded { cleaned.max(SANDED.min(2.5 * raw)) } else { cleaned };
                body.stiffness_n[k] = stiffness_n * (body.load_n[k] / still_n).max(0.05).cbrt().powi(2);
                energy_j_per_m += (body.contact_n[k] * body.slip_m_s(k)).abs() / body.v_m_s.abs().max(1.0);
            }
        }
    }

    fn follow(&mut self, time_s: f64) {
        for ((car, body), wagon) in self.cars.iter_mut().zip(&self.motion.bodies).zip(&self.spec.wagons) {
            car.sensors.follow(body.v_m_s, &body.wheel_speed_rad_s, &car.defects);
            let rims_m_s = car.sensors.rims_m_s(time_s, wagon.file.radius_m, &car.defects);
            let braking = car.gear.cylinder.iter().any(|share| *share > 0.02);
            car.protection.decide(&rims_m_s[..body.wheelsets], body.v_m_s, braking, self.tick_s);
        }
    }

    fn read(&mut self, time_s: f64) {
        self.readings.clear();
        self.truths.clear();
        let head_m = self.motion.bodies[0].position_m;
        for (index, (car, body)) in self.cars.iter_mut().zip(&self.motion.bodies).enumerate() {
            let seen = Seen {
                time_s,
                cylinder_n: &car.gear.pad_force_n,
                full_force_n: &car.gear.plan.full_force_n,
                drive_nm: &body.drive_nm,
                map_rad: self.spec.line.map_rad(body.position_m),
                sanding: car.sanding,
                position_m: body.position_m,
                mass_kg: body.mass_kg,
                brake_demand: car.demand,
            };
            self.readings.push(car.sensors.read(&seen, &car.defects));
            let coupler_n = self.motion.couplers.get(index).map_or(0.0, |coupler| coupler.force_n);
            self.truths.push(Truth::of(time_s, head_m, coupler_n, body, car));
        }
    }

    #[cfg(test)]
    pub(crate) fn motion(&self) -> &Motion {
        &self.motion
    }
}
