//! Cells that lie where others are, and places that no cell covers.

use crate::context::Context;
use crate::error::Result;
use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::split_quad;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Queries between two looks at the clock.
pub const QUERIES_PER_CHECK: usize = 1024;

/// A cell lies where others are if the boundary winds around its centre more often than this: between one and two times.
pub const TWICE: f64 = 1.5;

/// A part of the surface that is farther from the cells than the limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Uncovered {
    /// Its farthest place.
    pub at: [f64; 3],
    /// The distance there, as a share of the diagonal.
    pub distance: f64,
    /// Its share of the surface's area.
    pub area: f64,
}

/// The cells that lie where others are, ascending; `quads` are the boundary faces.
pub fn overlapping(points: &[DVec3], hexes: &[[u32; 8]], quads: &[[u32; 4]], context: &Context) -> Result<Vec<u32>> {
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&q| split_quad(points, q)).collect();
    let winding = WindingTree::new(&TriangleTree::new(points, &triangles));
    let is_twice = |h: &[u32; 8]| {
        let centre = h.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 8.0;
        winding.number(centre) > TWICE
    };
    let of_chunk = |(k, cells): (usize, &[[u32; 8]])| {
        context.check()?;
        let numbered = ((k * QUERIES_PER_CHECK) as u32..).zip(cells);
        Ok(numbered.filter(|(_, h)| is_twice(h)).map(|(id, _)| id).collect())
    };
    let found: Result<Vec<Vec<u32>>> = hexes.par_chunks(QUERIES_PER_CHECK).enumerate().map(of_chunk).collect();
    Ok(found?.concat())
}
