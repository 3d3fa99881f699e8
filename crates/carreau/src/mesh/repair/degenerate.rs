//! Step 2: faces without area go, and the surface stays closed.
//!
//! First every face loses its repeated corners. Then triangles without area go in one of three ways, the first that
//! applies; only the last can open the surface, and only where nothing else was attached:
//!
//! ```text
//! flip (a cap: c lies on ab)         collapse (a needle: a and b are close)
//!
//!       c                                    b
//!   a ──•── b        a ──•── b               │╲
//!    ╲     ╱    →     ╲  │  ╱                │  ╲ c    →    a ─── c
//!     ╲   ╱            ╲ │ ╱                 │  ╱
//!       d                d                   a╱
//! ```
//!
//! drop: what is left, such as a cap on a border.
//!
//! A triangle counts as without area only if it is flat in itself as well: tiny triangles of good shape are details of
//! a large model and stay.

use super::soup::Soup;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::area::{safe_length, triangle_area_vector};
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::half_edges::HalfEdges;
use crate::mesh::polygons::Polygons;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::topology::DEGENERATE_AREA;
use glam::DVec3;
use rayon::prelude::*;

/// Below this mean ratio a triangle is flat (1: equilateral).
const FLAT_RATIO: f64 = 1e-4;
/// Times [`FLAT_RATIO`]: from this mean ratio on no rounding can make a triangle flat.
const CLEARLY: f64 = 2.0;
/// Sums of squared edge lengths, in square units of the file, whose own squares neither vanish nor overflow.
const ORDINARY: std::ops::Range<f64> = 1e-100..1e100;
/// A needle has an edge shorter than this share of its longest.
const NEEDLE: f64 = 1e-3;
/// Rounds of flips and collapses; a long row of caps takes one round each in the worst order.
const FLAT_ROUNDS: usize = 64;

/// What was done about degenerate faces.
#[derive(Default)]
pub struct Removed {
    pub collapsed_faces: usize,
    pub flipped_edges: usize,
    pub merged_vertices: usize,
    pub dropped_faces: usize,
}

/// Removes faces without area.
pub fn remove(soup: &mut Soup, diagonal: f64, context: &Context) -> Result<Removed> {
    let mut done = Removed { collapsed_faces: remove_repeats(soup), ..Removed::default() };
    for _ in 0..FLAT_ROUNDS {
        context.check()?;
        let flat = flat_faces(soup, diagonal);
        if flat.is_empty() {
            return Ok(done);
        }
        let flipped = flip_caps(soup, &flat, diagonal);
        let merged = if flipped == 0 { collapse_needles(soup, &flat) } else { 0 };
        done.flipped_edges += flipped;
        done.merged_vertices += merged;
        if flipped + merged == 0 {
            break;
        }
        done.collapsed_faces += if merged > 0 { remove_repeats(soup) } else { 0 };
    }
    let mut drop = vec![false; soup.faces.len()];
    flat_faces(soup, diagonal).into_iter().for_each(|f| drop[f as usize] = true);
    done.dropped_faces = soup.keep_faces(|f| !drop[f]);
    Ok(done)
}

/// Divides every face that uses a vertex twice there, and keeps the parts with at least three corners. Returns how many
/// faces were concerned.
///
/// ```text
/// a b b c        →  a b c
/// a b c a d e    →  a b c, a d e
/// a b a          →  nothing
/// ```
fn remove_repeats(soup: &mut Soup) -> usize {
    let repeats = soup.faces_with_repeats();
    let count = repeats.iter().filter(|&&r| r).count();
    if count == 0 {
        return 0;
    }
    let mut open: Vec<u32> = Vec::new();
    soup.rewrite_faces(|f, face, out| {
        open.clear();
        for k in 0..face.len() as u32 {
            if repeats[f]
                && let Some(at) = open.iter().position(|&o| face[o as usize] == face[k as usize])
            {
                if open.len() - at >= 3 {
                    out(&open[at..]);
                }
                open.truncate(at);
            }
            open.push(k);
        }
        if open.len() >= 3 {
            out(&open);
        }
    });
    count
}

