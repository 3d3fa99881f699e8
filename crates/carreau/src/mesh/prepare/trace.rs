//! The way back: what every vertex and face of a prepared surface was in the file.

use super::super::attributes::{Column, Columns};
use super::super::repair::Soup;
use super::super::surface::SurfaceMesh;
use super::super::triangles::NONE;
use super::bodies::Bodies;
use super::report::PrepareReport;
use crate::error::{Error, Result};

/// The column that numbers polygons while they are cut.
const POLYGON: &str = "polygon that was cut";

/// A prepared surface.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// What rooms work on.
    pub mesh: SurfaceMesh,
    /// Its bodies.
    pub bodies: Bodies,
    /// What was done.
    pub report: PrepareReport,
    /// The way back; none where the mesh is as it was.
    pub(super) trace: Option<Box<Trace>>,
}

/// The input, and what became of it.
#[derive(Debug, Clone)]
pub(super) struct Trace {
    pub input: Option<SurfaceMesh>,
    pub vertex_source: Vec<u32>,
    pub face_source: Vec<u32>,
    pub vertex_image: Vec<u32>,
    pub face_image: Vec<u32>,
}

impl Trace {
    pub fn of(soup: &Soup, input: &SurfaceMesh, doubles: &[[u32; 2]]) -> Self {
        let mut face_image = vec![NONE; input.face_count()];
        for (f, &source) in soup.face_source.iter().enumerate().rev() {
            face_image[source as usize] = f as u32;
        }
        doubles.iter().for_each(|&[gone, stays]| face_image[gone as usize] = face_image[stays as usize]);
        Trace {
            input: None,
            vertex_source: soup.vertex_source.clone(),
            face_source: soup.face_source.clone(),
            vertex_image: soup.vertex_image.clone(),
            face_image,
        }
    }

    /// A surface that is as it was.
    pub fn identity(input: &SurfaceMesh) -> Self {
        let all = |n: usize| (0..n as u32).collect::<Vec<u32>>();
        let (vertices, faces) = (input.vertex_count(), input.face_count());
        Trace {
            input: None,
            vertex_source: all(vertices),
            face_source: all(faces),
            vertex_image: all(vertices),
            face_image: all(faces),
        }
    }

    pub fn with(self, input: SurfaceMesh) -> Self {
        Trace { input: Some(input), ..self }
    }

    /// The trace after vertices and faces were left out: the old number of each that stays.
    pub fn reduced(mut self, vertices: &[u32], faces: &[u32]) -> Self {
        let new_ids = |old: &[u32], count: usize| {
            let mut new = vec![NONE; count];
            (0u32..).zip(old).for_each(|(k, &o)| new[o as usize] = k);
            new
        };
        let (v, f) = (new_ids(vertices, self.vertex_source.len()), new_ids(faces, self.face_source.len()));
        let moved = |id: &mut u32, new: &[u32]| *id = if *id == NONE { NONE } else { new[*id as usize] };
        self.vertex_image.iter_mut().for_each(|id| moved(id, &v));
        self.face_image.iter_mut().for_each(|id| moved(id, &f));
        self.vertex_source = vertices.iter().map(|&k| self.vertex_source[k as usize]).collect();
        self.face_source = faces.iter().map(|&k| self.face_source[k as usize]).collect();
        self
    }
}

impl Prepared {
    /// A surface taken as it is.
    pub(super) fn as_is(mesh: SurfaceMesh) -> Self {
        let report = PrepareReport { as_is: true, ..PrepareReport::default() };
        Prepared { mesh, bodies: Bodies::default(), report, trace: None }
    }

    /// A surface on which there was nothing to do.
    pub(super) fn unchanged(mesh: SurfaceMesh, bodies: Bodies) -> Self {
        let report = PrepareReport { bodies: bodies.list.len(), ..PrepareReport::default() };
        Prepared { mesh, bodies, report, trace: None }
    }

