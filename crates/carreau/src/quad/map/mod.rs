//! Quads by global parametrisation: a seamless map of the frame field, whose flat metric is decimated to its cones and made whole.
//!
//! Protais and others (as in room `field`), section 3, make their meshes by global parametrisation in the manner of Campen,
//! Bommes, Kobbelt: *Quantized global parametrization*, 2015. Here whole numbers are chosen without a T-mesh: Coudert-Osmont,
//! Desobry, Heistermann, Bommes, Ray, Sokolov: *Quad mesh quantization without a T-mesh*, 2023. Both metrics are positive on the
//! same triangulation, so that quads are one-to-one on the surface by construction.
//!
//! | stage, in the order of the calls | file |
//! |---|---|
//! | working mesh at the size of the quads, with its field (rooms `remesh`, `field`) | `framed` |
//! | opposite singularities nearer than quads can show are cancelled | `cancel` |
//! | the surface is cut to a disc | `cut` |
//! | the seamless map: sparse symmetric solves, until no triangle is turned over | `seamless`, `untangle` |
//! | its flat metric, an intrinsic triangulation with signposts | `flat` |
//! | decimation to the cones | `decimate` |
//! | closed assignments and their parities; whole numbers; strips of cells where some are missing | `lattice`; `integers`; `strips` |
//! | quads of the integer triangles | `extract` |
//! | back to the surface | `locate` |
//! | whole vectors; constants | `cell`; `tuning` |

mod cancel;
mod cell;
mod cut;
mod decimate;
mod extract;
mod flat;
mod framed;
mod integers;
mod lattice;
mod locate;
mod seamless;
mod strips;
mod tuning;
mod untangle;

use super::coarse::{Coarse, Follow, coarse, field_of};
use super::curve::Curve;
use super::source::Source;
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use flat::Flat;
use framed::{Framed, next};
use integers::Curves;
use locate::Locator;
use seamless::Map;
use strips::Strips;
use tuning::{
    CANCELLED_DISTANCE, EVEN_GROWTH, FAILED_SIZES, LACKING_WEIGHT, LEAST_GROWTH, MAPPED_WITHIN, MORE_EDGES,
    MOST_CURVE_EDGES, MOST_MAPPED_QUADS, MOST_SIZES, QUADS_EACH_SINGULARITY, REFINED_STRETCH, SPARE_EDGES,
    STALLED_SIZES,
};

pub use tuning::{WORKING_EDGES, WORKING_SMALLEST};

/// What is wanted.
pub struct Wish {
    /// Length of the quads.
    pub length: f64,
    /// Their number; `None`: the length is what counts.
    pub quads: Option<usize>,
    /// Edges of the working mesh over those of the quads.
    pub working: f64,
    /// Smallest angle of features.
    pub feature_deg: f64,
}

/// A map that is flat, from which quads are made as often as others are wanted somewhere.
pub struct QuadMap {
    framed: Framed,
    map: Map,
    flat: Flat,
    /// The size that gave the number of quads.
    scale: f64,
    /// How much longer edges are to be at every vertex of the working mesh, in quads.
    stretch: Vec<f64>,
    /// What feature curves want.
    curves: Curves,
    /// The edges along every feature curve in the last quads.
    edges: Vec<i64>,
    /// The corners of the whole faces that the last quads came from, by quad.
    corners: Vec<[u32; 3]>,
}

/// The working mesh of a surface; or why there is none.
pub fn working_mesh(source: &Source, wish: &Wish, context: &Context) -> Result<std::result::Result<Coarse, String>> {
    if source.area / wish.length.powi(2) > MOST_MAPPED_QUADS {
        return Ok(Err("so many quads are too many for a map".into()));
    }
    let _stage = context.stage("working mesh");
    let edges = wish.working * wish.length;
    let found = coarse(source, edges, Follow::even(WORKING_SMALLEST), wish.feature_deg, context)?;
    Ok(found.ok_or("its features were not found again".into()))
}

