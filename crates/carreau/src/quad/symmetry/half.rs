//! The part of a surface above a plane: triangles across it are cut there.

use super::MirrorPlane;
use crate::error::Result;
use crate::mesh::{NONE, SurfaceMesh, TaggedEdge, VertexId, divided};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// A share of the diagonal: a vertex so near to the plane is put into it, because triangles as thin would be cut off.
const IN_PLANE: f64 = 1e-7;
/// A share of its shortest edge: the same, because the cut is to leave no needles beside it.
const NEAR_PLANE: f64 = 0.02;
/// A share of the diagonal: no vertex is moved by more into the plane.
const MOST_MOVED: f64 = 1e-4;

/// A part of a surface.
pub struct Part {
    /// Edges that were tagged or listed are tagged.
    pub mesh: SurfaceMesh,
    /// All its features.
    pub features: Vec<[VertexId; 2]>,
}

/// The half above, with what is left of its tagged edges and of its features; `None` where nothing is above, or below.
pub fn half(part: &Part, plane: &MirrorPlane) -> Result<Option<Part>> {
    let mesh = divided(&part.mesh)?;
    let height = heights(&mesh, plane);
    if !height.iter().any(|&h| h > 0.0) || !height.iter().any(|&h| h < 0.0) {
        return Ok(None);
    }
    let mut cut = Cut { mesh: &mesh, height, plane, points: Vec::new(), of: FxHashMap::default(), number: Vec::new() };
    cut.number = vec![NONE; mesh.vertex_count()];
    let mut triangles = Vec::new();
    for t in mesh.faces().iter() {
        let polygon = cut.above(t);
        // From the corner whose diagonal is the shorter one.
        let from = usize::from(polygon.len() == 4 && cut.is_shorter(polygon[1], polygon[3], polygon[0], polygon[2]));
        for k in 1..polygon.len().saturating_sub(1) {
            let at = |k: usize| polygon[(from + k) % polygon.len()];
            triangles.push([at(0), at(k), at(k + 1)]);
        }
    }
    let tagged: Vec<TaggedEdge> = mesh
        .tagged_edges
        .iter()
        .filter_map(|e| Some(TaggedEdge { ends: cut.edge_above(e.ends)?, tag: e.tag }))
        .collect();
    let features = part.features.iter().filter_map(|&ends| cut.edge_above(ends)).collect();
    let mut above = SurfaceMesh::from_triangles(cut.points, &triangles)?;
    above.tagged_edges = tagged;
    Ok(Some(Part { mesh: above, features }))
}

/// Of every vertex above the plane; zero in it.
fn heights(mesh: &SurfaceMesh, plane: &MirrorPlane) -> Vec<f64> {
    let mut shortest = vec![f64::INFINITY; mesh.vertex_count()];
    for t in mesh.faces().iter() {
        for k in 0..3 {
            let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| v as usize);
            let length = mesh.points()[a].distance(mesh.points()[b]);
            [a, b].into_iter().for_each(|v| shortest[v] = shortest[v].min(length));
        }
    }
    let diagonal = mesh.diagonal();
    let of = |(&p, shortest): (&DVec3, f64)| {
        let height = plane.height(p);
        let within = (NEAR_PLANE * shortest).min(MOST_MOVED * diagonal).max(IN_PLANE * diagonal);
        if height.abs() <= within { 0.0 } else { height }
    };
    mesh.points().iter().zip(shortest).map(of).collect()
}

/// A surface that is being cut.
struct Cut<'a> {
    mesh: &'a SurfaceMesh,
    height: Vec<f64>,
    plane: &'a MirrorPlane,
    points: Vec<DVec3>,
    /// The new vertex of every old one.
    number: Vec<u32>,
    /// The new vertex of an edge that crosses the plane, by its ends in ascending order.
    of: FxHashMap<[u32; 2], u32>,
}

