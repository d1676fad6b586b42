//! Multi-process scenarios: real `railgrip` processes, driven from outside.
//!
//! Each test has a train of its own ([`TrainUnderTest`]): a short folder under `/tmp`, an own prefix in `/dev/shm`, any
//! free HTTP port. Dropping it kills whatever is left and removes both. The scenarios are in `scenarios/`.

mod browser;
mod http;
mod processes;
mod random;
mod table;
mod train;

pub use browser::{Browser, Look, Tab};
pub use http::Http;
pub use processes::{Process, of_instance};
pub use random::Random;
pub use table::Table;
pub use train::{TrainUnderTest, within};

/// The program under test, built by Cargo for the test that asks.
#[macro_export]
macro_rules! program {
    () => {
        ::std::path::Path::new(env!("CARGO_BIN_EXE_railgrip-under-test"))
    };
}
