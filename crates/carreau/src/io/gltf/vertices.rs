//! Vertices as they are written: a vertex whose corners differ in colour, texture coordinates or normal is written once for
//! each of them.
//!
//! ```text
//!    red ╱│╲ blue         red ╱│ │╲ blue
//!       ╱ │ ╲       →        ╱ │ │ ╲        one vertex more for each end of the border
//! ```

use crate::mesh::{BODIES, Column, RawMesh};
use rustc_hash::FxHashMap;

pub type Color = [u8; 4];
/// Colour of vertices that have none.
const WHITE: Color = [255; 4];

/// Whether these are the unit normals that glTF asks for.
pub fn are_normals(column: &Column) -> bool {
    let unit = |n: &[f64; 3]| (n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-3;
    matches!(column, Column::Vector3(normals) if normals.iter().all(unit))
}

/// Columns of faces that are shown as colours; the first that exists wins.
pub const FACE_COLORS: [&str; 3] = ["color", "region", "patch"];

/// Colours of the faces: their own, or one for each label.
pub fn face_colors(mesh: &RawMesh) -> Option<Vec<Color>> {
    FACE_COLORS.iter().find_map(|&name| match mesh.attributes.face.get(name)? {
        Column::Color(colors) => Some(colors.clone()),
        Column::Label(labels) if name != "color" => Some(labels.iter().map(|&label| label_color(label)).collect()),
        _ => None,
    })
}

/// A colour for a label: hues a golden section of the circle apart, so that near labels have distant hues, in three
/// shades.
fn label_color(label: i32) -> Color {
    let turn = f64::from(label) * 0.618_033_988_749_895;
    let hue = 6.0 * (turn - turn.floor());
    let value = [0.95, 0.75, 0.85][label.rem_euclid(3) as usize];
    // A component is full over a third of the circle, and fades out to both sides.
    let component = |center: f64| {
        let distance = (hue - center).abs().min(6.0 - (hue - center).abs());
        let share = (2.0 - distance).clamp(0.0, 1.0);
        (255.0 * value * (0.35 + 0.65 * share)).round() as u8
    };
    [component(0.0), component(2.0), component(4.0), u8::MAX]
}

/// The triangles of one node.
pub struct Part {
    /// The value of the column that tells bodies apart; none where there is no such column.
    pub label: Option<i32>,
    /// Numbers of triangles.
    pub triangles: Vec<u32>,
}

/// The column that tells bodies apart, and the triangles of each body in the order of first use.
pub fn parts<'a>(mesh: &'a RawMesh, parents: &[u32]) -> (Option<&'static str>, Vec<Part>) {
    let column = |name: &&'static str| match mesh.attributes.face.get(*name) {
        Some(Column::Label(labels)) => Some((*name, labels)),
        _ => None,
    };
    let Some((name, labels)): Option<(&'static str, &'a Vec<i32>)> = BODIES.iter().find_map(column) else {
        return (None, vec![Part { label: None, triangles: (0..parents.len() as u32).collect() }]);
    };
    let mut place: FxHashMap<i32, usize> = FxHashMap::default();
    let mut parts: Vec<Part> = Vec::new();
    for (t, &face) in (0..).zip(parents) {
        let label = labels[face as usize];
        let k = *place.entry(label).or_insert(parts.len());
        if k == parts.len() {
            parts.push(Part { label: Some(label), triangles: Vec::new() });
        }
        parts[k].triangles.push(t);
    }
    (Some(name), parts)
}

/// What a corner has of its own; bits of numbers, which are compared.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Look {
    color: Option<Color>,
    uv: Option<[u64; 2]>,
    normal: Option<[u64; 3]>,
}

/// The vertices of a part.
pub struct Vertices {
    /// The vertex of the mesh that each is; the first ones are the part's own, in order.
    pub source: Vec<u32>,
    pub triangles: Vec<[u32; 3]>,
    /// How many of them are written again.
    pub copies: usize,
    pub colors: Option<Vec<Color>>,
    pub uvs: Option<Vec<[f64; 2]>>,
    pub normals: Option<Vec<[f64; 3]>>,
}

