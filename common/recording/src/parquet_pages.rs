//! What the pages of a Parquet column would fill, from their headers alone: the check before anything of them is unpacked.
//!
//! A few bytes can claim two gigabytes, in a page that packs well, in a dictionary or in a run of one repeated value, and a reader
//! that believes them makes the room first. Here each claim is held against a limit, and all of them against the rows that the
//! metadata names. What is no ordinary header is refused, so that nobody reads it otherwise than it was checked.

use crate::error::Problem;
use parquet::basic::Type as Physical;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::ChunkReader;
use std::io::Read;

/// Most bytes of a page, as stored and unpacked, and of a dictionary in memory: 64 MiB, eight million numbers. Writers make pages of
/// about 1 MiB, a few one a row group.
const MOST_PAGE_BYTES: i64 = 64 << 20;
/// Levels of structures in a header; there are three.
const MOST_LEVELS: usize = 8;

/// Kinds of a page in `parquet.thrift`, and the fields of their headers.
mod page {
    pub(super) const DATA: i64 = 0;
    pub(super) const INDEX: i64 = 1;
    pub(super) const DICTIONARY: i64 = 2;
    pub(super) const DATA_V2: i64 = 3;
    pub(super) const DATA_HEADER: i64 = 5;
    pub(super) const DICTIONARY_HEADER: i64 = 7;
    pub(super) const DATA_V2_HEADER: i64 = 8;
}

/// Encodings in `parquet.thrift`.
mod encoding {
    pub(super) const PLAIN_DICTIONARY: i64 = 2;
    pub(super) const DELTA_LENGTH_BYTE_ARRAY: i64 = 6;
    pub(super) const DELTA_BYTE_ARRAY: i64 = 7;
    pub(super) const RLE_DICTIONARY: i64 = 8;
}

/// Fails unless the pages of a column in one row group hold `rows` values, each page of bearable size.
pub(crate) fn check(
    source: &impl ChunkReader,
    chunk: &ColumnChunkMetaData,
    rows: u64,
) -> Result<(), Problem> {
    let start = chunk.dictionary_page_offset().unwrap_or_else(|| chunk.data_page_offset());
    let place = u64::try_from(start).ok().zip(u64::try_from(chunk.compressed_size()).ok());
    let inside =
        |(start, bytes): &(u64, u64)| start.checked_add(*bytes).is_some_and(|end| end <= source.len());
    let Some((mut at, bytes)) = place.filter(inside) else {
        return Err(damaged("a column lies outside the file"));
    };
    let end = at + bytes;
    let mut held = 0;
    let mut dictionary = false;
    while at < end {
        let from = source.get_read(at).map_err(|e| Problem::Parquet(e.to_string()))?.take(end - at);
        let mut header = Compact { from, read: 0 };
        let Some(page) = header.page() else {
            return Err(damaged("a page has no readable header"));
        };
        at += header.read;
        let stored = u64::try_from(page.stored_bytes).ok().filter(|stored| *stored <= end - at);
        let Some(stored) = stored else {
            return Err(damaged("a page lies outside its column"));
        };
        at += stored;
        held += page.check(chunk.column_type(), &mut dictionary)?;
    }
    match held == rows {
        true => Ok(()),
        false => Err(Problem::RowCount { claimed: rows, found: held }),
    }
}

fn damaged(what: &str) -> Problem {
    Problem::Parquet(what.to_owned())
}

/// What the header of a page says.
#[derive(Debug, Clone, Copy)]
struct Page {
    kind: i64,
    stored_bytes: i64,
    unpacked_bytes: i64,
    values: i64,
    encoding: i64,
}

