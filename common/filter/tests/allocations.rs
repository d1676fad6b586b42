//! A step of a filter allocates nothing, whatever comes: good samples, gaps, missing and mad values.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]

mod support;

use railgrip_filter::{
    BogieRigFile, BogieSample, Estimator, EstimatorConfig, EstimatorInput, FILTERS, Plant, PlantKind,
    TractionRigFile, TractionSample, WagonSample, estimator,
};
use railgrip_vehicle::bogie_rig::{BogieParameters, BogieRig, BogieSensors, ContactLaw, RailCondition};
use railgrip_vehicle::traction_rig::{Drive, DriveParameters, RigParameters, Surface, TractionRig};
use support::plant::{dry_stop, vehicle};

/// Motor samples of a rig at 1 kHz.
fn motor_samples(count: usize) -> Vec<EstimatorInput> {
    let rig = TractionRig::new(RigParameters::new(Surface::Base, 0.0));
    let mut drive = Drive::new(DriveParameters::default(), &rig.motor);
    let mut state = drive.fluxed_state(&rig, 20.0);
    let sample = |k: usize| {
        let mut voltage = [0.0; 2];
        let before = state;
        for _ in 0..10 {
            voltage = drive.step(&state, 20.0, 1e-4);
            state = rig.step(&state, voltage, 0.28, 1e-4);
        }
        EstimatorInput::Traction(TractionSample {
            time_s: 1e-3 * k as f64,
            current_a: before.motor.current_a,
            voltage_v: voltage,
            motor_speed_rad_s: before.motor_speed_rad_s,
            roller_speed_rad_s: before.roller_speed_rad_s,
            generator_current_a: rig.generator().current_a(before.roller_speed_rad_s),
        })
    };
    (0..count).map(sample).collect()
}

/// Samples of a braked bogie rig at 100 Hz.
fn bogie_samples(count: usize) -> Vec<EstimatorInput> {
    let parameters = BogieParameters::default();
    let rig = BogieRig::new(parameters.clone());
    let law = ContactLaw::of(RailCondition::Dry);
    let mut sensors = BogieSensors::new(parameters.sensors, parameters.gear_ratio, [0.1, 0.2, 0.3]);
    let mut state = rig.rolling(2.0);
    let sample = |k: usize| {
        let noise = ((k * 37 % 11) as f64 - 5.0) / 5.0;
        let mut step = Default::default();
        for _ in 0..10 {
            step = rig.step(&state, 25.0, [60.0, 58.0], &law, [1.0; 2], 1e-3);
            state = step.state;
        }
        let roller_pulses = if k.is_multiple_of(13) { sensors.roller_pulses(&step) } else { f64::NAN };
        EstimatorInput::Bogie(BogieSample {
            time_s: 1e-2 * k as f64,
            shaft_torque_nm: sensors.torque_nm(&step, noise),
            load_cell_n: sensors.load_cell_n(&step, -noise),
            brake_pressure_pa: 4e5,
            load_n: parameters.load_n(),
            roller_pulses,
            wheel_pulses: sensors.wheel_pulses(&step),
        })
    };
    (0..count).map(sample).collect()
}

/// The same samples with everything that can be wrong with them.
fn spoiled(inputs: &[EstimatorInput]) -> Vec<EstimatorInput> {
    let spoil = |(k, input): (usize, &EstimatorInput)| match *input {
        EstimatorInput::Wagon(sample) => EstimatorInput::Wagon(spoiled_wagon(k % 97, sample)),
        EstimatorInput::Traction(sample) => EstimatorInput::Traction(spoiled_traction(k % 97, sample)),
        EstimatorInput::Bogie(sample) => EstimatorInput::Bogie(spoiled_bogie(k % 97, sample)),
    };
    inputs.iter().enumerate().map(spoil).collect()
}

fn spoiled_wagon(k: usize, sample: WagonSample) -> WagonSample {
    match k {
        13 => WagonSample::missing(sample.time_s),
        29 => WagonSample { v_m_s: 1e9, ..sample },
        41 => WagonSample { wheel_speed_rad_s: [-5.0; 4], ..sample },
        53 => WagonSample { time_s: sample.time_s - 0.5, ..sample },
        61 => WagonSample { time_s: f64::NAN, ..sample },
        67 => WagonSample { pressing_force_n: [f64::NAN; 4], grade_rad: f64::NAN, ..sample },
        _ => sample,
    }
}

fn spoiled_traction(k: usize, sample: TractionSample) -> TractionSample {
    match k {
        13 | 29 => TractionSample::missing(sample.time_s),
        41 => TractionSample { current_a: [1e12; 2], ..sample },
        53 => TractionSample { time_s: sample.time_s - 0.5, ..sample },
        61 => TractionSample { time_s: f64::NAN, ..sample },
        _ => sample,
    }
}

fn spoiled_bogie(k: usize, sample: BogieSample) -> BogieSample {
    match k {
        13 | 29 => BogieSample::missing(sample.time_s),
        37 => BogieSample { load_cell_n: 1e12, ..sample },
        53 => BogieSample { time_s: sample.time_s - 0.5, ..sample },
        61 => BogieSample { time_s: f64::NAN, ..sample },
        _ => sample,
    }
}

/// Allocations of all steps after the first.
fn allocations(mut filter: Box<dyn Estimator>, inputs: &[EstimatorInput]) -> u64 {
    filter.step(&inputs[0]);
    let counted = allocation_counter::measure(|| {
        for input in &inputs[1..] {
            std::hint::black_box(filter.step(input));
        }
    });
    counted.count_total
}

#[test]
fn a_step_of_any_filter_allocates_nothing() {
    let (wagon, _) = dry_stop(1, 4e4, [1.0, 1.05]);
    let wagon: Vec<EstimatorInput> = wagon.into_iter().map(EstimatorInput::Wagon).collect();
    let motor = motor_samples(3000);
    let rig = TractionRigFile::of("rig", &RigParameters::new(Surface::Base, 0.0), 1e-2);
    let bogie = bogie_samples(2000);
    let bogie_rig = Box::new(BogieRigFile::of("rig", &BogieParameters::default()));
    for entry in FILTERS {
        let (plant, inputs) = match entry.plants.contains(&PlantKind::Wagon) {
            true => (Plant::Wagon(vehicle()), &wagon),
            false if entry.plants.contains(&PlantKind::Traction) => (Plant::Traction(rig.clone()), &motor),
            false => (Plant::Bogie(bogie_rig.clone()), &bogie),
        };
        let config = EstimatorConfig { filter: entry.name.into(), ..EstimatorConfig::default() };
        for (kind, inputs) in [("good", inputs.clone()), ("spoiled", spoiled(inputs))] {
            let count = allocations(estimator(&config, &plant).unwrap(), &inputs);
            println!("{}: {count} allocations in {} {kind} steps", entry.name, inputs.len() - 1);
            assert_eq!(count, 0, "{} with {kind} samples", entry.name);
        }
    }
}
