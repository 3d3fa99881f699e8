//! The model against the mesh: distances both ways, normals, volume.
//!
//! ```text
//!      ___----●----___     face
//!     ●───────┬───────●    facet: its corners are on the face, its middle is not
//!             sagitta ≈ κ l² / 8
//! ```
//!
//! What facets legitimately cut off is allowed besides the limit: the sagitta of a facet, from its longest side and the
//! curvature of the face there, and of the chords along a curved border. Where surfaces touch, a border of the mesh may be
//! rows of triangles away from the edge, so that a face may also be near triangles of other regions that face its way, and a
//! vertex near any face that does.

use super::region::{Region, fan, regions};
use super::{Fault, Finding, Limits, Reference, middle};
use crate::brep::tessellate::Tessellation;
use crate::brep::{Brep, Curve, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::search_tree::TriangleTree;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::cell::OnceCell;

/// How many times deeper than its facets say a surface that swings may be: what they say is exact where they are even.
const DEEPER: f64 = 2.0;

/// What was measured of one face.
#[derive(Debug, Clone, Copy, Default)]
struct Measured {
    /// The worst, and where.
    back: (f64, f64, DVec3),
    area: f64,
    turned: f64,
    turned_at: DVec3,
    /// The volume that facets may cut off.
    cut_off: f64,
    /// The signed volume between the face and its region.
    between: f64,
}

/// Compares every region with its faces.
pub(super) fn compare(
    brep: &Brep,
    tessellation: &Tessellation,
    reference: &Reference,
    limits: &Limits,
    chord: f64,
    context: &Context,
) -> Result<Vec<Finding>> {
    let regions = regions(brep, reference);
    let fans = || reference.mesh.faces().iter().flat_map(fan).collect();
    let everywhere = Everywhere::new(reference.mesh.points(), fans);
    let model = Everywhere::new(&tessellation.points, || tessellation.triangles.clone());
    let faces_of = triangles_by_face(brep.faces.len(), tessellation);
    let mut out = Vec::new();
    let mut cut_off = 0.0;
    // The face that most of a difference of volumes is at, and how much beyond its bound.
    let mut blamed = (f64::NEG_INFINITY, None);
    let points = reference.mesh.points();
    let (mut apart, means) = to_model(points, &regions, &faces_of, tessellation, context)?;
    let most = limits.distance + chord;
    for (v, normal) in far_vertices(reference, &apart, most) {
        let d = &mut apart[v as usize];
        *d = d.min(model.distance(points[v as usize], normal, most, limits.angle));
    }
    for (r, region) in regions.iter().enumerate().filter(|(_, r)| !r.triangles.is_empty()) {
        context.check()?;
        let first = points[region.triangles[0][0] as usize];
        let Some(mean) = means[r] else {
            out.push(Finding::new(Fault::MissingFace, r as f64, 0.0, first));
            continue;
        };
        let vertices = || region.triangles.iter().flatten().map(|&v| v as usize);
        let worst = vertices().max_by(|&v, &w| apart[v].total_cmp(&apart[w])).unwrap_or_default();
        if apart[worst] > most {
            let finding = Finding::new(Fault::MeshOffFace, apart[worst], most, points[worst]);
            out.push(finding.of_face(region.faces[0]));
        }
        let tree = TriangleTree::new(points, &region.triangles);
        for &f in &region.faces {
            let measured = to_mesh(
                brep,
                f,
                tessellation,
                &faces_of[f as usize],
                points,
                region,
                &tree,
                &everywhere,
                &apart,
                limits,
            );
            let (off, bound, at) = measured.back;
            if off > bound {
                out.push(Finding::new(Fault::FaceOffMesh, off, bound, at).of_face(f));
            }
            let share = measured.turned / measured.area;
            if share > limits.turned_share {
                let finding = Finding::new(Fault::TurnedNormal, share, limits.turned_share, measured.turned_at);
                out.push(finding.of_face(f));
            }
            let allowed = measured.cut_off + 2.0 * mean * measured.area;
            cut_off += allowed;
            if measured.between.abs() - allowed > blamed.0 {
                blamed = (measured.between.abs() - allowed, Some(f));
            }
        }
    }
    out.sort_by_key(|f| (f.fault, f.face));
    let of_volume = volume(brep, tessellation, reference, cut_off, context)?;
    out.extend(of_volume.map(|finding| Finding { face: blamed.1, ..finding }));
    Ok(out)
}

/// Whether a surface may bend between the vertices as it likes: a profile or a spline, no quadric and no torus.
fn swings(surface: &Surface) -> bool {
    matches!(surface, Surface::Spline(_) | Surface::Extrusion { .. } | Surface::Revolution { .. })
}

/// The volume inside the mesh, seen from a point.
fn enclosed(reference: &Reference, about: DVec3) -> f64 {
    let points = reference.mesh.points();
    let cone = |[a, b, c]: [DVec3; 3]| (a - about).dot((b - about).cross(c - about)) / 6.0;
    let faces = reference.mesh.faces().iter();
    faces.map(|face| fan(face).map(|t| cone(t.map(|v| points[v as usize]))).sum::<f64>()).sum()
}

/// Numbers of the triangles of every face.
fn triangles_by_face(faces: usize, tessellation: &Tessellation) -> Vec<Vec<u32>> {
    let mut out = vec![Vec::new(); faces];
    for (&f, k) in tessellation.face_of.iter().zip(0u32..) {
        out[f as usize].push(k);
    }
    out
}

/// The distance of every vertex from the nearest of the faces around it, which is that of a neighbour where a triangle lies across the
/// edge between both; and for every region that has faces the root mean square of the distances of its vertices from these.
///
/// ```text
///        edge of the model
///     ──────╮
///      ╲    │     ╲  a triangle of the upper region with a corner on the side
///       ╲●  │
/// ```
fn to_model(
    points: &[DVec3],
    regions: &[Region],
    faces_of: &[Vec<u32>],
    tessellation: &Tessellation,
    context: &Context,
) -> Result<(Vec<f64>, Vec<Option<f64>>)> {
    let mut apart = vec![f64::INFINITY; points.len()];
    let mut means = Vec::with_capacity(regions.len());
    for region in regions {
        context.check()?;
        let own = region.faces.iter().flat_map(|&f| &faces_of[f as usize]);
        let model: Vec<[u32; 3]> = own.map(|&k| tessellation.triangles[k as usize]).collect();
        if model.is_empty() {
            means.push(None);
            continue;
        }
        let model = TriangleTree::new(&tessellation.points, &model);
        let mut vertices: Vec<u32> = region.triangles.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let far = |v: &u32| model.distance(points[*v as usize]);
        let all: Vec<f64> = context.install(|| vertices.par_iter().map(far).collect());
        let square: f64 = all.iter().map(|d| d * d).sum();
        means.push(Some((square / all.len().max(1) as f64).sqrt()));
        vertices.iter().zip(all).for_each(|(&v, d)| apart[v as usize] = apart[v as usize].min(d));
    }
    Ok((apart, means))
}

/// Middles of a face's triangles against the triangles of its region.
fn to_mesh(
    brep: &Brep,
    f: u32,
    tessellation: &Tessellation,
    own: &[u32],
    points: &[DVec3],
    region: &Region,
    tree: &TriangleTree,
    everywhere: &Everywhere<'_, impl Fn() -> Vec<[u32; 3]>>,
    apart: &[f64],
    limits: &Limits,
) -> Measured {
    let face = &brep.faces[f as usize];
    let surface = brep.surface(face);
    let most_bent = border_curvature(brep, f);
    // Triangles across an edge of the model, with a corner on a face of the other side, cut it off, by no more than the distance of
    // that corner from the surface.
    let across = region.border.iter().filter(|b| apart[b.0 as usize] <= limits.distance);
    let off = across.map(|b| surface.distance(points[b.0 as usize]).min(b.1));
    let across = off.filter(|d| d.is_finite()).fold(0.0, f64::max);
    let sense = if face.same_sense { 1.0 } else { -1.0 };
    let mut out = Measured::default();
    // A quadric or a torus does not swing, so that what the largest of its facets cuts off is allowed everywhere: the facet that a
    // point is nearest to need not be the one under it. A profile may have any bends.
    let swings = swings(surface);
    let mut looks: Vec<Look> = Vec::with_capacity(own.len());
    for (uv, area) in own.iter().map(|&k| middle(tessellation, k as usize)) {
        let p = surface.point(uv.x, uv.y);
        let Some(near) = tree.closest(p) else { continue };
        let ids = region.triangles[near.triangle as usize];
        let corners = ids.map(|v| points[v as usize]);
        let (sagitta, tilt) = bend(surface, uv, corners);
        let sagitta = if swings { sagitta.min(DEEPER * region.depth[near.triangle as usize]) } else { sagitta };
        let longest = ids.iter().map(|v| region.border_at(*v)).fold(0.0, f64::max);
        let at_border = if longest > 0.0 { across } else { 0.0 };
        let border = (most_bent * longest.powi(2) / 8.0).min(0.5 * longest) + at_border;
        let normal = sense * surface.normal(uv.x, uv.y);
        looks.push(Look { p, normal, distance: near.distance(), sagitta, border });
        let facet = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        out.area += area;
        out.cut_off += area * sagitta;
        out.between += area * (p - near.point).dot(normal);
        // Facets may be tilted by what their size and the curvature make of it, too.
        let allowed = limits.angle.max(tilt.min(1.5));
        if facet.length_squared() > 0.0 && normal != DVec3::ZERO && normal.angle_between(facet) > allowed {
            out.turned += area;
            out.turned_at = p;
        }
    }
    let deepest = looks.iter().map(|l| l.sagitta).fold(0.0, f64::max);
    let bound = |l: &Look| limits.distance + 2.0 * if swings { l.sagitta } else { deepest } + l.border;
    for look in &mut looks {
        let most = bound(look);
        if look.distance > most {
            look.distance = look.distance.min(everywhere.distance(look.p, look.normal, most, limits.angle));
        }
    }
    let worst = looks.iter().max_by(|a, b| (a.distance - bound(a)).total_cmp(&(b.distance - bound(b))));
    out.back = worst.map_or(out.back, |l| (l.distance, bound(l), l.p));
    out
}

/// All triangles of the mesh or of the model, in a tree that is built when it is asked for.
struct Everywhere<'a, F> {
    points: &'a [DVec3],
    /// Lists the triangles.
    list: F,
    known: OnceCell<(Vec<[u32; 3]>, TriangleTree)>,
}