/// Whether a triangle has no area: below the share of the squared diagonal, and flat in itself.
///
/// In units of its longest edge, so that a model too small for the squares of its lengths is not taken for flat.
fn is_flat(p: [DVec3; 3], diagonal: f64) -> bool {
    // Most triangles are far from flat, and of a size whose squares say so.
    let (u, v) = (p[1] - p[0], p[2] - p[0]);
    let squares = u.length_squared() + v.length_squared() + (v - u).length_squared();
    let bound = CLEARLY * FLAT_RATIO * squares;
    if ORDINARY.contains(&squares) && 12.0 * u.cross(v).length_squared() > bound * bound {
        return false;
    }
    let l = edge_lengths(p);
    let longest = l[0].max(l[1]).max(l[2]);
    if longest == 0.0 {
        return true;
    }
    let [a, b, c] = p.map(|q| (q - p[0]) / longest);
    let area = triangle_area_vector(a, b, c).length();
    let squares: f64 = l.iter().map(|x| (x / longest) * (x / longest)).sum();
    area * (longest / diagonal) * (longest / diagonal) <= DEGENERATE_AREA
        && 4.0 * 3f64.sqrt() * area / squares < FLAT_RATIO
}

/// Lengths of the edges that leave each corner.
fn edge_lengths(p: [DVec3; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| safe_length(p[(k + 1) % 3] - p[k]))
}

/// Whether a face has no area: all triangles of its fan.
pub fn is_flat_face(points: &[DVec3], face: &[u32], diagonal: f64) -> bool {
    let fan = |k: usize| [face[0], face[k], face[k + 1]].map(|v| points[v as usize]);
    (1..face.len() - 1).all(|k| is_flat(fan(k), diagonal))
}

fn flat_faces(soup: &Soup, diagonal: f64) -> Vec<u32> {
    let flat = |f: u32| is_flat_face(&soup.points, soup.faces.face(f as usize), diagonal);
    (0..soup.faces.len() as u32).filter(|&f| flat(f)).collect()
}

/// The faces without area, and those that use a vertex twice.
pub fn found(soup: &Soup, diagonal: f64) -> Vec<u32> {
    let repeats = soup.faces_with_repeats();
    let flat = |f: u32| repeats[f as usize] || is_flat_face(&soup.points, soup.faces.face(f as usize), diagonal);
    (0..soup.faces.len() as u32).filter(|&f| flat(f)).collect()
}

/// Whether a mesh has faces without area.
pub fn any(mesh: &SurfaceMesh) -> bool {
    let diagonal = mesh.diagonal();
    let flat = |f: usize| is_flat_face(mesh.points(), mesh.faces().face(f), diagonal);
    (0..mesh.face_count()).into_par_iter().with_min_len(4096).any(flat)
}

/// Flips the longest edge of every cap whose neighbour across is a triangle, where that leaves fewer flat triangles.
/// Returns how many edges were flipped.
fn flip_caps(soup: &mut Soup, flat: &[u32], diagonal: f64) -> usize {
    let near = Neighbourhood::of(soup, flat);
    let mut touched = vec![false; soup.points.len()];
    let mut flips = 0;
    for &f in flat {
        let Some(flip) = near.flip_of(soup, f, diagonal) else { continue };
        // Two flips at one vertex could make the same edge: the second waits for the next round.
        if flip.vertices.iter().any(|&v| touched[v as usize]) {
            continue;
        }
        flip.vertices.iter().for_each(|&v| touched[v as usize] = true);
        for [corner, with] in flip.replace {
            soup.faces.corners_mut()[corner as usize] = soup.faces.corners()[with as usize];
        }
        let [first, second] = flip.replace;
        let sources = [first, second].map(|[_, with]| soup.corner_source[with as usize]);
        soup.corner_source[first[0] as usize] = sources[0];
        soup.corner_source[second[0] as usize] = sources[1];
        flips += 1;
    }
    flips
}

