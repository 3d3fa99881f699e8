//! Which faces a model has: plane → bicubic → divided → cell → triangle.
//!
//! | rung | what becomes a face | file |
//! |---|---|---|
//! | plane | the cells and triangles of one flat region, with its holes | `flat`, `region` |
//! | bicubic | a curved patch, where all its borders may be curves and the surface keeps the tolerance | `fit` |
//! | divided | what is left of a patch, cut where it bends | `divide` |
//! | cell | a cell with bends on all sides | `divide` |
//! | triangle | a triangle in no patch and no flat region | – |
//!
//! Only the second rung has to be tried. A bicubic face needs curves for borders: against planes, which take any curve in
//! them, and against other bicubic faces. Cells and triangles have straight sides, so a face beside them falls, and those
//! beside it. What falls becomes planes and cells, which changes the other faces' borders at corners at most; so all is put
//! together anew until nothing falls. That ends, for nothing ever rises.

use super::chain::{self, Chains};
use super::crossed::crossed;
use super::fit::{self, Shape, Smooth};
use super::flat::Flats;
use super::labels::Labels;
use super::model::{Geometry, PieceSurface};
use super::piece::{self, Block, Flat, Piece, Source};
use super::region::Parts;
use super::runs::{Curves, beside};
use super::scene::Scene;
use super::{divide, exact};
use crate::brep::{Curve, Surface};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{FaceId, NONE, Triangles, VertexId};
use crate::patch::Patch;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Diagonals of cells sharper than this stay edges, by the cosine (30°).
const DIAGONAL_CREASE: f64 = 0.866;
/// Most times that all is put together; what still changes then falls.
const ROUNDS: usize = 12;

/// All pieces with their borders and geometry.
pub struct Built {
    pub pieces: Vec<Piece>,
    pub chains: Chains,
    pub geometry: Geometry,
    /// Largest distance of a vertex from its bicubic surface.
    pub deviation: f64,
}

/// What a cell of a patch is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cell {
    /// Both triangles in one flat region.
    Flat,
    /// A face by itself, or a part of one.
    Curved,
    /// Two triangles that meet at a crease, that are not alike, or whose bilinear surface would not weigh right.
    Split,
}

/// Everything about the mesh that does not change from round to round.
struct Ladder<'a, 'b> {
    scene: &'a Scene<'b>,
    flats: &'a Flats,
    labels: &'a Labels,
    /// Per patch, row by row.
    cells: Vec<Vec<Cell>>,
    /// Triangles that are no part of cells and of no flat region.
    alone: Vec<FaceId>,
    ctx: &'a Context,
}

/// The faces of all patches and leftover triangles. With a tolerance, curved patches become bicubic where they can.
pub fn build(
    scene: &Scene,
    flats: &mut Flats,
    labels: &Labels,
    tolerance: Option<f64>,
    ctx: &Context,
) -> Result<Built> {
    let cells = cells(scene, flats, labels);
    let halves = scene.patches.iter().zip(&cells).flat_map(|(p, cells)| {
        let split = (0..cells.len()).filter(|&k| cells[k] == Cell::Split);
        split.flat_map(|k| [p.triangles[2 * k], p.triangles[2 * k + 1]])
    });
    let alone = halves.chain(scene.leftover.iter().copied()).filter(|t| flats.of[t.index()] == NONE).collect();
    let ladder = Ladder { scene, flats, labels, cells, alone, ctx };
    let mut candidates = match tolerance {
        Some(_) => ladder.candidates(),
        None => Vec::new(),
    };
    let mut curves = Curves::default();
    for round in 0.. {
        ctx.check()?;
        if round == ROUNDS {
            candidates.clear();
        }
        let pieces = ladder.pieces(&candidates)?;
        let chains = chain::chains(&pieces, scene.points.len());
        let tolerance = tolerance.unwrap_or(0.0);
        let fallen = ladder.fallen(&pieces, &chains, candidates.len());
        if fallen.contains(&true) {
            let mut fallen = fallen.into_iter();
            candidates.retain(|_| !fallen.next().unwrap_or(false));
            continue;
        }
        // The first pieces are the candidates, in order. Curves that are new make the surfaces beside them new.
        for chain in curves.fit(scene, &pieces, &chains, candidates.len(), tolerance)? {
            for k in beside(&chains, chain, candidates.len()) {
                candidates[k].1 = None;
            }
        }
        let open: Vec<usize> = (0..candidates.len()).filter(|&k| candidates[k].1.is_none()).collect();
        if open.is_empty() {
            let crossed = crossed(scene, &pieces, &chains, &curves, candidates.len(), ctx);
            if crossed.contains(&true) {
                let mut crossed = crossed.into_iter();
                candidates.retain(|_| !crossed.next().unwrap_or(false));
                continue;
            }
            return ladder.finish(pieces, chains, candidates, &curves);
        }
        for (&k, trial) in open.iter().zip(ladder.trials(&candidates, &open, &chains, &curves, tolerance)) {
            candidates[k].1 = trial?;
        }
        candidates.retain(|(_, smooth)| smooth.is_some());
    }
    Err(Error::Bug("the faces of a model were never decided".into()))
}