impl<'a, F: Fn() -> Vec<[u32; 3]>> Everywhere<'a, F> {
    fn new(points: &'a [DVec3], list: F) -> Self {
        Everywhere { points, list, known: OnceCell::new() }
    }

    /// The distance of a point from the nearest triangle within a radius whose normal is within an angle of a direction; infinite
    /// where there is none.
    fn distance(&self, p: DVec3, normal: DVec3, radius: f64, angle: f64) -> f64 {
        let (triangles, tree) = self.known.get_or_init(|| {
            let triangles = (self.list)();
            let tree = TriangleTree::new(self.points, &triangles);
            (triangles, tree)
        });
        let mut least = f64::INFINITY;
        tree.within(p, radius, |near| {
            let [a, b, c] = triangles[near.triangle as usize].map(|v| self.points[v as usize]);
            let facet = (b - a).cross(c - a);
            if facet.length_squared() > 0.0 && normal != DVec3::ZERO && normal.angle_between(facet) <= angle {
                least = least.min(near.distance());
            }
        });
        least
    }
}

/// Vertices of the mesh that are farther from the faces around them than allowed, with their normals.
fn far_vertices(reference: &Reference, apart: &[f64], most: f64) -> Vec<(u32, DVec3)> {
    let points = reference.mesh.points();
    let is_far = |&v: &u32| apart[v as usize].is_finite() && apart[v as usize] > most;
    let mut found: Vec<(u32, DVec3)> = Vec::new();
    for face in reference.mesh.faces().iter() {
        let [a, b, c] = [face[0], face[1], face[2]].map(|v| points[v as usize]);
        found.extend(face.iter().filter(|v| is_far(v)).map(|&v| (v, (b - a).cross(c - a))));
    }
    found.sort_by_key(|f| f.0);
    found.chunk_by(|a, b| a.0 == b.0).map(|of| (of[0].0, of.iter().map(|f| f.1).sum())).collect()
}

