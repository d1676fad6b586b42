//! The XML file of a device: its telegrams (`telegram name com-id data-set-id`), and the layout of their data sets
//! (`data-set id`, `element name type array-size scale offset`). Values lie one after another, most significant byte first, without gaps.
//!
//! An element of an array is `NAME[0]`, `NAME[1]`, …; one of a data set within a data set `OUTER.NAME`. What lies behind an array of
//! variable size has no fixed place and is not offered.

use crate::{Catalogue, Cell, FieldbusError, Kind, Message};
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::BTreeMap;

use super::telegram::LARGEST_DATA;

/// Data sets within data sets, at most.
const DEEPEST: usize = 5;

/// Reads the text of an XML file. A telegram that stands several times (once for each network) counts once.
///
/// # Errors
/// A text that is no XML; a telegram without a data set, a type that nobody knows, data that are too long.
pub fn read(text: &str) -> Result<Catalogue, FieldbusError> {
    // Without a document type: nothing can expand.
    let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
    let document =
        Document::parse_with_options(text, options).map_err(|error| FieldbusError::Xml(error.to_string()))?;
    let data_sets = data_sets(&document)?;
    let mut messages: Vec<Message> = Vec::new();
    let mut known: BTreeMap<u32, Option<&str>> = BTreeMap::new();
    for telegram in document.descendants().filter(|node| node.has_tag_name("telegram")) {
        let key = number(&telegram, "com-id")?;
        let data_set = telegram.attribute("data-set-id").map(str::trim);
        match known.insert(key, data_set) {
            Some(other) if other == data_set => continue,
            Some(_) => {
                return Err(wrong(&telegram, format!("com-id {key} stands twice, with two data sets")));
            }
            None => {}
        }
        let name = telegram.attribute("name").map_or_else(|| format!("telegram{key}"), str::to_owned);
        let mut layout = Layout { data_sets: &data_sets, telegram: &name, cells: Vec::new(), end: Some(0) };
        // A telegram without a data set is one for others to describe.
        if telegram.has_attribute("data-set-id") {
            let id = number(&telegram, "data-set-id")?;
            layout.add_data_set(&id.to_string(), "", 0)?;
        }
        messages.push(Message { key, name: name.clone(), cells: layout.cells });
    }
    if messages.is_empty() {
        return Err(FieldbusError::Xml("no <telegram>".to_owned()));
    }
    Ok(Catalogue { messages })
}

/// Data sets by their ids and names.
type DataSets<'a, 'd> = BTreeMap<&'a str, Node<'a, 'd>>;

fn data_sets<'a, 'd>(document: &'a Document<'d>) -> Result<DataSets<'a, 'd>, FieldbusError> {
    let mut found: DataSets<'a, 'd> = BTreeMap::new();
    for node in document.descendants().filter(|node| node.has_tag_name("data-set")) {
        if !node.children().any(|child| child.has_tag_name("element")) {
            return Err(wrong(&node, "a data set without any element".to_owned()));
        }
        let names = [node.attribute("id").map(str::trim), node.attribute("name")];
        let [id, name] = names;
        if let Some(id) = id
            && let Some(other) = found.insert(id, node)
            && !alike(&other, &node)
        {
            return Err(wrong(&node, format!("data set {id} stands twice, with other elements")));
        }
        // A name that is the number of another data set gives way to it.
        if let Some(name) = name.filter(|_| name != id) {
            found.entry(name).or_insert(node);
        }
    }
    Ok(found)
}

/// Whether two data sets have the same elements.
fn alike(a: &Node<'_, '_>, b: &Node<'_, '_>) -> bool {
    let elements = |node: &Node<'_, '_>| -> Vec<Vec<Option<String>>> {
        let keys = ["name", "type", "array-size", "scale", "offset"];
        let of = |element: Node<'_, '_>| keys.map(|key| element.attribute(key).map(str::to_owned)).to_vec();
        node.children().filter(|child| child.has_tag_name("element")).map(of).collect()
    };
    elements(a) == elements(b)
}

fn number(node: &Node<'_, '_>, attribute: &str) -> Result<u32, FieldbusError> {
    let given = node.attribute(attribute).unwrap_or_default();
    given.trim().parse().map_err(|_| wrong(node, format!("{attribute}=\"{given}\" is no number")))
}

