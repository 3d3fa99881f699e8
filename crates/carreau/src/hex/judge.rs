//! The verdict on a mesh before it is returned: how far surface and cells are apart and where, which parts of the
//! surface no cell comes near, the volume, and cells that overlap others.
//!
//! ```text
//!   ╭────╮   uncovered: the surface is        ┌──┬──┐
//!   │    │   farther from the cells than      │ ┌┼─┬┼─┐   overlapping: the boundary winds twice
//!  ─┴────┴─  the limit                        └─┼┴─┼┘ │   around the centre of a cell
//!  ┌──┬──┐                                      └──┴──┘
//!  └──┴──┘
//! ```
//!
//! Each cell by itself may be certified all the same: only both together make a mesh of the shape.

use super::layers::LayerFigures;
use super::middle_nodes::StraightEdges;
use super::overlap::{QUERIES_PER_CHECK, Uncovered};
use super::{HexOptions, HexResult};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::distance::{DistanceOptions, compare};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{DisjointSets, SurfaceMesh, Topology, split_quad, triangle_area_vector};
use crate::words::counted;
use glam::DVec3;
use rayon::prelude::*;

/// Default of the largest distance that is allowed, as a share of the surface's diagonal.
pub const MAX_DISTANCE: f64 = 0.02;
/// The user is told of a volume that differs from the surface's by more than this share.
const VOLUME: f64 = 0.05;

/// Samples alone miss the largest distance by some per cent.
const CLOSELY: DistanceOptions = DistanceOptions { samples: 100_000, refinements: 50_000, normals: false };

/// Measures the cells against the closed surface.
pub fn measure(result: &mut HexResult, surface: &SurfaceMesh, options: &HexOptions, context: &Context) -> Result<()> {
    let _stage = context.stage("measure");
    let mesh = &result.mesh;
    let triangles: Vec<[u32; 3]> = mesh.quads.iter().flat_map(|&q| split_quad(&mesh.points, q)).collect();
    let boundary = SurfaceMesh::from_triangles(mesh.points.clone(), &triangles)?;
    let found = compare(surface, &boundary, &CLOSELY, context)?;
    let diagonal = found.diagonal.max(f64::MIN_POSITIVE);
    let figures = &mut result.figures;
    figures.distance_max = Some(found.relative.max);
    let (to_cells, to_surface) = (found.a_to_b.distance.max, found.b_to_a.distance.max);
    figures.distance_max_at = Some(if to_cells >= to_surface { found.a_to_b.max_at } else { found.b_to_a.max_at });
    figures.distance_mean = Some(found.a_to_b.distance.mean / diagonal);
    let volume = Topology::of(surface).volume;
    figures.volume_ratio = volume.filter(|v| *v > 0.0).map(|v| figures.quality.volume / v);
    let limit = options.max_distance.unwrap_or(MAX_DISTANCE * diagonal);
    figures.uncovered = if to_cells > limit {
        let tree = TriangleTree::new(boundary.points(), &triangles);
        let mut parts = uncovered(surface, &tree, limit, diagonal, context)?;
        if parts.is_empty() {
            // Large triangles may be far away between their corners and their middle alone.
            parts.push(Uncovered { at: found.a_to_b.max_at, distance: to_cells / diagonal, area: 0.0 });
        }
        parts
    } else {
        Vec::new()
    };
    Ok(())
}

