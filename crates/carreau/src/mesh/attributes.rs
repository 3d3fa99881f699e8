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

    /// The column of a mesh whose elements are mixtures of this mesh's, each given by elements and their weights, which add
    /// up to one: numbers are blended, labels are copied from the heaviest.
    pub fn blend<M: AsRef<[(u32, f64)]>>(&self, mixtures: &[M]) -> Column {
        fn mean(mixture: &[(u32, f64)], value: impl Fn(usize) -> f64) -> f64 {
            mixture.iter().map(|&(k, w)| w * value(k as usize)).sum()
        }
        fn heaviest(mixture: &[(u32, f64)]) -> usize {
            mixture.iter().fold((0, f64::NEG_INFINITY), |best, &part| if part.1 > best.1 { part } else { best }).0
                as usize
        }
        let parts = mixtures.iter().map(AsRef::as_ref);
        match self {
            Column::Scalar(v) => Column::Scalar(parts.map(|m| mean(m, |k| v[k])).collect()),
            Column::Vector2(v) => Column::Vector2(parts.map(|m| [0, 1].map(|i| mean(m, |k| v[k][i]))).collect()),
            Column::Vector3(v) => Column::Vector3(parts.map(|m| [0, 1, 2].map(|i| mean(m, |k| v[k][i]))).collect()),
            Column::Label(v) => Column::Label(parts.map(|m| v[heaviest(m)]).collect()),
            Column::Color(v) => {
                let channel = |m, i: usize| mean(m, |k| f64::from(v[k][i])).round().clamp(0.0, 255.0) as u8;
                Column::Color(parts.map(|m| [0, 1, 2, 3].map(|i| channel(m, i))).collect())
            }
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

/// Every column, blended; see [`Column::blend`].
pub fn blend_columns<M: AsRef<[(u32, f64)]>>(columns: &Columns, mixtures: &[M]) -> Columns {
    columns.iter().map(|(name, column)| (name.clone(), column.blend(mixtures))).collect()
}
