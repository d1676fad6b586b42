//! What the command line changes in the settings of a train.

use std::net::SocketAddr;
use std::path::PathBuf;

/// What the command line overrides. Every process of a train must be given the same.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Replays these recordings: files, folders or globs, relative to the working directory.
    pub runs: Vec<String>,
    /// Replays this recorded train, a folder with `train.toml`, once.
    pub train: Option<PathBuf>,
    /// Plays or simulates so many seconds in a second.
    pub speed: Option<f64>,
    /// Listens here instead.
    pub listen: Option<SocketAddr>,
    /// Keeps the instance here instead.
    pub instance_dir: Option<PathBuf>,
}
