//! All messages that a file describes, and their values by name.

use crate::{Cell, FieldbusError};

/// One message.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Its identifier: of CAN with bit 31 set for 29-bit ones, of TRDP the ComId.
    pub key: u32,
    /// Its name.
    pub name: String,
    /// Its values by their names within the message.
    pub cells: Vec<(String, Cell)>,
}

/// A value of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found<'a> {
    /// The message.
    pub message: &'a Message,
    /// Name of the value within it.
    pub name: &'a str,
    /// Where it lies.
    pub cell: &'a Cell,
}

/// All messages that a file describes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Catalogue {
    /// In the order of the file.
    pub messages: Vec<Message>,
}

impl Catalogue {
    /// The message of that name.
    #[must_use]
    pub fn message(&self, name: &str) -> Option<&Message> {
        self.messages.iter().find(|message| message.name == name)
    }

    /// A value by `MESSAGE.NAME`, or by its name alone where only one message has it; nothing where none has it.
    ///
    /// # Errors
    /// A name that several messages have.
    pub fn find(&self, name: &str) -> Result<Option<Found<'_>>, FieldbusError> {
        let of_message = name.split_once('.').and_then(|(message, value)| {
            let message = self.message(message)?;
            let (name, cell) = message.cells.iter().find(|(own, _)| own == value)?;
            Some(Found { message, name, cell })
        });
        if of_message.is_some() {
            return Ok(of_message);
        }
        let mut all = self.all().filter(|found| found.name == name);
        let Some(first) = all.next() else { return Ok(None) };
        let others: Vec<_> = all.collect();
        if others.is_empty() {
            return Ok(Some(first));
        }
        let choices = std::iter::once(first).chain(others).take(8).map(|found| found.full_name()).collect();
        Err(FieldbusError::Ambiguous { name: name.to_owned(), choices })
    }

    /// The refusal of a name that no message has, with what comes close.
    #[must_use]
    pub fn unknown(&self, name: &str) -> FieldbusError {
        let value = name.rsplit('.').next().unwrap_or(name).to_lowercase();
        let of_message = name.split_once('.').and_then(|(message, _)| self.message(message));
        let close = |found: &Found<'_>| match of_message {
            Some(message) => found.message.key == message.key,
            None => found.name.to_lowercase().contains(&value),
        };
        let near: Vec<_> = self.all().filter(close).take(5).map(|found| found.full_name()).collect();
        let near = if near.is_empty() {
            let some: Vec<_> = self.all().take(5).map(|found| found.full_name()).collect();
            match self.all().count() {
                0 => "there is no value at all".to_owned(),
                count => format!("there are {count} values, for example {}", some.join(", ")),
            }
        } else {
            format!("close are {}", near.join(", "))
        };
        FieldbusError::Unknown { name: name.to_owned(), near }
    }

    fn all(&self) -> impl Iterator<Item = Found<'_>> {
        self.messages.iter().flat_map(|message| {
            message.cells.iter().map(move |(name, cell)| Found { message, name: name.as_str(), cell })
        })
    }
}

impl Found<'_> {
    /// The name that tells it apart from all others.
    #[must_use]
    pub fn full_name(&self) -> String {
        format!("{}.{}", self.message.name, self.name)
    }
}
