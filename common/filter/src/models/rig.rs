//! The roller-rig filter of Schwarz & Keck, state (19) `[ω_W, v_x, μ_B, μ_W]`: the paper's equations with one
//! wheelset, where v_x = ω_roller r_roller is the speed of the roller's rim.
//!
//! On the recording of a wagon it looks at the leading wheelset alone, as if that carried its share of the wagon.

use super::WagonFilter;
use super::paper::{PaperFilter, PaperModel};
use super::physics::WagonPhysics;
use crate::{EstimatorConfig, FilterError};
use railgrip_vehicle::{VehicleParameters, WagonModel};

/// Equations of the rig.
pub type RigModel = PaperModel<1, 4>;
/// The rig's filter.
pub type RigFilter = PaperFilter<1, 4>;

/// Builds the rig's filter; of a wagon it takes the leading wheelset.
pub(super) fn boxed(
    config: &EstimatorConfig,
    vehicle: &VehicleParameters,
    model: &WagonModel,
) -> Result<Box<dyn WagonFilter>, FilterError> {
    let wheelsets = model.constants().wheelsets;
    let mut physics = WagonPhysics::<1>::new(model);
    physics.mass_kg /= wheelsets as f64;
    physics.loads.transfer_kg = [0.0];
    physics.resistance = physics.resistance.per_wheelset(wheelsets);
    Ok(Box::new(RigFilter::new(config, vehicle, physics)))
}
