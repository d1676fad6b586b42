//! What is known about the train, and the snapshots of it that requests are answered from.
//!
//! One thread feeds the [`Store`] and takes a [`Snapshot`] several times a second; requests only read the latest one. What
//! most requests ask for is serialised once a snapshot, not once a request.
//!
//! | file | its job |
//! | --- | --- |
//! | `received` | the latest message of each wagon, microphone and process; each is checked as it comes in |
//! | `refused` | what did not pass that check, counted |
//! | `inference` | what the wagons show only together, by the crate of the indicators: neighbours, adhesion map, stopping distance |
//! | `symptoms` | hands what is judged to the alerts |
//! | `snapshot` | the train at one instant, ready to be served |
//! | `feed` | the store itself: takes messages in, gives snapshots out |

mod feed;
mod inference;
mod judgement;
mod received;
mod refused;
mod snapshot;
mod symptoms;

pub use feed::Store;
pub use inference::Whole;
pub use snapshot::Snapshot;