/// Merges the ends of the shortest edge of every needle into the end with the smaller id. Returns how many vertices went.
fn collapse_needles(soup: &mut Soup, flat: &[u32]) -> usize {
    let mut sets = DisjointSets::new(soup.points.len());
    for &f in flat {
        let &[a, b, c] = soup.faces.face(f as usize) else { continue };
        let v = [a, b, c];
        let l = edge_lengths(v.map(|v| soup.points[v as usize]));
        let shortest = if l[0] <= l[1] && l[0] <= l[2] { 0 } else { 1 + usize::from(l[2] < l[1]) };
        if l[shortest] <= NEEDLE * l[0].max(l[1]).max(l[2]) {
            sets.union(v[shortest], v[(shortest + 1) % 3]);
        }
    }
    soup.merge_vertices(&sets.leaders())
}

/// The faces at the vertices of the flat ones, with their half-edges.
struct Neighbourhood {
    half_edges: HalfEdges,
    /// Corner in the whole mesh of every corner in the part.
    corner: Vec<u32>,
    face_of: Vec<u32>,
}

/// A flip: two corners take over the vertex of two others; the vertices involved.
struct Flip {
    replace: [[u32; 2]; 2],
    vertices: [u32; 4],
}

impl Neighbourhood {
    fn of(soup: &Soup, flat: &[u32]) -> Self {
        let mut at_flat = vec![false; soup.points.len()];
        for &f in flat {
            soup.faces.face(f as usize).iter().for_each(|&v| at_flat[v as usize] = true);
        }
        let (mut part, mut corner, mut face_of) = (Polygons::new(), Vec::new(), Vec::new());
        for (f, face) in soup.faces.iter().enumerate() {
            if face.iter().any(|&v| at_flat[v as usize]) {
                part.push(face);
                let first = soup.faces.offsets()[f];
                corner.extend(first..first + face.len() as u32);
                face_of.extend(face.iter().map(|_| f as u32));
            }
        }
        Neighbourhood { half_edges: HalfEdges::new(&part, soup.points.len()), corner, face_of }
    }

    /// The flip of a cap's longest edge, if it may be done and helps.
    fn flip_of(&self, soup: &Soup, f: u32, diagonal: f64) -> Option<Flip> {
        let (faces, points) = (&soup.faces, &soup.points);
        let first = faces.offsets()[f as usize];
        let &[x, y, z] = faces.face(f as usize) else { return None };
        let v = [x, y, z];
        let l = edge_lengths(v.map(|v| points[v as usize]));
        let k = if l[0] >= l[1] && l[0] >= l[2] { 0 } else { 1 + usize::from(l[2] > l[1]) };
        let [a, b, c] = [v[k], v[(k + 1) % 3], v[(k + 2) % 3]];
        if l[(k + 1) % 3].min(l[(k + 2) % 3]) <= NEEDLE * l[k] {
            return None;
        }
        let edge = self.half_edges.find(a, b).filter(|edge| edge.len() == 2)?;
        let across = edge.corners().find(|&c| self.face_of[c as usize] != f)?;
        let neighbour = self.face_of[across as usize] as usize;
        let &[p, q, r] = faces.face(neighbour) else { return None };
        let start = faces.offsets()[neighbour];
        let corner_of = |wanted: u32| [p, q, r].iter().position(|&v| v == wanted).map(|k| start + k as u32);
        let d = [p, q, r].into_iter().find(|&v| v != a && v != b)?;
        if d == c || self.half_edges.find(c, d).is_some() || self.corner.is_empty() {
            return None;
        }
        let flat = |t: [u32; 3]| usize::from(is_flat(t.map(|v| points[v as usize]), diagonal));
        if flat([a, d, c]) + flat([c, d, b]) >= flat([a, b, c]) + flat([a, b, d]) {
            return None;
        }
        // The cap's corner b takes d's vertex, the neighbour's corner a takes c's: both keep their sense.
        let cap = |k: usize| first + (k % 3) as u32;
        Some(Flip { replace: [[cap(k + 1), corner_of(d)?], [corner_of(a)?, cap(k + 2)]], vertices: [a, b, c, d] })
    }
}
