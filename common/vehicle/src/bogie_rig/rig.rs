//! The rig as one machine, and the integrator that copes with its stiff contacts.
//!
//! A contact that rolls settles within a millisecond or less, the rollers within tens. A step is implicit in the slip
//! velocities (L-stable Euler) and linear in the speeds: an outer iteration for the sum of forces, which moves the
//! heavy rollers little, and one scalar equation a wheelset, solved by safeguarded Newton.

use super::{BOGIE_WHEELSETS, BogieParameters, ContactLaw};

/// Largest creep force over Q μ0 that Polach's law can give: 2/π (½ + π/2).
const SATURATION_MAX: f64 = 1.32;

/// Motion of the rig.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BogieRigState {
    /// ω_r, rad/s.
    pub roller_speed_rad_s: f64,
    /// ω_w of each wheelset, rad/s.
    pub wheel_speed_rad_s: [f64; BOGIE_WHEELSETS],
    /// Angle of the rollers, rad.
    pub roller_angle_rad: f64,
    /// Angle of each wheelset, rad.
    pub wheel_angle_rad: [f64; BOGIE_WHEELSETS],
}

/// What happened over one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BogieRigStep {
    /// Motion at its end.
    pub state: BogieRigState,
    /// Contact forces on the bogie, N; negative in braking.
    pub force_n: [f64; BOGIE_WHEELSETS],
    /// T_e at the transducer, N m.
    pub shaft_torque_nm: f64,
    /// ω̇_r, rad/s².
    pub roller_acceleration_rad_s2: f64,
}

impl BogieRigStep {
    /// What the link carries, N; positive in braking.
    pub fn link_force_n(&self) -> f64 {
        -self.force_n.iter().sum::<f64>()
    }

    /// Adhesion utilised by the bogie under its load, signed: negative in braking.
    pub fn mu_w(&self, parameters: &BogieParameters) -> f64 {
        let load_n = parameters.load_n();
        if load_n > 0.0 { -self.link_force_n() / load_n } else { 0.0 }
    }
}

/// The rig.
#[derive(Clone, Debug, PartialEq)]
pub struct BogieRig {
    /// Its constants.
    pub parameters: BogieParameters,
}

impl BogieRig {
    /// The rig with these constants.
    pub fn new(parameters: BogieParameters) -> Self {
        Self { parameters }
    }

    /// Wheelsets rolling without slip at a speed of the rollers' rim.
    pub fn rolling(&self, v_m_s: f64) -> BogieRigState {
        BogieRigState {
            roller_speed_rad_s: v_m_s / self.parameters.roller_radius_m,
            wheel_speed_rad_s: [v_m_s / self.parameters.wheel_radius_m; BOGIE_WHEELSETS],
            ..BogieRigState::default()
        }
    }

    /// Speed of the rollers' rim v, m/s.
    pub fn v_m_s(&self, state: &BogieRigState) -> f64 {
        self.parameters.roller_radius_m * state.roller_speed_rad_s
    }

    /// Slip λ (2) of each wheelset; 0 at standstill.
    pub fn slip(&self, state: &BogieRigState) -> [f64; BOGIE_WHEELSETS] {
        let v = self.v_m_s(state);
        state
            .wheel_speed_rad_s
            .map(|speed| if v > 1e-3 { (v - self.parameters.wheel_radius_m * speed) / v } else { 0.0 })
    }

    /// Motion after `dt_s` under a motor torque and brake torques; `level` scales the law's friction under each wheelset.
    pub fn step(
        &self,
        state: &BogieRigState,
        motor_torque_nm: f64,
        brake_torque_nm: [f64; BOGIE_WHEELSETS],
        law: &ContactLaw,
        level: [f64; BOGIE_WHEELSETS],
        dt_s: f64,
    ) -> BogieRigStep {
        let p = &self.parameters;
        let total_inertia = p.inertia_beyond_motor_kg_m2();
        let free_torque = p.gear_ratio * motor_torque_nm - p.loss_at_nm(state.roller_speed_rad_s);
        let mut step = BogieRigStep { state: *state, ..BogieRigStep::default() };
        // Forces at the slip of the start: near enough that two or three rounds settle.
        let v = p.roller_radius_m * state.roller_speed_rad_s;
        let mut sum_n: f64 = (0..BOGIE_WHEELSETS)
            .map(|i| {
                let slip = p.wheel_radius_m * state.wheel_speed_rad_s[i] - v;
                law.force(slip, v, p.wheelset_load_n[i], level[i]).force_n
            })
            .sum();
        for _ in 0..6 {
            let acceleration = (free_torque + p.roller_radius_m * sum_n) / total_inertia;
            let roller = (state.roller_speed_rad_s + dt_s * acceleration).max(0.0);
            step.state.roller_speed_rad_s = roller;
            for i in 0..BOGIE_WHEELSETS {
                let (speed, force) = self.wheelset(
                    state.wheel_speed_rad_s[i],
                    p.roller_radius_m * roller,
                    brake_torque_nm[i],
                    law,
                    p.wheelset_load_n[i],
                    level[i],
                    dt_s,
                );
                step.state.wheel_speed_rad_s[i] = speed;
                step.force_n[i] = force;
            }
            let next: f64 = step.force_n.iter().sum();
            let change = next - sum_n;
            sum_n = next;
            if change.abs() < 1e-3 {
                break;
            }
        }
        let roller_speed = step.state.roller_speed_rad_s;
        step.roller_acceleration_rad_s2 = (roller_speed - state.roller_speed_rad_s) / dt_s;
        step.shaft_torque_nm =
            motor_torque_nm - p.motor_inertia_kg_m2 * p.gear_ratio * step.roller_acceleration_rad_s2;
        step.state.roller_angle_rad += 0.5 * dt_s * (roller_speed + state.roller_speed_rad_s);
        for i in 0..BOGIE_WHEELSETS {
            step.state.wheel_angle_rad[i] +=
                0.5 * dt_s * (step.state.wheel_speed_rad_s[i] + state.wheel_speed_rad_s[i]);
        }
        step
    }

