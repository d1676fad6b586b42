//! The table: its form, its columns, and what takes its rows.

use crate::history::columns;
use crate::history::consist::Consist;
use railgrip_history::{HistoryError, Point, Reader};

/// In which form a table is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Comma-separated values, UTF-8, with a header.
    Csv,
    /// Apache Parquet, zstd.
    Parquet,
}

impl Form {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Csv, Self::Parquet];

    /// Its name in queries and file endings.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }

    /// Its media type.
    #[must_use]
    pub const fn media_type(self) -> &'static str {
        match self {
            Self::Csv => "text/csv; charset=utf-8",
            Self::Parquet => "application/vnd.apache.parquet",
        }
    }

    /// The form of that name.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|form| form.word() == word)
    }
}

/// Why an export failed.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The database refuses.
    #[error(transparent)]
    History(#[from] HistoryError),
    /// An indicator that was never stored.
    #[error("there is no indicator \"{name}\"; there are {known}")]
    Unknown {
        /// Its name.
        name: String,
        /// Those that there are.
        known: String,
    },
    /// The receiver refuses.
    #[error("{0}")]
    Write(#[from] std::io::Error),
    /// The table cannot be written as Parquet.
    #[error("{0}")]
    Parquet(#[from] ::parquet::errors::ParquetError),
}

/// What shall be exported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wanted {
    /// The wagons at these places; all that anything is known of if empty.
    pub wagons: Vec<u32>,
    /// Who runs where.
    pub consist: Consist,
    /// These indicators; all if absent.
    pub fields: Option<Vec<String>>,
    /// Begin, Unix s.
    pub from_s: i64,
    /// End, Unix s, exclusive.
    pub to_s: i64,
    /// Width of a step, s.
    pub step_s: i64,
}

/// One indicator in the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub name: String,
    pub unit: &'static str,
    pub interval: bool,
}

/// What each figure column takes of the cells of its field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Mean,
    Min,
    Max,
}

/// Columns of figures: name, cell, part of it.
pub(super) struct Layout {
    pub fields: Vec<Field>,
    /// Names of the columns of the database to be read.
    pub read: Vec<String>,
    pub figures: Vec<(String, usize, Part)>,
}

impl Layout {
    /// The columns of the indicators that are wanted.
    pub fn of(reader: &Reader, wanted: Option<&[String]>) -> Result<Self, ExportError> {
        let stored = reader.columns()?;
        let is_end = |name: &str| name.ends_with(".low") || name.ends_with(".high");
        let own: Vec<&String> = stored.iter().filter(|name| !is_end(name)).collect();
        for name in wanted.unwrap_or_default() {
            if !own.contains(&name) {
                let known = own.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(", ");
                return Err(ExportError::Unknown { name: name.clone(), known });
            }
        }
        let units = columns::all(railgrip_messages::MAX_WHEELSETS);
        let unit =
            |name: &str| units.iter().find(|column| column.name == name).map_or("", |column| column.unit);
        let field = |name: &&String| Field {
            name: (*name).clone(),
            unit: unit(name),
            interval: stored.contains(&format!("{name}.low")) && stored.contains(&format!("{name}.high")),
        };
        let kept = own.iter().filter(|name| wanted.is_none_or(|wanted| wanted.contains(name)));
        let fields: Vec<Field> = kept.map(field).collect();
        let (mut read, mut figures) = (Vec::new(), Vec::new());
        for field in &fields {
            let (plain, at) = (field.name.replace('.', "_"), read.len());
            read.push(field.name.clone());
            figures.push((plain.clone(), at, Part::Mean));
            if field.interval {
                read.extend([".low", ".high"].map(|end| format!("{}{end}", field.name)));
                figures.push((format!("{plain}_low"), at + 1, Part::Mean));
                figures.push((format!("{plain}_high"), at + 2, Part::Mean));
            }
            figures.push((format!("{plain}_min"), at, Part::Min));
            figures.push((format!("{plain}_max"), at, Part::Max));
        }
        Ok(Self { fields, read, figures })
    }

    /// The figure of a column in a row; NaN where nothing is known.
    pub fn figure(&self, column: usize, point: &Point) -> f32 {
        let (_, cell, part) = &self.figures[column];
        point.cells.get(*cell).map_or(f32::NAN, |cell| match part {
            Part::Mean => cell.mean,
            Part::Min => cell.min,
            Part::Max => cell.max,
        })
    }
}

/// The wagon of a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Whose {
    /// Where it runs now; nothing for a vehicle that is not in the train.
    pub place: Option<u32>,
    /// Its vehicle number, where it has one.
    pub vehicle: Option<String>,
}

/// Takes rows, one by one.
pub(super) trait Sink {
    /// Takes one row.
    fn row(&mut self, layout: &Layout, wagon: &Whose, point: Point) -> Result<(), ExportError>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_are_unique_and_need_no_quotes() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("history.db");
        let names = columns::stored(&columns::all(4));
        let names: Vec<_> = names.iter().map(|(name, keep)| (name.as_str(), *keep)).collect();
        let store = railgrip_history::Store::open(&path, &names).expect("store");
        let layout = Layout::of(&Reader::open(&path).expect("reader"), None).expect("layout");
        drop(store);
        let figures: Vec<&String> = layout.figures.iter().map(|(name, ..)| name).collect();
        let unique: std::collections::BTreeSet<_> = figures.iter().collect();
        assert_eq!(unique.len(), figures.len());
        assert!(
            figures.len() > 150
                && figures
                    .iter()
                    .all(|name| name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_'))
        );
        assert!(figures.iter().any(|name| *name == "wheelset_1_brake_friction_low"));
    }
}
