//! Which module uses what is defined in which other one.
//!
//! A name that a module hands on (`pub use child::Item`) belongs to where it is defined, so that a door that hands on the
//! things of its rooms does not stand in anybody's way.

use crate::source::Module;
use std::collections::{BTreeMap, BTreeSet};

/// What one file says about names.
#[derive(Default)]
struct Names {
    /// Names that its `use` lines give to paths.
    imports: BTreeMap<String, Vec<String>>,
    /// Paths whose names it takes all of (`*`).
    globs: Vec<Vec<String>>,
    /// Paths elsewhere in the code.
    paths: BTreeSet<Vec<String>>,
    /// What it defines.
    items: BTreeSet<String>,
}

/// The modules of a crate and their imports.
pub struct Imports<'a> {
    modules: &'a [Module],
    names: Vec<Names>,
    at: BTreeMap<&'a [String], usize>,
    /// Pairs of modules: who uses, and where that is defined.
    pub arrows: BTreeSet<(usize, usize)>,
}

/// More hand-overs of a name than any crate has.
const LONGEST_CHAIN: usize = 20;

impl<'a> Imports<'a> {
    /// Reads the imports of all modules.
    pub fn of(modules: &'a [Module]) -> Self {
        let names = modules.iter().map(|module| names_in(&module.code)).collect();
        let at = modules.iter().enumerate().map(|(k, module)| (&module.path[..], k)).collect();
        let mut all = Imports { modules, names, at, arrows: BTreeSet::new() };
        for k in 0..modules.len() {
            let names = &all.names[k];
            let named = names.imports.values().chain(&names.paths);
            let globs = names.globs.iter().filter_map(|path| all.module_at(k, path));
            let found: Vec<usize> = named.filter_map(|path| all.home(k, path, 0)).chain(globs).collect();
            all.arrows.extend(found.into_iter().filter(|&j| j != k).map(|j| (k, j)));
        }
        all
    }

    /// The module that defines what a path means; none for modules themselves and for other crates.
    fn home(&self, from: usize, path: &[String], handed: usize) -> Option<usize> {
        if handed > LONGEST_CHAIN {
            return None;
        }
        let (mut here, mut rest) = match path[0].as_str() {
            "crate" => (self.at[&[][..]], &path[1..]),
            "self" => (from, &path[1..]),
            "super" => (from, path),
            name if self.child(from, name).is_some() => (from, path),
            _ => return self.imported(from, path, handed),
        };
        while let Some(name) = rest.first() {
            let next = if name == "super" { self.parent(here) } else { self.child(here, name) };
            let is_item = rest.len() == 1 && self.names[here].imports.contains_key(name);
            match next {
                Some(next) if !is_item => (here, rest) = (next, &rest[1..]),
                _ if self.names[here].items.contains(name) => return Some(here),
                _ if self.names[here].imports.contains_key(name) => return self.imported(here, rest, handed),
                _ => {
                    let globs = self.names[here].globs.iter().filter_map(|path| self.module_at(here, path));
                    return Some(globs.into_iter().find(|&j| self.names[j].items.contains(name)).unwrap_or(here));
                }
            }
        }
        None
    }

    /// The same for a path whose first name stands for another path.
    fn imported(&self, here: usize, path: &[String], handed: usize) -> Option<usize> {
        let full = self.names[here].imports.get(&path[0])?;
        if full[0] == path[0] {
            let is_below = self.child(here, &path[0]).is_some();
            return is_below.then(|| self.home(here, full, handed + 1)).flatten();
        }
        let full: Vec<String> = full.iter().chain(&path[1..]).cloned().collect();
        self.home(here, &full, handed + 1)
    }

    /// The module that a path leads to.
    fn module_at(&self, from: usize, path: &[String]) -> Option<usize> {
        path.iter().try_fold(from, |here, name| match name.as_str() {
            "crate" => Some(self.at[&[][..]]),
            "self" => Some(here),
            "super" => self.parent(here),
            name => self.child(here, name),
        })
    }

    fn child(&self, of: usize, name: &str) -> Option<usize> {
        let path: Vec<String> = self.modules[of].path.iter().cloned().chain([name.to_string()]).collect();
        self.at.get(&path[..]).copied()
    }

