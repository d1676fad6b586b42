//! The families of trains: what they are made of, how they brake, where they run.

use crate::random::Stream;

use super::coupler::DrawGear;

/// How an order reaches the distributors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BrakeLine {
    /// By wire, everywhere at once.
    Electric,
    /// By the brake pipe: a wave that runs back along the train and fills what it reaches.
    Pipe,
}

/// A kind of wagon in a family.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WagonKind {
    pub(crate) name: &'static str,
    pub(crate) two_axles: bool,
    /// Mass empty and largest payload, kg.
    pub(crate) tare_kg: (f64, f64),
    pub(crate) payload_kg: f64,
    pub(crate) length_m: (f64, f64),
    pub(crate) radius_m: (f64, f64),
    pub(crate) inertia_kg_m2: (f64, f64),
    /// Heights of the centre of mass, empty and full, m.
    pub(crate) height_m: (f64, f64),
    /// Radius at which the pads act, over the wheel's; 1 for blocks on the tread.
    pub(crate) pad_radius: (f64, f64),
    pub(crate) pad_friction: f64,
    pub(crate) drag: (f64, f64),
    /// Largest traction and electric braking force, N; zero for a trailer.
    pub(crate) traction_n: f64,
    pub(crate) electric_n: f64,
    /// Largest power at the rail, W.
    pub(crate) power_w: f64,
    pub(crate) sander: f64,
}

/// A family of trains.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) coupled: bool,
    /// How often it is drawn among those of its kind.
    pub(crate) weight: f64,
    /// Wagons, locomotives included.
    pub(crate) wagons: (usize, usize),
    /// Leads the train; two of them lead a heavy one.
    pub(crate) locomotive: Option<WagonKind>,
    /// Repeated along the train, turned about from one set to the next.
    pub(crate) pattern: &'static [WagonKind],
    pub(crate) line: BrakeLine,
    /// Times to fill and to release a cylinder, s.
    pub(crate) fill_s: (f64, f64),
    pub(crate) release_s: (f64, f64),
    /// Retardation of a full brake, m/s².
    pub(crate) full_m_s2: (f64, f64),
    /// Retardation that stops are planned with over that of a full brake.
    pub(crate) planned: (f64, f64),
    pub(crate) top_m_s: (f64, f64),
    pub(crate) station_m: (f64, f64),
    pub(crate) grade_rad: f64,
    pub(crate) dwell_s: (f64, f64),
    pub(crate) gear: fn(&mut Stream) -> DrawGear,
}

const COACH: WagonKind = WagonKind {
    name: "coach",
    two_axles: false,
    tare_kg: (36e3, 46e3),
    payload_kg: 9e3,
    length_m: (26.0, 26.8),
    radius_m: (0.42, 0.46),
    inertia_kg_m2: (90.0, 140.0),
    height_m: (1.6, 1.75),
    pad_radius: (0.52, 0.57),
    pad_friction: 0.35,
    drag: (1.6, 3.0),
    traction_n: 0.0,
    electric_n: 0.0,
    power_w: 0.0,
    sander: 0.0,
};

const LOCOMOTIVE: WagonKind = WagonKind {
    name: "locomotive",
    tare_kg: (82e3, 88e3),
    payload_kg: 500.0,
    length_m: (18.5, 19.8),
    radius_m: (0.58, 0.625),
    inertia_kg_m2: (420.0, 620.0),
    height_m: (1.6, 1.7),
    pad_radius: (0.5, 0.55),
    drag: (7.0, 10.0),
    traction_n: 200e3,
    electric_n: 40e3,
    power_w: 5.2e6,
    sander: 1.0,
    ..COACH
};

const MOTOR_CAR: WagonKind = WagonKind {
    name: "motor_car",
    tare_kg: (44e3, 54e3),
    payload_kg: 12e3,
    length_m: (22.0, 25.5),
    inertia_kg_m2: (170.0, 280.0),
    drag: (3.0, 5.0),
    traction_n: 52e3,
    electric_n: 24e3,
    power_w: 1.1e6,
    sander: 1.0,
    ..COACH
};

const TRAILER_CAR: WagonKind = WagonKind {
    name: "trailer_car",
    tare_kg: (32e3, 40e3),
    payload_kg: 13e3,
    length_m: (22.0, 25.0),
    drag: (1.4, 2.6),
    ..COACH
};

const TWO_AXLE_WAGON: WagonKind = WagonKind {
    name: "two_axle_wagon",
    two_axles: true,
    tare_kg: (11.5e3, 15e3),
    payload_kg: 26e3,
    length_m: (12.0, 15.5),
    radius_m: (0.43, 0.46),
    inertia_kg_m2: (75.0, 105.0),
    height_m: (1.25, 1.75),
    pad_radius: (1.0, 1.0),
    pad_friction: 0.25,
    drag: (2.5, 5.0),
    ..COACH
};

const BOGIE_WAGON: WagonKind = WagonKind {
    name: "bogie_wagon",
    tare_kg: (19e3, 26e3),
    payload_kg: 62e3,
    length_m: (15.0, 21.5),
    radius_m: (0.43, 0.46),
    inertia_kg_m2: (75.0, 105.0),
    height_m: (1.2, 1.85),
    pad_radius: (1.0, 1.0),
    pad_friction: 0.25,
    drag: (3.0, 6.0),
    ..COACH
};

const RAILCAR: WagonKind = WagonKind {
    name: "railcar",
    tare_kg: (36e3, 50e3),
    payload_kg: 12e3,
    traction_n: 44e3,
    electric_n: 20e3,
    power_w: 0.6e6,
    ..MOTOR_CAR
};