fn wrong(node: &Node<'_, '_>, problem: String) -> FieldbusError {
    let line = node.document().text_pos_at(node.range().start).row;
    FieldbusError::Xml(format!("line {line}: {problem}"))
}

/// The values of one telegram.
struct Layout<'a, 'd> {
    data_sets: &'a DataSets<'a, 'd>,
    telegram: &'a str,
    cells: Vec<(String, Cell)>,
    /// Bytes so far; nothing behind an array of variable size.
    end: Option<usize>,
}

impl Layout<'_, '_> {
    /// Adds a data set by its id or name, its values under a prefix.
    fn add_data_set(&mut self, id: &str, prefix: &str, depth: usize) -> Result<(), FieldbusError> {
        let Some(found) = self.data_sets.get(id).copied() else {
            let said = format!("telegram {}: no data set or type {id}", self.telegram);
            return Err(FieldbusError::Xml(said));
        };
        if depth == DEEPEST {
            return Err(wrong(&found, format!("data sets within data sets, deeper than {DEEPEST}")));
        }
        for (place, element) in found.children().filter(|node| node.has_tag_name("element")).enumerate() {
            let name = element.attribute("name").map_or_else(|| format!("element{place}"), str::to_owned);
            self.add_element(&element, &format!("{prefix}{name}"), depth)?;
        }
        Ok(())
    }

    fn add_element(&mut self, element: &Node<'_, '_>, name: &str, depth: usize) -> Result<(), FieldbusError> {
        let given = element.attribute("type").unwrap_or_default().trim();
        let count = match element.attribute("array-size") {
            None => None,
            Some(_) => Some(number(element, "array-size")? as usize),
        };
        if count == Some(0) {
            self.end = None;
        }
        if count.is_some_and(|count| count > LARGEST_DATA) {
            return Err(wrong(
                element,
                format!("array-size: {LARGEST_DATA} bytes are all that a telegram has"),
            ));
        }
        let figure = |attribute: &str, default: f64| match element.attribute(attribute) {
            None => Ok(default),
            Some(given) => {
                let value = given.trim().parse().ok().filter(|value: &f64| value.is_finite());
                value.ok_or_else(|| wrong(element, format!("{attribute}=\"{given}\" is no number")))
            }
        };
        let (factor, offset) = (figure("scale", 1.0)?, figure("offset", 0.0)?);
        if factor == 0.0 {
            return Err(wrong(element, "scale=\"0\": nothing would be left of the value".to_owned()));
        }
        for place in 0..count.unwrap_or(1) {
            let Some(first) = self.end else { return Ok(()) };
            let name = if count.is_some_and(|count| count > 1) {
                format!("{name}[{place}]")
            } else {
                name.to_owned()
            };
            let Some((bytes, kind)) = basic(given) else {
                self.add_data_set(given, &format!("{name}."), depth + 1)?;
                continue;
            };
            self.end = Some(first + bytes);
            if first + bytes > LARGEST_DATA {
                return Err(wrong(element, format!("more than {LARGEST_DATA} bytes")));
            }
            self.cells.push((name, Cell { factor, offset, ..Cell::bytes(first, bytes, kind) }));
        }
        Ok(())
    }
}

