//! A telegram of process data: 40 bytes of header, most significant byte first, then the data set, filled up to whole words.
//!
//! | bytes | field |
//! | --- | --- |
//! | 0–3 | sequence counter |
//! | 4–5 | version of the protocol; the first byte must be 1 |
//! | 6–7 | kind of telegram: `Pd` data, `Pp` answer to a pull, `Pr` request, `Pe` error |
//! | 8–11 | ComId |
//! | 12–15, 16–19 | topography counters of the train backbone and of the operational train; 0 = no matter |
//! | 20–23 | length of the data, bytes |
//! | 24–35 | reserved; ComId and address of an answer |
//! | 36–39 | CRC of the bytes before (IEEE 802.3), least significant byte first |

/// The UDP port of process data.
pub const PORT: u16 = 17_224;
/// Size of the header, bytes.
pub const HEADER_BYTES: usize = 40;
/// The longest data of a telegram, bytes.
pub const LARGEST_DATA: usize = 1432;
/// Where the CRC lies.
const CRC_AT: usize = 36;
/// The version that is spoken; the second byte may differ.
const VERSION: u8 = 1;

/// A telegram with data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Telegram<'a> {
    /// Counts the telegrams of one ComId of one sender.
    pub sequence: u32,
    /// What the data are.
    pub com_id: u32,
    /// Topography counter of the train backbone; 0 = no matter.
    pub etb_topo_count: u32,
    /// Topography counter of the operational train; 0 = no matter.
    pub op_train_topo_count: u32,
    /// The data set.
    pub data: &'a [u8],
}

/// Why a datagram is no telegram with data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Malformed {
    /// Shorter than a header.
    Short,
    /// The CRC of the header is wrong.
    Crc,
    /// Another version of the protocol.
    Version,
    /// A request, an error, or message data.
    Kind,
    /// The length that the header says is not that of the datagram.
    Length,
}

/// Reads a datagram.
///
/// # Errors
/// Why it is no telegram with data.
pub fn parse(datagram: &[u8]) -> Result<Telegram<'_>, Malformed> {
    let header = datagram.get(..HEADER_BYTES).ok_or(Malformed::Short)?;
    let word = |at: usize| header[at..at + 4].iter().fold(0_u32, |word, byte| word << 8 | u32::from(*byte));
    if word(CRC_AT).swap_bytes() != crc32fast::hash(&header[..CRC_AT]) {
        return Err(Malformed::Crc);
    }
    if header[4] != VERSION {
        return Err(Malformed::Version);
    }
    if !matches!(&header[6..8], b"Pd" | b"Pp") {
        return Err(Malformed::Kind);
    }
    let length = usize::try_from(word(20)).unwrap_or(usize::MAX);
    let after = &datagram[HEADER_BYTES..];
    if length > LARGEST_DATA || after.len() < length || after.len() > length.next_multiple_of(4) {
        return Err(Malformed::Length);
    }
    Ok(Telegram {
        sequence: word(0),
        com_id: word(8),
        etb_topo_count: word(12),
        op_train_topo_count: word(16),
        data: &after[..length],
    })
}

/// The datagram of a telegram; data beyond [`LARGEST_DATA`] are cut off.
#[must_use]
pub fn write(telegram: &Telegram<'_>) -> Vec<u8> {
    let data = &telegram.data[..telegram.data.len().min(LARGEST_DATA)];
    let mut datagram = Vec::with_capacity(HEADER_BYTES + data.len().next_multiple_of(4));
    datagram.extend(telegram.sequence.to_be_bytes());
    datagram.extend([VERSION, 0]);
    datagram.extend(b"Pd");
    for word in [telegram.com_id, telegram.etb_topo_count, telegram.op_train_topo_count, data.len() as u32] {
        datagram.extend(word.to_be_bytes());
    }
    datagram.resize(CRC_AT, 0);
    let crc = crc32fast::hash(&datagram);
    datagram.extend(crc.to_le_bytes());
    datagram.extend(data);
    datagram.resize(HEADER_BYTES + data.len().next_multiple_of(4), 0);
    datagram
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn telegram(data: &[u8]) -> Telegram<'_> {
        Telegram { sequence: 7, com_id: 1001, etb_topo_count: 0, op_train_topo_count: 3, data }
    }

    #[test]
    fn a_telegram_survives_the_way_there_and_back() {
        for data in [&[][..], &[1], &[1, 2, 3, 4], &[9; 1432]] {
            let datagram = write(&telegram(data));
            assert_eq!(datagram.len() % 4, 0);
            assert_eq!(parse(&datagram), Ok(telegram(data)));
        }
    }

    #[test]
    fn what_is_wrong_has_its_name() {
        let good = write(&telegram(&[1, 2, 3, 4]));
        assert_eq!(parse(&good[..39]), Err(Malformed::Short));
        assert_eq!(parse(&good[..40]), Err(Malformed::Length));
        let longer = [&good[..], &[0, 0, 0, 0]].concat();
        assert_eq!(parse(&longer), Err(Malformed::Length));
        let changed = |at: usize, to: u8, mend: bool| {
            let mut datagram = good.clone();
            datagram[at] = to;
            if mend {
                let crc = crc32fast::hash(&datagram[..CRC_AT]);
                datagram[CRC_AT..HEADER_BYTES].copy_from_slice(&crc.to_le_bytes());
            }
            parse(&datagram).expect_err("wrong")
        };
        assert_eq!(changed(0, 1, false), Malformed::Crc);
        assert_eq!(changed(4, 2, true), Malformed::Version);
        assert_eq!(changed(7, b'r', true), Malformed::Kind);
        assert_eq!(changed(20, 0xff, true), Malformed::Length);
    }

    proptest! {
        #[test]
        fn no_datagram_brings_it_down(datagram in proptest::collection::vec(any::<u8>(), 0..1600)) {
            let _ = parse(&datagram);
            let mut mended = datagram;
            if mended.len() >= HEADER_BYTES {
                let crc = crc32fast::hash(&mended[..CRC_AT]);
                mended[CRC_AT..HEADER_BYTES].copy_from_slice(&crc.to_le_bytes());
                prop_assert_ne!(parse(&mended), Err(Malformed::Crc));
            }
        }
    }
}
