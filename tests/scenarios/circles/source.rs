//! What one source file says about others: its modules, the names it defines, its imports and the paths in its code.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use std::collections::BTreeSet;

/// A path such as `crate::core::Gaussian`, segment by segment.
pub type Path = Vec<String>;

/// One name that a `use` brings in.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// The name it has in this file; `*` for all names of a module.
    pub name: String,
    /// Where it comes from.
    pub path: Path,
    /// `pub use`, of any reach: the file passes the name on.
    pub passed_on: bool,
}

/// One source file.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Modules with a file of their own.
    pub modules: Vec<String>,
    /// Names defined at the top of the file.
    pub defined: BTreeSet<String>,
    /// What its `use` lines bring in.
    pub imports: Vec<Import>,
    /// Paths of two segments and more in its code.
    pub paths: Vec<Path>,
    /// Every identifier of its code outside of `use` lines.
    pub words: BTreeSet<String>,
}

/// Reads a file; `None` if it is no Rust. Code under `#[cfg(test)]` is left out: a test may look at anything.
pub fn read(text: &str) -> Option<Source> {
    let mut source = Source::default();
    source.walk(text.parse().ok()?, 0);
    Some(source)
}

fn is_punct(token: Option<&TokenTree>, wanted: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == wanted)
}

fn ident(token: Option<&TokenTree>) -> Option<String> {
    match token {
        Some(TokenTree::Ident(ident)) => Some(ident.to_string()),
        _ => None,
    }
}

/// The group of an attribute `#[…]` that begins at `at`.
fn attribute(tokens: &[TokenTree], at: usize) -> Option<&Group> {
    match tokens.get(at + 1) {
        Some(TokenTree::Group(group))
            if is_punct(tokens.get(at), '#') && group.delimiter() == Delimiter::Bracket =>
        {
            Some(group)
        }
        _ => None,
    }
}

/// Where the item that begins at `at` ends.
fn end_of_item(tokens: &[TokenTree], at: usize) -> usize {
    let ends = |token: &TokenTree| match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        other => is_punct(Some(other), ';'),
    };
    tokens[at..].iter().position(ends).map_or(tokens.len(), |length| at + length + 1)
}

impl Source {
    /// `depth` counts the inline modules around; they belong to the file.
    fn walk(&mut self, stream: TokenStream, depth: usize) {
        let tokens: Vec<TokenTree> = stream.into_iter().collect();
        let (mut at, mut passed_on, mut in_test) = (0, false, false);
        while at < tokens.len() {
            if let Some(group) = attribute(&tokens, at) {
                in_test |= group.stream().to_string().replace(' ', "") == "cfg(test)";
                at += 2;
                continue;
            }
            if in_test {
                (at, in_test) = (end_of_item(&tokens, at), false);
                continue;
            }
            let word = ident(tokens.get(at)).unwrap_or_default();
            match word.as_str() {
                "pub" => {
                    passed_on = true;
                    let reach = matches!(tokens.get(at + 1), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
                    at += if reach { 2 } else { 1 };
                    continue;
                }
                "use" => {
                    let end = end_of_use(&tokens, at);
                    self.import(&tokens[at + 1..end], &mut Vec::new(), depth, passed_on);
                    at = end;
                }
                "mod" => at = self.module(&tokens, at, depth),
                "fn" | "struct" | "enum" | "trait" | "type" | "const" | "static" | "union" if depth == 0 => {
                    self.defined.extend(ident(tokens.get(at + 1)).filter(|name| name != "mut"));
                    at += 1;
                }
                _ => at = self.code(&tokens, at, depth),
            }
            passed_on = false;
        }
    }

    fn module(&mut self, tokens: &[TokenTree], at: usize, depth: usize) -> usize {
        let Some(name) = ident(tokens.get(at + 1)) else { return at + 1 };
        match tokens.get(at + 2) {
            Some(TokenTree::Group(group)) => {
                self.defined.insert(name);
                self.walk(group.stream(), depth + 1);
            }
            _ => self.modules.push(name),
        }
        at + 3
    }

    /// Code at `at`: a path, a group, or a single token.
    fn code(&mut self, tokens: &[TokenTree], at: usize, depth: usize) -> usize {
        if let TokenTree::Group(group) = &tokens[at] {
            self.inside(group, depth);
            return at + 1;
        }
        let follows = |at: usize| is_punct(tokens.get(at), ':') && is_punct(tokens.get(at + 1), ':');
        let Some(first) = ident(tokens.get(at)) else { return at + 1 };
        let mut path = vec![first];
        let mut next = at + 1;
        while follows(next) {
            let Some(segment) = ident(tokens.get(next + 2)) else { break };
            path.push(segment);
            next += 3;
        }
        self.words.extend(path.iter().cloned());
        let absolute = at >= 2 && follows(at - 2);
        if path.len() > 1 && !absolute {
            self.paths.push(outside(path, depth));
        }
        next
    }

    /// The inside of a body defines nothing that other files could name, but it uses names.
    fn inside(&mut self, group: &Group, depth: usize) {
        let mut body = Source::default();
        body.walk(group.stream(), depth);
        self.imports.extend(body.imports.into_iter().map(|import| Import { passed_on: false, ..import }));
        self.paths.extend(body.paths);
        self.words.extend(body.words);
    }

    fn import(&mut self, tokens: &[TokenTree], prefix: &mut Path, depth: usize, passed_on: bool) {
        let before = prefix.len();
        let mut renamed = None;
        let mut at = 0;
        while at < tokens.len() {
            match &tokens[at] {
                TokenTree::Ident(word) if word == "as" => {
                    renamed = ident(tokens.get(at + 1));
                    at += 1;
                }
                TokenTree::Ident(word) => prefix.push(word.to_string()),
                TokenTree::Punct(punct) if punct.as_char() == '*' => prefix.push("*".to_owned()),
                TokenTree::Group(group) => {
                    let parts: Vec<TokenTree> = group.stream().into_iter().collect();
                    for part in
                        parts.split(|token| is_punct(Some(token), ',')).filter(|part| !part.is_empty())
                    {
                        self.import(part, prefix, depth, passed_on);
                    }
                    prefix.truncate(before);
                    return;
                }
                _ => {}
            }
            at += 1;
        }
        let mut path = prefix.clone();
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        if let Some(name) = renamed.or_else(|| path.last().cloned()) {
            self.imports.push(Import { name, path: outside(path, depth), passed_on });
        }
        prefix.truncate(before);
    }
}

/// `use a::{b, c};` ends at the semicolon, whatever braces it holds.
fn end_of_use(tokens: &[TokenTree], at: usize) -> usize {
    let length = tokens[at..].iter().position(|token| is_punct(Some(token), ';'));
    length.map_or(tokens.len(), |length| at + length)
}

/// A path of an inline module as the file around it would write it.
fn outside(mut path: Path, depth: usize) -> Path {
    for _ in 0..depth {
        if path.first().is_some_and(|first| first == "super") {
            path[0] = "self".to_owned();
            if path.get(1).is_some_and(|second| second == "super") {
                path.remove(0);
            }
        }
    }
    path
}