/// Size in bytes and meaning of a basic type, by its number or its name.
fn basic(given: &str) -> Option<(usize, Kind)> {
    Some(match given.to_uppercase().as_str() {
        "1" | "BOOL8" | "BITSET8" | "ANTIVALENT8" | "2" | "CHAR8" | "UTF8" | "8" | "UINT8" => {
            (1, Kind::Unsigned)
        }
        "3" | "UTF16" | "9" | "UINT16" => (2, Kind::Unsigned),
        "4" | "INT8" => (1, Kind::Signed),
        "5" | "INT16" => (2, Kind::Signed),
        "6" | "INT32" => (4, Kind::Signed),
        "7" | "INT64" => (8, Kind::Signed),
        "10" | "UINT32" | "14" | "TIMEDATE32" => (4, Kind::Unsigned),
        "11" | "UINT64" => (8, Kind::Unsigned),
        "12" | "REAL32" => (4, Kind::Float32),
        "13" | "REAL64" => (8, Kind::Float64),
        "15" | "TIMEDATE48" => (6, Kind::SecondsAndTicks),
        "16" | "TIMEDATE64" => (8, Kind::SecondsAndMicroseconds),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"<?xml version="1.0"?>
<device host-name="bcu">
  <bus-interface-list><bus-interface network-id="1" name="eth0">
    <telegram name="brakes" com-id="2001" data-set-id="2001"/>
    <telegram name="other" com-id="2002"/>
  </bus-interface></bus-interface-list>
  <data-set-list>
    <data-set name="axle" id="2100"><element name="n" type="INT16" scale="0.1"/><element name="ok" type="BOOL8"/></data-set>
    <data-set name="brakes" id="2001">
      <element name="time" type="TIMEDATE64"/>
      <element name="axle" type="2100" array-size="2"/>
      <element name="p" type="12" unit="bar"/>
      <element name="flags" type="8" array-size="2"/>
      <element name="text" type="CHAR8" array-size="0"/>
      <element name="behind" type="INT8"/>
    </data-set>
  </data-set-list>
</device>"#;

    #[test]
    fn values_lie_one_after_another() {
        let catalogue = read(TEXT).expect("a description");
        let brakes = catalogue.message("brakes").expect("there");
        let places: Vec<_> = brakes
            .cells
            .iter()
            .map(|(name, cell)| (name.as_str(), cell.start_bit / 8, cell.bits / 8))
            .collect();
        let expected = [
            ("time", 0, 8),
            ("axle[0].n", 8, 2),
            ("axle[0].ok", 10, 1),
            ("axle[1].n", 11, 2),
            ("axle[1].ok", 13, 1),
            ("p", 14, 4),
            ("flags[0]", 18, 1),
            ("flags[1]", 19, 1),
        ];
        assert_eq!(places, expected);
        let n = catalogue.find("brakes.axle[1].n").expect("one").expect("there");
        let mut data = [0; 20];
        data[11..13].copy_from_slice(&(-455_i16).to_be_bytes());
        assert_eq!(n.cell.read(&data), Ok(-45.5));
        assert_eq!(catalogue.message("other").map(|message| message.cells.len()), Some(0));
    }

    /// Arrays of arrays of nothing once were counted through for ever.
    #[test]
    fn data_sets_of_nothing_are_refused_at_once() {
        let nested: String = (1..4)
            .map(|id| {
                let inner = id + 1;
                format!("<data-set id=\"{id}\"><element type=\"{inner}\" array-size=\"1432\"/></data-set>")
            })
            .collect();
        let text = format!("<d><telegram com-id=\"1\" data-set-id=\"1\"/>{nested}<data-set id=\"4\"/></d>");
        let said = read(&text).expect_err("nothing").to_string();
        assert!(said.contains("a data set without any element"), "{said}");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let said = |from: &str, to: &str| {
            let text = TEXT.replace(from, to);
            read(&text).expect_err("wrong").to_string()
        };
        assert!(said("type=\"12\"", "type=\"REAL16\"").contains("no data set or type REAL16"));
        assert!(said("com-id=\"2001\"", "com-id=\"x\"").contains("line 4: com-id=\"x\" is no number"));
        assert!(said("type=\"INT16\"", "type=\"axle\"").contains("deeper than 5"));
        assert!(said("array-size=\"2\"", "array-size=\"4000000000\"").contains("array-size"));
        assert!(said("scale=\"0.1\"", "scale=\"0\"").contains("nothing would be left"));
        let twice = said("com-id=\"2002\"", "com-id=\"2001\"");
        assert!(twice.contains("line 5: com-id 2001 stands twice"), "{twice}");
        let twice = said("id=\"2100\"", "id=\"2001\"");
        assert!(twice.contains("data set 2001 stands twice, with other elements"), "{twice}");
        assert!(read("<a/>").expect_err("empty").to_string().contains("no <telegram>"));
        let bomb = "<!DOCTYPE a [<!ENTITY b \"cc\">]><a>&b;</a>";
        assert!(read(bomb).is_err());
    }
}
