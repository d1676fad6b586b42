//! Operator actions: people acknowledge an alert, take that back, silence it for a time, or end that silence.

use super::book::AlertBook;
use crate::alerts::model::{AcknowledgeRequest, Acknowledgement, Alert, Change, Silence, SilenceRequest};
use crate::time::rfc3339;
use railgrip_messages::Stamp;

/// Why a request of a person cannot be carried out.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// There is no such alert.
    #[error("there is no alert {0}")]
    Unknown(u64),
    /// It is over.
    #[error("alert {0} is over: its cause is gone")]
    Over(u64),
    /// It is not silenced.
    #[error("alert {0} is not silenced")]
    NotSilenced(u64),
    /// It is not acknowledged.
    #[error("alert {0} is not acknowledged")]
    NotAcknowledged(u64),
    /// The request makes no sense.
    #[error("{0}")]
    Invalid(String),
}

impl AlertBook {
    /// Somebody takes notice.
    ///
    /// # Errors
    /// An alert that is not there or over, or a request without a name.
    pub fn acknowledge(
        &mut self,
        id: u64,
        request: AcknowledgeRequest,
        now: Stamp,
    ) -> Result<Alert, Refusal> {
        let by = sane("by", &request.by, 100)?;
        let note = request.note.map(|note| sane("note", &note, 500)).transpose()?;
        self.change(id, Change::Acknowledged, now, |alert| {
            alert.acknowledged =
                Some(Acknowledgement { by: by.clone(), at: rfc3339(now.unix_ns), note: note.clone() });
            alert.note(Change::Acknowledged, Some(&by), note, now);
            Ok(())
        })
    }

    /// Somebody takes an acknowledgement back, for example one that was given to the wrong alert.
    ///
    /// # Errors
    /// As [`Self::acknowledge`], and an alert that is not acknowledged.
    pub fn unacknowledge(
        &mut self,
        id: u64,
        request: AcknowledgeRequest,
        now: Stamp,
    ) -> Result<Alert, Refusal> {
        let by = sane("by", &request.by, 100)?;
        let note = request.note.map(|note| sane("note", &note, 500)).transpose()?;
        self.change(id, Change::Unacknowledged, now, |alert| {
            alert.acknowledged.take().ok_or(Refusal::NotAcknowledged(id))?;
            alert.note(Change::Unacknowledged, Some(&by), note, now);
            Ok(())
        })
    }

    /// Somebody silences it for a time.
    ///
    /// # Errors
    /// As [`Self::acknowledge`], and a duration out of range.
    pub fn silence(&mut self, id: u64, request: SilenceRequest, now: Stamp) -> Result<Alert, Refusal> {
        let (by, why) = (sane("by", &request.by, 100)?, sane("why", &request.why, 500)?);
        if !(60.0..=2_592_000.0).contains(&request.duration_s) {
            let said = format!("`duration_s` is {}; allowed is 60 to 2592000 (30 days)", request.duration_s);
            return Err(Refusal::Invalid(said));
        }
        let until_unix_ns = now.unix_ns + (request.duration_s * 1e9) as i64;
        self.change(id, Change::Silenced, now, |alert| {
            alert.silenced = Some(Silence {
                by: by.clone(),
                at: rfc3339(now.unix_ns),
                why: why.clone(),
                until: rfc3339(until_unix_ns),
                until_unix_ns,
            });
            alert.note(Change::Silenced, Some(&by), Some(why), now);
            Ok(())
        })
    }

    /// Somebody ends a silence before its time is over.
    ///
    /// # Errors
    /// As [`Self::acknowledge`], and an alert that is not silenced.
    pub fn unsilence(&mut self, id: u64, request: AcknowledgeRequest, now: Stamp) -> Result<Alert, Refusal> {
        let by = sane("by", &request.by, 100)?;
        let note = request.note.map(|note| sane("note", &note, 500)).transpose()?;
        self.change(id, Change::Unsilenced, now, |alert| {
            alert.silenced.take().ok_or(Refusal::NotSilenced(id))?;
            alert.note(Change::Unsilenced, Some(&by), note, now);
            Ok(())
        })
    }

    fn change(
        &mut self,
        id: u64,
        change: Change,
        now: Stamp,
        make: impl FnOnce(&mut Alert) -> Result<(), Refusal>,
    ) -> Result<Alert, Refusal> {
        let Some(alert) = self.open.values_mut().find(|alert| alert.id == id) else {
            let over = self.over.iter().any(|alert| alert.id == id);
            return Err(if over { Refusal::Over(id) } else { Refusal::Unknown(id) });
        };
        make(alert)?;
        let alert = alert.clone();
        self.tell(&alert, change, now);
        self.save(now);
        Ok(alert)
    }
}

fn sane(key: &str, text: &str, most: usize) -> Result<String, Refusal> {
    let text = text.trim();
    if (1..=most).contains(&text.chars().count()) && !text.chars().any(|c| c.is_control() && c != '\n') {
        return Ok(text.to_owned());
    }
    Err(Refusal::Invalid(format!("`{key}` must be a text of 1 to {most} characters")))
}
