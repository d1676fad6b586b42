//! Asks a type what it reads: a deserializer that has no text, gives each field something of the kind that it asks for, and takes note.

use serde::de::value::{Error, StrDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess, SeqAccess,
    VariantAccess, Visitor,
};
use std::cell::RefCell;

/// A key as its type declares it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Traced {
    /// Dotted; `[]` stands for one of a list of tables, `NAME` for a name that is free.
    pub name: String,
    /// What it takes.
    pub takes: String,
    /// The type that has it as a field.
    pub of: &'static str,
    /// Whether it may be absent without another value in its place.
    pub optional: bool,
}

/// All fields of a type that lies at a key, in its order, but for those at the top that are to be skipped.
///
/// # Errors
/// A field that wants to see its text before it says what it is; it must be skipped.
pub(crate) fn trace<T: DeserializeOwned>(at: &str, skip: &[&str]) -> Result<Vec<Traced>, Error> {
    let found = RefCell::new(Vec::new());
    let tracer = Tracer { path: at.to_owned(), list: false, found: &found, skip, of: "", optional: false };
    T::deserialize(tracer)?;
    Ok(found.into_inner())
}

/// Stands for the value of one key.
struct Tracer<'a> {
    path: String,
    /// It stands in a list.
    list: bool,
    found: &'a RefCell<Vec<Traced>>,
    skip: &'a [&'a str],
    /// The type that it is a field of.
    of: &'static str,
    optional: bool,
}

impl<'a> Tracer<'a> {
    fn note(&self, one: &str, several: &str) {
        let takes = if self.list { format!("a list of {several}") } else { one.to_owned() };
        let name = self.path.trim_end_matches("[]").to_owned();
        let (of, optional) = (self.of, self.optional);
        self.found.borrow_mut().push(Traced { name, takes, of, optional });
    }

    fn inner(&self, name: &str, of: &'static str) -> Self {
        let path = if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) };
        Self { path, list: false, found: self.found, skip: &[], of, optional: false }
    }

    fn items(self, count: usize) -> Several<'a> {
        let path = format!("{}[]", self.path);
        Several { inner: Self { path, list: true, ..self }, left: count }
    }

    fn fields(self, of: &'static str, names: &[&'static str]) -> Fields<'a> {
        let names: Vec<_> = names.iter().copied().filter(|name| !self.skip.contains(name)).collect();
        Fields { holder: self, of, names: names.into_iter().peekable() }
    }
}

macro_rules! plain {
    ($($method:ident, $visit:ident, $value:expr, $one:literal, $several:literal;)+) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            self.note($one, $several);
            visitor.$visit($value)
        })+
    };
}

impl<'de> Deserializer<'de> for Tracer<'_> {
    type Error = Error;

    plain! {
        // Who takes anything looks at what comes: here, a text or a list of texts.
        deserialize_any, visit_str, "x", "a text or a list", "anything";
        deserialize_bool, visit_bool, true, "true or false", "true or false";
        deserialize_i8, visit_i8, 1, "a whole number", "whole numbers";
        deserialize_i16, visit_i16, 1, "a whole number", "whole numbers";
        deserialize_i32, visit_i32, 1, "a whole number", "whole numbers";
        deserialize_i64, visit_i64, 1, "a whole number", "whole numbers";
        deserialize_u8, visit_u8, 1, "a whole number", "whole numbers";
        deserialize_u16, visit_u16, 1, "a whole number", "whole numbers";
        deserialize_u32, visit_u32, 1, "a whole number", "whole numbers";
        deserialize_u64, visit_u64, 1, "a whole number", "whole numbers";
        deserialize_f32, visit_f32, 1.0, "a number", "numbers";
        deserialize_f64, visit_f64, 1.0, "a number", "numbers";
        deserialize_char, visit_char, 'x', "a letter", "letters";
        deserialize_str, visit_str, "x", "a text", "texts";
        deserialize_string, visit_str, "x", "a text", "texts";
        deserialize_bytes, visit_bytes, &[], "bytes", "bytes";
        deserialize_byte_buf, visit_bytes, &[], "bytes", "bytes";
        deserialize_identifier, visit_str, "x", "a text", "texts";
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(Self { optional: true, ..self })
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(self.items(1))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(self.items(length))
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_map(self.fields("", &["NAME"]))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_map(self.fields(name, fields))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let all = variants.join(", ");
        self.note(&all, &all);
        visitor.visit_enum(First(variants.first().copied().unwrap_or_default()))
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }
}

/// The fields of a table, or one entry of a free name.
struct Fields<'a> {
    holder: Tracer<'a>,
    of: &'static str,
    names: std::iter::Peekable<std::vec::IntoIter<&'static str>>,
}

impl<'de> MapAccess<'de> for Fields<'_> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Error> {
        let Some(name) = self.names.peek().copied() else { return Ok(None) };
        let name: StrDeserializer<'_, Error> = name.into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Error> {
        let name = self.names.next().unwrap_or_default();
        seed.deserialize(self.holder.inner(name, self.of))
    }
}

/// The items of a list.
struct Several<'a> {
    inner: Tracer<'a>,
    left: usize,
}

impl<'de> SeqAccess<'de> for Several<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        let Tracer { path, list, found, of, optional, .. } = &self.inner;
        let item = Tracer { path: path.clone(), list: *list, found, skip: &[], of, optional: *optional };
        seed.deserialize(item).map(Some)
    }
}

/// The first word of an enumeration.
struct First(&'static str);

impl<'de> EnumAccess<'de> for First {
    type Error = Error;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Error> {
        let word: StrDeserializer<'_, Error> = self.0.into_deserializer();
        Ok((seed.deserialize(word)?, self))
    }
}

impl<'de> VariantAccess<'de> for First {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Error> {
        let word: StrDeserializer<'_, Error> = self.0.into_deserializer();
        seed.deserialize(word)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }
}
