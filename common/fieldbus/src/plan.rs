//! Which values of which messages become which columns of which wagon: the mapping, resolved once against a catalogue.
//!
//! In the names of a mapping `{wagon}` stands for the number of the wagon and `{wagon:02}` for the same with two digits, so that one
//! mapping serves a whole train on one bus.

use crate::catalogue::Found;
use crate::{Catalogue, Cell, FieldbusError};
use railgrip_recording::{Mapping, Quantity, Row, Rule};
use std::collections::{BTreeMap, HashMap};

/// How the messages of wagons are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lanes {
    /// All on one bus, by their names.
    Shared,
    /// By the interface or the sender that they come from: one lane a wagon, in the order of the train.
    OneEach,
}

/// One column of a wagon's rows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    pub quantity: Quantity,
    pub wheelset: usize,
    /// Absent where a value has the column's own name.
    pub rule: Option<Rule>,
    /// Slots of its inputs.
    pub slots: Vec<usize>,
    /// Slot of its quality flag.
    pub flag: Option<usize>,
}

/// One wagon.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct WagonPlan {
    pub columns: Vec<Column>,
    pub slots: usize,
}

/// A value that goes into a slot of a wagon.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Take {
    pub wagon: usize,
    pub slot: usize,
    pub cell: Cell,
}

/// What becomes of a message.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Wanted {
    pub takes: Vec<Take>,
    /// Wagons of which it makes a row.
    pub samples: Vec<usize>,
}

/// The mapping, resolved.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plan {
    pub(crate) wagons: Vec<WagonPlan>,
    /// By lane and key.
    pub(crate) wanted: HashMap<(usize, u32), Wanted>,
}

impl Plan {
    /// Resolves a mapping for wagons with so many wheelsets each. `sample_on` names the message that makes the rows of a wagon; without it
    /// that is the one with the speed of the first wheelset, else the one with the speed.
    ///
    /// # Errors
    /// Names that no message has or that several have, wagons that would get the same values, a wagon without a sample message.
    pub fn new(
        catalogue: &Catalogue,
        mapping: &Mapping,
        wheelsets: &[usize],
        lanes: Lanes,
        sample_on: Option<&str>,
    ) -> Result<Self, FieldbusError> {
        let mut plan = Self::default();
        let mut makers: BTreeMap<(usize, u32), usize> = BTreeMap::new();
        for (wagon, wheelsets) in wheelsets.iter().enumerate() {
            let lane = if lanes == Lanes::OneEach { wagon } else { 0 };
            let mut making = Making { catalogue, wagon, lane, slots: Vec::new(), wanted: &mut plan.wanted };
            let mut columns = Vec::new();
            for quantity in Quantity::ALL {
                for wheelset in 0..if quantity.per_wheelset() { *wheelsets } else { 1 } {
                    let name = quantity.column(wheelset, *wheelsets);
                    let rule = mapping.rules.iter().find(|rule| rule.to == name);
                    columns.extend(making.column(quantity, wheelset, &name, rule)?);
                }
            }
            let slots = making.slots.len();
            let maker = match sample_on {
                Some(name) => {
                    let name = of_wagon(name, wagon);
                    let message = catalogue.message(&name).ok_or_else(|| catalogue.unknown(&name))?;
                    (message.key, message.name.clone())
                }
                None => making.maker(&columns).ok_or(FieldbusError::NoSampleMessage { wagon: wagon + 1 })?,
            };
            let (key, name) = maker;
            // A message that makes rows of two wagons at once means that both have the same names.
            if let Some(first) = makers.insert((lane, key), wagon).filter(|_| sample_on.is_none()) {
                return Err(FieldbusError::Shared { first: first + 1, second: wagon + 1, name });
            }
            plan.wanted.entry((lane, key)).or_default().samples.push(wagon);
            plan.wagons.push(WagonPlan { columns, slots });
        }
        Ok(plan)
    }