    /// Whether the surface is no longer that of the file.
    pub fn is_changed(&self) -> bool {
        self.trace.is_some()
    }

    /// The surface of the file.
    pub fn input(&self) -> &SurfaceMesh {
        self.trace.as_ref().and_then(|trace| trace.input.as_ref()).unwrap_or(&self.mesh)
    }

    /// The file's vertex that a vertex was.
    pub fn vertex(&self, v: u32) -> u32 {
        self.trace.as_ref().map_or(v, |trace| trace.vertex_source.get(v as usize).copied().unwrap_or(v))
    }

    /// The file's face that a face was, or was a part of.
    pub fn face(&self, f: u32) -> u32 {
        self.trace.as_ref().map_or(f, |trace| trace.face_source.get(f as usize).copied().unwrap_or(f))
    }

    /// What a vertex of the file has become; none where no face that is left uses it.
    pub fn vertex_image(&self, v: u32) -> Option<u32> {
        match &self.trace {
            None => Some(v),
            Some(trace) => trace.vertex_image.get(v as usize).copied().and_then(super::ids::some),
        }
    }

    /// The surface of the file, taken out.
    pub fn into_input(self) -> SurfaceMesh {
        self.trace.and_then(|trace| trace.input).unwrap_or(self.mesh)
    }

    /// The same with polygons cut into triangles.
    ///
    /// # Errors
    /// None that the mesh itself did not have.
    pub fn triangulated(mut self) -> Result<Self> {
        if self.mesh.is_triangular() {
            return Ok(self);
        }
        let faces = (0..self.mesh.face_count() as i32).collect();
        self.mesh.attributes.face.insert(POLYGON.into(), Column::Label(faces));
        self.mesh = self.mesh.triangulated()?;
        let Some(Column::Label(parent)) = self.mesh.attributes.face.remove(POLYGON) else {
            return Err(Error::Bug("a face lost its number".into()));
        };
        let parent: Vec<usize> = parent.into_iter().map(|f| f as usize).collect();
        self.bodies.of_face = parent.iter().map(|&f| self.bodies.of_face.get(f).copied().unwrap_or(0)).collect();
        if let Some(trace) = &mut self.trace {
            trace.face_source = parent.iter().map(|&f| trace.face_source[f]).collect();
            let mut first = vec![NONE; parent.iter().max().map_or(0, |&f| f + 1)];
            parent.iter().enumerate().rev().for_each(|(t, &f)| first[f] = t as u32);
            for image in trace.face_image.iter_mut().filter(|image| **image != NONE) {
                *image = first.get(*image as usize).copied().unwrap_or(NONE);
            }
        }
        Ok(self)
    }

    /// Whether a face runs against the one that it was in the file.
    pub fn is_turned(&self, f: u32) -> bool {
        if self.trace.is_none() {
            return false;
        }
        let now = self.mesh.faces().face(f as usize);
        let before = self.input().faces().face(self.face(f) as usize);
        let before: Vec<Option<u32>> = before.iter().map(|&v| self.vertex_image(v)).collect();
        let reversed: Vec<Option<u32>> = before.iter().rev().copied().collect();
        steps_agree(now, &reversed) && !steps_agree(now, &before)
    }

    /// The faces of the file that are not in the surface, nor stand for one that is.
    pub fn left_out(&self) -> Vec<u32> {
        let Some(trace) = &self.trace else { return Vec::new() };
        let stands = |f: u32| {
            let image = trace.face_image[f as usize];
            image != NONE && trace.face_source[image as usize] == f
        };
        (0..trace.face_image.len() as u32).filter(|&f| !stands(f)).collect()
    }

    /// Values of the surface's vertices as values of the file's; the last is for those that are gone.
    pub fn values_of_vertices<T: Copy>(&self, values: Vec<T>, otherwise: T) -> Vec<T> {
        match &self.trace {
            None => values,
            Some(trace) => {
                let value = |&image: &u32| values.get(image as usize).copied().unwrap_or(otherwise);
                trace.vertex_image.iter().map(value).collect()
            }
        }
    }

