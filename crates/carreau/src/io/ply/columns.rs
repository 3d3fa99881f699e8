//! Which properties make which column.
//!
//! | properties | column |
//! |---|---|
//! | `nx`, `ny`, `nz` | vectors `normal` |
//! | `red`, `green`, `blue`, perhaps `alpha` | colours `color` |
//! | `s`, `t`, or `texture_u`, `texture_v` | pairs `uv` |
//! | `NAME_x`, `NAME_y`, `NAME_z` | vectors `NAME` |
//! | `NAME_u`, `NAME_v` | pairs `NAME` |
//! | `NAME_red`, `NAME_green`, `NAME_blue`, perhaps `NAME_alpha` | colours `NAME` |
//! | any other integers | labels; numbers where they do not fit 32 bits |
//! | any other floats | numbers |
//!
//! Vectors and pairs are made of floats only; colours of integers up to 255, or of floats up to 1. A column whose name
//! is taken gets a `_` behind it.

use super::body::{Table, Values};
use crate::mesh::{Column, Columns};
use std::collections::BTreeMap;

/// Usual names of a normal's components.
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
/// Usual names of a colour's components.
const COLOR: [&str; 4] = ["red", "green", "blue", "alpha"];
/// Usual names of texture coordinates.
const UV: [&str; 2] = ["s", "t"];
/// Other names of texture coordinates.
const OTHER_UV: [&str; 2] = ["texture_u", "texture_v"];
/// Endings of the components of other vectors.
const VECTOR_ENDINGS: [&str; 3] = ["_x", "_y", "_z"];
/// Endings of the components of other pairs.
const PAIR_ENDINGS: [&str; 2] = ["_u", "_v"];
/// Endings of the components of other colours.
const COLOR_ENDINGS: [&str; 4] = ["_red", "_green", "_blue", "_alpha"];

/// The type of a property that is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Written {
    Double,
    Int,
    Byte,
}

impl Written {
    /// As the header names it.
    pub fn name(self) -> &'static str {
        match self {
            Written::Double => "double",
            Written::Int => "int",
            Written::Byte => "uchar",
        }
    }
}

/// The properties that a column is written as.
pub fn properties(name: &str, column: &Column) -> Vec<(String, Written)> {
    let named = |names: &[&str], kind| names.iter().map(|n| (n.to_string(), kind)).collect();
    let ended = |endings: &[&str], kind| endings.iter().map(|e| (format!("{name}{e}"), kind)).collect();
    match column {
        Column::Scalar(_) => named(&[name], Written::Double),
        Column::Label(_) => named(&[name], Written::Int),
        Column::Vector3(_) if name == "normal" => named(&NORMAL, Written::Double),
        Column::Vector3(_) => ended(&VECTOR_ENDINGS, Written::Double),
        Column::Vector2(_) if name == "uv" => named(&UV, Written::Double),
        Column::Vector2(_) => ended(&PAIR_ENDINGS, Written::Double),
        Column::Color(_) if name == "color" => named(&COLOR, Written::Byte),
        Column::Color(_) => ended(&COLOR_ENDINGS, Written::Byte),
    }
}

/// The columns of a table.
pub fn columns(table: Table) -> Columns {
    let mut scalars = Scalars(table.into_iter().collect());
    let mut columns = Columns::new();
    let mut add = |name: &str, column: Option<Column>| {
        if let Some(column) = column {
            let mut name = name.to_string();
            while columns.contains_key(&name) {
                name.push('_');
            }
            columns.insert(name, column);
        }
    };
    add("normal", scalars.vectors(NORMAL.map(String::from)).map(Column::Vector3));
    add("color", scalars.colors(COLOR.map(String::from)));
    add("uv", scalars.vectors(UV.map(String::from)).map(Column::Vector2));
    add("uv", scalars.vectors(OTHER_UV.map(String::from)).map(Column::Vector2));
    for name in scalars.names_ending(VECTOR_ENDINGS[0]) {
        add(&name, scalars.vectors(VECTOR_ENDINGS.map(|e| format!("{name}{e}"))).map(Column::Vector3));
    }
    for name in scalars.names_ending(PAIR_ENDINGS[0]) {
        add(&name, scalars.vectors(PAIR_ENDINGS.map(|e| format!("{name}{e}"))).map(Column::Vector2));
    }
    for name in scalars.names_ending(COLOR_ENDINGS[0]) {
        add(&name, scalars.colors(COLOR_ENDINGS.map(|e| format!("{name}{e}"))));
    }
    for (name, values) in scalars.0 {
        add(&name, single(values));
    }
    columns
}

/// The properties that are not yet in a column.
struct Scalars(BTreeMap<String, Values>);

impl Scalars {
    /// What stands before this ending in the names that have it.
    fn names_ending(&self, ending: &str) -> Vec<String> {
        self.0.keys().filter_map(|name| name.strip_suffix(ending)).map(String::from).collect()
    }

    /// Takes out these properties and joins them, where all are there and are floats.
    fn vectors<const N: usize>(&mut self, names: [String; N]) -> Option<Vec<[f64; N]>> {
        if !names.iter().all(|name| matches!(self.0.get(name), Some(Values::Floats(_)))) {
            return None;
        }
        let parts = names.map(|name| match self.0.remove(&name) {
            Some(Values::Floats(values)) => values,
            _ => Vec::new(),
        });
        let count = parts[0].len();
        Some((0..count).map(|k| std::array::from_fn(|i| parts[i][k])).collect())
    }

    /// Takes out these properties and joins them, where all but the last are there and can be colours.
    fn colors(&mut self, names: [String; 4]) -> Option<Column> {
        let [r, g, b] = [0, 1, 2].map(|i| self.0.get(&names[i]).and_then(bytes));
        let (r, g, b) = (r?, g?, b?);
        let alpha = match self.0.get(&names[3]) {
            Some(values) => bytes(values)?,
            None => vec![255; r.len()],
        };
        names.iter().for_each(|name| drop(self.0.remove(name)));
        Some(Column::Color((0..r.len()).map(|k| [r[k], g[k], b[k], alpha[k]]).collect()))
    }
}

/// The values as parts of a colour, where they can be that.
fn bytes(values: &Values) -> Option<Vec<u8>> {
    match values {
        Values::Integers(values) => values.iter().map(|&x| u8::try_from(x).ok()).collect(),
        Values::Floats(values) => {
            values.iter().map(|x| (0.0..=1.0).contains(x).then(|| (x * 255.0).round() as u8)).collect()
        }
        _ => None,
    }
}

fn single(values: Values) -> Option<Column> {
    match values {
        Values::Integers(values) => Some(match values.iter().map(|&x| i32::try_from(x).ok()).collect() {
            Some(labels) => Column::Label(labels),
            None => Column::Scalar(values.into_iter().map(|x| x as f64).collect()),
        }),
        Values::Floats(values) => Some(Column::Scalar(values)),
        Values::Faces(_) | Values::Strips(_) | Values::Skipped => None,
    }
}