impl Vertices {
    /// The vertices of a part. `triangles` and `corners` are all of the mesh, as vertices and as corners.
    pub fn new(mesh: &RawMesh, part: &Part, triangles: &[[u32; 3]], corners: &[[u32; 3]], parents: &[u32]) -> Self {
        let own = own_vertices(mesh, part, triangles);
        let looks = Looks::of(mesh);
        let mut id: FxHashMap<u32, u32> = FxHashMap::default();
        let mut source = own.clone();
        let mut seen: Vec<Option<Look>> = vec![None; source.len()];
        if part.label.is_some() {
            id = own.iter().zip(0..).map(|(&v, k)| (v, k)).collect();
        }
        let mut copies: FxHashMap<(u32, Look), u32> = FxHashMap::default();
        let mut written = Vec::with_capacity(part.triangles.len());
        for &t in &part.triangles {
            let t = t as usize;
            written.push(std::array::from_fn(|k| {
                let (vertex, look) = (triangles[t][k], looks.at(parents[t], corners[t][k]));
                let own = id.get(&vertex).copied().unwrap_or(vertex);
                match seen[own as usize] {
                    None => seen[own as usize] = Some(look),
                    Some(first) if first == look => {}
                    Some(_) => {
                        return *copies.entry((vertex, look)).or_insert_with(|| {
                            source.push(vertex);
                            seen.push(Some(look));
                            source.len() as u32 - 1
                        });
                    }
                }
                own
            }));
        }
        let seen: Vec<Look> = seen.into_iter().map(Option::unwrap_or_default).collect();
        Vertices {
            copies: source.len() - own.len(),
            colors: looks.colors(mesh, &source, &seen),
            uvs: looks.uvs(mesh, &source, &seen),
            normals: looks.normals(mesh, &source, &seen),
            source,
            triangles: written,
        }
    }
}

/// All vertices where the mesh is one part, else those that the part uses, ascending.
fn own_vertices(mesh: &RawMesh, part: &Part, triangles: &[[u32; 3]]) -> Vec<u32> {
    if part.label.is_none() {
        return (0..mesh.points.len() as u32).collect();
    }
    let mut own: Vec<u32> = part.triangles.iter().flat_map(|&t| triangles[t as usize]).collect();
    own.sort_unstable();
    own.dedup();
    own
}

/// The columns of faces and corners that decide how a vertex looks.
struct Looks<'a> {
    face_colors: Option<Vec<Color>>,
    corner_uvs: Option<&'a [[f64; 2]]>,
    corner_normals: Option<&'a [[f64; 3]]>,
}

impl<'a> Looks<'a> {
    fn of(mesh: &'a RawMesh) -> Self {
        let corner = &mesh.attributes.corner;
        Looks {
            face_colors: face_colors(mesh),
            corner_uvs: match corner.get("uv") {
                Some(Column::Vector2(uvs)) => Some(uvs),
                _ => None,
            },
            corner_normals: match corner.get("normal") {
                Some(column @ Column::Vector3(normals)) if are_normals(column) => Some(normals),
                _ => None,
            },
        }
    }

    fn at(&self, face: u32, corner: u32) -> Look {
        let corner = corner as usize;
        Look {
            color: self.face_colors.as_ref().map(|colors| colors[face as usize]),
            uv: self.corner_uvs.map(|uvs| uvs[corner].map(f64::to_bits)),
            normal: self.corner_normals.map(|normals| normals[corner].map(f64::to_bits)),
        }
    }

    fn colors(&self, mesh: &RawMesh, source: &[u32], seen: &[Look]) -> Option<Vec<Color>> {
        if self.face_colors.is_some() {
            return Some(seen.iter().map(|look| look.color.unwrap_or(WHITE)).collect());
        }
        match mesh.attributes.vertex.get("color") {
            Some(Column::Color(colors)) => Some(source.iter().map(|&v| colors[v as usize]).collect()),
            _ => None,
        }
    }

    fn uvs(&self, mesh: &RawMesh, source: &[u32], seen: &[Look]) -> Option<Vec<[f64; 2]>> {
        if self.corner_uvs.is_some() {
            return Some(seen.iter().map(|look| look.uv.unwrap_or_default().map(f64::from_bits)).collect());
        }
        match mesh.attributes.vertex.get("uv") {
            Some(Column::Vector2(uvs)) => Some(source.iter().map(|&v| uvs[v as usize]).collect()),
            _ => None,
        }
    }

    /// A vertex without faces has no normal of its own; any unit vector will do.
    fn normals(&self, mesh: &RawMesh, source: &[u32], seen: &[Look]) -> Option<Vec<[f64; 3]>> {
        if self.corner_normals.is_some() {
            let bits = |look: &Look| look.normal.map_or([0.0, 0.0, 1.0], |n| n.map(f64::from_bits));
            return Some(seen.iter().map(bits).collect());
        }
        match mesh.attributes.vertex.get("normal") {
            Some(column @ Column::Vector3(normals)) if are_normals(column) => {
                Some(source.iter().map(|&v| normals[v as usize]).collect())
            }
            _ => None,
        }
    }
}
