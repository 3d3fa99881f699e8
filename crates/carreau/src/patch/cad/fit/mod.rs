//! Bicubic surfaces near the patches instead of exact ones through every vertex: smaller files, smoother shapes.
//!
//! | file | stage |
//! |---|---|
//! | `curve` | every chain is fitted once; both its faces use the same curve |
//! | `side` | the curves of a side are joined, with knots of full multiplicity at nodes in between |
//! | `surface` | between given sides the inner control points are fitted and the knots refined |
//! | `stencil` | the equations of that, solved |
//! | `simple` | whether the border of a plane face stays clear of itself |
//!
//! A block in a plane is a plane face as long as its fitted border does not cross itself: it needs no control points and
//! asks nothing of its sides. Sides are never changed by a surface, so neighbours meet without gap or tolerance (C0), at T-nodes, too. A block whose
//! surface does not reach the tolerance, or would not be smaller than the exact one of degree (1, 1), stays exact. Its
//! border then is the polyline of its vertices, and that its neighbours have to follow: with kinks at every vertex. They
//! may in turn not be worth it any more; so exact blocks are settled first, by counting control points, then the rest is
//! fitted, and both is repeated until nothing changes. Every block becomes exact at most once, so this ends.

mod curve;
mod side;
mod simple;
mod stencil;
mod surface;

use super::chain::{ChainUse, Chains};
use super::piece::{Block, Piece, Source};
use super::scene::Scene;
use super::{Geometry, PatchFit, PieceSurface, Rung, exact};
use crate::brep::{Curve, Surface};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::bspline::BSplineCurve;
use curve::{ChainCurve, Shape};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use side::Frame;
use simple::is_simple;
use surface::{Fitted, Problem};

/// Vertices this near to a plane, as a share of the diagonal, lie in it: no farther than the file says itself.
const FLATNESS: f64 = 1e-9;
/// Points by which a spline is seen between two vertices.
const SAMPLES: u32 = 4;

/// Fitted curves and surfaces for all chains and pieces, and what every patch came to.
pub fn geometry(
    scene: &Scene,
    pieces: &[Piece],
    chains: &Chains,
    tolerance: f64,
    ctx: &Context,
) -> Result<(Geometry, Vec<PatchFit>)> {
    let mut ladder = Ladder::new(scene, pieces, chains, tolerance, ctx)?;
    ladder.settle_by_size((0..pieces.len() as u32).collect())?;
    let mut fitted: Vec<Option<Fitted>> = pieces.iter().map(|_| None).collect();
    loop {
        let open: Vec<u32> =
            (0..pieces.len() as u32).filter(|&k| ladder.spline[k as usize] && fitted[k as usize].is_none()).collect();
        if open.is_empty() {
            let crossed = ladder.crossed_planes();
            if crossed.is_empty() {
                break;
            }
            crossed.iter().for_each(|&k| ladder.planes[k as usize] = None);
            for k in ladder.make_exact(crossed)? {
                fitted[k as usize] = None;
            }
            continue;
        }
        let trials: Vec<Result<Option<Fitted>>> = ctx.install(|| open.par_iter().map(|&k| ladder.fit(k)).collect());
        let mut failed = Vec::new();
        for (&k, trial) in open.iter().zip(trials) {
            fitted[k as usize] = trial?;
            if fitted[k as usize].is_none() {
                failed.push(k);
            }
        }
        for k in ladder.make_exact(failed)? {
            fitted[k as usize] = None;
        }
    }
    ladder.result(fitted)
}

/// Which blocks are splines, and which chains therefore may be.
struct Ladder<'a> {
    scene: &'a Scene<'a>,
    pieces: &'a [Piece],
    chains: &'a Chains,
    tolerance: f64,
    ctx: &'a Context,
    /// The fitted curve of every chain.
    curves: Vec<ChainCurve>,
    /// Parameters of columns and rows of every block.
    scales: Vec<[Vec<f64>; 2]>,
    /// The planes of the blocks that lie in one.
    planes: Vec<Option<Surface>>,
    /// Whether a piece is to be fitted.
    spline: Vec<bool>,
}

impl<'a> Ladder<'a> {
    fn new(
        scene: &'a Scene,
        pieces: &'a [Piece],
        chains: &'a Chains,
        tolerance: f64,
        ctx: &'a Context,
    ) -> Result<Self> {
        let curves: Result<Vec<ChainCurve>> = ctx.install(|| {
            let fit = |path: &Vec<u32>| {
                ctx.check()?;
                ChainCurve::fit(&path.iter().map(|&v| scene.point(v)).collect::<Vec<_>>(), tolerance)
            };
            chains.paths.par_iter().map(fit).collect()
        });
        let scale = |piece: &Piece| match piece.source {
            Source::Block(b) => side::scale(scene, &b),
            _ => Default::default(),
        };
        let scales = pieces.iter().map(scale).collect();
        let flatness = FLATNESS * scene.mesh.diagonal();
        let plane = |piece: &Piece| match piece.source {
            Source::Block(b) => exact::plane_of_block(scene, b, flatness),
            _ => None,
        };
        let planes: Vec<Option<Surface>> = pieces.iter().map(plane).collect();
        let may_bend = |(p, plane): (&Piece, &Option<Surface>)| {
            plane.is_none() && matches!(p.source, Source::Block(b) if b.size != [1, 1])
        };
        let spline = pieces.iter().zip(&planes).map(may_bend).collect();
        Ok(Ladder { scene, pieces, chains, tolerance, ctx, curves: curves?, scales, planes, spline })
    }

