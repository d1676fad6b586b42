//! What can be wrong with a description of messages, or with what is wanted of it.

/// Why messages cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FieldbusError {
    /// The file is no DBC file.
    #[error("no DBC file: {0}")]
    Dbc(String),
    /// The file is no XML, or its telegrams and data sets make no sense.
    #[error("no TRDP description: {0}")]
    Xml(String),
    /// A signal lies outside of its message, or has an impossible size.
    #[error("{message}.{signal}: {problem}")]
    Cell {
        /// Name of the message.
        message: String,
        /// Name of the signal.
        signal: String,
        /// What is wrong.
        problem: String,
    },
    /// A message whose description contradicts itself or another.
    #[error("message {message}: {problem}")]
    Message {
        /// Name of the message.
        message: String,
        /// What is wrong.
        problem: String,
    },
    /// The mapping asks for something that no message has.
    #[error("no message has \"{name}\"; {near}")]
    Unknown {
        /// The input of the mapping.
        name: String,
        /// What comes close.
        near: String,
    },
    /// Several messages have a value of that name.
    #[error("\"{name}\" is in several messages: {}; write one of these", choices.join(", "))]
    Ambiguous {
        /// The input of the mapping.
        name: String,
        /// Names that tell them apart.
        choices: Vec<String>,
    },
    /// Nothing says when a row is complete.
    #[error(
        "wagon {wagon}: neither the speed of its first wheelset nor its own speed comes from a message; name a message by `sample_on`"
    )]
    NoSampleMessage {
        /// Number of the wagon.
        wagon: usize,
    },
    /// Two wagons would get the same values.
    #[error(
        "wagons {first} and {second} both take {name}: with one bus for several wagons, names need \"{{wagon}}\""
    )]
    Shared {
        /// Number of a wagon.
        first: usize,
        /// Number of another.
        second: usize,
        /// The value that both take.
        name: String,
    },
}
