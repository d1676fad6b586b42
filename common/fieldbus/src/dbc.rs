//! CAN messages as a DBC file describes them.

use crate::{Catalogue, Cell, FieldbusError, Kind, Message, Order, Selector};
use std::collections::{BTreeMap, BTreeSet};

use can_dbc::{ByteOrder, Dbc, MultiplexIndicator, NumericValue, Signal, SignalExtendedValueType, ValueType};

/// The largest data of a frame (CAN FD), bytes.
const LARGEST_FRAME: usize = 64;
/// Messages that only hold signals without one, by their agreed name.
const NO_MESSAGE: &str = "VECTOR__INDEPENDENT_SIG_MSG";

/// Reads the text of a DBC file.
///
/// # Errors
/// A text that is none, or a signal that cannot lie where it should.
pub fn read(text: &str) -> Result<Catalogue, FieldbusError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let dbc = Dbc::try_from(text).map_err(|error| FieldbusError::Dbc(in_short(&error.to_string())))?;
    let mut messages = Vec::new();
    let (mut keys, mut names) = (BTreeMap::new(), BTreeSet::new());
    for message in dbc.messages.iter().filter(|message| message.name != NO_MESSAGE) {
        let wrong = |signal: &Signal, problem: String| FieldbusError::Cell {
            message: message.name.clone(),
            signal: signal.name.clone(),
            problem,
        };
        let refuse = |problem: String| FieldbusError::Message { message: message.name.clone(), problem };
        if let Some(name) = keys.insert(message.id.raw(), &message.name) {
            let id = message.id.raw() & 0x1FFF_FFFF;
            return Err(refuse(format!("has the identifier {id} of message {name}")));
        }
        if !names.insert(&message.name) {
            return Err(refuse("stands twice, with two identifiers".to_owned()));
        }
        let mut cells: Vec<(String, Cell)> = Vec::new();
        for signal in &message.signals {
            let mut cell = plain(&dbc, message, signal);
            cell.selectors = selectors(&dbc, message, signal).map_err(|problem| wrong(signal, problem))?;
            let size = usize::try_from(message.size).unwrap_or(LARGEST_FRAME).min(LARGEST_FRAME);
            cell.check(size).map_err(|problem| wrong(signal, problem))?;
            for selector in &cell.selectors {
                selector.cell.check(size).map_err(|problem| wrong(signal, problem))?;
            }
            if cells.iter().any(|(name, _)| *name == signal.name) {
                return Err(wrong(signal, "stands twice in its message".to_owned()));
            }
            if let Some((other, _)) = cells.iter().find(|(_, other)| other.overlaps(&cell)) {
                return Err(wrong(signal, format!("lies on bits of {other}")));
            }
            cells.push((signal.name.clone(), cell));
        }
        messages.push(Message { key: message.id.raw(), name: message.name.clone(), cells });
    }
    Ok(Catalogue { messages })
}

/// What a parser says, without what it quotes at length: the lines that it cuts out of the text, on one line and free of characters
/// that a terminal would obey.
fn in_short(said: &str) -> String {
    const MOST: usize = 100;
    let line = |line: &str| {
        let shown = line.trim().chars().map(|c| if c.is_control() { ' ' } else { c });
        let mut short: String = shown.clone().take(MOST).collect();
        if shown.count() > MOST {
            short.push('…');
        }
        short
    };
    let bare = |line: &str| line.trim().chars().all(|c| matches!(c, '|' | '^' | '-' | ' '));
    said.lines().filter(|one| !bare(one)).map(line).collect::<Vec<_>>().join(" ")
}

/// The cell of a signal, whatever selects it.
fn plain(dbc: &Dbc, message: &can_dbc::Message, signal: &Signal) -> Cell {
    let extended = dbc.signal_extended_value_type_list.iter();
    let extended = extended
        .filter(|one| one.message_id == message.id && one.signal_name == signal.name)
        .map(|one| one.signal_extended_value_type)
        .next();
    let kind = match (extended, signal.value_type) {
        (Some(SignalExtendedValueType::IEEEfloat32Bit), _) => Kind::Float32,
        (Some(SignalExtendedValueType::IEEEdouble64bit), _) => Kind::Float64,
        (_, ValueType::Signed) => Kind::Signed,
        (_, ValueType::Unsigned) => Kind::Unsigned,
    };
    let order = match signal.byte_order {
        ByteOrder::LittleEndian => Order::Little,
        ByteOrder::BigEndian => Order::Big,
    };
    let (from, to) = (number(signal.min), number(signal.max));
    Cell {
        start_bit: usize::try_from(signal.start_bit).unwrap_or(usize::MAX),
        bits: usize::try_from(signal.size).unwrap_or(usize::MAX),
        order,
        kind,
        factor: signal.factor,
        offset: signal.offset,
        // Equal ends mean that nobody filled them in.
        range: (from < to).then_some((from, to)),
        selectors: Vec::new(),
    }
}

fn number(value: NumericValue) -> f64 {
    match value {
        NumericValue::Uint(value) => value as f64,
        NumericValue::Int(value) => value as f64,
        NumericValue::Double(value) => value,
    }
}

