//! How long the edges of quads are to be over a surface, relative to those of even ones: shorter where it bends, or as a vertex
//! property says.
//!
//! ```text
//!   ┌───┬───┬──┬─┬┬┬┬─┬──┬───┬───┐      Where the surface bends with curvature κ, a chord of length h is off it by
//!   │   │   │  │ ││││ │  │   │   │      κ h² / 8: h ~ κ^(-1/2) leaves all of them equally far off.
//!   └───┴───┴──┴─┴┴┴┴─┴──┴───┴───┘
//! ```
//!
//! Lengths stay within a range, change by little from one quad to the next, and leave the number of quads what it is.

use super::coarse::{Follow, coarse};
use super::limbs;
use super::map::{WORKING_EDGES, WORKING_SMALLEST};
use super::source::Source;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::curvature::{CurvatureOptions, curvature};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{Column, SurfaceMesh, Triangles, divided, triangle_area_vector};
use glam::DVec3;

/// Factors of the even length: by curvature edges are no shorter and no longer, because rows of quads go on where sizes change, and
/// quads would become long and thin.
const CURVATURE_RANGE: [f64; 2] = [0.5, 2.0];
/// Factors of the even length: the same for a property, which is what somebody wants.
const PROPERTY_RANGE: [f64; 2] = [0.25, 4.0];
/// Factors of the even length: edges are no shorter on limbs, because these would take too many of the quads.
const LIMB_RANGE: [f64; 2] = [0.3, 1.5];
/// A share: edges become no longer than this from one to the next, because quads beside each other are to look alike.
const GROWTH: f64 = 0.2;
/// A count: sweeps over the edges in which that is seen to, because lengths spread from edge to edge.
const GROWTH_SWEEPS: usize = 200;
/// A count: halvings in search of the factor that leaves the number of quads what it is, as far as doubles tell.
const FACTOR_STEPS: usize = 60;
/// A factor: pure red makes edges shorter by so much and its complement longer, a fourth and four times as many quads.
const RED_FACTOR: f64 = 2.0;

/// Relative lengths, by triangle of a mesh that covers the surface.
pub struct Sizes {
    tree: TriangleTree,
    values: Vec<f64>,
}

impl Sizes {
    /// Shorter where the surface bends, measured on triangles of the size of quads; `None` where there are none.
    pub fn of_curvature(source: &Source, length: f64, context: &Context) -> Result<Option<Self>> {
        let edges = WORKING_EDGES[0] * length;
        let Some(found) = coarse(source, edges, Follow::even(WORKING_SMALLEST), 180.0, context)? else {
            return Ok(None);
        };
        let Some(triangles) = Triangles::of(&found.mesh) else { return Ok(None) };
        let of = curvature(triangles, &found.is_feature, &CurvatureOptions::default(), context)?;
        let wanted = of.kmin.iter().zip(&of.kmax).map(|(a, b)| a.abs().max(b.abs()).sqrt().recip()).collect();
        Ok(Some(Self::new(triangles, wanted, CURVATURE_RANGE, length)))
    }

    /// Shorter on limbs that even quads have no room around; `None` where there are none.
    pub fn of_limbs(source: &Source, length: f64, context: &Context) -> Result<Option<Self>> {
        let Some(triangles) = Triangles::of(&source.surface.mesh) else { return Ok(None) };
        let wanted = limbs::lengths(source, length, context)?;
        Ok(wanted.map(|wanted| Self::new(triangles, wanted, LIMB_RANGE, length)))
    }

    /// As a vertex property says: a number is a relative length, a colour makes quads smaller where it is red, and larger where it
    /// is the complement of red.
    pub fn of_property(mesh: &SurfaceMesh, name: &str, length: f64) -> Result<Self> {
        let unusable = |what: &str| Error::Options(format!("sizes: the vertex property '{name}' {what}"));
        let wanted: Vec<f64> = match mesh.attributes.vertex.get(name) {
            Some(Column::Scalar(values)) => values.clone(),
            Some(Column::Label(values)) => values.iter().map(|&v| f64::from(v)).collect(),
            Some(Column::Color(values)) => values.iter().map(|c| RED_FACTOR.powf(-redness(*c))).collect(),
            Some(_) => return Err(unusable("is neither a number nor a colour")),
            None => return Err(unusable("is not in the file")),
        };
        if let Some(v) = wanted.iter().position(|x| !(*x > 0.0 && x.is_finite())) {
            return Err(unusable(&format!("is {} at vertex {v}, and lengths are above 0", wanted[v])));
        }
        let mesh = divided(mesh)?;
        let Some(triangles) = Triangles::of(&mesh) else { return Err(unusable("is on no triangles")) };
        Ok(Self::new(triangles, wanted, PROPERTY_RANGE, length))
    }

    /// The relative length at a place.
    pub fn at(&self, p: DVec3) -> f64 {
        self.tree.closest(p).map_or(1.0, |found| self.values[found.triangle as usize])
    }

    /// The shortest.
    pub fn smallest(&self) -> f64 {
        self.values.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The longest.
    pub fn largest(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }

    /// `wanted`: relative lengths by vertex, in any unit.
    fn new(triangles: Triangles<'_>, mut wanted: Vec<f64>, range: [f64; 2], length: f64) -> Self {
        let corners: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|t| triangles.triangle(t)).collect();
        let points = triangles.points();
        let mut area = vec![0.0; points.len()];
        for t in &corners {
            let [a, b, c] = t.map(|v| points[v as usize]);
            let third = triangle_area_vector(a, b, c).length() / 3.0;
            t.iter().for_each(|&v| area[v as usize] += third);
        }
        even(&mut wanted, &area, range);
        limit_growth(&mut wanted, &corners, points, length);
        even(&mut wanted, &area, range);
        let values = corners.iter().map(|t| t.iter().map(|&v| wanted[v as usize]).sum::<f64>() / 3.0).collect();
        Sizes { tree: TriangleTree::new(points, &corners), values }
    }
}

