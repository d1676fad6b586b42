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
}
