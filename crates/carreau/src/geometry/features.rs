//! Feature edges: where a surface must not be smoothed over.
//!
//! Features are the sharp edges, the borders, the edges tagged in the file and those the user lists. Edges without a
//! regular neighbour on the other side (non-manifold, inconsistently oriented) always count. Which sharp edges count is a
//! matter of the size of what is made: see [`Creases`].
//!
//! | file | holds |
//! |---|---|
//! | `at_size` | which sharp edges are creases at the size of elements; noise |
//! | `network` | strands of edges: bridged, pruned |
//! | `found` | what was found, for records and pictures |

mod at_size;
mod found;
mod network;

pub use at_size::{Noise, USUAL_ELEMENTS};
pub use found::{DroppedStrand, FoundFeatures};

use super::normals::{AngleLimit, angle_between, face_normals};
use crate::bounds::angle;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{CornerId, Side, SurfaceMesh, TaggedEdge, VertexId, area_vector, sound};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// An edge is sharp when its angle exceeds the limit by more than this, so that edges exactly at the limit are not
/// divided by rounding.
const MARGIN_DEG: f64 = 1e-6;

/// Which of the edges above the angle are features.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Creases {
    /// Every one.
    #[default]
    Every,
    /// Those that are creases at the size of the elements that are made: each method knows its own.
    Auto,
    /// Those that are creases at the size of elements with edges of this length, in the unit of the mesh.
    AtSize(f64),
}

/// What makes an edge a feature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FeatureOptions {
    /// Edges whose face normals differ by more than this, in degrees; `None`: no edge is sharp.
    pub angle_deg: Option<f64>,
    /// Whether every such edge is a feature, or only creases at the size of the result.
    pub creases: Creases,
    /// Whether borders are features.
    pub borders: bool,
    /// Whether edges tagged in the file are features.
    pub tags: bool,
    /// Further features, by their end vertices.
    pub edges: Vec<[VertexId; 2]>,
}

impl FeatureOptions {
    /// Refuses an angle that is none.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options).
    pub fn validate(&self) -> Result<()> {
        self.angle_deg.map_or(Ok(()), |degrees| angle("feature-angle", degrees))
    }
}

impl Default for FeatureOptions {
    fn default() -> Self {
        FeatureOptions { angle_deg: Some(35.0), creases: Creases::Every, borders: true, tags: true, edges: Vec::new() }
    }
}

impl FeatureOptions {
    /// Creases at the size of the elements that a method makes.
    pub fn auto() -> Self {
        FeatureOptions { creases: Creases::Auto, ..FeatureOptions::default() }
    }

    /// The same for elements with edges of this length, where they are to be found at that size.
    pub fn for_size(&self, length: f64) -> Self {
        let creases = if self.creases == Creases::Auto { Creases::AtSize(length) } else { self.creases };
        FeatureOptions { creases, ..self.clone() }
    }

    /// The same for elements that cover a surface `count` times over with squares.
    pub fn for_squares(&self, mesh: &SurfaceMesh, count: f64) -> Self {
        self.for_size(length_of_squares(mesh, count))
    }
}

/// Edge length of squares, given their number, that cover a surface.
pub fn length_of_squares(mesh: &SurfaceMesh, count: f64) -> f64 {
    let area: f64 = mesh.faces().iter().map(|face| area_vector(mesh.points(), face).length()).sum();
    (area / count.max(1.0)).sqrt()
}

/// The feature edges of a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Features {
    /// For every corner whether the half-edge that leaves it lies on a feature; the half-edges of an edge agree.
    pub corners: Vec<bool>,
    /// Listed and tagged edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// Edges above the angle that are none, as the corner that the first half-edge leaves from.
    pub dropped: Vec<CornerId>,
    /// The longest strand of these.
    pub longest_dropped: Option<DroppedStrand>,
    /// How noisy the edges above the angle are; nothing where all of them count.
    pub noise: Noise,
}

impl Features {
    /// Whether the half-edge that leaves this corner lies on a feature.
    #[inline]
    pub fn contains(&self, c: CornerId) -> bool {
        self.corners[c.index()]
    }

    /// Every feature edge once, as the corner that its first half-edge leaves from, in order.
    pub fn edges<'a>(&'a self, mesh: &'a SurfaceMesh) -> impl Iterator<Item = CornerId> + 'a {
        let first = |group: crate::mesh::EdgeGroup| group.corners().next();
        let half_edges = mesh.half_edges();
        let firsts: Vec<u32> = half_edges.groups().filter_map(first).collect();
        firsts.into_iter().map(CornerId).filter(|&c| self.contains(c))
    }
}

/// Finds the feature edges of a mesh.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for an angle outside 0 to 180.
pub fn feature_edges(mesh: &SurfaceMesh, options: &FeatureOptions) -> Result<Features> {
    feature_edges_in(mesh, options, &Context::new())
}

