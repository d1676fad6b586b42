//! Stored indicators as JSON: arrays on a regular grid, `null` in the gaps.

use super::History;
use super::columns::Column;
use super::query::Span;
use crate::api::figure::rounded;
use crate::time::rfc3339_s;
use railgrip_history::{Cell, HistoryError, Point, Reader};
use serde::Serialize;
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// One indicator over time; all arrays are as long as `time`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, ToSchema)]
pub struct SeriesView {
    /// Its unit; empty for a ratio, a number or a code.
    pub unit: &'static str,
    /// Mean over the step.
    pub value: Vec<Option<f64>>,
    /// Lower end of the 95 % interval, mean over the step; absent where no interval is remembered.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub low: Option<Vec<Option<f64>>>,
    /// Upper end of the 95 % interval, mean over the step; absent where no interval is remembered.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub high: Option<Vec<Option<f64>>>,
    /// Smallest value within the step.
    pub min: Vec<Option<f64>>,
    /// Largest value within the step.
    pub max: Vec<Option<f64>>,
}

/// Stored indicators of a wagon, in steps.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct HistoryView {
    /// The wagon.
    pub wagon: u32,
    /// The number of its vehicle; `null` where the config gives none: nothing from before the train was started is told then.
    pub vehicle_number: Option<String>,
    /// Begin of the first step, RFC 3339.
    pub from: String,
    /// End, RFC 3339.
    pub to: String,
    /// Width of a step, s.
    pub step_s: i64,
    /// The stored tier that answers: `second`, `minute` or `hour`.
    pub tier: &'static str,
    /// Up to here everything that arrived is stored, RFC 3339; later data may follow.
    pub written_until: Option<String>,
    /// From about here on something is stored in such steps, RFC 3339; `null` while nothing is.
    pub stored_from: Option<String>,
    /// Begin of each step, RFC 3339.
    pub time: Vec<String>,
    /// Begin of each step, Unix s.
    pub unix_s: Vec<i64>,
    /// Samples in each step; 0 in a gap.
    pub samples: Vec<u32>,
    /// By name of the indicator.
    pub indicators: BTreeMap<String, SeriesView>,
}

impl History {
    /// What is stored of a wagon; only the indicators called for, or all.
    ///
    /// # Errors
    /// The database refuses.
    pub fn view(
        &self,
        wagon: u32,
        span: Span,
        fields: Option<&[String]>,
    ) -> Result<HistoryView, HistoryError> {
        let wanted = |column: &&Column| fields.is_none_or(|fields| fields.contains(&column.name));
        let columns: Vec<&Column> = self.columns().iter().filter(wanted).collect();
        let names: Vec<_> = columns.iter().flat_map(|column| column.stored()).collect();
        let names: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
        let (points, stored_from_s) = self.read(|reader| {
            let consist = self.consist(reader)?;
            let id = consist.id(wagon);
            let mut points = reader.query(id, &names, span.from_s, span.to_s, span.step_s)?;
            points.retain(|point| point.unix_s >= consist.known_from(id));
            Ok((points, reader.stored_from(Reader::tier(span.step_s))?))
        })?;
        let written_until = self.status().written_until_unix_s.map(rfc3339_s);
        let stored_from = stored_from_s.map(rfc3339_s);
        Ok(view((wagon, self.vehicle_number(wagon)), span, &columns, &points, [written_until, stored_from]))
    }
}

fn view(
    (wagon, vehicle_number): (u32, Option<String>),
    span: Span,
    columns: &[&Column],
    points: &[Point],
    [written_until, stored_from]: [Option<String>; 2],
) -> HistoryView {
    let steps = span.steps();
    let unix_s: Vec<i64> = (0..steps as i64).map(|step| span.from_s + step * span.step_s).collect();
    let mut rows: Vec<Option<&Point>> = vec![None; steps];
    for point in points {
        if let Some(row) = rows.get_mut(((point.unix_s - span.from_s) / span.step_s) as usize) {
            *row = Some(point);
        }
    }
    let mut indicators = BTreeMap::new();
    let mut place = 0;
    for column in columns {
        let array = |place: usize, part: fn(&Cell) -> f32| -> Vec<Option<f64>> {
            rows.iter().map(|row| row.and_then(|row| number(part(&row.cells[place])))).collect()
        };
        let mut series = SeriesView {
            unit: column.unit,
            value: array(place, |cell| cell.mean),
            min: array(place, |cell| cell.min),
            max: array(place, |cell| cell.max),
            ..SeriesView::default()
        };
        place += 1;
        if column.interval {
            series.low = Some(array(place, |cell| cell.mean));
            series.high = Some(array(place + 1, |cell| cell.mean));
            place += 2;
        }
        indicators.insert(column.name.clone(), series);
    }
    HistoryView {
        wagon,
        vehicle_number,
        from: rfc3339_s(span.from_s),
        to: rfc3339_s(span.to_s),
        step_s: span.step_s,
        tier: Reader::tier(span.step_s).word(),
        written_until,
        stored_from,
        time: unix_s.iter().copied().map(rfc3339_s).collect(),
        samples: rows.iter().map(|row| row.map_or(0, |row| row.samples)).collect(),
        unix_s,
        indicators,
    }
}

fn number(value: f32) -> Option<f64> {
    value.is_finite().then(|| rounded(f64::from(value)))
}
