//! Points of the scan and their feet on the surface.
//!
//! A foot is sought where the surface looks the way that the scan does, so that thin parts do not take the points of their other
//! side. The surface has points of its own as well, in the middle of each part, which are drawn to the scan: where no vertex has a
//! foot, as inside the facets of a coarse scan and where the surface hangs over, nothing else tells where it belongs.

use super::limit::Limit;
use super::net::{Net, next, previous};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::{face_normals, vertex_normals};
use crate::geometry::search_tree::{Closest, TriangleTree};
use crate::mesh::SurfaceMesh;
use glam::DVec3;
use rayon::prelude::*;

/// A point of the scan with its foot.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Where it is.
    pub point: DVec3,
    /// The way the scan looks there.
    pub normal: DVec3,
    /// What it counts, for 1 of a vertex.
    pub weight: f64,
    /// The part of the surface with its foot.
    pub part: u32,
    /// Its place there.
    pub at: [f64; 2],
}

/// Weight of a point of the surface, for 1 of a vertex: small, because the facets that it is drawn to cut off what is round.
const OWN_WEIGHT: f64 = 0.03;
/// A count: most vertices that are fitted, because time grows with them.
const FIT_SAMPLES: usize = 120_000;
/// A count: steps of the search for a foot, few because it starts at the nearest of many points on the surface.
const FOOT_STEPS: usize = 4;
/// A count: divisions of the side of a part into the triangles among which feet are looked for, two because the search
/// for a foot only has to start near it.
const CELLS_A_SIDE: usize = 2;
/// In lengths of the sides of quads: what looks the right way is preferred if it is at most this much farther, because before the
/// surface is fitted it is off by about as much.
const REACH: f64 = 2.0;

/// Of every vertex whether it has a face.
pub fn used(mesh: &SurfaceMesh) -> Vec<bool> {
    let mut used = vec![false; mesh.vertex_count()];
    mesh.faces().corners().iter().for_each(|&v| used[v as usize] = true);
    used
}

/// The scan as what surfaces are fitted to.
pub struct Scan {
    tree: TriangleTree,
    normals: Vec<DVec3>,
    vertices: Vec<Sample>,
}

impl Scan {
    /// Of triangles.
    pub fn new(mesh: &SurfaceMesh) -> Self {
        let triangles: Vec<[u32; 3]> = mesh.faces().iter().filter_map(|f| f.try_into().ok()).collect();
        let normals = face_normals(mesh);
        let of_vertices = vertex_normals(mesh, &normals);
        let sample = |(&point, normal)| Sample { point, normal, weight: 1.0, part: 0, at: [0.0; 2] };
        let vertices = mesh.points().iter().zip(of_vertices).map(sample).collect();
        Scan { tree: TriangleTree::new(mesh.points(), &triangles), normals, vertices }
    }

    /// All vertices.
    pub fn vertices(&self) -> Vec<Sample> {
        self.vertices.clone()
    }

    /// The vertices that are fitted.
    pub fn fitted(&self, mesh: &SurfaceMesh) -> Vec<Sample> {
        let step = mesh.vertex_count().div_ceil(FIT_SAMPLES).max(1);
        self.vertices.iter().zip(used(mesh)).filter(|v| v.1).step_by(step).map(|v| *v.0).collect()
    }

    /// The middle of a part as a sample at what is nearest of the scan that looks the same way; none where that is not near. Besides
    /// whether what is nearest of all looks the other way: then the surface is turned over there.
    fn own(&self, part: u32, surface: &Limit<'_, DVec3>, reach: f64) -> (Option<Sample>, bool) {
        let at = [0.5; 2];
        let [point, u, v] = surface.piece(part, at).tangents(at);
        let normal = u.cross(v);
        let looks_so = |c: &Closest| self.normals[c.triangle as usize].dot(normal) > 0.0;
        let nearest = self.tree.closest(point);
        let (found, is_turned) = match nearest.filter(|c| c.distance() <= reach) {
            Some(near) if looks_so(&near) => (Some(near), false),
            near => {
                let same_way = self.tree.cheapest(point, reach, |c: &Closest| looks_so(c).then(|| c.distance()));
                (same_way.map(|c| c.1), near.is_some())
            }
        };
        (found.map(|near| Sample { point: near.point, normal, weight: OWN_WEIGHT, part, at }), is_turned)
    }
}

/// The samples that the middles of the parts are, on the scan, and the parts where the surface is turned over.
pub fn own(
    net: &Net,
    surface: &Limit<'_, DVec3>,
    points: &[DVec3],
    scan: &Scan,
    context: &Context,
) -> Result<(Vec<Sample>, Vec<u32>)> {
    let reach = REACH * side(net, points);
    let one = |part: usize| {
        context.check_every(part)?;
        Ok(scan.own(part as u32, surface, reach))
    };
    let all: Vec<(Option<Sample>, bool)> =
        context.install(|| (0..net.edge.len()).into_par_iter().map(one).collect::<Result<_>>())?;
    let turned = (0u32..).zip(&all).filter(|(_, of)| of.1).map(|(part, _)| part).collect();
    Ok((all.into_iter().filter_map(|of| of.0).collect(), turned))
}

/// The mean length of an edge.
fn side(net: &Net, points: &[DVec3]) -> f64 {
    let length = |[a, b]: &[u32; 2]| points[*a as usize].distance(points[*b as usize]);
    net.ends.iter().map(length).sum::<f64>() / net.ends.len().max(1) as f64
}

/// Triangles on the surface, among which feet are looked for.
struct Facets {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    normals: Vec<DVec3>,
    tree: TriangleTree,
}