/// The same in a context: creases at the size of elements take their time.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for an angle outside 0 to 180, [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn feature_edges_in(mesh: &SurfaceMesh, options: &FeatureOptions, context: &Context) -> Result<Features> {
    options.validate()?;
    let normals = face_normals(mesh);
    let limit = options.angle_deg.map(|a| AngleLimit::new((a + MARGIN_DEG).to_radians()));
    let is_sharp = |c: CornerId| {
        mesh.opposite(c).zip(limit.as_ref()).is_some_and(|(o, limit)| {
            let [a, b] = sides(mesh, &normals, c, o);
            limit.is_exceeded(a, b)
        })
    };
    let is_fixed = |c: CornerId| match mesh.side(c) {
        Side::Inner(_) => false,
        Side::Border => options.borders,
        Side::Inconsistent | Side::NonManifold => true,
    };
    let every = || (0..mesh.corner_count()).map(CornerId::new);
    let mut fixed: Vec<bool> = every().map(is_fixed).collect();
    let missing = mark_listed(mesh, options, &mut fixed);
    let sharp: Vec<bool> = every().map(is_sharp).collect();
    let size = match options.creases {
        Creases::Every => None,
        Creases::Auto => Some(length_of_squares(mesh, USUAL_ELEMENTS)),
        Creases::AtSize(size) => Some(size),
    };
    let Some((size, angle)) = size.zip(options.angle_deg).filter(|_| sharp.contains(&true)) else {
        let corners = fixed.iter().zip(&sharp).map(|(fixed, sharp)| *fixed || *sharp).collect();
        return Ok(Features { corners, missing, ..Features::default() });
    };
    let found = at_size::select(mesh, &normals, [fixed, sharp], angle, size, context)?;
    Ok(Features { missing, ..found })
}

/// Marks the tagged and listed edges; returns those that the mesh does not have.
fn mark_listed(mesh: &SurfaceMesh, options: &FeatureOptions, marks: &mut [bool]) -> Vec<[VertexId; 2]> {
    let tagged = mesh.tagged_edges.iter().filter(|_| options.tags).map(|e| e.ends);
    let listed: Vec<[VertexId; 2]> = tagged.chain(options.edges.iter().copied()).collect();
    let mut missing = Vec::new();
    if !listed.is_empty() {
        let half_edges = mesh.half_edges();
        for ends in listed {
            match half_edges.find(ends[0].0, ends[1].0) {
                Some(edge) => edge.corners().for_each(|c| marks[c as usize] = true),
                None => missing.push(ends),
            }
        }
    }
    missing
}

/// Sound triangles with their features: what fields and quads start from.
#[derive(Debug, Clone)]
pub struct FeaturedSurface {
    /// The triangles; the features are its tagged edges.
    pub mesh: SurfaceMesh,
    /// The features.
    pub features: Features,
    /// What was repaired, one sentence each.
    pub repaired: Vec<String>,
    /// Listed and tagged edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// What was kept and dropped.
    pub found: FoundFeatures,
}

impl FeaturedSurface {
    /// Finds the features of a mesh, triangulates it and repairs what needs it. Features are those of the mesh as it is: the
    /// diagonals that divide polygons are none.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options) for an angle outside 0 to 180, [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn new(mesh: &SurfaceMesh, options: &FeatureOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("features");
        let found = feature_edges_in(mesh, options, context)?;
        let mut marked = mesh.clone();
        let ends = |c: CornerId| [mesh.vertex(c), mesh.vertex(mesh.next(c))];
        marked.tagged_edges = found.edges(mesh).map(|c| TaggedEdge { ends: ends(c), tag: 1 }).collect();
        let is_triangular = mesh.is_triangular();
        let (mesh, repaired) = sound(&marked, context)?;
        // A repair may flip edges that were marked: others are sharp then.
        let is_new = is_triangular && !repaired.is_empty() && !found.noise.is_high();
        let angle_deg = options.angle_deg.filter(|_| is_new);
        let as_marked = FeatureOptions { angle_deg, ..FeatureOptions::default() };
        let features = feature_edges(&mesh, &as_marked)?;
        let told = FoundFeatures::new(&marked, &found);
        Ok(FeaturedSurface { mesh, features, repaired, missing: found.missing, found: told })
    }
}

/// The normals on both sides of a half-edge, in the order of the corners, so that both half-edges get the same angle.
fn sides(mesh: &SurfaceMesh, normals: &[DVec3], c: CornerId, o: CornerId) -> [DVec3; 2] {
    [c.min(o), c.max(o)].map(|c| normals[mesh.face_of(c).index()])
}

