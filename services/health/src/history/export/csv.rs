//! The table as CSV.

use super::table::{ExportError, Layout, Sink, Whose};
use crate::time::rfc3339_s;
use railgrip_history::Point;
use std::fmt::Write as _;
use std::io::Write;

/// Text that is written at once.
const PIECE_BYTES: usize = 64 * 1024;

/// A table being written.
pub(super) struct Sheet<W> {
    to: W,
    text: String,
}

impl<W: Write> Sheet<W> {
    pub(super) fn begin(layout: &Layout, mut to: W) -> Result<Self, ExportError> {
        let names = layout.figures.iter().map(|(name, ..)| name.as_str());
        let header: Vec<&str> = ["time", "wagon", "vehicle", "samples"].into_iter().chain(names).collect();
        to.write_all(header.join(",").as_bytes())?;
        to.write_all(b"\n")?;
        Ok(Self { to, text: String::new() })
    }

    pub(super) fn finish(mut self) -> Result<(), ExportError> {
        self.send()?;
        Ok(self.to.flush()?)
    }

    fn send(&mut self) -> Result<(), ExportError> {
        self.to.write_all(self.text.as_bytes())?;
        self.text.clear();
        Ok(())
    }
}

impl<W: Write> Sink for Sheet<W> {
    fn row(&mut self, layout: &Layout, wagon: &Whose, point: Point) -> Result<(), ExportError> {
        let time = rfc3339_s(point.unix_s);
        // Whole seconds; writing into a string cannot fail.
        let place = wagon.place.map_or_else(String::new, |place| place.to_string());
        let vehicle = wagon.vehicle.as_deref().unwrap_or_default();
        let _ = write!(self.text, "{}Z,{place},{vehicle},{}", &time[..time.len() - 5], point.samples);
        for column in 0..layout.figures.len() {
            let figure = layout.figure(column, &point);
            self.text.push(',');
            if figure.is_finite() {
                let _ = write!(self.text, "{figure}");
            }
        }
        self.text.push('\n');
        if self.text.len() >= PIECE_BYTES { self.send() } else { Ok(()) }
    }
}