impl Cut<'_> {
    /// The part of a triangle that is above.
    fn above(&mut self, t: &[u32]) -> Vec<u32> {
        let height = [0, 1, 2].map(|k| self.height[t[k] as usize]);
        if !height.iter().any(|&h| h > 0.0) {
            return Vec::new();
        }
        let mut polygon = Vec::with_capacity(4);
        for k in 0..3 {
            let [a, b] = [height[k], height[(k + 1) % 3]];
            if a >= 0.0 {
                polygon.push(self.vertex(t[k]));
            }
            if a * b < 0.0 {
                polygon.push(self.crossing(t[k], t[(k + 1) % 3]));
            }
        }
        polygon
    }

    fn vertex(&mut self, v: u32) -> u32 {
        if self.number[v as usize] == NONE {
            let p = self.mesh.points()[v as usize];
            self.number[v as usize] = self.points.len() as u32;
            self.points.push(if self.height[v as usize] == 0.0 { self.plane.foot(p) } else { p });
        }
        self.number[v as usize]
    }

    fn crossing(&mut self, a: u32, b: u32) -> u32 {
        let ends = [a.min(b), a.max(b)];
        let next = self.points.len() as u32;
        let found = *self.of.entry(ends).or_insert(next);
        if found == next {
            let [p, q] = ends.map(|v| self.mesh.points()[v as usize]);
            let [h, g] = ends.map(|v| self.height[v as usize]);
            self.points.push(self.plane.foot(p.lerp(q, h / (h - g))));
        }
        found
    }

    /// The part of an edge of the surface that is above.
    fn edge_above(&self, ends: [VertexId; 2]) -> Option<[VertexId; 2]> {
        let [a, b] = ends.map(|v| v.0);
        let at = |v: u32| self.number.get(v as usize).copied().filter(|&n| n != NONE);
        let crossing = || self.of.get(&[a.min(b), a.max(b)]).copied();
        let [a, b] = match [at(a), at(b)] {
            [Some(a), Some(b)] => [a, b],
            [Some(a), None] | [None, Some(a)] => [a, crossing()?],
            [None, None] => return None,
        };
        Some([VertexId(a), VertexId(b)])
    }

    fn is_shorter(&self, a: u32, b: u32, c: u32, d: u32) -> bool {
        let length = |a: u32, b: u32| self.points[a as usize].distance_squared(self.points[b as usize]);
        length(a, b) < length(c, d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::{Topology, area_vector};
    use crate::sample;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn both_halves_are_the_whole(
            normal in prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from_array)
                .prop_filter("long enough", |n| n.length() > 0.1),
            share in -0.2..0.2f64,
        ) {
            let mesh = sample::make("torus", None, &Context::new()).unwrap();
            let area = |mesh: &SurfaceMesh| -> f64 {
                mesh.faces().iter().map(|f| area_vector(mesh.points(), f).length()).sum()
            };
            let normal = normal.normalize();
            let (low, high) = mesh.bounds();
            let offset = normal.dot((low + high) / 2.0) + share * mesh.diagonal();
            let above = MirrorPlane { normal, offset, asymmetry: 0.0 };
            let below = MirrorPlane { normal: -normal, offset: -offset, asymmetry: 0.0 };
            let whole = Part { mesh: mesh.clone(), features: Vec::new() };
            let halves = [above, below].map(|plane| half(&whole, &plane).unwrap());
            let [Some(Part { mesh: a, .. }), Some(Part { mesh: b, .. })] = halves else { return Ok(()) };
            prop_assert!((area(&a) + area(&b) - area(&mesh)).abs() < 1e-3 * area(&mesh));
            for (part, plane) in [(&a, above), (&b, below)] {
                prop_assert!(part.points().iter().all(|&p| plane.height(p) > -1e-12 * mesh.diagonal()));
                let topology = Topology::of(part);
                prop_assert!(topology.boundary_loops > 0 && topology.nonmanifold_edges == 0);
            }
        }
    }

    #[test]
    fn edges_of_the_surface_are_cut_with_it() {
        let mesh = sample::make("bracket", None, &Context::new()).unwrap();
        let (low, high) = mesh.bounds();
        let plane = MirrorPlane { normal: DVec3::X, offset: (low.x + high.x) / 2.0, asymmetry: 0.0 };
        let faces = mesh.faces();
        let all: Vec<[VertexId; 2]> =
            faces.iter().flat_map(|f| (0..3).map(move |k| [f[k], f[(k + 1) % 3]].map(VertexId))).collect();
        let count = all.len();
        let above = half(&Part { mesh, features: all }, &plane).unwrap().unwrap();
        assert!(!above.features.is_empty() && above.features.len() < count);
        let half_edges = above.mesh.half_edges();
        assert!(above.features.iter().all(|e| half_edges.find(e[0].0, e[1].0).is_some()));
    }
}
