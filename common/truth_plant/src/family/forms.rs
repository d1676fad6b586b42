//! Forms of effects: what they are called, to which set they belong, and how one is drawn.

pub use super::set::FormSet;
use super::{
    moment::Departure,
    sheet::{FamilySheet, Needs},
};
use crate::random::Stream;

/// What a form draws from.
pub struct Draw<'a> {
    /// Size over the usual one.
    pub strength: f64,
    /// Randomness of this effect alone.
    pub stream: Stream,
    /// The vehicle.
    pub sheet: &'a FamilySheet,
    /// What was drawn, by name.
    pub parameters: Vec<(&'static str, f64)>,
}

impl Draw<'_> {
    /// A size: uniform between two usual sizes, times the strength.
    pub fn size(&mut self, name: &'static str, low: f64, high: f64) -> f64 {
        let value = self.strength * self.stream.uniform(low, high);
        self.note(name, value)
    }

    /// A size that never exceeds a bound.
    pub fn size_below(&mut self, name: &'static str, low: f64, high: f64, most: f64) -> f64 {
        let value = (self.strength * self.stream.uniform(low, high)).min(most);
        self.note(name, value)
    }

    /// A size of either sign.
    pub fn signed_size(&mut self, name: &'static str, low: f64, high: f64) -> f64 {
        let value = self.stream.sign() * self.strength * self.stream.uniform(low, high);
        self.note(name, value)
    }

    /// A shape, whatever the strength.
    pub fn shape(&mut self, name: &'static str, low: f64, high: f64) -> f64 {
        let value = self.stream.uniform(low, high);
        self.note(name, value)
    }

    /// One of the wheelsets.
    pub fn wheelset(&mut self) -> usize {
        let wheelset = self.stream.below(self.sheet.wheelsets);
        self.note("wheelset", wheelset as f64);
        wheelset
    }

    fn note(&mut self, name: &'static str, value: f64) -> f64 {
        self.parameters.push((name, value));
        value
    }
}

/// One functional form of an effect.
pub struct Form {
    /// Name within its effect.
    pub name: &'static str,
    /// The set it belongs to.
    pub set: FormSet,
    draw: fn(&mut Draw) -> Box<dyn Departure>,
}

impl Form {
    /// A form.
    #[must_use]
    pub const fn new(name: &'static str, set: FormSet, draw: fn(&mut Draw) -> Box<dyn Departure>) -> Self {
        Self { name, set, draw }
    }

    /// Draws the departure and says its parameters; the same seed and another strength give the same departure, larger or
    /// smaller.
    #[must_use]
    pub fn draw(
        &self,
        strength: f64,
        stream: Stream,
        sheet: &FamilySheet,
    ) -> (Box<dyn Departure>, Vec<(&'static str, f64)>) {
        let mut draw = Draw { strength, stream, sheet, parameters: Vec::new() };
        let departure = (self.draw)(&mut draw);
        (departure, draw.parameters)
    }
}

impl std::fmt::Debug for Form {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} ({})", self.name, self.set.letter())
    }
}

/// An effect with all its forms.
#[derive(Debug)]
pub struct Effect {
    /// Id of the contract, or a name of its own for one that no id names.
    pub id: &'static str,
    /// Term of the equations.
    pub term: &'static str,
    /// Whether the contract has an id for it.
    pub named: bool,
    /// What a vehicle must have for it.
    pub needs: Needs,
    /// Whether it is best seen on low rail.
    pub low_rail: bool,
    /// Its forms.
    pub forms: &'static [Form],
}

impl Effect {
    /// An effect with an id of the contract.
    #[must_use]
    pub const fn named(id: &'static str, term: &'static str, forms: &'static [Form]) -> Self {
        Self { id, term, named: true, needs: Needs { motor: false, sander: false }, low_rail: false, forms }
    }

    /// An effect that no id names.
    #[must_use]
    pub const fn nameless(id: &'static str, term: &'static str, forms: &'static [Form]) -> Self {
        Self { named: false, ..Self::named(id, term, forms) }
    }

    /// The same, best seen on low rail.
    #[must_use]
    pub const fn on_low_rail(self) -> Self {
        Self { low_rail: true, ..self }
    }

    /// The same, on vehicles with motors alone.
    #[must_use]
    pub const fn with_motor(self) -> Self {
        Self { needs: Needs { motor: true, sander: self.needs.sander }, ..self }
    }

    /// The same, on vehicles with sanders alone.
    #[must_use]
    pub const fn with_sander(self) -> Self {
        Self { needs: Needs { motor: self.needs.motor, sander: true }, ..self }
    }

    /// Its forms of one set.
    pub fn forms_of(&self, set: FormSet) -> impl Iterator<Item = &'static Form> {
        self.forms.iter().filter(move |form| form.set == set)
    }
}