impl Facets {
    /// Of a surface: `point_at` a place of a part.
    fn new(parts: usize, point_at: impl Fn(u32, [f64; 2]) -> DVec3, context: &Context) -> Result<Self> {
        let per = CELLS_A_SIDE + 1;
        let mut points = Vec::with_capacity(parts * per * per);
        let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(parts * 2 * CELLS_A_SIDE * CELLS_A_SIDE);
        for part in 0..parts as u32 {
            context.check_every(part as usize)?;
            let first = points.len() as u32;
            points.extend((0..per * per).map(|k| point_at(part, Self::place(k))));
            for k in 0..CELLS_A_SIDE * CELLS_A_SIDE {
                let a = first + (k / CELLS_A_SIDE * per + k % CELLS_A_SIDE) as u32;
                let [b, c, d] = [a + 1, a + 1 + per as u32, a + per as u32];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let tree = TriangleTree::new(&points, &triangles);
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            (b - a).cross(c - a)
        };
        let normals = triangles.iter().map(normal).collect();
        Ok(Facets { points, triangles, normals, tree })
    }

    /// The place of a point in its part.
    fn place(point: usize) -> [f64; 2] {
        let per = CELLS_A_SIDE + 1;
        let k = point % (per * per);
        [k % per, k / per].map(|x| x as f64 / CELLS_A_SIDE as f64)
    }

    /// The part and the place of what is nearest, those that look the wrong way being farther by `reach`.
    fn foot(&self, sample: &Sample, reach: f64) -> Option<(u32, [f64; 2])> {
        let cost = |c: &Closest| {
            let turned = self.normals[c.triangle as usize].dot(sample.normal) < 0.0;
            Some(c.distance() + if turned { reach } else { 0.0 })
        };
        let (_, near) = self.tree.cheapest(sample.point, f64::INFINITY, cost)?;
        let corners = self.triangles[near.triangle as usize].map(|v| v as usize);
        let weights = barycentric(near.point, corners.map(|v| self.points[v]));
        let at = weights.into_iter().zip(corners.map(Self::place));
        let at = at.fold([0.0; 2], |at, (w, p)| [at[0] + w * p[0], at[1] + w * p[1]]);
        Some((near.triangle / (2 * CELLS_A_SIDE * CELLS_A_SIDE) as u32, at))
    }
}

/// Gives every sample its foot on the quads themselves: their vertices are on the scan, while the surface that has them as control
/// points would be far inside of it.
pub fn find_first_feet(samples: &mut [Sample], net: &Net, points: &[DVec3], context: &Context) -> Result<()> {
    let point_at = |part: u32, at: [f64; 2]| {
        let [a, b] = [part, previous(part)].map(|h| points[net.start(h) as usize]);
        let [d, c] = [next(part), next(next(part))].map(|h| points[net.start(h) as usize]);
        let [x, y] = at.map(|t| 0.5 * t);
        a.lerp(d, x).lerp(b.lerp(c, x), y)
    };
    let facets = Facets::new(net.edge.len(), point_at, context)?;
    let reach = REACH * side(net, points);
    for (k, sample) in samples.iter_mut().enumerate() {
        context.check_every(k)?;
        if let Some(foot) = facets.foot(sample, reach) {
            (sample.part, sample.at) = foot;
        }
    }
    Ok(())
}

/// Gives every sample its foot on a surface. Returns the largest and the root mean square distance.
pub fn find_feet(
    samples: &mut [Sample],
    surface: &Limit<'_, DVec3>,
    net: &Net,
    points: &[DVec3],
    context: &Context,
) -> Result<[f64; 2]> {
    let point_at = |part: u32, at: [f64; 2]| match surface.apex(part) {
        Some(&apex) if at == [0.0; 2] => apex,
        _ => surface.piece(part, at).point(at),
    };
    let facets = Facets::new(net.edge.len(), point_at, context)?;
    let reach = REACH * side(net, points);
    let one = |(k, sample): (usize, &mut Sample)| -> Result<f64> {
        context.check_every(k)?;
        let Some(foot) = facets.foot(sample, reach) else { return Ok(0.0) };
        (sample.part, sample.at) = foot;
        Ok(approach(sample, surface))
    };
    let far: Vec<f64> = context.install(|| samples.par_iter_mut().enumerate().map(one).collect::<Result<_>>())?;
    let count = far.len().max(1) as f64;
    Ok([far.iter().copied().fold(0.0, f64::max), (far.iter().map(|d| d * d).sum::<f64>() / count).sqrt()])
}

/// Newton steps to the foot within the part. Returns the distance.
fn approach(sample: &mut Sample, surface: &Limit<'_, DVec3>) -> f64 {
    let mut best = surface.piece(sample.part, sample.at).point(sample.at).distance(sample.point);
    for _ in 0..FOOT_STEPS {
        let piece = surface.piece(sample.part, sample.at);
        let [point, su, sv] = piece.tangents(sample.at);
        let r = point - sample.point;
        let (e, f, g) = (su.dot(su), su.dot(sv), sv.dot(sv));
        let (a, b) = (r.dot(su), r.dot(sv));
        let d = e * g - f * f;
        if !(d > 1e-12 * e * g) {
            break;
        }
        let step = [(f * b - g * a) / d, (f * a - e * b) / d];
        let at = [0, 1].map(|k| (sample.at[k] + piece.size * step[k]).clamp(0.0, 1.0));
        let next = surface.piece(sample.part, at).point(at).distance(sample.point);
        if !(next < best) {
            break;
        }
        (sample.at, best) = (at, next);
    }
    best
}

fn barycentric(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let v = (p - a).cross(c - a).dot(normal) / square;
    let w = (b - a).cross(p - a).dot(normal) / square;
    [1.0 - v - w, v, w]
}
