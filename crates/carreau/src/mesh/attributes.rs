//! Named columns of values on the elements of a mesh.
//!
//! Names matter only at the border (files, Python): inside, algorithms take and return plain `Vec`s.

use std::collections::BTreeMap;

/// The values of one attribute, one per element.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Column {
    /// A number.
    Scalar(Vec<f64>),
    /// Two numbers: texture coordinates.
    Vector2(Vec<[f64; 2]>),
    /// Three numbers: normals, directions.
    Vector3(Vec<[f64; 3]>),
    /// An integer label; labels are copied, never blended.
    Label(Vec<i32>),
    /// Red, green, blue, opacity.
    Color(Vec<[u8; 4]>),
}

impl Column {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Column::Scalar(v) => v.len(),
            Column::Vector2(v) => v.len(),
            Column::Vector3(v) => v.len(),
            Column::Label(v) => v.len(),
            Column::Color(v) => v.len(),
        }
    }

    /// Whether there is no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The column of a mesh whose element `k` is this mesh's element `source[k]`.
    pub fn gather(&self, source: &[u32]) -> Column {
        fn pick<T: Copy>(values: &[T], source: &[u32]) -> Vec<T> {
            source.iter().map(|&s| values[s as usize]).collect()
        }
        match self {
            Column::Scalar(v) => Column::Scalar(pick(v, source)),
            Column::Vector2(v) => Column::Vector2(pick(v, source)),
            Column::Vector3(v) => Column::Vector3(pick(v, source)),
            Column::Label(v) => Column::Label(pick(v, source)),
            Column::Color(v) => Column::Color(pick(v, source)),
        }
    }
}

/// Attributes of one kind of element, by name, in alphabetical order.
pub type Columns = BTreeMap<String, Column>;

/// All attributes of a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attributes {
    /// On vertices.
    pub vertex: Columns,
    /// On faces.
    pub face: Columns,
    /// On corners: texture coordinates and normals of formats that give them per corner.
    pub corner: Columns,
    /// Words for the values of label columns, `(column, label) → name`: OBJ groups, Gmsh physical names.
    pub names: BTreeMap<(String, i32), String>,
}

/// Every column, gathered; see [`Column::gather`].
pub fn gather_columns(columns: &Columns, source: &[u32]) -> Columns {
    columns.iter().map(|(name, column)| (name.clone(), column.gather(source))).collect()
}
