//! No two files of a crate use each other in a circle.
//!
//! **The rule.** File A uses file B if its code names something that B defines: by `use`, or by a path in the code. A name
//! that comes by way of a facade (`pub use` in a `lib.rs` or `mod.rs`) counts for the file that defines it, so a child that
//! takes its brother's type from `super::` uses the brother. Declaring a module and passing a name on are signposts and no
//! uses: a facade may list its children, and a child may use what the facade defines, as long as the facade's own code
//! does not name the child's things. Code under `#[cfg(test)]` and methods called on values are not looked at.
//!
//! `tree` finds who uses whom, `source` reads one file. A circle fails the test with its files and the names that tie it.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

mod source;
mod tree;

use std::path::{Path, PathBuf};
use tree::{Tree, Uses};

/// Folders whose members are looked at.
const MEMBERS: [&str; 2] = ["common", "services"];

/// The shortest circle through each knot of files that use each other, in words; empty if there is none.
fn circles(tree: &Tree) -> Vec<String> {
    let uses = tree.uses();
    let mut told = vec![false; tree.nodes.len()];
    let mut found = Vec::new();
    for start in 0..tree.nodes.len() {
        let Some(circle) = shortest_circle(tree.nodes.len(), &uses, start) else { continue };
        if !told[start] {
            found.push(in_words(tree, &uses, &circle));
        }
        circle.iter().for_each(|&file| told[file] = true);
    }
    found
}

/// The shortest way from a file back to itself.
fn shortest_circle(files: usize, uses: &Uses, start: usize) -> Option<Vec<usize>> {
    let mut came_from = vec![None; files];
    let mut queue = std::collections::VecDeque::from([start]);
    while let Some(file) = queue.pop_front() {
        for &(_, next) in uses.keys().filter(|(from, _)| *from == file) {
            if next == start {
                let mut circle = vec![file];
                while let Some(before) = came_from[circle[circle.len() - 1]] {
                    circle.push(before);
                }
                circle.reverse();
                return Some(circle);
            }
            if came_from[next].is_none() {
                came_from[next] = Some(file);
                queue.push_back(next);
            }
        }
    }
    None
}

fn in_words(tree: &Tree, uses: &Uses, circle: &[usize]) -> String {
    let arrow = |position: usize| {
        let (from, to) = (circle[position], circle[(position + 1) % circle.len()]);
        let names = uses.get(&(from, to)).into_iter().flatten().map(String::as_str);
        let names: Vec<&str> = names.take(4).collect();
        format!("{} takes {} from {}", tree.nodes[from].file, names.join(", "), tree.nodes[to].file)
    };
    (0..circle.len()).map(arrow).collect::<Vec<_>>().join("; ")
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The members below `folder` with their folder of sources.
fn members(folder: &str) -> Vec<(String, PathBuf)> {
    let entries = std::fs::read_dir(repository().join(folder)).expect("folder of members");
    let mut members: Vec<_> = entries
        .map(|entry| entry.expect("entry").path())
        .filter(|path| path.join("Cargo.toml").is_file())
        .map(|path| (path.file_name().unwrap_or_default().to_string_lossy().into_owned(), path.join("src")))
        .collect();
    members.sort();
    members
}

#[test]
fn no_two_files_use_each_other_in_a_circle() {
    let (mut files, mut arrows, mut found) = (0, 0, Vec::new());
    for (member, sources) in MEMBERS.into_iter().flat_map(members) {
        let tree = Tree::read("lib.rs", &|path| std::fs::read_to_string(sources.join(path)).ok());
        assert!(!tree.nodes.is_empty(), "{member} has no lib.rs that can be read");
        (files, arrows) = (files + tree.nodes.len(), arrows + tree.uses().len());
        found.extend(circles(&tree).into_iter().map(|circle| format!("{member}: {circle}")));
    }
    println!("{files} files, {arrows} uses between them, {} circles", found.len());
    assert!(files > 300, "only {files} files were read: the search does not find the sources");
    assert!(found.is_empty(), "circles between files:\n{}", found.join("\n"));
}

/// A crate of these files (path, text).
fn planted(files: &[(&str, &str)]) -> Tree {
    Tree::read("lib.rs", &|path| {
        files.iter().find(|(name, _)| Path::new(name) == path).map(|(_, text)| (*text).to_owned())
    })
}

#[test]
fn a_planted_circle_is_found_and_named() {
    let tree = planted(&[
        ("lib.rs", "mod a; mod b; mod c; pub use a::One;"),
        ("a.rs", "use crate::b::Two; pub struct One(pub Two);"),
        ("b.rs", "pub struct Two; fn f() { let _ = crate::c::three(); }"),
        ("c.rs", "pub fn three() -> Option<crate::One> { None }"),
    ]);
    let found = circles(&tree);
    assert_eq!(found, ["a.rs takes Two from b.rs; b.rs takes three from c.rs; c.rs takes One from a.rs"]);
}

#[test]
fn a_circle_through_a_facade_is_found_where_its_own_code_uses_the_child() {
    let child = ("table/row.rs", "use super::Cell; pub fn row(_: Cell) {}");
    let uses = "mod row; pub use row::row; pub struct Cell; pub fn all() { row(Cell) }";
    let found = circles(&planted(&[("lib.rs", "mod table;"), ("table/mod.rs", uses), child]));
    assert_eq!(found.len(), 1, "{found:?}");
    let found = circles(&planted(&[("lib.rs", "mod table;"), ("table.rs", uses), child]));
    assert_eq!(found.len(), 1, "the same in the other layout: {found:?}");
}

#[test]
fn signposts_tests_and_words_in_strings_are_no_uses() {
    let tree = planted(&[
        ("lib.rs", "mod a; mod b; pub use a::{One, self as first}; pub use b::*; pub struct Base;"),
        ("a.rs", "use crate::Base; pub struct One(Base); #[cfg(test)] mod tests { use crate::b::Two; }"),
        (
            "b.rs",
            "//! Like crate::a::One.\nuse super::One; pub struct Two; const T: &str = \"crate::b::Two\"; fn f(_: One) {}",
        ),
    ]);
    assert_eq!(circles(&tree), Vec::<String>::new());
    let names: Vec<_> = tree.uses().keys().map(|&(from, to)| (from, to)).collect();
    assert_eq!(names.len(), 2, "a uses the root, b uses a: {names:?}");
}

#[test]
fn names_are_followed_through_globs_renames_and_groups() {
    let tree = planted(&[
        ("lib.rs", "mod a; mod b; pub mod prelude { pub use crate::a::One as First; }"),
        ("a.rs", "use crate::b::{self, Two as Second}; pub struct One(Second); fn f() { b::g(); }"),
        ("b.rs", "use super::a::*; pub struct Two; pub fn g() -> Option<One> { None }"),
    ]);
    assert_eq!(circles(&tree), ["a.rs takes Two, g from b.rs; b.rs takes One from a.rs"]);
}
