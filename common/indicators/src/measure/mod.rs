//! What is measured of a wagon at full rate, each quantity for itself: it takes an instant, keeps plain bytes for a
//! snapshot, and says what it knows when asked. Nothing is judged here.

pub(crate) mod applications;
pub(crate) mod dragging;
pub(crate) mod isolation;
pub(crate) mod mean;
pub(crate) mod rail_view;
pub(crate) mod roundness;
pub(crate) mod sanding;
pub(crate) mod sensors;
pub(crate) mod slides;
pub(crate) mod standard;
mod window;