    fn block(&self, piece: u32) -> Result<Block> {
        match self.pieces[piece as usize].source {
            Source::Block(b) => Ok(b),
            _ => Err(Error::Bug("only blocks are fitted".into())),
        }
    }

    /// Whether a piece is a block with a surface of degree (1, 1), or bicubic: no plane.
    fn is_curved_block(&self, piece: u32) -> bool {
        matches!(self.pieces[piece as usize].source, Source::Block(_)) && self.planes[piece as usize].is_none()
    }

    /// Whether an exact block has this chain on its border.
    fn is_exact(&self, chain: u32) -> bool {
        let (a, b) = self.chains.sides[chain as usize];
        let exact = |k: u32| self.is_curved_block(k) && !self.spline[k as usize];
        exact(a) || b.is_some_and(exact)
    }

    /// The curve of a chain as things stand.
    fn curve(&self, chain: u32) -> ChainCurve {
        if self.is_exact(chain) {
            let path = &self.chains.paths[chain as usize];
            return ChainCurve::exact(&path.iter().map(|&v| self.scene.point(v)).collect::<Vec<_>>());
        }
        self.curves[chain as usize].clone()
    }

    /// Plane faces whose borders, as they stand, cross or touch themselves.
    fn crossed_planes(&self) -> Vec<u32> {
        let crossed = |k: &u32| match self.planes[*k as usize] {
            Some(Surface::Plane { frame }) => {
                let (axis, across) = (frame.x, frame.y());
                let border = self.chains.loops[*k as usize].iter().flatten().flat_map(|of| self.samples(of));
                !is_simple(&border.map(|p| DVec2::new(p.dot(axis), p.dot(across))).collect::<Vec<_>>())
            }
            _ => false,
        };
        self.ctx.install(|| (0..self.pieces.len() as u32).into_par_iter().filter(crossed).collect())
    }

    /// Points of a chain as it is used, without the last one.
    fn samples(&self, of: &ChainUse) -> Vec<DVec3> {
        let path = &self.chains.paths[of.chain as usize];
        let curve = self.curve(of.chain);
        let mut points: Vec<DVec3> = match curve.shape {
            Shape::Polyline(stops) => stops.iter().map(|&k| self.scene.point(path[k as usize])).collect(),
            Shape::Spline(spline) => {
                let steps = (path.len() as u32 - 1) * SAMPLES;
                (0..=steps).map(|k| spline.point(f64::from(k) / f64::from(steps))).collect()
            }
        };
        if of.reversed {
            points.reverse();
        }
        points.pop();
        points
    }

    fn frame(&self, piece: u32) -> Result<Frame> {
        let uses = &self.chains.loops[piece as usize][0];
        let scale = &self.scales[piece as usize];
        Frame::new(self.scene, &self.block(piece)?, scale, uses, self.chains, &|chain| self.curve(chain))
    }

    fn fit(&self, piece: u32) -> Result<Option<Fitted>> {
        self.ctx.check()?;
        let frame = self.frame(piece)?;
        // Between sides that alone need that much, refinement may double it; see `settle_by_size`.
        let exact = self.exact_size(piece)?;
        let limit = if self.size(piece)? < exact { exact - 1 } else { 2 * exact };
        Problem::new(self.scene, &self.block(piece)?, &frame, self.tolerance, limit as usize).solve()
    }

    /// Number of vertices of a block: control points of its exact surface.
    fn exact_size(&self, piece: u32) -> Result<i64> {
        let [m, n] = self.block(piece)?.size;
        Ok((i64::from(m) + 1) * (i64::from(n) + 1))
    }

    /// Fewest control points of a surface between the sides as they stand, never more than the exact ones.
    fn size(&self, piece: u32) -> Result<i64> {
        let exact = self.exact_size(piece)?;
        if !self.spline[piece as usize] {
            return Ok(exact);
        }
        let knots = self.frame(piece)?.knots([false; 2])?;
        Ok(knots.map_or(i64::MAX / 4, |[u, v]| (u.count() * v.count()) as i64))
    }

    /// The blocks across the border of a block that are no planes, without repetition.
    fn neighbours(&self, piece: u32) -> Vec<u32> {
        let sides = self.chains.loops[piece as usize].iter().flatten().map(|of| self.chains.sides[of.chain as usize]);
        let mut out: Vec<u32> = sides.flat_map(|(a, b)| [Some(a), b]).flatten().filter(|&k| k != piece).collect();
        out.retain(|&k| self.is_curved_block(k));
        out.sort_unstable();
        out.dedup();
        out
    }

