//! What only the wagons of a train together show. Nothing here knows a clock, a channel or a file: whoever receives the
//! wagons' indicators hands them over.

pub mod braked;
pub mod capability;
mod delay;
mod middle;
pub mod neighbours;
mod pressed;
pub mod stopping;
pub mod track;