    fn parent(&self, of: usize) -> Option<usize> {
        let path = &self.modules[of].path;
        self.at.get(&path[..path.len().checked_sub(1)?]).copied()
    }

    /// Whether a module stands above another one, and so declares it or who declares it.
    fn is_above(&self, above: usize, below: usize) -> bool {
        let (above, below) = (&self.modules[above].path, &self.modules[below].path);
        above.len() < below.len() && below.starts_with(above)
    }

    /// The imports that run back up: modules that use what is defined in one above them.
    pub fn back_up(&self) -> Vec<(usize, usize)> {
        self.arrows.iter().copied().filter(|&(from, to)| self.is_above(to, from)).collect()
    }

    /// The circles among the others: groups of modules in which each reaches each.
    pub fn circles(&self) -> Vec<Vec<usize>> {
        let arrows: Vec<_> = self.arrows.iter().copied().filter(|&(from, to)| !self.is_above(to, from)).collect();
        groups(self.modules.len(), &arrows)
    }
}

/// Groups of more than one node in which each reaches each.
fn groups(count: usize, arrows: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut next = vec![Vec::new(); count];
    for &(from, to) in arrows {
        next[from].push(to);
    }
    let reached: Vec<Vec<bool>> = (0..count).map(|k| reached(k, &next)).collect();
    let mut found: Vec<Vec<usize>> = Vec::new();
    for k in 0..count {
        let group: Vec<usize> = (0..count).filter(|&j| reached[k][j] && reached[j][k]).collect();
        if group.len() > 1 && group[0] == k {
            found.push(group);
        }
    }
    found
}

/// Which nodes are reached from one over at least one arrow.
fn reached(from: usize, next: &[Vec<usize>]) -> Vec<bool> {
    let mut seen = vec![false; next.len()];
    let mut open = next[from].clone();
    while let Some(k) = open.pop() {
        if !std::mem::replace(&mut seen[k], true) {
            open.extend(&next[k]);
        }
    }
    seen
}

/// The names that a code gives, uses and defines.
fn names_in(code: &str) -> Names {
    let mut names = Names::default();
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut rest = code;
    let mut before = String::new();
    while let Some(begin) = rest.find(is_name) {
        let gap = &rest[..begin];
        let word = &rest[begin..][..rest[begin..].find(|c| !is_name(c)).unwrap_or(rest.len() - begin)];
        let after = &rest[begin + word.len()..];
        if word == "use" && after.starts_with(' ') {
            let (tree, beyond) = after.split_once(';').unwrap_or((after, ""));
            add_tree(&mut names, &[], tree.trim());
            rest = beyond;
            before.clear();
            continue;
        }
        let defines = ["fn", "struct", "enum", "trait", "type", "const", "static", "union", "macro_rules"];
        if defines.contains(&before.as_str()) && gap.trim_start_matches('!').trim().is_empty() {
            names.items.insert(word.into());
        }
        // A path: words with `::` between them.
        let mut path = vec![word.to_string()];
        let mut tail = after;
        while let Some(more) = tail.strip_prefix("::").filter(|more| more.starts_with(is_name)) {
            let length = more.find(|c| !is_name(c)).unwrap_or(more.len());
            path.push(more[..length].into());
            tail = &more[length..];
        }
        if path.len() > 1 && !gap.ends_with(['.', ':']) {
            names.paths.insert(path.clone());
        }
        before = path.pop().unwrap_or_default();
        rest = tail;
    }
    names
}

/// Adds the names of a `use` tree below a path.
fn add_tree(names: &mut Names, above: &[String], tree: &str) {
    if let Some((path, list)) = tree.split_once('{') {
        let mut above = above.to_vec();
        above.extend(words_of(path));
        let list = list.trim_end().strip_suffix('}').unwrap_or(list);
        let (mut depth, mut begin) = (0, 0);
        for (k, c) in list.char_indices().chain([(list.len(), ',')]) {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    let one = list[begin..k].trim();
                    if !one.is_empty() {
                        add_tree(names, &above, one);
                    }
                    begin = k + 1;
                }
                _ => {}
            }
        }
        return;
    }
    let (path, alias) = tree.split_once(" as ").map_or((tree, None), |(path, alias)| (path, Some(alias.trim())));
    let mut full = above.to_vec();
    full.extend(words_of(path));
    if full.len() > 1 && full.last().is_some_and(|last| last == "self") {
        full.pop();
    }
    match full.last().map(String::as_str) {
        Some("*") => {
            full.pop();
            names.globs.push(full);
        }
        Some(last) => {
            let name = alias.unwrap_or(last).to_string();
            names.imports.insert(name, full);
        }
        None => {}
    }
}

