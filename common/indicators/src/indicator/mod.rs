//! The indicators, one file each (two where they are judged by the same law): its entry of the table and how it is judged.

mod adhesion;
mod asymmetry;
mod brake_delay;
mod brake_friction;
mod disc_rise;
mod dragging;
mod filter;
mod isolated;
pub mod judging;
mod model;
mod rail;
mod response;
mod sanding;
mod sensors;
mod slides;
mod stopping_distance;
mod wheel_flat;
mod wsp_share;

pub use adhesion::{ADHESION_AVAILABLE, ADHESION_UTILISED};
pub use asymmetry::ASYMMETRY;
pub use brake_delay::BRAKE_DELAY;
pub use brake_friction::{BRAKE_FRICTION, BRAKE_FRICTION_STANDARD};
pub use disc_rise::DISC_RISE;
pub use dragging::DRAGGING;
pub use filter::FILTER;
pub use isolated::ISOLATED;
pub use model::MODEL;
pub use rail::RAIL;
pub use response::RESPONSE;
pub use sanding::SANDING;
pub use sensors::SENSORS;
pub use slides::SLIDES;
pub use stopping_distance::{STOPPING_DISTANCE, STOPPING_RATIO};
pub use wheel_flat::WHEEL_FLAT;
pub use wsp_share::WSP_SHARE;
