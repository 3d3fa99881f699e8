//! Room 3: quad patches on the vertices of a triangle mesh.
//!
//! Bénière, Subsol, Gesquière, Le Breton, Puech: *Décomposition d'un maillage triangulaire 3D en carreaux
//! quadrangulés*, REFIG 5(1), 2011. Pairs of adjacent triangles become quads, quads become `m × n` grids; no vertex is
//! moved or added, and every grid line is a path of mesh edges. What fits no grid stays a triangle. The result is a
//! surface that CAD systems read as B-spline faces.
//!
//! | stage | file | paper |
//! |---|---|---|
//! | edges that limit patches | `creases` | §5 |
//! | which pairs are quads, and how good | `quality` | §3.1, equation 1 |
//! | which reflex quads fold too much | `fold` | – |
//! | zones of quads | `zones` | §3.2 |
//! | or: the optimal choice of quads | `pairing` | – |
//! | rows and columns, polygons with walls | `positions`, `polygon` | §3.3, figures 5–7 |
//! | rectangles, greedily or as few as possible | `rectangles`, `dissection` | §3.3, figures 8–9 |
//! | or: all of this at once | `growth` | §5 |
//! | merging of patches | `merge` | §5 |
//! | the check of every result | `validate` | – |
//! | CAD faces: exact, bicubic or trimmed | `cad/` | §4, §5 |
//! | figures | `statistics` | table 1 |
//!
//! Where this departs from the paper:
//! - Corner angles are sums of triangle angles. With angles in 0..π, as a quad's own angles are usually taken, Q could
//!   never exceed π/2 and the limit Q_max would do nothing.
//! - The default strategy, [`Strategy::Grow`], grows rectangles on the triangles instead of choosing quads first and
//!   cutting them into rectangles later: a quarter of the patches for the same coverage. `PatchOptions::paper()` gives
//!   the paper's pipeline.
//! - A polygon has walls as well as cells: quads may lie side by side in the layout without sharing a mesh edge, which
//!   the paper does not mention.

pub mod cad;
mod concave;
mod creases;
mod dissection;
mod fold;
mod grid;
mod growth;
mod merge;
mod output;
mod pairing;
mod polygon;
mod positions;
mod quality;
mod rectangles;
#[cfg(test)]
mod samples;
mod statistics;
#[cfg(test)]
mod tests;
mod validate;
mod zones;

use crate::bounds::angle;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::Creases;
use crate::mesh::{CornerId, FaceId, SurfaceMesh, Triangles, VertexId};
use cad::{QuadCell, QuadPolygon};
use grid::Grid;
use growth::Grower;
use pairing::Preference;
use quality::{Candidates, Filters};
use rectangles::CornerRule;
use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};
use zones::Quads;

pub use grid::Patch;
pub use output::quad_mesh;
pub use polygon::{Cell, Polygon};
pub use positions::Policy;
pub use quality::Quality;
pub use statistics::{Figures, coverage, patches_needed};
pub use validate::{Promises, validate};

/// How patches are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// Rectangles grown directly on the triangles: the fewest patches.
    #[default]
    Grow,
    /// The paper: greedy zones of quads, then rectangles in them.
    Zones,
    /// Quads by minimum-cost matching (best quads, few leftovers), then rectangles.
    Matching,
    /// Quads by maximum matching (fewest leftovers), then rectangles.
    MatchingCardinality,
}

/// How a rectilinear polygon is cut into rectangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dissection {
    /// Largest rectangle first, as in the paper: all rectangles from each corner are tried.
    Greedy,
    /// Largest rectangle first, where each corner is tried only with its longest row: figure 8 taken to the letter.
    LongestRow,
    /// As few rectangles as possible.
    #[default]
    Minimum,
}

/// Options of [`decompose`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PatchOptions {
    /// How patches are found.
    pub strategy: Strategy,
    /// How contradictions between rows and columns are resolved (not used by [`Strategy::Grow`]).
    pub policy: Policy,
    /// Smallest number of cells of a patch; smaller ones stay triangles. 1 keeps single quads.
    pub min_cells: u32,
    /// Q_max of equation 1 in degrees, 0..=180; from 135 on it rejects no shape. Large quads that fold over themselves are
    /// never accepted.
    pub q_max: f64,
    /// ε_φ: largest angle between the normals of the two triangles of a quad, in degrees.
    pub dihedral: f64,
    /// Accept a larger angle where the surrounding surface bends as much.
    pub adapt_dihedral: bool,
    /// Reject quads with a corner above 180°.
    pub convex_only: bool,
    /// Accept only quads whose bilinear surface has the area and volume that CAD programs will compute.
    pub faces: bool,
    /// How far such a surface may be off the two triangles of the quad; [`cad::decompose_for_faces`] decides.
    #[serde(skip)]
    pub off_mesh: Option<cad::OffLimit>,
    /// How candidate quads are ranked.
    pub quality: Quality,
    /// How polygons are cut into rectangles (not used by [`Strategy::Grow`]).
    pub dissection: Dissection,
    /// Join patches along complete common sides.
    pub merge: bool,
    /// How many rectangles [`Strategy::Grow`] tries through each triangle: more take longer and give larger patches.
    /// Low 1, high 32; 0 tries every seed. By default 16, fewer on large meshes so that the time stays linear.
    pub probes: Option<u32>,
    /// Rectangles of [`Strategy::Grow`] end at creases: connected edges with more than this angle between the face
    /// normals, in degrees. Merging may join them across, along complete sides. 180: creases are nothing special.
    pub crease_angle: f64,
    /// Edges with more than this angle between the face normals, in degrees, are never crossed.
    pub feature_angle: Option<f64>,
    /// Whether every such edge is meant, or only creases at the size of 3,000 squares.
    pub creases: Creases,
    /// Edges that are never crossed, by their vertices.
    #[serde(skip)]
    pub feature_edges: Vec<[VertexId; 2]>,
    /// Edges tagged in the file are never crossed.
    pub tagged_edges: bool,
}