    /// Values of the file's faces as values of the surface's.
    pub fn gather_faces<T: Copy>(&self, values: Vec<T>) -> Vec<T> {
        match &self.trace {
            None => values,
            Some(trace) => trace.face_source.iter().map(|&f| values[f as usize]).collect(),
        }
    }

    /// Labels of the surface's faces as labels of the file's. A face that was left out has the label of the one that stands for
    /// it, or of the first one at its edges or vertices; else 0.
    pub fn labels_of_faces(&self, labels: &[u32]) -> Vec<u32> {
        let Some(trace) = &self.trace else { return labels.to_vec() };
        let near = Nearby::new(self);
        let label = |(f, &image): (u32, &u32)| match image {
            NONE => near.face_at(self, f).map_or(0, |f| labels[f as usize]),
            image => labels[image as usize],
        };
        (0u32..).zip(&trace.face_image).map(label).collect()
    }
}

/// Whether a face has an edge in the sense that it had.
fn steps_agree(now: &[u32], before: &[Option<u32>]) -> bool {
    let n = before.len();
    (0..now.len()).any(|k| {
        let [a, b] = [Some(now[k]), Some(now[(k + 1) % now.len()])];
        (0..n).any(|k| before[k] == a && before[(k + 1) % n] == b)
    })
}

/// The faces at vertices of a surface.
struct Nearby {
    /// The first face at every vertex.
    at_vertex: Vec<u32>,
    half_edges: super::super::half_edges::HalfEdges,
    face_of: Vec<u32>,
}

impl Nearby {
    fn new(prepared: &Prepared) -> Self {
        let mesh = &prepared.mesh;
        let mut at_vertex = vec![NONE; mesh.vertex_count()];
        for (face, f) in mesh.faces().iter().zip(0u32..) {
            face.iter().for_each(|&v| at_vertex[v as usize] = at_vertex[v as usize].min(f));
        }
        Nearby { at_vertex, half_edges: mesh.half_edges(), face_of: mesh.faces().face_of_corners() }
    }

    /// A face at the place of one of the file's that was left out.
    fn face_at(&self, prepared: &Prepared, f: u32) -> Option<u32> {
        let face = prepared.input().faces().face(f as usize);
        let now: Vec<u32> = face.iter().filter_map(|&v| prepared.vertex_image(v)).collect();
        let pairs = (0..now.len()).map(|k| [now[k], now[(k + 1) % now.len()]]).filter(|[a, b]| a != b);
        let beside = pairs
            .filter_map(|[a, b]| self.half_edges.find(a, b))
            .flat_map(|edge| edge.corners().map(|c| self.face_of[c as usize]).collect::<Vec<u32>>());
        beside.min().or_else(|| now.iter().filter_map(|&v| super::ids::some(self.at_vertex[v as usize])).min())
    }
}

/// Vertex columns in which vertices that became one differ, as along the seam of a texture, become corner columns.
pub(super) fn split_columns(mesh: &mut SurfaceMesh, input: &SurfaceMesh, vertex_source: &[u32], corner_source: &[u32]) {
    let own: Vec<u32> = corner_source.iter().map(|&c| input.faces().corners()[c as usize]).collect();
    let now: Vec<u32> = mesh.faces().corners().iter().map(|&v| vertex_source[v as usize]).collect();
    if own == now {
        return;
    }
    let mut split = Columns::new();
    for (name, column) in &input.attributes.vertex {
        let is_of_side = matches!(column, Column::Vector2(_) | Column::Vector3(_) | Column::Color(_));
        if is_of_side && !mesh.attributes.corner.contains_key(name) && column.gather(&own) != column.gather(&now) {
            split.insert(name.clone(), column.gather(&own));
        }
    }
    split.keys().for_each(|name| drop(mesh.attributes.vertex.remove(name)));
    mesh.attributes.corner.extend(split);
}
