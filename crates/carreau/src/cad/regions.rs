//! The map that the model is made from: every triangle belongs to a piece, every piece lies on a surface.
//!
//! Regions come from [`crate::segment`].

use super::tuning::{EXACT_TOLERANCE, FILE_PRECISION, MOST_GAP, NOISY_GAP};
use crate::brep::{Frame, Surface};
use crate::geometry::primitive::{Kind, Primitive};
use crate::mesh::{DisjointSets, NONE, Triangles};
use glam::DVec3;
use serde::Serialize;

/// How a piece of the mesh is described, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rung {
    /// A plane, cylinder, cone, sphere or torus.
    Analytic,
    /// A surface of extrusion or revolution.
    Swept,
    /// A spline surface.
    Spline,
    /// Plane faces, one for each set of coplanar triangles.
    Planes,
    /// A plane face for each triangle.
    Triangles,
}

/// A part of the mesh that becomes a face.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Another number for every piece, and for a piece that is described in another way.
    pub id: u64,
    /// What it lies on.
    pub surface: Surface,
    /// The same where it is analytic.
    pub primitive: Option<Primitive>,
    /// How it is described.
    pub rung: Rung,
    /// The region of the segmentation that it is, or is a part of.
    pub region: u32,
    /// Whether the surface's normal points out of the body.
    pub same_sense: bool,
    /// Largest distance of its vertices from the surface.
    pub max: f64,
    /// How often it was cut.
    pub cuts: u8,
    /// Mean square of these distances.
    pub square: f64,
    /// Its triangles, ascending.
    pub triangles: Vec<u32>,
}

/// A surface, and the same where it is analytic.
pub type Described = (Surface, Option<Primitive>);

impl Piece {
    /// Triangles on a surface.
    pub fn on(
        t: Triangles<'_>,
        triangles: Vec<u32>,
        surface: Surface,
        primitive: Option<Primitive>,
        region: u32,
    ) -> Self {
        let rung = if primitive.is_some() { Rung::Analytic } else { Rung::Swept };
        let mut piece = Piece { surface, primitive, rung, ..Piece::free(t, triangles, region) };
        let off = |q: &DVec3| primitive.map_or_else(|| piece.surface.distance(*q), |p| p.distance(*q).abs());
        let far: Vec<f64> = vertices(t, &piece.triangles).iter().map(off).collect();
        piece.max = far.iter().copied().fold(0.0, f64::max);
        piece.square = far.iter().map(|d| d * d).sum::<f64>() / far.len().max(1) as f64;
        piece.same_sense = looks_along(t, &piece);
        piece
    }

    /// Whether it is taken for a cylinder, cone, sphere or torus.
    pub fn is_round(&self) -> bool {
        self.rung == Rung::Analytic && self.primitive.is_some_and(|p| p.kind() != Kind::Plane)
    }

    /// Triangles whose surface is still to be found.
    pub fn free(t: Triangles<'_>, triangles: Vec<u32>, region: u32) -> Self {
        let surface = Surface::Plane { frame: Frame::along(t.point(3 * triangles[0]), DVec3::Z) };
        let (primitive, rung) = (None, Rung::Spline);
        Piece { id: 0, surface, primitive, rung, region, same_sense: true, max: 0.0, cuts: 0, square: 0.0, triangles }
    }
}

/// Pieces and the piece of every triangle.
#[derive(Clone)]
pub struct Map<'a> {
    /// The mesh.
    pub t: Triangles<'a>,
    /// The length that tolerances are shares of.
    pub diagonal: f64,
    /// Largest distance of a vertex from its surface.
    pub tolerance: f64,
    /// How near vertices lie to the surfaces that they are on, where the data is exact.
    pub precision: f64,
    /// Piece of every triangle.
    pub label: Vec<u32>,
    /// All pieces.
    pub pieces: Vec<Piece>,
    /// The number of the next piece.
    pub next: u64,
}

