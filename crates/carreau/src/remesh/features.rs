//! Decides which edges are kept: borders, ridges by angle, tagged edges, edges between labels, seams of what is not
//! manifold.

use super::curves::{Kind, Marks};
use super::options::RemeshOptions;
use super::{fading, warped};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{Creases, FeatureOptions, Features, FoundFeatures, feature_edges, feature_edges_in};
use crate::geometry::normals::angle_between;
use crate::mesh::{Column, CornerId, DisjointSets, NONE, Side, SurfaceMesh, TaggedEdge, VertexId, area_vector};
use glam::DVec3;
use rustc_hash::FxHashSet;
use std::collections::BTreeMap;

/// How a mesh is read.
pub struct Reading {
    /// The kind of curve that every half-edge of the triangular mesh lies on.
    pub marks: Marks,
    /// The surface is a scan: there is noise to take out.
    pub noisy: bool,
    /// The features.
    pub found: FoundFeatures,
}

/// Finds the edges that stay.
pub fn read(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Reading> {
    let wanted = FeatureOptions {
        angle_deg: (options.feature_angle < 180.0).then_some(options.feature_angle),
        creases: options.creases,
        tags: options.tags,
        edges: Vec::new(),
        ..FeatureOptions::default()
    };
    let mut features = feature_edges_in(mesh, &wanted, context)?;
    let inside = inside_polygons(mesh, options.feature_angle)?;
    if let Some(inside) = &inside {
        let drawn = feature_edges(mesh, &FeatureOptions { angle_deg: None, ..wanted })?.corners;
        let stays = inside.iter().zip(drawn).map(|(inside, drawn)| drawn || !inside);
        features.corners.iter_mut().zip(stays).for_each(|(feature, stays)| *feature &= stays);
    }
    let noisy = is_scan(mesh)?
        && match options.creases {
            Creases::Every => drop_noise(mesh, &mut features.corners, options),
            _ if is_noise(mesh, &features) => {
                drop_fragments(mesh, &mut features, options);
                true
            }
            _ => false,
        };
    let found = FoundFeatures::new(mesh, &features);
    let labels = match &options.labels {
        None => None,
        Some(name) => match mesh.attributes.face.get(name) {
            Some(Column::Label(labels)) => Some(labels),
            _ => return Err(Error::Options(format!("the mesh has no face property '{name}' of integers"))),
        },
    };
    let sorted = |[a, b]: [VertexId; 2]| [a.min(b), a.max(b)];
    let has_held_tag = |e: &&TaggedEdge| options.held_tag == Some(e.tag);
    let held: FxHashSet<_> = mesh.tagged_edges.iter().filter(has_held_tag).map(|e| sorted(e.ends)).collect();
    let kind = |c: usize| {
        let c = CornerId::new(c);
        match mesh.side(c) {
            _ if held.contains(&sorted([mesh.vertex(c), mesh.vertex(mesh.next(c))])) => Some(Kind::Seam),
            Side::Border if options.ragged_borders => Some(Kind::Border),
            Side::Border => Some(Kind::Ridge),
            Side::Inconsistent | Side::NonManifold => Some(Kind::Seam),
            Side::Inner(o) => {
                let label = |c: CornerId| labels.map(|l| l[mesh.face_of(c).index()]);
                (features.contains(c) || label(c) != label(o)).then_some(Kind::Ridge)
            }
        }
    };
    let mut marks = (0..mesh.corner_count()).map(kind).collect();
    if !noisy && options.feature_angle < 180.0 {
        let may_bend = |c: CornerId| inside.as_ref().is_some_and(|inside| inside[c.index()]);
        fading::follow(mesh, &mut marks, options.feature_angle, may_bend)?;
    }
    Ok(Reading { marks, noisy, found })
}

/// The face property that tells which triangles were one polygon, where there were any.
pub const POLYGON: &str = " polygon";

/// Which half-edges lie within a polygon of the input, or between two whose normals differ by less than half the feature
/// angle: as long as they are not folded, nobody drew a ridge there, however much the triangles of a warped polygon bend.
/// `None` where there were triangles only.
fn inside_polygons(mesh: &SurfaceMesh, angle_deg: f64) -> Result<Option<Vec<bool>>> {
    let Some(Column::Label(polygon)) = mesh.attributes.face.get(POLYGON) else { return Ok(None) };
    let of = |c: CornerId| polygon[mesh.face_of(c).index()] as usize;
    let mut normals = vec![DVec3::ZERO; 1 + polygon.iter().copied().max().unwrap_or(0) as usize];
    for (t, face) in mesh.faces().iter().enumerate() {
        normals[polygon[t] as usize] += area_vector(mesh.points(), face);
    }
    let limit = (0.5 * angle_deg).to_radians();
    let angle_deg = Some(angle_deg.max(warped::FOLDED_DEG));
    let folded =
        feature_edges(mesh, &FeatureOptions { angle_deg, borders: false, tags: false, ..FeatureOptions::default() })?;
    let inside = |c: CornerId| match mesh.side(c) {
        Side::Inner(o) => !folded.contains(c) && angle_between(normals[of(c)], normals[of(o)]) < limit,
        _ => false,
    };
    Ok(Some((0..mesh.corner_count()).map(|c| inside(CornerId::new(c))).collect()))
}

/// Share of the faces in flats of many sides from which on a surface is no scan.
const FLAT_SHARE: f64 = 0.2;
/// Share of the area in such flats from which on a surface is no scan: a box with round edges has six large flats and
/// thousands of small triangles.
const FLAT_AREA: f64 = 0.4;
/// Share of loose ridge edges below which a surface is no scan.
const LOOSE_SHARE: f64 = 0.1;
/// Where more of the edges than this are ridges they are taken as they are: the surface is coarse, not noisy.
const RIDGE_SHARE: f64 = 0.02;
/// Number of neighbours from which on a flat has many sides.
const MANY_SIDES: usize = 4;
/// Edges with a smaller angle are flat, in degrees; borders with a smaller one go straight on.
const FLAT_DEG: f64 = 0.1;
/// Ridges of a scan are dropped where they have fewer edges than this for every loose end.
const EDGES_PER_LOOSE_END: usize = 40;

/// Whether what is sharp beside the creases is noise: there is much of it, and little besides. Where many of the edges are
/// creases the surface is coarse, not noisy.
fn is_noise(mesh: &SurfaceMesh, features: &Features) -> bool {
    let inner = features.edges(mesh).filter(|&c| mesh.opposite(c).is_some()).count();
    let is_coarse = inner as f64 > RIDGE_SHARE * mesh.corner_count() as f64 / 2.0;
    inner == 0 || features.noise.is_high() && !is_coarse
}

/// Drops the creases of a scan that are in short pieces with loose ends: few vertices of a coarse mesh are worth a pinned one.
fn drop_fragments(mesh: &SurfaceMesh, features: &mut Features, options: &RemeshOptions) {
    let before: Vec<CornerId> = features.edges(mesh).collect();
    drop_noise(mesh, &mut features.corners, options);
    let is_gone = |c: &CornerId| !features.corners[c.index()];
    features.dropped.extend(before.into_iter().filter(is_gone));
}

/// Drops ridges that are only noise; false where they are no noise. CAD models have flat faces and ridges that end at other
/// ridges; scans have neither: there, ridges found by angle alone are few, in scattered pieces with loose ends, and each
/// would pin its vertices.
fn drop_noise(mesh: &SurfaceMesh, feature: &mut [bool], options: &RemeshOptions) -> bool {
    let n = mesh.vertex_count();
    let ends = |c: usize| {
        let c = CornerId::new(c);
        [mesh.vertex(c).index(), mesh.vertex(mesh.next(c)).index()]
    };
    let inner = |c: usize| mesh.opposite(CornerId::new(c)).is_some_and(|o| c < o.index());
    // The degree counts every curve edge, so that ridges may end at borders.
    let mut degree = vec![0u32; n];
    let mut ridges = Vec::new();
    for c in 0..mesh.corner_count() {
        if feature[c] && (inner(c) || mesh.opposite(CornerId::new(c)).is_none()) {
            ends(c).iter().for_each(|&v| degree[v] += 1);
            if inner(c) {
                ridges.push(c);
            }
        }
    }
    let loose_ends = |c: usize| ends(c).iter().filter(|&&v| degree[v] == 1).count();
    let loose: usize = ridges.iter().map(|&c| loose_ends(c)).sum();
    if ridges.is_empty() {
        return true;
    }
    let too_many = ridges.len() as f64 > RIDGE_SHARE * mesh.corner_count() as f64 / 2.0;
    if too_many || (loose as f64) < LOOSE_SHARE * ridges.len() as f64 {
        return false;
    }
    let mut pieces = DisjointSets::new(n);
    for &c in &ridges {
        let [a, b] = ends(c);
        pieces.union(a as u32, b as u32);
    }
    let mut count = vec![(0usize, 0usize); n];
    for &c in &ridges {
        let of = &mut count[pieces.find(ends(c)[0] as u32) as usize];
        (of.0, of.1) = (of.0 + 1, of.1 + loose_ends(c));
    }
    let tagged: Vec<[usize; 2]> = mesh
        .tagged_edges
        .iter()
        .filter(|_| options.tags)
        .map(|e| e.ends.map(|v| v.index()))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    for c in ridges {
        let (edges, loose) = count[pieces.find(ends(c)[0] as u32) as usize];
        let [a, b] = ends(c);
        if edges < EDGES_PER_LOOSE_END * loose.max(1) && !tagged.contains(&[a.min(b), a.max(b)]) {
            feature[c] = false;
            if let Some(o) = mesh.opposite(CornerId::new(c)) {
                feature[o.index()] = false;
            }
        }
    }
    true
}

/// Whether a surface has no flat places to speak of, as scans have none.
///
/// Faces that lie in one plane make one flat. Those of a scan are its triangles, even where they have been divided since,
/// and have three sides: other flats, or straight borders. The flats of a CAD model have many.
fn is_scan(mesh: &SurfaceMesh) -> Result<bool> {
    let bent = FeatureOptions { angle_deg: Some(FLAT_DEG), borders: false, tags: false, ..FeatureOptions::default() };
    let bent = feature_edges(mesh, &bent)?.corners;
    let face = |c: usize| mesh.face_of(CornerId::new(c)).index() as u32;
    let across = |c: usize| mesh.opposite(CornerId::new(c)).map(|o| face(o.index()));
    let mut flats = DisjointSets::new(mesh.face_count());
    for c in (0..mesh.corner_count()).filter(|&c| !bent[c]) {
        if let Some(other) = across(c) {
            flats.union(face(c), other);
        }
    }
    let flat = flats.leaders();
    let mut neighbours = vec![[NONE; 3]; mesh.face_count()];
    let mut straight: BTreeMap<u32, Vec<DVec3>> = BTreeMap::new();
    let mut is_large = vec![false; mesh.face_count()];
    for c in 0..mesh.corner_count() {
        let own = flat[face(c) as usize];
        let Some(other) = across(c).map(|f| flat[f as usize]) else {
            let c = CornerId::new(c);
            let along = (mesh.point(mesh.vertex(mesh.next(c))) - mesh.point(mesh.vertex(c))).normalize_or_zero();
            let known = straight.entry(own).or_default();
            let is_other = |side: &DVec3| side.distance(along) > FLAT_DEG.to_radians();
            if known.len() < MANY_SIDES && known.iter().all(is_other) {
                known.push(along);
            }
            continue;
        };
        if other == own {
            continue;
        }
        let known = &mut neighbours[own as usize];
        match known.iter().position(|&k| k == other || k == NONE) {
            Some(k) => known[k] = other,
            None => is_large[own as usize] = true,
        }
    }
    for (own, straight) in straight {
        let others = neighbours[own as usize].iter().filter(|&&k| k != NONE).count();
        is_large[own as usize] |= others + straight.len() >= MANY_SIDES;
    }
    let (mut count, mut area, mut total) = (0.0, 0.0, 0.0);
    for (f, face) in mesh.faces().iter().enumerate() {
        let own = area_vector(mesh.points(), face).length();
        total += own;
        if is_large[flat[f] as usize] {
            (count, area) = (count + 1.0, area + own);
        }
    }
    Ok(count < FLAT_SHARE * mesh.face_count() as f64 && area < FLAT_AREA * total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Polygons;
    use crate::mesh::test_models::{cube, grid, moved, sphere, triangles};
    use crate::sample;

    /// Every triangle in four, in its plane.
    fn divided(mesh: &SurfaceMesh) -> SurfaceMesh {
        let mut points = mesh.points().to_vec();
        let mut middle_of = vec![0u32; mesh.corner_count()];
        for edge in mesh.half_edges().groups() {
            let [a, b] = edge.ends.map(|v| mesh.points()[v as usize]);
            edge.corners().for_each(|c| middle_of[c as usize] = points.len() as u32);
            points.push((a + b) / 2.0);
        }
        let mut faces = Vec::new();
        for (t, f) in mesh.faces().iter().enumerate() {
            let [m, n, o] = [0, 1, 2].map(|k| middle_of[3 * t + k]);
            faces.extend([[f[0], m, o], [f[1], n, m], [f[2], o, n], [m, n, o]]);
        }
        SurfaceMesh::from_triangles(points, &faces).unwrap()
    }

    #[test]
    fn a_scan_whose_triangles_were_divided_is_still_one() {
        let scan = moved(&sphere(3), |p| p * (1.0 + 0.01 * (37.0 * p.x).sin() * (41.0 * p.y + 29.0 * p.z).cos()));
        assert!(is_scan(&scan).unwrap() && is_scan(&divided(&divided(&scan))).unwrap());
        let part = sample::make("bracket", None, &Context::new()).unwrap().triangulated().unwrap();
        let cube = cube(DVec3::ZERO, 1.0).triangulated().unwrap();
        // Flats that are all there is, with borders alone around them.
        let triangle = triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]);
        assert!(is_scan(&triangle).unwrap() && is_scan(&divided(&divided(&triangle))).unwrap());
        let plate = grid(1);
        // Hundreds of small triangles beside a large flat.
        let small = moved(&scan, |p| 0.1 * p);
        let shift = small.vertex_count() as u32;
        let points = small.points().iter().chain(plate.points()).copied().collect::<Vec<_>>();
        let fans = plate.clone().triangulated().unwrap();
        let faces = small.faces().iter().map(|f| [f[0], f[1], f[2]]);
        let faces = faces.chain(fans.faces().iter().map(|f| [f[0] + shift, f[1] + shift, f[2] + shift]));
        let mostly_flat = triangles(&points, &faces.collect::<Vec<_>>());
        for mesh in [part, cube, plate, mostly_flat] {
            assert!(!is_scan(&mesh).unwrap() && !is_scan(&divided(&mesh)).unwrap());
        }
    }

    #[test]
    fn the_triangles_of_a_warped_quad_have_no_ridge_between_them() {
        // A twisted quad with a wall on one side: its four triangles bend by 30° from one to the next.
        let points = [(0., 0., 0.2), (1., 0., -0.2), (1., 1., 0.2), (0., 1., -0.2), (1., 0., -1.), (1., 1., -1.)];
        let mut faces = Polygons::new();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[1, 4, 5, 2]);
        let mesh = SurfaceMesh::new(points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec(), faces).unwrap();
        let (divided, _) = crate::remesh::clean(&mesh, &Context::new()).unwrap();
        let options = RemeshOptions { feature_angle: 25.0, ..RemeshOptions::default() };
        let ridges = |mesh: &SurfaceMesh| {
            let marks = read(mesh, &options, &Context::new()).unwrap().marks;
            let ends = |c: CornerId| [mesh.vertex(c), mesh.vertex(mesh.next(c))].map(|v| mesh.points()[v.index()].x);
            let ridges = (0..mesh.corner_count()).filter(|&c| marks[c] == Some(Kind::Ridge));
            ridges.map(|c| ends(CornerId::new(c))).collect::<Vec<_>>()
        };
        assert_eq!(divided.face_count(), 6);
        assert_eq!(ridges(&divided), [[1.0; 2]; 2], "the edge to the wall alone, seen from both sides");
        let mut forgotten = divided;
        forgotten.attributes.face.clear();
        assert!(ridges(&forgotten).len() > 2);
    }
}
