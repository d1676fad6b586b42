//! Where one value lies in the data of a message, and what its bits mean.
//!
//! Bits are numbered as in DBC files: bit `b` is bit `b % 8` (0 the least significant) of byte `b / 8`. A little-endian cell
//! (Intel) begins at its least significant bit and grows with the numbers; a big-endian one (Motorola, and all of TRDP) begins at
//! its most significant bit and goes down within a byte, then to the top of the next.

/// Which end comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Least significant bit first (Intel).
    Little,
    /// Most significant bit first (Motorola, network order).
    Big,
}

/// What the bits are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number from 0.
    Unsigned,
    /// A number in two's complement.
    Signed,
    /// IEEE 754, 32 bits.
    Float32,
    /// IEEE 754, 64 bits.
    Float64,
    /// 32 bits of seconds, 16 bits of 1/65536 s.
    SecondsAndTicks,
    /// 32 bits of seconds, 32 bits of µs.
    SecondsAndMicroseconds,
}

/// A cell is there only while another one has a value of these.
#[derive(Debug, Clone, PartialEq)]
pub struct Selector {
    /// The other cell, unsigned.
    pub cell: Box<Cell>,
    /// Its values, from and to.
    pub values: Vec<(u64, u64)>,
}

/// One value in the data of a message: `factor · bits + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Number of its first bit.
    pub start_bit: usize,
    /// Number of its bits, 1 to 64.
    pub bits: usize,
    /// Which end comes first.
    pub order: Order,
    /// What the bits are.
    pub kind: Kind,
    /// Units of one.
    pub factor: f64,
    /// Added to that.
    pub offset: f64,
    /// What it can be, from and to, where the file says so. Beyond lie marks such as "not available".
    pub range: Option<(f64, f64)>,
    /// When it is there at all; all of them must hold.
    pub selectors: Vec<Selector>,
}

/// Why a cell has no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unread {
    /// The data end before it.
    Short,
    /// Another value has its place in this message.
    NotSelected,
    /// Not a number, or outside of what the file says that it can be.
    OutOfRange,
}

impl Cell {
    /// A cell of so many bytes from a byte on, most significant first.
    #[must_use]
    pub const fn bytes(first: usize, count: usize, kind: Kind) -> Self {
        Self {
            start_bit: first * 8 + 7,
            bits: count * 8,
            order: Order::Big,
            kind,
            factor: 1.0,
            offset: 0.0,
            range: None,
            selectors: Vec::new(),
        }
    }

    /// What is wrong with its place in a message of `size` bytes, in words.
    ///
    /// # Errors
    /// An impossible number of bits, or an end beyond the message.
    pub fn check(&self, size: usize) -> Result<(), String> {
        let wanted = match self.kind {
            Kind::Unsigned | Kind::Signed => 1..=64,
            Kind::Float32 => 32..=32,
            Kind::Float64 | Kind::SecondsAndMicroseconds => 64..=64,
            Kind::SecondsAndTicks => 48..=48,
        };
        if !wanted.contains(&self.bits) {
            return Err(format!(
                "has {} bits, allowed are {} to {}",
                self.bits,
                wanted.start(),
                wanted.end()
            ));
        }
        if self.factor == 0.0 || !self.factor.is_finite() {
            return Err(format!("has the factor {}, allowed is a finite one other than 0", self.factor));
        }
        if !self.offset.is_finite() {
            return Err(format!("has the offset {}, allowed is a finite one", self.offset));
        }
        match self.last_byte() {
            Some(last) if last < size => Ok(()),
            _ => Err(format!("does not fit into the {size} bytes of its message")),
        }
    }

    /// Its bits, as one number each that tells them apart.
    fn places(&self) -> impl Iterator<Item = usize> {
        // Of big-endian cells, bits are counted from the top of a byte.
        let first = match self.order {
            Order::Little => self.start_bit,
            Order::Big => self.start_bit / 8 * 8 + 7 - self.start_bit % 8,
        };
        let order = self.order;
        (first..first.saturating_add(self.bits)).map(move |bit| match order {
            Order::Little => bit,
            Order::Big => bit / 8 * 8 + 7 - bit % 8,
        })
    }

