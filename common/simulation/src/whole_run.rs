//! A scenario from start to end: one recording a wagon, with the truth beside it.

use crate::{Scenario, ScenarioError, Train};
use railgrip_recording::{Optional, RailClass, Recording, Truth};
use railgrip_vehicle::{RailClass as VehicleRailClass, VehicleParameters};

/// The run of one wagon.
#[derive(Clone, Debug, PartialEq)]
pub struct WagonRun {
    /// What its sensors recorded; named after the rail class on which the wagon spent most of its time.
    pub recording: Recording,
    /// What no sensor sees, row for row.
    pub truth: Truth,
}

/// Runs a scenario for its whole duration. `progress` hears the share that is done, about a hundred times.
///
/// # Errors
/// As [`Train::new`].
pub fn run(
    scenario: &Scenario,
    vehicles: &[VehicleParameters],
    seed: u64,
    mut progress: impl FnMut(f64),
) -> Result<Vec<WagonRun>, ScenarioError> {
    let mut train = Train::new(scenario, vehicles, seed, None)?;
    let samples = (scenario.duration_s / train.sample_period_s()).round() as usize + 1;
    let mut runs: Vec<WagonRun> = (0..train.wagons())
        .map(|wagon| {
            let wheelsets = train.wheelsets(wagon);
            let recording = Recording::empty("", None, wheelsets, Optional::MEASURED);
            WagonRun { recording, truth: Truth::empty(wheelsets) }
        })
        .collect();
    let mut time_on = vec![[0usize; VehicleRailClass::ALL.len()]; runs.len()];
    for index in 0..samples {
        for (wagon, sample) in train.step().wagons.iter().enumerate() {
            if sample.present {
                runs[wagon].recording.push(&sample.row);
                runs[wagon].truth.push(&sample.truth.row);
            }
            time_on[wagon][sample.truth.rail as usize] += 1;
        }
        if index % samples.div_ceil(100) == 0 {
            progress(index as f64 / samples as f64);
        }
    }
    for (wagon, run) in runs.iter_mut().enumerate() {
        let own = scenario.wagon.iter().find(|own| own.number == wagon + 1).and_then(|own| own.rail);
        let class = own.unwrap_or_else(|| most(&time_on[wagon]));
        run.recording.rail = RailClass::parse(class.name());
        run.recording.name = format!("wagon{:02}.{}", wagon + 1, class.name());
    }
    Ok(runs)
}

/// The class of the highest count, the better rail of equals.
fn most(counts: &[usize; VehicleRailClass::ALL.len()]) -> VehicleRailClass {
    let mut best = VehicleRailClass::Dry;
    for class in VehicleRailClass::ALL {
        if counts[class as usize] > counts[best as usize] {
            best = class;
        }
    }
    best
}