    /// Identifiers of all messages that are wanted, once each.
    #[must_use]
    pub fn keys(&self) -> Vec<u32> {
        let mut keys: Vec<_> = self.wanted.keys().map(|(_, key)| *key).collect();
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    /// Whether the time of a wagon's rows comes from a message, and not from their arrival.
    #[must_use]
    pub fn carries_time(&self, wagon: usize) -> bool {
        let columns = self.wagons.get(wagon).map_or(&[][..], |wagon| &wagon.columns);
        columns.iter().any(|column| column.quantity == Quantity::Time)
    }
}

/// What a name of the mapping is for a wagon.
fn of_wagon(name: &str, wagon: usize) -> String {
    let number = wagon + 1;
    name.replace("{wagon}", &number.to_string()).replace("{wagon:02}", &format!("{number:02}"))
}

/// The plan of one wagon while it is made.
struct Making<'a> {
    catalogue: &'a Catalogue,
    wagon: usize,
    lane: usize,
    /// Full name and message of each slot.
    slots: Vec<(String, Found<'a>)>,
    wanted: &'a mut HashMap<(usize, u32), Wanted>,
}

impl Making<'_> {
    /// The column by its rule, or by its own name where a message has that; nothing where neither is there.
    fn column(
        &mut self,
        quantity: Quantity,
        wheelset: usize,
        name: &str,
        rule: Option<&Rule>,
    ) -> Result<Option<Column>, FieldbusError> {
        let Some(rule) = rule else {
            let Some(slot) = self.slot(name)? else { return Ok(None) };
            return Ok(Some(Column { quantity, wheelset, rule: None, slots: vec![slot], flag: None }));
        };
        let mut wanted = |name: &String| {
            let name = of_wagon(name, self.wagon);
            self.slot(&name)?.ok_or_else(|| self.catalogue.unknown(&name))
        };
        let slots = rule.from.iter().map(&mut wanted).collect::<Result<_, _>>()?;
        let flag = rule.flag.as_ref().map(|flag| wanted(&flag.from)).transpose()?;
        Ok(Some(Column { quantity, wheelset, rule: Some(rule.clone()), slots, flag }))
    }

    fn slot(&mut self, name: &str) -> Result<Option<usize>, FieldbusError> {
        let Some(found) = self.catalogue.find(name)? else { return Ok(None) };
        let full_name = found.full_name();
        if let Some(known) = self.slots.iter().position(|(known, _)| *known == full_name) {
            return Ok(Some(known));
        }
        let slot = self.slots.len();
        let take = Take { wagon: self.wagon, slot, cell: found.cell.clone() };
        self.wanted.entry((self.lane, found.message.key)).or_default().takes.push(take);
        self.slots.push((full_name, found));
        Ok(Some(slot))
    }

    /// Key and name of the message that makes rows where nobody says another.
    fn maker(&self, columns: &[Column]) -> Option<(u32, String)> {
        let of = |quantity: Quantity| {
            columns.iter().find(|column| column.quantity == quantity && column.wheelset == 0)
        };
        let column = of(Quantity::WheelSpeed).or_else(|| of(Quantity::Speed))?;
        let (name, found) = self.slots.get(*column.slots.first()?)?;
        Some((found.message.key, name.clone()))
    }
}

impl WagonPlan {
    /// The row of what `held` gives of the slots; `t_s` where no message carries the time.
    pub fn row(&self, t_s: f64, held: &dyn Fn(usize) -> f64, inputs: &mut Vec<f64>) -> Row {
        let mut row = Row { t_s, ..Row::default() };
        for column in &self.columns {
            inputs.clear();
            inputs.extend(column.slots.iter().map(|slot| held(*slot)));
            let good = match (column.flag, column.rule.as_ref().and_then(|rule| rule.flag.as_ref())) {
                (Some(slot), Some(flag)) => held(slot) == flag.is,
                _ => true,
            };
            let value = match &column.rule {
                _ if !good => f64::NAN,
                Some(rule) => rule.of(inputs),
                None => inputs.first().copied().unwrap_or(f64::NAN),
            };
            *row.get_mut(column.quantity, column.wheelset) = value;
        }
        row
    }
}