/// What every cell is; triangles of curved cells leave their flat regions.
fn cells(scene: &Scene, flats: &mut Flats, labels: &Labels) -> Vec<Vec<Cell>> {
    let vector = |t: FaceId| {
        let [a, b, c] = scene.corners(t);
        (b - a).cross(c - a)
    };
    let cell = |w: &[FaceId]| {
        let [a, b] = [w[0], w[1]].map(|t| flats.of[t.index()]);
        let (x, y) = (vector(w[0]), vector(w[1]));
        match () {
            () if a != NONE && a == b => Cell::Flat,
            () if x.dot(y) < DIAGONAL_CREASE * x.length() * y.length() => Cell::Split,
            () if labels.kind(w[0].index()) != labels.kind(w[1].index()) => Cell::Split,
            () => Cell::Curved,
        }
    };
    let of_patch = |p: &Patch| -> Vec<Cell> {
        let cells = p.triangles.chunks_exact(2).map(cell).zip(p.cell_corners());
        let right = |(cell, corners): (Cell, [VertexId; 4])| match cell {
            Cell::Curved if !divide::cell_weighs_right(corners.map(|v| scene.point(v.0))) => Cell::Split,
            _ => cell,
        };
        cells.map(right).collect()
    };
    let out: Vec<Vec<Cell>> = scene.patches.iter().map(of_patch).collect();
    for (patch, cells) in scene.patches.iter().zip(&out) {
        let curved = (0..cells.len()).filter(|&k| cells[k] == Cell::Curved);
        flats.release(curved.flat_map(|k| [patch.triangles[2 * k], patch.triangles[2 * k + 1]]));
    }
    out
}

type Candidate = (Block, Option<Smooth>);

impl Ladder<'_, '_> {
    /// Blocks of patches, cut where they touch themselves, that lie in no single plane.
    fn candidates(&self) -> Vec<Candidate> {
        let region = |b: &Block, r: u32, c: u32| {
            let patch = &self.scene.patches[b.patch as usize];
            let [t, _] = patch.cell_triangles(b.from[0] + r, b.from[1] + c);
            self.flats.of[t.index()]
        };
        let curved = |b: &Block| {
            let first = region(b, 0, 0);
            let mut places = (0..b.size[0]).flat_map(|r| (0..b.size[1]).map(move |c| (r, c)));
            b.size != [1, 1] && (first == NONE || places.any(|(r, c)| region(b, r, c) != first))
        };
        let split = |b: &Block| self.places(b).any(|k| self.cells[b.patch as usize][k] == Cell::Split);
        let kind =
            |b: &Block, k: usize| self.labels.kind(self.scene.patches[b.patch as usize].triangles[2 * k].index());
        let alike = |b: &Block| {
            let mut kinds = self.places(b).map(|k| kind(b, k));
            kinds.next().is_none_or(|first| kinds.all(|k| k == first))
        };
        let blocks = piece::blocks(self.scene).into_iter();
        blocks
            .filter(|b| curved(b) && !split(b) && alike(b) && !divide::is_creased(self.scene, b))
            .map(|b| (b, None))
            .collect()
    }

