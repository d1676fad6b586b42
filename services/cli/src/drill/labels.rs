//! What is sealed, and where it lies.

use std::path::{Path, PathBuf};

use railgrip_truth_plant::train::label::Label;
use serde::{Deserialize, Serialize};

/// Form of the labels.
pub(super) const SCHEMA: &str = "railgrip.drill.labels/1";

/// What is sealed.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Labels {
    pub(super) schema: String,
    pub(super) seed: u64,
    pub(super) trains: Vec<Made>,
}

/// A train on disk.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Made {
    /// The answer.
    pub(super) label: Label,
    /// SHA-256 over the train's folder, so that the seal ties labels to data.
    pub(super) train_sha256: String,
}

/// Folder of a train.
pub(super) fn train_folder(out: &Path, name: &str) -> PathBuf {
    out.join("trains").join(name)
}

/// Folder of what the owner keeps.
pub(super) fn sealed_folder(out: &Path) -> PathBuf {
    out.join("sealed")
}