const LIGHT_RAILCAR: WagonKind = WagonKind {
    name: "light_railcar",
    two_axles: true,
    tare_kg: (19e3, 27e3),
    payload_kg: 7e3,
    length_m: (13.0, 17.0),
    radius_m: (0.36, 0.43),
    inertia_kg_m2: (70.0, 130.0),
    height_m: (1.2, 1.5),
    pad_radius: (0.5, 0.58),
    drag: (2.8, 4.2),
    traction_n: 22e3,
    electric_n: 9e3,
    power_w: 0.28e6,
    sander: 1.0,
    ..COACH
};

fn centre_buffer(stream: &mut Stream) -> DrawGear {
    DrawGear {
        slack_m: stream.uniform(0.0, 0.002),
        preload_n: stream.uniform(15e3, 30e3),
        stiffness_n_per_m: stream.uniform(10e6, 20e6),
        stiffening_n_per_m3: 2e9,
        friction: stream.uniform(0.10, 0.2),
        damping_n_s_per_m: stream.uniform(3e4, 8e4),
    }
}

fn tight_screw(stream: &mut Stream) -> DrawGear {
    DrawGear {
        slack_m: stream.uniform(0.002, 0.008),
        stiffness_n_per_m: stream.uniform(5e6, 9e6),
        friction: stream.uniform(0.2, 0.35),
        ..centre_buffer(stream)
    }
}

fn loose_screw(stream: &mut Stream) -> DrawGear {
    DrawGear {
        slack_m: stream.uniform(0.012, 0.035),
        stiffness_n_per_m: stream.uniform(4e6, 8e6),
        friction: stream.uniform(0.25, 0.4),
        ..centre_buffer(stream)
    }
}

/// All families.
pub(crate) const FAMILIES: [Family; 6] = [
    Family {
        name: "multiple_unit",
        coupled: true,
        weight: 0.4,
        wagons: (4, 12),
        locomotive: None,
        pattern: &[MOTOR_CAR, TRAILER_CAR, TRAILER_CAR, MOTOR_CAR],
        line: BrakeLine::Electric,
        fill_s: (1.4, 2.2),
        release_s: (1.6, 2.6),
        full_m_s2: (0.95, 1.15),
        planned: (0.48, 0.72),
        top_m_s: (30.0, 44.0),
        station_m: (3e3, 9e3),
        grade_rad: 0.012,
        dwell_s: (25.0, 90.0),
        gear: centre_buffer,
    },
    Family {
        name: "coaches",
        coupled: true,
        weight: 0.25,
        wagons: (4, 14),
        locomotive: Some(LOCOMOTIVE),
        pattern: &[COACH],
        line: BrakeLine::Pipe,
        fill_s: (3.2, 4.8),
        release_s: (13.0, 19.0),
        full_m_s2: (0.9, 1.1),
        planned: (0.42, 0.6),
        top_m_s: (33.0, 50.0),
        station_m: (4e3, 11e3),
        grade_rad: 0.010,
        dwell_s: (40.0, 120.0),
        gear: tight_screw,
    },
    Family {
        name: "freight_p",
        coupled: true,
        weight: 0.2,
        wagons: (8, 40),
        locomotive: Some(LOCOMOTIVE),
        pattern: &[BOGIE_WAGON, TWO_AXLE_WAGON, BOGIE_WAGON],
        line: BrakeLine::Pipe,
        fill_s: (3.3, 5.0),
        release_s: (14.0, 20.0),
        full_m_s2: (0.62, 0.78),
        planned: (0.45, 0.6),
        top_m_s: (24.0, 31.0),
        station_m: (4e3, 9e3),
        grade_rad: 0.006,
        dwell_s: (30.0, 120.0),
        gear: loose_screw,
    },
    Family {
        name: "freight_g",
        coupled: true,
        weight: 0.15,
        wagons: (24, 64),
        locomotive: Some(LOCOMOTIVE),
        pattern: &[BOGIE_WAGON, BOGIE_WAGON, TWO_AXLE_WAGON, TWO_AXLE_WAGON],
        line: BrakeLine::Pipe,
        fill_s: (19.0, 28.0),
        release_s: (45.0, 58.0),
        full_m_s2: (0.55, 0.68),
        planned: (0.5, 0.62),
        top_m_s: (20.0, 25.0),
        station_m: (4e3, 9e3),
        grade_rad: 0.004,
        dwell_s: (30.0, 120.0),
        gear: loose_screw,
    },
    Family {
        name: "railcar",
        coupled: false,
        weight: 0.6,
        wagons: (1, 1),
        locomotive: None,
        pattern: &[RAILCAR],
        line: BrakeLine::Electric,
        fill_s: (1.2, 2.0),
        release_s: (1.4, 2.4),
        full_m_s2: (0.95, 1.15),
        planned: (0.5, 0.75),
        top_m_s: (24.0, 36.0),
        station_m: (2.5e3, 7e3),
        grade_rad: 0.014,
        dwell_s: (20.0, 70.0),
        gear: centre_buffer,
    },
    Family {
        name: "light_railcar",
        coupled: false,
        weight: 0.4,
        wagons: (1, 1),
        locomotive: None,
        pattern: &[LIGHT_RAILCAR],
        line: BrakeLine::Electric,
        fill_s: (0.8, 1.5),
        release_s: (0.9, 1.6),
        full_m_s2: (1.0, 1.2),
        planned: (0.5, 0.75),
        top_m_s: (18.0, 26.0),
        station_m: (1e3, 3e3),
        grade_rad: 0.018,
        dwell_s: (15.0, 50.0),
        gear: centre_buffer,
    },
];
