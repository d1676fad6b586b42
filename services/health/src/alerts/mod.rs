//! Alerts that people do not learn to ignore.
//!
//! * A *symptom* is one indicator at one place. It counts when it has lasted, and is gone when it has stayed away: each
//!   time an alert comes back it must stay away twice as long.
//! * Symptoms of one *cause* make one alert: pad friction and asymmetry of a wagon, all wheelsets of it. What a worse
//!   symptom explains (a dead sensor explains a filter that disagrees) raises nothing of its own.
//! * A cause of the whole train (a low rail, pads that are wet everywhere) makes one alert that lists the wagons.
//! * Each has a reason and advice in words, a link to its evidence, and a history of what happened to it.
//! * People acknowledge it, or shelve it for a time. What becomes worse comes back by itself.
//! * All of it survives a restart ([`journal`]), and so does what is yet to be delivered.

mod book;
mod change;
pub mod journal;
pub mod model;
pub mod routes;
mod rules;

pub use book::{AlertBook, Cause, Refusal};

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The book, shared by the thread that judges and the requests of people.
#[derive(Debug, Clone)]
pub struct SharedBook(Arc<Mutex<AlertBook>>);

impl SharedBook {
    /// Shares a book.
    #[must_use]
    pub fn new(book: AlertBook) -> Self {
        Self(Arc::new(Mutex::new(book)))
    }

    /// The book, for a moment.
    pub fn lock(&self) -> MutexGuard<'_, AlertBook> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