    /// Whether both can be there in one message, on bits of which some are the same.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        !self.excludes(other) && self.places().any(|bit| other.places().any(|own| own == bit))
    }

    /// Whether a switch gives the place to one of the two only.
    fn excludes(&self, other: &Self) -> bool {
        let apart = |one: &Selector, two: &Selector| {
            let disjoint = |a: &(u64, u64)| two.values.iter().all(|b| a.1 < b.0 || b.1 < a.0);
            one.cell == two.cell && one.values.iter().all(disjoint)
        };
        self.selectors.iter().any(|one| other.selectors.iter().any(|two| apart(one, two)))
    }

    /// The last byte that it reaches.
    fn last_byte(&self) -> Option<usize> {
        let more = self.bits.checked_sub(1)?;
        match self.order {
            Order::Little => Some(self.start_bit.checked_add(more)? / 8),
            // Counted from the top of its first byte.
            Order::Big => Some(self.start_bit / 8 + (7 - self.start_bit % 8 + more) / 8),
        }
    }

    /// Its value.
    ///
    /// # Errors
    /// Why it has none.
    pub fn read(&self, data: &[u8]) -> Result<f64, Unread> {
        for selector in &self.selectors {
            let selected = selector.cell.raw(data).ok_or(Unread::Short)?;
            if !selector.values.iter().any(|(from, to)| (*from..=*to).contains(&selected)) {
                return Err(Unread::NotSelected);
            }
        }
        let raw = self.raw(data).ok_or(Unread::Short)?;
        let number = match self.kind {
            Kind::Unsigned => raw as f64,
            Kind::Signed => {
                let unused = 64 - self.bits;
                ((raw << unused).cast_signed() >> unused) as f64
            }
            Kind::Float32 => f64::from(f32::from_bits(raw as u32)),
            Kind::Float64 => f64::from_bits(raw),
            Kind::SecondsAndTicks => (raw >> 16) as f64 + (raw & 0xffff) as f64 / 65_536.0,
            Kind::SecondsAndMicroseconds => (raw >> 32) as f64 + (raw & 0xffff_ffff) as f64 * 1e-6,
        };
        let value = self.factor * number + self.offset;
        // Half a step, as the ends of a range are often rounded.
        let slack = 0.5 * self.factor.abs();
        let possible = self.range.is_none_or(|(from, to)| (from - slack..=to + slack).contains(&value));
        if value.is_finite() && possible { Ok(value) } else { Err(Unread::OutOfRange) }
    }

    /// Its bits as a number; nothing if the data end before it.
    fn raw(&self, data: &[u8]) -> Option<u64> {
        let (first, last) = (self.start_bit / 8, self.last_byte()?);
        let bytes = data.get(first..=last)?;
        // At most nine bytes: 64 bits that begin within a byte.
        let mut whole = 0_u128;
        let unused = match self.order {
            Order::Little => {
                bytes.iter().rev().for_each(|byte| whole = whole << 8 | u128::from(*byte));
                self.start_bit % 8
            }
            Order::Big => {
                bytes.iter().for_each(|byte| whole = whole << 8 | u128::from(*byte));
                bytes.len() * 8 - (7 - self.start_bit % 8) - self.bits
            }
        };
        let mask = u64::MAX >> (64 - self.bits);
        Some((whole >> unused) as u64 & mask)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(start_bit: usize, bits: usize, order: Order, kind: Kind) -> Cell {
        Cell { start_bit, bits, order, kind, ..Cell::bytes(0, 1, kind) }
    }

    #[test]
    fn bits_of_both_orders_are_where_they_should_be() {
        let data = [0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0];
        let read = |start, bits, order, kind| cell(start, bits, order, kind).read(&data);
        assert_eq!(read(0, 16, Order::Little, Kind::Unsigned), Ok(f64::from(0x3412)));
        assert_eq!(read(7, 16, Order::Big, Kind::Unsigned), Ok(f64::from(0x1234)));
        assert_eq!(read(4, 12, Order::Little, Kind::Unsigned), Ok(f64::from(0x341)));
        assert_eq!(read(3, 12, Order::Big, Kind::Unsigned), Ok(f64::from(0x234)));
        assert_eq!(read(39, 8, Order::Big, Kind::Signed), Ok(-102.0));
        assert_eq!(read(32, 8, Order::Little, Kind::Signed), Ok(-102.0));
        assert_eq!(read(7, 64, Order::Big, Kind::Unsigned), Ok(0x1234_5678_9abc_def0_u64 as f64));
        assert_eq!(read(60, 8, Order::Little, Kind::Unsigned), Err(Unread::Short));
        assert!(cell(3, 64, Order::Big, Kind::Unsigned).check(8).is_err());
        assert_eq!(cell(3, 64, Order::Big, Kind::Unsigned).check(9), Ok(()));
    }

    #[test]
    fn floats_and_times_of_a_train_network_are_read() {
        let float = Cell::bytes(0, 4, Kind::Float32);
        assert_eq!(float.read(&22.5_f32.to_be_bytes()), Ok(22.5));
        assert_eq!(float.read(&f32::NAN.to_be_bytes()), Err(Unread::OutOfRange));
        let double = Cell::bytes(2, 8, Kind::Float64);
        let mut data = vec![0, 0];
        data.extend((-0.125_f64).to_be_bytes());
        assert_eq!(double.read(&data), Ok(-0.125));
        let time = [0, 0, 0, 10, 0, 7, 0xa1, 0x20];
        assert_eq!(Cell::bytes(0, 8, Kind::SecondsAndMicroseconds).read(&time), Ok(10.5));
        assert_eq!(Cell::bytes(0, 6, Kind::SecondsAndTicks).read(&[0, 0, 0, 3, 0x80, 0]), Ok(3.5));
    }

    #[test]
    fn a_mark_beyond_the_range_is_no_value_and_a_selector_decides() {
        let mut speed = Cell { factor: 0.1, range: Some((0.0, 500.0)), ..Cell::bytes(1, 2, Kind::Unsigned) };
        assert_eq!(speed.read(&[1, 0x02, 0xd0]), Ok(72.0));
        assert_eq!(speed.read(&[1, 0xff, 0xff]), Err(Unread::OutOfRange));
        let page = Box::new(Cell::bytes(0, 1, Kind::Unsigned));
        speed.selectors.push(Selector { cell: page, values: vec![(1, 3)] });
        assert_eq!(speed.read(&[4, 0x02, 0xd0]), Err(Unread::NotSelected));
        assert_eq!(speed.read(&[3, 0x02, 0xd0]), Ok(72.0));
        assert_eq!(speed.read(&[]), Err(Unread::Short));
    }
}
