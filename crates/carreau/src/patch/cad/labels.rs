//! What the faces of the mesh are called, and their colours: what a CAD face may not be mixed of.

use crate::brep::{Brep, Face};
use crate::mesh::{Column, SurfaceMesh};
use rustc_hash::FxHashMap;

/// Face columns that tell bodies apart, the one that counts most first.
const BODIES: [&str; 4] = ["body", "object", "solid", "part"];
/// Face columns that name faces, the one that counts most first.
const FACES: [&str; 2] = ["group", "material"];

/// Name, body and colour of faces that are alike.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct Kind {
    name: String,
    body: String,
    color: Option<[u8; 3]>,
}

/// The kinds of the faces of a mesh.
#[derive(Debug, Default)]
pub struct Labels {
    /// The kind of every face; empty where all are alike.
    pub of: Vec<u32>,
    kinds: Vec<Kind>,
}

impl Labels {
    /// Reads bodies, groups, materials and colours.
    pub fn new(mesh: &SurfaceMesh) -> Self {
        let columns = &mesh.attributes.face;
        let label = |name: &&'static str| match columns.get(*name) {
            Some(Column::Label(values)) if values.len() == mesh.face_count() => Some((*name, values)),
            _ => None,
        };
        let colors = columns.values().find_map(|c| match c {
            Column::Color(values) if values.len() == mesh.face_count() => Some(values),
            _ => None,
        });
        let labels: Vec<_> = BODIES.iter().chain(&FACES).filter_map(label).collect();
        if labels.is_empty() && colors.is_none() {
            return Labels::default();
        }
        let mut numbers: FxHashMap<(Vec<i32>, Option<[u8; 4]>), u32> = FxHashMap::default();
        let mut out = Labels::default();
        for t in 0..mesh.face_count() {
            let values: Vec<i32> = labels.iter().map(|(_, values)| values[t]).collect();
            let color = colors.map(|c| c[t]);
            let word = |wanted: &[&str]| {
                let named = labels.iter().zip(&values).filter(|((column, _), _)| wanted.contains(column));
                let word = |((column, _), value): (&(&str, _), &i32)| {
                    mesh.attributes.names.get(&((*column).to_string(), *value)).filter(|w| !w.is_empty()).cloned()
                };
                named.filter_map(word).next().unwrap_or_default()
            };
            let next = out.kinds.len() as u32;
            let number = *numbers.entry((values.clone(), color)).or_insert(next);
            if number == next {
                let color = color.map(|[r, g, b, _]| [r, g, b]);
                out.kinds.push(Kind { name: word(&FACES), body: word(&BODIES), color });
            }
            out.of.push(number);
        }
        out
    }

    /// The kind of a face; 0 where all are alike.
    pub fn kind(&self, t: usize) -> u32 {
        self.of.get(t).copied().unwrap_or(0)
    }

    /// Gives name and colour to a face that stands for triangle `t`.
    pub fn dress(&self, face: &mut Face, t: usize) {
        if let Some(kind) = self.kinds.get(self.kind(t) as usize) {
            face.name.clone_from(&kind.name);
            face.color = kind.color;
        }
    }

    /// Gives names to solids, and to shells in none; `first` is a triangle of every face.
    pub fn name_bodies(&self, brep: &mut Brep, first: &[usize]) {
        let body = |shell: u32| {
            let face = brep.shells[shell as usize].faces.first().and_then(|&f| first.get(f as usize));
            face.and_then(|&t| self.kinds.get(self.kind(t) as usize)).map(|k| k.body.clone()).unwrap_or_default()
        };
        let solids: Vec<String> = brep.solids.iter().map(|s| body(s.outer)).collect();
        let shells: Vec<(u32, String)> = brep.free_shells().into_iter().map(|s| (s, body(s))).collect();
        brep.solids.iter_mut().zip(solids).for_each(|(solid, name)| solid.name = name);
        shells.into_iter().for_each(|(s, name)| brep.shells[s as usize].name = name);
    }
}
