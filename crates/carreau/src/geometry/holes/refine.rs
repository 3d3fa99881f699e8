//! Triangles of the size of those around: centres are added where a triangle is large, edges flipped until they are Delaunay.
//!
//! ```text
//!     c             c               c            c
//!    ╱ ╲           ╱│╲             ╱ ╲          ╱│╲
//!   ╱   ╲    →    ╱ m ╲           a───b    →   a │ b     where the angles at c and d add up to more than 180°
//!  a─────b       a─────b           ╲ ╱          ╲│╱
//!                                   d            d
//! ```

use super::patch::Patch;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::SurfaceMesh;
use glam::DVec3;
use rustc_hash::FxHashMap;

/// A centre is added where it is farther from every corner than the lengths there, divided by this.
const DENSITY: f64 = std::f64::consts::SQRT_2;
/// Vertices that are added at most, for each border vertex squared: a disc needs about a twelfth.
const MOST_ADDED: usize = 2;
/// Rounds of centres and flips.
const REFINING_ROUNDS: usize = 64;
/// Flips in a row at most, for each edge: they end by themselves but for rounding.
const FLIPS: usize = 64;

/// Refines a patch on a ring of vertices; its own vertices are numbered from `first` on.
pub fn refine(patch: &mut Patch, mesh: &SurfaceMesh, ring: &[u32], first: u32, context: &Context) -> Result<()> {
    let n = ring.len();
    // The length wanted at every vertex: the mean of the border edges there, averaged along the border.
    let point = |k: usize| mesh.points()[ring[k % n] as usize];
    let mut length: FxHashMap<u32, f64> = FxHashMap::default();
    for k in 0..n {
        let edges = [point(k).distance(point(k + 1)), point(k).distance(point(k + n - 1))];
        length.insert(ring[k], 0.5 * (edges[0] + edges[1]));
    }
    let most = (MOST_ADDED * n * n).min(1_000_000);
    flip(patch, mesh, first, context)?;
    for _ in 0..REFINING_ROUNDS {
        let before = patch.points.len();
        for t in 0..patch.triangles.len() {
            context.check_every(t)?;
            let corners = patch.triangles[t];
            let at = corners.map(|v| place(patch, mesh, first, v));
            let lengths = corners.map(|v| length.get(&v).copied().unwrap_or(f64::INFINITY));
            let (centre, wanted) = ((at[0] + at[1] + at[2]) / 3.0, lengths.iter().sum::<f64>() / 3.0);
            let is_far = |k: usize| DENSITY * centre.distance(at[k]) > wanted.max(lengths[k]);
            if !(0..3).all(is_far) || patch.points.len() >= most {
                continue;
            }
            let m = first + patch.points.len() as u32;
            patch.points.push(centre);
            length.insert(m, wanted);
            let [a, b, c] = corners;
            patch.triangles[t] = [a, b, m];
            patch.triangles.extend([[b, c, m], [c, a, m]]);
        }
        flip(patch, mesh, first, context)?;
        if patch.points.len() == before {
            break;
        }
    }
    Ok(())
}

/// Where a vertex of the patch or of the mesh is.
pub fn place(patch: &Patch, mesh: &SurfaceMesh, first: u32, v: u32) -> DVec3 {
    if v >= first { patch.points[(v - first) as usize] } else { mesh.points()[v as usize] }
}

/// The triangles at every edge of the patch.
struct Edges(FxHashMap<[u32; 2], [u32; 2]>);

/// No triangle.
const NONE: u32 = u32::MAX;

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Edges {
    fn of(triangles: &[[u32; 3]]) -> Self {
        let mut edges = Edges(FxHashMap::default());
        for (t, corners) in (0u32..).zip(triangles) {
            (0..3).for_each(|k| edges.add(key(corners[k], corners[(k + 1) % 3]), t));
        }
        edges
    }

    fn add(&mut self, edge: [u32; 2], t: u32) {
        let pair = self.0.entry(edge).or_insert([NONE, NONE]);
        if pair[0] == NONE { pair[0] = t } else { pair[1] = t }
    }

    fn replace(&mut self, edge: [u32; 2], old: u32, new: u32) {
        if let Some(place) = self.0.get_mut(&edge).and_then(|pair| pair.iter_mut().find(|t| **t == old)) {
            *place = new;
        }
    }
}

/// Flips inner edges of the patch until all are Delaunay.
fn flip(patch: &mut Patch, mesh: &SurfaceMesh, first: u32, context: &Context) -> Result<()> {
    let mut edges = Edges::of(&patch.triangles);
    let half_edges = mesh.half_edges();
    let exists = |a: u32, b: u32| a < first && b < first && half_edges.find(a, b).is_some();
    let mut waiting: Vec<[u32; 2]> =
        patch.triangles.iter().flat_map(|t| [key(t[0], t[1]), key(t[1], t[2]), key(t[2], t[0])]).collect();
    waiting.sort_unstable();
    waiting.dedup();
    waiting.reverse();
    let most = FLIPS * waiting.len();
    let mut step = 0;
    while let Some(edge) = waiting.pop() {
        step += 1;
        context.check_every(step)?;
        if step > most {
            break;
        }
        let Some(&[s, t]) = edges.0.get(&edge).filter(|pair| pair[1] != NONE) else { continue };
        let (Some([a, b, c]), Some([_, _, d])) =
            (from_edge(patch.triangles[s as usize], edge), from_edge(patch.triangles[t as usize], edge))
        else {
            continue;
        };
        let [pa, pb, pc, pd] = [a, b, c, d].map(|v| place(patch, mesh, first, v));
        let turned = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p);
        let angle = |at: DVec3| (pa - at).angle_between(pb - at);
        let is_flat_turn = turned(pa, pd, pc).dot(turned(pd, pb, pc)) > 0.0;
        if !(angle(pc) + angle(pd) > std::f64::consts::PI + 1e-9) || !is_flat_turn {
            continue;
        }
        if c == d || exists(c, d) || edges.0.contains_key(&key(c, d)) {
            continue;
        }
        // a b c and b a d become a d c and d b c.
        (patch.triangles[s as usize], patch.triangles[t as usize]) = ([a, d, c], [d, b, c]);
        edges.0.remove(&edge);
        edges.add(key(c, d), s);
        edges.add(key(c, d), t);
        edges.replace(key(a, d), t, s);
        edges.replace(key(b, c), s, t);
        waiting.extend([key(a, d), key(d, b), key(b, c), key(c, a)]);
    }
    Ok(())
}

/// A triangle turned so that it begins with an edge.
fn from_edge(t: [u32; 3], edge: [u32; 2]) -> Option<[u32; 3]> {
    (0..3).map(|k| [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]).find(|t| key(t[0], t[1]) == edge)
}