/// The connected parts of a surface that are farther than the limit, by the corners and middles of triangles; the farthest first.
fn uncovered(
    surface: &SurfaceMesh,
    cells: &TriangleTree,
    limit: f64,
    diagonal: f64,
    context: &Context,
) -> Result<Vec<Uncovered>> {
    let (points, triangles) = (surface.points(), surface.faces().fan().0);
    let farthest = |t: &[u32; 3]| {
        let p = t.map(|v| points[v as usize]);
        let middle = p.iter().sum::<DVec3>() / 3.0;
        let all = [middle, p[0], p[1], p[2]].map(|q| (cells.distance(q), q));
        all.into_iter().fold((0.0, middle), |best: (f64, DVec3), next| if next.0 > best.0 { next } else { best })
    };
    let of_chunk = |chunk: &[[u32; 3]]| {
        context.check()?;
        Ok(chunk.iter().map(farthest).collect())
    };
    let far: Result<Vec<Vec<(f64, DVec3)>>> = triangles.par_chunks(QUERIES_PER_CHECK).map(of_chunk).collect();
    let far = far?.concat();
    let is_far = |t: &usize| far[*t].0 > limit;
    let mut sets = DisjointSets::new(points.len());
    for t in (0..triangles.len()).filter(is_far) {
        let [a, b, c] = triangles[t];
        sets.union(a, b);
        sets.union(b, c);
    }
    let area = |t: usize| {
        let [a, b, c] = triangles[t].map(|v| points[v as usize]);
        triangle_area_vector(a, b, c).length()
    };
    let all: f64 = (0..triangles.len()).map(area).sum();
    let mut of_set: Vec<(u32, usize)> =
        (0..triangles.len()).filter(is_far).map(|t| (sets.find(triangles[t][0]), t)).collect();
    of_set.sort_unstable();
    let part = |same: &[(u32, usize)]| {
        let worst = same.iter().map(|s| far[s.1]).fold((0.0, DVec3::ZERO), |a, b| if b.0 > a.0 { b } else { a });
        let sum: f64 = same.iter().map(|s| area(s.1)).sum();
        Uncovered { at: worst.1.to_array(), distance: worst.0 / diagonal, area: sum / all.max(f64::MIN_POSITIVE) }
    };
    let mut parts: Vec<Uncovered> = of_set.chunk_by(|a, b| a.0 == b.0).map(part).collect();
    parts.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    Ok(parts)
}

/// Refuses cells that are too far from the surface or lie where others are, unless they are allowed to; then, and where the
/// volume is not the surface's, a warning says so. In the unit of the file.
pub fn accept(result: &mut HexResult, options: &HexOptions, diagonal: f64) -> Result<()> {
    let found = flaws(result, options, diagonal);
    if !found.is_empty() && !options.allow_far {
        let remedy = "ask for smaller cells, or give a skeleton with a branch in every limb; \
                      the options max-distance and allow-far let such a mesh pass";
        return Err(Error::Numeric(format!("{}; {remedy}", found.join("; "))));
    }
    result.warnings.extend(found);
    if let Some(ratio) = result.figures.volume_ratio.filter(|r| (r - 1.0).abs() > VOLUME) {
        result.warnings.push(format!("the cells have {:.1}% of the volume of the surface", 100.0 * ratio));
    }
    Ok(())
}

fn flaws(result: &HexResult, options: &HexOptions, diagonal: f64) -> Vec<String> {
    let figures = &result.figures;
    let percent = |share: f64| format!("{:.2}%", 100.0 * share);
    let limit = options.max_distance.map_or(MAX_DISTANCE, |d| d / diagonal.max(f64::MIN_POSITIVE));
    let mut found = Vec::new();
    if let Some((far, at)) = figures.distance_max.zip(figures.distance_max_at).filter(|f| f.0 > limit) {
        let parts = match figures.uncovered.len() {
            0 => String::new(),
            n => format!(" ({} of the surface not covered)", counted(n, "part", "parts")),
        };
        found.push(format!(
            "the cells and the surface are up to {} of the diagonal apart, near {}, but only {} is allowed{parts}",
            percent(far),
            place(at),
            percent(limit)
        ));
    }
    found.extend(overlap_line(result));
    found
}

/// What is to be said of layers and curved edges that are not as they should be. In the unit of the file, too.
pub fn tell(result: &mut HexResult) {
    let figures = &result.figures;
    let of_layers = figures.layers.as_ref().and_then(LayerFigures::warning);
    let of_edges = figures.straight_edges.as_ref().and_then(StraightEdges::warning);
    result.warnings.extend([of_layers, of_edges].into_iter().flatten());
}