    /// Numbers of the cells of a block in its patch.
    fn places(&self, b: &Block) -> impl Iterator<Item = usize> + use<> {
        let (columns, b) = (self.scene.patches[b.patch as usize].cols, *b);
        let row = move |r: u32| (0..b.size[1]).map(move |c| ((b.from[0] + r) * columns + b.from[1] + c) as usize);
        (0..b.size[0]).flat_map(row)
    }

    /// Bicubic surfaces for some of the candidates; none where one cannot be had.
    fn trials(
        &self,
        candidates: &[Candidate],
        open: &[usize],
        chains: &Chains,
        curves: &Curves,
        tolerance: f64,
    ) -> Vec<Result<Option<Smooth>>> {
        let fit = |&k: &usize| {
            self.ctx.check()?;
            fit::smooth(self.scene, candidates[k].0, k, chains, curves, tolerance)
        };
        self.ctx.install(|| open.par_iter().map(fit).collect())
    }

    /// Candidates, then planes, divided patches and triangles of the rest.
    fn pieces(&self, candidates: &[Candidate]) -> Result<Vec<Piece>> {
        let patches = self.scene.patches;
        let mut taken: Vec<Vec<bool>> = self.cells.iter().map(|c| vec![false; c.len()]).collect();
        let mut gone = vec![false; self.flats.of.len()];
        let mut curves = FxHashSet::default();
        let mut out: Vec<Piece> = Vec::new();
        for (block, _) in candidates {
            for k in self.places(block) {
                taken[block.patch as usize][k] = true;
                let triangles = &patches[block.patch as usize].triangles;
                [0, 1].into_iter().for_each(|j| gone[triangles[2 * k + j].index()] = true);
            }
            let piece = Piece::block(patches, *block);
            curves.extend(segments(&piece.loops[0].vertices));
            out.push(piece);
        }
        let mut alone = self.alone.clone();
        let mut planes = self.planes(&gone, &mut alone)?;
        self.mark_corners(&mut planes, &curves);
        out.extend(planes);
        let kind = |patch: usize, r: u32, c: u32| {
            let k = (r * patches[patch].cols + c) as usize;
            let curved = self.cells[patch][k] == Cell::Curved && !taken[patch][k];
            curved.then(|| self.labels.kind(patches[patch].triangles[2 * k].index()))
        };
        let divided: Vec<Result<Vec<Block>>> = self.ctx.install(|| {
            let divide = |k: usize| {
                self.ctx.check()?;
                divide::divide(self.scene, k as u32, &|r, c| kind(k, r, c))
            };
            (0..patches.len()).into_par_iter().map(divide).collect()
        });
        for blocks in divided {
            for block in blocks? {
                let mut piece = Piece::block(patches, block);
                // Straight sides from vertex to vertex: the neighbours have no kinks inside their edges either.
                piece.loops[0].corner.fill(true);
                out.push(piece);
            }
        }
        alone.sort_unstable();
        out.extend(alone.into_iter().map(|t| Piece::triangle(self.scene, t)));
        Ok(out)
    }

    /// The parts of flat regions; single triangles are `alone`.
    fn planes(&self, gone: &[bool], alone: &mut Vec<FaceId>) -> Result<Vec<Piece>> {
        let mut planes = Vec::new();
        let Some(triangles) = Triangles::of(self.scene.mesh) else { return Ok(planes) };
        let mut sets: Vec<Vec<u32>> = vec![Vec::new(); self.flats.normals.len()];
        let own = (0..).zip(&self.flats.of).filter(|(t, region)| **region != NONE && !gone[*t as usize]);
        own.for_each(|(t, &region)| sets[region as usize].push(t));
        let mut parts = Parts::new(triangles);
        for (k, (set, &normal)) in sets.into_iter().zip(&self.flats.normals).enumerate() {
            self.ctx.check_every(k)?;
            for part in parts.cut(set, normal) {
                match part.triangles[..] {
                    [t] => alone.push(FaceId(t)),
                    _ => {
                        let cells = part.triangles.iter().map(|&t| triangles.triangle(t)).map(|[a, b, c]| [a, b, c, c]);
                        let cells = cells.collect();
                        planes.push(Piece {
                            source: Source::Flat(Flat { normal, first: part.triangles[0] }),
                            cells,
                            loops: part.loops,
                        });
                    }
                }
            }
        }
        Ok(planes)
    }

