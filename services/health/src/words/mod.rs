//! Languages: who reads which one, and the one table of messages, `words/de.po`.
//!
//! # Terms
//! * **message** – a sentence or a word of the program in English, with `{names}` where something is filled in; in the table
//!   it stands beside its German, as gettext has it (msgid, msgstr).
//! * **sentence** – a message that was filled in elsewhere, for example a reason from a channel or an alert of last year. On
//!   channels, in journals and in the interface sentences are English; [`reword`] finds the message and the arguments again.
//! * **speak** – renders something in a language. A rendering never leaves its thread and never waits, so that the language
//!   belongs to the thread for so long.

mod catalogue;
pub(crate) mod choice;
mod message;
mod number;
mod pattern;
mod scripts;
mod spoken;
pub(crate) mod translate;

pub use catalogue::{german, table};
pub use choice::Language;
pub use message::{reword, say, t};
pub(crate) use number::localised;
pub use scripts::in_language;
pub use spoken::speak;
pub(crate) use spoken::spoken;
