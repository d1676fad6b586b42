//! Messages with `{names}`: filling them in, and finding what was filled in.

/// A part of a message, for whoever fills in more than text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Piece {
    /// As it stands.
    Text(&'static str),
    /// The name of what is filled in.
    Name(&'static str),
}

/// The parts of a message, one after the other; an open bracket that nothing closes is text.
pub(super) fn pieces(message: &'static str) -> impl Iterator<Item = Piece> {
    let named = |(at, part): (usize, &'static str)| match part.split_once('}') {
        Some((name, behind)) if at > 0 => [Some(Piece::Name(name)), Some(Piece::Text(behind))],
        _ => [None, Some(Piece::Text(part))],
    };
    let all = message.split('{').enumerate().flat_map(named).flatten();
    all.filter(|piece| *piece != Piece::Text(""))
}

/// A message cut into what is always there and what is filled in.
#[derive(Debug)]
pub(super) struct Pattern {
    /// Text before the first name, between names, and behind the last: one more than names.
    fixed: Vec<&'static str>,
    names: Vec<&'static str>,
}

impl Pattern {
    /// `None` if nothing is filled in.
    pub fn new(message: &'static str) -> Option<Self> {
        let (mut fixed, mut names, mut rest) = (Vec::new(), Vec::new(), message);
        while let Some((before, behind)) = rest.split_once('{') {
            let (name, behind) = behind.split_once('}')?;
            fixed.push(before);
            names.push(name);
            rest = behind;
        }
        fixed.push(rest);
        (!names.is_empty()).then_some(Self { fixed, names })
    }

    /// Length of what is always there: the longer, the surer a match.
    pub fn weight(&self) -> usize {
        self.fixed.iter().map(|text| text.len()).sum()
    }

    /// The first way in which a sentence fits such that `understood` takes every argument.
    pub fn find<'a, T>(
        &self,
        sentence: &'a str,
        understood: &mut impl FnMut(&'static str, &'a str) -> Option<T>,
    ) -> Option<Vec<(&'static str, T)>> {
        let rest = sentence.strip_prefix(self.fixed[0])?;
        let mut found = Vec::with_capacity(self.names.len());
        self.rest(0, rest, understood, &mut found).then(|| {
            found.reverse();
            found
        })
    }

    /// Argument `at` and all behind it; fills `found` from the last on.
    fn rest<'a, T>(
        &self,
        at: usize,
        sentence: &'a str,
        understood: &mut impl FnMut(&'static str, &'a str) -> Option<T>,
        found: &mut Vec<(&'static str, T)>,
    ) -> bool {
        let Some(name) = self.names.get(at).copied() else { return sentence.is_empty() };
        let behind = self.fixed[at + 1];
        if at + 1 == self.names.len() {
            let Some(argument) = sentence.strip_suffix(behind).filter(|text| !text.is_empty()) else {
                return false;
            };
            let Some(taken) = understood(name, argument) else { return false };
            found.push((name, taken));
            return true;
        }
        for (end, _) in sentence.match_indices(behind).filter(|(end, _)| *end > 0) {
            // What follows first: it is often a number, which costs less to look at than a sentence.
            if !self.rest(at + 1, &sentence[end + behind.len()..], understood, found) {
                continue;
            }
            if let Some(taken) = understood(name, &sentence[..end]) {
                found.push((name, taken));
                return true;
            }
            found.clear();
        }
        false
    }
}

/// Fills in a message.
pub(super) fn fill<'a>(message: &str, mut argument: impl FnMut(&str) -> &'a str) -> String {
    let mut text = String::with_capacity(2 * message.len());
    let mut rest = message;
    while let Some((before, behind)) = rest.split_once('{') {
        let Some((name, behind)) = behind.split_once('}') else { break };
        text.push_str(before);
        text.push_str(argument(name));
        rest = behind;
    }
    text.push_str(rest);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_is_found_only_where_all_of_it_is_there() {
        let pattern = Pattern::new("{a} of {b}: {c}").unwrap();
        let take = |text: &'static str| pattern.find(text, &mut |_, argument| Some(argument.to_owned()));
        let found: Vec<String> =
            take("one of two: three").unwrap().into_iter().map(|(_, text)| text).collect();
        assert_eq!(found, ["one", "two", "three"]);
        assert!(take("one of two").is_none());
    }

    #[test]
    fn a_message_is_cut_at_its_names() {
        let parts = |message| pieces(message).collect::<Vec<_>>();
        use Piece::{Name, Text};
        assert_eq!(
            parts("In {place}: {gap} there"),
            [Text("In "), Name("place"), Text(": "), Name("gap"), Text(" there")]
        );
        assert_eq!(parts("{all}"), [Name("all")]);
        assert_eq!(parts("nothing"), [Text("nothing")]);
    }
}