/// Signed angle between the normals on both sides of a regular inner edge, in radians: 0 where the surface is flat,
/// positive where it is convex, negative where it is concave. `None` on borders and irregular edges.
///
/// The angle through the material, which CAD calls dihedral, is π minus this.
pub fn dihedral_turn(mesh: &SurfaceMesh, face_normals: &[DVec3], c: CornerId) -> Option<f64> {
    let o = mesh.opposite(c)?;
    let along = mesh.point(mesh.vertex(mesh.next(c))) - mesh.point(mesh.vertex(c));
    let [own, other] = [c, o].map(|c| face_normals[mesh.face_of(c).index()]);
    let [a, b] = sides(mesh, face_normals, c, o);
    let angle = angle_between(a, b);
    Some(if own.cross(other).dot(along) < 0.0 { -angle } else { angle })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::*;
    use proptest::prelude::*;

    fn with_angle(angle: f64) -> FeatureOptions {
        FeatureOptions { angle_deg: Some(angle), ..FeatureOptions::default() }
    }

    fn count(mesh: &SurfaceMesh, options: &FeatureOptions) -> usize {
        let features = feature_edges(mesh, options).unwrap();
        for c in (0..mesh.corner_count()).map(CornerId::new) {
            assert!(mesh.opposite(c).is_none_or(|o| features.contains(o) == features.contains(c)));
        }
        features.edges(mesh).count()
    }

    /// A roof: two rectangles that meet at the angle.
    fn roof(turn_deg: f64) -> SurfaceMesh {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let p = [DVec3::ZERO, DVec3::Y, DVec3::NEG_X, DVec3::new(-1., 1., 0.), DVec3::new(cos, 0., -sin)];
        let far = DVec3::new(cos, 1.0, -sin);
        triangles(&[&p[..], &[far]].concat(), &[[2, 0, 1], [2, 1, 3], [0, 4, 5], [0, 5, 1]])
    }

    #[test]
    fn a_cube_has_twelve_sharp_edges_and_no_sharp_diagonal() {
        let mesh = cube(DVec3::ZERO, 3.0).triangulated().unwrap();
        assert_eq!(count(&mesh, &with_angle(35.0)), 12);
        assert_eq!(count(&mesh, &with_angle(90.0)), 0);
        assert_eq!(count(&mesh, &with_angle(89.9)), 12);
        assert_eq!(count(&mesh, &FeatureOptions { angle_deg: None, ..FeatureOptions::default() }), 0);
    }

    #[test]
    fn borders_tags_lists_and_irregular_edges_count_as_asked() {
        let mut mesh = grid(3);
        let none = FeatureOptions { angle_deg: None, borders: false, tags: false, ..FeatureOptions::default() };
        assert_eq!(count(&mesh, &none), 0);
        assert_eq!(count(&mesh, &FeatureOptions { borders: true, ..none.clone() }), 12);
        let inner = [VertexId(5), VertexId(6)];
        mesh.tagged_edges = vec![TaggedEdge { ends: inner, tag: 1 }];
        assert_eq!(count(&mesh, &none), 0);
        assert_eq!(count(&mesh, &FeatureOptions { tags: true, ..none.clone() }), 1);
        let listed = FeatureOptions { edges: vec![[inner[1], inner[0]], [VertexId(0), VertexId(900)]], ..none.clone() };
        assert_eq!(count(&mesh, &listed), 1);
        assert_eq!(feature_edges(&mesh, &listed).unwrap().missing, [[VertexId(0), VertexId(900)]]);
        assert_eq!(count(&cubes_sharing_an_edge(), &none), 1);
        assert_eq!(count(&strip(9, 1), &none), 1);
    }

    #[test]
    fn angles_out_of_range_are_refused() {
        for wrong in [-1.0, 181.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(feature_edges(&grid(1), &with_angle(wrong)), Err(crate::Error::Options(_))));
        }
    }

    proptest! {
        #[test]
        fn the_turn_is_measured_with_its_sign(angle in -179.9f64..179.9) {
            let mesh = roof(angle);
            let normals = face_normals(&mesh);
            for (c, _) in mesh.faces().corners().iter().enumerate() {
                let Some(found) = dihedral_turn(&mesh, &normals, CornerId::new(c)) else { continue };
                let ridge = [c, mesh.next(CornerId::new(c)).index()].iter().all(|&c| mesh.faces().corners()[c] < 2);
                let expected = if ridge { angle } else { 0.0 };
                prop_assert!((found.to_degrees() - expected).abs() < 1e-9, "{} {}", found.to_degrees(), expected);
            }
        }

        #[test]
        fn tiny_turns_are_measured_exactly(exponent in -12.0f64..0.0) {
            let angle = 10f64.powf(exponent);
            let mesh = roof(angle);
            let ridge = (0..12).map(CornerId).find(|&c| mesh.vertex(c).0 == 0 && mesh.vertex(mesh.next(c)).0 == 1);
            let found = dihedral_turn(&mesh, &face_normals(&mesh), ridge.unwrap()).unwrap().to_degrees();
            prop_assert!((found / angle - 1.0).abs() < 1e-3, "{} {}", found, angle);
        }
    }
}
