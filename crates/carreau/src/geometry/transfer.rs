//! What a mesh has on its vertices, faces and corners, carried over to another mesh of the same surface.
//!
//! | of the source | at the target |
//! |---|---|
//! | face columns | those of the triangle nearest to the middle of the face, on its side of the surface: labels are never blended |
//! | vertex columns | interpolated in the nearest triangle |
//! | corner columns | interpolated in the nearest triangle of the same chart: textures do not smear across their seams |
//! | `normal` | measured anew |
//! | tagged edges | edges that lie along them |
//! | names, colours, libraries, unit | as they are |
//!
//! A chart is what edges connect along which all corner columns agree:
//!
//! ```text
//!  ┌─────┬─────┐     the face f is nearest to chart A; its corner c is nearer to B, where texture coordinates
//!  │  A  │  B  │     are others: they are taken from A, at the place of A nearest to c
//!  │   f─┼c    │
//!  └─────┴─────┘
//! ```
//!
//! Columns that the target has already are its own and stay.

use super::features::{FeatureOptions, feature_edges};
use super::normals::{corner_normals, face_normals, unit, vertex_normals};
use super::search_tree::{Closest, TriangleTree};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{
    Attributes, Column, Columns, CornerId, DisjointSets, RawMesh, Side, SurfaceMesh, area_vector, blend_columns,
    gather_columns,
};
use crate::words::counted;
use glam::DVec3;
use rayon::prelude::*;

/// The column of normals, which are measured anew.
const NORMAL: &str = "normal";
/// Edges lie along others where they are as near as this share of the diagonal: ridges may move by half of it.
const ALONG: f64 = 1e-3;
/// … and as near as this share of their own length …
const ALONG_OWN: f64 = 0.1;
/// … and have about the same direction: cosine of 18 degrees.
const ALIGNED: f64 = 0.95;
/// Elements per piece of work.
const PIECE: usize = 256;

/// A triangle of the source and a place in it.
type Mixture = [(u32, f64); 3];

/// Carries what `source` has over to `target`, which describes the same surface. Returns a sentence for what could not be
/// carried.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline), and those of a target that is no
/// surface.
pub fn transfer(source: &SurfaceMesh, target: &mut RawMesh, context: &Context) -> Result<Vec<String>> {
    let own = std::mem::take(&mut target.attributes);
    let mut all = Attributes::words_of(&source.attributes);
    all.names.extend(own.names.clone());
    all.colors.extend(own.colors.clone());
    let wanted = |from: &Columns, own: &Columns| -> Columns {
        let missing = |(name, _): &(&String, &Column)| *name != NORMAL && !own.contains_key(*name);
        from.iter().filter(missing).map(|(name, column)| (name.clone(), column.clone())).collect()
    };
    let from = &source.attributes;
    let vertex = wanted(&from.vertex, &own.vertex);
    let face = wanted(&from.face, &own.face);
    let corner = wanted(&from.corner, &own.corner);
    let has_columns = [&vertex, &face, &corner].into_iter().any(|columns| !columns.is_empty());
    if has_columns && !source.faces().is_empty() {
        let surface = Surface::new(source, &corner, context)?;
        if !vertex.is_empty() {
            let at = |p: &DVec3| surface.mixture(surface.tree.closest(*p));
            let mixtures = mapped(&target.points, context, at)?;
            all.vertex = blend_columns(&vertex, &mixtures);
        }
        if !face.is_empty() || !corner.is_empty() {
            let faces: Vec<&[u32]> = target.faces.iter().collect();
            let seats = mapped(&faces, context, |f| surface.seat(&target.points, f))?;
            let parents: Vec<u32> = seats.iter().map(|&t| surface.parents[t as usize]).collect();
            all.face = gather_columns(&face, &parents);
            if !corner.is_empty() {
                let seated: Vec<(u32, u32)> =
                    faces.iter().zip(&seats).flat_map(|(f, &t)| f.iter().map(move |&v| (t, v))).collect();
                let at = |&(seat, v): &(u32, u32)| surface.corner(seat, target.points[v as usize]);
                all.corner = blend_columns(&corner, &mapped(&seated, context, at)?);
            }
        }
    }
    add_normals(source, target, &own, &mut all)?;
    all.vertex.extend(own.vertex);
    all.face.extend(own.face);
    all.corner.extend(own.corner);
    let mut said = Vec::new();
    if target.edges.is_empty() && !source.tagged_edges.is_empty() {
        said.extend(carry_edges(source, target));
    }
    target.attributes = all;
    Ok(said)
}

