//! The validator between the rungs: what a quad mesh has to be before anyone sees it.

use super::junction::TOUCH_DISTANCE;
use super::source::Source;
use super::symmetry::{AT_PLANE, MirrorPlane};
use super::work::Work;
use crate::error::Result;
use crate::geometry::quality::scaled_jacobian;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{HalfEdges, SurfaceMesh, Topology};
use glam::DVec3;

/// A share of the diagonal: a feature is kept where an edge is so near, because chords of a bend cannot be on it.
pub const FEATURE_NEAR: f64 = 0.002;
/// Degrees: that edge is so parallel to it, because one that crosses a feature is near it as well.
pub const FEATURE_ALONG_DEG: f64 = 15.0;
/// A count: places of features for each length of the diagonal, because two of them are within [`FEATURE_NEAR`] then.
const FEATURE_SAMPLES: f64 = 1000.0;
/// A share of the diagonal: borders are so near to features, a little nearer than what keeps them because an edge is
/// looked at in three places only.
const BORDER_NEAR: f64 = 0.0018;
/// A share of its longest edge: a quad looks the wrong way where no triangle so little farther than the nearest one
/// agrees with it, because needles of the input look anywhere.
const WITNESS_REACH: f64 = 0.2;
/// A share of the features: so much has to be kept, which is all but rounding because every one of them is asked for.
pub const LEAST_RECALL: f64 = 0.9995;

/// Why a mesh is refused; `None`: it is accepted.
pub fn refusal(work: &Work, mesh: &SurfaceMesh, source: &Source) -> Result<Option<String>> {
    if let Some(why) = unsound(work, mesh, source)? {
        return Ok(Some(why));
    }
    let (kept, lost) = recall(work, source);
    let place =
        lost.map_or(String::new(), |p| format!(", the first one is lost near {:.4} {:.4} {:.4}", p.x, p.y, p.z));
    Ok((kept < LEAST_RECALL).then(|| format!("{:.3} % of the features are kept{place}", 100.0 * kept)))
}

/// Why a mesh is refused, whatever it keeps of the features inside the surface.
pub fn unsound(work: &Work, mesh: &SurfaceMesh, source: &Source) -> Result<Option<String>> {
    if work.faces.iter().any(|f| f.len() != 4) {
        return Ok(Some("a face is no quad".into()));
    }
    if let Some(why) = topology_refusal(mesh, source) {
        return Ok(Some(why.into()));
    }
    if let Some(fault) = faults(work, source).next() {
        return Ok(Some(told(work, fault)));
    }
    Ok(border_refusal(work, source).map(String::from))
}

/// Why a mesh is no mesh of the source's topology.
pub fn topology_refusal(mesh: &SurfaceMesh, source: &Source) -> Option<&'static str> {
    let (had, has) = (Topology::of(&source.surface.mesh), Topology::of(mesh));
    if has.nonmanifold_edges + has.nonmanifold_vertices + has.inconsistent_edges + has.duplicate_faces > 0 {
        return Some("it is not manifold");
    }
    let counts = |t: &Topology| (t.components, t.euler, t.boundary_loops);
    (counts(&had) != counts(&has)).then_some("its topology is another")
}

/// Quads that are no good, with what is wrong.
pub fn faults<'a>(work: &'a Work, source: &'a Source) -> impl Iterator<Item = (usize, &'static str)> + 'a {
    work.faces.iter().enumerate().filter_map(|(q, face)| {
        let p = [0, 1, 2, 3].map(|k| work.points[face[k] as usize]);
        if !(scaled_jacobian(p) > 0.0) {
            return Some((q, "is inverted"));
        }
        let normal = (p[2] - p[0]).cross(p[3] - p[1]);
        let centre = p.iter().sum::<DVec3>() / 4.0;
        let (below, t) = source.on_region(work.region[q], centre)?;
        let longest = (0..4).map(|k| p[k].distance(p[(k + 1) % 4])).fold(0.0, f64::max);
        // Needles of the input look anywhere: one around that agrees will do.
        let is_turned = normal.dot(source.normal(t)) <= 0.0
            && !source.has_alike(work.region[q], centre, centre.distance(below) + WITNESS_REACH * longest, normal);
        is_turned.then_some((q, "looks the wrong way"))
    })
}

/// What is wrong with a quad, and where it is.
pub fn told(work: &Work, (q, what): (usize, &str)) -> String {
    let p = work.faces.face(q).iter().map(|&v| work.points[v as usize]).sum::<DVec3>() / 4.0;
    format!("the quad near {:.4} {:.4} {:.4} {what}", p.x, p.y, p.z)
}

