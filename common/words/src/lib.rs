//! Languages, and the one table of messages, `de.po`, for pages, scripts, reports and sentences.
//!
//! # Terms
//! * **message** – a sentence or a word of the program in English, with `{names}` where something is filled in; in the table
//!   it stands beside its German, as gettext has it (msgid, msgstr).
//! * **sentence** – a message that was filled in elsewhere, for example a reason from a channel or an alert of last year. On
//!   channels, in journals, in reports for programs and in the interface sentences are English; [`reword`] finds the message
//!   and the arguments again.
//! * **speak** – renders something in a language. A rendering never leaves its thread and never waits, so that the language
//!   belongs to the thread for so long.

mod catalogue;
mod language;
mod message;
mod number;
mod pattern;
mod scripts;
mod spoken;

pub use catalogue::{german, table};
pub use language::Language;
pub use message::{pieces, reword, say, t, word};
pub use number::localised;
pub use pattern::Piece;
pub use scripts::in_language;
pub use spoken::{speak, spoken};