impl QuadMap {
    /// The map of a surface by the field of its working mesh, in which the directions of curvature have a weight; or why there is
    /// none.
    pub fn new(
        source: &Source,
        coarse: &Coarse,
        curvature: f64,
        wish: &Wish,
        context: &Context,
    ) -> Result<std::result::Result<Self, String>> {
        let field = field_of(coarse, source, curvature, context)?;
        if !field.repaired.is_empty() {
            return Ok(Err("its working mesh is not sound".into()));
        }
        tracing::debug!(target: "carreau::quad", triangles = field.mesh.face_count(), singular = field.singularities(), "working mesh");
        if field.singularities() as f64 * QUADS_EACH_SINGULARITY > source.area / wish.length.powi(2) {
            return Ok(Err("the field has too many singularities for so few quads".into()));
        }
        match Framed::new(coarse, &field) {
            Ok(framed) => Self::of_frames(framed.led(&source.guidance), fewest(source), wish, context),
            Err(why) => Ok(Err(why)),
        }
    }

    fn of_frames(
        mut framed: Framed,
        fewest: Vec<usize>,
        wish: &Wish,
        context: &Context,
    ) -> Result<std::result::Result<Self, String>> {
        let _stage = context.stage("map");
        let cancelled = cancel::cancel(&mut framed, CANCELLED_DISTANCE * wish.length, context)?;
        let cut = match cut::cut(&framed) {
            Ok(cut) => cut,
            Err(why) => return Ok(Err(why)),
        };
        let map = match seamless::seamless(&framed, cut, wish.length, context)? {
            Ok(map) => map,
            Err(why) => return Ok(Err(why)),
        };
        let mut flat = Flat::new(&framed, &map);
        let left = decimate::decimate(&mut flat, &framed.is_kept, context)?;
        tracing::debug!(target: "carreau::quad", cancelled, left, faces = flat.faces().count(), "decimated");
        let area: f64 = flat.faces().map(|f| flat.area(f)).sum::<f64>() / 2.0;
        let scale = wish.quads.map_or(1.0, |n| (n as f64 / area).sqrt());
        let stretch = vec![1.0; framed.points.len()];
        let curves = Curves { factor: vec![1.0; fewest.len()], fewest };
        Ok(Ok(QuadMap { framed, map, flat, scale, stretch, curves, edges: Vec::new(), corners: Vec::new() }))
    }

    /// Quads before their vertices are moved, of the number that is wanted; or why there are none.
    pub fn quads(&mut self, wish: &Wish, context: &Context) -> Result<std::result::Result<Work, String>> {
        let Some(whole) = self.whole(wish, context)? else {
            return Ok(Err("a part of the map has no room for a cell".into()));
        };
        self.edges = whole.edges_of_curves(self.curves.fewest.len());
        let _stage = context.stage("quads");
        let locator = Locator::new(&self.framed, &self.map, self.scale);
        let (work, of) = match extract::extract(&whole, &self.framed, &locator, context)? {
            Ok(found) => found,
            Err(why) => return Ok(Err(why.into())),
        };
        self.corners = of.iter().map(|f| [0, 1, 2].map(|k| whole.side(3 * f + k).vertex)).collect();
        Ok(Ok(work))
    }

    /// The next quads are to be smaller where some of these are.
    pub fn refine(&mut self, quads: impl Iterator<Item = usize>) {
        let mut corners: Vec<u32> = quads.flat_map(|q| self.corners[q]).collect();
        corners.sort_unstable();
        corners.dedup();
        corners.into_iter().for_each(|v| self.stretch[v as usize] *= REFINED_STRETCH);
    }

    /// A feature curve is to have more edges in the next quads.
    pub fn lengthen(&mut self, curve: usize) {
        self.curves.fewest[curve] = self.curves.fewest[curve].max(self.edges[curve] as usize) + MORE_EDGES;
    }