/// Borders stay on features; where two lie on each other, as in a surface that was cut, their vertices do, too.
fn border_refusal(work: &Work, source: &Source) -> Option<&'static str> {
    let half_edges = HalfEdges::new(&work.faces, work.points.len());
    let edges: Vec<[u32; 2]> = half_edges.groups().filter(|e| e.len() == 1).map(|e| e.ends).collect();
    let near = BORDER_NEAR * source.diagonal;
    let is_far = |e: &[u32; 2]| {
        let [a, b] = e.map(|v| work.points[v as usize]);
        let at_plane = |p: DVec3, plane: &MirrorPlane| plane.height(p).abs() <= AT_PLANE * source.diagonal;
        // The quads are mirrored there: how near they are to the cut is how near they are to the surface.
        if source.guidance.cuts.iter().any(|plane| [a, b].iter().all(|&p| at_plane(p, plane))) {
            return false;
        }
        [0.25, 0.5, 0.75].iter().any(|&s| source.feature_along(a + (b - a) * s, DVec3::X, near, -1.0).is_none())
    };
    if edges.iter().any(is_far) {
        return Some("a border is off the borders of the surface");
    }
    let tree = TriangleTree::of_segments(&work.points, edges.iter().copied());
    let touch = TOUCH_DISTANCE * source.diagonal;
    let is_inside = |v: u32| {
        let p = work.points[v as usize];
        let mut inside = false;
        tree.within(p, touch, |found| {
            let [a, b] = edges[found.triangle as usize];
            let far = |w: u32| work.points[w as usize].distance(p) > touch;
            inside |= far(a) && far(b);
        });
        inside
    };
    edges.iter().flatten().copied().any(is_inside).then_some("a border vertex is inside another border edge")
}

/// The share of the features that is kept, and the first place where one is not.
pub fn recall(work: &Work, source: &Source) -> (f64, Option<DVec3>) {
    let lost = lost(work, source);
    let total: f64 = lost.iter().map(|l| l.of).sum();
    let share = lost.iter().map(|l| l.length).sum::<f64>() / total;
    (if total > 0.0 { 1.0 - share } else { 1.0 }, lost.iter().find_map(|l| l.first))
}

/// What is lost of a feature curve.
#[derive(Debug, Clone, Copy, Default)]
pub struct Lost {
    pub length: f64,
    /// The length of the curve.
    pub of: f64,
    pub first: Option<DVec3>,
}

/// What is lost of every curve: places that no edge of a feature is near and about parallel to.
pub fn lost(work: &Work, source: &Source) -> Vec<Lost> {
    let tree = TriangleTree::of_segments(&work.points, work.features.iter().map(|f| f.0));
    let (near, cos) = (FEATURE_NEAR * source.diagonal, FEATURE_ALONG_DEG.to_radians().cos());
    let mut all = vec![Lost::default(); source.paths.len()];
    let features = source.edges.iter().zip(&source.curve).filter(|(_, curve)| !source.is_cut[**curve as usize]);
    for (ends, &curve) in features {
        let of_curve = &mut all[curve as usize];
        let [a, b] = ends.map(|v| source.surface.mesh.points()[v as usize]);
        let (length, along) = (a.distance(b), (b - a).normalize_or_zero());
        let n = (length / source.diagonal * FEATURE_SAMPLES).ceil().max(1.0);
        for k in 0..n as usize {
            let p = a + (b - a) * ((k as f64 + 0.5) / n);
            let mut found = false;
            tree.within(p, near, |closest| {
                let [a, b] = work.features[closest.triangle as usize].0.map(|v| work.points[v as usize]);
                found |= (b - a).normalize_or_zero().dot(along).abs() >= cos;
            });
            of_curve.of += length / n;
            if !found {
                of_curve.length += length / n;
                of_curve.first = of_curve.first.or(Some(p));
            }
        }
    }
    all
}

/// Whether edges between two places keep the curve that they are on, by a share of what may be between them.
pub fn keeps_feature(source: &Source, curve: u32, ends: [DVec3; 2], share: f64) -> bool {
    source.is_cut.get(curve as usize) == Some(&true)
        || source.is_along(
            curve,
            ends,
            share * FEATURE_NEAR * source.diagonal,
            (share * FEATURE_ALONG_DEG).to_radians().cos(),
        )
}