/// Maps in parallel, in pieces between which the context is asked.
fn mapped<T: Sync, R: Send>(items: &[T], context: &Context, f: impl Fn(&T) -> R + Sync) -> Result<Vec<R>> {
    let pieces: Vec<Vec<R>> = items
        .par_chunks(PIECE)
        .map(|piece| -> Result<Vec<R>> {
            context.check()?;
            Ok(piece.iter().map(&f).collect())
        })
        .collect::<Result<_>>()?;
    Ok(pieces.into_iter().flatten().collect())
}

/// The source, ready to be asked.
struct Surface<'a> {
    points: &'a [DVec3],
    triangles: Vec<[u32; 3]>,
    /// Corners of the triangles, numbered over all polygons.
    corners: Vec<[u32; 3]>,
    /// The face of every triangle.
    parents: Vec<u32>,
    /// The chart of every face.
    charts: Vec<u32>,
    tree: TriangleTree,
}

impl<'a> Surface<'a> {
    fn new(source: &'a SurfaceMesh, corner: &Columns, context: &Context) -> Result<Self> {
        let (triangles, parents) = source.faces().fan();
        let mut corners = Vec::with_capacity(triangles.len());
        for (f, face) in source.faces().iter().enumerate() {
            let first = source.faces().offsets()[f];
            let n = face.len() as u32;
            corners.extend((1..n.saturating_sub(1)).map(|k| [first, first + k, first + k + 1]));
        }
        context.check()?;
        let tree = TriangleTree::new(source.points(), &triangles);
        let charts = if corner.is_empty() { Vec::new() } else { charts(source, corner) };
        Ok(Surface { points: source.points(), triangles, corners, parents, charts, tree })
    }

    fn places(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.points[v as usize])
    }

    /// The triangle nearest to the middle of a face, among those that look the same way where there are any about as near.
    fn seat(&self, points: &[DVec3], face: &[u32]) -> u32 {
        let middle = face.iter().map(|&v| points[v as usize]).sum::<DVec3>() / face.len().max(1) as f64;
        let Some(nearest) = self.tree.closest(middle) else { return 0 };
        let normal = unit(area_vector(points, face));
        let facing = |t: u32| {
            let [a, b, c] = self.places(t);
            unit((b - a).cross(c - a)).dot(normal) > 0.0
        };
        if facing(nearest.triangle) {
            return nearest.triangle;
        }
        let size = face.iter().map(|&v| points[v as usize].distance(middle)).fold(0.0, f64::max);
        let radius = 2.0 * nearest.distance() + size;
        let cost = |hit: &Closest| facing(hit.triangle).then_some(hit.distance_squared);
        self.tree.cheapest(middle, radius, cost).map_or(nearest.triangle, |(_, hit)| hit.triangle)
    }

    /// The vertices around a place, with their weights.
    fn mixture(&self, hit: Option<Closest>) -> Mixture {
        let Some(hit) = hit else { return [(0, 1.0), (0, 0.0), (0, 0.0)] };
        let weights = weights(hit.point, self.places(hit.triangle));
        let vertices = self.triangles[hit.triangle as usize];
        [0, 1, 2].map(|k| (vertices[k], weights[k]))
    }

    /// The corners around a place near a triangle, in the chart of that triangle.
    fn corner(&self, seat: u32, p: DVec3) -> Mixture {
        let chart = self.chart(seat);
        let nearest = self.tree.closest(p).filter(|hit| self.chart(hit.triangle) == chart);
        let hit = nearest.or_else(|| {
            let [a, b, c] = self.places(seat);
            let radius = [a, b, c].iter().map(|q| q.distance(p)).fold(0.0, f64::max);
            let cost = |hit: &Closest| (self.chart(hit.triangle) == chart).then_some(hit.distance_squared);
            self.tree.cheapest(p, radius, cost).map(|(_, hit)| hit)
        });
        let (triangle, place) = hit.map_or((seat, p), |hit| (hit.triangle, hit.point));
        let weights = weights(place, self.places(triangle));
        let corners = self.corners[triangle as usize];
        [0, 1, 2].map(|k| (corners[k], weights[k]))
    }

    fn chart(&self, t: u32) -> u32 {
        self.charts[self.parents[t as usize] as usize]
    }
}

