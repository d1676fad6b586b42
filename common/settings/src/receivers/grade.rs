//! The least grade of which a receiver is told.

use serde::{Deserialize, Serialize};

/// The least grade of which a receiver is told.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Least {
    #[default]
    Watch,
    Act,
}
