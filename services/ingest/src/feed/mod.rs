//! Where samples come from, and when each is due.

mod arrival;
mod can;
mod cbor;
mod heir;
mod json;
mod layout;
pub mod lines;
mod live;
mod overrun;
mod replay;
mod rig;
mod senders;
mod simulate;
mod source_clock;
mod steps;
mod tally;
mod topics;
mod trdp;
mod wagon;

pub use arrival::{Arrival, Feed, InputError, Next, Rolls, When};
pub use layout::Layout;
pub use live::{Inlet, Live};
pub use replay::Replay;
pub use rig::{Rigs, feed_of};
pub use simulate::Simulated;
pub use source_clock::{Reading, SourceClock};
pub use tally::{Account, Tally};

use railgrip_filter::PlantKind;
use railgrip_settings::{Source, TrainSettings};

/// Opens the source that the settings name.
///
/// # Errors
/// A recording that cannot be read or does not fit its vehicle, a scenario that cannot be run.
pub fn open(settings: &TrainSettings) -> Result<Box<dyn Feed>, InputError> {
    check_plants(settings)?;
    let vehicles: Vec<_> = settings.wagons.iter().map(|wagon| wagon.vehicle.clone()).collect();
    let plants: Vec<_> = settings.wagons.iter().map(|wagon| wagon.plant.kind()).collect();
    Ok(match &settings.source {
        Source::Simulate { scenario, seed, sample_rate_hz, speed } => {
            let real = settings.wagons.iter().zip(vehicles);
            let real: Vec<_> =
                real.map(|(wagon, believed)| wagon.simulated.clone().unwrap_or(believed)).collect();
            Box::new(Simulated::new(scenario, &real, *seed, *sample_rate_hz, *speed)?)
        }
        Source::Replay { runs, speed, repeat } => {
            Box::new(Replay::open(runs, &vehicles, &plants, &settings.mapping, *speed, *repeat)?)
        }
        Source::Rig { programme, seed, speed, repeat } => {
            Box::new(Rigs::new(*programme, *seed, settings.wagons.len(), *speed, *repeat))
        }
        Source::Stdin
        | Source::Tcp(_)
        | Source::Udp(_)
        | Source::Mqtt(_)
        | Source::Can(_)
        | Source::Trdp(_) => {
            let mut live = Live::new(settings);
            if let Some(inlet) = live.inlet() {
                match &settings.source {
                    Source::Can(can) => can::start(can, inlet)?,
                    Source::Trdp(trdp) => trdp::start(trdp, inlet)?,
                    lines => senders::start(lines, inlet)?,
                }
            }
            Box::new(live)
        }
        Source::External => return Err(InputError::External),
    })
}

/// Refuses a source that has no samples of what a wagon is.
fn check_plants(settings: &TrainSettings) -> Result<(), InputError> {
    for wagon in &settings.wagons {
        let kind = wagon.plant.kind();
        let (fits, source_kind) = match &settings.source {
            Source::Replay { .. } => (true, "a replay"),
            Source::Simulate { .. } => (kind == PlantKind::Wagon, "a simulated train"),
            Source::Stdin | Source::Tcp(_) | Source::Udp(_) | Source::Mqtt(_) => {
                (matches!(kind, PlantKind::Wagon | PlantKind::Roller), "a source of lines")
            }
            Source::Can(_) | Source::Trdp(_) => {
                (matches!(kind, PlantKind::Wagon | PlantKind::Roller), "a source of messages")
            }
            Source::External => (true, "another program"),
            Source::Rig { programme, .. } => (kind == programme.plant(), "this programme"),
        };
        if !fits {
            let (wagon, plant) = (wagon.number, kind.name());
            let allowed = "allowed are a recording of it, or kind = \"rig\" with a programme of its rig";
            return Err(InputError::Plant { wagon, plant, source_kind, allowed });
        }
    }
    Ok(())
}