/// A point of a face over its region.
struct Look {
    p: DVec3,
    normal: DVec3,
    distance: f64,
    sagitta: f64,
    border: f64,
}

/// How far a facet may be from a surface over it, from the second fundamental form along its sides, and how much it may be tilted.
///
/// A side e lies |II(e, e)| / 8 deep under the surface, and its ends' normals differ by |II(e, e)| / |e|. No facet is farther from
/// a round surface than its own size.
fn bend(surface: &Surface, uv: DVec2, corners: [DVec3; 3]) -> (f64, f64) {
    let jet = surface.jet(uv.x, uv.y);
    let normal = surface.normal(uv.x, uv.y);
    let [su, sv] = jet.first;
    let (e, f, g) = (su.dot(su), su.dot(sv), sv.dot(sv));
    let form = jet.second.map(|d| d.dot(normal));
    let (mut sagitta, mut tilt) = (0.0f64, 0.0f64);
    for k in 0..3 {
        let side = corners[(k + 1) % 3] - corners[k];
        let (p, q) = (side.dot(su), side.dot(sv));
        let area = e * g - f * f;
        let (a, b) = ((g * p - f * q) / area, (e * q - f * p) / area);
        let second = (form[0] * a * a + 2.0 * form[1] * a * b + form[2] * b * b).abs();
        let size = side.length();
        let second = if second.is_finite() { second } else { 4.0 * size };
        sagitta = sagitta.max((second / 8.0).min(0.5 * size));
        tilt = tilt.max(if size > 0.0 { second / size } else { 0.0 });
    }
    (sagitta, tilt)
}

