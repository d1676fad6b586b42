//! The languages, and which of them somebody's settings ask for.

/// A language of pages and reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Language {
    /// British English.
    #[default]
    English,
    /// German.
    German,
}

impl Language {
    /// All of them, with their own names.
    pub const ALL: [(Self, &'static str); 2] = [(Self::English, "English"), (Self::German, "Deutsch")];

    /// Its tag, as in `<html lang>`.
    #[must_use]
    pub const fn tag(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
        }
    }

    /// From a tag such as `de`, `de-AT` or `de_DE.UTF-8`.
    #[must_use]
    pub fn parse(tag: &str) -> Option<Self> {
        let first = tag.split(['-', '_', '.', '@']).next().unwrap_or_default();
        Self::ALL.into_iter().map(|(one, _)| one).find(|one| first.eq_ignore_ascii_case(one.tag()))
    }

    /// The one that values of the header `Accept-Language` like best; English where they name none that there is.
    pub fn accepted<'a>(values: impl Iterator<Item = &'a str>) -> Self {
        let mut best = (0.0, Self::English);
        for range in values.flat_map(|value| value.split(',')) {
            let mut parts = range.split(';').map(str::trim);
            let language = parts.next().and_then(Self::parse);
            let weight = parts.find_map(|part| part.strip_prefix("q=")).map_or(Ok(1.0), str::parse);
            if let (Some(language), Ok(weight)) = (language, weight)
                && weight > best.0
            {
                best = (weight, language);
            }
        }
        best.1
    }

    /// The one of a terminal: the first variable that is set of `LC_ALL`, `LC_MESSAGES` and `LANG` decides, as POSIX has it;
    /// English where it names none that there is. `variable` looks one up.
    pub fn of_locale(variable: impl Fn(&str) -> Option<String>) -> Self {
        let set = |name: &&str| variable(name).filter(|value| !value.is_empty());
        let first = ["LC_ALL", "LC_MESSAGES", "LANG"].iter().find_map(set);
        first.and_then(|value| Self::parse(&value)).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_weighed() {
        for (accept, language) in [
            ("de-DE,de;q=0.9,en;q=0.8", Language::German),
            ("en-GB,en;q=0.9,de;q=0.8", Language::English),
            ("fr-FR,fr;q=0.9", Language::English),
            ("fr, de;q=0.3", Language::German),
            ("de;q=0", Language::English),
            ("", Language::English),
        ] {
            assert_eq!(Language::accepted(std::iter::once(accept)), language, "{accept:?}");
        }
    }

    #[test]
    fn the_locale_is_that_of_the_first_variable_that_is_set() {
        for (all, messages, lang, language) in [
            ("", "", "de_DE.UTF-8", Language::German),
            ("C", "", "de_DE.UTF-8", Language::English),
            ("", "de_AT", "en_GB.UTF-8", Language::German),
            ("", "", "", Language::English),
        ] {
            let variable = |name: &str| match name {
                "LC_ALL" => Some(all.to_owned()),
                "LC_MESSAGES" => Some(messages.to_owned()),
                _ => Some(lang.to_owned()).filter(|lang| !lang.is_empty()),
            };
            assert_eq!(Language::of_locale(variable), language, "{all:?} {messages:?} {lang:?}");
        }
    }
}
