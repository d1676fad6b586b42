//! What can go wrong in an experiment.

use std::path::PathBuf;

/// Why an experiment did not run to its end.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// A file or directory that cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A figure that cannot be drawn.
    #[error("{}: cannot draw: {message}", path.display())]
    Draw {
        /// Which.
        path: PathBuf,
        /// Why.
        message: String,
    },
    /// A filter that cannot be built.
    #[error(transparent)]
    Filter(#[from] railgrip_filter::FilterError),
    /// A record that cannot be smoothed.
    #[error(transparent)]
    Smoother(#[from] railgrip_filter::core::SmootherError),
    /// A classifier that cannot be used.
    #[error(transparent)]
    Classifier(#[from] railgrip_classifier::ModelError),
    /// Audio that cannot be used.
    #[error(transparent)]
    Audio(#[from] railgrip_acoustics::AudioError),
}