impl Page {
    /// Values for rows in this page.
    fn check(self, physical: Physical, dictionary: &mut bool) -> Result<u64, Problem> {
        let of_dictionary = self.kind == page::DICTIONARY;
        let decoded = if of_dictionary { self.values.saturating_mul(bytes_in_memory(physical)) } else { 0 };
        let bytes = self.stored_bytes.max(self.unpacked_bytes).max(decoded);
        if bytes > MOST_PAGE_BYTES {
            return Err(Problem::PageSize { mib: mib(bytes), most_mib: mib(MOST_PAGE_BYTES) });
        }
        if self.kind == page::INDEX {
            return Ok(0);
        }
        let Ok(values) = u64::try_from(self.values) else {
            return Err(damaged("a page of less than no values"));
        };
        if of_dictionary {
            *dictionary = true;
            return Ok(0);
        }
        let bytes = matches!(physical, Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY);
        match self.encoding {
            encoding::PLAIN_DICTIONARY | encoding::RLE_DICTIONARY if !*dictionary => {
                Err(damaged("a page needs a dictionary that is not there"))
            }
            // Their lengths are packed as differences: a few bytes unpack to any number of values, or to values of any length.
            encoding::DELTA_LENGTH_BYTE_ARRAY | encoding::DELTA_BYTE_ARRAY if bytes => {
                Err(Problem::ColumnType("bytes in a delta encoding (write them plain)".to_owned()))
            }
            _ => Ok(values),
        }
    }
}

/// Bytes of a value in a dictionary that was read; byte arrays are slices of their page.
const fn bytes_in_memory(physical: Physical) -> i64 {
    match physical {
        Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY => 32,
        Physical::INT96 => 12,
        _ => 8,
    }
}

fn mib(bytes: i64) -> u64 {
    u64::try_from(bytes).unwrap_or_default().div_ceil(1 << 20)
}

/// The little of Thrift's compact protocol that a page header needs; `None` where it ends or is none.
struct Compact<R> {
    from: R,
    read: u64,
}

impl<R: Read> Compact<R> {
    const STRUCTURE: u8 = 12;

    fn page(&mut self) -> Option<Page> {
        let [mut kind, mut unpacked, mut stored, mut said] = [const { None }; 4];
        let mut inner = [None; 9];
        let mut last = 0;
        while let Some((id, form)) = self.field(&mut last)? {
            match (id, form) {
                (1, 4..=6) => kind = Some(self.whole()?),
                (2, 4..=6) => unpacked = Some(self.whole()?),
                (3, 4..=6) => stored = Some(self.whole()?),
                (page::DATA_HEADER | page::DICTIONARY_HEADER | page::DATA_V2_HEADER, Self::STRUCTURE) => {
                    // A page with two of them would be read as one and unpacked as the other.
                    if said.replace(id).is_some() {
                        return None;
                    }
                    inner = self.numbers()?;
                }
                _ => self.skip(form, MOST_LEVELS)?,
            }
        }
        let kind = kind?;
        let (header, encoding) = match kind {
            page::DATA => (Some(page::DATA_HEADER), inner[2]),
            page::DICTIONARY => (Some(page::DICTIONARY_HEADER), inner[2]),
            page::DATA_V2 => (Some(page::DATA_V2_HEADER), inner[4]),
            page::INDEX => (None, Some(0)),
            _ => return None,
        };
        if header != said {
            return None;
        }
        let values = if header.is_some() { inner[1]? } else { 0 };
        let (stored_bytes, unpacked_bytes) = (stored?, unpacked?);
        (unpacked_bytes >= 0).then_some(Page {
            kind,
            stored_bytes,
            unpacked_bytes,
            values,
            encoding: encoding?,
        })
    }

    /// The whole numbers of a structure by the numbers of their fields.
    fn numbers(&mut self) -> Option<[Option<i64>; 9]> {
        let mut numbers = [None; 9];
        let mut last = 0;
        while let Some((id, form)) = self.field(&mut last)? {
            match usize::try_from(id).ok().and_then(|id| numbers.get_mut(id)) {
                Some(number) if matches!(form, 4..=6) => *number = Some(self.whole()?),
                _ => self.skip(form, MOST_LEVELS)?,
            }
        }
        Some(numbers)
    }

    /// Number and form of the next field of a structure, nothing at its end. Writers number them upwards.
    fn field(&mut self, last: &mut i64) -> Option<Option<(i64, u8)>> {
        let byte = self.byte()?;
        if byte == 0 {
            return Some(None);
        }
        let id = match byte >> 4 {
            0 => self.whole()?,
            step => *last + i64::from(step),
        };
        if id <= *last || id > i64::from(i16::MAX) {
            return None;
        }
        *last = id;
        Some(Some((id, byte & 0x0f)))
    }