    /// Whole numbers in the size that gives the number of quads that is wanted, with as many edges along features as these need.
    fn whole(&mut self, wish: &Wish, context: &Context) -> Result<Option<Flat>> {
        let _stage = context.stage("numbers");
        let mut scale = self.scale;
        let mut best: Option<((bool, f64), f64, Flat)> = None;
        let (mut failed, mut stalled) = (0, 0);
        let mut before: Option<[f64; 2]> = None;
        for _ in 0..MOST_SIZES {
            let mut tried = self.flat.clone();
            tried.sides.iter_mut().for_each(|side| side.vector *= scale);
            self.make_longer(&tried);
            let holds = integers::choose(&mut tried, &mut self.stretch, &self.curves, context)?;
            let missing = if holds { self.missing(&mut tried, context)? } else { 0 };
            let count = tried.faces().map(|f| tried.cells(f)).sum::<i64>() as f64 / 2.0;
            let ratio = wish.quads.map_or(1.0, |n| count / n as f64);
            if holds {
                tracing::debug!(target: "carreau::quad", scale, count, missing, "whole");
                let off = ratio.ln().abs();
                let lacking = LACKING_WEIGHT * missing as f64 / self.curves.fewest.iter().sum::<usize>().max(1) as f64;
                let cost = (missing > 0, off + lacking);
                let is_nearer = best.as_ref().is_none_or(|b| cost < b.0);
                if is_nearer {
                    best = Some((cost, scale, tried));
                }
                stalled = if is_nearer { 0 } else { stalled + 1 };
                if off < MAPPED_WITHIN && missing == 0 || stalled == STALLED_SIZES {
                    break;
                }
                let now = [scale.ln(), ratio.ln()];
                scale = (now[0] - now[1] / growth(before, now)).exp();
                before = Some(now);
            } else {
                tracing::debug!(target: "carreau::quad", scale, "not whole");
                // Another size, other numbers.
                scale *= 1.01;
                failed += 1;
                if failed == FAILED_SIZES {
                    break;
                }
            }
        }
        Ok(best.map(|(_, scale, whole)| {
            self.scale = scale;
            whole
        }))
    }

    /// Makes curves longer that would have fewer edges than they need.
    fn make_longer(&mut self, flat: &Flat) {
        let mut length = vec![0.0; self.curves.fewest.len()];
        for h in flat.on_curves() {
            let [a, b] = [h, next(h)].map(|h| self.stretch[flat.side(h).vertex as usize]);
            length[flat.side(h).curve as usize] += flat.side(h).vector.length() * (a * b).sqrt();
        }
        for (curve, (length, &fewest)) in length.into_iter().zip(&self.curves.fewest).enumerate() {
            let (wanted, factor) = (fewest as f64, &mut self.curves.factor[curve]);
            if fewest > 0 && length > 0.0 {
                *factor = factor.max((wanted + SPARE_EDGES) / length);
            }
        }
    }

    /// Gives curves the edges that they need, as far as that goes; returns how many they lack.
    fn missing(&mut self, whole: &mut Flat, context: &Context) -> Result<usize> {
        let goal = integers::goals(whole, &self.stretch, &self.curves);
        Strips::new(whole, goal, &self.curves.fewest).lengthen_curves(context)
    }
}

/// The power of the size with which the number of quads grows, from two sizes and numbers, by their logarithms: two where features
/// ask for nothing, less where they ask for most of them.
fn growth(before: Option<[f64; 2]>, now: [f64; 2]) -> f64 {
    let measured = before.map(|before| (now[1] - before[1]) / (now[0] - before[0]));
    measured.filter(|m| m.is_finite()).map_or(EVEN_GROWTH, |m| m.clamp(LEAST_GROWTH, EVEN_GROWTH))
}

/// The fewest edges that keep every curve of a surface; none where one does, or no number.
fn fewest(source: &Source) -> Vec<usize> {
    let of = |curve: &Curve| curve.fewest(source, MOST_CURVE_EDGES).filter(|&n| n > 1).unwrap_or(0);
    source.paths.iter().enumerate().map(|(k, curve)| if source.asks_for_edges(k) { of(curve) } else { 0 }).collect()
}

#[cfg(test)]
mod tests;
