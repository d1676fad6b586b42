//! The alerts, shared by the thread that judges and the requests of people.

use super::book::AlertBook;
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