impl Default for PatchOptions {
    fn default() -> Self {
        PatchOptions {
            strategy: Strategy::default(),
            policy: Policy::default(),
            min_cells: 2,
            q_max: 90.0,
            dihedral: 30.0,
            adapt_dihedral: false,
            convex_only: false,
            faces: false,
            off_mesh: None,
            quality: Quality::default(),
            dissection: Dissection::default(),
            merge: true,
            probes: None,
            crease_angle: 40.0,
            feature_angle: None,
            creases: Creases::Every,
            feature_edges: Vec::new(),
            tagged_edges: true,
        }
    }
}

impl PatchOptions {
    /// The paper's pipeline: zones, greedy rectangles, no merging.
    pub fn paper() -> Self {
        PatchOptions {
            strategy: Strategy::Zones,
            dissection: Dissection::Greedy,
            merge: false,
            ..PatchOptions::default()
        }
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        angle("q-max", self.q_max)?;
        angle("dihedral", self.dihedral)?;
        angle("crease-angle", self.crease_angle)?;
        angle("feature-angle", self.feature_angle.unwrap_or(0.0))?;
        if self.min_cells == 0 {
            return Err(Error::Options("min-cells is 0, a patch has at least one cell".into()));
        }
        Ok(())
    }

    /// Probes per triangle. Rectangles grow with the mesh, and their triangles leave the cache: sixteen probes on every
    /// triangle are affordable up to some 200,000 triangles, and on a million one finds nearly as much.
    fn probes(&self, triangles: usize) -> u32 {
        match self.probes {
            None => (1_600_000 / triangles.max(1)).clamp(1, 16) as u32,
            Some(0) => u32::MAX,
            Some(n) => n,
        }
    }

    fn filters(&self) -> Filters {
        Filters {
            quality: self.quality,
            q_max: self.q_max.to_radians(),
            dihedral: self.dihedral.to_radians(),
            adapt_dihedral: self.adapt_dihedral,
            convex_only: self.convex_only,
            faces: self.faces,
            off_mesh: self.off_mesh,
        }
    }

    fn promises(&self) -> Promises {
        Promises {
            q_max: self.q_max.to_radians(),
            dihedral: if self.adapt_dihedral { f64::INFINITY } else { self.dihedral.to_radians() },
            convex_only: self.convex_only,
            min_cells: self.min_cells as usize,
        }
    }
}

/// A decomposition into patches.
#[derive(Debug, Clone)]
pub struct PatchResult {
    /// The patches, largest first.
    pub patches: Vec<Patch>,
    /// Triangles that belong to no patch, in order.
    pub leftover: Vec<FaceId>,
    /// The polygons that the patches were cut from, for trimmed surfaces; `None` for [`Strategy::Grow`], which has none.
    pub polygons: Option<PolygonLayout>,
    /// The figures of the layout.
    pub figures: Figures,
}

/// Rectilinear polygons of at least the smallest number of cells, and the triangles in none of them.
#[derive(Debug, Clone, Default)]
pub struct PolygonLayout {
    /// The polygons.
    pub polygons: Vec<QuadPolygon>,
    /// Triangles that belong to no polygon, in order.
    pub leftover: Vec<FaceId>,
}

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
fn by_polygons(
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
fn polygon_layout(
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
fn dissect(
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
fn quad_corners(candidates: &Candidates, h: u32, turn: u32) -> ([VertexId; 4], [FaceId; 2]) {
    let (t, o) = (candidates.triangles, candidates.triangles.opposite(h));
    let own = [h, t.previous(o), o, t.previous(h)].map(|c| VertexId(t.vertex(c)));
    (std::array::from_fn(|g| own[(g + 4 - turn as usize) % 4]), [FaceId(h / 3), FaceId(o / 3)])
}

/// Drops patches that are too small, sorts, checks and counts.
fn finish(
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