/// What must hold for a multiplexed signal to be there.
fn selectors(dbc: &Dbc, message: &can_dbc::Message, signal: &Signal) -> Result<Vec<Selector>, String> {
    let own = match signal.multiplexer_indicator {
        MultiplexIndicator::Plain | MultiplexIndicator::Multiplexor => return Ok(Vec::new()),
        MultiplexIndicator::MultiplexedSignal(value)
        | MultiplexIndicator::MultiplexorAndMultiplexedSignal(value) => value,
    };
    let mut found = Vec::new();
    let (mut name, mut value) = (signal.name.as_str(), own);
    // A switch may itself be switched; as deep as there are signals, so that a circle ends.
    for _ in 0..message.signals.len() {
        let mut extended = dbc.extended_multiplex.iter();
        let rule = extended.find(|one| one.message_id == message.id && one.signal_name == name);
        let by_name = |signal: &&Signal| rule.is_some_and(|rule| rule.multiplexor_signal_name == signal.name);
        let top = |signal: &&Signal| signal.multiplexer_indicator == MultiplexIndicator::Multiplexor;
        let mut all = message.signals.iter();
        let switch = if rule.is_some() { all.find(by_name) } else { all.find(top) };
        let Some(switch) = switch else { return Err("nothing selects it".to_owned()) };
        let values = match rule {
            Some(rule) => rule.mappings.iter().map(|values| (values.min_value, values.max_value)).collect(),
            None => vec![(value, value)],
        };
        let mut cell = plain(dbc, message, switch);
        cell.kind = Kind::Unsigned;
        found.push(Selector { cell: Box::new(cell), values });
        match switch.multiplexer_indicator {
            MultiplexIndicator::MultiplexorAndMultiplexedSignal(own)
            | MultiplexIndicator::MultiplexedSignal(own) => (name, value) = (switch.name.as_str(), own),
            MultiplexIndicator::Plain | MultiplexIndicator::Multiplexor => return Ok(found),
        }
    }
    Err("its switches select each other".to_owned())
}

/// Bits of an identifier that say what kind of frame it is: a request, an error.
const KIND_BITS: u32 = 0x6000_0000;

/// The key of a CAN frame in its catalogue, from the identifier as the kernel writes it.
#[must_use]
pub const fn key_of(id_word: u32) -> u32 {
    id_word & !KIND_BITS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unread;

    const TEXT: &str = r#"VERSION ""

NS_ :

BS_:

BU_: BCU GPS

BO_ 256 Axles: 8 BCU
 SG_ N1 : 0|16@1+ (0.01,0) [0|500] "rad/s" GPS
 SG_ N2 : 23|16@0- (0.01,0) [0|0] "rad/s" GPS
 SG_ P : 32|32@1- (1,0) [0|0] "bar" GPS

BO_ 2566845694 Pages: 4 BCU
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" GPS
 SG_ Load m1 : 8|16@1+ (10,0) [0|0] "kg" GPS
 SG_ Sand m2 : 8|1@1+ (1,0) [0|0] "" GPS

SIG_VALTYPE_ 256 P : 1;
"#;

    #[test]
    fn signals_of_both_orders_floats_and_pages_are_read() {
        let catalogue = read(TEXT).expect("a DBC file");
        let value = |name: &str, data: &[u8]| {
            let found = catalogue.find(name).expect("one").expect("there");
            found.cell.read(data)
        };
        let mut axles = vec![0x10, 0x27, 0xfc, 0x18];
        axles.extend(3.8_f32.to_le_bytes());
        assert_eq!(value("N1", &axles), Ok(100.0));
        assert_eq!(value("Axles.N2", &axles), Ok(-10.0));
        assert!((value("P", &axles).expect("a pressure") - 3.8).abs() < 1e-6);
        assert_eq!(value("N1", &[0xff, 0xff]), Err(Unread::OutOfRange));
        assert_eq!(value("Load", &[1, 0x10, 0x27, 0]), Ok(100_000.0));
        assert_eq!(value("Load", &[2, 1, 0, 0]), Err(Unread::NotSelected));
        assert_eq!(value("Sand", &[2, 1, 0, 0]), Ok(1.0));
        assert_eq!(catalogue.message("Pages").map(|message| message.key), Some(0x98fe_f4fe));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let beyond = TEXT.replace("23|16@0-", "3|61@0-");
        let said = read(&beyond).expect_err("beyond").to_string();
        assert_eq!(said, "Axles.N2: does not fit into the 8 bytes of its message");
        let said = read("nonsense").expect_err("nonsense").to_string();
        assert!(said.starts_with("no DBC file: "), "{said}");
        let said = read(&format!("VERSION \u{1b}[2J{}", "x".repeat(100_000))).expect_err("noise").to_string();
        assert!(said.len() < 1000 && !said.contains('\u{1b}'), "{said}");
        assert!(read(&format!("\u{feff}{TEXT}")).is_ok(), "a byte order mark");
        let catalogue = read(TEXT).expect("a DBC file");
        assert_eq!(catalogue.find("N3"), Ok(None));
        let said = catalogue.unknown("Axles.N").to_string();
        assert!(said.contains("close are Axles.N1, Axles.N2"), "{said}");
    }
}
