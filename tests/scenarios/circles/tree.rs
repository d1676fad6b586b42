//! The files of one crate as a tree of modules, and which file a path leads to.

use super::source::{Import, Source, read};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Imports that pass a name on to each other this often are no code that compiles.
const DEEPEST: usize = 16;

/// One file of a crate.
#[derive(Debug)]
pub struct Node {
    /// Where it lies below the crate's folder of sources.
    pub file: String,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    source: Source,
}

/// The files of a crate; the first is its root.
#[derive(Debug, Default)]
pub struct Tree {
    pub nodes: Vec<Node>,
}

/// What a path leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// An item of this file.
    Item(usize),
    /// A module as such.
    Module(usize),
}

/// Which file takes which names from which.
pub type Uses = BTreeMap<(usize, usize), BTreeSet<String>>;

impl Tree {
    /// Reads a crate from its root file, which `load` finds like every other (path below the sources → text).
    pub fn read(root: &str, load: &dyn Fn(&Path) -> Option<String>) -> Self {
        let mut tree = Self::default();
        tree.add(Path::new(root), None, Path::new(""), load);
        tree
    }

    /// Adds a file whose modules lie in `folder`.
    fn add(
        &mut self,
        file: &Path,
        parent: Option<usize>,
        folder: &Path,
        load: &dyn Fn(&Path) -> Option<String>,
    ) -> Option<usize> {
        let source = read(&load(file)?)?;
        let index = self.nodes.len();
        let modules = source.modules.clone();
        let file = file.display().to_string();
        self.nodes.push(Node { file, parent, children: BTreeMap::new(), source });
        for module in modules {
            let own = folder.join(&module);
            let candidates: [PathBuf; 2] = [folder.join(format!("{module}.rs")), own.join("mod.rs")];
            let child = candidates.iter().find_map(|path| self.add(path, Some(index), &own, load));
            if let Some(child) = child {
                self.nodes[index].children.insert(module, child);
            }
        }
        Some(index)
    }

    /// Who uses whom. Passing a name on (`pub use`) and declaring a module are signposts, no uses; a name that comes by
    /// way of a signpost counts for the file that defines it.
    pub fn uses(&self) -> Uses {
        let mut uses = Uses::new();
        for (index, node) in self.nodes.iter().enumerate() {
            let mut note = |name: &str, place: Option<Place>| {
                if let Some(Place::Item(target)) = place
                    && target != index
                {
                    uses.entry((index, target)).or_default().insert(name.to_owned());
                }
            };
            for import in &node.source.imports {
                if import.name == "*" {
                    let Some(Place::Module(module)) = self.glob(index, import, 0) else { continue };
                    for word in &node.source.words {
                        note(word, self.known(module, word, 0));
                    }
                } else if !import.passed_on || node.source.words.contains(&import.name) {
                    let name = import.path.last().map_or("", String::as_str);
                    note(name, self.resolve(index, &import.path, 0));
                }
            }
            for path in &node.source.paths {
                note(path.last().map_or("", String::as_str), self.resolve(index, path, 0));
            }
        }
        uses
    }

    fn glob(&self, from: usize, import: &Import, depth: usize) -> Option<Place> {
        self.resolve(from, &import.path[..import.path.len().saturating_sub(1)], depth)
    }

    /// Where a path leads that stands in the file `from`; `None` where it leaves the crate.
    fn resolve(&self, from: usize, path: &[String], depth: usize) -> Option<Place> {
        let (first, rest) = path.split_first()?;
        let start = match first.as_str() {
            "crate" => Place::Module(0),
            "self" => Place::Module(from),
            "super" => Place::Module(self.nodes[from].parent?),
            name => self.known(from, name, depth)?,
        };
        rest.iter().try_fold(start, |place, segment| match place {
            Place::Module(module) if segment == "super" => self.nodes[module].parent.map(Place::Module),
            // What the reader does not know by name (a macro's item) belongs to the module that is asked for it.
            Place::Module(module) => Some(self.known(module, segment, depth).unwrap_or(Place::Item(module))),
            item => Some(item),
        })
    }

    /// What a name means in a module: its child, its own item, or something that it brings in.
    fn known(&self, module: usize, name: &str, depth: usize) -> Option<Place> {
        if depth > DEEPEST {
            return None;
        }
        let node = &self.nodes[module];
        if let Some(&child) = node.children.get(name) {
            return Some(Place::Module(child));
        }
        if node.source.defined.contains(name) {
            return Some(Place::Item(module));
        }
        let named = node.source.imports.iter().find(|import| import.name == name && import.path[0] != name);
        if let Some(import) = named {
            return self.resolve(module, &import.path, depth + 1);
        }
        node.source.imports.iter().filter(|import| import.name == "*").find_map(|import| {
            match self.glob(module, import, depth + 1)? {
                Place::Module(brought) if brought != module => self.known(brought, name, depth + 1),
                _ => None,
            }
        })
    }
}