/// Barycentric coordinates of a place in a triangle, none negative; those of its nearest corner where it has no area.
fn weights(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let n = (b - a).cross(c - a);
    let area = n.length_squared();
    if !(area > 0.0 && area.is_finite()) {
        let distances = [a, b, c].map(|q| q.distance(p));
        let nearest = (0..3).min_by(|&i, &j| distances[i].total_cmp(&distances[j])).unwrap_or(0);
        return std::array::from_fn(|k| if k == nearest { 1.0 } else { 0.0 });
    }
    let part = |q: DVec3, r: DVec3| ((q - p).cross(r - p).dot(n) / area).max(0.0);
    let parts = [part(b, c), part(c, a), part(a, b)];
    let sum: f64 = parts.iter().sum();
    if sum > 0.0 { parts.map(|w| w / sum) } else { [1.0 / 3.0; 3] }
}

/// The chart of every face: faces are of one where they meet at an edge along which all corner columns agree.
fn charts(mesh: &SurfaceMesh, corner: &Columns) -> Vec<u32> {
    let mut sets = DisjointSets::new(mesh.face_count());
    let agree = |a: CornerId, b: CornerId| corner.values().all(|column| same(column, a.index(), b.index()));
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        if let Side::Inner(o) = mesh.side(c)
            && c.index() < o.index()
            // The half-edges run against each other: the end of one is the start of the other.
            && agree(c, mesh.next(o))
            && agree(mesh.next(c), o)
        {
            sets.union(mesh.face_of(c).0, mesh.face_of(o).0);
        }
    }
    sets.leaders()
}

fn same(column: &Column, a: usize, b: usize) -> bool {
    match column {
        Column::Scalar(v) => v[a] == v[b],
        Column::Vector2(v) => v[a] == v[b],
        Column::Vector3(v) => v[a] == v[b],
        Column::Label(v) => v[a] == v[b],
        Column::Color(v) => v[a] == v[b],
    }
}

/// Normals of the target, where the source has some: of its vertices, of its corners (one for each side of a feature).
fn add_normals(source: &SurfaceMesh, target: &RawMesh, own: &Attributes, all: &mut Attributes) -> Result<()> {
    let has = |columns: &Columns| matches!(columns.get(NORMAL), Some(Column::Vector3(_)));
    let vertex = has(&source.attributes.vertex) && !own.vertex.contains_key(NORMAL);
    let corner = has(&source.attributes.corner) && !own.corner.contains_key(NORMAL);
    if !(vertex || corner) || target.faces.is_empty() {
        return Ok(());
    }
    let mesh = RawMesh { attributes: Attributes::default(), ..target.clone() }.into_surface()?;
    let normals = face_normals(&mesh);
    let column = |list: Vec<DVec3>| Column::Vector3(list.iter().map(DVec3::to_array).collect());
    if vertex {
        all.vertex.insert(NORMAL.into(), column(vertex_normals(&mesh, &normals)));
    }
    if corner {
        let features = feature_edges(&mesh, &FeatureOptions::default())?;
        all.corner.insert(NORMAL.into(), column(corner_normals(&mesh, &normals, &features.corners)));
    }
    Ok(())
}