/// What is to be said of cells that lie where others are.
pub fn overlap_line(result: &HexResult) -> Option<String> {
    let quality = &result.figures.quality;
    let first = *quality.overlapping.first()?;
    let corners = result.mesh.hexes.get(first as usize)?;
    let centre = corners.iter().map(|&v| result.mesh.points[v as usize]).sum::<DVec3>() / 8.0;
    let cells = counted(quality.overlapping.len(), "cell lies where another is", "cells lie where others are");
    let (share, at) = (100.0 * quality.overlap, place(centre.to_array()));
    Some(format!("{cells} ({share:.2}% of the volume), first cell {first}, near {at}"))
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("{x:.6} {y:.6} {z:.6}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hex::{Figures, Padding};
    use crate::mesh::test_models::bricks;
    use crate::mesh::{CurveNet, HexMesh, boundary_faces};

    fn block(size: [u32; 3]) -> HexMesh {
        let (points, hexes) = bricks(size);
        let quads: Vec<[u32; 4]> = boundary_faces(&hexes).into_iter().map(|f| f.0).collect();
        HexMesh { points, hexes, tags: vec![1; quads.len()], quads }
    }

    fn judged(cells: [u32; 3], surface: [u32; 3], options: &HexOptions) -> (Result<()>, HexResult) {
        let context = Context::new();
        let (mesh, around) = (block(cells), block(surface));
        let triangles: Vec<[u32; 3]> = around.quads.iter().flat_map(|&q| split_quad(&around.points, q)).collect();
        let surface = SurfaceMesh::from_triangles(around.points, &triangles).unwrap();
        let figures = Figures::of(&mesh, 1, Padding::None, &context).unwrap();
        let skeleton = CurveNet::new(Vec::new(), Vec::new(), Vec::new());
        let (origins, flat_caps, bases) = (Vec::new(), Vec::new(), Vec::new());
        let (warnings, second_order) = (Vec::new(), None);
        let mut result = HexResult { mesh, skeleton, figures, warnings, origins, flat_caps, second_order, bases };
        measure(&mut result, &surface, options, &context).unwrap();
        (accept(&mut result, options, surface.diagonal()), result)
    }

    /// Two cells are missing at one end of six.
    #[test]
    fn what_is_far_is_refused_with_its_place() {
        let (verdict, result) = judged([4, 1, 1], [6, 1, 1], &HexOptions::default());
        let message = match verdict {
            Err(Error::Numeric(message)) => message,
            other => panic!("{other:?}"),
        };
        assert!(message.contains("near 6.0") && message.contains("1 part of the surface"), "{message}");
        let figures = &result.figures;
        assert_eq!(figures.distance_max_at.map(|p| p[0]), Some(6.0));
        let far = figures.distance_max.unwrap();
        assert!((far - 2.0 / 38f64.sqrt()).abs() < 1e-9, "{far}");
        assert_eq!(figures.uncovered.len(), 1);
        assert!((figures.uncovered[0].distance - far).abs() < 1e-9 && figures.uncovered[0].area > 0.2);
        assert!((figures.volume_ratio.unwrap() - 4.0 / 6.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_far_passes_where_that_is_allowed() {
        let far = HexOptions { allow_far: true, ..HexOptions::default() };
        let (verdict, result) = judged([4, 1, 1], [6, 1, 1], &far);
        assert!(verdict.is_ok() && result.warnings.len() == 2, "{:?}", result.warnings);
        let wide = HexOptions { max_distance: Some(2.5), ..HexOptions::default() };
        let (verdict, result) = judged([4, 1, 1], [6, 1, 1], &wide);
        assert!(verdict.is_ok() && result.figures.uncovered.is_empty());
        let (verdict, result) = judged([4, 1, 1], [4, 1, 1], &HexOptions::default());
        assert!(verdict.is_ok() && result.warnings.is_empty(), "{:?}", result.warnings);
    }
}