    /// Marks where the borders of planes turn, but for those that are curves of bicubic faces.
    fn mark_corners(&self, planes: &mut [Piece], curves: &FxHashSet<[u32; 2]>) {
        let flatness = self.flats.flatness;
        for outline in planes.iter_mut().flat_map(|p| &mut p.loops) {
            let n = outline.vertices.len();
            let point = |k: usize| self.scene.point(outline.vertices[k % n]);
            let turns = |a: usize, k: usize| distance(point(k), point(a), point(k + 1)) > flatness;
            let Some(first) = (0..n).find(|&k| turns(k + n - 1, k)) else {
                outline.corner.fill(true);
                continue;
            };
            let mut corner = vec![false; n];
            let mut last = first;
            corner[first] = true;
            for k in first + 1..first + n {
                if turns(last, k) {
                    corner[k % n] = true;
                    last = k;
                }
            }
            if corner.iter().filter(|c| **c).count() < 3 {
                corner.fill(true);
            }
            let on_curve: Vec<bool> = segments(&outline.vertices).map(|s| curves.contains(&s)).collect();
            (0..n).for_each(|k| corner[k] &= !(on_curve[k] && on_curve[(k + n - 1) % n]));
            outline.corner = corner;
        }
    }

    /// Candidates with a border that has to be straight from vertex to vertex, and those beside such.
    fn fallen(&self, pieces: &[Piece], chains: &Chains, candidates: usize) -> Vec<bool> {
        let mut fallen = vec![false; candidates];
        let mut open = Vec::new();
        let mut beside: Vec<Vec<u32>> = vec![Vec::new(); candidates];
        for (path, &(a, b)) in chains.paths.iter().zip(&chains.sides) {
            let Some(b) = b else { continue };
            for (own, other) in [(a, b), (b, a)] {
                if own as usize >= candidates || path.len() == 2 {
                    continue;
                }
                if (other as usize) < candidates {
                    beside[own as usize].push(other);
                } else if !matches!(pieces[other as usize].source, Source::Flat(_)) {
                    open.push(own);
                }
            }
        }
        while let Some(k) = open.pop() {
            if !std::mem::replace(&mut fallen[k as usize], true) {
                open.extend(&beside[k as usize]);
            }
        }
        fallen
    }

    /// The geometry of the pieces as they stand.
    fn finish(&self, pieces: Vec<Piece>, chains: Chains, candidates: Vec<Candidate>, curves: &Curves) -> Result<Built> {
        let scene = self.scene;
        let mut deviation: f64 = 0.0;
        let mut surfaces = Vec::with_capacity(pieces.len());
        let mut smooth = candidates.into_iter();
        for piece in &pieces {
            surfaces.push(match (smooth.next(), piece.source) {
                (Some((_, Some(fit))), _) => {
                    deviation = deviation.max(fit.deviation);
                    // With its border in the parameter plane, whose knots tell readers how closely to integrate.
                    PieceSurface { surface: Surface::Spline(fit.surface), border: Some(fit.border), trimmed: true }
                }
                (_, Source::Flat(flat)) => exact::plane_of_flat(scene, piece, flat.normal),
                (_, Source::Block(block)) => exact::block_by_length(scene, block)?,
                (_, Source::Triangle(t)) => exact::triangle(scene, t),
                (_, Source::Polygon) => return Err(Error::Bug("a polygon is on no rung".into())),
            });
        }
        let mut geometry = Geometry { curves: Vec::new(), stops: Vec::new(), surfaces };
        for path in &chains.paths {
            let last = path.len() as u32 - 1;
            let (curve, stops) = match curves.of(path).shape {
                Shape::Spline(c) => (Curve::Spline(c), None),
                _ => (exact::segment(scene, path), Some(vec![0, last])),
            };
            geometry.curves.push(curve);
            geometry.stops.push(stops);
        }
        Ok(Built { pieces, chains, geometry, deviation })
    }
}

/// The sides of a border, without sense.
fn segments(vertices: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..vertices.len()).map(|k| [vertices[k], vertices[(k + 1) % vertices.len()]]).map(|[a, b]| [a.min(b), a.max(b)])
}

/// Distance of a point from the segment a b.
fn distance(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let scale = along.length_squared();
    let t = if scale > 0.0 { ((p - a).dot(along) / scale).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + t * along)
}