    /// Speed and contact force of a wheelset at the end of a step, for a given speed of the rim under it. A brake holds a
    /// wheelset that has stopped; it cannot turn it backwards.
    fn wheelset(
        &self,
        speed_rad_s: f64,
        v_m_s: f64,
        brake_torque_nm: f64,
        law: &ContactLaw,
        load_n: f64,
        level: f64,
        dt_s: f64,
    ) -> (f64, f64) {
        let radius = self.parameters.wheel_radius_m;
        let inertia = self.parameters.wheelset_inertia_kg_m2;
        let free = radius * (speed_rad_s - dt_s * brake_torque_nm / inertia) - v_m_s;
        let compliance = dt_s * radius * radius / inertia;
        let reach = compliance * SATURATION_MAX * load_n * level * law.friction_at_rest;
        let (mut low, mut high) = (free - reach, free + reach);
        let mut slip = (radius * speed_rad_s - v_m_s).clamp(low, high);
        for _ in 0..60 {
            let force = law.force(slip, v_m_s, load_n, level);
            let residual = slip - free + compliance * force.force_n;
            if residual > 0.0 {
                high = slip
            } else {
                low = slip
            }
            let slope = 1.0 + compliance * force.slope_n_s_per_m;
            let newton = slip - residual / slope;
            let next =
                if slope > 0.0 && newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            let change = next - slip;
            slip = next;
            if change.abs() < 1e-9 {
                break;
            }
        }
        let speed = (slip + v_m_s) / radius;
        if speed <= 0.0 && brake_torque_nm > 0.0 {
            return (0.0, law.force(-v_m_s, v_m_s, load_n, level).force_n);
        }
        (speed, law.force(slip, v_m_s, load_n, level).force_n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bogie_rig::{HydraulicBrake, RailCondition, RollerDrive};

    const DT_S: f64 = 5e-4;

    fn rig() -> BogieRig {
        BogieRig::new(BogieParameters::default())
    }

    /// Holds a speed with the drive while the brakes ask for a torque.
    fn held(v_m_s: f64, torque_nm: f64, condition: RailCondition, seconds: f64) -> (BogieRig, BogieRigStep) {
        let rig = rig();
        let p = &rig.parameters;
        let rpm = p.motor_speed_rpm_at(v_m_s);
        let mut drive = RollerDrive::turning(p.drive, rpm);
        let mut brake = HydraulicBrake::released(p.brake);
        let law = ContactLaw::of(condition);
        let mut step = BogieRigStep { state: rig.rolling(v_m_s), ..BogieRigStep::default() };
        for k in 0..(seconds / DT_S) as usize {
            let motor_speed = p.gear_ratio * step.state.roller_speed_rad_s;
            if k % 250 == 0 {
                drive.control(rpm, crate::bogie_rig::rpm_from_rad_s(motor_speed), 0.125);
            }
            let torque = drive.torque_nm(motor_speed, DT_S);
            let brakes = brake.step(p.brake.pressure_pa(torque_nm), DT_S);
            step = rig.step(&step.state, torque, brakes, &law, [1.0; 2], DT_S);
        }
        (rig, step)
    }

    #[test]
    fn in_steady_state_link_and_shaft_carry_what_the_brakes_ask_for() {
        let (rig, step) = held(1.388, 120.0, RailCondition::Dry, 15.0);
        let p = &rig.parameters;
        let demand = (120.0 + 0.97 * 120.0) / p.wheel_radius_m;
        let by_shaft = (p.gear_ratio * step.shaft_torque_nm - p.loss_at_nm(step.state.roller_speed_rad_s))
            / p.roller_radius_m;
        println!(
            "brakes ask for {demand:.1} N, link {:.1} N, shaft {by_shaft:.1} N, v {:.4} m/s, slip {:?}",
            step.link_force_n(),
            rig.v_m_s(&step.state),
            rig.slip(&step.state)
        );
        assert!((step.link_force_n() / demand - 1.0).abs() < 1e-3);
        assert!((by_shaft / demand - 1.0).abs() < 2e-3);
        assert!((rig.v_m_s(&step.state) - 1.388).abs() < 0.005);
    }

    #[test]
    fn erratum_9_shaft_balance_needs_the_rollers_inertia_away_from_steady_state() {
        let rig = rig();
        let p = &rig.parameters;
        let law = ContactLaw::of(RailCondition::Dry);
        let mut state = rig.rolling(2.0);
        let mut step = BogieRigStep::default();
        for _ in 0..200 {
            // The motor gives nothing: the brakes stop the rollers.
            step = rig.step(&state, 0.0, [40.0, 40.0], &law, [1.0; 2], DT_S);
            state = step.state;
        }
        let plain = p.gear_ratio * step.shaft_torque_nm / p.roller_radius_m;
        let whole = (p.gear_ratio * step.shaft_torque_nm
            - p.inertia_beyond_transducer_kg_m2() * step.roller_acceleration_rad_s2
            - p.loss_at_nm(state.roller_speed_rad_s))
            / p.roller_radius_m;
        println!(
            "link {:.1} N; from the shaft without inertia {plain:.1} N, with it {whole:.1} N",
            step.link_force_n()
        );
        assert!((whole / step.link_force_n() - 1.0).abs() < 5e-3);
        assert!((plain / step.link_force_n() - 1.0).abs() > 0.3);
    }

    #[test]
    fn power_balance_closes() {
        let rig = rig();
        let p = &rig.parameters;
        let law = ContactLaw::of(RailCondition::Dry);
        let energy = |state: &BogieRigState| {
            0.5 * p.inertia_beyond_motor_kg_m2() * state.roller_speed_rad_s.powi(2)
                + 0.5
                    * p.wheelset_inertia_kg_m2
                    * state.wheel_speed_rad_s.iter().map(|speed| speed * speed).sum::<f64>()
        };
        let dt_s = 1e-5;
        let (motor, brake) = (30.0, [100.0, 97.0]);
        let mut state = rig.rolling(2.0);
        let begin = energy(&state);
        let mut work = 0.0;
        for _ in 0..20_000 {
            let step = rig.step(&state, motor, brake, &law, [1.0; 2], dt_s);
            let roller = 0.5 * (state.roller_speed_rad_s + step.state.roller_speed_rad_s);
            work += dt_s * roller * (p.gear_ratio * motor - p.loss_at_nm(state.roller_speed_rad_s));
            for i in 0..2 {
                let wheel = 0.5 * (state.wheel_speed_rad_s[i] + step.state.wheel_speed_rad_s[i]);
                let slip_velocity = p.wheel_radius_m * wheel - p.roller_radius_m * roller;
                work -= dt_s * (wheel * brake[i] + slip_velocity * step.force_n[i]);
            }
            state = step.state;
        }
        let change = energy(&state) - begin;
        println!("kinetic energy {change:.4} J, work {work:.4} J");
        assert!((change - work).abs() < 1e-3 * change.abs());
    }

    #[test]
    fn too_much_brake_locks_and_releasing_unlocks() {
        let (rig, locked) = held(2.76, 120.0, RailCondition::Wet, 3.0);
        assert_eq!(locked.state.wheel_speed_rad_s, [0.0; 2]);
        let law = ContactLaw::of(RailCondition::Wet);
        let mut state = locked.state;
        for _ in 0..2000 {
            state = rig.step(&state, 30.0, [0.0; 2], &law, [1.0; 2], DT_S).state;
        }
        println!("slip 1 s after release: {:?}", rig.slip(&state));
        assert!(rig.slip(&state).iter().all(|slip| slip.abs() < 1e-3));
    }

    #[test]
    fn halving_the_step_changes_little() {
        let law = ContactLaw::of(RailCondition::Dry);
        let end = |dt_s: f64| {
            let rig = rig();
            let mut state = rig.rolling(2.76);
            for k in 0..(1.0 / dt_s).round() as usize {
                let brake = 140.0 * (k as f64 * dt_s).min(1.0);
                state = rig.step(&state, 60.0 * (k as f64 * dt_s), [brake; 2], &law, [1.0; 2], dt_s).state;
            }
            (rig.v_m_s(&state), rig.slip(&state)[0])
        };
        let (coarse, fine, reference) = (end(5e-4), end(2.5e-4), end(1e-5));
        println!("v and slip after 1 s: {coarse:?} {fine:?} {reference:?}");
        assert!((coarse.0 - reference.0).abs() < 2e-3);
        assert!((fine.0 - reference.0).abs() < 0.6 * (coarse.0 - reference.0).abs());
    }
}