fn words_of(path: &str) -> Vec<String> {
    path.split("::").map(|word| word.trim().to_string()).filter(|word| !word.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::modules_in;

    /// The imports of files in memory, as `from > to`.
    fn arrows(files: &[(&str, &str)]) -> Vec<String> {
        let modules = modules_in(files);
        let imports = Imports::of(&modules);
        let name = |k: usize| modules[k].path.join("::");
        imports.arrows.iter().map(|&(from, to)| format!("{} > {}", name(from), name(to))).collect()
    }

    #[test]
    fn imports_are_seen_in_every_way_to_write_them() {
        for way in [
            "use super::b::B;",
            "use super::{b::B, c::C};",
            "use crate::room::b::{self, B};\nfn f(x: b::B) {}",
            "use crate::room::b;\nfn f(x: b::B) {}",
            "use super::b as other;\nfn f(x: other::B) {}",
            "fn f(x: super::b::B) {}",
            "fn f() { let x = crate::room::b::B::new(1); }",
            "use super::b::*;",
            "use super::super::room::b::B;",
            "use crate as root;\nfn f(x: root::room::b::B) {}",
            "pub(super) use super::b::{B as D};",
            // By the name that the door hands on.
            "use super::B;",
            "use crate::room::B;",
            "use super::Renamed;",
            "use crate::B;",
        ] {
            let files = [
                ("lib.rs", "pub mod room;\npub use room::B;\n"),
                ("room/mod.rs", "mod a;\nmod b;\nmod c;\npub use b::B;\npub use b::B as Renamed;\n"),
                ("room/a.rs", way),
                ("room/b.rs", "pub struct B;\n"),
                ("room/c.rs", "pub struct C;\n"),
            ];
            let found = arrows(&files);
            assert!(found.contains(&"room::a > room::b".to_string()), "{way}: {found:?}");
            assert!(!found.contains(&"room::a > room".to_string()), "{way}: {found:?}");
        }
    }

    #[test]
    fn what_is_not_of_the_crate_is_no_import() {
        let files = [
            ("lib.rs", "mod a;\nmod b;\n"),
            (
                "a.rs",
                "use std::fmt::Debug;\n// use super::b::B;\nfn f(x: glam::DVec3) { let s = \"crate::b::B\"; x.b::<u8>(); }\n",
            ),
            ("b.rs", "pub struct B;\n"),
        ];
        assert!(arrows(&files).is_empty(), "{:?}", arrows(&files));
    }

    #[test]
    fn imports_back_up_and_circles_are_told_apart() {
        let files = [
            ("lib.rs", "pub mod room;\n"),
            ("room/mod.rs", "mod a;\nmod b;\nmod c;\npub struct Options;\npub use c::C;\nfn run() { a::a(); }\n"),
            ("room/a.rs", "use super::Options;\nuse super::b::B;\npub fn a() {}\n"),
            ("room/b.rs", "use super::c;\npub struct B;\nfn f() { c::c(); }\n"),
            ("room/c.rs", "use super::{C as D, a::a};\npub struct C;\npub fn c() {}\n"),
        ];
        let modules = modules_in(&files);
        let imports = Imports::of(&modules);
        let name = |k: usize| modules[k].path.join("::");
        let up: Vec<_> = imports.back_up().into_iter().map(|(from, to)| (name(from), name(to))).collect();
        assert_eq!(up, [("room::a".to_string(), "room".to_string())]);
        let circles: Vec<Vec<String>> =
            imports.circles().into_iter().map(|group| group.into_iter().map(name).collect()).collect();
        assert_eq!(circles, [["room::a", "room::b", "room::c"]]);
    }

    #[test]
    fn groups_reach_themselves() {
        assert_eq!(groups(5, &[(0, 1), (1, 0), (1, 2), (2, 3), (4, 4)]), [[0, 1]]);
        assert!(groups(3, &[(0, 1), (1, 2), (0, 2)]).is_empty());
    }
}