    fn skip(&mut self, form: u8, levels: usize) -> Option<()> {
        let levels = levels.checked_sub(1)?;
        match form {
            1 | 2 => Some(()),
            3 => self.byte().map(|_| ()),
            4..=6 => self.varint().map(|_| ()),
            7 => self.pass(8),
            8 => self.varint().and_then(|bytes| self.pass(bytes)),
            9 | 10 => {
                let byte = self.byte()?;
                let count = if byte >> 4 == 15 { self.varint()? } else { u64::from(byte >> 4) };
                // Truths stand in a byte each here, in a structure in none.
                let form = if matches!(byte & 0x0f, 1 | 2) { 3 } else { byte & 0x0f };
                (0..count).try_for_each(|_| self.skip(form, levels))
            }
            Self::STRUCTURE => {
                let mut last = 0;
                while let Some((_, form)) = self.field(&mut last)? {
                    self.skip(form, levels)?;
                }
                Some(())
            }
            _ => None,
        }
    }

    fn byte(&mut self) -> Option<u8> {
        let mut byte = [0];
        self.from.read_exact(&mut byte).ok()?;
        self.read += 1;
        Some(byte[0])
    }

    fn pass(&mut self, bytes: u64) -> Option<()> {
        let passed = std::io::copy(&mut self.from.by_ref().take(bytes), &mut std::io::sink()).ok()?;
        self.read += passed;
        (passed == bytes).then_some(())
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// A whole number of 32 bits, its sign in the lowest one; some writers call it one of 64 bits.
    fn whole(&mut self) -> Option<i64> {
        let value = self.varint()?;
        let signed = (value >> 1).cast_signed() ^ -(value & 1).cast_signed();
        i32::try_from(signed).ok().map(i64::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(bytes: &[u8]) -> Option<(Page, u64)> {
        let mut header = Compact { from: bytes, read: 0 };
        header.page().map(|page| (page, header.read))
    }

    /// A data page of 1,000 values, dictionary encoded, 20 bytes that are 40 unpacked.
    const DATA: [u8; 20] = [
        0x15, 0x00, 0x15, 0x50, 0x15, 0x28, 0x2c, 0x15, 0xd0, 0x0f, 0x15, 0x10, 0x15, 0x06, 0x15, 0x06, 0x00,
        0x00, 0xff, 0xff,
    ];

    #[test]
    fn a_header_says_what_its_page_holds() {
        let (data, read) = page(&DATA).expect("a header");
        assert_eq!((data.stored_bytes, data.unpacked_bytes, data.values, read), (20, 40, 1_000, 18));
        let check = |mut dictionary| data.check(Physical::DOUBLE, &mut dictionary);
        assert_eq!(check(true).expect("good"), 1_000);
        assert!(check(false).expect_err("no dictionary").to_string().contains("dictionary"));
    }

    #[test]
    fn nothing_that_is_no_header_is_taken_for_one() {
        for cut in 0..18 {
            assert!(page(&DATA[..cut]).is_none(), "cut at {cut}");
        }
        // The same field twice, and the header of another kind of page.
        assert!(page(&[0x15, 0x00, 0x05, 0x02, 0x00]).is_none());
        let mut other = DATA;
        other[1] = 0x04;
        assert!(page(&other).is_none());
        // Structures without end in a field that nobody knows.
        assert!(page(&[0x9c; 64]).is_none());
    }

    #[test]
    fn a_small_page_that_unpacks_to_much_is_refused() {
        let (data, _) = page(&DATA).expect("a header");
        let large = Page { unpacked_bytes: 2_000_000_000, ..data };
        let said = large.check(Physical::DOUBLE, &mut true).expect_err("large").to_string();
        assert!(said.contains("1908 MiB") && said.contains("64 MiB"), "{said}");
        let words = Page { kind: page::DICTIONARY, values: i64::from(i32::MAX), ..data };
        assert!(words.check(Physical::DOUBLE, &mut false).is_err());
        let delta = Page { encoding: encoding::DELTA_BYTE_ARRAY, ..data };
        assert!(delta.check(Physical::BYTE_ARRAY, &mut true).is_err());
    }
}
