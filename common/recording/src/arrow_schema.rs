//! Which columns of a Parquet file are durations. Parquet has no type for them: programs that write through Apache Arrow store
//! whole numbers, and keep their own schema, a FlatBuffers message in base64, in the metadata of the file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Code of a duration in the union `Type` of Arrow's `Schema.fbs`.
const DURATION: u8 = 18;
/// Seconds of one count, by Arrow's `TimeUnit`: s, ms, µs, ns.
const COUNTS_A_SECOND: [i64; 4] = [1, 1_000, 1_000_000, 1_000_000_000];
/// Its default, where a file leaves it out.
const DEFAULT_UNIT: u16 = 1;

/// Names of the columns that are durations, each with its counts in a second; none where the text is no such schema.
pub(crate) fn durations(base64: &str) -> Vec<(String, i64)> {
    STANDARD.decode(base64.trim()).ok().and_then(|bytes| read(&bytes)).unwrap_or_default()
}

fn read(bytes: &[u8]) -> Option<Vec<(String, i64)>> {
    // A message begins with a mark and its length; older writers leave the mark out.
    let marked = bytes.get(..4)? == [0xff; 4];
    let buffer = Buffer(bytes.get(if marked { 8 } else { 4 }..)?);
    let message = buffer.follow(0)?;
    let schema = buffer.follow(buffer.field(message, 2)?)?;
    let fields = buffer.follow(buffer.field(schema, 1)?)?;
    let count = buffer.u32(fields)? as usize;
    let mut found = Vec::new();
    for index in 0..count.min(bytes.len()) {
        let field = buffer.follow(fields + 4 + 4 * index)?;
        let kind = buffer.field(field, 2).and_then(|at| buffer.0.get(at).copied());
        if kind != Some(DURATION) {
            continue;
        }
        let name = buffer.text(buffer.follow(buffer.field(field, 0)?)?)?;
        let duration = buffer.follow(buffer.field(field, 3)?)?;
        let unit = buffer.field(duration, 0).and_then(|at| buffer.u16(at)).unwrap_or(DEFAULT_UNIT);
        found.push((name, *COUNTS_A_SECOND.get(usize::from(unit))?));
    }
    Some(found)
}

/// The few ways through a FlatBuffer that a schema needs; every step stays in bounds.
struct Buffer<'a>(&'a [u8]);

impl Buffer<'_> {
    fn u16(&self, at: usize) -> Option<u16> {
        Some(u16::from_le_bytes(self.0.get(at..at.checked_add(2)?)?.try_into().ok()?))
    }

    fn u32(&self, at: usize) -> Option<u32> {
        Some(u32::from_le_bytes(self.0.get(at..at.checked_add(4)?)?.try_into().ok()?))
    }

    /// Where the offset at this place leads.
    fn follow(&self, at: usize) -> Option<usize> {
        at.checked_add(self.u32(at)? as usize).filter(|to| *to < self.0.len())
    }

    /// Where a field of a table stands; `None` where it has its default.
    fn field(&self, table: usize, number: usize) -> Option<usize> {
        let back = self.u32(table)?.cast_signed();
        let layout = usize::try_from(i64::try_from(table).ok()? - i64::from(back)).ok()?;
        let place = 4 + 2 * number;
        if place + 2 > usize::from(self.u16(layout)?) {
            return None;
        }
        let offset = usize::from(self.u16(layout.checked_add(place)?)?);
        (offset > 0).then(|| table + offset)
    }

    fn text(&self, at: usize) -> Option<String> {
        let length = self.u32(at)? as usize;
        let bytes = self.0.get(at + 4..at.checked_add(4)?.checked_add(length)?)?;
        String::from_utf8(bytes.to_vec()).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What Polars writes for one column of durations in microseconds.
    const POLARS: &str = "/////3UAAAAEAAAA8v///xQAAAAEAAEAAAAKAAsACAAKAAQA+P///wwAAAAIAAgAAAAEAAEAAAAEAAAA7P///zAAAAAgAAAAGAAAAAES\
                          AAAQABIABAAQABEACAAAAAwAAAAAAPr///8CAAYABgAEAAgAAABzaW5jZV91cwA=";

    #[test]
    fn a_duration_is_found_with_its_unit() {
        assert_eq!(durations(POLARS), [("since_us".to_owned(), 1_000_000)]);
    }

    #[test]
    fn nothing_that_is_no_schema_does_harm() {
        assert_eq!(durations("not base64!"), []);
        let bytes = STANDARD.decode(POLARS).expect("base64");
        for at in 0..bytes.len() {
            for value in [0, 0x7f, 0xff] {
                let mut broken = bytes.clone();
                broken[at] = value;
                assert!(read(&broken).is_none_or(|found| found.len() <= bytes.len()));
            }
            assert!(read(&bytes[..at]).is_none_or(|found| found.len() <= 1));
        }
    }
}