/// The largest curvature of the edges of a face.
fn border_curvature(brep: &Brep, f: u32) -> f64 {
    let bend = |edge: u32| {
        let edge = &brep.edges[edge as usize];
        if let Curve::Line { .. } = edge.curve {
            return 0.0;
        }
        let at = |k: u32| {
            let [_, d, dd] = edge.curve.derivatives(edge.parameter_at((f64::from(k) + 0.5) / 8.0));
            d.cross(dd).length() / d.length().powi(3)
        };
        (0..8).map(at).filter(|k| k.is_finite()).fold(0.0, f64::max)
    };
    brep.faces[f as usize].uses().map(|of| bend(of.edge)).fold(0.0, f64::max)
}

/// The volumes of closed models.
fn volume(
    brep: &Brep,
    tessellation: &Tessellation,
    reference: &Reference,
    cut_off: f64,
    context: &Context,
) -> Result<Option<Finding>> {
    if brep.solids.is_empty() || !brep.free_shells().is_empty() {
        return Ok(None);
    }
    let mass = brep.mass(context)?;
    let about = mass.about;
    let cone = |[a, b, c]: [DVec3; 3]| (a - about).dot((b - about).cross(c - about)) / 6.0;
    let of_mesh = enclosed(reference, about);
    // A quadrature that went astray is no better than the model's own facets say.
    let of_facets: f64 = tessellation.triangles.iter().map(|t| cone(t.map(|v| tessellation.points[v as usize]))).sum();
    let off = (mass.volume - of_mesh).abs().max(if of_facets > 0.0 { 0.0 } else { of_facets.abs() });
    let bound = cut_off + 1e-9 * of_mesh.abs();
    Ok((!(off <= bound)).then(|| Finding::new(Fault::Volume, off, bound, about)))
}
