//! What a report says in words: numbers and names as people read them, the sentences, and the summary on the terminal.

pub mod advice;
pub mod compare;
pub mod findings;
pub mod format;
pub mod parameters;
pub mod regime;
pub mod sentences;
pub mod summary;

pub use sentences::headline;
pub use summary::summary;
