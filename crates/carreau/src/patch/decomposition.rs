//! The room itself: candidates, then grids on them by one of the strategies.

use super::cad::{QuadCell, QuadPolygon};
use super::grid::{Grid, Patch};
use super::growth::{self, Grower};
use super::options::{Dissection, PatchOptions, Strategy};
use super::pairing::{self, Preference};
use super::polygon::{Cell, Polygon};
use super::quality::Candidates;
use super::rectangles::{self, CornerRule};
use super::result::{PatchResult, PolygonLayout};
use super::statistics::Figures;
use super::validate::validate;
use super::zones::{self, Quads};
use super::{creases, dissection, merge, positions};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{CornerId, FaceId, SurfaceMesh, Triangles, VertexId};
use rustc_hash::FxHashSet;

/// Decomposes a triangle mesh into quad patches. Every result has passed [`validate`].
///
/// ```
/// use carreau::{Context, patch, sample};
/// let context = Context::new();
/// let mesh = sample::make("cube-cylinders", None, &context)?;
/// let result = patch::decompose(&mesh, &patch::PatchOptions::default(), &context)?;
/// assert!(result.figures.coverage > 0.95);
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Options`] for options out of range, [`Error::Input`] for a
/// mesh without faces or with polygons, [`Error::Cancelled`],
/// [`Error::Deadline`].
pub fn decompose(mesh: &SurfaceMesh, options: &PatchOptions, context: &Context) -> Result<PatchResult> {
    options.validate()?;
    let Some(triangles) = Triangles::of(mesh) else {
        return Err(Error::input("the mesh has faces with more than three corners", "", "triangulate it first"));
    };
    if triangles.is_empty() {
        return Err(Error::input("the mesh has no faces", "", "patches need triangles"));
    }
    let candidates = {
        let _stage = context.stage("quality");
        Candidates::new(triangles, &options.filters(), creases::barriers(mesh, options)?, context)?
    };
    // Where rows of triangles may not be added, be it in growing or in absorbing what is left.
    let walls = match options.strategy {
        Strategy::Grow => creases::creases(mesh, options.crease_angle, &candidates.barrier)?,
        _ => candidates.barrier.clone(),
    };
    let min_cells = options.min_cells as usize;
    let (mut patches, polygons) = match options.strategy {
        Strategy::Grow => {
            let mut grower = Grower::new(&candidates, &walls);
            (growth::cover(&mut grower, options.probes(triangles.len()), min_cells, context)?, None)
        }
        _ => {
            let (patches, polygons) = by_polygons(&candidates, options, context)?;
            (patches, Some(polygons))
        }
    };
    if options.merge {
        patches = merge::merge_and_absorb(patches, &candidates, &walls, min_cells, context)?;
    }
    let mut result = finish(mesh, patches, &candidates.barrier, options, context)?;
    result.polygons = polygons;
    Ok(result)
}

/// Quads first, then polygons of quads, then rectangles: the paper's way.
pub fn by_polygons(
    candidates: &Candidates,
    options: &PatchOptions,
    context: &Context,
) -> Result<(Vec<Patch>, PolygonLayout)> {
    let quads = match options.strategy {
        Strategy::Matching => pairing::match_pairs(candidates, Preference::Quality, context)?,
        Strategy::MatchingCardinality => pairing::match_pairs(candidates, Preference::Cardinality, context)?,
        Strategy::Zones | Strategy::Grow => zones::grow_zones(candidates, context)?,
    };
    let (polygons, turns) = positions::lay_out(candidates, &quads, options.policy, context)?;
    let patches = dissect(candidates, &quads, &polygons, &turns, options, context)?;
    Ok((patches, polygon_layout(candidates, &quads, &polygons, &turns, options.min_cells as usize)))
}

/// The polygons with the mesh vertices of their cells.
pub fn polygon_layout(
    candidates: &Candidates,
    quads: &Quads,
    polygons: &[Polygon],
    turns: &[u32],
    min_cells: usize,
) -> PolygonLayout {
    let mut free = vec![true; candidates.triangles.len()];
    let mut cell = |cell: &Cell| {
        let (corners, pair) = quad_corners(candidates, quads.diagonal[cell.quad as usize], turns[cell.quad as usize]);
        pair.iter().for_each(|t| free[t.index()] = false);
        QuadCell { row: cell.row, col: cell.col, corners, next: cell.next }
    };
    let large = polygons.iter().filter(|p| p.cells.len() >= min_cells);
    let polygons = large.map(|p| QuadPolygon { cells: p.cells.iter().map(&mut cell).collect() }).collect();
    let leftover = (0..free.len()).filter(|&t| free[t]).map(FaceId::new).collect();
    PolygonLayout { polygons, leftover }
}

/// Cuts polygons into rectangles and rectangles out of the mesh.
pub fn dissect(
    candidates: &Candidates,
    quads: &Quads,
    polygons: &[Polygon],
    turns: &[u32],
    options: &PatchOptions,
    context: &Context,
) -> Result<Vec<Patch>> {
    let _stage = context.stage("dissection");
    let mut patches = Vec::new();
    for (k, polygon) in polygons.iter().enumerate() {
        context.check_every(k)?;
        let rectangles = match options.dissection {
            Dissection::Greedy => rectangles::greedy(polygon, CornerRule::AnyWidth, context)?,
            Dissection::LongestRow => rectangles::greedy(polygon, CornerRule::LongestRow, context)?,
            Dissection::Minimum => dissection::minimum(polygon, context)?,
        };
        patches.extend(rectangles.iter().map(|rectangle| {
            let mut grid = Grid::new(rectangle.rows, rectangle.cols);
            let places = (0..rectangle.rows).flat_map(|r| (0..rectangle.cols).map(move |c| (r, c)));
            for ((r, c), cell) in places.zip(polygon.cells_of(rectangle)) {
                let quad = polygon.cells[cell as usize].quad as usize;
                let (corners, pair) = quad_corners(candidates, quads.diagonal[quad], turns[quad]);
                grid.set(r, c, corners, pair);
            }
            grid.finish()
        }));
    }
    Ok(patches)
}

/// Corners of a quad from the bottom left, for its turn, and its two triangles.
pub fn quad_corners(candidates: &Candidates, h: u32, turn: u32) -> ([VertexId; 4], [FaceId; 2]) {
    let (t, o) = (candidates.triangles, candidates.triangles.opposite(h));
    let own = [h, t.previous(o), o, t.previous(h)].map(|c| VertexId(t.vertex(c)));
    (std::array::from_fn(|g| own[(g + 4 - turn as usize) % 4]), [FaceId(h / 3), FaceId(o / 3)])
}

/// Drops patches that are too small, sorts, checks and counts.
pub fn finish(
    mesh: &SurfaceMesh,
    mut patches: Vec<Patch>,
    barrier: &[bool],
    options: &PatchOptions,
    context: &Context,
) -> Result<PatchResult> {
    let _stage = context.stage("validation");
    context.check()?;
    patches.retain(|p| p.cells() >= options.min_cells as usize);
    // Largest first; equal ones in the order in which they were found, which does not depend on labels.
    patches.sort_by_key(|p| std::cmp::Reverse(p.cells()));
    let mut covered = vec![false; mesh.face_count()];
    patches.iter().flat_map(|p| &p.triangles).for_each(|t| covered[t.index()] = true);
    let leftover: Vec<FaceId> = (0..mesh.face_count()).filter(|&t| !covered[t]).map(FaceId::new).collect();
    let ends = |c: u32| [mesh.vertex(CornerId(c)), mesh.vertex(mesh.next(CornerId(c)))];
    let sorted = |[a, b]: [VertexId; 2]| (a.min(b), a.max(b));
    let barred: FxHashSet<_> =
        (0..).zip(barrier).filter(|(_, barred)| **barred).map(|(c, _)| sorted(ends(c))).collect();
    validate(mesh, &patches, &leftover, &options.promises(), |a, b| barred.contains(&sorted([a, b])))?;
    let figures = Figures::of(mesh, &patches);
    Ok(PatchResult { patches, leftover, polygons: None, figures })
}
