//! The reading side of the history, shared by all requests.

use crate::history::columns;
use crate::history::consist::Consist;
use crate::history::export::turn::Exports;
use crate::web::room::Room;
use railgrip_history::{HistoryError, Reader};
use railgrip_settings::VehicleNumber;
use serde::Serialize;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::Semaphore;
use utoipa::ToSchema;

/// Requests that may read at once; others wait.
const READERS: usize = 2;
/// Memory for answers that wait for their readers, bytes.
const ROOM_BYTES: usize = 64 << 20;

/// How the history is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, ToSchema)]
pub struct HistoryStatus {
    /// What is wrong; absent if nothing is.
    pub trouble: Option<String>,
    /// Unix s up to which everything that arrived is on the medium.
    pub written_until_unix_s: Option<i64>,
    /// Writes so far.
    pub flushes: u64,
    /// Bytes of blocks written so far.
    pub written_bytes: u64,
    /// Size of the database, bytes.
    pub size_bytes: u64,
    /// Records that were lost because the disk refused them for too long, or was too slow.
    pub dropped: u64,
}

/// The reading side, shared by all requests.
#[derive(Debug)]
pub struct History {
    database: PathBuf,
    columns: Vec<columns::Column>,
    numbers: Vec<Option<VehicleNumber>>,
    started_s: Option<i64>,
    status: Mutex<HistoryStatus>,
    idle: Mutex<Vec<Reader>>,
    pub(crate) turns: Arc<Semaphore>,
    pub(crate) exports: Exports,
    /// For answers that wait for their readers.
    pub(crate) room: Room,
}

impl History {
    /// The history in this database, of wagons with at most so many wheelsets.
    #[must_use]
    pub fn new(database: PathBuf, wheelsets: usize) -> Self {
        Self::with(database, columns::all(wheelsets))
    }

    /// The history in this database, with these columns.
    #[must_use]
    pub fn with(database: PathBuf, columns: Vec<columns::Column>) -> Self {
        Self {
            database,
            columns,
            numbers: Vec::new(),
            started_s: None,
            status: Mutex::default(),
            idle: Mutex::default(),
            turns: Arc::new(Semaphore::new(READERS)),
            exports: Exports::default(),
            room: Room::new(ROOM_BYTES),
        }
    }

    /// The same for wagons with these vehicle numbers, by place.
    #[must_use]
    pub fn of_vehicles(self, numbers: Vec<Option<VehicleNumber>>) -> Self {
        Self { numbers, ..self }
    }

    /// The same of a train that was started then, Unix s.
    #[must_use]
    pub fn started(self, started_s: Option<i64>) -> Self {
        Self { started_s, ..self }
    }

    /// The vehicle numbers of the train, by place.
    #[must_use]
    pub fn numbers(&self) -> &[Option<VehicleNumber>] {
        &self.numbers
    }

    /// The number of the vehicle at a place, as it is written.
    pub(crate) fn vehicle_number(&self, wagon: u32) -> Option<String> {
        let number = self.numbers.get((wagon as usize).checked_sub(1)?)?.as_ref();
        number.map(|number| number.written().to_owned())
    }

    /// Who runs where.
    ///
    /// # Errors
    /// The database refuses.
    pub fn consist(&self, reader: &Reader) -> Result<Consist, HistoryError> {
        Ok(Consist::read(reader, &self.numbers)?.started(self.started_s))
    }

    /// What is recorded.
    #[must_use]
    pub fn columns(&self) -> &[columns::Column] {
        &self.columns
    }

    /// How it is now.
    #[must_use]
    pub fn status(&self) -> HistoryStatus {
        self.status.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What is wrong with it, in words; for an alert.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        self.status().trouble
    }

    pub(crate) fn update(&self, change: impl FnOnce(&mut HistoryStatus)) {
        change(&mut self.status.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// A reader of its own, also of what older versions wrote.
    ///
    /// # Errors
    /// There is no database yet, or it refuses.
    pub fn open(&self) -> Result<Reader, HistoryError> {
        Ok(Reader::open(&self.database)?.with_names(&columns::former(&self.columns)))
    }

    /// Reads; blocks meanwhile, so call it where that is allowed.
    ///
    /// # Errors
    /// There is no database yet, or it refuses.
    pub fn read<T>(&self, read: impl FnOnce(&Reader) -> Result<T, HistoryError>) -> Result<T, HistoryError> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let reader = match idle {
            Some(reader) => reader,
            None => self.open()?,
        };
        let result = read(&reader)?;
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(reader);
        Ok(result)
    }
}