/// Scales lengths so that quads of them, within a range, are as many as even ones.
fn even(wanted: &mut [f64], area: &[f64], [low, high]: [f64; 2]) {
    let whole: f64 = area.iter().sum();
    let quads =
        |factor: f64| -> f64 { wanted.iter().zip(area).map(|(s, a)| a / (factor * s).clamp(low, high).powi(2)).sum() };
    let used = || wanted.iter().zip(area).filter(|(s, a)| **a > 0.0 && s.is_finite()).map(|(s, _)| *s);
    let (least, most) = used().fold((f64::INFINITY, 0f64), |(a, b), s| (a.min(s), b.max(s)));
    if !(least > 0.0 && most > 0.0) {
        wanted.fill(1.0);
        return;
    }
    let (mut small, mut large) = ((low / most).ln(), (high / least).ln());
    for _ in 0..FACTOR_STEPS {
        let middle = 0.5 * (small + large);
        *(if quads(middle.exp()) > whole { &mut small } else { &mut large }) = middle;
    }
    let factor = (0.5 * (small + large)).exp();
    wanted.iter_mut().for_each(|s| *s = (factor * *s).clamp(low, high));
}

/// Makes edges shorter that would be much longer than those beside them.
fn limit_growth(wanted: &mut [f64], corners: &[[u32; 3]], points: &[DVec3], length: f64) {
    for _ in 0..GROWTH_SWEEPS {
        let mut has_changed = false;
        for t in corners {
            for (k, l) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                let [a, b] = [t[k] as usize, t[l] as usize];
                let most = wanted[a] + GROWTH * points[a].distance(points[b]) / length;
                has_changed |= wanted[b] > most * (1.0 + 1e-9);
                wanted[b] = wanted[b].min(most);
            }
        }
        if !has_changed {
            break;
        }
    }
}

/// From -1 for the complement of red, over 0 for white, grey and black, to 1 for red.
fn redness([r, g, b, _]: [u8; 4]) -> f64 {
    (f64::from(r) - 0.5 * (f64::from(g) + f64::from(b))) / 255.0
}

#[cfg(test)]
mod tests {
    use super::super::{QuadOptions, quads};
    use super::*;
    use crate::mesh::test_models::{grid, moved};

    /// A sheet with a bump in its middle.
    fn sheet() -> SurfaceMesh {
        let height = |p: DVec3| 0.15 * (-(p.truncate() - 0.5).length_squared() / 0.006).exp();
        moved(&grid(60), |p| DVec3::new(p.x, p.y, height(p / 60.0)) / DVec3::new(60.0, 60.0, 1.0))
    }

    /// Mean length of the quads' edges in the middle of the sheet, over that near its corners, and how many quads there are.
    fn middle_over_corners(mesh: &SurfaceMesh, options: QuadOptions) -> (f64, usize) {
        let result = quads(mesh, &QuadOptions { quads: 1000, ..options }, &Context::new()).unwrap();
        assert_eq!(result.quality.inverted, 0);
        let out = &result.mesh;
        let (mut middle, mut corners) = ((0.0, 0.0), (0.0, 0.0));
        for edge in out.half_edges().groups() {
            let [a, b] = edge.ends.map(|v| out.points()[v as usize]);
            let sum = match (a.midpoint(b).truncate() - 0.5).length() {
                r if r < 0.15 => &mut middle,
                r if r > 0.45 => &mut corners,
                _ => continue,
            };
            *sum = (sum.0 + a.distance(b), sum.1 + 1.0);
        }
        (middle.0 / middle.1 / (corners.0 / corners.1), out.face_count())
    }

    #[test]
    fn quads_are_smaller_where_the_surface_bends() {
        let (even, _) = middle_over_corners(&sheet(), QuadOptions::default());
        let (adaptive, count) = middle_over_corners(&sheet(), QuadOptions { adaptive: true, ..QuadOptions::default() });
        assert!(adaptive < 0.8 * even, "{adaptive} {even}");
        assert!((900..=1100).contains(&count), "{count}");
    }

    #[test]
    fn quads_have_the_sizes_of_a_property() {
        let mut mesh = sheet();
        let (even, _) = middle_over_corners(&mesh, QuadOptions::default());
        let is_middle = |p: &DVec3| (p.truncate() - 0.5).length() < 0.2;
        let lengths = mesh.points().iter().map(|p| if is_middle(p) { 2.0 } else { 1.0 }).collect();
        let colours = mesh.points().iter().map(|p| if is_middle(p) { [0, 255, 255, 255] } else { [255; 4] }).collect();
        for column in [Column::Scalar(lengths), Column::Color(colours)] {
            mesh.attributes.vertex.insert("wanted".into(), column);
            let options = QuadOptions { sizes: Some("wanted".into()), ..QuadOptions::default() };
            let (found, count) = middle_over_corners(&mesh, options);
            assert!(found > 1.2 * even && (900..=1100).contains(&count), "{found} {even} {count}");
        }
    }

    #[test]
    fn properties_that_are_no_lengths_are_refused() {
        let mut mesh = sheet();
        let mut values = vec![1.0; mesh.vertex_count()];
        values[7] = 0.0;
        mesh.attributes.vertex.insert("zero".into(), Column::Scalar(values));
        for name in ["zero", "missing"] {
            let options = QuadOptions { sizes: Some(name.into()), ..QuadOptions::default() };
            let found = quads(&mesh, &options, &Context::new());
            assert!(matches!(found, Err(Error::Options(why)) if why.contains(name)));
        }
    }
}