/// Tags the edges of the target that lie along tagged edges of the source.
fn carry_edges(source: &SurfaceMesh, target: &mut RawMesh) -> Option<String> {
    let points = source.points();
    let tagged = &source.tagged_edges;
    let tree = TriangleTree::of_segments(points, tagged.iter().map(|e| e.ends.map(|v| v.0)));
    let limit = ALONG * source.diagonal();
    let mut edges: Vec<[u32; 2]> = target
        .faces
        .iter()
        .flat_map(|f| (0..f.len()).map(|k| [f[k], f[(k + 1) % f.len()]]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.par_sort_unstable();
    edges.dedup();
    let tag_of = |&[a, b]: &[u32; 2]| {
        let [p, q] = [a, b].map(|v| target.points[v as usize]);
        let near = limit.min(ALONG_OWN * p.distance(q));
        let middle = tree.closest_within(0.5 * (p + q), near)?;
        [p, q].iter().all(|&end| tree.closest_within(end, near).is_some()).then_some(())?;
        let segment = tagged.get(middle.triangle as usize)?;
        let [s, t] = segment.ends.map(|v| points[v.index()]);
        (unit(q - p).dot(unit(t - s)).abs() > ALIGNED).then_some(segment.tag)
    };
    let found: Vec<([u32; 2], i32)> = edges.par_iter().filter_map(|e| tag_of(e).map(|tag| (*e, tag))).collect();
    target.edges = found.iter().map(|e| e.0).collect();
    target.edge_tags = found.iter().map(|e| e.1).collect();
    let length = |[p, q]: [DVec3; 2]| p.distance(q);
    let before: f64 = tagged.iter().map(|e| length(e.ends.map(|v| points[v.index()]))).sum();
    let after: f64 = found.iter().map(|(e, _)| length(e.map(|v| target.points[v as usize]))).sum();
    (after < 0.99 * before).then(|| {
        let count = counted(tagged.len(), "tagged edge", "tagged edges");
        format!(
            "the method: {:.1} % of the length of {count} of the input is edges of the result",
            100.0 * after / before
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Polygons, TaggedEdge, VertexId};

    /// A square of two quads side by side, each a chart of its own.
    fn source() -> SurfaceMesh {
        let points = [(0., 0.), (1., 0.), (2., 0.), (0., 1.), (1., 1.), (2., 1.)];
        let points = points.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        let faces: Polygons = [&[0u32, 1, 4, 3][..], &[1, 2, 5, 4]].into_iter().collect();
        let mut mesh = SurfaceMesh::new(points.clone(), faces).unwrap();
        let a = &mut mesh.attributes;
        a.vertex.insert("heat".into(), Column::Scalar(points.iter().map(|p| p.x).collect()));
        a.vertex.insert("normal".into(), Column::Vector3(vec![[9.0; 3]; 6]));
        a.face.insert("material".into(), Column::Label(vec![3, 8]));
        a.names.insert(("material".into(), 3), "red".into());
        let uvs = [[0., 0.], [1., 0.], [1., 1.], [0., 1.], [5., 0.], [6., 0.], [6., 1.], [5., 1.]];
        a.corner.insert("uv".into(), Column::Vector2(uvs.to_vec()));
        a.corner.insert("normal".into(), Column::Vector3(vec![[9.0; 3]; 8]));
        mesh.tagged_edges = vec![TaggedEdge { ends: [VertexId(1), VertexId(4)], tag: 7 }];
        mesh
    }

    /// The same in triangles, one of which reaches across the seam by a little.
    #[test]
    fn everything_comes_along() {
        let points = [(0., 0.), (1.001, 0.), (2., 0.), (0., 1.), (1.001, 1.), (2., 1.)];
        let faces = [[0u32, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        let mut target = RawMesh {
            points: points.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
            faces: Polygons::from_triangles(&faces),
            ..RawMesh::default()
        };
        transfer(&source(), &mut target, &Context::new()).unwrap();
        let a = &target.attributes;
        assert_eq!(a.face["material"], Column::Label(vec![3, 3, 8, 8]));
        assert_eq!(a.name("material", 3), Some("red"));
        let Column::Scalar(heat) = &a.vertex["heat"] else { panic!("numbers stay numbers") };
        assert!(heat.iter().zip(points).all(|(h, p)| (h - p.0).abs() < 1e-12), "{heat:?}");
        let Column::Vector2(uvs) = &a.corner["uv"] else { panic!("pairs stay pairs") };
        // No corner takes the coordinates of the other chart, or a mixture of both.
        assert!(uvs[..6].iter().all(|uv| (0.0..=1.0).contains(&uv[0])), "{uvs:?}");
        assert!(uvs[6..].iter().all(|uv| (5.0..=6.0).contains(&uv[0])), "{uvs:?}");
        assert_eq!(a.vertex["normal"], Column::Vector3(vec![[0.0, 0.0, 1.0]; 6]));
        assert_eq!(a.corner["normal"], Column::Vector3(vec![[0.0, 0.0, 1.0]; 12]));
        assert_eq!((&target.edges, &target.edge_tags), (&vec![[1, 4]], &vec![7]));
    }

    /// Two sheets back to back, a hair apart: each face takes the label of the sheet that looks its way.
    #[test]
    fn labels_stay_on_their_side() {
        let corner = |z: f64| [(0., 0.), (1., 0.), (0., 1.)].map(|(x, y)| DVec3::new(x, y, z));
        let points = [corner(0.0), corner(1e-3)].concat();
        let mut sheets = SurfaceMesh::from_triangles(points, &[[0, 2, 1], [3, 4, 5]]).unwrap();
        sheets.attributes.face.insert("side".into(), Column::Label(vec![1, 2]));
        let points = [corner(9e-4), corner(1e-4)].concat();
        let faces = Polygons::from_triangles(&[[0, 2, 1], [3, 4, 5]]);
        let mut target = RawMesh { points, faces, ..RawMesh::default() };
        transfer(&sheets, &mut target, &Context::new()).unwrap();
        assert_eq!(target.attributes.face["side"], Column::Label(vec![1, 2]));
    }
}