    /// Makes blocks exact where that saves control points, theirs and their neighbours' together. Returns the blocks
    /// whose sides have changed.
    fn settle_by_size(&mut self, mut open: Vec<u32>) -> Result<Vec<u32>> {
        open.sort_unstable();
        open.reverse();
        let mut waiting = vec![false; self.pieces.len()];
        open.iter().for_each(|&k| waiting[k as usize] = true);
        let mut changed = Vec::new();
        let mut steps = 0;
        while let Some(piece) = open.pop() {
            waiting[piece as usize] = false;
            steps += 1;
            self.ctx.check_every(steps)?;
            if !self.spline[piece as usize] {
                continue;
            }
            let exact = self.exact_size(piece)?;
            let gain = self.size(piece)? - exact;
            if gain < 0 {
                continue;
            }
            let around: Vec<u32> = self.neighbours(piece).into_iter().filter(|&k| self.spline[k as usize]).collect();
            let total = |ladder: &Self| around.iter().map(|&k| ladder.size(k)).sum::<Result<i64>>();
            let before = total(self)?;
            self.spline[piece as usize] = false;
            let loss = total(self)? - before;
            // A surface that is no smaller than the exact one is kept only for what it saves the neighbours.
            if loss > gain && gain < exact {
                self.spline[piece as usize] = true;
                continue;
            }
            changed.extend(&around);
            for k in around {
                if !std::mem::replace(&mut waiting[k as usize], true) {
                    open.push(k);
                }
            }
        }
        Ok(changed)
    }

    /// Makes blocks exact, and those that are then better exact, too. Returns the blocks whose sides have changed.
    fn make_exact(&mut self, failed: Vec<u32>) -> Result<Vec<u32>> {
        failed.iter().for_each(|&k| self.spline[k as usize] = false);
        let mut changed: Vec<u32> = failed.iter().flat_map(|&k| self.neighbours(k)).collect();
        changed.extend(self.settle_by_size(changed.clone())?);
        Ok(changed)
    }

    fn result(&self, fitted: Vec<Option<Fitted>>) -> Result<(Geometry, Vec<PatchFit>)> {
        let mut fits: Vec<PatchFit> = vec![PatchFit::default(); self.scene.patches.len()];
        let mut surfaces = Vec::with_capacity(self.pieces.len());
        for (k, (piece, fit)) in self.pieces.iter().zip(fitted).enumerate() {
            let block = match piece.source {
                Source::Block(b) => b,
                Source::Triangle(t) => {
                    surfaces.push(exact::triangle(self.scene, t));
                    continue;
                }
                Source::Polygon => return Err(Error::Bug("polygons are not fitted".into())),
            };
            let out = &mut fits[block.patch as usize];
            let of_chain = |chain: u32| if self.is_exact(chain) { 0.0 } else { self.curves[chain as usize].deviation };
            let border = self.chains.loops[k].iter().flatten().map(|of| of_chain(of.chain)).fold(0.0, f64::max);
            let (rung, surface) = match (fit, &self.planes[k]) {
                (_, Some(plane)) => {
                    out.deviation = out.deviation.max(border);
                    (Rung::Plane, PieceSurface { surface: plane.clone(), scale: None, trimmed: true })
                }
                (Some(fit), None) => {
                    out.deviation = out.deviation.max(fit.deviation).max(border);
                    out.control_points += fit.surface.points().len();
                    let scale = Some(self.scales[k].clone());
                    (Rung::Bicubic, PieceSurface { surface: Surface::Spline(fit.surface), scale, trimmed: false })
                }
                (None, None) => {
                    out.control_points += self.exact_size(k as u32)? as usize;
                    (Rung::Bilinear, exact::block(self.scene, block)?)
                }
            };
            out.rung = out.rung.min(rung);
            surfaces.push(surface);
        }
        let mut geometry = Geometry { curves: Vec::new(), stops: Vec::new(), surfaces };
        for (chain, path) in self.chains.paths.iter().enumerate() {
            let (curve, stops) = match self.curve(chain as u32).shape {
                Shape::Spline(c) => (Curve::Spline(c), None),
                Shape::Polyline(stops) if stops.len() == 2 => {
                    let [a, b] = [0, path.len() - 1].map(|k| self.scene.point(path[k]));
                    (Curve::segment(a, b).0, Some(stops))
                }
                Shape::Polyline(stops) => {
                    let points = stops.iter().map(|&k| self.scene.point(path[k as usize])).collect();
                    (Curve::Spline(BSplineCurve::polyline(points)?), Some(stops))
                }
            };
            geometry.curves.push(curve);
            geometry.stops.push(stops);
        }
        Ok((geometry, fits))
    }
}
