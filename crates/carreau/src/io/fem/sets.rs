//! Labels as sets: of faces, of cells, of nodes.

use crate::io::limits::columns_left_out;
use crate::mesh::{Column, Columns, RawMesh};
use std::collections::{BTreeMap, BTreeSet};

/// Elements or nodes under one name.
pub struct Set {
    pub name: String,
    /// Numbers from 0, ascending.
    pub members: Vec<u32>,
}

/// Labels of these columns are reference numbers: 0 is none.
const ZERO_IS_NONE: [&str; 6] = ["ref", "tag", "edge", "cell", "corner", "required"];

/// Names that a deck can hold, each once, whatever the case: letters, digits and underscores, a letter first.
#[derive(Default)]
pub struct Names(BTreeSet<String>);

impl Names {
    /// A name like this one that is not taken.
    pub fn take(&mut self, word: &str, longest: usize) -> String {
        let plain: String = word.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let plain = plain.trim_matches('_');
        let mut plain = match plain.chars().next() {
            Some(first) if first.is_ascii_alphabetic() => plain.to_string(),
            _ => format!("set_{plain}"),
        };
        plain.truncate(longest.saturating_sub(4));
        let mut name = plain.clone();
        let mut k = 2;
        while !self.0.insert(name.to_ascii_uppercase()) {
            name = format!("{plain}_{k}");
            k += 1;
        }
        name
    }
}

/// The sets of a list of labels, by ascending label.
pub fn of_labels(mesh: &RawMesh, column: &str, labels: &[i32], names: &mut Names, longest: usize) -> Vec<Set> {
    let mut members: BTreeMap<i32, Vec<u32>> = BTreeMap::new();
    for (k, &label) in (0..).zip(labels) {
        let none = label < 0 || (label == 0 && ZERO_IS_NONE.contains(&column));
        if !none || mesh.attributes.name(column, label).is_some() {
            members.entry(label).or_default().push(k);
        }
    }
    let word = |label| mesh.attributes.name(column, label).map_or_else(|| format!("{column}_{label}"), str::to_string);
    members.into_iter().map(|(label, members)| Set { name: names.take(&word(label), longest), members }).collect()
}

/// The sets of all label columns.
pub fn of_columns(mesh: &RawMesh, columns: &Columns, names: &mut Names, longest: usize) -> Vec<Set> {
    let labels = columns.iter().filter_map(|(name, column)| match column {
        Column::Label(labels) => Some((name, labels)),
        _ => None,
    });
    labels.flat_map(|(name, labels)| of_labels(mesh, name, labels, names, longest)).collect()
}

/// Nodes at the ends of edges, by the tags of these.
pub fn of_edges(mesh: &RawMesh, names: &mut Names, longest: usize) -> Vec<Set> {
    let mut sets = of_labels(mesh, "edge", &mesh.edge_tags, names, longest);
    for set in &mut sets {
        let ends = |k: &u32| mesh.edges.get(*k as usize).copied().unwrap_or_default();
        set.members = set.members.iter().flat_map(ends).collect();
        set.members.sort_unstable();
        set.members.dedup();
    }
    sets
}

/// What decks have no place for: all columns but labels.
pub fn left_out(mesh: &RawMesh, format: &str) -> Vec<String> {
    let is_label = |_: &str, column: &Column| matches!(column, Column::Label(_));
    let columns = &mesh.attributes;
    let vertex = columns_left_out(format, "vertex", &columns.vertex, is_label);
    let face = columns_left_out(format, "face", &columns.face, is_label);
    let corner = columns_left_out(format, "corner", &columns.corner, |_, _| false);
    let untagged = mesh.edge_tags.iter().all(|&tag| tag == 0) && !mesh.edges.is_empty();
    let edges = untagged.then(|| format!("{format} has no place for lines: left out all {}", mesh.edges.len()));
    let words = super::super::limits::words_left_out(format, mesh, |_| true, |_| false);
    [vertex, face, corner, edges].into_iter().flatten().chain(words).collect()
}