impl Map<'_> {
    /// Whether vertices are farther from their surfaces than those of exact data.
    pub fn is_noisy(&self) -> bool {
        self.tolerance > EXACT_TOLERANCE * self.diagonal
    }

    /// Largest gap between a face, its edges and their ends. What noise leaves over where surfaces nearly touch is no gap.
    pub fn gap(&self) -> f64 {
        let noise = if self.is_noisy() { NOISY_GAP * self.tolerance } else { 0.0 };
        noise.max(MOST_GAP * self.diagonal)
    }

    /// A number that no piece has.
    pub fn new_id(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }

    /// Puts pieces in the place of others: parts of their triangles with their surfaces, a piece for every connected part, which is of
    /// the region that most of its triangles were of. Triangles in none of the parts have no surface.
    pub fn replace(&mut self, which: &[u32], mut parts: Vec<(Vec<u32>, Option<Described>)>) {
        let mut rest: Vec<u32> =
            which.iter().flat_map(|&p| std::mem::take(&mut self.pieces[p as usize].triangles)).collect();
        rest.sort_unstable();
        let mut taken: Vec<u32> = parts.iter().flat_map(|part| part.0.iter().copied()).collect();
        taken.sort_unstable();
        rest.retain(|k| taken.binary_search(k).is_err());
        parts.push((rest, None));
        for (triangles, described) in parts {
            for triangles in connected(self.t, &triangles, |_, _| true) {
                let region = self.most_common_region(&triangles);
                let mut piece = match &described {
                    Some((surface, primitive)) => Piece::on(self.t, triangles, surface.clone(), *primitive, region),
                    None => Piece::free(self.t, triangles, region),
                };
                piece.id = self.new_id();
                let number = self.pieces.len() as u32;
                piece.triangles.iter().for_each(|&k| self.label[k as usize] = number);
                self.pieces.push(piece);
            }
        }
    }

    fn most_common_region(&self, triangles: &[u32]) -> u32 {
        let mut regions: Vec<u32> =
            triangles.iter().map(|&k| self.pieces[self.label[k as usize] as usize].region).collect();
        regions.sort_unstable();
        let most = regions.chunk_by(|a, b| a == b).max_by(|a, b| a.len().cmp(&b.len()).then(b[0].cmp(&a[0])));
        most.map_or(NONE, |r| r[0])
    }

    /// Takes back a tolerance that was for surfaces which did not fit, where others do.
    pub fn tighten(&mut self) {
        let worst = self.pieces.iter().map(|p| p.max).fold(0.0, f64::max);
        self.tolerance = self.tolerance.min(f64::max(2.0 * worst, FILE_PRECISION * self.diagonal));
    }

    /// The labels of the neighbours of triangles, ascending, each once; their own ones where they are neighbours of each other.
    pub fn labels_beside(&self, triangles: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let corners = triangles.into_iter().flat_map(|k| 3 * k..3 * k + 3);
        let beyond = corners.map(|c| self.t.opposite(c)).filter(|&o| o != NONE);
        let mut found: Vec<u32> = beyond.map(|o| self.label[o as usize / 3]).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Makes splines of pieces, whose surfaces are still to be found.
    pub fn loosen(&mut self, which: &[u32]) {
        for &p in which {
            let id = self.new_id();
            let piece = &mut self.pieces[p as usize];
            (piece.id, piece.rung) = (id, Rung::Spline);
        }
    }

    /// Drops pieces without triangles and numbers the others in order.
    pub fn compact(&mut self) {
        let mut number = vec![NONE; self.pieces.len()];
        let mut kept = 0;
        for (n, piece) in number.iter_mut().zip(&self.pieces) {
            if !piece.triangles.is_empty() {
                *n = kept;
                kept += 1;
            }
        }
        self.pieces.retain(|p| !p.triangles.is_empty());
        self.label.iter_mut().for_each(|l| *l = number[*l as usize]);
    }
}

/// Twice the area times the normal of a triangle.
pub fn area_vector(t: Triangles<'_>, k: u32) -> DVec3 {
    let [a, b, c] = t.triangle(k).map(|v| t.points()[v as usize]);
    (b - a).cross(c - a)
}

/// Whether most of the area looks along the surface's normal.
fn looks_along(t: Triangles<'_>, piece: &Piece) -> bool {
    let along = |&k: &u32| {
        let center = t.triangle(k).map(|v| t.points()[v as usize]).iter().sum::<DVec3>() / 3.0;
        let [u, v] = piece.surface.project(center);
        piece.surface.normal(u, v).dot(area_vector(t, k))
    };
    piece.triangles.iter().map(along).sum::<f64>() >= 0.0
}

/// The distinct vertices of triangles, ascending.
pub fn vertex_ids(t: Triangles<'_>, triangles: &[u32]) -> Vec<u32> {
    let mut ids: Vec<u32> = triangles.iter().flat_map(|&k| t.triangle(k)).collect();
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// Which vertices are inside of one piece: on the border of noisy data they lie on some neighbour, or between both.
pub fn inner_vertices(t: Triangles<'_>, label: &[u32]) -> Vec<bool> {
    let mut of = vec![NONE; t.points().len()];
    let mut inner = vec![true; t.points().len()];
    for (k, &l) in (0u32..).zip(label) {
        for v in t.triangle(k) {
            let first = std::mem::replace(&mut of[v as usize], l);
            inner[v as usize] &= first == NONE || first == l;
        }
    }
    inner
}

/// Their places.
pub fn vertices(t: Triangles<'_>, triangles: &[u32]) -> Vec<DVec3> {
    vertex_ids(t, triangles).into_iter().map(|v| t.points()[v as usize]).collect()
}

/// Parts of triangles that are connected by neighbours which belong together, each ascending, in the order of their first ones; the
/// triangles are ascending.
pub fn connected(t: Triangles<'_>, triangles: &[u32], together: impl Fn(u32, u32) -> bool) -> Vec<Vec<u32>> {
    let mut sets = DisjointSets::new(triangles.len());
    for (at, &k) in (0u32..).zip(triangles) {
        for o in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
            if let Ok(other) = triangles.binary_search(&(o / 3))
                && together(k, o / 3)
            {
                sets.union(at, other as u32);
            }
        }
    }
    let (of, count) = sets.labels();
    let mut parts = vec![Vec::new(); count];
    of.iter().zip(triangles).for_each(|(&part, &k)| parts[part as usize].push(k));
    parts
}
