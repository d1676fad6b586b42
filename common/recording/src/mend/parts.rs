//! Parts of a stretch in which every input is known.

use super::stretch::is_input;
use crate::columns::Quantity;
use crate::recording::{Optional, Recording};
use std::ops::Range;

/// Cuts a recording where an input is missing for long, and its ends where outputs are.
pub(super) fn cut(whole: Recording, notes: &mut Vec<String>) -> Vec<Recording> {
    let known: Vec<bool> = (0..whole.len()).map(|k| missing_input(&whole, k).is_none()).collect();
    let mut parts = Vec::new();
    let mut from = 0;
    while let Some(begin) = (from..known.len()).find(|k| known[*k]) {
        let end = (begin..known.len()).find(|k| !known[*k]).unwrap_or(known.len());
        if end < known.len()
            && let Some(column) = missing_input(&whole, end)
        {
            let until = (end..known.len()).find(|k| known[*k]).unwrap_or(known.len());
            notes.push(format!(
                "{column} is not known from {:.2} s on, for {} rows: cut there",
                whole.t_s[end],
                until - end
            ));
        }
        parts.extend(trimmed(&whole, begin..end));
        from = end;
    }
    match parts.as_slice() {
        [only] if only.len() == whole.len() => vec![whole],
        _ => parts,
    }
}

/// The first input that is not known at a row.
fn missing_input(recording: &Recording, row: usize) -> Option<String> {
    Quantity::ALL.into_iter().filter(|quantity| is_input(*quantity)).find_map(|quantity| {
        let count = if quantity.per_wheelset() { recording.wheelsets } else { 1 };
        let missing =
            |wheelset: &usize| recording.column(quantity, *wheelset).is_some_and(|cells| cells[row].is_nan());
        (0..count).find(missing).map(|wheelset| quantity.column(wheelset, recording.wheelsets))
    })
}

/// The rows of a range from the first to the last at which all outputs were measured.
fn trimmed(whole: &Recording, range: Range<usize>) -> Option<Recording> {
    let measured = |k: &usize| {
        whole.v_m_s[*k].is_finite() && whole.wheel_speed_rad_s.iter().all(|column| column[*k].is_finite())
    };
    let (first, last) = (range.clone().find(measured)?, range.clone().rev().find(measured)?);
    let optional = Optional {
        grade: whole.grade_rad.is_some(),
        sanding: whole.sanding.is_some(),
        position: whole.position_m.is_some(),
        wsp: whole.wsp_active.is_some(),
        load: whole.load_kg.is_some(),
        brake_demand: whole.brake_demand.is_some(),
    };
    let mut part = Recording::empty(&whole.name, whole.rail, whole.wheelsets, optional);
    (first..=last).for_each(|k| part.push(&whole.row(k)));
    Some(part)
}

/// Drops parts that are too short.
pub(super) fn keep_long(parts: &mut Vec<Recording>, least_s: f64, notes: &mut Vec<String>) {
    parts.retain(|part| {
        let long = part.duration_s() >= least_s;
        if !long && let Some(start_s) = part.t_s.first() {
            notes.push(format!(
                "left out: {:.2} s from {start_s:.2} s on, less than a second",
                part.duration_s()
            ));
        }
        long
    });
}
