//! Limbs that are thinner than quads can go around: there edges are to be shorter, or the quads leave the limb out. Features that run
//! along a limb keep it: only what is smooth all around counts.
//!
//! ```text
//!        p              From a place p of the surface it is t to the opposite side, and at least w from side to side through the
//!      ╭─┼─╮            middle m between: the limb is about π (t + w) / 2 around. A plate is as thin, but wide.
//!   ───┼─m─┼── w
//!      ╰─┼─╯
//!        t
//! ```

use super::source::Source;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::vertex_normals;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A count of quads: around every limb there is to be room for so many, because whole numbers may take one away, and three have no
/// shape.
const QUADS_AROUND: f64 = 5.0;
/// A cosine: what is opposite looks the other way, but for this, because the far side of a limb that tapers is no parallel of the near one.
const OPPOSITE: f64 = -0.3;
/// A count: lines through the middle of a limb that are compared for the narrowest, because which one is across is not known.
const LINES: usize = 4;

/// The relative length of edges at every vertex of the source: one, and less on limbs; `None` where there are none.
pub fn lengths(source: &Source, length: f64, context: &Context) -> Result<Option<Vec<f64>>> {
    let mesh = &source.surface.mesh;
    let corners = mesh.faces().fan().0;
    let normals = vertex_normals(mesh, &source.normals);
    let tree = TriangleTree::new(mesh.points(), &corners);
    // The section of a flat limb is about twice as wide as what goes around it.
    let reach = QUADS_AROUND * length / 2.0;
    let region = inner_regions(source, &corners);
    let of = |v: usize| -> Result<f64> {
        context.check_every(v)?;
        if region[v] == NONE {
            return Ok(1.0);
        }
        let (p, up) = (mesh.points()[v], normals[v]);
        let mut across = f64::INFINITY;
        tree.along_ray(p, -up, reach, |hit| {
            let is_own = corners[hit.triangle as usize].contains(&(v as u32));
            let is_opposite = source.region[hit.triangle as usize] == region[v];
            if is_opposite && !is_own && source.normal(hit.triangle).dot(up) < OPPOSITE {
                across = across.min(hit.t);
            }
        });
        if across > reach {
            return Ok(1.0);
        }
        let middle = p - 0.5 * across * up;
        let (x, y) = up.any_orthonormal_pair();
        let first = |way: DVec3| {
            let mut t = f64::INFINITY;
            tree.along_ray(middle, way, reach, |hit| t = t.min(hit.t));
            t
        };
        let width = |k: usize| {
            let (sin, cos) = (PI * k as f64 / LINES as f64).sin_cos();
            let way = x * cos + y * sin;
            first(way) + first(-way)
        };
        let narrowest = (0..LINES).map(width).fold(f64::INFINITY, f64::min);
        Ok((PI * (across + narrowest) / 2.0 / (QUADS_AROUND * length)).min(1.0))
    };
    let lengths: Vec<f64> = (0..mesh.vertex_count()).into_par_iter().map(of).collect::<Result<_>>()?;
    Ok(lengths.iter().any(|&s| s < 1.0).then_some(lengths))
}

/// The region that every vertex is inside of; [`NONE`] on features.
fn inner_regions(source: &Source, corners: &[[u32; 3]]) -> Vec<u32> {
    let mut region = vec![NONE; source.surface.mesh.vertex_count()];
    for (t, &own) in corners.iter().zip(&source.region) {
        t.iter().for_each(|&v| region[v as usize] = own);
    }
    source.edges.iter().flatten().for_each(|&v| region[v as usize] = NONE);
    region
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{SurfaceMesh, test_models::moved};
    use crate::sample;

    /// The least relative length on a ball that is stretched but near its rim, which is thin and narrow on any plate, for quads with
    /// edges of a length.
    fn least(stretch: DVec3, length: f64) -> f64 {
        let context = Context::new();
        let ball: SurfaceMesh = moved(&sample::make("icosphere", Some(40), &context).unwrap(), |p| p * stretch);
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&ball, &options, &context).unwrap();
        let lengths = lengths(&source, length, &context).unwrap();
        let is_inside = |v: &usize| source.surface.mesh.points()[*v].truncate().length() < 0.8;
        lengths.map_or(1.0, |all| (0..all.len()).filter(is_inside).map(|v| all[v]).fold(1.0, f64::min))
    }

    #[test]
    fn edges_are_shorter_around_thin_limbs_alone() {
        let (limb, plate) = (DVec3::new(0.1, 0.1, 1.0), DVec3::new(1.0, 1.0, 0.1));
        assert_eq!(least(DVec3::ONE, 0.2), 1.0, "a ball");
        assert_eq!(least(limb, 0.03), 1.0, "quads that have room around it");
        assert!(least(limb, 0.3) < 0.5, "quads that have none");
        assert_eq!(least(plate, 0.2), 1.0, "a plate is wide");
    }
}
