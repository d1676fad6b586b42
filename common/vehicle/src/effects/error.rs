//! Why an effect, and with it a model, cannot be built.

/// Why a model cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// An effect that the catalogue lacks.
    #[error("effect `{id}` is not in the catalogue; `railgrip gap effects` lists what is")]
    UnknownEffect {
        /// The id.
        id: String,
    },
    /// A parameter that the effect does not have.
    #[error("effect `{id}` has no parameter `{name}`")]
    UnknownParameter {
        /// The effect.
        id: &'static str,
        /// The parameter.
        name: String,
    },
    /// A value outside its bounds.
    #[error("effect `{id}`: `{name}` is {value}, allowed is {lower} to {upper}")]
    ParameterOutOfBounds {
        /// The effect.
        id: &'static str,
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A value that no wagon like this one can have.
    #[error("effect `{id}`: `{name}` is {value}, more than the {largest:.1} that this wagon leaves for it")]
    MoreThanWagonAllows {
        /// The effect.
        id: &'static str,
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// The largest value on this wagon.
        largest: f64,
    },
}

impl ModelError {
    /// Id of the effect that is wrong, and the parameter, where one is.
    pub fn place(&self) -> (&str, Option<&str>) {
        match self {
            Self::UnknownEffect { id } => (id, None),
            Self::UnknownParameter { id, name } => (id, Some(name)),
            Self::ParameterOutOfBounds { id, name, .. } | Self::MoreThanWagonAllows { id, name, .. } => {
                (id, Some(name))
            }
        }
    }
}
