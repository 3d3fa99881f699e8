//! What belongs to one body: its outer surface, its cavities, its name.

use super::super::attributes::Column;
use super::super::nesting::Shells;
use super::super::surface::SurfaceMesh;

/// Face columns that name bodies, the surest first.
const NAMES: [&str; 4] = ["solid", "object", "body", "group"];

/// The face column that tells bodies apart, and its labels; none where all faces have the same.
fn column(mesh: &SurfaceMesh) -> Option<(&'static str, &[i32])> {
    NAMES.into_iter().find_map(|name| match mesh.attributes.face.get(name) {
        Some(Column::Label(labels)) if labels.len() == mesh.face_count() => {
            labels.iter().any(|l| *l != labels[0]).then_some((name, &labels[..]))
        }
        _ => None,
    })
}

/// The label that names the body of every face.
pub(in crate::mesh) fn labels(mesh: &SurfaceMesh) -> Option<&[i32]> {
    column(mesh).map(|(_, labels)| labels)
}

/// A body of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name in the file, where all its faces have one.
    pub name: Option<String>,
    /// Number of faces.
    pub faces: usize,
    /// The first of them.
    pub first: u32,
    /// Their area.
    pub area: f64,
}

/// The bodies of a surface, in the order of their first faces, and the body of every face.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bodies {
    /// The bodies.
    pub list: Vec<Body>,
    /// The body of every face.
    pub of_face: Vec<u32>,
}

impl Bodies {
    /// Components as bodies: cavities belong to the one around them.
    pub(super) fn of(mesh: &SurfaceMesh, component: &[u32], count: usize, shells: &Shells) -> Self {
        let outer: Vec<u32> = (0..count as u32).map(|c| shells.body(c)).collect();
        let (mut number, mut list, mut of_face) =
            (vec![u32::MAX; count], Vec::new(), Vec::with_capacity(component.len()));
        let names = column(mesh);
        let mut label: Vec<Option<i32>> = Vec::new();
        for (face, f) in mesh.faces().iter().zip(0u32..) {
            let place = &mut number[outer[component[f as usize] as usize] as usize];
            if *place == u32::MAX {
                *place = list.len() as u32;
                list.push(Body { name: None, faces: 0, first: f, area: 0.0 });
                label.push(names.map(|(_, labels)| labels[f as usize]));
            }
            let b = *place as usize;
            list[b].faces += 1;
            list[b].area += super::super::area::safe_length(super::super::area::area_vector(mesh.points(), face));
            if names.is_some_and(|(_, labels)| Some(labels[f as usize]) != label[b]) {
                label[b] = None;
            }
            of_face.push(b as u32);
        }
        for (body, label) in list.iter_mut().zip(label) {
            let word =
                names.zip(label).and_then(|((name, _), label)| mesh.attributes.names.get(&(name.to_string(), label)));
            body.name = word.filter(|word| !word.is_empty()).cloned();
        }
        Bodies { list, of_face }
    }
}
