//! Why a file of own effects was refused.

/// Why a file of own effects was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OwnEffectError {
    /// Another layout.
    #[error("`schema` is {found}, known is 1")]
    Schema {
        /// What stands there.
        found: u32,
    },
    /// Something is wrong with an effect.
    #[error("effect `{id}`, `{what}`: {problem}")]
    Effect {
        /// The effect.
        id: String,
        /// The key.
        what: &'static str,
        /// What is wrong, and what there is.
        problem: String,
    },
    /// Two effects have one id.
    #[error("effect `{id}`: another effect of this id was read before")]
    Twice {
        /// The id.
        id: String,
    },
}

impl OwnEffectError {
    /// Id of the effect that is wrong, and the key, where one is.
    pub fn place(&self) -> Option<(&str, &'static str)> {
        match self {
            Self::Schema { .. } => None,
            Self::Effect { id, what, .. } => Some((id, what)),
            Self::Twice { id } => Some((id, "id")),
        }
    }
}
