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
    /// Words for the values of label columns, `(column, label) → name`: OBJ groups, STL solids, Gmsh physical names. The
    /// name of a body that is alone in its file has no column: `("solid", 0)`.
    pub names: BTreeMap<(String, i32), String>,
    /// Colours for the values of label columns, `(column, label) → red, green, blue, opacity` (sRGB): materials.
    pub colors: BTreeMap<(String, i32), [u8; 4]>,
    /// Files that describe the materials further (OBJ's `mtllib`), in the order in which the mesh names them.
    pub libraries: Vec<MaterialLibrary>,
    /// The unit of the coordinates, where the file says it.
    pub unit: Option<LengthUnit>,
}

/// Face label columns that tell bodies apart: objects of OBJ, glTF and 3MF, solids of STL.
pub const BODIES: [&str; 2] = ["object", "solid"];

/// A file that describes materials by their names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MaterialLibrary {
    /// As the mesh's file names it.
    pub name: String,
    /// What is in it; empty where it could not be read.
    pub bytes: Vec<u8>,
}

/// A unit of length, as files name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LengthUnit {
    /// A thousandth of a millimetre.
    Micron,
    /// Millimetres.
    Millimeter,
    /// Centimetres.
    Centimeter,
    /// Inches of 25.4 mm.
    Inch,
    /// Feet of 304.8 mm.
    Foot,
    /// Metres.
    Meter,
}

impl Attributes {
    /// No columns, but all that another mesh says about the values of its labels and about its unit: names, colours, libraries.
    pub fn words_of(other: &Attributes) -> Attributes {
        Attributes {
            names: other.names.clone(),
            colors: other.colors.clone(),
            libraries: other.libraries.clone(),
            unit: other.unit,
            ..Attributes::default()
        }
    }

    /// The word for a value of a label column.
    pub fn name(&self, column: &str, label: i32) -> Option<&str> {
        self.names.get(&(column.to_string(), label)).map(String::as_str)
    }

    /// The colour for a value of a label column.
    pub fn color(&self, column: &str, label: i32) -> Option<[u8; 4]> {
        self.colors.get(&(column.to_string(), label)).copied()
    }

    /// The name of the only body, where the mesh has no labels that tell bodies apart.
    pub fn only_body(&self) -> Option<&str> {
        let alone = |column: &&str| !self.has_labels(column);
        BODIES.into_iter().filter(alone).find_map(|column| self.name(column, 0))
    }

    /// Whether a label column with this name is on some element.
    pub fn has_labels(&self, column: &str) -> bool {
        let is_label = |columns: &&Columns| matches!(columns.get(column), Some(Column::Label(_)));
        [&self.vertex, &self.face, &self.corner].iter().any(is_label)
    }
}

/// Every column, gathered; see [`Column::gather`].
pub fn gather_columns(columns: &Columns, source: &[u32]) -> Columns {
    columns.iter().map(|(name, column)| (name.clone(), column.gather(source))).collect()
}

/// Every column, blended; see [`Column::blend`].
pub fn blend_columns<M: AsRef<[(u32, f64)]>>(columns: &Columns, mixtures: &[M]) -> Columns {
    columns.iter().map(|(name, column)| (name.clone(), column.blend(mixtures))).collect()
}
