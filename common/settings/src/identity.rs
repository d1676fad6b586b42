//! Who a wagon is. Its place in the train changes with every consist; what is remembered of it belongs to its vehicle number.

use crate::SettingsError;
use crate::place::ConfigText;

/// Longest vehicle number as it is written, characters.
const LONGEST: usize = 32;

/// The number of a vehicle, for example `51 80 21-75 019-3` by UIC 438, or any that its keeper uses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VehicleNumber {
    written: String,
    key: String,
}

impl VehicleNumber {
    /// Takes a number as people write it: letters, digits, blanks, `-`, `.`, `/`.
    #[must_use]
    pub fn new(written: &str) -> Option<Self> {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, ' ' | '-' | '.' | '/');
        let key: String =
            written.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_uppercase()).collect();
        let fits = written.len() <= LONGEST && written.chars().all(plain) && !key.is_empty();
        fits.then(|| Self { written: written.trim().to_owned(), key })
    }

    /// As it was written.
    #[must_use]
    pub fn written(&self) -> &str {
        &self.written
    }

    /// Letters and digits alone: the same however somebody sets blanks and hyphens.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }
}

/// The number that a `[[wagon]]` table gives; `earlier` are those of the wagons before it.
pub(crate) fn number<'a>(
    at: &ConfigText<'_>,
    wagon: u32,
    given: Option<&str>,
    mut earlier: impl Iterator<Item = &'a VehicleNumber>,
) -> Result<Option<VehicleNumber>, SettingsError> {
    let Some(given) = given else { return Ok(None) };
    let key = format!("wagon.{wagon}.number");
    let allowed = format!("1 to {LONGEST} letters, digits, blanks, `-`, `.`, `/`");
    let number = VehicleNumber::new(given).ok_or_else(|| at.refuse(&key, format!("{given:?}"), allowed))?;
    if earlier.any(|other| other.key() == number.key()) {
        return Err(at.refuse(&key, format!("{given:?}"), "a vehicle number that no other wagon has"));
    }
    Ok(Some(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_the_same_however_it_is_written() {
        let [spaced, tight] =
            ["51 80 21-75 019-3", "518021750193"].map(|text| VehicleNumber::new(text).expect(text));
        assert_eq!((spaced.key(), spaced.written()), (tight.key(), "51 80 21-75 019-3"));
        for wrong in ["", " - ", "wagon\n1", "ä", &"1".repeat(33)] {
            assert_eq!(VehicleNumber::new(wrong), None, "{wrong:?}");
        }
    }
}
